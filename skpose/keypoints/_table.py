"""Layouts from tables: the points, their parents, and the source.

A table has a row for each point of the array, in its order, and then one for each midpoint: name, parent, whether the
point is rigid. Names follow the source in snake case; OpenPose, Kinect and Pose2Sim names have their sides first,
and marker names are as in files, with the letters of both sides in capitals.
"""

from collections.abc import Mapping
from typing import Literal

from skpose.keypoints._layout import Layout

RIGID = True
Row = tuple[str, str | None] | tuple[str, str | None, bool]


def layout_of(
    name: str,
    rows: tuple[Row, ...],
    source: str,
    up: Literal["y", "z", "-y"] = "y",
    midpoints: Mapping[str, tuple[str, ...]] = {},
) -> Layout:
    return Layout(
        name,
        names=[row[0] for row in rows if row[0] not in midpoints],
        parents={row[0]: row[1] for row in rows},
        midpoints=midpoints,
        rigid=[row[0] for row in rows if row[2:] == (RIGID,)],
        up=up,
        source=source,
    )
