"""Checks of poses that must be within joint limits."""

import numpy as np

from skpose._validation.skeletons import SkeletonLike, limits_of

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
