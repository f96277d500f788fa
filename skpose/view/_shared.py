"""What the other packages of skpose use of `skpose.view` beside its public names."""

from skpose.view._strip import strip

__all__ = [
    "strip",
]
