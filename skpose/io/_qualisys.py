"""TSV files of Qualisys Track Manager: positions of markers, in mm.

"Motion data TSV export", https://docs.qualisys.com/qtm/content/files/motion_data_3d_6d_and_skeleton_tsv.htm. Lines of a
key and its values come first, the last of them MARKER_NAMES or TRAJECTORY_TYPES, and then the names of the columns, if
these include the numbers and times of frames.
"""

import numpy as np

from skpose.io._source import Source, parse
from skpose.io._stored import Stored

LAST = "MARKER_NAMES", "TRAJECTORY_TYPES", "Frame"  # how the last lines before the frames begin


def is_qualisys(source: Source) -> bool:
    return source.first_word == "no_of_frames"


def read_qualisys(source: Source) -> Stored:
    rows = [(number, line.strip("\r").split("\t")) for number, line in enumerate(source.lines, 1) if line.strip()]
    n_head = max((i + 1 for i, (_, cells) in enumerate(rows) if cells[0].strip() in LAST), default=0)
    stated = {cells[0].strip(): [cell.strip() for cell in cells[1:]] for _, cells in rows[:n_head]}
    names = [name for name in stated.get("MARKER_NAMES", []) if name]
    if not names:
        raise source.error("expected MARKER_NAMES: export markers in three dimensions")
    n_before = 2 * ("Frame" in stated)  # columns of the frame and the time
    width = n_before + 3 * len(names)
    words = list[str]()
    for number, cells in rows[n_head:]:
        if len(cells) < width or any(cell.strip() for cell in cells[width:]):
            raise source.error(f"expected {width} cells, three for each marker, found {len(cells)}", number)
        words += [cell.strip().replace("NULL", "") or "nan" for cell in cells[n_before:width]]
    numbers = parse(" ".join(words).encode())
    if numbers is None or len(numbers) != len(words):
        raise source.error("expected numbers of the markers, found others")
    rate = source.number(next(iter(stated.get("FREQUENCY", [])), ""), "FREQUENCY")
    return Stored(np.reshape(numbers, (-1, len(names), 3)), None, names, rate, "z", scale=0.001, why="as in QTM")
