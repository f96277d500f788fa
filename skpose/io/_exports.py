"""Positions that programs of motion-capture systems export: OptiTrack Motive, Qualisys Track Manager and Xsens MVN.

Motive: "Data export: CSV", https://docs.optitrack.com/motive/data-export/data-export-csv. Five or six lines name the
columns: their type, the name of the body, the quantity and the axis.

Qualisys: "Motion data TSV export", https://docs.qualisys.com/qtm/content/files/motion_data_3d_6d_and_skeleton_tsv.htm.
Lines of a key and its values come first, the last of them MARKER_NAMES or TRAJECTORY_TYPES, and then the names of the
columns, if these include the numbers and times of frames. Positions are in mm.

MVN: "MVN User Manual", Movella, section MVNX, https://www.movella.com/hubfs/MVN_User_Manual.pdf. XML with the origins
of body segments, in m, z up.
"""

import io
from xml.etree import ElementTree

import numpy as np

from skpose.io._conventions import Stored, number_names, read_unit
from skpose.io._keypoints_csv import split_rows
from skpose.io._source import Source, parse, read_cells

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
