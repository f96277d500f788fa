"""The direction in which people stand, by the names of joints: heads are above feet."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import MotionLike, SkeletonLike
from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._root import root_orientations
from skpose.skeleton._rotations import joint_positions

# Parts of the names of points on the head, the neck and the shoulders, and of those on ankles and feet.
HIGH = "head", "hd", "nose", "neck", "c7", "clav", "acr", "shoulder"
LOW = "foot", "toe", "heel", "hee", "ank", "mal", "cal"
NEAR = 0.8  # cosine of the angle to an axis up to which a skeleton stands along it
N_FRAMES = 32  # checked, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a pose does not stand along an axis; 0.9 in a T-pose
N_ENDS = 4  # joints without children from which a skeleton with unknown names is taken for a person's


def high_and_low(names: list[str]) -> tuple[list[int], list[int]]:
    """The indices of names of points high on a person, and of points low on a person."""
    high, low = (
        [i for i, name in enumerate(names) if any(part in name.lower() for part in parts)] for parts in (HIGH, LOW)
    )
    return high, low


def axes_with_up_last(up: str) -> list[int]:
    """The axes of the world in a cycle that ends with the one that points up."""
    i = "xyz".index(up)
    return [(i + 1) % 3, (i + 2) % 3, i]


def upright_turn(skeleton: SkeletonLike, up: str) -> Rotation:
    """The quarter or half turn of the world after which a skeleton at angle zero stands along an axis.

    The identity if the skeleton already stands so, along no axis, or if its names do not show how it stands.
    """
    high, low = high_and_low(list(skeleton.joint_names))
    if not (high and low):
        return Rotation.identity()
    zero = positions_at_zero(skeleton)
    spine = zero[high].mean(axis=0) - zero[low].mean(axis=0)
    stands, vertical = int(np.abs(spine).argmax()), "xyz".index(up)
    if np.abs(spine[stands]) <= NEAR * np.linalg.norm(spine):
        return Rotation.identity()
    if stands == vertical:
        about = np.eye(3)[(vertical + 1) % 3] * (np.pi if spine[stands] < 0.0 else 0.0)
    else:
        about = np.cross(np.eye(3)[stands] * np.sign(spine[stands]), np.eye(3)[vertical]) * np.pi / 2.0
    return Rotation.from_rotvec(about)


def complaint_of_up(motion: MotionLike, up: str) -> str:
    """The warning about an axis that does not point up; empty if it does."""
    found = find_up(motion, up)
    if found == up:
        return ""
    return f"{up} is taken as up, but {describe_up(found)}: pass up={found!r}, or up={up!r} if this is intended"


def describe_up(found: str) -> str:
    """The direction of `find_up` as a clause."""
    stands = f"the head is below the feet along {found[-1]}" if len(found) > 1 else f"the pose stands along {found}"
    return f"in nearly all frames {stands}"


def find_up(motion: MotionLike, default: str) -> str:
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
