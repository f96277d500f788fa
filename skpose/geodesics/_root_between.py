"""The root between key poses: positions linearly or by a cubic spline, orientations by slerp or a rotation spline."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import RotationSpline, Slerp

from skpose.skeleton import Motion
from skpose.skeleton._root import continuous_root_angles, root_orientations


def root_between(keys: Motion, at: np.ndarray, times: np.ndarray, method: str) -> tuple[np.ndarray, np.ndarray, str]:
    """Positions (n, 3), angles (n, k) and axes of the root at some times; `at` are the times of the keys."""
    orientations = root_orientations(keys.root_angles, keys.root_axes)
    if method == "spline":
        positions = CubicSpline(at, keys.root_positions, bc_type="natural")(times)
        between = RotationSpline(at, orientations)(times)
    else:
        positions = np.stack([np.interp(times, at, values) for values in keys.root_positions.T], axis=1)
        between = Slerp(at, orientations)(times)
    return positions, *continuous_root_angles(between, keys.root_axes)
