"""Checks of the argument `skeleton`."""

from typing import Any, Protocol, TypeGuard

import numpy as np

from skpose._compat.sklearn import InstanceOf


class SkeletonLike(Protocol):
    """Attributes that checks, and functions that the class itself calls, read of a skeleton."""

    @property
    def bones(self) -> tuple[Any, ...]: ...
    @property
    def joint_names(self) -> tuple[str, ...]: ...
    @property
    def dof_names(self) -> tuple[str, ...]: ...
    @property
    def n_joints(self) -> int: ...
    @property
    def n_dofs(self) -> int: ...
    @property
    def offset_frame(self) -> str: ...
    @property
    def parents(self) -> np.ndarray: ...
    @property
    def offsets(self) -> np.ndarray: ...
    @property
    def rest_rotations(self) -> np.ndarray: ...
    @property
    def weights(self) -> np.ndarray: ...
    @property
    def limits(self) -> np.ndarray | None: ...


def is_skeleton(value: object) -> TypeGuard[SkeletonLike]:
    """Return whether a value is a `Skeleton`, the one class that has names of dofs and a frame of its offsets."""
    return hasattr(type(value), "dof_names") and hasattr(type(value), "offset_frame")


def check_skeleton(skeleton: object) -> None:
    """Refuse what is no skeleton, with the skeleton to pass instead where there is one."""
    if not is_skeleton(skeleton):
        raise TypeError(f"skeleton must be a skpose.Skeleton, got {type(skeleton).__name__}{_remedy(skeleton)}")


def explain_no_skeleton(value: object) -> None:
    """Refuse a value in the place of a skeleton if there is a remedy: the check of scikit-learn has none."""
    if _remedy(value):
        check_skeleton(value)


def _remedy(value: object) -> str:
    if value is None or is_skeleton(value):
        return ""
    if "skeleton" in dir(value):  # a motion, a dataset, an ASF file
        name = type(value).__name__
        return f": pass its skeleton, {'dataset' if name == 'MotionDataset' else name.lower()}.skeleton"
    if isinstance(value, str):
        return ": skpose.io.load_motion(path).skeleton reads one from a file"
    if hasattr(value, "__array__") or isinstance(value, list | tuple):
        return ": poses come first, then the skeleton"
    return ""


def limits_of(skeleton: SkeletonLike) -> np.ndarray:
    """Return the limits (n_dofs, 2) that are to be enforced, or refuse a skeleton without any."""
    if skeleton.limits is None:
        raise ValueError(
            'joint_limits="enforce" needs a skeleton with limits, and none of its bones has any: give limits to its '
            'bones, or use joint_limits="ignore"'
        )
    return skeleton.limits


# The constraint of the parameter `skeleton` of functions and estimators, for scikit-learn's validation.
IS_SKELETON = InstanceOf(is_skeleton, "skpose.Skeleton", explain_no_skeleton)
