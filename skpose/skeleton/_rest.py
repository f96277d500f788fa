"""The rest pose of a skeleton: its bones at angle zero. Equal numbers are different poses where rest poses differ."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from skpose.skeleton._skeleton import Skeleton

LARGEST_DIFFERENCE = 45.0  # degrees: people of one set differ by less, T-poses and A-poses by more
NO_DIRECTION = 1e-3  # share of the longest bone: a shorter one, or none, has no direction


def axes_at_zero(skeleton: "Skeleton") -> np.ndarray:
    """Return the axes (n_joints, 3, 3) of each joint at angle zero, in those of the root."""
    axes = np.empty((skeleton.n_joints + 1, 3, 3))  # the last is the root's, whose index is -1
    axes[-1] = np.eye(3)
    for j, (parent, rest) in enumerate(zip(skeleton.parents, skeleton.rest_rotations, strict=True)):
        axes[j] = axes[parent] @ rest
    return axes[:-1]


def directions_at_zero(skeleton: "Skeleton") -> np.ndarray:
    """Return the direction (n_joints, 3) of each bone at angle zero, in the axes of the root; zeros if it has none."""
    axes = axes_at_zero(skeleton)
    if skeleton.offset_frame == "parent":
        axes = np.concatenate([axes, np.eye(3)[None]])[skeleton.parents]
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    has_one = lengths > NO_DIRECTION * lengths.max()
    units = np.where(has_one[:, None], skeleton.offsets / np.where(has_one, lengths, 1.0)[:, None], 0.0)
    return np.einsum("jab,jb->ja", axes, units)


def size_of(skeleton: "Skeleton") -> float:
    """Return the longest edge of the box around the joints and the root at angle zero."""
    axes = axes_at_zero(skeleton)
    if skeleton.offset_frame == "parent":
        axes = np.concatenate([axes, np.eye(3)[None]])[skeleton.parents]
    bones = np.einsum("jab,jb->ja", axes, skeleton.offsets)
    positions = np.zeros((skeleton.n_joints + 1, 3))  # the last is the root's, whose index is -1
    for j, parent in enumerate(skeleton.parents):
        positions[j] = positions[parent] + bones[j]
    return float(np.ptp(positions, axis=0).max())


def check_rest_poses(skeletons: Sequence["Skeleton"], names: Sequence[str], remedy: str) -> None:
    """Refuse skeletons with the same joints of which two have bones, or rest rotations, that are far apart.

    Each bone is compared by its direction at angle zero; each joint with dofs by its rest rotation, too.
    """
    if len(skeletons) < 2:
        return
    joints = skeletons[0].joint_names
    order = [[skeleton.joint_names.index(name) for name in joints] for skeleton in skeletons]
    directions = np.stack([directions_at_zero(s)[i] for s, i in zip(skeletons, order, strict=True)])
    rests = np.stack([s.rest_rotations[i] for s, i in zip(skeletons, order, strict=True)])
    rests = rests.reshape(*rests.shape[:2], 9)
    moves = np.array([bool(bone.dofs) for bone in skeletons[0].bones])
    known = np.linalg.norm(directions, axis=-1) > 0.0
    worst, words = LARGEST_DIFFERENCE, ""
    for i in range(len(skeletons) - 1):  # with all that follow: those of one first skeleton may differ among themselves
        cosines = np.einsum("ja,nja->nj", directions[i], directions[i + 1 :])
        cosines[~(known[i] & known[i + 1 :])] = 1.0
        traces = np.einsum("ja,nja->nj", rests[i], rests[i + 1 :])
        for what, cosine in (
            ("bone {!r} points in directions that are {:.0f}° apart at angle zero", cosines),
            ("joint {!r} has rest rotations that are {:.0f}° apart", np.where(moves, (traces - 1.0) / 2.0, 1.0)),
        ):
            k, j = np.unravel_index(cosine.round(9).argmin(), cosine.shape)  # a joint before those that follow it
            angle = float(np.degrees(np.arccos(np.clip(cosine[k, j], -1.0, 1.0))))
            if angle > worst + 1e-6:
                worst = angle
                words = f"{names[i]} and {names[i + 1 + k]} have different rest poses: {what.format(joints[j], angle)}"
    if words:
        raise ValueError(
            f"{words}, so that equal numbers are different poses; expected at most {LARGEST_DIFFERENCE:.0f}°. {remedy}"
        )
