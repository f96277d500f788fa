"""Checks of arrays of poses that are given by the user."""

import numpy as np
from numpy.typing import ArrayLike
from sklearn.utils import check_array

from skpose.skeleton._motion import Motion
from skpose.skeleton._skeleton import Skeleton


def check_poses(X: ArrayLike, skeleton: Skeleton | None, name: str) -> np.ndarray:
    """Return X as an (n_poses, n_dofs) array, float32 if it was and else float64, that fits the skeleton."""
    check_is_array(X, name)
    if skeleton is not None:
        if not isinstance(skeleton, Skeleton):
            raise TypeError(f"skeleton must be a skpose.Skeleton, got {type(skeleton).__name__}")
        check_column_names(X, skeleton, name)
    poses = check_array(X, dtype=[np.float64, np.float32], input_name=name)
    if skeleton is not None:
        check_width(poses, skeleton, name)
    return poses


def check_pose(pose: ArrayLike, skeleton: Skeleton, name: str) -> np.ndarray:
    """Return one pose as an (n_dofs,) array of float64; a row of a data frame is checked by its column names."""
    check_is_array(pose, name, one=True)
    if hasattr(pose, "to_frame"):  # a pandas Series
        pose = pose.to_frame().T
    elif np.ndim(pose) != 1:
        raise ValueError(f"{name} must be one pose of shape ({skeleton.n_dofs},), got shape {np.shape(pose)}")
    else:
        pose = np.asarray(pose)[np.newaxis]
    return check_poses(pose, skeleton, name)[0].astype(np.float64)


def check_is_array(X: object, name: str, *, one: bool = False) -> None:
    """Refuse a skeleton or a motion, or a list of them, where poses or one pose belong."""
    expected = f"{name} must be {'one pose' if one else 'an array of poses'}, got a "
    is_list = isinstance(X, list | tuple) and bool(X)
    first = X[0] if is_list else X  # type: ignore[index]
    if isinstance(first, Motion) and is_list:
        raise TypeError(f"{expected}{type(X).__name__} of Motions: pass the angles of one, or MotionDataset.poses()[0]")
    if isinstance(first, Motion):
        raise TypeError(f"{expected}Motion: pass {'a row of ' * one}motion.angles")
    if isinstance(first, Skeleton):
        raise TypeError(f"{expected}{'list of Skeletons' if is_list else 'Skeleton'}: pass it as skeleton=")


def check_width(X: np.ndarray, skeleton: Skeleton, name: str) -> None:
    """Refuse an array that does not have one column for each dof."""
    if X.shape[1] != skeleton.n_dofs:
        raise ValueError(
            f"{name} has {X.shape[1]} columns, but the skeleton has {skeleton.n_dofs} degrees of freedom: "
            "one column per name in skeleton.dof_names"
        )


def check_same_width(X: np.ndarray, Y: np.ndarray) -> None:
    """Refuse X and Y of different numbers of dofs."""
    if X.shape[1] != Y.shape[1]:
        raise ValueError(f"X has {X.shape[1]} columns and Y has {Y.shape[1]}; poses of one skeleton have equally many")


def check_column_names(X: ArrayLike, skeleton: Skeleton, name: str) -> None:
    """Refuse a data frame whose columns are named after dofs but are not the skeleton's, in its order.

    A data frame without any column named after a dof is taken by position, like an array.
    """
    columns = getattr(X, "columns", None)
    if columns is None:
        return
    columns, expected = list(columns), list(skeleton.dof_names)
    if columns == expected or not set(columns) & set(expected):
        return
    missing = [dof for dof in expected if dof not in columns]
    unknown = [column for column in columns if column not in expected]
    if missing or unknown:
        detail = f"missing: {_some(missing)}; not a dof of it: {_some(unknown)}"
    else:
        i = next(i for i, (a, b) in enumerate(zip(columns, expected, strict=True)) if a != b)
        detail = f"column {i} is {columns[i]!r} and should be {expected[i]!r}"
    raise ValueError(
        f"the columns of {name} are named after degrees of freedom, but not the skeleton's in its order "
        f"({detail}); select them with {name}[list(skeleton.dof_names)]"
    )


def _some(names: list[str]) -> str:
    return ", ".join(map(repr, names[:3])) + (f" and {len(names) - 3} more" if len(names) > 3 else "") or "none"
