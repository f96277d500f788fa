"""Checks of the arguments of motions."""

from numbers import Real
from typing import Any, TypeAlias

import numpy as np

MotionLike: TypeAlias = Any  # a `Motion`, whose class is in a package above this one


def is_motion(value: object) -> bool:
    """Whether a value is a `Motion`."""
    return hasattr(type(value), "root_axes") and hasattr(type(value), "frame_numbers")


def check_up(up: Any) -> str:
    """Refuse a value that is not an axis of the world."""
    if up not in ("x", "y", "z"):
        raise ValueError(f'up must be "x", "y" or "z", got {up!r}')
    return str(up)


def check_frame_rate(frame_rate: Any) -> float:
    """The frame rate as a float; refuse it unless positive and finite."""
    is_number = isinstance(frame_rate, Real) or (isinstance(frame_rate, np.ndarray) and frame_rate.ndim == 0)
    if isinstance(frame_rate, bool) or not is_number or not 0.0 < frame_rate < np.inf:
        raise ValueError(f"frame_rate must be a positive number of Hz, got {frame_rate!r}")
    return float(frame_rate)
