"""The layouts that come with the library, made of their tables."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from skpose.keypoints._layout import Layout
from skpose.keypoints._names import find_names
from skpose.keypoints._table import RIGID, Table
from skpose.keypoints._tables import TABLES


def _layout(table: Table) -> Layout:
    return Layout(
        table.name,
        names=table.names,
        parents={row[0]: row[1] for row in table.rows},
        midpoints=table.midpoints,
        rigid=[row[0] for row in table.rows if row[2:] == (RIGID,)],
        up=table.up,
        source=table.source,
    )


_BY_NAME = {table.name: _layout(table) for table in TABLES}


class _Layouts(Mapping[str, Layout]):
    """The layouts that come with the library, by name; a read-only mapping.

    ================== ======================================== ====== ===========================================
    name               keypoints of                             up     made besides
    ================== ======================================== ====== ===========================================
    "coco17"           COCO, lifted to 3-D: MMPose, MoveNet ... y      pelvis, neck
    "mediapipe33"      MediaPipe Pose, its world landmarks      −y     pelvis, neck
    "h36m17"           Human3.6M, in world coordinates          z
    "body25"           OpenPose BODY_25, triangulated           −y
    "kinect25"         Kinect v2, in camera space               y
    "smpl24"           SMPL, its joints                         y
    "cmu31"            CMU's ASF files, the root and 30 bones   y
    "kinect20"         the first Kinect, in skeleton space      y
    "mediapipe_hand21" MediaPipe Hands, one, world landmarks    −y
    "pose2sim21"       Pose2Sim, HALPE_26 without the face      y      hip
    "opencap43"        OpenCap's markers, of video              y      pelvis, knees, ankles, elbows, wrists
    "plug_in_gait39"   markers of Plug-in Gait, the full body   z      pelvis, hips, thorax, head, wrists
    "opencap_mocap55"  OpenCap's markers, of motion capture     y      pelvis, knees, ankles, elbows, wrists
    ================== ======================================== ====== ===========================================

    Each states where the order of its points is from, ``layouts["coco17"].source``. Keypoints that are lifted from
    pictures to 3-D have no axis of their own that points up: where it is not y, pass
    ``dataclasses.replace(layouts["coco17"], up="z")``. `Layout` makes another one in a few lines.

    Files of markers name their points, and some have fewer of them:
    ``layouts["plug_in_gait39"].without(["LUPA", "RUPA"]).keypoints(load_c3d("walk.c3d"))``. Markers stand on the skin,
    and so do the ends of bones that are markers; the hips of "plug_in_gait39" are means of markers of the pelvis, above
    the joints. Where a file states joint centres, a `Layout` with these is better. Medial markers of knees and ankles
    are often there for the standing trial alone: ``layout.keypoints(markers, absent="unseen")`` reads the others.

    Examples
    --------
    >>> from skpose.keypoints import layouts
    >>> list(layouts)[:3]
    ['coco17', 'mediapipe33', 'h36m17']
    >>> layouts["coco17"].names[:3]
    ('nose', 'left_eye', 'right_eye')
    >>> layouts["coco17"].pairs[0]
    ('left_eye', 'right_eye')
    """

    def __getitem__(self, name: str) -> Layout:
        if name not in _BY_NAME:
            raise KeyError(f"there is no layout {name!r}; the layouts are {', '.join(self)}")
        return _BY_NAME[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_BY_NAME)

    def __len__(self) -> int:
        return len(_BY_NAME)

    def __repr__(self) -> str:
        return f"layouts({', '.join(self)})"


layouts = _Layouts()


def check_layout(layout: Any) -> Layout:
    """Return a layout, which may be named."""
    if isinstance(layout, Layout):
        return layout
    if not isinstance(layout, str):
        raise TypeError(f"layout must be a Layout or the name of one, got {type(layout).__name__}")
    if layout not in layouts:
        raise ValueError(f"layout must be one of {', '.join(layouts)}, got {layout!r}")
    return layouts[layout]


def find_layout(names: Sequence[str]) -> Layout | None:
    """Return the layout of which all points are among the names, in any spelling; of several the one with the most."""

    def fits(layout: Layout) -> bool:
        try:
            return not missing_points(layout, names)
        except ValueError:  # two points have one name but for the spelling
            return False

    return max(filter(fits, layouts.values()), key=lambda layout: len(layout.names), default=None)


def missing_points(layout: Layout, names: Sequence[str]) -> list[str]:
    """Return the points of a layout that are not among names, in any spelling."""
    found = find_names(layout.names, names)
    return [name for name in layout.names if name not in found]


def nearest_layout(names: Sequence[str]) -> Layout | None:
    """Return the layout of which the largest share of the points is among names; None if that is less than half."""

    def share(layout: Layout) -> float:
        try:
            return 1.0 - len(missing_points(layout, names)) / len(layout.names)
        except ValueError:  # two points have one name but for the spelling
            return 0.0

    nearest = max(layouts.values(), key=share)
    return nearest if share(nearest) >= 0.5 else None
