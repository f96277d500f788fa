"""Checks of arrays of poses."""

from typing import Any

import numpy as np
from sklearn.utils import check_array

from skpose._typing import ArrayLike
from skpose._validation.columns import check_column_names, check_dimensions, check_width
from skpose._validation.motions import is_motion
from skpose._validation.skeletons import SkeletonLike, check_skeleton, is_skeleton


def check_poses(X: ArrayLike, skeleton: SkeletonLike | None, name: str) -> np.ndarray:
    """X as an (n_poses, n_dofs) array that fits the skeleton; float32 stays, everything else becomes float64."""
    check_is_array(X, name)
    if skeleton is not None:
        check_skeleton(skeleton)
        check_column_names(X, skeleton, name)
        check_dimensions(X, skeleton, name)
    poses = check_array(X, dtype=[np.float64, np.float32], input_name=name)
    if skeleton is not None:
        check_width(poses, skeleton, name)
    return poses


def check_pose(pose: ArrayLike, skeleton: SkeletonLike, name: str) -> np.ndarray:
    """One pose as an (n_dofs,) array of float64; it may be a pandas Series or a dataframe with one row."""
    check_is_array(pose, name)
    check_skeleton(skeleton)
    rows: Any = pose
    if hasattr(rows, "to_frame") and hasattr(rows, "index"):  # a pandas Series
        rows = rows.to_frame().T
    elif not hasattr(rows, "columns"):
        rows = np.asarray(rows)[np.newaxis]
    if len(rows) != 1 or np.ndim(rows) != 2:
        raise ValueError(f"{name} must be one pose of shape ({skeleton.n_dofs},), got shape {np.shape(pose)}")
    return check_poses(rows, skeleton, name)[0].astype(np.float64)


def check_is_array(X: Any, name: str) -> None:
    """Refuse a skeleton, a motion, a dataset, or a list of these, passed as poses."""
    first = X[0] if isinstance(X, list | tuple) and X else X
    if is_skeleton(first):
        raise TypeError(f"{name} must be an array of poses, got a {type(first).__name__}: pass it as skeleton=")
    if is_motion(first):
        raise TypeError(f"{name} must be an array of poses, got a {type(first).__name__}: pass motion.angles")
    if callable(getattr(type(first), "poses", None)):
        raise TypeError(f"{name} must be an array of poses, got a {type(first).__name__}: pass dataset.poses()[0]")


def check_same_width(X: np.ndarray, Y: np.ndarray) -> None:
    """Refuse X and Y with different numbers of columns."""
    if X.shape[1] != Y.shape[1]:
        raise ValueError(f"X has {X.shape[1]} columns and Y has {Y.shape[1]}; they must have equally many")
