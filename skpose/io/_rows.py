"""The frames of a BVH file: rows of equally many numbers, and the number of each frame."""

import numpy as np

from skpose.io._hierarchy import Lexer
from skpose.io._numbers import counted, read_numbers
from skpose.io._source import Source
from skpose.io._words import Token


def read_rows(lexer: Lexer, width: int, claimed: Token, trust: str, on_nan: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (n_frames, width) after the head of MOTION, and the numbers of these frames, from 0."""
    source = lexer.source
    if width == 0:
        raise source.error("no joint has CHANNELS, so nothing moves; is the file cut short?")
    n_frames, counts, finite = int(claimed), list[int](), on_nan == "raise"
    if trust == "rows":
        numbers = read_numbers(source, lexer.rest(), width, None, finite=finite, counts=counts)
    else:
        numbers = read_numbers(source, lexer.rest(), width, n_frames, finite=finite)
    frames = None
    if len(numbers) != n_frames * width:
        if trust == "header":
            raise source.error(
                f"expected {counted(n_frames * width, width)}, found {counted(len(numbers), width)}; is the file cut "
                "short? trust='rows' reads the whole frames that there are",
                claimed,
            )
        # The rest of the line of "Frame Time:", if there is any, is a line of its own.
        numbers, frames = _by_line(numbers, counts, source.line - len(counts) + 1, width, source)
    rows = numbers[: len(numbers) // width * width].reshape(-1, width)
    frames = np.arange(len(rows)) if frames is None else frames
    return (rows, frames) if finite else drop_not_finite(rows, frames, source)


def _by_line(
    numbers: np.ndarray, counts: list[int], first: int, width: int, source: Source
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the numbers of the lines that hold one frame, and which of all lines these are.

    Where such lines are not the majority, a line is no frame: all numbers and None.
    """
    lines = np.flatnonzero(counts)
    count = np.array(counts)[lines]
    whole = count == width
    if 2 * np.count_nonzero(whole) <= len(lines):
        if left := len(numbers) % width:
            source.warn(f"the last frame has {left} of {width} numbers and is left out")
        return numbers, None
    if not whole.all():
        at = int(np.argmin(whole))
        source.warn(
            f"{np.count_nonzero(~whole)} of {len(lines)} lines of numbers are left out, as they are not one frame: "
            f"line {first + lines[at]} has {count[at]} numbers, not {width}"
        )
    return numbers[np.repeat(whole, count)], np.flatnonzero(whole)


def drop_not_finite(rows: np.ndarray, frames: np.ndarray, source: Source) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows that hold no NaN and no infinite number, and their frames; a warning counts the others."""
    finite = np.isfinite(rows).all(axis=1)
    if finite.all():
        return rows, frames
    source.warn(
        f"{np.count_nonzero(~finite)} of {len(rows)} frames have a number that is NaN or infinite and are left out; "
        "the others keep their times"
    )
    return rows[finite], frames[finite]
