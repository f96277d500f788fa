"""Joint columns that are continuous in time: each frame has the numbers nearest to the frame before."""

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import Bone, are_slides, with_columns
from skpose.skeleton._rotations import (
    LOCKED,
    NO_TURN,
    TWO_PI,
    columns_of,
    resolve_gimbal_lock,
    rotations_of,
    squared_gap,
    twin,
)


def convert(bones: Sequence[Bone], others: Sequence[Bone], poses: np.ndarray) -> np.ndarray:
    """Poses in time on the same bones in the same order with other dofs."""
    converted = []
    for (bone, columns), other in zip(with_columns(bones), others, strict=True):
        if bone.dofs == other.dofs:
            converted.append(poses[:, columns])
        elif len(poses):
            converted.append(continuous_columns(other, rotations_of(bone, poses[:, columns])))
        else:
            converted.append(np.zeros((0, other.n_dofs)))
    return np.concatenate(converted, axis=1)


def continuous_triples(order: str, rotations: Rotation) -> np.ndarray:
    """Rotations over time as Euler triples (n_frames, 3), the first frame's nearest to zero."""
    return continuous_columns(Bone("", None, (0.0, 0.0, 0.0), order), rotations)


def continuous_columns(bone: Bone, rotations: Rotation) -> np.ndarray:
    """The columns (n_frames, 3) of a joint with three dofs, the first frame's nearest to zero."""
    columns = columns_of(bone, rotations, np.zeros(3))
    if bone.is_ball:
        return continuous_vectors(columns)
    # In gimbal lock the nearest triple depends on the frame before up to twins and whole turns, which the last step
    # removes.
    for frame in np.flatnonzero(np.abs(np.cos(columns[1:, 1])) < LOCKED):
        columns[frame + 1] = resolve_gimbal_lock(bone.dofs, columns[frame + 1 : frame + 2], columns[frame])[0]
    return continuous_angles(columns)


def remove_jumps(bones: Sequence[Bone], poses: np.ndarray, literal: np.ndarray | None = None) -> np.ndarray:
    """Poses (n_frames, n_dofs) with the same rotations whose numbers do not jump.

    Columns that are `literal`, (n_dofs,) of bool, stay unchanged.
    """
    kept = are_slides(bones) if literal is None else are_slides(bones) | literal
    poses = poses.copy()
    for bone, columns in with_columns(bones):
        if bone.is_ball:
            poses[:, columns] = continuous_vectors(poses[:, columns])
        elif bone.n_dofs == 3 and not kept[columns].any():
            poses[:, columns] = continuous_angles(poses[:, columns])
        else:
            poses[:, columns] = np.where(kept[columns], poses[:, columns], np.unwrap(poses[:, columns], axis=0))
    return poses


def continuous_angles(angles: np.ndarray) -> np.ndarray:
    """Euler triples (n_frames, 3) of the same rotations, each the nearest to the one before; the first stays."""
    # Twins are as far apart as the triples themselves, so that a change of twin does not depend on the frames before.
    others = twin(angles)
    change = squared_gap(others[1:], angles[:-1]) < squared_gap(angles[1:], angles[:-1])
    is_other = np.logical_xor.accumulate(np.concatenate([[False], change]))[: len(angles)]
    return np.unwrap(np.where(is_other[:, None], others, angles), axis=0)


def continuous_vectors(vectors: np.ndarray) -> np.ndarray:
    """Rotation vectors (n_frames, 3) of the same rotations, each the nearest to the one before."""
    size = np.linalg.norm(vectors, axis=1)
    # A rotation by zero has any axis: use the axis of the frame before rather than one left by rounding.
    turned = size > NO_TURN
    last = np.maximum.accumulate(np.where(turned, np.arange(len(vectors)), 0))
    axis = (vectors / np.where(turned, size, 1.0)[:, None])[last]
    cosine = (axis[1:] * axis[:-1]).sum(axis=1)
    if not np.rint((cosine * size[:-1] - size[1:]) / TWO_PI).any():
        return vectors

    def nearest(before: float, now: tuple[float, float]) -> float:
        """The signed size of this frame's vector along its axis, given the size in the frame before."""
        between, given = now
        return given + TWO_PI * round((between * before - given) / TWO_PI)

    sizes = np.array(list(accumulate(zip(cosine.tolist(), size[1:].tolist(), strict=True), nearest, initial=size[0])))
    turns = np.rint((sizes - size) / TWO_PI)
    return vectors + (turns * TWO_PI)[:, None] * axis
