"""TRC files, positions of markers in time as text, of Motion Analysis and OpenSim.

Programs separate the cells by tabs, by blanks, by both, or by commas. Where there are tabs they separate, so that an
empty cell shifts no other and names may have blanks in them.
"""

import re
from typing import Literal

import numpy as np

from skpose.io._conventions import (
    Up,
    Zeros,
    agree,
    check_options,
    choose_rate,
    keypoints_of_markers,
    number_names,
    read_unit,
)
from skpose.io._source import NUMBER, WHOLE, Readable, Row, Source, open_source, read_cells
from skpose.keypoints import Keypoints

# Frame# and Time, with a unit as in "Time (s)" or, before a tab, "Time s".
COLUMNS = re.compile(
    r"\s*frame\s?#?\s+times?(?: *[(\[][^)\]\t]*[)\]]|[ /]+s(?:ec(?:onds?)?)?(?=\t))?(?=\s|$)", re.IGNORECASE
)
ORDER = re.compile(r"\s\((?!X/Y/Z)[XYZ]/[XYZ]/[XYZ]\)(?=\s|$)", re.IGNORECASE)  # of the axes, in the first line
AXES = re.compile(r"(?:\s*X\d*\s+Y\d*\s+Z\d*(?=\s|$))+\s*", re.IGNORECASE)

Line = tuple[int, str]  # and its number


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
        stand along another axis; or the axis of the floor, with a warning, as in `load_c3d`. If an axis points down,
        the world is turned by half a turn: about x for y and z, about y for x.
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
    if len(lines) < 4 or not lines[0][1].lower().startswith("pathfiletype"):
        raise source.error("expected a TRC file, which begins with PathFileType and three more lines", 1)
    title, keys, values = (text for _, text in lines[:3])
    if order := ORDER.search(title):
        source.warn(f"line 1 says {order[0].strip()}, but the three numbers of each marker are read as x, y and z")
    pairs = keys.split(), values.split()
    if len(pairs[0]) != len(pairs[1]):  # a value is missing
        pairs = keys.split("\t"), values.split("\t")
    stated = {key.strip().lower(): value.strip() for key, value in zip(*pairs, strict=False)}
    scale = read_unit(source, "Units", stated.get("units", ""), scale, 3)
    names, first = _read_names(source, lines, _count(source, stated, "NumMarkers"))
    rows = _read_rows(source, lines[first:], len(names))
    if trust == "header" and (n_frames := _count(source, stated, "NumFrames")) != len(rows):
        raise source.error(f"NumFrames: expected {n_frames} rows, found {len(rows)}; trust='rows' reads the rows", 3)
    rate = _rate(source, rows[:, 0], stated.get("datarate", ""), frame_rate)
    with source.format_errors():
        positions = rows[:, 1:].reshape(len(rows), len(names), 3)
        return keypoints_of_markers(source, positions, names, rate, scale, zeros, up, ("y", "as is usual"))


def _lines(source: Source) -> list[Line]:
    """The lines with their numbers; of those below the third, the ones that are not blank."""
    commas = source.head[:13].lower() == "pathfiletype,"
    texts = (text.rstrip("\r").replace(",", "\t") if commas else text.rstrip("\r") for text in source.lines)
    return [(line, text) for line, text in enumerate(texts, 1) if line <= 3 or text.strip()]


def _count(source: Source, stated: dict[str, str], key: str) -> int:
    word = stated.get(key.lower(), "")
    if not WHOLE.fullmatch(word):
        raise source.error(f"{key}: expected a whole number, found {word[:40]!r}", 3)
    return int(word)


def _read_names(source: Source, lines: list[Line], n_markers: int) -> tuple[list[str], int]:
    """The names of the markers that have columns, and the index of the first row."""
    line, text = lines[3]
    second, row = lines[4] if len(lines) > 4 else (line, "")
    columns = COLUMNS.match(text)
    if not columns:
        raise source.error("expected Frame#, Time and the markers' names", line)
    if has_axes := row != "" and not NUMBER.fullmatch(row.split()[0]):
        if not AXES.fullmatch(row):
            raise source.error("expected the columns X, Y, Z of each marker", second)
        n = len(row.split()) // 3
    else:
        n = (len(_cells(row.rstrip())) - 2) // 3 if row else n_markers
    rest = text[columns.end() :]
    words, cells = rest.split(), [cell.strip() for cell in rest.split("\t") if cell.strip()]
    cells = cells if "\t" in rest else words
    thirds = [cell.strip() for cell in rest.rstrip().split("\t")[1::3]]  # the first is empty, after the column Time
    numbered = [cell or str(i + 1) for i, cell in enumerate(thirds)] if [*filter(None, thirds)] == cells else []
    names = next((some for some in (cells, words, numbered, cells[:n_markers]) if len(some) == n), [])
    if not names:
        raise source.error(f"expected names and columns of {n_markers} markers, found {len(cells)} and {n}", line)
    if n != n_markers or n not in (len(cells), len(words)):
        source.warn(
            f"NumMarkers is {n_markers}, line {line} names {len(cells)} markers, and there are columns of {n}, which "
            "are read; markers without a name are called by their numbers"
        )
    return number_names(source, names), 4 + has_axes


def _cells(text: str) -> list[str]:
    """The cells of a row between tabs, or between blanks if several numbers are in one."""
    cells = text.split("\t")
    return text.split() if any(len(cell.split()) > 1 for cell in cells) else cells


def _read_rows(source: Source, lines: list[Line], n_markers: int) -> np.ndarray:
    """The columns but the first, Frame#, as an array (n_frames, 1 + 3 n_markers), NaN for lost markers."""
    width = 2 + 3 * n_markers
    n = next((i for i, (_, text) in enumerate(lines) if not "".join(text.split("\t", 2)[:2]).strip()), len(lines))
    if any("".join(text.split("\t", 2)[:2]).strip() for _, text in lines[n:]):
        raise source.error("expected a frame, found a row without Frame# and Time", lines[n][0])
    if n < len(lines):
        source.warn(f"{len(lines) - n} rows from line {lines[n][0]} on have no Frame# and Time and are left out")
    table = list[Row]()
    for line, text in lines[:n]:
        cells = text.split("\t")
        cells = [cell.strip() for cell in (cells if len(cells) >= width else _cells(text))]
        table.append((line, [*cells[:width], *filter(None, cells[width:])]))
    rows = read_cells(source, table, range(width), width)
    lost = np.isnan(rows[:, 2:]).reshape(n, n_markers, 3)
    faults = {
        "finite numbers": np.isinf(rows).any(axis=1) | np.isnan(rows[:, 1]),
        "3 coordinates of each marker or none": (lost.any(axis=2) & ~lost.all(axis=2)).any(axis=1),
        "frames in their order, without gaps": np.diff(rows[:, 0], prepend=rows[:1, 0] - 1.0) != 1.0,
    }
    for expected, is_wrong in faults.items():
        if is_wrong.any():
            raise source.error(f"expected {expected}, found others", lines[int(is_wrong.argmax())][0])
    return rows[:, 1:]


def _rate(source: Source, times: np.ndarray, word: str, given: float | None) -> float:
    """The frame rate, Hz: `given`, or DataRate, which the column Time must not contradict, or by that column."""
    stated = float(word) if NUMBER.fullmatch(word) else np.nan
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        by_time = float((len(times) - 1) / (times[-1] - times[0])) if len(times) > 1 else np.nan
        if given is not None:
            is_by_time = agree(given, by_time) or not 0.0 < stated < np.inf
            return choose_rate(source, given, by_time if is_by_time else stated, "the file")
        rate = stated
        if stated == 0.0 and 0.0 < by_time < np.inf:
            source.warn(f"DataRate is 0: {by_time:g} Hz is the rate of the column Time; frame_rate= chooses another")
            rate = by_time
        if not 0.0 < rate < np.inf:
            raise source.error(f"DataRate: expected a positive number, found {word[:40]!r}: pass frame_rate=", 3)
        frames = np.arange(len(times))  # times may be rounded, or up to 1 % faster or slower
        if not (np.abs((times - times[:1]) * rate - frames) <= 0.5 + 0.01 * frames).all():
            raise source.error(f"the column Time, with {by_time:.4g} Hz, contradicts {rate:g} Hz: pass frame_rate=")
    return rate
