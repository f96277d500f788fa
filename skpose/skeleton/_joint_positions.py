"""Positions of joints by scipy's rotations, for what is computed of motions below `skpose.kinematics`."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import axes_of
from skpose.skeleton._rotations import rotations_of
from skpose.skeleton._skeleton import Skeleton


def joint_positions(skeleton: Skeleton, angles: np.ndarray, root: Rotation) -> np.ndarray:
    """Return the positions (n, n_joints + 1, 3) of the root and of the joints, m, relative to the root."""
    orientations, positions = [root], [np.zeros((len(angles), 3))]
    first = 0
    for bone, parent, rest in zip(skeleton.bones, skeleton.parents, skeleton.rest_rotations, strict=True):
        columns = angles[:, first : first + bone.n_dofs]
        first += bone.n_dofs
        own = orientations[parent + 1] * Rotation.from_matrix(rest)
        if bone.n_dofs:
            own = own * rotations_of(bone, columns)
        carrier = own if skeleton.offset_frame == "own" else orientations[parent + 1]
        positions.append(positions[parent + 1] + carrier.apply(bone.offset))
        if bone.is_slide:
            positions[-1] += own.apply(columns * axes_of(bone))
        orientations.append(own)
    return np.stack(positions, axis=1)
