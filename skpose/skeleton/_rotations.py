"""The rotation of a joint as numbers: the columns of a pose that belong to it."""

import warnings

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import Bone

TWO_PI = 2.0 * np.pi


def rotations_of(bone: Bone, columns: np.ndarray) -> Rotation:
    """Return the rotations (n,) of a joint from its columns (n, n_dofs), without the rest rotation."""
    if bone.is_ball:
        return Rotation.from_rotvec(columns)
    return Rotation.from_euler(bone.dofs, columns)


def columns_of(bone: Bone, rotations: Rotation, near: np.ndarray) -> np.ndarray:
    """Return the columns (n, 3) of a joint with three dofs.

    Of the numbers that are one rotation, they are those nearest to others, of shape (n, 3) or (3,).
    """
    if bone.is_ball:
        return nearest_vectors(rotations.as_rotvec(), near)
    with warnings.catch_warnings():  # of gimbal lock, where the numbers are not unique; the rotation is right
        warnings.simplefilter("ignore", UserWarning)
        angles = rotations.as_euler(bone.dofs)
    return nearest_angles(angles, near)


def nearest_vectors(vectors: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Add whole turns to rotation vectors (n, 3), so that they come nearest to others."""
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    axis = vectors / np.where(size > 0.0, size, 1.0)
    turns = np.rint(((axis * near).sum(axis=-1, keepdims=True) - size) / TWO_PI)
    return vectors + turns * TWO_PI * axis


def nearest_angles(angles: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Return those Euler triples (n, 3) of the same rotations that are nearest to others.

    About three different axes, (a, b, c) and (a + π, π − b, c + π) are one rotation.
    """
    twins = np.stack([angles, angles * [1.0, -1.0, 1.0] + np.pi])
    twins -= TWO_PI * np.rint((twins - near) / TWO_PI)
    second_is_nearer = np.subtract(*np.square(twins - near).sum(axis=-1)) > 0.0
    return np.where(second_is_nearer[..., None], twins[1], twins[0])
