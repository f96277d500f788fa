"""A score as a number that knows what it is."""

from collections.abc import Mapping
from typing import Any

import numpy as np


class Score(float):
    """A number with its unit, the options that it was computed with, and how much it is the mean of.

    It is a `float` in every computation.

    Parameters
    ----------
    value : float
        The number.
    signature : str
        What was computed.
    n_counted : int
        How many points, angles, rotations or series were counted.
    n_missing : int
        How many were left out.

    Attributes
    ----------
    signature : str
        What was computed, which `pose_score` takes: name, unit, options. "PA-MPJPE|mm|scale".
    unit : str
        The unit: "mm", "%", "deg" and others; empty for a number without one.
    n_counted : int
        How many points (joints of frames), angles, rotations or series of the truth were counted. Those of samples
        without weight are not.
    n_missing : int
        How many were left out, because the truth is NaN there.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.metrics import mpjpe
    >>> true = np.array([[[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])  # a frame of two joints, m
    >>> error = mpjpe(true, true + [0.03, 0.04, 0.0])
    >>> error
    Score(50, 'MPJPE|mm', 2 counted)
    >>> print(f"{error:.1f} {error.unit}")
    50.0 mm
    """

    def __new__(cls, value: float, signature: str, n_counted: int, n_missing: int) -> "Score":
        score = super().__new__(cls, value)
        score.signature, score.n_counted, score.n_missing = signature, int(n_counted), int(n_missing)
        return score

    signature: str
    n_counted: int
    n_missing: int

    @property
    def unit(self) -> str:
        """The unit, the second part of the signature."""
        _, *rest = self.signature.split("|")
        return "" if not rest or "=" in rest[0] else rest[0]

    def __repr__(self) -> str:
        missing = f", {self.n_missing} missing" if self.n_missing else ""
        return f"Score({float(self):.6g}, {self.signature!r}, {self.n_counted} counted{missing})"

    def __str__(self) -> str:
        return float.__repr__(self)

    def __reduce__(self) -> tuple[type["Score"], tuple[float, str, int, int]]:
        return Score, (float(self), self.signature, self.n_counted, self.n_missing)


def signature_of(name: str, unit: str, options: Mapping[str, tuple[Any, Any]], words: tuple[str, ...] = ()) -> str:
    """Return the signature of a score: its name, its unit, words, and the options that are not as by default.

    Options are pairs of a value and the default value.
    """
    options = {key: (_plain(value), default) for key, (value, default) in options.items()}
    tokens = [f"{key}={_text(value)}" for key, (value, default) in options.items() if not _is_same(value, default)]
    return "|".join([name, *([unit] if unit else []), *words, *tokens])


def _plain(value: Any) -> Any:
    """Return a number of numpy as one of Python."""
    return value.item() if isinstance(value, np.generic) else value


def _is_same(value: Any, default: Any) -> bool:
    return value is default or (type(value) is type(default) and value == default)


def _text(value: Any) -> str:
    if isinstance(value, str | bool | None):
        return str(value)
    if isinstance(value, float | int):
        return number_text(value)
    return ",".join(str(one) for one in value)


def number_text(value: float) -> str:
    """Return a number in as few digits as give it back."""
    return str(int(value)) if float(value).is_integer() else repr(float(value))
