"""Joints' columns that are continuous in time: each frame the numbers nearest to those of the frame before."""

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.skeleton._bone import Bone, are_slides
from skpose.skeleton._rotations import LOCKED, NO_TURN, TWO_PI, columns_of, resolve_gimbal_lock, squared_gap, twin


def continuous_triples(order: str, rotations: Rotation) -> np.ndarray:
    """Return rotations over time as Euler triples (n_frames, 3), the first frame's nearest to zero."""
    return continuous_columns(Bone("", None, (0.0, 0.0, 0.0), order), rotations)


def continuous_columns(bone: Bone, rotations: Rotation) -> np.ndarray:
    """Return the columns (n_frames, 3) of a joint with three dofs, the first frame's nearest to zero."""
    columns = columns_of(bone, rotations, np.zeros(3))
    if bone.is_ball:
        return continuous_vectors(columns)
    # Twins and whole turns of a frame before change its nearest triple in gimbal lock by a twin and whole turns, which
    # are undone after this.
    for frame in np.flatnonzero(np.abs(np.cos(columns[1:, 1])) < LOCKED):
        columns[frame + 1] = resolve_gimbal_lock(bone.dofs, columns[frame + 1 : frame + 2], columns[frame])[0]
    return continuous_angles(columns)


def remove_jumps(bones: Sequence[Bone], poses: np.ndarray, literal: np.ndarray | None = None) -> np.ndarray:
    """Return poses (n_frames, n_dofs) of joints whose rotations stay and whose numbers do not jump.

    Columns that are `literal`, (n_dofs,) of bool, stay as they are.
    """
    kept = are_slides(bones) if literal is None else are_slides(bones) | literal
    poses, first = poses.copy(), 0
    for bone in bones:
        columns = slice(first, first + bone.n_dofs)
        first += bone.n_dofs
        if bone.is_ball:
            poses[:, columns] = continuous_vectors(poses[:, columns])
        elif bone.n_dofs == 3 and not kept[columns].any():
            poses[:, columns] = continuous_angles(poses[:, columns])
        else:
            poses[:, columns] = np.where(kept[columns], poses[:, columns], np.unwrap(poses[:, columns], axis=0))
    return poses


def continuous_angles(angles: np.ndarray) -> np.ndarray:
    """Return Euler triples (n_frames, 3) of the same rotations, each the nearest to the one before; the first stays."""
    # Twins are as far apart as the triples themselves, so that a change of twin does not depend on those before.
    others = twin(angles)
    change = squared_gap(others[1:], angles[:-1]) < squared_gap(angles[1:], angles[:-1])
    is_other = np.logical_xor.accumulate(np.concatenate([[False], change]))[: len(angles)]
    return np.unwrap(np.where(is_other[:, None], others, angles), axis=0)


def continuous_vectors(vectors: np.ndarray) -> np.ndarray:
    """Return rotation vectors (n_frames, 3) of the same rotations, each the nearest to the one before."""
    size = np.linalg.norm(vectors, axis=1)
    # A rotation by 2π is none, about any axis: it takes the axis of the frame before, not that of what rounding left.
    turned = size > NO_TURN
    last = np.maximum.accumulate(np.where(turned, np.arange(len(vectors)), 0))
    axis = (vectors / np.where(turned, size, 1.0)[:, None])[last]
    cosine = (axis[1:] * axis[:-1]).sum(axis=1)
    if not np.rint((cosine * size[:-1] - size[1:]) / TWO_PI).any():
        return vectors

    def nearest(before: float, now: tuple[float, float]) -> float:
        """Return the size of this frame's vector, negative against its axis, from that of the frame before."""
        between, given = now
        return given + TWO_PI * round((between * before - given) / TWO_PI)

    sizes = np.array(list(accumulate(zip(cosine.tolist(), size[1:].tolist(), strict=True), nearest, initial=size[0])))
    turns = np.rint((sizes - size) / TWO_PI)
    return vectors + (turns * TWO_PI)[:, None] * axis
