"""Names of `skpose.view` that the other packages of skpose use, in addition to the public ones."""

from skpose.view._strip import strip

__all__ = [
    "strip",
]
