"""What every entry point asks of an array of poses, in the user's words."""

import numpy as np
from numpy.typing import ArrayLike
from sklearn.utils import check_array

from skpose.skeleton._skeleton import Skeleton


def check_poses(X: ArrayLike, skeleton: Skeleton | None, name: str) -> np.ndarray:
    """X as an (n_poses, n_dofs) array of float32 (if it was) or float64, one column for each dof of the skeleton."""
    if skeleton is not None:
        if not isinstance(skeleton, Skeleton):
            raise TypeError(f"skeleton must be a skpose.Skeleton, got {type(skeleton).__name__}")
        check_column_names(X, skeleton, name)
    X = check_array(X, dtype=[np.float64, np.float32], input_name=name)
    if skeleton is not None:
        check_width(X, skeleton, name)
    return X


def check_pose(pose: ArrayLike, skeleton: Skeleton, name: str) -> np.ndarray:
    """One pose as an (n_dofs,) array of float64; a row of a data frame is held to its column names."""
    if hasattr(pose, "to_frame"):
        pose = pose.to_frame().T
    elif np.ndim(pose) != 1:
        raise ValueError(f"{name} must be one pose of shape ({skeleton.n_dofs},), got shape {np.shape(pose)}")
    else:
        pose = np.asarray(pose)[np.newaxis]
    return check_poses(pose, skeleton, name)[0].astype(np.float64)


def check_width(X: np.ndarray, skeleton: Skeleton, name: str) -> None:
    """Refuse an array that has not one column for each dof."""
    if X.shape[1] != skeleton.n_dofs:
        raise ValueError(
            f"{name} has {X.shape[1]} columns, but the skeleton has {skeleton.n_dofs} degrees of freedom: "
            "one column per name in skeleton.dof_names"
        )


def check_same_width(X: np.ndarray, Y: np.ndarray) -> None:
    """Refuse poses of which some have more dofs than others."""
    if X.shape[1] != Y.shape[1]:
        raise ValueError(f"X has {X.shape[1]} columns and Y has {Y.shape[1]}; poses of one body have equally many")


def check_column_names(X: ArrayLike, skeleton: Skeleton, name: str) -> None:
    """Refuse a data frame whose columns are named after dofs but are not the skeleton's, in its order.

    A frame none of whose columns has the name of a dof is taken as it stands, like an array.
    """
    columns = getattr(X, "columns", None)
    if columns is None:
        return
    columns, expected = list(columns), list(skeleton.dof_names)
    if columns == expected or not set(columns) & set(expected):
        return
    missing = [dof for dof in expected if dof not in columns]
    strange = [column for column in columns if column not in expected]
    if missing or strange:
        detail = f"missing: {_some(missing)}; not a dof of it: {_some(strange)}"
    else:
        i = next(i for i, (a, b) in enumerate(zip(columns, expected, strict=True)) if a != b)
        detail = f"column {i} is {columns[i]!r} and should be {expected[i]!r}"
    raise ValueError(
        f"the columns of {name} are named after degrees of freedom, but not the skeleton's in its order "
        f"({detail}); select them with {name}[list(skeleton.dof_names)]"
    )


def _some(names: list[str]) -> str:
    return ", ".join(map(repr, names[:3])) + (f" and {len(names) - 3} more" if len(names) > 3 else "") or "none"
