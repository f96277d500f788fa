"""The numbers of a file's frames, read by numpy's parsers: each the nearest double, as by Python's float."""

import io
from contextlib import suppress
from itertools import islice

import numpy as np

from skpose.io._source import NUMBER, WORD, Source, Token, complaint

CHUNK = 1 << 18  # bytes that are read at once: enough for numpy's parser, and they fit the cache
# Kind of each character: a blank, a digit, a point, a sign, or (?) something else.
KINDS = b"?" * 9 + b" " * 5 + b"?" * 18 + b" " + b"?" * 10 + b"-?-.?" + b"0" * 10 + b"?" * 198  # by its code
OTHER = b"\x1c\x1d\x1e\x1f"  # blanks to numpy, but not in these files; nor is "_", Python's separator of digits


def read_numbers(source: Source, start: int, *, finite: bool) -> np.ndarray:
    """Read all numbers from a byte of the file on as float64 of shape (n,); line ends have no meaning.

    An error names the first word that is not a number, or not a finite one if all must be.
    """
    data, parts = source.data, list[np.ndarray]()
    while start < len(data):
        stop = data.find(b"\n", start + CHUNK) + 1 or len(data)
        numbers = parse(data[start:stop])
        words = WORD.finditer(data, start, stop)
        if numbers is None:
            token = next(token for token in map(Token, words) if not NUMBER.fullmatch(token))
            raise source.error(f"a frame: {complaint(token)}", token)
        if finite and not np.isfinite(numbers).all():
            token = Token(next(islice(words, int(np.argmin(np.isfinite(numbers))), None)))
            raise source.error(f"a frame: {complaint(token)}; on_nan='drop' leaves such frames out", token)
        parts.append(numbers)
        start = stop
    return np.concatenate(parts) if parts else np.empty(0)


def drop_not_finite(rows: np.ndarray, frames: np.ndarray, source: Source) -> tuple[np.ndarray, np.ndarray]:
    """Leave out the rows that hold a NaN or infinite number, and their frames; a warning counts them."""
    finite = np.isfinite(rows).all(axis=1)
    if finite.all():
        return rows, frames
    source.warn(
        f"{np.count_nonzero(~finite)} of {len(rows)} frames have a number that is NaN or infinite and are left out; "
        "the others keep their times"
    )
    return rows[finite], frames[finite]


def parse(text: bytes) -> np.ndarray | None:
    """The numbers; None if any word is not a number."""
    text = text.strip()
    if not text:
        return np.empty(0)
    # The rest is likely to be written in the same format as the first 1,000 characters.
    if parse_fixed(text[:1000].rpartition(b" ")[0] or text) is not None and (numbers := parse_fixed(text)) is not None:
        return numbers
    if b"_" in text or len(text) != len(text.translate(None, OTHER)):
        return None
    # The first is faster, but requires equally many numbers on each line.
    for read in (
        lambda: np.loadtxt(io.BytesIO(text).readlines(), comments=None, encoding="ascii", ndmin=1).ravel(),
        lambda: np.array(text.split(), dtype=np.float64),
    ):
        with suppress(ValueError):
            return read()
    return None


def parse_fixed(text: bytes) -> np.ndarray | None:
    """Numbers with equally many digits after the point, as most programs write them; None for any others.

    Without their points they are integers, which numpy reads three times as fast. A double holds integers below 2^53
    and powers of ten up to 10^22 exactly, so that one division gives the double that the digits stand for (W. D.
    Clinger, How to read floating point numbers accurately, 1990, DOI 10.1145/93542.93557). numpy's parser of integers
    accepts some words that are not integers, so every word is checked first.
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
