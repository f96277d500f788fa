"""Weights of the joints in distances: those of the bones, and defaults."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.options import check_choice
from skpose._validation.skeletons import SkeletonLike
from skpose.skeleton._bone import Bone
from skpose.skeleton._mass import mass_weights
from skpose.skeleton._selection import check_joints

ROOT = -1
SAME_PLACE = 1e-9  # m; files that print nine digits leave this much between joints in one place


def weight_bones(
    skeleton: SkeletonLike, weights: Mapping[str, float] | ArrayLike | Literal["mass"]
) -> tuple[Bone, ...]:
    """The bones of a skeleton with weights, see `Skeleton.with_weights`."""
    if isinstance(weights, str):
        check_choice("weights", weights, ("mass",))
        weights = mass_weights(skeleton)
    by_name: dict[Any, Any] = dict(weights.items()) if hasattr(weights, "items") else {}  # pandas Series have items too
    if isinstance(weights, Mapping) or any(isinstance(name, str) for name in by_name):
        check_joints(skeleton, by_name, "weights")
        given = [by_name.get(bone.name, bone.weight) for bone in skeleton.bones]
    else:
        array = np.asarray(weights)
        if array.shape != (skeleton.n_joints,):
            raise ValueError(f"weights must have shape ({skeleton.n_joints},), one per joint, got {array.shape}")
        given = list(array)
    return tuple(bone._replace(weight=weight) for bone, weight in zip(skeleton.bones, given, strict=True))


def joint_weights(skeleton: SkeletonLike) -> np.ndarray:
    """The weights (n_joints,) of the joints; joints at one point count once by default."""
    weights = np.ones(skeleton.n_joints)
    taken = set()
    for j, (bone, key) in enumerate(zip(skeleton.bones, _position_keys(skeleton), strict=True)):
        if bone.weight is not None:
            weights[j] = bone.weight
        elif key in taken:
            weights[j] = 0.0
        if weights[j] > 0.0:
            taken.add(key)
    return weights


def _position_keys(skeleton: SkeletonLike) -> list[tuple]:
    """A key for each joint, equal for joints at one point in every pose."""
    axes = [ROOT]  # of the root, then of each joint: the joint whose dofs rotate it, itself or the nearest one above
    to_axes = [np.eye(3)]  # from the joint's own axes to these
    points: list[tuple[int, np.ndarray]] = [(ROOT, np.zeros(3))]  # axes, and coordinates in them
    centres: dict[int, tuple] = {}  # the points about which axes rotate
    found: dict[int, list[np.ndarray]] = {}  # coordinates of the points in each joint's axes

    def key(point: tuple[int, np.ndarray]) -> tuple:
        frame, numbers = point
        if frame != ROOT and _is_near(numbers, np.zeros(3)):
            return centres[frame]
        known = found.setdefault(frame, [])
        number = next((i for i, one in enumerate(known) if _is_near(numbers, one)), len(known))
        if number == len(known):
            known.append(numbers)
        return frame, number

    for j, (bone, parent) in enumerate(zip(skeleton.bones, skeleton.parents + 1, strict=True)):
        axes.append(j if bone.dofs else axes[parent])
        to_axes.append(np.eye(3) if bone.dofs else to_axes[parent] @ skeleton.rest_rotations[j])
        carrier = j + 1 if skeleton.offset_frame == "own" else parent
        frame, start = axes[carrier], points[parent]
        if skeleton.offsets[j].any():
            before = start[1] if start[0] == frame else np.zeros(3)
            centres.setdefault(frame, key(start))
            points.append((frame, before + to_axes[carrier] @ skeleton.offsets[j]))
        else:
            points.append(start)
        if bone.is_slide:  # it is not always at the point of another joint
            points[-1] = j, np.zeros(3)
            centres[j] = j, -1
    return [key(point) for point in points[1:]]


def _is_near(a: np.ndarray, b: np.ndarray) -> bool:
    return bool(np.abs(a - b).max() <= SAME_PLACE)
