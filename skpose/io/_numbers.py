"""The numbers of a file's frames, read by numpy's parsers: each the nearest double, as by Python's float."""

import sys
from collections.abc import Iterable
from itertools import islice

import numpy as np

from skpose.io._source import Chunk, Source
from skpose.io._words import NUMBER, complaint

# Kind of each character: a blank, a digit, a point, a sign, or (?) something else.
KINDS = bytearray(b"?" * 256)
for kind, characters in {b" ": b" \t\n\v\f\r", b"0": b"0123456789", b".": b".", b"-": b"+-"}.items():
    for character in characters:
        KINDS[character] = ord(kind)
OTHER = b"\x1c\x1d\x1e\x1f"  # blanks to numpy, as "_" is Python's separator of digits, but nothing of a number here


def read_numbers(
    source: Source,
    chunks: Iterable[Chunk],
    width: int,
    n_frames: int | None,
    *,
    finite: bool,
    counts: list[int] | None = None,
) -> np.ndarray:
    """Return all numbers of the chunks as float64 of shape (n,); line ends have no meaning.

    Memory is proportional to what has been read, not to the counts that the file states. An error names the first word
    that is no number, the first that is not finite if all must be, and the first past `n_frames` of `width` numbers.
    The count of words of each line is appended to `counts`.
    """
    numbers, n_read = np.empty(0), 0
    most = sys.maxsize if n_frames is None else n_frames * width
    chunks = iter(chunks)
    for chunk in chunks:
        parsed = parse(chunk)
        if parsed is None:
            token = next(word for word in chunk.words() if not NUMBER.fullmatch(word))
            raise source.error(f"a frame: {complaint(token)}", token)
        if n_frames is not None and n_read + len(parsed) > n_frames * width:
            token = next(islice(chunk.words(), n_frames * width - n_read, None))
            found = n_read + len(parsed) + sum(len(line.split()) for more in chunks for line in more.lines)
            raise source.error(
                f"expected the end of the file after {in_words(n_frames * width, width)}, found {str(token[:40])!r}: "
                f"there are {in_words(found, width)}; trust='rows' reads the whole frames that there are",
                token,
            )
        if finite and not np.isfinite(parsed).all():
            token = next(islice(chunk.words(), int(np.argmin(np.isfinite(parsed))), None))
            raise source.error(f"a frame: {complaint(token)}; on_nan='drop' leaves such frames out", token)
        if counts is not None:
            counts += [len(line.split()) for line in chunk.lines]
        if n_read + len(parsed) > len(numbers):  # twice as much each time; memory that is not written to costs nothing
            larger = np.empty(min(2 * (n_read + len(parsed)), most))
            larger[:n_read] = numbers[:n_read]
            numbers = larger
        numbers[n_read : n_read + len(parsed)] = parsed
        n_read += len(parsed)
    return numbers[:n_read]


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


def in_words(n: int, width: int) -> str:
    """Return in words how many frames n numbers are."""
    whole, left = divmod(n, width)
    frames = f"{whole} frame{'s' * (whole != 1)} of {width} numbers"
    return frames + (f" and {left} number{'s' * (left != 1)} more" if left else "")


def parse(chunk: Chunk) -> np.ndarray | None:
    """Return the numbers; None if any word is none."""
    text = chunk.text.strip()
    if not text:
        return np.empty(0)
    some = text[:1000].rpartition(b" ")[0] or text  # the rest is likely to be written in the same format
    if parse_fixed(some) is not None and (numbers := parse_fixed(text)) is not None:
        return numbers
    if b"_" in text or len(text) != len(text.translate(None, OTHER)):
        return None
    try:
        # Faster than splitting into words, but requires equally many numbers on each line.
        return np.loadtxt(chunk.lines, dtype=np.float64, comments=None, encoding="ascii", ndmin=1).ravel()
    except ValueError:
        pass
    try:
        return np.array(text.split(), dtype=np.float64)
    except ValueError:
        return None


def parse_fixed(text: bytes) -> np.ndarray | None:
    """Return numbers with equally many digits after the point, as most programs write them; None for any others.

    Without their points they are integers, which numpy reads three times as fast. A double holds integers below 2^53
    and powers of ten up to 10^22 exactly, so that one division gives the double that the digits stand for (W. D.
    Clinger, How to read floating point numbers accurately, 1990, DOI 10.1145/93542.93557). numpy's parser of integers
    accepts some words that are none, so every word is checked first.
    """
    n_digits = len(text.split(None, 1)[0].rpartition(b".")[2])
    kinds = (b" " + text + b" " * (n_digits + 1)).translate(KINDS)
    if not 1 <= n_digits <= 22 or b"?" in kinds:
        return None
    codes = np.frombuffer(kinds, np.uint8)
    blank, points = codes == ord(" "), np.flatnonzero(codes == ord("."))
    ends, n_words = points + n_digits + 1, np.count_nonzero(blank[:-1] > blank[1:])
    # A word ends n_digits characters after each point, before the next point. So no word has two points; as there are
    # as many words as points, each word has exactly one.
    if len(points) != n_words or not (blank[ends] & ~blank[ends - 1]).all() or (points[1:] <= ends[:-1]).any():
        return None
    if ((codes[1:] == ord("-")) & ~blank[:-1]).any():  # a sign that does not begin a word
        return None
    whole = np.fromstring(text.replace(b".", b""), np.int64, sep=" ")
    if whole.min() <= -(2**53) or whole.max() >= 2**53:
        return None
    numbers, zeros = whole / 10.0**n_digits, np.flatnonzero(whole == 0)
    starts = np.flatnonzero(blank[:-1] > blank[1:])[zeros]
    numbers[zeros[np.frombuffer(text, np.uint8)[starts] == ord("-")]] = -0.0  # integers have no such zero
    return numbers
