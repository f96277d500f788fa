"""The orientation of the root, as numbers of a motion and as a joint of the poses."""

from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import BALL, Bone
from skpose.skeleton._rotations import columns_of, continuous_columns, fit_columns, rotations_of
from skpose.skeleton._skeleton import Skeleton

EXACT = 1e-9  # rad, tolerance of angles about fewer than three axes


def root_orientations(angles: np.ndarray, axes: str) -> Rotation:
    """The orientations (n,) of the root from its angles (n, k) about k axes."""
    if not axes:
        return Rotation.identity(len(angles))
    return Rotation.from_euler(axes, angles)


def root_angles_of(orientations: Rotation, near: np.ndarray, axes: str) -> tuple[np.ndarray, str]:
    """The orientations as angles about the axes, near to others, or about "xyz" if the axes are not three."""
    if sorted(axes.lower()) != ["x", "y", "z"]:
        axes, near = "xyz", np.zeros(3)
    return columns_of(Bone("root", None, (0.0, 0.0, 0.0), axes), orientations, near), axes


def continuous_root_angles(orientations: Rotation, axes: str) -> tuple[np.ndarray, str]:
    """Orientations (n,) over time as angles (n, k) about the axes, or about "xyz" if these cannot represent them."""
    bone = Bone("root", None, (0.0, 0.0, 0.0), axes)
    if len(axes) < 3:
        columns, missed = fit_columns(bone, orientations)
        if not (missed > EXACT).any():
            return np.unwrap(columns, axis=0), axes
        bone = bone._replace(dofs="xyz")
    return continuous_columns(bone, orientations), bone.dofs


def heading(orientations: Rotation, up: str) -> np.ndarray:
    """The angles (n,) in [−π, π] of the twist about an axis of the world.

    An orientation R is twist · tilt: the tilt, a rotation about a horizontal axis, is the same for all orientations
    that differ by a rotation of the world about its vertical. Upside down the heading is zero.
    """
    quaternions = orientations.as_quat()
    twist = 2.0 * np.arctan2(quaternions[:, "xyz".index(up)], quaternions[:, 3])
    return twist - 2.0 * np.pi * np.rint(twist / (2.0 * np.pi))


@lru_cache(maxsize=64)
def with_root_joint(skeleton: Skeleton) -> Skeleton:
    """Add a ball joint of length zero at the root, as the parent of the root's children."""
    name = "root"
    while name in skeleton.joint_names:
        name += "_"
    bones = [bone._replace(parent=name) if bone.parent is None else bone for bone in skeleton.bones]
    return Skeleton([Bone(name, None, (0.0, 0.0, 0.0), BALL), *bones], skeleton.offset_frame)


def has_root_joint(skeleton: Skeleton) -> bool:
    """Whether the first joint is at the root, has length zero and three dofs, and carries all others."""
    first, *others = skeleton.bones
    is_movable = first.n_dofs == 3 and not np.any(first.offset)
    return bool(others) and is_movable and all(bone.parent is not None for bone in others)


def root_joint_orientations(skeleton: Skeleton, poses: np.ndarray) -> Rotation:
    """The orientations (n,) of the joint at the root, relative to the root."""
    return Rotation.from_matrix(skeleton.rest_rotations[0]) * rotations_of(skeleton.bones[0], poses[:, :3])
