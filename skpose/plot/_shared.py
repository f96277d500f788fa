"""Names of `skpose.plot` that the other packages of skpose use, in addition to the public ones."""

from skpose.plot._axes import COLOURS, SIDES

__all__ = [
    "COLOURS",
    "SIDES",
]
