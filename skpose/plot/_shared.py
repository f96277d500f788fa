"""What the other packages of skpose use of `skpose.plot` beside its public names."""

from skpose.plot._axes import COLOURS

__all__ = [
    "COLOURS",
]
