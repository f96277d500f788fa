"""The numbers of a file's frames, through numpy's parser."""

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np

from skpose.io._source import NUMBER, Source, Token, complaint


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
    blocks, n_read = [], 0
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
        n_read += len(block)
        blocks.append(block)
    return np.concatenate(blocks) if blocks else np.empty(0)


def _parse(lines: list[bytes]) -> np.ndarray | None:
    """The numbers of some lines; None if there is something else among them."""
    if not any(map(bytes.strip, lines)):
        return np.empty(0)
    try:
        # Faster than what follows, but only for as many numbers on each line.
        return np.loadtxt(lines, dtype=np.float64, comments=None, encoding="ascii", ndmin=1).ravel()
    except ValueError:
        text = b" ".join(lines)
    if b"_" in text:  # Python's digit separator
        return None
    try:
        return np.array(text.split(), dtype=np.float64)
    except ValueError:
        return None
