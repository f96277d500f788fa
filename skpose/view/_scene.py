"""Motions in space, as pages draw them: y points up, and the ground is at zero."""

from typing import Any, NamedTuple

import numpy as np

from skpose.kinematics import forward_kinematics
from skpose.kinematics._ground import find_ground
from skpose.kinematics._places import joint_places
from skpose.skeleton import Motion
from skpose.skeleton._root import heading, root_orientations
from skpose.skeleton._sides import sides
from skpose.view._pack import ANGLE, pack, unpack
from skpose.view._shape import find_shape

# For each axis that points up: which axes of the world are x, y and z here. A cyclic change does not mirror.
AXES = {"x": (2, 0, 1), "y": (0, 1, 2), "z": (1, 2, 0)}


class Scene(NamedTuple):
    """Positions of a motion's joints, m."""

    joints: np.ndarray  # (n_frames, n_joints, 3) minus the root's position, as the root is rotated
    root: np.ndarray  # (n_frames, 3)
    headings: np.ndarray  # (n_frames,) rotation of the root about y, rad
    axes: str  # names of the axes of the world that are x, y and z here
    size: float  # the largest extent of the first pose along an axis, m; of all poses if that is zero; or else 1
    standing: int  # frames that the height of the ground is found from, see `_ground`


def scene_of(motion: Motion) -> Scene:
    order = AXES[motion.up]
    orientations = root_orientations(motion.root_angles, motion.root_axes)
    poses = forward_kinematics(motion.angles, motion.skeleton)
    joints = np.einsum("fij,fkj->fki", orientations.as_matrix(), poses)[..., order]
    root = motion.root_positions[:, order]
    extents = joints.max(axis=1).clip(min=0.0) - joints.min(axis=1).clip(max=0.0)  # the root is at zero
    size = float(extents[0].max() or extents.max() or 1.0)
    height, standing = find_ground(np.concatenate([root[:, None], joints + root[:, None]], axis=1), motion.times, size)
    return Scene(
        joints,
        root - [0.0, height, 0.0],
        heading(orientations, motion.up),
        "".join("xyz"[axis] for axis in order),
        size,
        standing,
    )


def vertical_of(motion: Motion) -> np.ndarray:
    """The vertical of the world (3,) in the axes of the root, summed over the frames."""
    orientations = root_orientations(motion.root_angles, motion.root_axes)
    return orientations.inv().apply(np.eye(3)["xyz".index(motion.up)]).sum(axis=0)


def motion_data(motion: Motion, label: str) -> dict[str, Any]:
    """Data of a motion in a page, as an object of JSON."""
    scene = scene_of(motion)
    skeleton, numbers = motion.skeleton, motion.frame_numbers - motion.frame_numbers[0]
    return scene_data(scene) | {
        "label": label,
        "names": joint_places(skeleton),
        "parents": skeleton.parents.tolist(),
        "sides": sides(skeleton.joint_names),
        "shape": find_shape(skeleton).data(),
        "rate": motion.frame_rate,
        "start": float(motion.times[0]),
        "numbers": pack(numbers[:, None], 1.0) if numbers[-1] >= len(numbers) else None,  # frames are missing
        "headings": pack(scene.headings[:, None], ANGLE),
    }


def scene_data(scene: Scene) -> dict[str, Any]:
    """Data of any scene: positions, and their largest error, mm."""
    joints = pack(scene.joints.reshape(len(scene.joints), -1))
    root = pack(scene.root, joints["step"] or scene.size / 2**16)
    off = unpack(root) - scene.root
    off_joints = unpack(joints).reshape(scene.joints.shape) - scene.joints + off[:, None]
    return {
        "axes": scene.axes,
        "size": scene.size,
        "standing": scene.standing,
        "error": 1e3 * float(max(np.linalg.norm(one, axis=-1).max() for one in (off, off_joints))),
        "joints": joints,
        "root": root,
    }
