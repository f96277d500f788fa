"""Reader of TRC files, positions of markers in time as text, of Motion Analysis and OpenSim."""

from itertools import chain
from typing import Literal

import numpy as np

from skpose._validation.motions import check_frame_rate
from skpose._validation.options import check_choice, check_positive
from skpose.io._arguments import Readable
from skpose.io._points import Zeros, check_options, drop_origin, stand_points
from skpose.io._rates import choose_rate, differ
from skpose.io._source import Source
from skpose.io._trc_head import Head, Lines, cells_of, lines_of, read_head
from skpose.io._up import Up
from skpose.io._words import NUMBER, complaint
from skpose.keypoints import Keypoints


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
        The direction that points up, which the format does not state. None is OpenSim's, y, with a warning where
        markers of head and feet speak against it. Where an axis points down the world is turned by half a turn: about x
        if y or z points down, about y if x does.
    scale : float, default=None
        Metres per unit of length. None is the unit that the file names.
    frame_rate : float, default=None
        Frames per second, Hz. None is the file's DataRate, refused where the column Time contradicts it; where DataRate
        is 0, the rate of that column, with a warning. A number comes before both, with a warning where it is neither.
    trust : {"header", "rows"}, default="header"
        What to do where NumFrames is not the number of rows: refuse the file, or read the rows that there are.
    zeros : {"seen", "missing"}, default=None
        What a position of exactly (0, 0, 0) is: a position, or a lost marker, as some programs write it. None is
        "seen", with a warning where there are any.

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
        If the markers are less than 0.3 or more than 5 m apart: the file may name the wrong unit. If positions are
        (0, 0, 0). If people stand along another axis than y. If two markers have one name: they are numbered. If
        NumMarkers is not the number of names, and the number of columns says which is right. If markers have no names:
        they are called by their numbers. If the first line names another order of the axes than (X/Y/Z). If DataRate is
        0, or neither it nor Time is the frame rate that is given. If rows without Frame# and Time follow the last
        frame.

    See Also
    --------
    load_c3d : Read a C3D file.
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    A marker is lost where its three cells are empty or NaN. Where there are tabs they separate the cells, so that an
    empty cell shifts no other; a line without tabs is split at blanks, and one of a file that begins with
    ``PathFileType,`` at commas. One or two empty cells of three are refused, as are rows that are too short.

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
    check_options(up, zeros)
    if scale is not None:
        check_positive("scale", scale)
    if frame_rate is not None:
        check_frame_rate(frame_rate)
    with Source(path, "a TRC file") as source:
        lines = lines_of(source)
        head, first = read_head(source, lines, frame_rate, scale, trust)
        rows = _read_rows(source, head, lines if first is None else chain([first], lines))
        if frame_rate is None:
            rate = _rate_of(source, rows[:, 0]) if head.frame_rate is None else head.frame_rate
            _check_times(source, rows[:, 0], rate, head.frame_rate is not None)
        else:
            rate = _chosen_rate(source, rows[:, 0], frame_rate, head.frame_rate)
        with source.format_errors():
            positions = rows[:, 1:].reshape(len(rows), len(head.names), 3)
            drop_origin(source, positions, head.names, zeros)
            positions *= head.scale
            positions, axis = stand_points(source, positions, head.names, up, "y", "as is usual", "markers")
            found = Keypoints(positions, head.names, rate, up=axis)
        source.warn_of_extent(found.positions, head.scale)
        return found


def _read_rows(source: Source, head: Head, lines: Lines) -> np.ndarray:
    """Return the columns but the first, Frame#, as an array (n_frames, 1 + 3 n_markers), NaN for lost markers."""
    rows, frame, no_frames = list[np.ndarray](), None, list[int]()
    for line, text in lines:
        if not text.strip():
            continue  # at the end
        is_whole = head.n_frames is None or len(rows) == head.n_frames
        if is_whole and not "".join(text.split("\t", 2)[:2]).strip():
            no_frames.append(line)
            continue
        if len(rows) == head.n_frames:
            raise source.error(
                f"expected the end of the file after {head.n_frames} rows (NumFrames); trust='rows' reads them all",
                line,
            )
        row = _numbers(source, text, line, head.names)
        if no_frames:
            raise source.error("expected a frame, found a row without Frame# and Time", no_frames[0])
        if frame is not None and row[0] != frame + 1:
            raise source.error(
                f"expected frame {frame + 1:.0f}, found {row[0]:g}: frames are missing or out of order; a row of empty "
                "cells stands for a frame without markers",
                line,
            )
        frame = row[0]
        rows.append(row[1:])
    if head.n_frames is not None and len(rows) != head.n_frames:
        raise source.error(
            f"NumFrames: expected {head.n_frames} rows, found {len(rows)}; is the file cut short? trust='rows' reads "
            "the rows that there are",
            head.claimed,
        )
    if no_frames:
        source.warn(
            f"{len(no_frames)} rows after the last frame, from line {no_frames[0]} on, have numbers but neither Frame# "
            "nor Time, and are left out"
        )
    return np.array(rows) if rows else np.empty((0, 1 + 3 * len(head.names)))


def _numbers(source: Source, text: str, line: int, names: list[str]) -> np.ndarray:
    """Return the numbers of a row, NaN for empty cells."""
    cells, width = text.split("\t"), 2 + 3 * len(names)
    if len(cells) < width and any(len(cell.split()) > 1 for cell in cells):
        cells = text.split()  # at blanks; no cell is empty then
    while len(cells) > width and not cells[-1].strip():
        cells.pop()
    if len(cells) != width:
        raise source.error(
            f"expected {width} cells, Frame#, Time and three for each of {len(names)} markers, found {len(cells)}: the "
            "cells of a lost marker are empty, but not left out",
            line,
        )
    try:
        row = np.array([float(cell) if cell and not cell.isspace() else np.nan for cell in cells])
    except ValueError:
        row = None
    if row is None or "_" in text or not text.isascii() or np.isinf(row).any() or np.isnan(row[:2]).any():
        tokens = cells_of("\t".join(cells), line)
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


def _rate_of(source: Source, times: np.ndarray) -> float:
    """Return the frame rate by the column Time, for a file whose DataRate is 0."""
    rate = _mean_rate(times)
    if not (rate > 0 and np.isfinite(rate)):
        raise source.error("DataRate is 0, and Time does not say the rate either: frame_rate= chooses it", 3)
    source.warn(f"DataRate is 0: {rate:g} Hz is the rate of the column Time; frame_rate= chooses another")
    return float(rate)


def _mean_rate(times: np.ndarray) -> float:
    """Return the mean rate of the column Time, Hz; zero, NaN or an infinite number where it has none."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return float((len(times) - 1) / (times[-1] - times[0])) if len(times) > 1 else np.nan


def _chosen_rate(source: Source, times: np.ndarray, given: float, stated: float | None) -> float:
    """Return the rate that is given, with a warning where the file states another, by DataRate and by Time."""
    by_time = _mean_rate(times)
    has_times = by_time > 0 and np.isfinite(by_time)
    if has_times and not differ(given, by_time):
        return given
    if stated is None:
        return choose_rate(source, given, by_time, "the column Time") if has_times else given
    return choose_rate(source, given, stated, "DataRate")


def _check_times(source: Source, times: np.ndarray, frame_rate: float, is_stated: bool) -> None:
    """Refuse times that are not those of the frame rate, rounded or up to 1 % faster or slower."""
    frames = np.arange(len(times))
    with np.errstate(over="ignore", invalid="ignore"):
        wrong = ~(np.abs((times - times[:1]) * frame_rate - frames) <= 0.5 + 0.01 * frames)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise source.error(
            f"{'DataRate is' if is_stated else 'the mean rate is'} {frame_rate:g} Hz, so frame {k} after the first is "
            f"{k / frame_rate:.6g} s after it, but Time says {times[k] - times[0]:.6g} s: frame_rate= chooses the "
            "rate, without regard to Time"
        )
