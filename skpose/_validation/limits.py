"""Checks of poses that must be inside the limits of their joints."""

import numpy as np

from skpose._validation.skeletons import SkeletonLike, limits_of

ROUNDING = 1e-6  # rad or m by which a pose is outside of limits that it was meant to be at: of float32, of degrees


def check_limits(poses: np.ndarray, skeleton: SkeletonLike, name: str) -> np.ndarray:
    """Return poses (n_poses, n_dofs), or one (n_dofs,), without the rounding errors by which they are outside.

    What is outside by more is refused.
    """
    lower, upper = limits_of(skeleton).T
    rows = np.atleast_2d(poses)
    excess = np.maximum(lower - rows, rows - upper)
    if excess.max(initial=0.0) > ROUNDING:
        row, dof = np.unravel_index(excess.argmax(), excess.shape)
        angle, low, high = float(rows[row, dof]), float(lower[dof]), float(upper[dof])
        count = int((excess > ROUNDING).sum())
        place = f"{name}[{row}]" if poses.ndim == 2 else name
        is_slide = [bone.is_slide for bone in skeleton.bones for _ in range(bone.n_dofs)][dof]
        shown = _metres if is_slide else _degrees
        raise ValueError(
            f'joint_limits="enforce" needs poses inside the limits of the skeleton, but in {place} '
            f"{skeleton.dof_names[dof]} is {shown(angle)}, its limits {shown(low)} and {shown(high)}"
            f"{'' if is_slide else _inside(angle, low, high)}"
            f"{f'; {count} numbers are outside in all' if count > 1 else ''}. Take the nearest pose inside, "
            f'np.clip({name}, *skeleton.limits.T), give the bone wider limits, or use joint_limits="ignore"'
        )
    return np.clip(poses, lower, upper)


def _metres(displacement: float) -> str:
    return f"{displacement:.7g} m"


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.7g}°"


def _inside(angle: float, lower: float, upper: float) -> str:
    """Return in words the angle inside limits that is the same rotation, if there is one."""
    turns = np.round((angle - np.clip(angle, lower, upper)) / (2 * np.pi))
    for same in angle - 2 * np.pi * (turns + np.arange(-1, 2)):
        if lower <= same <= upper:
            return f" ({_degrees(same)}, the same rotation, is inside)"
    return ""
