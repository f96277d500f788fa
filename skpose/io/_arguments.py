"""Types and checks of the arguments that readers and writers share."""

import os
from typing import IO

import numpy as np

PathLike = str | os.PathLike
Readable = PathLike | IO


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    """Raise ValueError unless an option has one of its values."""
    if value not in choices:
        raise ValueError(f"{name} must be {' or '.join(map(repr, choices))}, got {value!r}")


def check_positive(name: str, value: float) -> None:
    """Raise ValueError unless an option is a finite number above zero."""
    if not (np.isreal(value) and np.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be a positive number, got {value!r}")
