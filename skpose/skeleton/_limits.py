"""Angles with joint limits: numbers within a range, rather than directions up to whole turns."""

from collections.abc import Sequence

import numpy as np

from skpose.skeleton._bone import Bone, ranges_of
from skpose.skeleton._rotations import TWO_PI


def limited_dofs(bones: Sequence[Bone]) -> np.ndarray:
    """Which dofs (n_dofs,) have a limit, on one side at least."""
    return np.isfinite(ranges_of(bones)).any(axis=1)


def kept_inside(bones: Sequence[Bone], poses: np.ndarray) -> np.ndarray:
    """Which numbers (n_poses, n_dofs) of a recording are to be taken without whole turns.

    They are inside limits that exclude part of the circle, of joints with one or two dofs. Joints with three dofs are
    taken as rotations, since files often break their own limits.
    """
    lower, upper = ranges_of(bones).T
    is_hinge = np.repeat([bone.n_dofs < 3 for bone in bones], [bone.n_dofs for bone in bones])
    return (is_hinge & (upper - lower < TWO_PI)) & (lower <= poses) & (poses <= upper)
