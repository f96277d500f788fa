"""Poses as seen from a base: the steps of straight lines from it, with joints of three dofs as body rotations.

A step has as many numbers as a pose. Those of a ball joint, or of one with three Euler angles, are the rotation vector
by which the joint rotates from the base about its own axes: the slerp. Other numbers are differences of angles, wrapped
to [−π, π], and of slides as they are. Where such numbers are few, they do not depend on the order of Euler angles.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import Bone, are_slides
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of
from skpose.skeleton._skeleton import Skeleton

MAX_ITER = 200  # of the joint-wise mean; some five suffice unless rotations spread over half a turn
TOL = 1e-10  # mean step at which it has converged, rad


def steps_from(bones: Sequence[Bone], base: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return the steps (n_poses, n_dofs) from a base (n_dofs,) to poses."""
    steps = _differences(bones, base, poses)
    for bone, columns in _joints_of_three_dofs(bones):
        at = rotations_of(bone, base[None, columns])
        steps[:, columns] = (at.inv() * rotations_of(bone, poses[:, columns])).as_rotvec()
    return steps


def move(bones: Sequence[Bone], base: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the poses (n_poses, n_dofs) at steps from a base, as numbers near its own."""
    poses = base + steps
    for bone, columns in _joints_of_three_dofs(bones):
        turned = rotations_of(bone, base[None, columns]) * Rotation.from_rotvec(steps[:, columns])
        poses[:, columns] = columns_of(bone, turned, base[columns])
    return poses


def steps_between(bones: Sequence[Bone], poses: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the steps (n_poses, n_dofs) from each pose to the other of the same row."""
    steps = _differences(bones, poses, others)
    for bone, columns in _joints_of_three_dofs(bones):
        at = rotations_of(bone, poses[:, columns])
        steps[:, columns] = (at.inv() * rotations_of(bone, others[:, columns])).as_rotvec()
    return steps


def displace(bones: Sequence[Bone], poses: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return each pose moved by the step of the same row, as numbers near its own."""
    moved = poses + steps
    for bone, columns in _joints_of_three_dofs(bones):
        turned = rotations_of(bone, poses[:, columns]) * Rotation.from_rotvec(steps[:, columns])
        moved[:, columns] = columns_of(bone, turned, poses[:, columns])
    return moved


def mean_of_joints(bones: Sequence[Bone], poses: np.ndarray) -> tuple[np.ndarray, bool]:
    """Return the pose from which the mean step to the poses is zero, and whether the iteration converged to it."""
    directions = np.arctan2(np.sin(poses).mean(axis=0), np.cos(poses).mean(axis=0))
    base = np.where(are_slides(bones), poses.mean(axis=0), directions)
    for bone, columns in _joints_of_three_dofs(bones):
        mean = rotations_of(bone, poses[:, columns]).mean().as_quat()[None]
        base[columns] = columns_of(bone, Rotation.from_quat(mean), poses[:1, columns])[0]
    for _ in range(MAX_ITER):
        step = steps_from(bones, base, poses).mean(axis=0)
        if np.abs(step).max(initial=0.0) <= TOL:
            return base, True
        base = move(bones, base, step[None])[0]
    return base, False


def skeleton_at(skeleton: Skeleton, base: np.ndarray) -> tuple[Skeleton, np.ndarray]:
    """Return a skeleton whose dofs are the numbers of steps, but for a constant, and its pose that is the base.

    Joints with three dofs are ball joints there, with the rotations of the base as a part of their rest rotations.
    """
    bones, pose = list(skeleton.bones), base.copy()
    place = {bone.name: i for i, bone in enumerate(bones)}
    rests = dict(zip(skeleton.joint_names, skeleton.rest_rotations, strict=True))
    for bone, columns in _joints_of_three_dofs(skeleton.bones):
        rest = rests[bone.name] @ rotations_of(bone, base[None, columns]).as_matrix()[0]
        bones[place[bone.name]] = bone._replace(dofs="rotvec", rest_rotation=rest, limits=None)
        pose[columns] = 0.0
    return replace(skeleton, bones=tuple(bones)), pose


def _differences(bones: Sequence[Bone], poses: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return how much columns differ, angles wrapped to [−π, π]."""
    gaps = others - poses
    return np.where(are_slides(bones), gaps, gaps - TWO_PI * np.rint(gaps / TWO_PI))


def _joints_of_three_dofs(bones: Sequence[Bone]) -> Iterator[tuple[Bone, slice]]:
    """Yield the joints with three dofs and their columns."""
    first = 0
    for bone in bones:
        if bone.n_dofs == 3:
            yield bone, slice(first, first + 3)
        first += bone.n_dofs
