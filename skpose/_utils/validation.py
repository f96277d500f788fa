"""Checks of arguments: one for each kind of object, called once at the public function."""

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from numbers import Integral, Real
from typing import Any, TypeAlias

import numpy as np
from sklearn.utils import check_array

from skpose._utils.typing import ArrayLike

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


def near_names(names: Sequence[str], name: str, otherwise: str = "skeleton.joint_names lists the joints") -> str:
    """A question with the names similar to an unknown one; `otherwise` if there are none."""
    lower = {one.lower(): one for one in names}
    near = [repr(lower[found]) for found in get_close_matches(name.lower(), lower)]
    return f"did you mean {' or '.join(near)}?" if near else otherwise


MOST_NAMES = 5  # in a message


def list_names(names: Iterable[str]) -> str:
    """List the first names, and the number of the others."""
    names = list(names)
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(map(repr, names[:MOST_NAMES])) + more


def as_numbers(values: Any, name: str, masked: float = np.nan) -> np.ndarray:
    """A new float64 array of real numbers; masked values become NaN or another number."""
    if np.ma.isMaskedArray(values):
        values = np.ma.filled(values.astype(np.float64), masked)
    try:
        array = np.asarray(values)
        if array.dtype.kind in "biufO":  # numpy would take times and strings for numbers
            return np.array(array, dtype=np.float64)
    except (TypeError, ValueError):
        if hasattr(type(values), "frame_numbers"):  # a Motion says itself what to pass
            raise
    raise ValueError(f"{name} must be an array of real numbers, got {type(values).__name__}")


def check_choice(name: str, value: Any, choices: tuple[str, ...]) -> None:
    """Refuse a value that is not among the choices."""
    if value not in choices:
        raise ValueError(f"{name} must be {' or '.join(map(repr, choices))}, got {value!r}")


def check_positive(name: str, value: Any) -> None:
    """Refuse a value that is not a finite number above zero."""
    if not (isinstance(value, Real) and 0.0 < float(value) < np.inf):
        raise ValueError(f"{name} must be a positive number, got {value!r}")


def check_kind(value: object, expected: type, name: str, remedy: str) -> None:
    """Refuse an instance of another class."""
    if not isinstance(value, expected):
        raise TypeError(f"{name} must be a {expected.__name__}, got {type(value).__name__}: {remedy}")


def check_integer(value: Any, least: int, name: str) -> None:
    """Refuse a value that is not an integer of at least `least`."""
    if not isinstance(value, Integral) or value < least:
        raise ValueError(f"{name} must be an integer of at least {least}, got {value!r}")


ROUNDING = 1e-6  # rad or m; float32 and degrees with a few digits leave this much


def check_limits(poses: np.ndarray, skeleton: SkeletonLike, name: str) -> np.ndarray:
    """Clip rounding errors of poses (n_poses, n_dofs), or of one (n_dofs,); refuse poses outside the limits."""
    lower, upper = limits_of(skeleton).T
    rows = np.atleast_2d(poses)
    excess = np.maximum(lower - rows, rows - upper)
    if excess.max(initial=0.0) > ROUNDING:
        row, dof = np.unravel_index(excess.argmax(), excess.shape)
        place = f"{name}[{row}]" if poses.ndim == 2 else name
        raise ValueError(
            f"{skeleton.dof_names[dof]} of {place} is {rows[row, dof]:.7g}, outside its limits {lower[dof]:.7g} to "
            f"{upper[dof]:.7g}: pass np.clip({name}, *skeleton.limits.T)"
        )
    return np.clip(poses, lower, upper)


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


def check_width(X: Any, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array that does not have one column for each dof."""
    if X.shape[1] != skeleton.n_dofs:
        is_position = X.shape[1] in (3 * skeleton.n_joints, 3 * skeleton.n_joints + 3)
        hint = ": use PoseFromPositions for positions" if is_position else ""
        raise ValueError(f"{name} has {X.shape[1]} columns, but the skeleton has {skeleton.n_dofs} dofs{hint}")


MotionLike: TypeAlias = Any  # a `Motion`, whose class is in a package above this one


def is_motion(value: object) -> bool:
    """Whether a value is a `Motion`."""
    return hasattr(type(value), "root_axes") and hasattr(type(value), "frame_numbers")


def check_frame_rate(frame_rate: Any) -> float:
    """The frame rate as a float; refuse it unless positive and finite."""
    is_number = isinstance(frame_rate, Real) or (isinstance(frame_rate, np.ndarray) and frame_rate.ndim == 0)
    if isinstance(frame_rate, bool) or not is_number or not 0.0 < frame_rate < np.inf:
        raise ValueError(f"frame_rate must be a positive number of Hz, got {frame_rate!r}")
    return float(frame_rate)


def check_positions(positions: Any, n_points: int, name: str) -> np.ndarray:
    """A new float64 array of shape (n_frames, n_points, 3); NaN marks points that are not seen."""
    array = as_numbers(positions, name)
    if array.ndim == 3 and array.shape[2] == 2:
        raise ValueError(f"{name} must have three coordinates, got shape {array.shape}: lift keypoints to 3-D first")
    if array.ndim != 3 or array.shape[1:] != (n_points, 3):
        raise ValueError(f"{name} must have shape (n_frames, {n_points}, 3), got {array.shape}")
    refuse_infinite(array, name)
    array[np.isnan(array).any(axis=2)] = np.nan
    return array


def refuse_infinite(positions: np.ndarray, name: str) -> None:
    """Refuse infinite positions (n_frames, n_points, 3)."""
    if np.isinf(positions).any():
        frame, point, _ = np.argwhere(np.isinf(positions))[0]
        raise ValueError(f"{name} are infinite at frame {frame}, point {point}: use NaN for unseen points")


def check_poses(X: ArrayLike, skeleton: SkeletonLike | None, name: str) -> np.ndarray:
    """X as an (n_poses, n_dofs) array that fits the skeleton; float32 stays, everything else becomes float64."""
    check_layout(X, skeleton, name)
    poses = check_array(X, dtype=[np.float64, np.float32], input_name=name)
    if skeleton is not None:
        check_width(poses, skeleton, name)
    return poses


def check_layout(X: Any, skeleton: SkeletonLike | None, name: str) -> None:
    """Refuse what is no array, columns in another order, and more than two dimensions."""
    check_is_array(X, name)
    if skeleton is not None:
        check_skeleton(skeleton)
        check_column_names(X, skeleton, name)
        shape = np.shape(X) if isinstance(X, list | tuple) else tuple(getattr(X, "shape", ()))
        if len(shape) > 2:
            raise ValueError(
                f"{name} must have shape (n_poses, {skeleton.n_dofs}), got {shape}: use PoseFromPositions for "
                "positions, poses_from_rotations for rotations"
            )


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
