"""Euler angles of rotations over time, without jumps."""

import warnings

import numpy as np
from scipy.spatial.transform import Rotation


def euler_angles(rotations: Rotation, axes: str) -> np.ndarray:
    """Return the Euler angles (n_frames, 3) of rotations about three different axes, rad, continuous in time."""
    with warnings.catch_warnings():  # of gimbal lock, where the angles are not unique; the rotation is right
        warnings.simplefilter("ignore", UserWarning)
        return continuous(rotations.as_euler(axes))


def continuous(angles: np.ndarray) -> np.ndarray:
    """Return Euler angles (n_frames, 3) of the same rotations that change least from frame to frame.

    About three different axes, (a, b, c) and its twin (a + π, π − b, c + π) are one rotation. Two twins are as far from
    each other as the two triples that they are twins of. So a frame is a twin where an odd number of frames up to it
    are nearer to their predecessor's twin than to the predecessor.
    """
    if len(angles) < 2:
        return angles
    twins = angles * [1.0, -1.0, 1.0] + np.pi
    gaps = np.stack([angles[1:] - angles[:-1], twins[1:] - angles[:-1]])
    gaps -= 2.0 * np.pi * np.rint(gaps / (2.0 * np.pi))
    stay, change = np.square(gaps).sum(axis=2)
    is_twin = np.cumsum(np.concatenate([[False], change < stay])) % 2 == 1
    return np.unwrap(np.where(is_twin[:, None], twins, angles), axis=0)
