"""Checks of arrays of poses that are given by the user."""

from typing import Any

import numpy as np
from sklearn.utils import check_array

from skpose._typing import ArrayLike
from skpose._validation.columns import check_column_names, check_dimensions, check_width
from skpose._validation.motions import is_motion
from skpose._validation.skeletons import SkeletonLike, check_skeleton, is_skeleton


def check_poses(X: ArrayLike, skeleton: SkeletonLike | None, name: str) -> np.ndarray:
    """Return X as an (n_poses, n_dofs) array, float32 if it was and else float64, that fits the skeleton."""
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
    """Return one pose as an (n_dofs,) array of float64; what has names is checked by them.

    Names are those of a pandas Series, or of a data frame of one row: a polars Series has none.
    """
    check_is_array(pose, name, one=True)
    check_skeleton(skeleton)
    rows: Any = pose
    if hasattr(rows, "columns"):
        if len(rows) != 1:
            raise ValueError(f"{name} must be one pose, got a data frame of {len(rows)} rows")
    elif hasattr(rows, "to_frame") and hasattr(rows, "index"):  # a pandas Series
        rows = rows.to_frame().T
    elif np.ndim(rows) != 1:
        raise ValueError(f"{name} must be one pose of shape ({skeleton.n_dofs},), got shape {np.shape(rows)}")
    else:
        rows = np.asarray(rows)[np.newaxis]
    return check_poses(rows, skeleton, name)[0].astype(np.float64)


def check_is_array(X: object, name: str, *, one: bool = False) -> None:
    """Refuse a skeleton, a motion, a dataset, or a list of them, where poses or one pose belong."""
    expected = f"{name} must be {'one pose' if one else 'an array of poses'}, got a "
    first = X[0] if isinstance(X, list | tuple) and X else X
    is_list = first is not X
    if is_motion(first) and is_list:
        raise TypeError(f"{expected}{type(X).__name__} of Motions: pass the angles of one, or MotionDataset.poses()[0]")
    if is_motion(first):
        raise TypeError(f"{expected}Motion: pass {'a row of ' * one}motion.angles")
    if is_skeleton(first):
        raise TypeError(f"{expected}{'list of Skeletons' if is_list else 'Skeleton'}: pass it as skeleton=")
    if callable(getattr(type(first), "poses", None)):
        raise TypeError(f"{expected}{type(first).__name__}: pass {'a row of ' * one}dataset.poses()[0]")
    if callable(getattr(type(X), "collect", None)) and hasattr(type(X), "columns"):
        raise TypeError(f"{expected}{type(X).__name__}, which has no values yet: pass {name}.collect()")


def check_same_width(X: np.ndarray, Y: np.ndarray) -> None:
    """Refuse X and Y of different numbers of dofs."""
    if X.shape[1] != Y.shape[1]:
        raise ValueError(f"X has {X.shape[1]} columns and Y has {Y.shape[1]}; poses of one skeleton have equally many")
