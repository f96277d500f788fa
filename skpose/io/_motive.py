"""CSV files of OptiTrack Motive: positions of markers, rigid bodies and bones.

"Data export: CSV", https://docs.optitrack.com/motive/data-export/data-export-csv. Five or six lines name the columns:
their type, the name of the body, the quantity and the axis.
"""

import numpy as np

from skpose.io._conventions import number_names, read_unit
from skpose.io._keypoints_csv import split_rows
from skpose.io._source import Source, parse
from skpose.io._stored import Stored

HEAD = "Format Version,"


def is_motive(source: Source) -> bool:
    return source.head.startswith(HEAD)


def read_motive(source: Source) -> Stored:
    first, *rows = split_rows(source.lines)
    stated = dict(zip(first[::2], first[1::2], strict=False))
    start = next((i for i, row in enumerate(rows) if row[0] == "Frame"), 0)
    axes = rows[start] if start else []
    heads = [row for row in rows[:start] if any(row)]
    named = next((row for row in heads if row[1:2] == ["Name"]), (heads[1:2] or [[]])[0])  # the second, in old files
    quantities = next((row for row in heads if "Position" in row), [])
    columns = [i for i, word in enumerate(quantities) if word == "Position" and i < min(len(named), len(axes))]
    if not columns or [axes[i] for i in columns] != ["X", "Y", "Z"] * (len(columns) // 3):
        raise source.error("expected columns X, Y, Z of Position with a Name: export global positions")
    scale = read_unit(source, "Length Units", stated["Length Units"], None) if "Length Units" in stated else None
    words = [row[i] or "nan" if i < len(row) else "nan" for row in rows[start + 1 :] if any(row) for i in columns]
    numbers = parse(" ".join(words).encode())
    if numbers is None or len(numbers) != len(words):
        raise source.error("expected numbers in the columns of positions, found others")
    names = number_names(source, [named[i] for i in columns[::3]])
    rate = source.number(stated.get("Export Frame Rate", stated.get("Capture Frame Rate", "")), "Export Frame Rate")
    positions = np.reshape(numbers, (-1, len(names), 3))
    return Stored(positions, None, names, rate, "y", scale=scale, why="as in Motive")
