"""The skeleton of a layout that fits positions of its points."""

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.units import LARGEST, SMALLEST, UNITS, likely_unit
from skpose._warnings import warn
from skpose.keypoints._keypoints import Keypoints
from skpose.keypoints._layout import Layout
from skpose.keypoints._layouts import layouts
from skpose.keypoints._lengths import bone_length, warn_of_lengths
from skpose.keypoints._rest_pose import rest_rotations
from skpose.keypoints._root_axes import Points
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._shared import BALL, size_of


def fit_skeleton(keypoints: Keypoints | ArrayLike, layout: Layout) -> Skeleton:
    r"""Return the skeleton of a layout that fits positions: lengths of bones, and a rest pose in the middle of them.

    Every point of the layout is a joint of the skeleton. The first is the root's, a rigid joint of length zero; those
    that are rigid in the layout have no dofs, and all others are ball joints. Offsets are in the joints' own axes and
    along x, so that column ``NAME_rotvec_x`` is the twist of a bone about itself.

    Parameters
    ----------
    keypoints : Keypoints or array-like of shape (n_frames, n_points, 3)
        Positions of one person, m. Of keypoints the points are found by name, others are ignored; an array is in the
        order of ``layout.names``, with NaN where a point is not seen.
    layout : Layout
        The points and the tree of bones, such as ``layouts["coco17"]``.

    Returns
    -------
    Skeleton
        With a joint for each of ``layout.points``.

    Raises
    ------
    ValueError
        For a point of the layout that is never seen, or never with its parent; if no frame shows how the root is
        turned, as hips and spine are not seen at once or are on one line; if all points are in one place.
    TypeError
        For what is no layout.

    Warns
    -----
    UserWarning
        If bones stretch: if their lengths change slowly, by 10 % and more, beyond what noise can do by chance. Noise
        differs from frame to frame, and what lasts from one frame to the next is a change of the bone, so that frames
        in another order than that of time do not show it. The spread in % is the standard deviation of the slow part.
        As a back bends, a bone from the pelvis to the neck changes by some 8 %.
    UserWarning
        If the standard error of a length is 5 % and more: few frames, or a bone as short as the noise.
    UserWarning
        If the skeleton is not between 0.3 and 5 m from end to end, and has the size of a person in another unit.

    See Also
    --------
    skpose.keypoints.layouts : The layouts that come with the library.

    Notes
    -----
    *Lengths.* Of each bone, in the frames in which both ends are seen, with the product of their confidences as the
    weight: lengths of more than four robust standard deviations from the median are left out. Of the others,

    .. math:: L^4 = \operatorname{mean}(d^2)^2 - 1.5 \operatorname{var}(d^2),

    which is free of the bias by noise at the ends if that is normal and the same in all directions, for all lengths.
    The plain mean of a bone of 5 cm is 8 % too long where each coordinate has noise of 1 cm. Noise along one axis
    alone, such as that of a camera's depth, is corrected for bones that are several times as long as it.

    *Rest pose.* The root has x to the left, y up and z forward: its rigid points, with the start of the trunk, are
    turned onto their mean shape in all frames (generalised Procrustes analysis); the start of the trunk counts little,
    and says how the root is rotated about the line of the hips. At rest each bone has its mean direction in the axes of
    its parent, so that rotation vectors spread about zero. Three points at least say how a bone is twisted: where
    points are rigid with it, such as shoulders with the neck, its twist is turned onto their mean shape, with the mean
    at zero. Elsewhere nothing shows the twist, and the axes are those of the shortest rotation from the rest pose,
    without twist. Across the bone, axes at rest are those of the parent after the shortest rotation between both bones.

    *Missing and few data.* Frames count for what they show; frames without a single point count for nothing. A single
    frame is enough: it is the rest pose, and there is no correction for noise. Bones of length zero are kept.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose.keypoints import Layout, fit_skeleton
    >>> arm = Layout(
    ...     "arm",
    ...     names=["shoulder", "elbow", "wrist"],
    ...     parents={"shoulder": None, "elbow": "shoulder", "wrist": "elbow"},
    ... )
    >>> skeleton = fit_skeleton([[[0.0, 1.4, 0.0], [0.0, 1.1, 0.0], [0.25, 1.1, 0.0]]], arm)
    >>> np.linalg.norm(skeleton.offsets, axis=1).round(2)
    array([0.  , 0.3 , 0.25])
    >>> skeleton.dof_names
    ('elbow_rotvec_x', 'elbow_rotvec_y', 'elbow_rotvec_z', 'wrist_rotvec_x', 'wrist_rotvec_y', 'wrist_rotvec_z')
    """
    if not isinstance(layout, Layout):
        remedy = ": pass one of skpose.keypoints.layouts, or a Layout of your own"
        if isinstance(layout, str) and layout in layouts:
            remedy = f": pass skpose.keypoints.layouts[{layout!r}]"
        raise TypeError(f"layout must be a skpose.keypoints.Layout, got {type(layout).__name__}{remedy}")
    if not isinstance(keypoints, Keypoints):
        keypoints = layout.keypoints(keypoints, frame_rate=1.0)  # the rate plays no part
    points = _points(keypoints, layout)
    children = [(name, parent) for name in layout.points if (parent := layout.parents[name]) is not None]
    lengths = {}
    for name, parent in children:
        together = points.confidences[name] * points.confidences[parent]
        if not together.any():
            raise ValueError(
                f"{name!r} and its parent {parent!r} are never seen in one frame, so that there is no length between "
                f"them: pass layout.without([{name!r}]), or frames that show both"
            )
        lengths[name] = bone_length(np.linalg.norm(points[name] - points[parent], axis=1), together)
    if not any(length.value > 0.0 for length in lengths.values()):
        raise ValueError("all points are in one place in all frames, so that there is no skeleton")
    rests = rest_rotations(points, layout, keypoints.up)
    warn_of_lengths(lengths)
    bones = [Bone(layout.root, None, (0.0, 0.0, 0.0))]
    for name, parent in children:
        dofs = "" if name in layout.rigid else BALL
        bones.append(Bone(name, parent, (lengths[name].value, 0.0, 0.0), dofs, rests[name]))
    skeleton = Skeleton(bones)
    if layout.pairs:  # a hand or an arm has not the size of a person
        _warn_of_size(skeleton)
    return skeleton


def _points(keypoints: Keypoints, layout: Layout) -> Points:
    """Return the points of the layout, all of which are seen in some frame."""
    made = [name for name in layout.midpoints if name not in keypoints.names]
    missing = [name for name in layout.points if name not in keypoints.names and name not in made]
    if missing:
        raise ValueError(
            f"the keypoints have no point named {missing[0]!r}, as the layout {layout.name!r} has; their names are "
            f"{', '.join(keypoints.names)}. Pass the layout that they are of, or layout.without([{missing[0]!r}])"
        )
    if made:
        raise ValueError(
            f"the keypoints have no {' and no '.join(map(repr, made))}, which the layout {layout.name!r} makes of "
            "other points: make the keypoints with layout.keypoints(positions, frame_rate)"
        )
    if not len(keypoints):
        raise ValueError("keypoints have no frames, and there is nothing to fit a skeleton to")
    chosen = keypoints.select(layout.points)
    points = Points(
        {name: chosen.positions[:, i] for i, name in enumerate(layout.points)},
        {name: chosen.confidences[:, i] for i, name in enumerate(layout.points)},
    )
    never = [name for name in layout.points if not points.confidences[name].any()]
    if len(never) == len(layout.points):
        raise ValueError("no point is seen in any frame: positions are NaN, or confidences 0, everywhere")
    if never:
        remedy = f"fit the layout without what is never seen, layout.without({never})"
        needed = {layout.root, *layout.midpoints, *(end for ends in layout.midpoints.values() for end in ends)}
        if needed & set(never):
            remedy = "make a Layout of your own of the points that are seen"
        raise ValueError(f"never seen in {len(chosen)} frames: {', '.join(map(repr, never))}; {remedy}")
    return points


def _warn_of_size(skeleton: Skeleton) -> None:
    """Warn if the skeleton has the size of a person in another unit than metres."""
    size = size_of(skeleton)
    unit = likely_unit(size)
    if SMALLEST <= size <= LARGEST or unit == "metres":
        return
    factor = UNITS[unit]
    warn(
        f"the skeleton is {size:.3g} m from end to end at rest, and people are between {SMALLEST} and {LARGEST:g} m: "
        f"if positions are in {unit}, pass {factor:.4g} * positions, which makes that {size * factor:.3g} m"
    )
