"""Checks of positions of joints or points."""

from typing import Any

import numpy as np

from skpose._typing import ArrayLike
from skpose._validation.columns import check_names
from skpose._validation.numbers import as_numbers
from skpose._validation.skeletons import SkeletonLike


def check_position_names(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse a dataframe with some columns named after positions, but not all of them in order."""
    names = [f"{joint}_{axis}" for joint in skeleton.joint_names for axis in "xyz"]
    check_names(X, names, name, '[f"{joint}_{axis}" for joint in skeleton.joint_names for axis in "xyz"]')


def check_position_dimensions(X: ArrayLike, skeleton: SkeletonLike, name: str) -> None:
    """Refuse positions of three dimensions or more."""
    shape = np.shape(X)
    if len(shape) > 2:
        expected = f"(n_samples, {3 * skeleton.n_joints})"
        remedy = f": pass {name}.reshape(len({name}), -1)" if shape[1:] == (skeleton.n_joints, 3) else ""
        raise ValueError(f"{name} must have shape {expected}, got {shape}{remedy}")


def check_position_width(X: Any, skeleton: SkeletonLike, name: str) -> None:
    """Refuse an array that does not have three columns for each joint."""
    expected = 3 * skeleton.n_joints
    if X.shape[1] != expected:
        hint = ": leave out the root" if X.shape[1] == expected + 3 else ""
        raise ValueError(f"{name} must have {expected} columns, x, y, z of each joint, got {X.shape[1]}{hint}")


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
