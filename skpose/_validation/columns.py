"""Columns of poses: their names and number."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.skeletons import SkeletonLike

FORMS = {(3,): "rotvec", (4,): "quaternion_wxyz", (6,): "6d", (3, 3): "matrix"}  # of a rotation, by its shape


def check_column_names(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse a dataframe with some columns named after dofs, but not all of them in order.

    A dataframe without any such column is taken by position, like an array.
    """
    check_names(X, skeleton.dof_names, name, "list(skeleton.dof_names)")


def check_names(X: Any, names: Sequence[str], name: str, columns: str) -> None:
    """Refuse a dataframe that has some of the names as columns, but not all of them in order."""
    found = list(getattr(X, "columns", ()))
    if found == list(names) or not set(found) & set(names):
        return
    wrong = sorted(set(found) ^ set(names), key=str) or [a for a, b in zip(found, names, strict=False) if a != b]
    raise ValueError(
        f"columns of {name} must be those of the skeleton in order, see {wrong[0]!r}: pass {name}[{columns}]"
    )


def check_dimensions(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array of three or more dimensions."""
    shape = np.shape(X)
    if len(shape) > 2:
        hint = other_than_poses(shape, skeleton)
        raise ValueError(f"{name} must have shape (n_poses, {skeleton.n_dofs}), got {shape}{hint}")


def check_width(X: Any, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array that does not have one column for each dof."""
    if X.shape[1] != skeleton.n_dofs:
        hint = other_than_poses(X.shape, skeleton)
        raise ValueError(f"{name} has {X.shape[1]} columns, but the skeleton has {skeleton.n_dofs} dofs{hint}")


def other_than_poses(shape: Sequence[int], skeleton: SkeletonLike) -> str:
    """A hint that an array of this shape holds positions or rotations; empty if it does not."""
    sizes, n_joints = tuple(shape[1:]), skeleton.n_joints
    n_rotating = sum(bool(bone.dofs) for bone in skeleton.bones)
    if sizes[:1] == (n_rotating,) and sizes[1:] in FORMS:
        return f": for rotations use skpose.poses_from_rotations(..., form={FORMS[sizes[1:]]!r})"
    if sizes in ((3 * n_joints,), (3 * n_joints + 3,), (n_joints, 3), (n_joints + 1, 3)):
        return ": for positions use skpose.PoseFromPositions or skpose.inverse_kinematics"
    return ""
