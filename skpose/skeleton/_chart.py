"""Poses as steps along straight lines from a base; joints with three dofs take body rotations.

A step has as many numbers as a pose. Those of a ball joint, or of one with three Euler angles, are the rotation vector
by which the joint rotates from the base about its own axes: the slerp. Other numbers are differences of angles, wrapped
to [−π, π], and of slides unchanged. Small steps do not depend on the order of Euler angles.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import Bone, are_slides, with_columns
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of
from skpose.skeleton._skeleton import Skeleton

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


def mean_of_joints(
    bones: Sequence[Bone], poses: np.ndarray, weights: np.ndarray | None = None
) -> tuple[np.ndarray, bool]:
    """The pose from which the mean step to the poses is zero, and whether the iteration converged."""
    shares = np.full(len(poses), 1.0 / len(poses)) if weights is None else weights
    directions = np.arctan2(shares @ np.sin(poses), shares @ np.cos(poses))
    base = np.where(are_slides(bones), shares @ poses, directions)
    for bone, columns in with_columns(bones):
        if bone.n_dofs == 3:
            mean = rotations_of(bone, poses[:, columns]).mean(weights).as_quat()[None]
            base[columns] = columns_of(bone, Rotation.from_quat(mean), poses[:1, columns])[0]
    for _ in range(MAX_ITER):
        step = shares @ steps_from(bones, base, poses)
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
