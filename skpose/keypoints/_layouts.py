"""The layouts that come with the library, made from their tables."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from skpose._utils.validation import check_choice
from skpose.keypoints._layout import Layout, find_names
from skpose.keypoints._tables import LAYOUTS

_BY_NAME = {layout.name: layout for layout in LAYOUTS}


class _Layouts(Mapping[str, Layout]):
    """The layouts that come with the library, by name; a read-only mapping.

    ================== ======================================== ====== ===========================================
    name               keypoints of                             up     added midpoints
    ================== ======================================== ====== ===========================================
    "coco17"           COCO, lifted to 3-D: MMPose, MoveNet ... y      pelvis, neck
    "mediapipe33"      MediaPipe Pose, its world landmarks      −y     pelvis, neck
    "h36m17"           Human3.6M, in world coordinates          z
    "body25"           OpenPose BODY_25, triangulated           −y
    "kinect25"         Kinect v2, in camera space               y
    "smpl24"           SMPL, its joints                         y
    "humanml22"        HumanML3D, joints of SMPL without hands  y
    "cmu31"            CMU's ASF files, the root and 30 bones   y
    "kinect20"         the first Kinect, in skeleton space      y
    "mediapipe_hand21" MediaPipe Hands, one, world landmarks    −y
    "pose2sim21"       Pose2Sim, HALPE_26 without the face      y      hip
    "opencap43"        OpenCap's markers, of video              y      pelvis, knees, ankles, elbows, wrists
    "plug_in_gait39"   markers of Plug-in Gait, the full body   z      pelvis, hips, thorax, head, wrists
    "opencap_mocap55"  OpenCap's markers, of motion capture     y      pelvis, knees, ankles, elbows, wrists
    ================== ======================================== ====== ===========================================

    ``layouts["coco17"].source`` is the source of the order of the points. Keypoints lifted from pictures to 3-D have
    the axes of the program that lifts them: if y is not up, pass ``dataclasses.replace(layouts["coco17"], up="z")``.
    `Layout` makes your own in a few lines.

    Files of markers name their points, and some lack a few:
    ``layouts["plug_in_gait39"].without(["LUPA", "RUPA"]).keypoints(load_c3d("walk.c3d"))``. Markers are on the skin,
    and so are the ends of bones that are markers; the hips of "plug_in_gait39" are computed from those of the pelvis by
    Harrington's regression, see `Layout`. If a file has joint centres, a `Layout` with these is better. Medial markers
    of knees and ankles are often in the standing trial only: ``layout.keypoints(markers, absent="unseen")`` reads the
    other trials.

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
        return _BY_NAME[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_BY_NAME)

    def __len__(self) -> int:
        return len(_BY_NAME)

    def __repr__(self) -> str:
        return f"layouts({', '.join(self)})"


layouts = _Layouts()


def check_layout(layout: Any) -> Layout:
    """A layout, given as such or by name."""
    if isinstance(layout, Layout):
        return layout
    check_choice("layout", layout, tuple(layouts))
    return layouts[layout]


def find_layout(names: Sequence[str]) -> Layout | None:
    """The layout with all of its points among the names, in any spelling; the one with the most points."""
    complete = (layout for layout in layouts.values() if _share(layout, names) == 1.0)
    return max(complete, key=lambda layout: len(layout.names), default=None)


def missing_points(layout: Layout, names: Sequence[str]) -> list[str]:
    """The points of a layout that are not among names, in any spelling."""
    found = find_names(layout.names, names)
    return [name for name in layout.names if name not in found]


def nearest_layout(names: Sequence[str]) -> Layout | None:
    """The layout with the largest share of its points among names; None if that is less than half."""
    nearest = max(layouts.values(), key=lambda layout: _share(layout, names))
    return nearest if _share(nearest, names) >= 0.5 else None


def _share(layout: Layout, names: Sequence[str]) -> float:
    """The share of a layout's points among names."""
    try:
        return 1.0 - len(missing_points(layout, names)) / len(layout.names)
    except ValueError:  # two names differ in spelling only
        return 0.0
