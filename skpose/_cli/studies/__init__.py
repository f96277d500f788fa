"""The studies of `skpose compare` and `skpose reproduce`."""
