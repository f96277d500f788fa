"""The player: motions in one page, side by side or on top of each other, optionally aligned in time."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from skpose._utils.validation import check_kind
from skpose.geodesics import GeodesicResult
from skpose.keypoints import Keypoints, Layout
from skpose.keypoints._layouts import check_layout
from skpose.kinematics import forward_kinematics
from skpose.kinematics._forward import weighted_positions
from skpose.motions import Alignment
from skpose.skeleton import Motion
from skpose.skeleton._interpolation import straight_line
from skpose.skeleton._rotations import TWO_PI
from skpose.view._page import Page, check_labels, page_of
from skpose.view._scene import motion_data, pack, points_data

Recording = Motion | Keypoints

MOST = 12  # motions in one page; more would be too small to see
DURATION, FRAME_RATE = 2.0, 30.0  # s, Hz, of paths
FINE = 640  # chords by which the straight line is measured
ASSETS = (
    "page.css",
    "panels.css",
    "player.css",
    "sharing.html",
    "page.js",
    "figure.js",
    "shape.js",
    "gestures.js",
    "orbit.js",
    "between.js",
    "clip.js",
    "stage.js",
    "loop.js",
    "link.js",
    "gif.js",
    "record.js",
    "player.js",
)


def player(
    motions: Motion | Keypoints | GeodesicResult | Iterable[Any],
    *,
    labels: Sequence[str] | None = None,
    alignment: Alignment | None = None,
    layout: Layout | str | None = None,
    overlay: bool = False,
    title: str | None = None,
    up: Literal["x", "y", "z"] = "y",
) -> Page:
    """Make a page that plays motions, to be turned and compared: one HTML file without network access.

    Parameters
    ----------
    motions : Motion, Keypoints, iterable of these, or GeodesicResult
        One motion, or up to twelve, of any skeletons and frame rates. Keypoints, such as markers, are drawn in the
        frames that have them. A path of `skpose.geodesic` is played next to the straight line: both take two seconds at
        constant speed, and colours show the distance of each joint from its place on the other path.
    labels : sequence of str, default=None
        A name for each; None is "motion 1", "motion 2" and so on.
    alignment : Alignment, default=None
        For two motions: the matching frames, from ``align_motions(a, b)``. The two are then played in step, and colours
        show the distance of each joint from its counterpart.
    layout : Layout or str, default=None
        The layout of keypoints, or its name in `skpose.keypoints.layouts`: its bones are drawn between the points, with
        its midpoints. None chooses the largest layout whose points are all there by name; without one, points have no
        bones. The help in the page names it.
    overlay : bool, default=False
        Whether several motions start in one picture instead of side by side; a control in the page changes it.
    title : str, default=None
        Title of the page; None is the labels.
    up : {"x", "y", "z"}, default="y"
        For a path: the axis of the root that points up, "z" for robots.

    Returns
    -------
    Page
        In a notebook it shows itself; ``page.save("view.html")`` writes it, ``page.open()`` shows it in the browser.

    Raises
    ------
    TypeError
        If an element is neither a `Motion` nor `Keypoints`.
    ValueError
        For motions without frames or visible points, none or more than twelve motions, another number of labels, an
        alignment of other motions, and a layout without keypoints.

    See Also
    --------
    skpose.Motion.play, skpose.Keypoints.play : The player of one motion, without options.
    skpose.plot.PoseDisplay : Poses side by side with matplotlib.

    Notes
    -----
    The page has all frames of the motion: ``motion.resample(30)`` makes a smaller page. Positions are rounded to a
    65,535th of the extent of the skeleton; ``page.note`` states the largest error. A minute of 30 joints at 30 Hz is
    some 0.3 MB. The ground is at the median height of the lowest joint where it stands still, or else at the lowest
    joint of all frames.

    The player starts by itself, unless the system asks for reduced motion. Arrow keys turn the view, + and − zoom, the
    space bar plays; "Help" in the page lists all keys. Browsers since 2023 show it.

    Examples
    --------
    >>> from skpose.motions import align_motions
    >>> from skpose.datasets import make_gait
    >>> from skpose.view import player
    >>> gait = make_gait(n_subjects=1, n_sequences=2, random_state=0)
    >>> a, b = gait.motions[:2]
    >>> page = player([a, b], labels=["first", "second"], alignment=align_motions(a, b))
    >>> page.title
    'first and second'

    >>> from skpose import Skeleton, geodesic
    >>> player(geodesic([0.2, 0.3, 0.0], [2.4, 0.2, 0.1], Skeleton.chain(3))).title
    'shortest path, 7.17 m and straight line, 8.03 m'
    """
    if isinstance(motions, GeodesicResult):
        return _paths_page(motions, up, overlay, title)
    shown = _check_motions(motions)
    kinds = ["points" if isinstance(one, Keypoints) else "motion" for one in shown]
    names = check_labels(labels, [f"{kind} {i}" for i, kind in enumerate(kinds, 1)] if len(shown) > 1 else kinds)
    layout = None if layout is None else check_layout(layout)
    if layout is not None and not any(isinstance(one, Keypoints) for one in shown):
        raise ValueError("layout is for keypoints, got motions only")
    data = [
        points_data(one, name, layout) if isinstance(one, Keypoints) else motion_data(one, name)
        for one, name in zip(shown, names, strict=True)
    ]
    aligned = None if alignment is None else _alignment_data(alignment, shown)
    return page(data, aligned, overlay=overlay, title=" and ".join(names) if title is None else title)


def _paths_page(found: GeodesicResult, up: Literal["x", "y", "z"], overlay: bool, title: str | None) -> Page:
    """The page of a geodesic and the straight line between its ends, at constant speed."""
    skeleton = found._skeleton
    first, last = found.path[[0, -1]]
    straight = straight_line(skeleton.bones, first, last, FINE + 1, TWO_PI)
    if found._limited is not None:  # which do not pass half a turn
        straight[:, found._limited] = np.linspace(first, last, FINE + 1)[:, found._limited]
    length = np.linalg.norm(np.diff(weighted_positions(straight, skeleton), axis=0), axis=1).sum()
    paths = {
        f"shortest path, {found.curve_length:.3g} m": found,
        f"straight line, {length:.3g} m": replace(found, path=straight),
    }
    n = int(DURATION * FRAME_RATE) + 1
    motions = [Motion(skeleton, path.resample(n), FRAME_RATE, up=up) for path in paths.values()]
    F, G = (forward_kinematics(motion.angles, skeleton) for motion in motions)
    same = np.repeat(np.arange(n)[:, None], 2, axis=1)
    pairs = pairs_data(same, np.linalg.norm(F - G, axis=2), [range(skeleton.n_joints)] * 2)
    data = [motion_data(motion, label) for motion, label in zip(motions, paths, strict=True)]
    return page(data, pairs, overlay=overlay, title=" and ".join(paths) if title is None else title)


def page(data: list[dict[str, Any]], alignment: dict[str, Any] | None, *, overlay: bool, title: str) -> Page:
    """The page of motions as objects of JSON, see `motion_data`, `points_data` and `pairs_data`."""
    plural = "s" * (len(data) > 1)
    are_points = all("seen" in motion for motion in data)
    count = f"{len(data)} " + (f"recording{plural} of points" if are_points else f"motion{plural}")
    return page_of(
        title,
        f"{count}, positions within {max((motion['error'] for motion in data), default=0.0):.2g} mm",
        {"title": title, "motions": data, "alignment": alignment, "overlay": bool(overlay)},
        "player.html",
        ASSETS,
    )


def pairs_data(path: np.ndarray, distances: np.ndarray, columns: Sequence[Sequence[int]]) -> dict[str, Any]:
    """Data of matching frames, (n_pairs, 2), and of the distances (n_pairs, n_columns) of joints, m.

    `columns` holds for each joint of the first and of the second motion its column of the distances.
    """
    return {
        "path": pack(path, 1.0),
        "distances": pack(distances),
        "columns": [list(map(int, some)) for some in columns],
        "largest": float(distances.max()),
    }


def _check_motions(motions: Recording | Iterable[Any]) -> list[Recording]:
    shown = [motions] if isinstance(motions, Recording) else list(motions)
    if not 0 < len(shown) <= MOST:
        raise ValueError(f"motions must be 1 to {MOST}, got {len(shown)}")
    for i, motion in enumerate(shown):
        if not isinstance(motion, Recording):
            raise TypeError(f"motions must be skpose.Motion or skpose.Keypoints, got {type(motion).__name__}")
        if not len(motion) or (isinstance(motion, Keypoints) and not motion.confidences.any()):
            raise ValueError(f"motions must have frames with visible points, motions[{i}] has none")
    return shown


def _alignment_data(alignment: Alignment, motions: list[Recording]) -> dict[str, Any]:
    """Data of an alignment, which must be of these motions."""
    check_kind(alignment, Alignment, "alignment", "align_motions(a, b) finds one")
    if alignment.skeleton is None or alignment.joint_distances is None:
        raise ValueError("alignment must have a skeleton: pass Motion objects to align_motions")
    column = {name: i for i, name in enumerate(alignment.skeleton.joint_names)}
    columns = []
    for motion, poses in zip(motions, (alignment.a, alignment.b), strict=False):
        if isinstance(motion, Motion) and len(motion) == len(poses):
            columns.append([column.get(name, -1) for name in motion.skeleton.joint_names])
    if len(motions) != 2 or [sorted(some) for some in columns] != 2 * [list(range(len(column)))]:
        raise ValueError("alignment must be of the two motions: pass align_motions(*motions)")
    return pairs_data(alignment.path, alignment.joint_distances, columns)
