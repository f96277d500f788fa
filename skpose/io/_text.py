"""What the readers share: a file's text, its numbers, and the error that names the line."""

import math
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

PathLike = str | os.PathLike


class MocapFormatError(ValueError):
    """A motion-capture file that does not say what its format asks for.

    Attributes
    ----------
    filename : str
        The file.
    line : int or None
        Where in it, counted from 1; None where no one line is at fault.
    """

    def __init__(self, filename: PathLike, line: int | None, message: str):
        self.filename, self.line, self.message = str(filename), line, message
        where = Path(filename).name + (f", line {line}" if line is not None else "")
        super().__init__(f"{where}: {message}")

    def __reduce__(self):
        return MocapFormatError, (self.filename, self.line, self.message)


def read_lines(path: PathLike, kind: str) -> list[str]:
    """Lines of a text file; a MocapFormatError if it is empty or no text at all."""
    data = Path(path).read_bytes()
    if b"\0" in data[:4096]:
        raise MocapFormatError(path, None, f"this is a binary file, not {kind}")
    # Names in these files may be in any encoding; numbers and keywords are ASCII.
    lines = data.decode("utf-8-sig", errors="replace").splitlines()
    if not any(line.strip() for line in lines):
        raise MocapFormatError(path, None, f"the file is empty, not {kind}")
    return lines


def number(token: str, path: PathLike, line: int, what: str) -> float:
    """One number; infinite ones are allowed, NaN is not."""
    try:
        value = float(token)
    except ValueError:
        raise MocapFormatError(path, line, f"{what}: expected a number, found {token!r}") from None
    if math.isnan(value):
        raise MocapFormatError(path, line, f"{what}: expected a number, found {token!r}")
    return value


def finite_number(token: str, path: PathLike, line: int, what: str) -> float:
    """One finite number."""
    value = number(token, path, line, what)
    if not math.isfinite(value):
        raise MocapFormatError(path, line, f"{what}: expected a finite number, found {token!r}")
    return value


def finite_numbers(tokens: Sequence[str], lines: Sequence[int], path: PathLike, what: str) -> np.ndarray:
    """Many numbers at once, each from the line of the same place in `lines`."""
    try:
        values = np.array(tokens, dtype=np.float64)
    except ValueError:
        values = np.array([np.nan])
    if not np.isfinite(values).all():
        for token, line in zip(tokens, lines, strict=True):
            finite_number(token, path, line, what)
    return values
