"""Weights of the joints in distances."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.typing import ArrayLike
from skpose._utils.upper_layers import upper_layers
from skpose._utils.validation import SkeletonLike, check_choice
from skpose.skeleton._bone import Bone
from skpose.skeleton._joint_positions import joint_positions
from skpose.skeleton._selection import check_joints

SAME_PLACE = 1e-9  # m; files that print nine digits leave this much between joints in one place


def weight_bones(
    skeleton: SkeletonLike, weights: Mapping[str, float] | ArrayLike | Literal["mass"]
) -> tuple[Bone, ...]:
    """The bones of a skeleton with weights, see `Skeleton.with_weights`."""
    if isinstance(weights, str):
        check_choice("weights", weights, ("mass",))
        weights = upper_layers.mass_weights(skeleton)
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
    """The weights (n_joints,) of the joints; joints at one point in every pose count once by default."""
    generic = np.random.default_rng(0).uniform(-1.0, 1.0, (1, skeleton.n_dofs))
    points = joint_positions(skeleton, generic, Rotation.identity(1))[0, 1:]
    weights = np.ones(skeleton.n_joints)
    for j, bone in enumerate(skeleton.bones):
        near = np.abs(points[:j] - points[j]).max(axis=1, initial=0.0) <= SAME_PLACE
        if bone.weight is not None:
            weights[j] = bone.weight
        elif (weights[:j][near] > 0.0).any():
            weights[j] = 0.0
    return weights
