"""Checks of positions of joints or points, in rows like poses or as arrays of three dimensions."""

from typing import Any

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.columns import check_names, shape_of
from skpose._validation.numbers import as_numbers
from skpose._validation.skeletons import SkeletonLike


def check_position_names(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse a data frame whose columns are named after positions but are not the skeleton's, in its order."""
    names = [f"{joint}_{axis}" for joint in skeleton.joint_names for axis in "xyz"]
    remedy = f'{name}[[f"{{joint}}_{{axis}}" for joint in skeleton.joint_names for axis in "xyz"]]'
    check_names(X, names, name, "positions of joints", "a position of it", remedy)


def check_position_dimensions(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array of positions that is not two-dimensional, with the remedy."""
    shape = shape_of(X)
    if len(shape) < 3:
        return
    likely = f": pass {name}.reshape(len({name}), -1)" if shape[1:] == (skeleton.n_joints, 3) else ""
    if shape[2] == 2:
        likely = ": positions in two dimensions do not say how a pose is, lift them to 3-D first"
    raise ValueError(
        f"{name} must have shape (n_samples, {3 * skeleton.n_joints}), x, y and z of each joint in "
        f"skeleton.joint_names, got {shape}{likely}"
    )


def check_position_width(X: Any, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array that does not have three columns for each joint."""
    n_joints, width = skeleton.n_joints, X.shape[1]
    if width == 3 * n_joints:
        return
    likely = ""
    if width == 3 * n_joints + 3:
        likely = ". Are these positions with the root? It is not among the joints: leave it out"
    elif width == 2 * n_joints:
        likely = ". Are these positions in two dimensions? Lift them to 3-D first: lengths of bones are not known from "
        likely += "a picture"
    elif width == skeleton.n_dofs:
        likely = ". Are these poses? Then this step is not needed"
    raise ValueError(
        f"{name} has {width} columns, but the skeleton has {n_joints} joints: x, y and z of each in "
        f"skeleton.joint_names, {3 * n_joints} columns{likely}"
    )


def check_positions(positions: Any, n_points: int, name: str) -> np.ndarray:
    """Return positions as a new float64 array of shape (n_frames, n_points, 3), NaN for points that are not seen."""
    array = as_numbers(positions, name)
    if array.ndim == 3 and array.shape[2] == 2:
        raise ValueError(
            f"{name} have two coordinates for each point, shape {array.shape}, but three are needed: lengths of bones "
            "are not known from a picture. Lift them to 3-D first, by a pose estimator that gives 3-D keypoints or by "
            "several cameras"
        )
    if array.ndim != 3 or array.shape[1:] != (n_points, 3):
        remedy = f": pass {name}[None] for one frame" if array.shape == (n_points, 3) else ""
        raise ValueError(f"{name} must have shape (n_frames, {n_points}, 3), got {array.shape}{remedy}")
    refuse_infinite(array, name)
    array[np.isnan(array).any(axis=2)] = np.nan
    return array


def refuse_infinite(positions: np.ndarray, name: str) -> None:
    """Refuse positions (n_frames, n_points, 3) of which one is infinite."""
    if np.isinf(positions).any():
        frame, point, _ = np.argwhere(np.isinf(positions))[0]
        raise ValueError(f"{name} are infinite at frame {frame}, point {point}: use NaN for a point that is not seen")
