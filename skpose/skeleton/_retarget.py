"""Conversion of poses to a skeleton whose bones point elsewhere at angle zero.

Let d be the direction of a bone at angle zero, and G the rotation, since angle zero, of the joint that carries it, both
in the axes of the root: the bone points along G·d. A constant rotation A of each joint takes the directions of the
target at zero to those of the source, A·d_target = d_source. So the bones of the target point where those of the source
do if its joints have rotated by G_target = G_source·A.

A joint carries the bones that rotate with it: those that end at it (offsets in its "own" axes) or start at it, and
those of joints without dofs that follow it; the root carries bones likewise. A is the shortest rotation, beyond that of
the joint before, that fits one direction; the least squares fit to several (Kabsch); and that of the joint before where
there is none.
"""

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._arguments import check_skeleton
from skpose.skeleton._bone import Bone
from skpose.skeleton._rest import LARGEST_DIFFERENCE, axes_at_zero, check_rest_poses, directions_at_zero
from skpose.skeleton._root import root_angles_of, root_orientations
from skpose.skeleton._rotations import TWO_PI, columns_of, rotations_of
from skpose.skeleton._skeleton import Skeleton, mismatch

if TYPE_CHECKING:
    from skpose.skeleton._motion import Motion

RESTS = ("raise", "world", "same")
ROUNDING = 1e-6  # rad
# Least squares fit a second direction if it has this weight: bones within 2° of a line have one direction.
LINE = 1e-3
ROOT = -1


def retarget(motion: "Motion", skeleton: Skeleton, rest: str) -> "Motion":
    """Return the motion on another skeleton, see `Motion.retarget`."""
    if rest not in RESTS:
        raise ValueError(f'rest must be "raise", "world" or "same", got {rest!r}')
    check_skeleton(skeleton)
    difference = mismatch(motion.skeleton, skeleton)
    if difference:
        raise ValueError(f"the motion's angles do not carry over to this skeleton: {difference}")
    if rest == "world" and len(motion):
        angles, turn = _keep_directions(motion.skeleton, motion.angles, skeleton)
        root_angles, axes = motion.root_angles, motion.root_axes
        if turn.magnitude() > 1e-12:  # more than rounding
            root_angles, axes = root_angles_of(root_orientations(root_angles, axes) * turn, root_angles, axes)
        return replace(motion, skeleton=skeleton, angles=angles, root_angles=root_angles, root_axes=axes)
    if rest == "raise":
        remedy = 'rest="world" keeps the directions of the bones in the world, rest="same" the numbers'
        check_rest_poses([motion.skeleton, skeleton], ["the motion's skeleton", "the given one"], remedy)
    column = {name: i for i, name in enumerate(motion.skeleton.dof_names)}
    angles = motion.angles[:, [column[name] for name in skeleton.dof_names]]
    return replace(motion, skeleton=skeleton, angles=angles)


def _keep_directions(source: Skeleton, angles: np.ndarray, target: Skeleton) -> tuple[np.ndarray, Rotation]:
    """Return the angles on the target whose bones point where those of the source do.

    The second result A takes vectors in the axes of the target's root to those of the source's: bones point along the
    same directions of the world if the root has the orientation of the source's root times A.
    """
    there = [source.joint_names.index(name) for name in target.joint_names]
    carried = _carried(target)
    turns = _turns(target, directions_at_zero(target), directions_at_zero(source)[there], carried)
    zero, zero_source = axes_at_zero(target), axes_at_zero(source)[there]
    directions = directions_at_zero(target)
    moved = _orientations(source, angles)
    columns = _columns(source)
    oriented: dict[str | None, Rotation] = {None: Rotation.identity()}
    converted = np.empty((len(angles), target.n_dofs))
    for j, bone in enumerate(target.bones):
        before = oriented[bone.parent] * Rotation.from_matrix(target.rest_rotations[j].copy())
        if not bone.dofs:
            oriented[bone.name] = before
            continue
        since_zero = moved[bone.name] * Rotation.from_matrix(zero_source[j].T)
        wished = turns[ROOT].inv() * since_zero * turns[j] * Rotation.from_matrix(zero[j])
        local, near = before.inv() * wished, angles[:, columns[bone.name]]
        numbers = columns_of(bone, local, near) if bone.n_dofs == 3 else _nearest(bone, local, near)
        oriented[bone.name] = before * rotations_of(bone, numbers)
        if bone.n_dofs < 3:
            for k in carried[j]:
                along = zero[j].T @ directions[k]
                _check(bone, target.joint_names[k], oriented[bone.name].apply(along), wished.apply(along))
        converted[:, _columns(target)[bone.name]] = numbers
    return converted, turns[ROOT]


def _carried(skeleton: Skeleton) -> dict[int, list[int]]:
    """Return the bones that rotate with the root and with each joint that has dofs."""
    mover = {ROOT: ROOT}
    carried: dict[int, list[int]] = {ROOT: []}
    for j, bone in enumerate(skeleton.bones):
        parent = int(skeleton.parents[j])
        mover[j] = j if bone.dofs else mover[parent]
        carried.setdefault(mover[j], [])
        carried[mover[j if skeleton.offset_frame == "own" else parent]].append(j)
    return carried


def _turns(
    target: Skeleton, directions: np.ndarray, wished: np.ndarray, carried: dict[int, list[int]]
) -> dict[int, Rotation]:
    """Return the constant rotation of the root and of each joint: the A of the module's text."""
    turns = {ROOT: Rotation.identity()}
    for j in (ROOT, *range(target.n_joints)):
        before = turns[int(target.parents[j])] if j != ROOT else turns[ROOT]
        bones = [k for k in carried.get(j, []) if directions[k].any() and wished[k].any()]
        if not bones:
            turns[j] = before
            continue
        turns[j] = _fit(before.apply(directions[bones]), wished[bones]) * before
        cosines = np.einsum("ka,ka->k", turns[j].apply(directions[bones]), wished[bones])
        angle = np.degrees(np.arccos(np.clip(cosines.min(), -1.0, 1.0)))
        if angle > LARGEST_DIFFERENCE:
            name = target.joint_names[bones[int(cosines.argmin())]]
            raise ValueError(
                f"the motion's poses have no counterpart on this skeleton: bone {name!r} is {angle:.0f}° apart from "
                "its namesake after the best fit of all bones that move with it, and no joint is between them; "
                f"expected at most {LARGEST_DIFFERENCE:.0f}°"
            )
    return turns


def _fit(a: np.ndarray, b: np.ndarray) -> Rotation:
    """Return the rotation that takes directions a (n, 3) nearest to b; the shortest where all are on a line."""
    U, singular, Vt = np.linalg.svd(b.T @ a)
    sign = np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    if singular[1] + sign * singular[2] > LINE * singular[0]:
        return Rotation.from_matrix(U @ np.diag([1.0, 1.0, sign]) @ Vt)
    u, v = Vt[0], U[:, 0]
    quaternion = np.array([*np.cross(u, v), 1.0 + u @ v])  # the scalar last
    if np.linalg.norm(quaternion) < 1e-8:  # opposite: by 180° about an axis across
        quaternion = np.array([*np.cross(u, np.eye(3)[np.abs(u).argmin()]), 0.0])
    return Rotation.from_quat(quaternion)


def _columns(skeleton: Skeleton) -> dict[str, slice]:
    """Return the columns of each joint in a pose."""
    ends = np.cumsum([bone.n_dofs for bone in skeleton.bones])
    return {b.name: slice(end - b.n_dofs, end) for b, end in zip(skeleton.bones, ends.tolist(), strict=True)}


def _orientations(skeleton: Skeleton, angles: np.ndarray) -> dict[str | None, Rotation]:
    """Return the orientation of each joint's axes in those of the root, (n_poses,) or one for all."""
    oriented: dict[str | None, Rotation] = {None: Rotation.identity()}
    columns = _columns(skeleton)
    for bone, rest in zip(skeleton.bones, skeleton.rest_rotations, strict=True):
        oriented[bone.name] = oriented[bone.parent] * Rotation.from_matrix(rest.copy())
        if bone.dofs:
            oriented[bone.name] = oriented[bone.name] * rotations_of(bone, angles[:, columns[bone.name]])
    return oriented


def _nearest(bone: Bone, rotations: Rotation, near: np.ndarray) -> np.ndarray:
    """Return the columns of a joint with one or two dofs; its rotations are these if there are such columns."""
    if bone.n_dofs == 1:
        quaternions = rotations.as_quat()
        axis = "xyz".index(bone.dofs.lower())
        angles = 2.0 * np.arctan2(quaternions[:, axis], quaternions[:, 3])[:, None]
    else:
        axes = "xyz" if bone.dofs.islower() else "XYZ"
        third = next(axis for axis in axes if axis not in bone.dofs)
        with warnings.catch_warnings():  # of gimbal lock, where the third angle becomes zero
            warnings.simplefilter("ignore", UserWarning)
            triples = rotations.as_euler(bone.dofs + third)
        is_zero = np.cos(triples[:, 2:]) > 0.0  # or else that of the other triple of the same rotation
        angles = np.where(is_zero, triples[:, :2], triples[:, :2] * [1.0, -1.0] + np.pi)
    return angles - TWO_PI * np.rint((angles - near) / TWO_PI)


def _check(bone: Bone, carried: str, reached: np.ndarray, wished: np.ndarray) -> None:
    """Refuse directions (n, 3) that a joint cannot give to a bone."""
    apart = np.degrees(2.0 * np.arcsin(np.minimum(np.linalg.norm(reached - wished, axis=-1) / 2.0, 1.0)))
    if apart.max() > np.degrees(ROUNDING):
        raise ValueError(
            f"joint {bone.name!r} has the dofs {bone.dofs!r}, with which bone {carried!r} cannot keep its direction: "
            f"at frame {apart.argmax()} it is off by {apart.max():.2g}°. Take the numbers "
            'as they are with rest="same", which is right where rest poses are close'
        )
