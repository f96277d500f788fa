"""Reader of TRC files, positions of markers in time as text, of Motion Analysis and OpenSim."""

import re
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from skpose._validation.motions import check_frame_rate, check_up
from skpose._validation.options import check_choice, check_positive
from skpose.io._arguments import Readable
from skpose.io._lengths import complaint_of_unit, metres_of
from skpose.io._source import Chunk, Source
from skpose.io._words import NUMBER, WHOLE, Token, complaint
from skpose.keypoints import Keypoints

REQUIRED = "DataRate", "NumFrames", "NumMarkers", "Units"
AXIS = re.compile(r"([XYZ])\d*", re.IGNORECASE)


class Head(NamedTuple):
    """The numbers and names above the frames."""

    frame_rate: float
    n_frames: int
    claimed: Token  # the number of frames in the file
    scale: float  # metres of one unit
    names: list[str]


def load_trc(
    path: Readable,
    *,
    up: Literal["x", "y", "z"] = "y",
    scale: float | None = None,
    frame_rate: float | None = None,
    trust: Literal["header", "rows"] = "header",
) -> Keypoints:
    """Read positions of markers from a TRC file, as OpenSim reads and writes them.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    up : {"x", "y", "z"}, default="y"
        The axis that points up, which the format does not state; OpenSim's is y.
    scale : float, default=None
        Metres per unit of length. None is the unit that the file names.
    frame_rate : float, default=None
        Frames per second. None is the file's DataRate, refused where the column Time contradicts it. With a number the
        column is not compared.
    trust : {"header", "rows"}, default="header"
        What to do where NumFrames is not the number of rows: refuse the file, or read the rows that there are.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a marker is lost.

    Raises
    ------
    MocapFormatError
        If the file does not follow its format; with its name, line and column.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If the markers are less than 0.3 or more than 5 m apart: the file may name the wrong unit.

    See Also
    --------
    load_c3d : Read a C3D file.
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    A marker is lost where its three cells are empty or NaN. Cells are separated by tabs alone, so that an empty cell
    shifts no other. One or two empty cells of three are refused, as are rows that are too short.

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
    check_choice("trust", trust, ("header", "rows"))
    check_up(up)
    if scale is not None:
        check_positive("scale", scale)
    if frame_rate is not None:
        check_frame_rate(frame_rate)
    with Source(path, "a TRC file") as source:
        head = _read_head(source, scale)
        rows = _read_rows(source, head, trust == "header")
        rate = head.frame_rate if frame_rate is None else frame_rate
        if frame_rate is None:
            _check_times(source, rows[:, 0], rate)
        with source.format_errors():
            found = Keypoints(rows[:, 1:].reshape(len(rows), len(head.names), 3) * head.scale, head.names, rate, up=up)
        source.warn_of_extent(found.positions, head.scale)
        return found


def _read_head(source: Source, scale: float | None) -> Head:
    first = _next_cells(source)
    if not first or first[0].lower() != "pathfiletype":
        at = first[0] if first else 1
        raise source.error("expected a TRC file, which begins with PathFileType", at)
    keys = _next_cells(source)
    values: dict[str, Token] = dict(zip(keys, _next_cells(source), strict=False))
    for key in REQUIRED:
        if not values.get(key):
            raise source.error(f"expected a value of {key} below the keys of line 2", source.line)
    claimed = {}
    for key in ("NumFrames", "NumMarkers"):
        if not WHOLE.fullmatch(values[key]):
            raise source.error(f"{key}: expected a whole number, found {str(values[key][:40])!r}", values[key])
        claimed[key] = int(values[key])
    unit = values["Units"]
    if scale is None and (scale := metres_of(unit)) is None:
        raise source.error(complaint_of_unit("Units", unit), unit)
    rate = source.positive(values["DataRate"], "DataRate")
    names = _read_names(source, claimed["NumMarkers"])
    return Head(rate, claimed["NumFrames"], values["NumFrames"], scale, names)


def _read_names(source: Source, n_markers: int) -> list[str]:
    """Return the markers' names, of the line of names and of the line of axes."""
    cells = _next_cells(source)
    if [str(cell).lower() for cell in cells[:2]] != ["frame#", "time"]:
        raise source.error("expected Frame#, Time and the markers' names, separated by tabs", source.line)
    names = [cell for cell in cells[2:] if cell]
    if len(names) != n_markers:
        raise source.error(f"expected {n_markers} names of markers (NumMarkers), found {len(names)}", source.line)
    if not names:
        raise source.error("there are no markers", source.line)
    first = dict[str, Token]()
    for name in names:
        if name in first:
            raise source.error(
                f"two markers are named {str(name)!r}, in columns {first[name].column} and {name.column}: rename one, "
                "as points are matched by name",
                name,
            )
        first[name] = name
    axes = [cell for cell in _next_cells(source) if cell]
    if len(axes) != 3 * n_markers:
        raise source.error(f"expected {3 * n_markers} columns X1, Y1, Z1 and so on, found {len(axes)}", source.line)
    for i, cell in enumerate(axes):
        match = AXIS.fullmatch(cell)
        if not match or match[1].upper() != "XYZ"[i % 3]:
            raise source.error(f"expected the columns X, Y, Z of each marker, found {str(cell[:40])!r}", cell)
    return [str(name) for name in names]


def _next_cells(source: Source) -> list[Token]:
    """Return the cells of the next line, without blanks around them; empty at the end of the file."""
    text = source.readline()
    return [] if text is None else _cells(text, source.line)


def _cells(text: str, line: int) -> list[Token]:
    """Return the cells of a line with their positions."""
    cells, column = [], 1
    for cell in text.rstrip("\r\n").split("\t"):
        cells.append(Token(cell.strip(), line, column + len(cell) - len(cell.lstrip())))
        column += len(cell) + 1
    return cells


def _read_rows(source: Source, head: Head, strict: bool) -> np.ndarray:
    """Return the columns but the first, Frame#, as an array (n_frames, 1 + 3 n_markers), NaN for lost markers."""
    rows, frame = list[np.ndarray](), None
    for line, text in _lines(source.chunks()):
        if not text.strip():
            continue  # one below the head, and at the end
        if strict and len(rows) == head.n_frames:
            raise source.error(
                f"expected the end of the file after {head.n_frames} rows (NumFrames); trust='rows' reads them all",
                line,
            )
        row = _numbers(source, text, line, head.names)
        if frame is not None and row[0] != frame + 1:
            raise source.error(
                f"expected frame {frame + 1:.0f}, found {row[0]:g}: frames are missing or out of order; a row of empty "
                "cells stands for a frame without markers",
                line,
            )
        frame = row[0]
        rows.append(row[1:])
    if strict and len(rows) != head.n_frames:
        raise source.error(
            f"NumFrames: expected {head.n_frames} rows, found {len(rows)}; is the file cut short? trust='rows' reads "
            "the rows that there are",
            head.claimed,
        )
    return np.array(rows) if rows else np.empty((0, 1 + 3 * len(head.names)))


def _lines(chunks: Iterator[Chunk]) -> Iterator[tuple[int, bytes]]:
    for chunk in chunks:
        yield from enumerate(chunk.lines, start=chunk.line)


def _numbers(source: Source, text: bytes, line: int, names: list[str]) -> np.ndarray:
    """Return the numbers of a row, NaN for empty cells."""
    cells, width = text.strip(b"\r\n").split(b"\t"), 2 + 3 * len(names)
    while len(cells) > width and not cells[-1].strip():
        cells.pop()
    if len(cells) != width:
        raise source.error(
            f"expected {width} cells separated by tabs, Frame#, Time and three for each of {len(names)} markers, found "
            f"{len(cells)}: the cells of a lost marker are empty, but not left out",
            line,
        )
    try:
        row = np.array([float(cell) if cell and not cell.isspace() else np.nan for cell in cells])
    except ValueError:
        row = None
    if row is None or b"_" in text or np.isinf(row).any() or np.isnan(row[:2]).any():
        tokens = _cells(text.decode("utf-8", errors="replace"), line)
        for i, token in enumerate(tokens):
            lost = i > 1 and (not token or token.lower() == "nan")
            if not lost and not (NUMBER.fullmatch(token) and np.isfinite(float(token))):
                what = ("Frame#", "Time")[i] if i < 2 else "a coordinate"
                raise source.error(f"{what}: {complaint(token)}", token)
        raise source.error("expected numbers, found other characters between them", line)
    lost = np.isnan(row[2:]).reshape(-1, 3)
    partly = lost.any(axis=1) & ~lost.all(axis=1)
    if partly.any():
        marker = int(np.argmax(partly))
        raise source.error(
            f"the marker {names[marker]!r} has {3 - lost[marker].sum()} of 3 coordinates: are the cells shifted?", line
        )
    return row


def _check_times(source: Source, times: np.ndarray, frame_rate: float) -> None:
    """Refuse times that are not those of the frame rate, rounded or up to 1 % faster or slower."""
    frames = np.arange(len(times))
    with np.errstate(over="ignore", invalid="ignore"):
        wrong = ~(np.abs((times - times[:1]) * frame_rate - frames) <= 0.5 + 0.01 * frames)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise source.error(
            f"DataRate is {frame_rate:g} Hz, so frame {k} after the first is {k / frame_rate:.6g} s after it, but Time "
            f"says {times[k] - times[0]:.6g} s: frame_rate= chooses the rate, without regard to Time"
        )
