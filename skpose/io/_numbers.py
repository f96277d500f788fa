"""The numbers of a file's frames, through numpy's parser."""

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np

from skpose.io._source import NUMBER, Source, Token, complaint

# What a character is: a blank, a digit, a point, a sign, or (?) something else.
KINDS = bytearray(b"?" * 256)
for kind, characters in {b" ": b" \t\n\v\f\r", b"0": b"0123456789", b".": b".", b"-": b"+-"}.items():
    for character in characters:
        KINDS[character] = ord(kind)


class Piece(NamedTuple):
    """Some lines of a file, and where the first of them begins."""

    line: int
    column: int
    lines: list[bytes]

    def words(self) -> Iterator[Token]:
        """The words with their places; slow, and so only for what is wrong."""
        for i, text in enumerate(self.lines):
            at = 0
            for word in text.split():
                at = text.index(word, at)
                column = at + 1 + (self.column if i == 0 else 0)
                yield Token(word.decode("utf-8", errors="replace"), self.line + i, column)
                at += len(word)


def read_numbers(source: Source, pieces: Iterable[Piece], limit: int | None, *, finite: bool) -> np.ndarray:
    """All numbers of the pieces, wherever the lines end; as float64, flat.

    What is allocated follows what has been read, never what the file says of itself. An error names the first word that
    is no number, the first that is not finite if all must be, and the first past the limit.
    """
    numbers, n_read = np.empty(0), 0
    for piece in pieces:
        block = _parse(piece.lines)
        if block is None:
            token = next(word for word in piece.words() if not NUMBER.fullmatch(word))
            raise source.error(f"a frame: {complaint(token)}", token)
        if limit is not None and n_read + len(block) > limit:
            token = next(islice(piece.words(), limit - n_read, None))
            raise source.error(f"expected the end of the file after its last frame, found {str(token[:40])!r}", token)
        if finite and not np.isfinite(block).all():
            token = next(islice(piece.words(), int(np.argmin(np.isfinite(block))), None))
            raise source.error(f"a frame: {complaint(token)}; on_nan='drop' leaves such frames out", token)
        if n_read + len(block) > len(numbers):  # twice as much each time; memory that is not written to costs nothing
            larger = np.empty(2 * (n_read + len(block)))
            larger[:n_read] = numbers[:n_read]
            numbers = larger
        numbers[n_read : n_read + len(block)] = block
        n_read += len(block)
    return numbers[:n_read]


def _parse(lines: list[bytes]) -> np.ndarray | None:
    """The numbers of some lines; None if there is something else among them."""
    text = b" ".join(lines).strip()
    if not text:
        return np.empty(0)
    some = text[:1000].rpartition(b" ")[0] or text  # what the rest will be like, most likely
    if _parse_fixed(some) is not None and (numbers := _parse_fixed(text)) is not None:
        return numbers
    try:
        # Faster than what follows, but only for as many numbers on each line.
        return np.loadtxt(lines, dtype=np.float64, comments=None, encoding="ascii", ndmin=1).ravel()
    except ValueError:
        if b"_" in text:  # Python's digit separator
            return None
    try:
        return np.array(text.split(), dtype=np.float64)
    except ValueError:
        return None


def _parse_fixed(text: bytes) -> np.ndarray | None:
    """Numbers with equally many digits after the point, as most programs write them; None if there is anything else.

    Without their points they are whole numbers, which numpy reads three times as fast. A double holds whole numbers
    below 2^53 and powers of ten up to 10^22 exactly, so that one division gives the double that the digits stand for
    (W. D. Clinger, How to read floating point numbers accurately, 1990, DOI 10.1145/93542.93557). numpy takes some
    words for whole numbers that are none, so it gets no others to see.
    """
    n_digits = len(text.split(None, 1)[0].rpartition(b".")[2])
    kinds = (b" " + text + b" " * (n_digits + 1)).translate(KINDS)
    if not 1 <= n_digits <= 22 or b"?" in kinds:
        return None
    kinds = np.frombuffer(kinds, np.uint8)
    blank, points = kinds == ord(" "), np.flatnonzero(kinds == ord("."))
    ends, n_words = points + n_digits + 1, np.count_nonzero(blank[:-1] > blank[1:])
    # So many characters after each point a word ends, and the next point comes later: no word has two points, so each
    # has one, if there are as many of both, and ends there.
    if len(points) != n_words or not (blank[ends] & ~blank[ends - 1]).all() or (points[1:] <= ends[:-1]).any():
        return None
    if ((kinds[1:] == ord("-")) & ~blank[:-1]).any():  # a sign that does not begin a word
        return None
    whole = np.fromstring(text.replace(b".", b""), np.int64, sep=" ")
    if whole.min() <= -(2**53) or whole.max() >= 2**53:
        return None
    return whole / 10.0**n_digits
