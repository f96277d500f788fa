"""The orientation of the root, as numbers of a motion and as a joint of the poses."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import BALL, Bone, with_columns
from skpose.skeleton._rotations import columns_of, continuous_columns, fit_columns, rotations_of
from skpose.skeleton._skeleton import Skeleton

EXACT = 1e-9  # rad, tolerance of angles about fewer than three axes


def root_parts(
    root_angles: np.ndarray, root_axes: str, part: str, up: str, stand: Rotation
) -> tuple[np.ndarray, np.ndarray, str]:
    """Split the root's orientation into rotation vectors (n, 3) of a part of it, the remaining angles, and their axes.

    `stand` is the orientation in which a person stands with heading zero.
    """
    axes = up if part == "tilt" else root_axes
    left, vectors = np.zeros((len(root_angles), len(axes))), np.zeros((len(root_angles), 3))
    if len(root_angles):
        orientations = root_orientations(root_angles, root_axes)
        if part == "tilt":
            left[:, 0] = heading(orientations * stand.inv(), up)
            orientations = Rotation.from_euler(up, left).inv() * orientations
        vectors = orientations.as_rotvec()
    return vectors, left, axes


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


def with_root_joint(skeleton: Skeleton) -> Skeleton:
    """Add a ball joint of length zero at the root, as the parent of the root's children."""
    name = "root"
    while name in skeleton.joint_names:
        name += "_"
    bones = [bone._replace(parent=name) if bone.parent is None else bone for bone in skeleton.bones]
    return Skeleton([Bone(name, None, (0.0, 0.0, 0.0), BALL), *bones], skeleton.offset_frame)


def find_root_joint(skeleton: Skeleton) -> str:
    """The name of a joint at the root, of length zero and with three dofs, that carries all others, or ""."""
    first, *more = [bone for bone in skeleton.bones if bone.parent is None]
    is_root_joint = not more and first.n_dofs == 3 and not np.any(first.offset) and len(skeleton.bones) > 1
    return first.name if is_root_joint else ""


def without_root_joint(skeleton: Skeleton) -> tuple[Skeleton, np.ndarray]:
    """The skeleton without its joint at the root, and the remaining columns."""
    name = find_root_joint(skeleton)
    if not name:
        raise ValueError("without_root needs a motion of with_root, whose first joint carries all others")
    bones = [
        bone._replace(parent=None if bone.parent == name else bone.parent)
        for bone in skeleton.bones
        if bone.name != name
    ]
    there = Skeleton(bones, skeleton.offset_frame)
    return there, there.columns_in(skeleton)


def root_joint_orientations(skeleton: Skeleton, poses: np.ndarray) -> Rotation:
    """The orientations (n,) of the joint at the root, relative to the root."""
    name = find_root_joint(skeleton)
    bone, columns = next(one for one in with_columns(skeleton.bones) if one[0].name == name)
    rest = skeleton.rest_rotations[skeleton.joint_names.index(name)]
    return Rotation.from_matrix(rest) * rotations_of(bone, poses[:, columns])
