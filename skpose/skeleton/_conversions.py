"""The same rotations of joints as other numbers."""

from collections.abc import Sequence

import numpy as np

from skpose.skeleton._bone import Bone
from skpose.skeleton._continuity import continuous_columns
from skpose.skeleton._rotations import rotations_of


def convert(bones: Sequence[Bone], others: Sequence[Bone], poses: np.ndarray) -> np.ndarray:
    """Return poses in time on the same bones in the same order, which differ in their dofs."""
    columns, first = [], 0
    for bone, other in zip(bones, others, strict=True):
        given = poses[:, first : first + bone.n_dofs]
        first += bone.n_dofs
        if bone.dofs == other.dofs:
            columns.append(given)
        elif len(poses):
            columns.append(continuous_columns(other, rotations_of(bone, given)))
        else:
            columns.append(np.zeros((0, other.n_dofs)))
    return np.concatenate(columns, axis=1)
