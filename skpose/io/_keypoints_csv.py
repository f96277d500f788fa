"""Keypoints in CSV files: one row a frame, with a header that names the coordinates of each point."""

import csv
import re
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from skpose.io._frame_times import Times, time_key
from skpose.io._source import Source
from skpose.io._stored import (
    ANGLES_HEAD,
    POINTS_HEAD,
    Stored,
    as_confidences,
    at_frames,
    frame_key,
    frame_numbers,
    positions_only,
)
from skpose.io._words import NUMBER, complaint
from skpose.keypoints._shared import REMEDY

SEPARATORS = ",;\t"
SURE = "visibility", "confidence", "score", "likelihood", "conf", "vis", "v", "c"
# A coordinate after or before the name of its point: nose_x, nose.X, noseX, x_nose, x1.
AXES = "x", "y", "z", "w"  # the last one of rotations
LETTERS = "|".join(AXES + SURE)
AFTER = re.compile(rf"(.*[^\s_.:-])(?:[\s_.:-]+({LETTERS})|(?-i:(?<=[a-z0-9])([XYZW])))", re.IGNORECASE)
BEFORE = re.compile(rf"({LETTERS})(?:[\s_.:-]+(.+)|(\d+))", re.IGNORECASE)
LONG = {"x", "y", "z"}
LONGEST = 100  # characters of a name
ANGLES = (
    "a table of joint angles, as save_csv writes them, without the skeleton: pandas.read_csv reads it, and "
    "Motion(skeleton, table[list(skeleton.dof_names)], frame_rate) is the motion; save_npz writes motions with their "
    "skeletons, and load_motion reads these"
)
NUMBERED = re.compile(r"([^\d]*)(\d{1,9})")  # landmark_7, 7: no names, but the order of the points


class Columns(NamedTuple):
    """The numbers of columns: of x, y and z of each point, of how sure each is, of the frame's number and time."""

    names: list[str] | None
    positions: list[list[int]]
    confidences: list[int] | None
    frame: int | None
    time: int | None


def is_angles(head: str) -> bool:
    """Return whether the beginning of a file is that of a table of joint angles."""
    return head.startswith(f"{','.join(ANGLES_HEAD)},")


def is_table(head: str) -> bool:
    """Return whether the beginning of a file is a header of positions."""
    line = next((line for line in head.splitlines() if line.strip()), "")
    cells = _cells(line, _separator(line))
    return len(cells) > 1 and ({cell.lower() for cell in cells} >= LONG or bool(find_points(cells)))


def read_csv(source: Source) -> Stored:
    """Return the positions of an open CSV file."""
    rows = _rows(source)
    line, header = next(rows, (1, []))
    if is_angles(source.head):
        raise source.error(f"this is {ANGLES}", line)
    columns = _columns(source, header, line)
    wanted = [*(i for three in columns.positions for i in three), *(columns.confidences or [])]
    numbers, frames, times = list[list[float]](), list[float | str](), list[float]()
    same: dict[str, set[str]] = {word: set() for word in ("frame_rate", "up") if word in header}
    for line, row in rows:
        if len(row) != len(header):
            raise source.error(f"expected {len(header)} cells, as in the header, found {len(row)}", line)
        numbers.append([_number(source, row[i], header[i], line) for i in wanted])
        for word, cells in same.items():
            cells.add(row[header.index(word)])
        if columns.frame is not None:
            frames.append(row[columns.frame] or np.nan)
        if columns.time is not None:
            times.append(float(cell) if NUMBER.fullmatch(cell := row[columns.time]) else np.nan)
    if not numbers:
        raise source.error("expected a row for each frame after the header, found none")
    array = np.array(numbers)
    n = len(columns.positions)
    positions = array[:, : 3 * n].reshape(-1, n, 3)
    confidences = None
    if columns.confidences is not None:
        confidences = as_confidences(source, np.nan_to_num(array[:, 3 * n : 4 * n], posinf=np.inf))
    rate, up = (_only(same.get(word, set())) for word in ("frame_rate", "up"))
    stored = Stored(positions, confidences, columns.names, _rate(rate), up if up in ("x", "y", "z") else None)
    given = frame_numbers(source, frames, header[columns.frame]) if columns.frame is not None else None
    if columns.time is not None:
        at = None if given is None else np.array(given)
        stored = stored._replace(times=Times(header[columns.time], np.array(times), at))
    return at_frames(source, stored, given)


def _only(cells: set[str]) -> str:
    """Return the cell that all rows have, empty if they differ."""
    return next(iter(cells)) if len(cells) == 1 else ""


def _rate(cell: str) -> float | None:
    """Return a frame rate, None if the cell is none: a column of this name may hold something else."""
    rate = float(cell) if NUMBER.fullmatch(cell) else np.nan
    return rate if rate > 0.0 and 0.0 < 1.0 / rate < np.inf else None


def _rows(source: Source) -> Iterator[tuple[int, list[str]]]:
    """Yield each row that is not blank, with the number of its line; a row is one line, also where it is quoted."""
    separator = ""
    while (text := source.readline()) is not None:
        if not text.strip():
            continue
        separator = separator or _separator(text)
        yield source.line, _cells(text, separator)


def _separator(line: str) -> str:
    return max(SEPARATORS, key=line.count)


def _cells(line: str, separator: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([line.rstrip("\r\n")], delimiter=separator), [])]
    except csv.Error:  # a cell of more than 131,072 characters
        return line.split(separator)


def find_points(header: list[str]) -> dict[str, dict[str, int]]:
    """Return for each point the columns of its coordinates, and of its confidence, by letter or word."""
    best: dict[str, dict[str, int]] = {}
    for pattern, of_name, of_axis in ((AFTER, (1,), (2, 3)), (BEFORE, (2, 3), (1,))):
        found: dict[str, dict[str, int]] = {}
        for i, cell in enumerate(header):
            if len(cell) <= LONGEST and (match := pattern.fullmatch(cell)):
                name, axis = (next(match[g] for g in groups if match[g]) for groups in (of_name, of_axis))
                found.setdefault(name, {}).setdefault(axis.lower(), i)
        kept = {name: columns for name, columns in found.items() if {"x", "y"} <= columns.keys()}
        best = max(best, kept, key=len)
    return best


def _columns(source: Source, header: list[str], line: int) -> Columns:
    twice = next((cell for cell in header if cell and header.count(cell) > 1), None)
    if twice is not None:
        raise source.error(f"the header has {twice[:40]!r} {header.count(twice)} times", line)
    lower = [cell.lower() for cell in header]
    points = find_points(header)
    if not points and set(lower) >= LONG:
        raise source.error(
            "one row for each point, where one for each frame is expected: bring all points of a frame into one row, "
            "such as with pandas.DataFrame.pivot, under names such as nose_x, nose_y, nose_z",
            line,
        )
    if not points:
        raise source.error("expected a header with the coordinates of points, such as nose_x,nose_y,nose_z", line)
    if turned := next((name for name, columns in points.items() if {"z", "w"} <= columns.keys()), None):
        raise source.error(
            f"expected positions of points, found x, y, z and w of {turned[:40]!r}, as of a rotation: if w is how sure "
            f"each point is, name it {turned[:40]}_score",
            line,
        )
    kept = positions_only(source, list(points))
    points = {name: points[name] for name in kept}
    numbered = [NUMBERED.fullmatch(name) for name in points]
    is_ours = tuple(header[: len(POINTS_HEAD)]) == POINTS_HEAD  # where points have the names that they had
    is_numbered = not is_ours and len({match[1] for match in numbered if match}) == 1 and None not in numbered
    if is_numbered:
        numbers = [int(match[2]) for match in numbered if match]
        points = {name: points[name] for _, name in sorted(zip(numbers, points, strict=True))}
        if sorted(numbers) != list(range(min(numbers), min(numbers) + len(numbers))):
            raise source.error(
                f"the numbers of points go from {min(numbers)} to {max(numbers)}, and some are missing", line
            )
    flat = [name for name, columns in points.items() if "z" not in columns]
    if len(flat) == len(points):
        raise source.error(f"these are keypoints in two dimensions: {flat[0]!r} has x and y, and no z. {REMEDY}", line)
    if flat:
        raise source.error(f"the point {flat[0][:40]!r} has x and y, and no z", line)
    sure = [next((columns[word] for word in SURE if word in columns), None) for columns in points.values()]
    if None in sure and any(one is not None for one in sure):
        name = list(points)[sure.index(None)]
        raise source.error(f"some points have a confidence, and {name[:40]!r} has none", line)
    return Columns(
        names=None if is_numbered else list(points),
        positions=[[columns[axis] for axis in "xyz"] for columns in points.values()],
        confidences=None if None in sure else [one for one in sure if one is not None],
        frame=None if (key := frame_key(header)) is None else header.index(key),
        time=None if (key := time_key(header)) is None else header.index(key),
    )


def _number(source: Source, cell: str, column: str, line: int) -> float:
    """Return a cell as a number; NaN where it is empty."""
    if not cell:
        return np.nan
    if not NUMBER.fullmatch(cell):
        raise source.error(f"{column[:40]}: {complaint(cell)}", line)
    return float(cell)
