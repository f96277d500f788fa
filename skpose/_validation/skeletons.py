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
        raise TypeError(f"skeleton must be a skpose.Skeleton, got {type(skeleton).__name__}{_remedy(skeleton)}")


def explain_no_skeleton(value: object) -> None:
    """Raise an error with the remedy if there is one; scikit-learn's own message has none."""
    if not is_skeleton(value) and _remedy(value):
        check_skeleton(value)


def _remedy(value: object) -> str:
    if value is not None and hasattr(value, "skeleton"):  # a motion, a dataset
        return f": pass {type(value).__name__.lower()}.skeleton"
    if hasattr(value, "__array__") or isinstance(value, list | tuple):
        return ": poses come first, then the skeleton"
    return ""


def limits_of(skeleton: SkeletonLike) -> np.ndarray:
    """The limits (n_dofs, 2) to enforce."""
    if skeleton.limits is None:
        raise ValueError('joint_limits="enforce" needs a skeleton with limits: use joint_limits="ignore"')
    limits: np.ndarray = skeleton.limits
    return limits


# The constraint of the parameter `skeleton` of functions and estimators, for scikit-learn's validation.
IS_SKELETON = InstanceOf(is_skeleton, "skpose.Skeleton", explain_no_skeleton)
