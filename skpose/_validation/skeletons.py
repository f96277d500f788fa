"""Checks of the argument `skeleton`."""

from typing import Any, TypeAlias

import numpy as np

from skpose._compat.sklearn import InstanceOf

SkeletonLike: TypeAlias = Any  # a `Skeleton`, whose class is in a package above this one


def is_skeleton(value: object) -> bool:
    """Whether a value is a `Skeleton`."""
    return hasattr(type(value), "dof_names") and hasattr(type(value), "offset_frame")


def check_skeleton(skeleton: Any) -> None:
    """Refuse a value that is not a `Skeleton`."""
    if not is_skeleton(skeleton):
        remedy = f": pass {type(skeleton).__name__.lower()}.skeleton" if hasattr(skeleton, "skeleton") else ""
        raise TypeError(f"skeleton must be a skpose.Skeleton, got {type(skeleton).__name__}{remedy}")


def limits_of(skeleton: SkeletonLike) -> np.ndarray:
    """The limits (n_dofs, 2) to enforce."""
    if skeleton.limits is None:
        raise ValueError('joint_limits="enforce" needs a skeleton with limits: use joint_limits="ignore"')
    limits: np.ndarray = skeleton.limits
    return limits


# The constraint of the parameter `skeleton` of functions and estimators, for scikit-learn's validation.
IS_SKELETON = InstanceOf(is_skeleton, "skpose.Skeleton")
