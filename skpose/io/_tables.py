"""Tables of positions, one row a frame: CSV with a header, TRC, and exports of Motive, Qualisys and MVN."""

import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import chain
from typing import Literal
from xml.etree import ElementTree

import numpy as np

from skpose._utils.files import write_csv
from skpose.io._conventions import (
    METRES,
    Stored,
    Times,
    Up,
    Zeros,
    agree,
    as_confidences,
    at_frames,
    check_options,
    choose_rate,
    frame_key,
    frame_numbers,
    keypoints_of_markers,
    number_names,
    positions_only,
    read_unit,
    time_key,
)
from skpose.io._source import NUMBER, WHOLE, PathLike, Readable, Source, complaint, open_source, parse
from skpose.keypoints import Keypoints
from skpose.keypoints._checks import REMEDY
from skpose.keypoints._keypoints import columns_of
from skpose.skeleton import Motion

# The first columns of the tables that `save_csv` writes, of positions and of angles.
POINTS_HEAD = "frame", "time", "frame_rate", "up"
ANGLES_HEAD = (*POINTS_HEAD, "root_axes")
SEPARATORS = ",;\t"
FORMULA = re.compile(r"'*[=+@-]")  # a cell that begins so is a formula for a spreadsheet, or looks like a quoted one
SURE = "visibility", "confidence", "score", "likelihood", "conf", "vis", "v", "c"
# A coordinate after or before the name of its point: nose_x, nose.X, noseX, x_nose, x1.
AXES = "x", "y", "z", "w"  # the last one of rotations
LETTERS = "|".join(AXES + SURE)
AFTER = re.compile(rf"(.{{0,99}}[^\s_.:-])(?:[\s_.:-]+({LETTERS})|(?-i:(?<=[a-z0-9])([XYZW])))", re.IGNORECASE)
BEFORE = re.compile(rf"({LETTERS})(?:[\s_.:-]+(.+)|(\d+))", re.IGNORECASE)
# A unit after a column's name, in brackets; or of length, after the axis: X (mm), hip_x_mm.
BRACKETED = re.compile(r"(.*[^\s_])[\s_]*[(\[](?!\d*[)\]])([^()\[\]]*)[)\]]")
AFTER_AXIS = re.compile(rf"((?:.*[\s_.:-])?[xyz])[\s_.-]+({'|'.join(METRES)})", re.IGNORECASE)
NUMBERED = re.compile(r"([^\d]*)(\d{1,9})")  # landmark_7, 7: not names, but the order of the points


Row = tuple[int, list[str]]  # of a table: the number of its line, and its cells without blanks around them
NOTHING = "", "NULL"  # cells without a number


def read_cells(source: Source, rows: Sequence[Row], columns: Sequence[int], width: int) -> np.ndarray:
    """The numbers (n_rows, n_columns) in some columns of a table, NaN where a cell is empty."""
    words = list[str]()
    for line, cells in rows:
        if len(cells) != width:
            raise source.error(f"expected {width} cells, found {len(cells)}", line)
        words += ["nan" if cells[i] in NOTHING else cells[i] for i in columns]
    numbers = parse(" ".join(words).encode())
    if numbers is None or len(numbers) != len(words):
        i = next(i for i, word in enumerate(words) if not NUMBER.fullmatch(word))
        raise source.error(f"column {columns[i % len(columns)] + 1}: {complaint(words[i])}", rows[i // len(columns)][0])
    return numbers.reshape(len(rows), len(columns))


def is_csv(source: Source) -> bool:
    """Whether a file begins with a header of positions."""
    header = [_split_unit(cell)[0] for _, row in split_rows(source.head.lstrip().splitlines()[:1]) for cell in row]
    is_header = {cell.lower() for cell in header} >= {"x", "y", "z"} or bool(find_points(header))
    return source.head.startswith("scorer,") or (len(header) > 1 and is_header)


def read_csv(source: Source) -> Stored:
    (line, header), *numbered = split_rows(source.lines)
    if header[0] == "scorer":  # DeepLabCut's header has a line of points and one of coordinates
        header = ["frame", *map("_".join, list(zip(*(row for _, row in numbered[:2]), strict=True))[1:])]
        numbered = numbered[2:]
    header = [cell[1:] if cell[:1] == "'" and FORMULA.match(cell) else cell for cell in header]
    (names, at, sure, scale), rows = _columns(source, header, line), [row for _, row in numbered]
    if not rows:
        raise source.error("expected a row for each frame after the header, found none")
    wanted = at + sure
    array = read_cells(source, numbered, wanted, len(header))
    n = len(at)
    confidences = as_confidences(source, array[:, n:]) if sure else None
    first = dict(zip(header, rows[0], strict=True))
    frame_rate = up = None
    if set(POINTS_HEAD) <= first.keys():
        frame_rate, up = source.number(first["frame_rate"], "frame_rate", numbered[0][0]), first["up"]
    positions = array[:, :n].reshape(len(rows), -1, 3)
    stored = Stored(positions, confidences, names, frame_rate, up, scale=scale)
    key, time = frame_key(header), time_key(header)
    others = [cell for i, cell in enumerate(header) if i not in wanted and cell != key]
    for other in others if n == 3 else filter(None, [time]):
        if _tells_rows_apart([row[header.index(other)] for row in rows]):
            raise source.error(f"expected one row for each frame, found several by the column {other[:40]!r}: keep one")
    numbers = None if key is None else frame_numbers(source, key, [row[header.index(key)] for row in rows])
    if time is not None:
        cells = [row[header.index(time)] for row in rows]
        times = np.array([float(cell) if NUMBER.fullmatch(cell) else np.nan for cell in cells])
        stored = stored._replace(times=Times(time, times, numbers))
    return at_frames(source, stored, numbers)


def split_rows(lines: list[str]) -> list[Row]:
    """The cells of each line that is not blank; a row is one line, also where it is quoted."""
    numbered = [(number, line.rstrip("\r")) for number, line in enumerate(lines, 1) if line.strip()]
    separator = max(SEPARATORS, key=numbered[0][1].count) if numbered else ","
    rows = list[Row]()
    for number, line in numbered:
        cells = next(csv.reader([line], delimiter=separator), []) if '"' in line else line.split(separator)
        rows.append((number, [cell.strip() for cell in cells]))
    return rows


def _split_unit(cell: str) -> tuple[str, str]:
    """The name of a column, and its unit; empty if it has none."""
    match = BRACKETED.fullmatch(cell) or AFTER_AXIS.fullmatch(cell)
    return (match[1], match[2].strip().lower()) if match else (cell, "")


def _tells_rows_apart(cells: list[str]) -> bool:
    """Whether words, or numbers that begin again, as of samples, show that rows of one frame are in several places."""
    if not all(map(NUMBER.fullmatch, cells)):
        return 1 < len(set(cells)) < len(cells) and "" not in cells
    numbers = np.array(cells, dtype=np.float64)
    steps, again = np.diff(numbers), numbers[1:] == numbers[0]
    return bool(again.any() and ((steps > 0.0) | again).all() and steps[0] > 0.0)


def find_points(header: list[str]) -> dict[str, dict[str, int]]:
    """For each point the columns of its coordinates, and of its confidence, by letter or word."""
    best: dict[str, dict[str, int]] = {}
    for pattern, of_name, of_axis in ((AFTER, (1,), (2, 3)), (BEFORE, (2, 3), (1,))):
        found: dict[str, dict[str, int]] = {}
        for i, cell in enumerate(header):
            if match := pattern.fullmatch(cell):
                name, axis = (next(match[g] for g in groups if match[g]) for groups in (of_name, of_axis))
                found.setdefault(name, {}).setdefault(axis.lower(), i)
        kept = {name: columns for name, columns in found.items() if {"x", "y"} <= columns.keys()}
        best = max(best, kept, key=len)
    return best


def _columns(
    source: Source, header: list[str], line: int
) -> tuple[list[str] | None, list[int], list[int], float | None]:
    """The names of points, the columns of their coordinates and confidences, and the metres per unit, if stated."""
    if twice := [(cell, n) for cell, n in Counter(header).items() if cell and n > 1]:
        raise source.error(f"expected each column once, found {twice[0][0][:40]!r} {twice[0][1]} times", line)
    cells, units = zip(*map(_split_unit, header), strict=True)
    others = [i for i, unit in enumerate(units) if unit and unit not in METRES]
    points = find_points(["" if i in others else cell for i, cell in enumerate(cells)])
    lost = find_points(list(cells)).keys() - points.keys()
    what = ", ".join(repr(header[i][:40]) for i in others if lost or cells[i].lower() in AXES)[:120]
    if not points:
        expected = "a header such as nose_x,nose_y,nose_z, and a row for each frame"
        raise source.error(f"expected positions of points, found {what}" if what else f"expected {expected}", line)
    if lost:
        source.warn(f"{what}: not positions by their units, and left out")
    if turned := [name for name, columns in points.items() if {"z", "w"} <= columns.keys()]:
        raise source.error(f"expected positions of points, found the rotation {turned[0][:40]!r} with x, y, z, w", line)
    points = {name: points[name] for name in positions_only(source, list(points))}
    numbered = [match for name in points if (match := NUMBERED.fullmatch(name))]
    is_ours = tuple(header[: len(POINTS_HEAD)]) == POINTS_HEAD  # where points have the names that they had
    is_numbered = len(numbered) == len(points) and len({match[1] for match in numbered}) == 1 and not is_ours
    if is_numbered:
        by_number = {int(match[2]): points[match[0]] for match in numbered}
        if max(by_number) - min(by_number) + 1 != len(numbered):
            raise source.error("expected points with consecutive numbers, and some are missing", line)
        points = {str(number): by_number[number] for number in sorted(by_number)}
    flat = [name for name, columns in points.items() if "z" not in columns]
    if flat:
        raise source.error(f"{flat[0][:40]!r} has no z: these are keypoints in two dimensions. {REMEDY}", line)
    sure = [columns[word] for columns in points.values() for word in [*filter(columns.__contains__, SURE)][:1]]
    if sure and len(sure) < len(points):
        raise source.error("expected a confidence of each point or of none", line)
    positions = [columns[axis] for columns in points.values() for axis in "xyz"]
    scales = {METRES.get(units[i]) for i in positions}
    if len(scales) > 1:
        raise source.error(f"expected one unit of length, found {sorted({units[i] for i in positions})}", line)
    return None if is_numbered else list(points), positions, sure, scales.pop()


# --- writer -----------------------------------------------------------------------------------------------------------


def save_csv(path: PathLike, content: Motion | Keypoints) -> None:
    """Write the angles of a motion, or the positions of keypoints, as a table in a CSV file.

    Parameters
    ----------
    path : str or path-like
        The file, which must not exist yet. It is written whole or not at all.
    content : Motion or Keypoints
        What to write.

    Raises
    ------
    TypeError
        If it is neither a motion nor keypoints.
    ValueError
        For names of points that would be others where the file is read; for keypoints without frames.
    OSError
        If the file exists, or cannot be written.

    See Also
    --------
    load_keypoints : Read the table of keypoints again.
    save_npz : Write a motion with its skeleton, which `load_motion` reads.

    Notes
    -----
    A row is a frame, commas separate cells, and numbers have as many digits as they need to be read as they are. The
    first columns are

    ================================== ===================================================================
    ``frame``, ``time``                number of the frame; its time, s
    ``frame_rate``, ``up``             Hz; the axis of the world that points up. The same in all rows
    ``root_axes``                      of a motion: the axes of the root's angles, see `Motion`; likewise
    ================================== ===================================================================

    Of a motion then follow ``root_x``, ``root_y``, ``root_z``, the positions of the root, m, its angles, rad, such as
    ``root_rz``, and the angles of the joints, rad, by ``skeleton.dof_names``. The "root" of these columns is
    ``"root_"``, or has more underscores, where columns of the joints have these names. The skeleton is not in the
    table: the last example puts the angles onto it again.

    Names that a spreadsheet would take for formulas, which begin with ``=``, ``+``, ``-`` or ``@``, follow a single
    quote; `load_keypoints` removes it.

    Of keypoints follow ``hip_x``, ``hip_y``, ``hip_z`` of each point, m, without a number where it is not seen, and
    ``hip_confidence`` where any confidence is between 0 and 1.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import pandas
    >>> from skpose import Motion
    >>> from skpose.datasets import make_gait
    >>> from skpose.io import save_csv
    >>> walk = make_gait(1, 1, random_state=0)[0]
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "walk.csv")
    ...     save_csv(path, walk)
    ...     table = pandas.read_csv(path)
    >>> list(table.columns[:9])
    ['frame', 'time', 'frame_rate', 'up', 'root_axes', 'root_x', 'root_y', 'root_z', 'root_rx']
    >>> angles = table[list(walk.skeleton.dof_names)]
    >>> Motion(walk.skeleton, angles, table["frame_rate"][0], table[["root_x", "root_y", "root_z"]], up=table["up"][0])
    Motion(180 frames at 60 Hz, 3.0 s, y up, Skeleton(n_joints=22, n_dofs=48))
    """
    if not isinstance(content, Motion | Keypoints):
        raise TypeError(f"content must be a skpose.Motion or skpose.Keypoints, got {type(content).__name__}")
    header, same, numbers, columns = _of_motion(content) if isinstance(content, Motion) else _of_keypoints(content)
    head = [f"'{cell}" if FORMULA.match(cell) else cell for cell in header]
    frames = zip(numbers.tolist(), (numbers / content.frame_rate).tolist(), columns, strict=True)
    rows = ([number, time, *same, *("" if x != x else x for x in row)] for number, time, row in frames)
    write_csv(path, chain([head], rows))


Table = tuple[list[str], list, np.ndarray, Iterable[list[float]]]


def _of_motion(motion: Motion) -> Table:
    """The header, the cells that are the same in all rows, the numbers of the frames, and the other cells."""
    names, root = motion.skeleton.dof_names, "root"

    def root_columns() -> list[str]:
        return [f"{root}_{axis}" for axis in "xyz"] + [f"{root}_r{axis}" for axis in motion.root_axes.lower()]

    while set(root_columns()) & set(names):
        root += "_"
    header = [*ANGLES_HEAD, *root_columns(), *names]
    same = [float(motion.frame_rate), motion.up, motion.root_axes]
    array = np.concatenate([motion.root_positions, motion.root_angles, motion.angles], axis=1)
    return header, same, motion.frame_numbers, (row.tolist() for row in array)


def _of_keypoints(points: Keypoints) -> Table:
    """The same of keypoints."""
    if not len(points):
        raise ValueError("a CSV file needs at least one frame, got none: write an .npz file")
    columns, array = columns_of(points)
    header = [*POINTS_HEAD, *columns]
    found = list(find_points([cell.strip() for cell in header]))
    if found != list(points.names):
        name = next((name for name in points.names if name not in found), points.names[0])
        raise ValueError(
            f"point {name[:100]!r} would have another name in a CSV file: rename it, or write an .npz file"
        )
    same = [float(points.frame_rate), points.up]
    return header, same, np.arange(len(points)), (row.tolist() for row in array)


# --- exports of Motive, Qualisys and MVN ------------------------------------------------------------------------------
# Motive: "Data export: CSV", https://docs.optitrack.com/motive/data-export/data-export-csv. Five or six lines name the
# columns: their type, the name of the body, the quantity and the axis.
#
# Qualisys: "Motion data TSV export",
# https://docs.qualisys.com/qtm/content/files/motion_data_3d_6d_and_skeleton_tsv.htm. Lines of a key and its values come
# first, the last of them MARKER_NAMES or TRAJECTORY_TYPES, and then the names of the columns, if these include the
# numbers and times of frames. Positions are in mm.
#
# MVN: "MVN User Manual", Movella, section MVNX, https://www.movella.com/hubfs/MVN_User_Manual.pdf. XML with the origins
# of body segments, in m, z up.


LAST = "MARKER_NAMES", "TRAJECTORY_TYPES", "Frame"  # how the last lines of Qualisys before the frames begin
USUAL = "normal"  # MVN: frames of another type are poses of the calibration


def read_motive(source: Source) -> Stored:
    (_, first), *rows = split_rows(source.lines)
    stated = dict(zip(first[::2], first[1::2], strict=False))
    start = next((i for i, (_, row) in enumerate(rows) if row[0] == "Frame"), 0)
    axes, heads = rows[start][1] if start else [], [row for _, row in rows[:start] if any(row)]
    named = next((row for row in heads if row[1:2] == ["Name"]), (heads[1:2] or [[]])[0])  # the second, in old files
    quantities = next((row for row in heads if "Position" in row), [])
    columns = [i for i, word in enumerate(quantities) if word == "Position" and i < min(len(named), len(axes))]
    if not columns or [axes[i] for i in columns] != ["X", "Y", "Z"] * (len(columns) // 3):
        raise source.error("expected columns X, Y, Z of Position with a Name: export global positions")
    scale = read_unit(source, "Length Units", stated["Length Units"], None) if "Length Units" in stated else None
    empty = [""] * len(axes)  # rows may end before their last cells
    numbers = read_cells(
        source,
        [(line, (row + empty)[: len(axes)]) for line, row in rows[start + 1 :] if any(row)],
        columns,
        len(axes),
    )
    names = number_names(source, [named[i] for i in columns[::3]])
    rate = source.number(stated.get("Export Frame Rate", stated.get("Capture Frame Rate", "")), "Export Frame Rate")
    return Stored(numbers.reshape(-1, len(names), 3), None, names, rate, "y", scale=scale, why="as in Motive")


def read_qualisys(source: Source) -> Stored:
    rows = split_rows(source.lines)
    n_head = max((i + 1 for i, (_, cells) in enumerate(rows) if cells[0] in LAST), default=0)
    stated = {cells[0]: cells[1:] for _, cells in rows[:n_head]}
    names = [name for name in stated.get("MARKER_NAMES", []) if name]
    if not names:
        raise source.error("expected MARKER_NAMES: export markers in three dimensions")
    n_before = 2 * ("Frame" in stated)  # columns of the frame and the time
    width = n_before + 3 * len(names)
    frames = [(line, [*cells[:width], *filter(None, cells[width:])]) for line, cells in rows[n_head:]]
    numbers = read_cells(source, frames, range(n_before, width), width)
    rate = source.number(next(iter(stated.get("FREQUENCY", [])), ""), "FREQUENCY")
    return Stored(numbers.reshape(-1, len(names), 3), None, names, rate, "z", scale=0.001, why="as in QTM")


def read_mvnx(source: Source) -> Stored:
    names, rate, rows = list[str](), "", list[np.ndarray]()
    try:
        for _, element in ElementTree.iterparse(io.BytesIO(source.data)):
            kind = element.tag.rpartition("}")[2]
            if kind == "segment":
                names.append(element.get("label", ""))
            elif kind == "subject":
                rate = element.get("frameRate", "")
            elif kind == "frame":
                if element.get("type", USUAL) == USUAL:
                    texts = [child.text or "" for child in element if child.tag.rpartition("}")[2] == "position"]
                    numbers = parse(" ".join(texts).encode())
                    rows.append(np.empty(0) if numbers is None else numbers)
                element.clear()  # for memory
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # damage, or an unknown encoding
        raise source.error(f"XML is damaged or cut short: {error}") from None
    if not rows or not names or any(len(row) != 3 * len(names) for row in rows):
        raise source.error("expected segments, and <position> of all of them in each frame: export MVNX with positions")
    positions = np.reshape(rows, (len(rows), len(names), 3))
    return Stored(positions, None, names, source.number(rate, "frameRate"), "z", why="as in MVN")


# --- TRC --------------------------------------------------------------------------------------------------------------
# Positions of markers in time as text, of Motion Analysis and OpenSim. Programs separate the cells by tabs, by blanks,
# by both, or by commas. Where there are tabs they separate, so that an empty cell shifts no other and names may have
# blanks in them.


# Frame# and Time, with a unit as in "Time (s)" or, before a tab, "Time s".
COLUMNS = re.compile(
    r"\s*frame\s?#?\s+times?(?: *[(\[][^)\]\t]*[)\]]|[ /]+s(?:ec(?:onds?)?)?(?=\t))?(?=\s|$)", re.IGNORECASE
)
ORDER = re.compile(r"\s\((?!X/Y/Z)[XYZ]/[XYZ]/[XYZ]\)(?=\s|$)", re.IGNORECASE)  # of the axes, in the first line
TRIPLES = re.compile(r"(?:\s*X\d*\s+Y\d*\s+Z\d*(?=\s|$))+\s*", re.IGNORECASE)

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
        if not TRIPLES.fullmatch(row):
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
