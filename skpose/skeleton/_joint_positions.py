"""Positions of joints by scipy's rotations, for modules below `skpose.kinematics`."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import SkeletonLike
from skpose.skeleton._bone import axes_of, with_columns
from skpose.skeleton._rotations import rotations_of


def joint_positions(skeleton: SkeletonLike, angles: np.ndarray, root: Rotation) -> np.ndarray:
    """The positions (n, n_joints + 1, 3) of the root and of the joints, m, relative to the root."""
    orientations, positions = [root], [np.zeros((len(angles), 3))]
    bones = with_columns(skeleton.bones)
    for (bone, columns), parent, rest in zip(bones, skeleton.parents, skeleton.rest_rotations, strict=True):
        own = orientations[parent + 1] * Rotation.from_matrix(rest)
        if bone.n_dofs:
            own = own * rotations_of(bone, angles[:, columns])
        carrier = own if skeleton.offset_frame == "own" else orientations[parent + 1]
        positions.append(positions[parent + 1] + carrier.apply(bone.offset))
        if bone.is_slide:
            positions[-1] += own.apply(angles[:, columns] * axes_of(bone))
        orientations.append(own)
    return np.stack(positions, axis=1)
