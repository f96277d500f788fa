"""TRC files, positions of markers in time as text, of Motion Analysis and OpenSim.

Programs separate the cells by tabs, by blanks, by both, or by commas. Where there are tabs they separate, so that an
empty cell shifts no other and names may have blanks in them.
"""

import re
from collections.abc import Iterator
from itertools import chain
from math import isfinite
from typing import Literal, NamedTuple

import numpy as np

from skpose._utils.units import complaint_of_extent
from skpose.io._arguments import Readable
from skpose.io._conventions import (
    Up,
    Zeros,
    check_options,
    choose_rate,
    differ,
    number_names,
    read_unit,
    stand_markers,
)
from skpose.io._source import NUMBER, WHOLE, Source, complaint, open_source
from skpose.keypoints import Keypoints

FRAME = r"\s*frame\s?#?"
COLUMNS = re.compile(rf"{FRAME}\s+times?(?: *[(\[][^)\]\t]*[)\]])?(?=\s|$)", re.IGNORECASE)  # "Time (s)", "Time[s]"
CELLS = re.compile(rf"{FRAME} *\t *time[^\t]*(?=\t)", re.IGNORECASE)  # "Time s" between tabs
ORDER = re.compile(r"\(([xyz])/([xyz])/([xyz])\)", re.IGNORECASE)  # in the first line
AXIS = re.compile(r"([XYZ])\d*", re.IGNORECASE)

Line = tuple[int, str]  # and its number


class Head(NamedTuple):
    """The numbers and names above the frames."""

    frame_rate: float | None  # Hz, by DataRate; None where that is 0, or is not needed and not a rate
    n_frames: int | None  # stated by the file; None if it does not matter
    scale: float  # metres of one unit
    names: list[str]  # of the markers that have columns


def load_trc(
    path: Readable,
    *,
    up: Up | None = None,
    scale: float | None = None,
    frame_rate: float | None = None,
    trust: Literal["header", "rows"] = "header",
    zeros: Zeros | None = None,
) -> Keypoints:
    """Read positions of markers from a TRC file, as OpenSim reads and writes them.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis that points up, which the format does not state. By default y, as in OpenSim, with a warning if people
        stand along another axis. If an axis points down, the world is turned by half a turn: about x for y and z, about
        y for x.
    scale : float, default=None
        Metres per unit of length. By default that of the file's Units.
    frame_rate : float, default=None
        Frames per second, Hz. By default the file's DataRate, which the column Time must not contradict; or, if that is
        0, the rate of that column, with a warning. A number replaces both, with a warning if it differs.
    trust : {"header", "rows"}, default="header"
        Refuse a file in which NumFrames is not the number of rows, or read the rows.
    zeros : {"seen", "missing"}, default=None
        Whether a position of exactly (0, 0, 0) is a position or a lost marker. By default a position, with a warning.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a marker is lost.

    Raises
    ------
    MocapFormatError
        If the file is damaged; with its name and line.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If the markers are not of the size of a person, positions are (0, 0, 0), people stand along another axis than y,
        names are missing, repeated or too many, the first line names another order of axes, or the rate is replaced.

    See Also
    --------
    load_c3d : Read a C3D file.
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    A marker is lost where its three cells are empty or NaN.

    References
    ----------
    .. [1] OpenSim documentation, "Marker (.trc) files",
       https://opensimconfluence.atlassian.net/wiki/spaces/OpenSim/pages/53089972.

    Examples
    --------
    >>> import io
    >>> from skpose.io import load_trc
    >>> text = (
    ...     "PathFileType\\t4\\t(X/Y/Z)\\tarm.trc\\n"
    ...     "DataRate\\tCameraRate\\tNumFrames\\tNumMarkers\\tUnits\\n"
    ...     "100\\t100\\t2\\t2\\tmm\\n"
    ...     "Frame#\\tTime\\tshoulder\\t\\t\\twrist\\t\\t\\n"
    ...     "\\t\\tX1\\tY1\\tZ1\\tX2\\tY2\\tZ2\\n"
    ...     "1\\t0.00\\t0\\t1400\\t0\\t0\\t900\\t0\\n"
    ...     "2\\t0.01\\t0\\t1400\\t0\\t\\t\\t\\n"
    ... )
    >>> markers = load_trc(io.StringIO(text))
    >>> markers
    Keypoints(2 frames at 100 Hz, 0.0 s, 2 points, 25.0 % not seen)
    >>> markers.positions[0, 1]
    array([0. , 0.9, 0. ])
    """
    check_options(trust=trust, up=up, zeros=zeros, scale=scale, frame_rate=frame_rate)
    source = open_source(path, "a TRC file")
    lines = _lines(source)
    head, first = _read_head(source, lines, frame_rate, scale, trust)
    rows = _read_rows(source, head, chain(first, lines))
    rate = _rate(source, rows[:, 0], head.frame_rate, frame_rate)
    with source.format_errors():
        positions = rows[:, 1:].reshape(len(rows), len(head.names), 3)
        usual: tuple[Up, str] = "y", "as is usual"
        positions, axis = stand_markers(source, positions, head.names, head.scale, zeros, up, usual)
        found = Keypoints(positions, head.names, rate, up=axis)
    source.warn(complaint_of_extent(found.positions, head.scale))
    return found


def _lines(source: Source) -> Iterator[Line]:
    commas = source.head[:13].lower() == "pathfiletype,"
    for line, text in enumerate(source.lines, 1):
        text = text.rstrip("\r")
        yield line, text.replace(",", "\t") if commas else text


def _read_head(
    source: Source, lines: Iterator[Line], frame_rate: float | None, scale: float | None, trust: str
) -> tuple[Head, list[Line]]:
    """The head, and the first row; what the arguments say need not be in the file."""
    _, title = next(lines)
    words = title.split()
    if not words or words[0].lower() != "pathfiletype":
        raise source.error("expected a TRC file, which begins with PathFileType", 1)
    _, keys = next(lines, (2, ""))
    _, values = next(lines, (3, ""))
    pairs = keys.split(), values.split()
    if len(pairs[0]) != len(pairs[1]):  # a value is missing
        pairs = keys.split("\t"), values.split("\t")
    stated = {key.strip().lower(): value.strip() for key, value in zip(*pairs, strict=False)}
    given = {"datarate": frame_rate, "units": scale, "numframes": None if trust == "header" else trust}
    for key in ("DataRate", "NumFrames", "NumMarkers", "Units"):
        if not stated.get(key.lower()) and given.get(key.lower()) is None:
            raise source.error(f"expected a value of {key} below the keys, found none", 3)
    n_markers = _count(source, stated["nummarkers"], "NumMarkers")
    n_frames = _count(source, stated["numframes"], "NumFrames") if trust == "header" else None
    scale = read_unit(source, "Units", stated.get("units", ""), scale, 3)
    rate, word = None, stated.get("datarate", "")
    is_number = NUMBER.fullmatch(word) is not None
    if not (is_number and float(word) == 0.0) and (frame_rate is None or (is_number and 0.0 < float(word) < np.inf)):
        rate = source.positive(word, "DataRate", 3)
    order = ORDER.fullmatch(words[2]) if len(words) > 2 else None
    if order and "".join(order.groups()).upper() != "XYZ":
        source.warn(f"line 1 says {words[2]}, but the three numbers of each marker are read as x, y and z")
    names, first = _read_names(source, lines, n_markers)
    return Head(rate, n_frames, scale, names), first


def _count(source: Source, word: str, key: str) -> int:
    if not WHOLE.fullmatch(word):
        raise source.error(f"{key}: expected a whole number, found {word[:40]!r}", 3)
    return int(word)


def _read_names(source: Source, lines: Iterator[Line], n_markers: int) -> tuple[list[str], list[Line]]:
    """The names of the markers that have columns, and the first row, if there is any."""
    line, text = next(lines, (4, ""))
    columns, cells = COLUMNS.match(text), CELLS.match(text)
    if cells and (not columns or len(text[cells.end() :].split()) == n_markers):
        columns = cells  # the cell of the time is what is between two tabs
    if not columns:
        raise source.error("expected Frame#, Time and the markers' names", line)
    rest = text[columns.end() :]
    names = [cell.strip() for cell in rest.split("\t") if cell.strip()] if "\t" in rest else rest.split()
    thirds = [cell.strip() for cell in rest.rstrip().split("\t")[1::3]]  # the first is empty, after the column Time
    row = next(((number, text) for number, text in lines if text.strip()), None)
    n: float = n_markers  # markers by the columns
    if row is not None and NUMBER.fullmatch(row[1].split()[0]):
        n = (len(_cells(row[1].rstrip())) - 2) / 3
    elif row is not None:
        axes = row[1].split()
        n = len(axes) / 3
        for i, cell in enumerate(axes):
            if not (match := AXIS.fullmatch(cell)) or match[1].upper() != "XYZ"[i % 3]:
                raise source.error(f"expected the columns X, Y, Z of each marker, found {cell[:40]!r}", row[0])
        row = next(((number, text) for number, text in lines if text.strip()), None)
    if len(names) != n and len(rest.split()) == n:
        names = rest.split()
    elif len(names) < n == len(thirds) and [cell for cell in thirds if cell] == names:
        source.warn(f"line {line} names {len(names)} of {len(thirds)} markers: the others are called by their numbers")
        names = [cell or str(i + 1) for i, cell in enumerate(thirds)]
    if len(names) > n == n_markers:
        source.warn(f"line {line} names {len(names)} markers, and there are columns of {n}: the last are left out")
        names = names[:n_markers]
    elif len(names) != n or not names:
        raise source.error(f"expected {n_markers} names of markers and as many columns, found {len(names)}", line)
    elif n != n_markers:
        source.warn(
            f"NumMarkers is {n_markers}, but there are names and columns of {len(names)} markers: they are read"
        )
    return number_names(source, names), [] if row is None else [row]


def _cells(text: str) -> list[str]:
    """The cells of a row between tabs, or between blanks if several numbers are in one."""
    cells = text.split("\t")
    return text.split() if any(len(cell.split()) > 1 for cell in cells) else cells


def _read_rows(source: Source, head: Head, lines: Iterator[Line]) -> np.ndarray:
    """The columns but the first, Frame#, as an array (n_frames, 1 + 3 n_markers), NaN for lost markers."""
    rows, frame, no_frames = list[np.ndarray](), None, list[int]()
    for line, text in lines:
        if not text.strip():
            continue  # at the end
        if head.n_frames in (None, len(rows)) and not "".join(text.split("\t", 2)[:2]).strip():
            no_frames.append(line)
            continue
        row = _numbers(source, text, line, head.names)
        if no_frames:
            raise source.error("expected a frame, found a row without Frame# and Time", no_frames[0])
        if frame is not None and row[0] != frame + 1:
            raise source.error(f"expected frame {frame + 1:.0f}, found {row[0]:g}", line)
        frame = row[0]
        rows.append(row[1:])
    if head.n_frames is not None and len(rows) != head.n_frames:
        raise source.error(
            f"NumFrames: expected {head.n_frames} rows, found {len(rows)}; trust='rows' reads the rows", 3
        )
    if no_frames:
        source.warn(f"{len(no_frames)} rows from line {no_frames[0]} on have no Frame# and Time and are left out")
    return np.array(rows) if rows else np.empty((0, 1 + 3 * len(head.names)))


def _numbers(source: Source, text: str, line: int, names: list[str]) -> np.ndarray:
    """The numbers of a row, NaN for empty cells."""
    cells, width = text.split("\t"), 2 + 3 * len(names)
    if len(cells) < width:
        cells = _cells(text)
    while len(cells) > width and not cells[-1].strip():
        cells.pop()
    if len(cells) != width:
        raise source.error(f"expected {width} cells, three for each marker, found {len(cells)}", line)
    try:
        row = np.array([float(cell) if cell and not cell.isspace() else np.nan for cell in cells])
    except ValueError:
        row = np.full(width, np.inf)
    if "_" in text or not text.isascii() or np.isinf(row).any() or np.isnan(row[:2]).any():
        for i, cell in enumerate(map(str.strip, cells)):
            is_lost = i > 1 and cell.lower() in ("", "nan")
            if not is_lost and not (NUMBER.fullmatch(cell) and isfinite(float(cell))):
                raise source.error(complaint(cell), line)
        raise source.error("expected numbers, found other characters between them", line)
    lost = np.isnan(row[2:]).reshape(-1, 3)
    partly = lost.any(axis=1) & ~lost.all(axis=1)
    if partly.any():
        raise source.error(f"expected 3 coordinates of {names[int(np.argmax(partly))]!r}, found fewer", line)
    return row


def _rate(source: Source, times: np.ndarray, stated: float | None, given: float | None) -> float:
    """The frame rate, Hz: `given`, or DataRate, which the column Time must not contradict, or by that column."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        by_time = float((len(times) - 1) / (times[-1] - times[0])) if len(times) > 1 else np.nan
    has_times = by_time > 0 and isfinite(by_time)
    if given is not None:
        if has_times and (stated is None or not differ(given, by_time)):
            return choose_rate(source, given, by_time, "the column Time")
        return given if stated is None else choose_rate(source, given, stated, "DataRate")
    rate = stated
    if rate is None:
        if not has_times:
            raise source.error("expected a rate by DataRate or by the column Time: pass frame_rate=", 3)
        source.warn(f"DataRate is 0: {by_time:g} Hz is the rate of the column Time; frame_rate= chooses another")
        rate = by_time
    frames = np.arange(len(times))
    with np.errstate(over="ignore", invalid="ignore"):
        # Rounded, or up to 1 % faster or slower.
        wrong = ~(np.abs((times - times[:1]) * rate - frames) <= 0.5 + 0.01 * frames)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise source.error(
            f"expected frame {k} after {k / rate:.6g} s at {rate:g} Hz, but Time says {times[k] - times[0]:.6g} s: "
            "pass frame_rate="
        )
    return rate
