"""Names of `skpose.plot` that the other packages of skpose use, in addition to the public ones."""

from skpose.plot._axes import COLOURS, SIDES
from skpose.plot._volume import draw_volume

__all__ = [
    "COLOURS",
    "SIDES",
    "draw_volume",
]
