"""Checks of the arguments of motions: what is one, its frame rate, the axis that points up."""

from numbers import Real

import numpy as np


def is_motion(value: object) -> bool:
    """Return whether a value is a `Motion`, the one class that has axes of its root and numbers of its frames."""
    return hasattr(type(value), "root_axes") and hasattr(type(value), "frame_numbers")


def check_up(up: object) -> str:
    """Return an axis of the world that points up, or refuse what is none."""
    if up not in ("x", "y", "z"):
        raise ValueError(f'up must be "x", "y" or "z", the axis of the world that points up, got {up!r}')
    return str(up)


def check_frame_rate(frame_rate: object) -> float:
    """Return a rate as a number, or refuse it."""
    rate = np.nan
    if isinstance(frame_rate, Real) or (
        isinstance(frame_rate, np.ndarray) and frame_rate.ndim == 0 and frame_rate.dtype.kind in "iuf"
    ):
        rate = float(frame_rate)
    if not np.isfinite(rate) or rate <= 0 or isinstance(frame_rate, bool):
        raise ValueError(f"frame_rate must be a positive number of Hz, got {frame_rate!r}")
    return rate
