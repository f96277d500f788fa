"""Checks of single options."""

from numbers import Integral, Real
from typing import Any

import numpy as np


def check_choice(name: str, value: Any, choices: tuple[str, ...]) -> None:
    """Refuse a value that is not among the choices."""
    if value not in choices:
        raise ValueError(f"{name} must be {' or '.join(map(repr, choices))}, got {value!r}")


def check_positive(name: str, value: Any) -> None:
    """Refuse a value that is not a finite number above zero."""
    if not (isinstance(value, Real) and 0.0 < float(value) < np.inf):
        raise ValueError(f"{name} must be a positive number, got {value!r}")


def check_kind(value: object, expected: type, name: str, remedy: str) -> None:
    """Refuse an instance of another class."""
    if not isinstance(value, expected):
        raise TypeError(f"{name} must be a {expected.__name__}, got {type(value).__name__}: {remedy}")


def check_integer(value: Any, least: int, name: str) -> None:
    """Refuse a value that is not an integer of at least `least`."""
    if not isinstance(value, Integral) or value < least:
        raise ValueError(f"{name} must be an integer of at least {least}, got {value!r}")
