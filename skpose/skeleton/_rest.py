"""The rest pose of a skeleton: its bones at angle zero. Equal numbers are different poses if rest poses differ."""

import numpy as np

from skpose._utils.validation import SkeletonLike

NO_DIRECTION = 1e-3  # share of the longest bone: a shorter one, or none, has no direction


def axes_at_zero(skeleton: SkeletonLike) -> np.ndarray:
    """The axes (n_joints, 3, 3) of each joint at angle zero, in the root's axes."""
    axes = np.empty((skeleton.n_joints + 1, 3, 3))  # the last is the root's, whose index is -1
    axes[-1] = np.eye(3)
    for j, (parent, rest) in enumerate(zip(skeleton.parents, skeleton.rest_rotations, strict=True)):
        axes[j] = axes[parent] @ rest
    return axes[:-1]


def _axes_of_offsets(skeleton: SkeletonLike) -> np.ndarray:
    axes = axes_at_zero(skeleton)
    if skeleton.offset_frame == "parent":
        axes = np.concatenate([axes, np.eye(3)[None]])[skeleton.parents]
    return axes


def directions_at_zero(skeleton: SkeletonLike) -> np.ndarray:
    """The direction (n_joints, 3) of each bone at angle zero, in the axes of the root; zeros without length."""
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    has_one = lengths > NO_DIRECTION * lengths.max()
    units = np.where(has_one[:, None], skeleton.offsets / np.where(has_one, lengths, 1.0)[:, None], 0.0)
    return np.einsum("jab,jb->ja", _axes_of_offsets(skeleton), units)


def size_of(skeleton: SkeletonLike) -> float:
    """The longest edge of the box around the joints and the root at angle zero."""
    return float(np.ptp(positions_at_zero(skeleton), axis=0).max())


def positions_at_zero(skeleton: SkeletonLike) -> np.ndarray:
    """The positions (n_joints + 1, 3) of the joints at angle zero, and last of the root, at the origin."""
    bones = np.einsum("jab,jb->ja", _axes_of_offsets(skeleton), skeleton.offsets)
    positions = np.zeros((skeleton.n_joints + 1, 3))  # the root's index is -1
    for j, parent in enumerate(skeleton.parents):
        positions[j] = positions[parent] + bones[j]
    return positions
