"""The direction in which a skeleton stands at angle zero, by the names of its joints: heads are above feet."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._skeleton import Skeleton

# Parts of the names of points on the head, the neck and the shoulders, and of those on ankles and feet.
HIGH = "head", "hd", "nose", "neck", "c7", "clav", "acr", "shoulder"
LOW = "foot", "toe", "heel", "hee", "ank", "mal", "cal"
NEAR = 0.8  # cosine of the angle to an axis up to which a skeleton stands along it


def high_and_low(names: list[str]) -> tuple[list[int], list[int]]:
    """The indices of names of points that are high on a person, and of those that are low."""
    high, low = (
        [i for i, name in enumerate(names) if any(part in name.lower() for part in parts)] for parts in (HIGH, LOW)
    )
    return high, low


def upright_turn(skeleton: Skeleton, up: str) -> Rotation:
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
