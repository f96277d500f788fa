"""Keypoints in CSV files: one row a frame, with a header that names the coordinates of each point."""

import csv
import re
from collections import Counter
from typing import NamedTuple

import numpy as np

from skpose.io._source import NUMBER, Source
from skpose.io._stored import (
    Stored,
    Times,
    as_confidences,
    at_frames,
    frame_key,
    frame_numbers,
    positions_only,
    time_key,
)
from skpose.keypoints._pictures import REMEDY

# The first columns of the tables that `save_csv` writes, of positions and of angles.
POINTS_HEAD = "frame", "time", "frame_rate", "up"
ANGLES_HEAD = (*POINTS_HEAD, "root_axes")
ANGLES = "this is a table of joint angles of save_csv, without a skeleton: pandas.read_csv reads it"
SEPARATORS = ",;\t"
FORMULA = re.compile(r"'*[=+@-]")  # a cell that begins so is a formula for a spreadsheet, or looks like a quoted one
SURE = "visibility", "confidence", "score", "likelihood", "conf", "vis", "v", "c"
# A coordinate after or before the name of its point: nose_x, nose.X, noseX, x_nose, x1.
AXES = "x", "y", "z", "w"  # the last one of rotations
LETTERS = "|".join(AXES + SURE)
AFTER = re.compile(rf"(.{{0,99}}[^\s_.:-])(?:[\s_.:-]+({LETTERS})|(?-i:(?<=[a-z0-9])([XYZW])))", re.IGNORECASE)
BEFORE = re.compile(rf"({LETTERS})(?:[\s_.:-]+(.+)|(\d+))", re.IGNORECASE)
NUMBERED = re.compile(r"([^\d]*)(\d{1,9})")  # landmark_7, 7: not names, but the order of the points


class Columns(NamedTuple):
    """The numbers of columns: of x, y and z of each point, and of how sure each is."""

    names: list[str] | None
    positions: list[int]
    confidences: list[int]


def is_angles(source: Source) -> bool:
    """Whether a file is a table of joint angles that `save_csv` wrote."""
    return source.head.startswith(f"{','.join(ANGLES_HEAD)},")


def is_csv(source: Source) -> bool:
    """Whether a file begins with a header of positions."""
    line = next(iter(source.head.lstrip().splitlines()), "")
    header = _rows([line])[0] if line else []
    return len(header) > 1 and ({cell.lower() for cell in header} >= {"x", "y", "z"} or bool(find_points(header)))


def read_csv(source: Source) -> Stored:
    lines = [(number, line) for number, line in enumerate(source.lines, 1) if line.strip()]
    if is_angles(source):
        raise source.error(ANGLES)
    header, *rows = _rows([line for _, line in lines])
    header = [cell[1:] if cell[:1] == "'" and FORMULA.match(cell) else cell for cell in header]
    columns = _columns(source, header, lines[0][0])
    wanted = columns.positions + columns.confidences
    array = np.empty((len(rows), len(wanted)))
    for i, ((line, _), row) in enumerate(zip(lines[1:], rows, strict=True)):
        if len(row) != len(header):
            raise source.error(f"expected {len(header)} cells, as in the header, found {len(row)}", line)
        array[i] = [source.number(row[k] or "nan", header[k][:40], line, finite=False, nan=True) for k in wanted]
    if not rows:
        raise source.error("expected a row for each frame after the header, found none")
    n = len(columns.positions)
    confidences = as_confidences(source, array[:, n:]) if columns.confidences else None
    first = dict(zip(header, rows[0], strict=True))
    frame_rate = up = None
    if set(POINTS_HEAD) <= first.keys():
        frame_rate, up = source.number(first["frame_rate"], "frame_rate", lines[1][0]), first["up"]
    stored = Stored(array[:, :n].reshape(len(rows), -1, 3), confidences, columns.names, frame_rate, up)
    key, time = frame_key(header), time_key(header)
    numbers = None if key is None else frame_numbers(source, key, [row[header.index(key)] for row in rows])
    if time is not None:
        cells = [row[header.index(time)] for row in rows]
        times = np.array([float(cell) if NUMBER.fullmatch(cell) else np.nan for cell in cells])
        stored = stored._replace(times=Times(time, times, numbers))
    return at_frames(source, stored, numbers)


def _rows(lines: list[str]) -> list[list[str]]:
    """The cells of each line; a row is one line, also where it is quoted."""
    separator = max(SEPARATORS, key=lines[0].count)
    return [
        [cell.strip() for cell in next(csv.reader([line.rstrip("\r")], delimiter=separator), [])]
        if '"' in line
        else [cell.strip() for cell in line.split(separator)]
        for line in lines
    ]


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


def _columns(source: Source, header: list[str], line: int) -> Columns:
    if twice := [(cell, n) for cell, n in Counter(header).items() if cell and n > 1]:
        raise source.error(f"expected each column once, found {twice[0][0][:40]!r} {twice[0][1]} times", line)
    points = find_points(header)
    if not points:
        raise source.error("expected a header such as nose_x,nose_y,nose_z, and a row for each frame", line)
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
    return Columns(None if is_numbered else list(points), positions, sure)
