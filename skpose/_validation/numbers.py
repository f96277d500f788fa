"""Checks of numeric arrays other than poses."""

from typing import Any

import numpy as np


def as_numbers(values: Any, name: str, masked: float = np.nan) -> np.ndarray:
    """A new float64 array of real numbers; masked values become NaN or another number."""
    if np.ma.isMaskedArray(values):
        values = np.ma.filled(values.astype(np.float64), masked)
    try:
        array = np.asarray(values)
        if array.dtype.kind in "biufO":  # numpy would take times and strings for numbers
            return np.array(array, dtype=np.float64)
    except (TypeError, ValueError):
        if hasattr(type(values), "frame_numbers"):  # a Motion says itself what to pass
            raise
    raise ValueError(f"{name} must be an array of real numbers, got {type(values).__name__}")
