"""The skeleton of a layout that fits positions of its points."""

from collections.abc import Iterable
from typing import Any, Literal

import numpy as np

from skpose._utils.typing import ArrayLike
from skpose._utils.units import SMALLEST, TALLEST, UNITS, likely_unit
from skpose._utils.warnings import warn
from skpose.keypoints._keypoints import Keypoints
from skpose.keypoints._layout import Layout
from skpose.keypoints._layouts import check_layout
from skpose.keypoints._rest_pose import Points, bone_length, partners_of, rest_pose, symmetric_lengths, warn_of_lengths
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._bone import BALL
from skpose.skeleton._rest import size_of
from skpose.skeleton._sides import sides

FAR, TURNED = 0.03, np.cos(np.radians(25.0))  # m; in recordings of people 5 mm and 7° at most
BACKWARD = -0.2  # cosine of the angle to forward


def fit_skeleton(
    keypoints: Keypoints | ArrayLike | Iterable[ArrayLike], layout: Layout, *, symmetric: bool = False
) -> Skeleton:
    r"""Fit the skeleton of a layout to positions of a person.

    Every point of the layout becomes a joint. The first is at the root, a rigid joint of length zero; points that are
    rigid in the layout have no dofs, and all others are ball joints. Offsets of ball joints are along x of their own
    axes, so that column ``NAME_rotvec_x`` is the twist of a bone about itself.

    Parameters
    ----------
    keypoints : Keypoints, array-like of shape (n_frames, n_points, 3), or iterable of such
        Positions of one person, m, or a sequence of recordings, each at its own frame rate. Points of keypoints are
        found by name, in any spelling; others are ignored. An array is in the order of ``layout.names``, with NaN if a
        point is not seen.
    layout : Layout or str
        The points and the tree of bones, or the name of one of `layouts`.
    symmetric : bool, default=False
        Whether left and right are mirror images: bones have the mean length of both sides, weighted by the frames that
        show them, and rigid points have mirrored places. Pairs are found by name, see ``layout.pairs``.

    Returns
    -------
    Skeleton
        With a joint for each of ``layout.points``.

    Raises
    ------
    ValueError
        For a point of the layout that is never seen, or never with its parent; if no frame shows the orientation of the
        root, because hips and spine are not seen at once or are on one line; if all points are in one place; for
        `symmetric`, if the layout has no pairs, or left and right differ in their parents.

    Warns
    -----
    UserWarning
        If lengths of bones change slowly by 10 % or more (standard deviation of the part common to consecutive frames),
        beyond chance. A bone from the pelvis to the neck changes by some 8 % as the back bends.
    UserWarning
        If the standard error of a length is 5 % or more: few frames, or a bone as short as the noise.
    UserWarning
        If points that are rigid with the root are 3 cm or more off in the mean, and the trunk is turned by 25° or more
        relative to them, as in few frames with noise.
    UserWarning
        If toes and nose point backward: then left and right are exchanged, or one axis is reversed.
    UserWarning
        For an array, as `Layout.keypoints`: lost points at (0, 0, 0), units of a picture, another axis up.
    UserWarning
        With `symmetric`, if left and right differ in a length by 10 % or more.
    UserWarning
        If the skeleton is not between 0.3 and 2.4 m from end to end, and has the size of a person in another unit.

    See Also
    --------
    skpose.keypoints.layouts : The layouts that come with the library.

    Notes
    -----
    *Lengths.* From distances d between the ends of a bone, weighted by the product of their confidences, without those
    more than four robust standard deviations from the median, the length is

    .. math:: L^4 = \operatorname{mean}(d^2)^2 - 1.5 \operatorname{var}(d^2),

    which is unbiased by noise that is normal and the same in all directions. The plain mean of a bone of 5 cm is 8 %
    too long with noise of 1 cm in each coordinate. Noise along one axis, such as a camera's depth, is corrected
    for bones that are several times as long.

    *Rest pose.* The root has x to the left, y up and z forward: its rigid points, with the start of the trunk at a low
    weight, are rotated onto their mean shape in all frames (generalised Procrustes analysis). The rest pose belongs to
    the layout, so that equal numbers are the same pose for all people: standing upright with bent knees and with the
    forearms held forward, as in running. That is in the middle of the range of joints, and rotation vectors jump half a
    turn from rest. It applies to bones between points with names of the library's layouts in any spelling: "left_knee",
    "LKnee". Bones between other points have the person's own mean direction in the axes of their parent. The axes of a
    bone at rest follow by the shortest rotation from forward.

    Points that are rigid with a bone or with the root are at their mean place, and show its twist if they are off its
    line, such as shoulders for the neck. The twist of other bones is not shown.

    *Missing data.* Each frame is used for the points that it shows. A single frame is enough, without correction for
    noise. Bones of length zero are kept.

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
    layout = check_layout(layout)
    if symmetric:
        _check_pairs(layout)
    points, up = _points(_recordings(keypoints, layout), layout)
    children = [(name, parent) for name in layout.points if (parent := layout.parents[name]) is not None]
    lengths, frames = {}, {}
    for name, parent in children:
        together = points.confidences[name] * points.confidences[parent]
        if not together.any():
            raise ValueError(f"{name!r} and {parent!r} are never seen in one frame: use layout.without([{name!r}])")
        frames[name] = together.sum()
        lengths[name] = bone_length(np.linalg.norm(points[name] - points[parent], axis=1), together)
    if not any(length.value > 0.0 for length in lengths.values()):
        raise ValueError("all points are in one place in all frames")
    if symmetric:
        lengths = symmetric_lengths(lengths, partners_of(layout), frames)
    rest = rest_pose(points, layout, up, symmetric)
    warn_of_lengths(lengths)
    if rest.forward and max(rest.forward.values()) < BACKWARD:  # bones that point forward in people
        warn(f"{', '.join(rest.forward)} point backward: left and right are exchanged, or an axis has the wrong sign")
    if rest.off > FAR and rest.upright and max(rest.upright.values()) < TURNED:
        angle = np.degrees(np.arccos(max(rest.upright.values())))
        warn(
            f"the pelvis does not fit: points are {1000.0 * rest.off:.0f} mm off in the mean, and the trunk is turned "
            f"by {angle:.0f}°. Less noise, or more frames, would show it"
        )
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
        size = size_of(skeleton)
        unit = likely_unit(size, 1.0)
        if not SMALLEST <= size <= TALLEST and SMALLEST <= size * UNITS[unit] <= TALLEST:
            warn(
                f"the skeleton is {size:.3g} m from end to end: if positions are in {unit}, "
                f"multiply by {UNITS[unit]:.4g}"
            )
    return skeleton


def is_of_layout(skeleton: Skeleton) -> bool:
    """Whether a skeleton has the form of a result of `fit_skeleton`, whose rest pose is a layout's.

    All of its joints that rotate have three dofs, and bones along x of their own axes, as in no mocap file.
    """
    turned = [bone for bone in skeleton.bones if bone.dofs]
    return (
        skeleton.offset_frame == "own"
        and bool(turned)
        and all(bone.n_dofs == 3 and not np.any(bone.offset[1:]) for bone in turned)
    )


def _recordings(keypoints: Any, layout: Layout) -> list[Keypoints]:
    """One or several recordings as keypoints."""
    if isinstance(keypoints, Keypoints) or hasattr(keypoints, "__array__"):
        keypoints = [keypoints]
    keypoints = list(keypoints)
    if keypoints and not isinstance(keypoints[0], Keypoints) and np.ndim(keypoints[0]) == 2:
        keypoints = [keypoints]  # nested lists
    # The frame rate of arrays has no effect.
    return [layout.keypoints(each, None if isinstance(each, Keypoints) else 1.0) for each in keypoints]


def _check_pairs(layout: Layout) -> None:
    """Refuse layouts in which the left cannot be the mirror image of the right."""
    partner = partners_of(layout)
    for name, side in zip(layout.points, sides(layout.points), strict=True):
        parent, other = layout.parents[name], layout.parents[partner[name]]
        is_alone = side and partner[name] == name
        differs = (None if parent is None else partner[parent]) != other
        if is_alone or differs or (name in layout.rigid) != (partner[name] in layout.rigid) or not layout.pairs:
            raise ValueError(f"symmetric=True needs a layout with like left and right, but {name!r} differs")


def _points(recordings: list[Keypoints], layout: Layout) -> tuple[Points, Literal["x", "y", "z"]]:
    """The points of the layout, all seen in some frame, and the axis that points up.

    A frame without points separates recordings, so that they do not follow each other in time.
    """
    if not any(map(len, recordings)):
        raise ValueError("keypoints have no frames")
    parts, up = [], recordings[0].up
    for keypoints in recordings:
        turned = np.roll(keypoints.positions, "xyz".index(up) - "xyz".index(keypoints.up), axis=2)
        parts += [
            (turned, keypoints.confidences),
            (np.full((1, *turned.shape[1:]), np.nan), np.zeros((1, turned.shape[1]))),
        ]
    positions, confidences = (np.concatenate(arrays) for arrays in zip(*parts[:-1], strict=True))
    never = [name for i, name in enumerate(layout.points) if not confidences[:, i].any()]
    if never:
        raise ValueError(f"points are never seen: {', '.join(never)}; use layout.without(...) or a layout of your own")
    points = Points(
        {name: positions[:, i] for i, name in enumerate(layout.points)},
        {name: confidences[:, i] for i, name in enumerate(layout.points)},
    )
    return points, up
