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


def chordal_mean(bones: Sequence[Bone], poses: np.ndarray, shares: np.ndarray, near: np.ndarray) -> np.ndarray:
    """The mean of each joint under weights that sum to 1, as numbers near those of a pose.

    Rotations count by their matrices, other angles by their directions, slides by their values.
    """
    gaps = poses - near
    turns = np.arctan2(shares @ np.sin(gaps), shares @ np.cos(gaps))
    base: np.ndarray = near + np.where(are_slides(bones), shares @ gaps, turns)
    for bone, columns in with_columns(bones):
        if bone.n_dofs == 3:
            mean = rotations_of(bone, poses[:, columns]).mean(shares).as_quat()[None]
            base[columns] = columns_of(bone, Rotation.from_quat(mean), near[None, columns])[0]
    return base


def mean_of_joints(bones: Sequence[Bone], poses: np.ndarray) -> tuple[np.ndarray, bool]:
    """The pose from which the mean step to the poses is zero, and whether the iteration converged."""
    base = chordal_mean(bones, poses, np.full(len(poses), 1.0 / len(poses)), poses[0])
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
