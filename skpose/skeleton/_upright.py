"""Along which axis of the world people stand in a motion: whether the axis that is said to point up does."""

import numpy as np

from skpose.skeleton._joint_positions import joint_positions
from skpose.skeleton._motion import Motion
from skpose.skeleton._root import root_orientations
from skpose.skeleton._stance import HIGH, LOW

N_FRAMES = 32  # that are looked at, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a pose does not stand along an axis; of a T-pose it is 0.9
N_ENDS = 4  # joints without children from which a skeleton whose names say nothing is taken for that of a person


def complaint_of_up(motion: Motion, up: str) -> str:
    """Return what speaks against an axis that points up; empty where nothing does."""
    found = find_up(motion, up)
    if found == up:
        return ""
    return (
        f"{up} is taken as the axis that points up, as is usual, but {describe_up(found)}: pass up={found!r}, "
        f"or up={up!r} if the person {'lies' if found[-1] != up else 'is upside down'}"
    )


def describe_up(found: str) -> str:
    """Return in words how the poses of a motion stand, of which `find_up` has found the direction."""
    stands = f"the head is below the feet along {found[-1]}" if len(found) > 1 else f"the pose stands along {found}"
    return f"in nearly all frames {stands}"


def find_up(motion: Motion, default: str) -> str:
    """Return the direction along which the poses of nearly all frames stand; the default where there is none."""
    frames = np.unique(np.linspace(0, len(motion) - 1, min(N_FRAMES, len(motion))).astype(int))
    names = ["", *(name.lower() for name in motion.skeleton.joint_names)]
    high, low = ([j for j, name in enumerate(names) if any(part in name for part in parts)] for parts in (HIGH, LOW))
    n_ends = len({*range(motion.skeleton.n_joints)} - {*motion.skeleton.parents.tolist()})
    if not len(frames) or not ((high and low) or n_ends >= N_ENDS):
        return default
    positions = _positions(motion, frames)
    if high and low:
        heights = positions[:, high].mean(axis=1) - positions[:, low].mean(axis=1)
    else:
        heights = np.ptp(positions, axis=1)  # the tallest axis, whichever end is up
    for i, axis in enumerate("xyz"):
        for sign in (1.0, -1.0):
            height, extent = sign * heights[:, i], np.abs(heights).max(axis=1)
            stands = (height == extent) & (extent > 0.0)
            if axis != default:
                stands &= np.abs(heights[:, "xyz".index(default)]) < FLAT * extent
            if stands.mean() >= NEARLY_ALL:
                return axis if sign > 0.0 else f"-{axis}"
    return default


def _positions(motion: Motion, frames: np.ndarray) -> np.ndarray:
    """Return the positions (n, n_joints + 1, 3) of the root and of the joints in some frames, relative to the root."""
    root = root_orientations(motion.root_angles[frames], motion.root_axes)
    return joint_positions(motion.skeleton, motion.angles[frames], root)
