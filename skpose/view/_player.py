"""The player: motions in one page, side by side or on top of each other, and aligned in time."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from skpose.keypoints import Keypoints, Layout
from skpose.keypoints._shared import check_layout
from skpose.motions import Alignment
from skpose.skeleton import Motion
from skpose.view._pack import pack
from skpose.view._page import Page, page_of
from skpose.view._points import points_data
from skpose.view._scene import motion_data

Recording = Motion | Keypoints

MOST = 12  # motions in one page; more would be too small to see
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
    motions: Motion | Keypoints | Iterable[Any],
    *,
    labels: Sequence[str] | None = None,
    alignment: Alignment | None = None,
    layout: Layout | str | None = None,
    overlay: bool = False,
    title: str | None = None,
) -> Page:
    """Return a page that plays motions: one HTML file, without network, to turn them and to compare them.

    Parameters
    ----------
    motions : Motion, Keypoints, or iterable of these
        One motion, or up to twelve, of any skeletons and frame rates. Of keypoints, such as markers, those that are
        seen in a frame are drawn.
    labels : sequence of str, default=None
        A name for each; None is "motion 1", "motion 2" and so on.
    alignment : Alignment, default=None
        For two motions: the frames that belong together, from ``align_motions(a, b)``. The two are then played in step,
        and colours show how far each joint is from its counterpart.
    layout : Layout or str, default=None
        The layout of keypoints, or the name of one of `skpose.keypoints.layouts`: its bones are drawn between the
        points, and its midpoints with them. None is the layout with the most points of those whose points are all
        there by their names, in any spelling; where there is none, points are drawn without bones. The help in the page
        states which one it is.
    overlay : bool, default=False
        Whether several motions start in one picture instead of side by side; a control in the page changes it.
    title : str, default=None
        Title of the page; None is the labels.

    Returns
    -------
    Page
        In a notebook it shows itself; ``page.save("view.html")`` writes it, ``page.open()`` shows it in the browser.

    Raises
    ------
    TypeError
        For what is no motion.
    ValueError
        For motions without frames, and keypoints of which none is seen, for none or more than twelve, for labels that
        are not one each, for an alignment of other motions, and for a layout without keypoints or of other ones.

    See Also
    --------
    skpose.Motion.play, skpose.Keypoints.play : The player of one motion, without options.
    geodesic_player : The shortest path between two poses and the straight line.
    skpose.plot.PoseStripDisplay : Poses side by side with matplotlib.

    Notes
    -----
    The page has each frame that the motion has: ``motion.resample(30)`` makes a smaller page. Positions are rounded to
    a 65,535th of the extent of the skeleton; by how much at most, `Page.note` and the page state. A minute of 30 joints
    at 30 Hz is some 0.3 MB. The ground is where the lowest joint stands still, in the median of such
    frames, or else at the lowest joint of all.

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
    """
    shown = _check_motions(motions)
    names = _check_labels(labels, shown)
    layout = None if layout is None else check_layout(layout)
    if layout is not None and not any(isinstance(one, Keypoints) for one in shown):
        raise ValueError("layout is for keypoints, and there are motions alone, which have bones: leave it out")
    data = [
        points_data(one, name, layout) if isinstance(one, Keypoints) else motion_data(one, name)
        for one, name in zip(shown, names, strict=True)
    ]
    aligned = None if alignment is None else _alignment_data(alignment, shown)
    return page(data, aligned, overlay=overlay, title=" and ".join(names) if title is None else title)


def page(data: list[dict[str, Any]], alignment: dict[str, Any] | None, *, overlay: bool, title: str) -> Page:
    """Return the page of motions as objects of JSON, see `motion_data`, `points_data` and `pairs_data`."""
    plural = "s" * (len(data) > 1)
    are_points = all("seen" in motion for motion in data)
    count = f"{len(data)} " + (f"recording{plural} of points" if are_points else f"motion{plural}")
    error = max((motion["error"] for motion in data), default=0.0)
    return page_of(
        title,
        f"{count}, positions within {error:.2g} mm",
        {"title": title, "motions": data, "alignment": alignment, "overlay": bool(overlay)},
        "player.html",
        ASSETS,
    )


def pairs_data(path: np.ndarray, distances: np.ndarray, columns: Sequence[Sequence[int]]) -> dict[str, Any]:
    """What a page holds of frames that belong together, (n_pairs, 2), and of the distances of their joints, m.

    `columns` are for each joint of the first and of the second motion its column of the distances.
    """
    return {
        "path": pack(path, 1.0),
        "distances": pack(distances),
        "columns": [list(map(int, some)) for some in columns],
        "largest": float(distances.max()),
    }


def _check_motions(motions: Recording | Iterable[Any]) -> list[Recording]:
    expected = "motions must be a skpose.Motion, skpose.Keypoints, or several in a list"
    if isinstance(motions, Recording):
        motions = [motions]
    if isinstance(motions, str | bytes) or not isinstance(motions, Iterable):
        hint = ": skpose.io.load_motion(path) reads a motion from a file" if isinstance(motions, str | bytes) else ""
        raise TypeError(f"{expected}, got {type(motions).__name__}{hint}")
    shown = list(motions)
    for i, motion in enumerate(shown):
        if not isinstance(motion, Recording):
            raise TypeError(
                f"{expected}, got {type(motion).__name__} as motions[{i}]: "
                "Motion(skeleton, angles, frame_rate) makes one of an array of poses"
            )
        if not len(motion):
            raise ValueError(f"motions[{i}] has no frames, and there is nothing to show: leave it out")
        if isinstance(motion, Keypoints) and not motion.confidences.any():
            raise ValueError(f"motions[{i}] has no point that is seen, and there is nothing to show: leave it out")
    if not 0 < len(shown) <= MOST:
        raise ValueError(f"a player shows 1 to {MOST} motions at once, got {len(shown)}: choose some of them")
    return shown


def _check_labels(labels: Sequence[str] | None, shown: list[Recording]) -> list[str]:
    n = len(shown)
    if labels is None:
        kinds = ["points" if isinstance(one, Keypoints) else "motion" for one in shown]
        return [f"{kind} {i}" for i, kind in enumerate(kinds, start=1)] if n > 1 else kinds
    if isinstance(labels, str) or len(labels) != n:
        got = repr(labels) if isinstance(labels, str) else f"{len(labels)} labels"
        raise ValueError(f"labels must be a list of one name for each of the {n} motions, got {got}")
    return [str(label) for label in labels]


def _alignment_data(alignment: Alignment, motions: list[Recording]) -> dict[str, Any]:
    """Return what a page holds of an alignment; refuse one of other motions."""
    if not isinstance(alignment, Alignment):
        raise TypeError(
            f"alignment must be a skpose.motions.Alignment, got {type(alignment).__name__}: align_motions(a, b) "
            "finds it"
        )
    if len(motions) != 2:
        raise ValueError(f"an alignment is one of two motions, got {len(motions)}: pass player([a, b], alignment=...)")
    if alignment.skeleton is None or alignment.joint_distances is None:
        raise ValueError(
            "the alignment has no skeleton, so that there are no joints to compare: pass the motions themselves to "
            "align_motions"
        )
    column = {name: i for i, name in enumerate(alignment.skeleton.joint_names)}
    columns = []
    for i, (motion, poses) in enumerate(zip(motions, (alignment.a, alignment.b), strict=True)):
        if not isinstance(motion, Motion):
            raise ValueError(
                f"the alignment is one of motions, and motions[{i}] is Keypoints, which have no joints: leave "
                "alignment out, or make a motion of them by fit_skeleton and inverse_kinematics"
            )
        if len(motion) != len(poses):
            raise ValueError(
                f"the alignment is not one of these motions: it has {len(poses)} frames for motions[{i}], which has "
                f"{len(motion)}: pass align_motions(motions[0], motions[1])"
            )
        if unlike := column.keys() ^ set(motion.skeleton.joint_names):
            raise ValueError(
                f"the alignment is not one of these motions: {min(unlike)!r} is a joint of only one of the alignment "
                f"and motions[{i}]: pass align_motions(motions[0], motions[1])"
            )
        columns.append([column[name] for name in motion.skeleton.joint_names])
    return pairs_data(alignment.path, alignment.joint_distances, columns)
