"""Interpolation, steps and means of poses: joints with three dofs rotate by the smallest angle, others linearly."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import MotionLike, SkeletonLike
from skpose.skeleton._bone import Bone, are_slides, with_columns
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of
from skpose.skeleton._skeleton import Skeleton


def interpolate_poses(
    bones: Sequence[Bone], poses: np.ndarray, at: np.ndarray, literal: np.ndarray | None = None
) -> np.ndarray:
    """Poses (n, n_dofs) at rows, not necessarily whole, of others (n_poses, n_dofs); whole rows are kept.

    The rotation of a ball joint, or of one with three Euler angles, is the slerp between two rows, as numbers near the
    row before. Other angles change linearly along their difference wrapped to [−π, π], and slides linearly.

    Some numbers may be `literal`, an array (n_dofs,) or (n_poses, n_dofs) of bool: two of these change linearly within
    their range, not exceeding it even by rounding. A joint with any literal number does not slerp.
    """
    literal = np.broadcast_to(are_slides(bones) if literal is None else are_slides(bones) | literal, poses.shape)
    start, end, part = _rows_around(poses, at)
    before, after, _ = _rows_around(literal, at)
    # Parts are less than one, so the product rounds to less than the difference, and the sum not past the end.
    between = np.where(
        before & after, interpolate_values(start, end, part, 0.0), interpolate_values(start, end, part, TWO_PI)
    )
    moved = (part[:, 0] > 0.0) & (start != end).any(axis=1)
    for bone, columns in with_columns(bones):
        if bone.n_dofs == 3 and moved.any() and not literal[:, columns].any():
            p, q = rotations_of(bone, start[moved, columns]), rotations_of(bone, end[moved, columns])
            turned = p * Rotation.from_rotvec(part[moved] * (p.inv() * q).as_rotvec())
            between[moved, columns] = columns_of(bone, turned, start[moved, columns])
    return between


def interpolate_linearly(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Values (n, k) at rows that need not be whole."""
    return interpolate_values(*_rows_around(values, at), 0.0)


def _rows_around(values: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The rows before and after, and the position in between (n, 1) from 0 to 1."""
    before = np.minimum(at.astype(np.intp), max(len(values) - 1, 0))
    return values[before], values[np.minimum(before + 1, len(values) - 1)], (at - before)[:, None]


def straight_line(
    bones: Sequence[Bone], start: np.ndarray, end: np.ndarray, n_poses: int, period: float = 0.0
) -> np.ndarray:
    """Poses on the line of "spatial": slerp of ball joints, angles linearly, wrapped if there is a period."""
    parts = np.linspace(0.0, 1.0, n_poses)
    line = interpolate_values(start, end, parts[:, None], period) if period else np.linspace(start, end, n_poses)
    line[:, are_slides(bones)] = np.linspace(start, end, n_poses)[:, are_slides(bones)]
    turned = interpolate_poses(bones, np.stack([start, end]), parts)
    is_ball = np.repeat([bone.is_ball for bone in bones], [bone.n_dofs for bone in bones])
    line[:, is_ball] = turned[:, is_ball]
    return line


def interpolate_values(start: np.ndarray, end: np.ndarray, part: np.ndarray, period: float) -> np.ndarray:
    """Values between others, their difference wrapped if there is a period."""
    gap = end - start
    return start + part * (gap - period * np.rint(gap / period) if period else gap)


# --- seen -------------------------------------------------------------------------------------------------------------
# The joints seen in each frame of a motion that was fitted to positions.


def join_seen(parts: Sequence[np.ndarray | None], lengths: Sequence[int]) -> np.ndarray | None:
    """The joints seen in consecutive motions: all in recordings of rotations; None if there are only such."""
    widths = [part.shape[1] for part in parts if part is not None]
    if not widths:
        return None
    shown = (np.ones((n, widths[0]), bool) if part is None else part for part, n in zip(parts, lengths, strict=True))
    return np.concatenate(list(shown))


def seen_of(motion: MotionLike, skeleton: SkeletonLike) -> np.ndarray | None:
    """The joints of another skeleton that were seen; those without a counterpart by name, such as a root, were not."""
    if motion.seen is None:
        return None
    columns, nowhere = dict(zip(motion.skeleton.joint_names, motion.seen.T, strict=True)), np.zeros(len(motion), bool)
    return np.stack([columns.get(name, nowhere) for name in skeleton.joint_names], axis=1)


# --- steps ------------------------------------------------------------------------------------------------------------
# Poses as steps along straight lines from a base; joints with three dofs take body rotations.
#
# A step has as many numbers as a pose. Those of a ball joint, or of one with three Euler angles, are the rotation
# vector by which the joint rotates from the base about its own axes: the slerp. Other numbers are differences of
# angles, wrapped to [−π, π], and of slides unchanged. Small steps do not depend on the order of Euler angles.


MAX_ITER = 200  # of the joint-wise mean; about five suffice unless rotations spread over half a turn
TOL = 1e-10  # mean step at which it has converged, rad


def steps_from(bones: Sequence[Bone], base: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """The steps (n_poses, n_dofs) to poses from a base (n_dofs,), or from the base of the same row."""
    base = np.atleast_2d(base)
    gaps = poses - base
    steps: np.ndarray = np.where(are_slides(bones), gaps, gaps - TWO_PI * np.rint(gaps / TWO_PI))
    for bone, columns in with_columns(bones):
        if bone.n_dofs == 3:
            at = rotations_of(bone, base[:, columns])
            steps[:, columns] = (at.inv() * rotations_of(bone, poses[:, columns])).as_rotvec()
    return steps


def move(bones: Sequence[Bone], base: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """The poses (n_poses, n_dofs) at steps from a base, or from the base of the same row, as numbers near its own."""
    base = np.atleast_2d(base)
    poses = base + steps
    for bone, columns in with_columns(bones):
        if bone.n_dofs == 3:
            turned = rotations_of(bone, base[:, columns]) * Rotation.from_rotvec(steps[:, columns])
            poses[:, columns] = columns_of(bone, turned, base[:, columns])
    return poses


def mean_of_joints(bones: Sequence[Bone], poses: np.ndarray) -> tuple[np.ndarray, bool]:
    """The pose from which the mean step to the poses is zero, and whether the iteration converged."""
    directions = np.arctan2(np.sin(poses).mean(axis=0), np.cos(poses).mean(axis=0))
    base = np.where(are_slides(bones), poses.mean(axis=0), directions)
    for bone, columns in with_columns(bones):
        if bone.n_dofs == 3:
            mean = rotations_of(bone, poses[:, columns]).mean().as_quat()[None]
            base[columns] = columns_of(bone, Rotation.from_quat(mean), poses[:1, columns])[0]
    for _ in range(MAX_ITER):
        step = steps_from(bones, base, poses).mean(axis=0)
        if np.abs(step).max(initial=0.0) <= TOL:
            return base, True
        base = move(bones, base, step[None])[0]
    return base, False


def skeleton_at(skeleton: Skeleton, base: np.ndarray) -> tuple[Skeleton, np.ndarray]:
    """A skeleton whose dofs are the numbers of steps plus a constant, and its pose equal to the base.

    Joints with three dofs become ball joints, with the rotations of the base in their rest rotations.
    """
    bones, pose = [], base.copy()
    for (bone, columns), rest in zip(with_columns(skeleton.bones), skeleton.rest_rotations, strict=True):
        if bone.n_dofs == 3:
            rest = rest @ rotations_of(bone, base[None, columns]).as_matrix()[0]
            bone = bone._replace(dofs="rotvec", rest_rotation=rest, limits=None)
            pose[columns] = 0.0
        bones.append(bone)
    return replace(skeleton, bones=tuple(bones)), pose
