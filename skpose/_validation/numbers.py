"""Checks of arrays of numbers that are no poses."""

from typing import Any

import numpy as np


def check_numbers(values: object, name: str) -> np.ndarray:
    """Return an argument that is no poses as float64; refuse what is not real numbers."""
    try:
        given = np.asarray(values)
        if given.dtype.kind not in "mMcSU":  # times of pandas are not seconds
            return given.astype(np.float64, copy=False)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name} must be an array of real numbers, got one that is not: {error}") from None
    raise ValueError(f"{name} must be an array of real numbers, got {given.dtype}")


def as_numbers(values: Any, name: str, masked: float = np.nan) -> np.ndarray:
    """Return a new float64 array of real numbers; those that a masked array masks are NaN, or another number."""
    if np.ma.isMaskedArray(values):
        values = np.ma.filled(values.astype(np.float64), masked)
    refused = ValueError(f"{name} must be an array of real numbers, got {type(values).__name__} of other values")
    try:
        array = np.asarray(values)
    except ValueError:  # rows of other lengths; a Motion says itself what to pass
        raise refused from None
    if array.dtype.kind not in "fiuO":
        raise refused
    try:
        return np.array(array, dtype=np.float64)
    except (TypeError, ValueError):
        raise refused from None
