"""The skeleton of a layout that fits positions of its points."""

from collections.abc import Iterable, Mapping
from typing import Any, Literal

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.units import LARGEST, SMALLEST, UNITS, likely_unit
from skpose._warnings import warn
from skpose.keypoints._keypoints import Keypoints
from skpose.keypoints._layout import Layout
from skpose.keypoints._layouts import layouts
from skpose.keypoints._lengths import bone_length, symmetric_lengths, warn_of_lengths
from skpose.keypoints._rest_pose import partners_of, rest_pose
from skpose.keypoints._root_axes import Points
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._shared import BALL, sides, size_of

BACKWARD = -0.2  # cosine of the angle to forward


def fit_skeleton(
    keypoints: Keypoints | ArrayLike | Iterable[ArrayLike], layout: Layout, *, symmetric: bool = False
) -> Skeleton:
    r"""Return the skeleton of a layout that fits positions of a person: lengths of bones, and the layout's rest pose.

    Every point of the layout is a joint of the skeleton. The first is the root's, a rigid joint of length zero; those
    that are rigid in the layout have no dofs, and all others are ball joints. Offsets of ball joints are in their own
    axes and along x, so that column ``NAME_rotvec_x`` is the twist of a bone about itself.

    Parameters
    ----------
    keypoints : Keypoints, array-like of shape (n_frames, n_points, 3), or iterable of such
        Positions of one person, m; several recordings in a list or the like, each at its own frame rate. Of keypoints
        the points are found by name, others are ignored; an array is in the order of ``layout.names``, with NaN where a
        point is not seen.
    layout : Layout
        The points and the tree of bones, such as ``layouts["coco17"]``.
    symmetric : bool, default=False
        Whether left and right are mirror images: bones of one length, the mean of both sides by the frames that show
        them, and rigid points in mirrored places. Pairs are found by name, see ``layout.pairs``.

    Returns
    -------
    Skeleton
        With a joint for each of ``layout.points``.

    Raises
    ------
    ValueError
        For a point of the layout that is never seen, or never with its parent; if no frame shows how the root is
        turned, as hips and spine are not seen at once or are on one line; if all points are in one place; for
        `symmetric`, if the layout has no pairs, or left and right differ in what they are attached to.
    TypeError
        For what is no layout, and a mapping of recordings: pass its values.

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
        If toes and nose point backward: then left and right are exchanged, or one axis is reversed.
    UserWarning
        Of an array, for which `Layout.keypoints` warns: lost points at (0, 0, 0), units of a picture, another axis up.
    UserWarning
        With `symmetric`, if left and right differ in a length by 10 % and more.
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
    and says how the root is rotated about the line of the hips. The rest pose is one of the layout, so that equal
    numbers are the same pose of all people who are fitted to it: a person stands upright, with bent knees and with the
    forearms held forward, as in running. That is in the middle of what joints can do, and rotation vectors jump half a
    turn from rest. So stand all bones between points that have the names of the library's layouts, however they are
    written: "left_knee", "LKnee". Bones between other points have their mean direction in the axes of their parent,
    which is the person's own. The axes of a bone at rest are those of the shortest rotation from forward.

    Points that are rigid with a bone or with the root have the place where they are in the mean. Three points at least
    say how a bone is twisted: where points are rigid with it, such as shoulders with the neck, its twist is turned onto
    their mean shape, with those of the left to the left at rest. Elsewhere nothing shows the twist.

    *Missing and few data.* Frames count for what they show; frames without a single point count for nothing. A single
    frame is enough; there is no correction for noise. Bones of length zero are kept.

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
    if symmetric:
        _check_pairs(layout)
    points, up = _points(_recordings(keypoints, layout), layout)
    children = [(name, parent) for name in layout.points if (parent := layout.parents[name]) is not None]
    lengths, frames = {}, {}
    for name, parent in children:
        together = points.confidences[name] * points.confidences[parent]
        if not together.any():
            raise ValueError(
                f"{name!r} and its parent {parent!r} are never seen in one frame, so that there is no length between "
                f"them: pass layout.without([{name!r}]), or frames that show both"
            )
        frames[name] = together.sum()
        lengths[name] = bone_length(np.linalg.norm(points[name] - points[parent], axis=1), together)
    if not any(length.value > 0.0 for length in lengths.values()):
        raise ValueError("all points are in one place in all frames, so that there is no skeleton")
    if symmetric:
        lengths = symmetric_lengths(lengths, partners_of(layout), frames)
    rest = rest_pose(points, layout, up, symmetric)
    warn_of_lengths(lengths)
    _warn_of_mirror(rest.forward)
    bones = [Bone(layout.root, None, (0.0, 0.0, 0.0))]
    for name, parent in children:
        length = lengths[name].value
        if name in layout.rigid:
            direction = rest.directions.get(name, np.zeros(3))
            bones.append(Bone(name, parent, length * (rest.axes[parent].T @ direction)))
        else:
            bones.append(Bone(name, parent, (length, 0.0, 0.0), BALL, rest.axes[parent].T @ rest.axes[name]))
    skeleton = Skeleton(bones)
    if layout.pairs:  # a hand or an arm has not the size of a person
        _warn_of_size(skeleton)
    return skeleton


def is_of_layout(skeleton: Skeleton) -> bool:
    """Return whether a skeleton has the form of those of `fit_skeleton`, whose rest pose is a layout's.

    All of its bones that rotate have three dofs, and are along x of their own axes, as in no file of a mocap system.
    """
    turned = [bone for bone in skeleton.bones if bone.dofs]
    return (
        skeleton.offset_frame == "own"
        and bool(turned)
        and all(bone.n_dofs == 3 and not np.any(bone.offset[1:]) for bone in turned)
    )


def _recordings(keypoints: Any, layout: Layout) -> list[Keypoints]:
    """Return the recordings, one or several, as keypoints."""
    if isinstance(keypoints, Mapping):
        raise TypeError(
            f"keypoints must be one recording or a sequence of them, got {type(keypoints).__name__}, a mapping: pass "
            "list(mapping.values())"
        )
    one = isinstance(keypoints, Keypoints) or not isinstance(keypoints, Iterable) or hasattr(keypoints, "__array__")
    if not one:
        keypoints = list(keypoints)
        if keypoints:
            one = not isinstance(keypoints[0], Keypoints) and np.ndim(keypoints[0]) != 3
    recordings = []
    for i, each in enumerate([keypoints] if one else keypoints):
        if not isinstance(each, Keypoints):
            try:
                each = layout.keypoints(each, frame_rate=1.0)  # the rate plays no part
            except ValueError as error:
                raise ValueError(f"keypoints[{i}]: {error}" if not one else str(error)) from None
        recordings.append(each)
    return recordings


def _check_pairs(layout: Layout) -> None:
    """Refuse layouts in which the left cannot be the mirror image of the right."""
    partner = partners_of(layout)
    if not layout.pairs:
        raise ValueError(
            f"the layout {layout.name!r} has no left and right by name, such as 'left_hip' and 'right_hip', and cannot "
            "be symmetric: pass symmetric=False, or a Layout with such names"
        )
    alone = [name for name, side in zip(layout.points, sides(layout.points), strict=True) if side]
    alone = [name for name in alone if partner[name] == name]
    if alone:
        raise ValueError(
            f"left and right of the layout {layout.name!r} differ: {', '.join(map(repr, alone))} have no partner on "
            f"the other side. Pass symmetric=False, or layout.without({alone})"
        )
    for name in layout.points:
        parent, other = layout.parents[name], layout.parents[partner[name]]
        if (None if parent is None else partner[parent]) != other:
            raise ValueError(
                f"left and right of the layout {layout.name!r} differ: {name!r} is attached to {parent!r} and "
                f"{partner[name]!r} to {other!r}. Pass symmetric=False, or a Layout in which they are equal"
            )
        if (name in layout.rigid) != (partner[name] in layout.rigid):
            raise ValueError(
                f"left and right of the layout {layout.name!r} differ: of {name!r} and {partner[name]!r} one is rigid. "
                "Pass symmetric=False, or a Layout in which they are equal"
            )


def _points(recordings: list[Keypoints], layout: Layout) -> tuple[Points, Literal["x", "y", "z"]]:
    """Return the points of the layout, all of which are seen in some frame, and the axis that points up.

    A frame without a point is between one recording and the next, so that they do not follow each other in time.
    """
    parts, up = [], recordings[0].up if recordings else "y"
    for i, keypoints in enumerate(recordings):
        _check_names(keypoints, layout, f"keypoints[{i}] have" if len(recordings) > 1 else "the keypoints have")
        chosen = keypoints.select(layout.points)
        turned = np.roll(chosen.positions, "xyz".index(up) - "xyz".index(keypoints.up), axis=2)
        parts += [
            (turned, chosen.confidences),
            (np.full((1, *turned.shape[1:]), np.nan), np.zeros((1, turned.shape[1]))),
        ]
    if not any(map(len, recordings)):
        raise ValueError("keypoints have no frames, and there is nothing to fit a skeleton to")
    positions, confidences = (np.concatenate(arrays) for arrays in zip(*parts[:-1], strict=True))
    points = Points(
        {name: positions[:, i] for i, name in enumerate(layout.points)},
        {name: confidences[:, i] for i, name in enumerate(layout.points)},
    )
    never = [name for name in layout.points if not points.confidences[name].any()]
    if len(never) == len(layout.points):
        raise ValueError("no point is seen in any frame: positions are NaN, or confidences 0, everywhere")
    if never:
        remedy = f"fit the layout without what is never seen, layout.without({never})"
        needed = {layout.root, *layout.midpoints, *(end for ends in layout.midpoints.values() for end in ends)}
        if needed & set(never):
            remedy = "make a Layout of your own of the points that are seen"
        n = sum(map(len, recordings))
        raise ValueError(f"never seen in {n} frames: {', '.join(map(repr, never))}; {remedy}")
    return points, up


def _check_names(keypoints: Keypoints, layout: Layout, subject: str) -> None:
    """Refuse keypoints without a point of the layout."""
    made = [name for name in layout.midpoints if name not in keypoints.names]
    missing = [name for name in layout.points if name not in keypoints.names and name not in made]
    if missing:
        raise ValueError(
            f"{subject} no point named {missing[0]!r}, as the layout {layout.name!r} has; their names are "
            f"{', '.join(keypoints.names)}. Pass the layout that they are of, or layout.without([{missing[0]!r}])"
        )
    if made:
        raise ValueError(
            f"{subject} no {' and no '.join(map(repr, made))}, which the layout {layout.name!r} makes of "
            "other points: make the keypoints with layout.keypoints(positions, frame_rate)"
        )


def _warn_of_mirror(forward: dict[str, float]) -> None:
    """Warn if all that points forward in people points backward."""
    if forward and max(forward.values()) < BACKWARD:
        warn(
            f"{', '.join(forward)} point backward, where those of people point forward: left and right are exchanged, "
            "or the positions are a mirror image. Exchange the names of the left and of the right, or pass "
            "positions * [-1, 1, 1] if one of the axes is reversed"
        )


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
