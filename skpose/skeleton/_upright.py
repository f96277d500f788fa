"""The axis of the world along which people stand in a motion, to check the one that is said to point up."""

import numpy as np

from skpose.skeleton._joint_positions import joint_positions
from skpose.skeleton._motion import Motion
from skpose.skeleton._root import root_orientations
from skpose.skeleton._stance import high_and_low

N_FRAMES = 32  # checked, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a pose does not stand along an axis; 0.9 in a T-pose
N_ENDS = 4  # joints without children from which a skeleton with unknown names is taken for a person's


def complaint_of_up(motion: Motion, up: str) -> str:
    """The warning about an axis that does not point up; empty if it does."""
    found = find_up(motion, up)
    if found == up:
        return ""
    return f"{up} is taken as up, but {describe_up(found)}: pass up={found!r}, or up={up!r} if this is intended"


def describe_up(found: str) -> str:
    """The direction of `find_up` as a clause."""
    stands = f"the head is below the feet along {found[-1]}" if len(found) > 1 else f"the pose stands along {found}"
    return f"in nearly all frames {stands}"


def find_up(motion: Motion, default: str) -> str:
    """The direction along which the poses of nearly all frames stand; the default if there is none."""
    frames = np.unique(np.linspace(0, len(motion) - 1, min(N_FRAMES, len(motion))).astype(int))
    skeleton = motion.skeleton
    high, low = high_and_low(["", *skeleton.joint_names])
    n_ends = len({*range(skeleton.n_joints)} - {*skeleton.parents.tolist()})
    if not len(frames) or not ((high and low) or n_ends >= N_ENDS):
        return default
    root = root_orientations(motion.root_angles[frames], motion.root_axes)
    positions = joint_positions(skeleton, motion.angles[frames], root)
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
