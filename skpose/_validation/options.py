"""Checks of single options: one of some words, a number above zero, a whole number, an instance of a class."""

import sys
from numbers import Integral
from typing import Any

import numpy as np


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise ValueError unless an option has one of its values."""
    if value not in choices:
        raise ValueError(f"{name} must be {' or '.join(map(repr, choices))}, got {value!r}")


def check_positive(name: str, value: float) -> None:
    """Raise ValueError unless an option is a finite number above zero."""
    if not (np.isreal(value) and np.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be a positive number, got {value!r}")


def check_kind(value: object, expected: type, name: str, remedy: str) -> None:
    """Refuse a value of another class than the expected one."""
    if not isinstance(value, expected):
        raise TypeError(f"{name} must be a {_public_name(expected)}, got {type(value).__name__}: {remedy}")


def _public_name(kind: type) -> str:
    """Return where users import a class from: the top level, or its package."""
    package = kind.__module__.partition("._")[0]
    top = package.partition(".")[0]
    return f"{top if kind.__name__ in sys.modules[top].__all__ else package}.{kind.__name__}"


def check_integer(value: Any, least: int, name: str) -> None:
    """Refuse what is not a whole number of at least so many."""
    if not isinstance(value, Integral) or value < least:
        raise ValueError(f"{name} must be a whole number of at least {least}, got {value!r}")
