"""The head of a TRC file: keys and values, the names of the markers, and the line of axes below them.

Programs separate the cells by tabs, by blanks, by both, or by commas. Where there are tabs they separate, so that an
empty cell shifts no other and names may have blanks in them.
"""

import re
from collections.abc import Iterator
from math import isfinite
from typing import NamedTuple

from skpose.io._lengths import complaint_of_unit, is_angle, metres_of
from skpose.io._points import number_names
from skpose.io._source import Chunk, Source
from skpose.io._words import NUMBER, WHOLE, Token

COMMAS = "pathfiletype,"  # what a file begins with whose cells are separated by commas
FRAME = r"\s*frame\s?#?"
COLUMNS = re.compile(rf"{FRAME}\s+times?(?: *[(\[][^)\]\t]*[)\]])?(?=\s|$)", re.IGNORECASE)  # "Time (s)", "Time[s]"
CELLS = re.compile(rf"{FRAME} *\t *time[^\t]*(?=\t)", re.IGNORECASE)  # "Time s" between tabs
ORDER = re.compile(r"\(([xyz])/([xyz])/([xyz])\)", re.IGNORECASE)  # in the first line
AXIS = re.compile(r"([XYZ])\d*", re.IGNORECASE)
WORD = re.compile(r"\S+")
OPTIONS = {"datarate": "frame_rate", "units": "scale", "numframes": "trust"}  # what replaces a value of the head


class Head(NamedTuple):
    """The numbers and names above the frames."""

    frame_rate: float | None  # Hz, by DataRate; None where that is 0, or is not needed and is no rate
    n_frames: int | None  # that the file states; None where it is not requested
    claimed: Token | None  # the word of this number
    scale: float  # metres of one unit
    names: list[str]  # of the markers that have columns


Lines = Iterator[tuple[int, str]]


def lines_of(source: Source) -> Lines:
    """Yield the lines of the file with their numbers, their cells separated by tabs or by blanks."""
    commas = source.head[: len(COMMAS)].lower() == COMMAS
    for line, text in _lines(source.chunks()):
        text = text.rstrip("\r\n")
        yield line, text.replace(",", "\t") if commas else text


def _lines(chunks: Iterator[Chunk]) -> Lines:
    for chunk in chunks:
        # Names may be in any encoding; numbers and keywords are ASCII.
        yield from enumerate((line.decode("utf-8", errors="replace") for line in chunk.lines), start=chunk.line)


def read_head(
    source: Source, lines: Lines, frame_rate: float | None, scale: float | None, trust: str
) -> tuple[Head, tuple[int, str] | None]:
    """Return the head, and the first line that is not blank below it; None at the end of the file.

    `frame_rate`, `scale` and `trust="rows"` come before what the head says: then it need not say it.
    """
    line, text = next(lines, (1, ""))
    first = head_words(text, line)
    if not first or first[0].lower() != "pathfiletype":
        raise source.error("expected a TRC file, which begins with PathFileType", first[0] if first else line)
    given = {"datarate": frame_rate is not None, "units": scale is not None, "numframes": trust == "rows"}
    values = _read_values(source, lines, {key for key, is_given in given.items() if is_given})
    n_markers = _count(source, values["nummarkers"], "NumMarkers")
    claimed = None if trust == "rows" else values["numframes"]
    n_frames = None if claimed is None else _count(source, claimed, "NumFrames")
    unit = values.get("units", Token("", line, 1))  # where a scale is given it may be missing
    if is_angle(unit) or (scale is None and (scale := metres_of(unit)) is None):
        raise source.error(complaint_of_unit("Units", unit), unit)
    stated = values.get("datarate", Token("", line, 1))
    rate = None
    if not _is_zero(stated) and (frame_rate is None or _is_positive(stated)):
        rate = source.positive(stated, "DataRate")
    _warn_of_order(source, first)
    names, row = _read_names(source, lines, n_markers)
    return Head(rate, n_frames, claimed, scale, names), row


def _warn_of_order(source: Source, first: list[Token]) -> None:
    """Warn if the first line names another order of the axes than that of the columns."""
    order = ORDER.fullmatch(first[2]) if len(first) > 2 else None
    axes = "".join(order.groups()).upper() if order else "XYZ"
    if axes == "XYZ":
        return
    remedy = ""
    if len({*axes}) == 3:
        remedy = f"; if they are in that order, positions[..., {[axes.index(axis) for axis in 'XYZ']}] are x, y and z"
    source.warn(
        f"line {first[2].line} says {first[2]}, but the three numbers of each marker are read as x, y and z, as other "
        f"programs do{remedy}"
    )


def head_words(text: str, line: int) -> list[Token]:
    """Return the words of a line with their positions, and an empty one for each empty cell between tabs."""
    words, column = list[Token](), 1
    for cell in text.split("\t"):
        found = [Token(match[0], line, column + match.start()) for match in WORD.finditer(cell)]
        words += found or [Token("", line, column)]
        column += len(cell) + 1
    return words


def cells_of(text: str, line: int, column: int = 1) -> list[Token]:
    """Return the cells of a line between tabs with their positions, without blanks around them."""
    cells = []
    for cell in text.split("\t"):
        cells.append(Token(cell.strip(), line, column + len(cell) - len(cell.lstrip())))
        column += len(cell) + 1
    return cells


def _read_values(source: Source, lines: Lines, given: set[str]) -> dict[str, Token]:
    """Return the values of the third line by the keys of the second, in lower case."""
    first, keys = next(lines, (2, ""))
    second, values = next(lines, (first, ""))
    names, found = head_words(keys, first), head_words(values, second)
    not_empty = [name for name in names if name], [value for value in found if value]
    if len(not_empty[0]) == len(not_empty[1]):  # with any number of tabs between them
        names, found = not_empty
    by_key = {name.lower(): value for name, value in zip(names, found, strict=False)}
    for key in ("DataRate", "NumFrames", "NumMarkers", "Units"):
        if not by_key.get(key.lower()) and key.lower() not in given:
            option = OPTIONS.get(key.lower(), "")
            remedy = f"; {option}= says it otherwise" if option else ""
            raise source.error(f"expected a value of {key} below the keys of line {first}{remedy}", second)
    return by_key


def _count(source: Source, word: Token, key: str) -> int:
    if not WHOLE.fullmatch(word):
        raise source.error(f"{key}: expected a whole number, found {str(word[:40])!r}", word)
    return int(word)


def _is_zero(word: Token) -> bool:
    return NUMBER.fullmatch(word) is not None and float(word) == 0.0


def _is_positive(word: Token) -> bool:
    return NUMBER.fullmatch(word) is not None and float(word) > 0.0 and isfinite(1.0 / float(word))


def _read_names(source: Source, lines: Lines, n_markers: int) -> tuple[list[str], tuple[int, str] | None]:
    """Return the names of the markers that have columns, and the first line below that is not blank and not of axes."""
    line, text = next(lines, (4, ""))
    columns, cells = COLUMNS.match(text), CELLS.match(text)
    if cells and (not columns or len(_not_empty(text[cells.end() :], line, 1)) == n_markers):
        columns = cells  # the cell of the time is what is between two tabs
    if not columns:
        raise source.error("expected Frame#, Time and the markers' names", line)
    rest = text[columns.end() :]
    names = _not_empty(rest, line, columns.end() + 1)
    words = [Token(match[0], line, columns.end() + match.start() + 1) for match in WORD.finditer(rest)]
    with_gaps = _three_apart(rest, line, names)
    if "\t" not in rest or (len(names) != n_markers and len(words) == n_markers and len(with_gaps) != n_markers):
        names, with_gaps = words, []
    below = _next_row(lines)
    n_columns = None
    if below is not None and not NUMBER.fullmatch(next(iter(below[1].split()))):
        n_columns = _count_axes(source, *below, n_markers)
        below = _next_row(lines)
    elif below is not None:
        n_columns = len(head_words(below[1].rstrip(), below[0])) - 2
    n_columns = 3 * len(names) if n_columns is None else n_columns
    if len(names) < n_markers and n_columns == 3 * n_markers == 3 * len(with_gaps):
        names = _number_empty(source, with_gaps, line)
    if n_columns == 3 * n_markers < 3 * len(names):
        source.warn(
            f"line {line} names {len(names)} markers, but NumMarkers and the columns are those of {n_markers}: the "
            f"names from {str(names[n_markers])!r} on are left out"
        )
        names = names[:n_markers]
    elif n_columns != 3 * len(names):
        raise source.error(
            f"expected {n_markers} names of markers (NumMarkers), found {len(names)}, and {n_columns} columns of "
            "numbers",
            line,
        )
    elif len(names) != n_markers:
        source.warn(
            f"NumMarkers is {n_markers}, but there are names and columns of {len(names)} markers: they are read"
        )
    if not names:
        raise source.error("there are no markers", line)
    return number_names(source, [str(name) for name in names]), below


def _not_empty(text: str, line: int, column: int) -> list[Token]:
    return [cell for cell in cells_of(text, line, column) if cell]


def _three_apart(text: str, line: int, names: list[Token]) -> list[Token]:
    """Return every third cell up to the last name, empty where a marker has none; none if names are in other cells."""
    cells = cells_of(text.rstrip(), line)[1::3]  # the first is empty, after the column Time
    return cells if [cell for cell in cells if cell] == names else []


def _number_empty(source: Source, cells: list[Token], line: int) -> list[Token]:
    """Return the names of markers, the number of a marker in the place of each that is empty."""
    empty = [str(i + 1) for i, cell in enumerate(cells) if not cell]
    more = f" and {len(empty) - 5} more" if len(empty) > 5 else ""
    source.warn(
        f"line {line} has no name for {len(empty)} of {len(cells)} markers: they are called "
        f"{', '.join(map(repr, empty[:5]))}{more} here, by their numbers"
    )
    return [cell or Token(str(i + 1), line, 1) for i, cell in enumerate(cells)]


def _next_row(lines: Lines) -> tuple[int, str] | None:
    """Return the next line that is not blank."""
    return next(((line, text) for line, text in lines if text.strip()), None)


def _count_axes(source: Source, line: int, text: str, n_markers: int) -> int:
    """Return the number of columns X1, Y1, Z1 and so on."""
    axes = [cell for cell in head_words(text, line) if cell]
    if len(axes) % 3:
        raise source.error(f"expected {3 * n_markers} columns X1, Y1, Z1 and so on, found {len(axes)}", line)
    for i, cell in enumerate(axes):
        match = AXIS.fullmatch(cell)
        if not match or match[1].upper() != "XYZ"[i % 3]:
            raise source.error(f"expected the columns X, Y, Z of each marker, found {str(cell[:40])!r}", cell)
    return len(axes)
