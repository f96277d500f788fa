"""The mirror image of poses: left and right exchanged."""

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import Bone
from skpose.skeleton._continuity import continuous_columns
from skpose.skeleton._rotations import fit_columns, rotations_of
from skpose.skeleton._sides import partners
from skpose.skeleton._skeleton import Skeleton

PARALLEL = 1e-12  # axes that differ by less are one
MISSED = 1e-3  # rad by which a mirrored rotation may miss the axes of a joint
ASYMMETRY = 45.0  # degrees between a bone and the mirror image of its partner, at angle zero


def mirror_poses(skeleton: Skeleton, poses: np.ndarray, axis: str) -> np.ndarray:
    """Return the mirror image of poses in time, see `Motion.mirrored`."""
    if axis not in ("x", "y", "z"):
        raise ValueError(f'axis must be "x", "y" or "z", the one that points to the left or to the right, got {axis!r}')
    mirror = np.where(np.arange(3) == "xyz".index(axis), -1.0, 1.0)
    other = partners(skeleton.joint_names)
    _check_parents(skeleton, other)
    rest = _rest_axes(skeleton)
    _check_directions(skeleton, other, rest, mirror, axis)

    ends = np.cumsum([bone.n_dofs for bone in skeleton.bones])
    columns = []
    for j, k in enumerate(other):
        bone, partner = skeleton.bones[j], skeleton.bones[k]
        given = poses[:, ends[k] - partner.n_dofs : ends[k]]
        # Relative to angle zero a joint rotates in its parent's axes by G = B L Bᵀ, with B its axes at angle zero and L
        # its own rotation. G becomes M G M of the partner, so that L becomes Cᵀ L C of it.
        columns.append(_reflect(partner, bone, given, rest[k].T * mirror @ rest[j]))
    return np.concatenate(columns, axis=1)


def _reflect(partner: Bone, bone: Bone, given: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Return columns of a joint that are the rotations Cᵀ L C of its partner, with det C = −1."""
    if bone.is_ball and partner.is_ball:
        return -given @ change
    if bone.n_dofs == partner.n_dofs and not bone.is_ball and not partner.is_ball:
        # Cᵀ takes a rotation about n to one about Cᵀn, by the opposite angle: the same axes in the same order?
        letters = zip(partner.dofs.lower(), bone.dofs.lower(), strict=True)
        signs = np.array([change["xyz".index(p), "xyz".index(b)] for p, b in letters])
        if partner.dofs.islower() == bone.dofs.islower() and (np.abs(np.abs(signs) - 1.0) < PARALLEL).all():
            return -np.sign(signs) * given
    if not len(given):
        return np.zeros((0, bone.n_dofs))
    rotations = rotations_of(partner, given) if partner.n_dofs else Rotation.identity(len(given))
    rotations = Rotation.from_matrix(change.T @ rotations.as_matrix() @ change)
    if bone.n_dofs == 3:
        return continuous_columns(bone, rotations)
    if bone.n_dofs:
        columns, missed = fit_columns(bone, rotations)
    else:
        columns, missed = np.zeros((len(given), 0)), rotations.magnitude()
    worst = missed.argmax()
    if missed[worst] > MISSED:
        raise ValueError(
            f"the rotation of {partner.name!r} at frame {worst}, mirrored, misses the axes {bone.dofs!r} of "
            f"{bone.name!r} by {np.degrees(missed[worst]):.3g}°: left and right need dofs about mirrored axes"
        )
    return columns


def _rest_axes(skeleton: Skeleton) -> np.ndarray:
    """Return each joint's axes at angle zero in those of the root, (n_joints, 3, 3)."""
    rest = Rotation.from_matrix(skeleton.rest_rotations.copy()).as_matrix()  # exactly orthonormal
    for j, parent in enumerate(skeleton.parents):
        if parent >= 0:
            rest[j] = rest[parent] @ rest[j]
    return rest


def _check_parents(skeleton: Skeleton, other: list[int]) -> None:
    for j, parent in enumerate(skeleton.parents):
        expected = other[parent] if parent >= 0 else -1
        if skeleton.parents[other[j]] != expected:
            names = [*skeleton.joint_names, "the root"]
            raise ValueError(
                f"left and right must be mirror images, but {names[j]!r} is a child of {names[parent]!r} and "
                f"{names[other[j]]!r} of {names[skeleton.parents[other[j]]]!r}"
            )


def _check_directions(skeleton: Skeleton, other: list[int], rest: np.ndarray, mirror: np.ndarray, axis: str) -> None:
    carriers = np.arange(skeleton.n_joints) if skeleton.offset_frame == "own" else skeleton.parents
    axes = np.concatenate([rest, np.eye(3)[None]])[carriers]  # the root's last, as its index is -1
    offsets = (axes @ skeleton.offsets[:, :, None])[:, :, 0]
    lengths = np.linalg.norm(offsets, axis=1)
    reflected = offsets[other] * mirror
    sine = np.linalg.norm(np.cross(offsets, reflected), axis=1)
    apart = np.degrees(np.arctan2(sine, (offsets * reflected).sum(axis=1)))
    apart[(lengths == 0.0) | (lengths[other] == 0.0)] = 0.0
    worst = apart.argmax()
    if apart[worst] >= ASYMMETRY:
        name, partner = skeleton.joint_names[worst], skeleton.joint_names[other[worst]]
        raise ValueError(
            f"left and right must be mirror images across {axis} at angle zero, but the bone of {name!r} and the "
            f"mirror image of that of {partner!r} are {apart[worst]:.0f}° apart: pass as axis the one that points to "
            "the left or to the right at angle zero"
        )
