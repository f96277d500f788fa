"""The frames of an AMC file: a line for the number of each, and one for the name and the numbers of each bone."""

from collections.abc import Iterator
from itertools import chain

import numpy as np

from skpose.io._source import Chunk, Source
from skpose.io._words import NUMBER, WHOLE, Token, complaint

Line = tuple[int, str]  # its number, and its text without a comment


class Layout:
    """Indices of a frame's numbers among its words; each frame is read with the layout of the previous one if it fits.

    Parameters
    ----------
    channels : dict of lists of str
        Names of the bones and of their channels, in the order of the numbers that `row` returns.
    source : Source
        The AMC file, for its errors.
    asf : str
        Name of the ASF file, for messages.
    fill : bool
        Whether the numbers of a bone that a frame does not mention are zero.
    keep_nan : bool
        Whether numbers may be NaN or infinite.
    """

    def __init__(self, channels: dict[str, list[str]], source: Source, asf: str, fill: bool, keep_nan: bool):
        self.channels, self.source, self.asf, self.fill, self.keep_nan = channels, source, asf, fill, keep_nan
        self.n_words = -1
        self.names: dict[int, str] = {}  # bones by the index of their name
        self.numbers: list[int] = []  # index of each number; -1 is a zero appended to the words

    def row(self, number: Token, frame: list[Line]) -> np.ndarray:
        """Return the numbers of a frame."""
        text = " ".join([text for _, text in frame])
        words = text.split()
        if len(words) != self.n_words or any(words[i] != name for i, name in self.names.items()):
            self._learn(number, frame)
        words.append("0")
        try:
            row = np.array([words[i] for i in self.numbers], dtype=np.float64)
            regular = "_" not in text and text.isascii() and np.isfinite(row).all()  # "1_0" is a number to Python
        except ValueError:
            self._learn(number, frame)  # an error if lines end elsewhere, so that a name is among the numbers
            regular = False
        if not regular:
            self._check(number, frame)
        return row

    def _learn(self, number: Token, frame: list[Line]) -> None:
        """Take the layout of this frame, if it is whole."""
        first: dict[str, int] = {}
        self.names, self.n_words = {}, 0
        for line, text in frame:
            name, *values = self.source.words(text, line)
            if name not in self.channels or name in first or len(values) != len(self.channels[name]):
                raise self.source.error(self._fault(name, values, number, name in first), name)
            self.names[self.n_words], first[name] = str(name), self.n_words + 1
            self.n_words += 1 + len(values)
        absent = [name for name in self.channels if name not in first]
        if absent and not self.fill:
            more = f" and {len(absent) - 5} more" if len(absent) > 5 else ""
            raise self.source.error(
                f"frame {number} ends without {', '.join(absent[:5])}{more}; is the file cut short? missing='rest' "
                "sets their angles to zero",
                frame[-1][0] if frame else number,
            )
        self.numbers = [
            first[name] + k if name in first else -1 for name, its in self.channels.items() for k in range(len(its))
        ]

    def _fault(self, name: Token, values: list[Token], number: Token, again: bool) -> str:
        """Return what is wrong with a line of a frame."""
        if name not in self.channels:
            return f"{self.asf} has no bone {str(name[:40])!r} with degrees of freedom; is it the right skeleton?"
        if again:
            return f"{str(name)!r} appears twice in frame {number}"
        expected = self.channels[name]
        return (
            f"{str(name)!r} has {len(values)} numbers, but {self.asf} gives it {len(expected)} ({' '.join(expected)}); "
            "is the line cut short, or the skeleton another?"
        )

    def _check(self, number: Token, frame: list[Line]) -> None:
        """Check every word of a frame; an error names the first that is not a number."""
        for line, text in frame:
            for token in self.source.words(text, line)[1:]:
                if not NUMBER.fullmatch(token):
                    raise self.source.error(f"frame {number}: {complaint(token)}", token)
                if not self.keep_nan and not np.isfinite(float(token)):
                    raise self.source.error(
                        f"frame {number}: {complaint(token)}; on_nan='drop' leaves such frames out", token
                    )


def read_frames(source: Source, layout: Layout, first: Chunk) -> np.ndarray:
    """Return the numbers of all frames, (n_frames, n_channels), from the line after the keywords on."""
    rows: list[np.ndarray] = []
    last: int | None = None
    for number, frame in _frames(source, _lines(source, first)):
        if last is not None and int(number) != last + 1:
            raise source.error(f"expected frame {last + 1}, found frame {number}", number)
        last = int(number)
        rows.append(layout.row(number, frame))
    if not rows:
        raise source.error("the file ends without a frame; not AMC, or cut short", source.line)
    return np.array(rows)


def _lines(source: Source, first: Chunk) -> Iterator[Line]:
    """Yield the lines that are not empty, without comments, from a first one on."""
    for line, _, text in chain((first,), source.chunks()):
        for n, one in enumerate(text.decode("utf-8", errors="replace").split("\n"), line):
            if "#" in one:
                one = one.partition("#")[0]
            if one and not one.isspace():
                yield n, one


def _frames(source: Source, lines: Iterator[Line]) -> Iterator[tuple[Token, list[Line]]]:
    """Yield the frames, each with its number and its lines."""
    number: Token | None = None
    frame: list[Line] = []
    for line, text in lines:
        if text.strip().isdecimal() and WHOLE.fullmatch(text.strip()):  # the first for speed, the second for ASCII
            if number is not None:
                yield number, frame
            number, frame = Token(text.strip(), line, 1), []
        elif number is None:
            raise source.error(f"expected a frame number, found {text.strip()[:40]!r}; not an AMC file?", line)
        else:
            frame.append((line, text))
    if number is not None:
        yield number, frame
