"""The rotation of a joint as numbers: the columns of a pose that belong to it."""

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import SkeletonLike
from skpose.skeleton._bone import Bone, are_slides, axes_of, with_columns

TWO_PI = 2.0 * np.pi
OPPOSITE = 1e-8  # rad; vectors nearer to half a turn apart show no axis
NO_TURN = 1e-12  # rad; smaller rotations are rounding and lack an axis
LOCKED = 1e-14  # cosine of the middle angle below which two Euler axes are one; larger, it would change rotations


def rotations_of(bone: Bone, columns: np.ndarray) -> Rotation:
    """The rotations (n,) of a joint from its columns (n, n_dofs), without the rest rotation; slides do not rotate."""
    columns = columns.copy()  # the first scipy that is supported refuses read-only arrays
    if bone.is_ball:
        return Rotation.from_rotvec(columns)
    if bone.is_slide:
        return Rotation.identity(len(columns))
    if bone.is_hinge:
        return Rotation.from_rotvec(columns * axes_of(bone))
    return Rotation.from_euler(bone.dofs, columns)


def columns_of(bone: Bone, rotations: Rotation, near: np.ndarray) -> np.ndarray:
    """The columns (n, 3) of a joint with three dofs.

    Among equivalent numbers, those nearest to others, of shape (n, 3) or (3,).
    """
    if bone.is_ball:
        return nearest_vectors(rotations.as_rotvec(), near)
    angles = euler_angles(bone.dofs, rotations)
    return nearest_angles(resolve_gimbal_lock(bone.dofs, angles, near), near)


def fit_columns(bone: Bone, rotations: Rotation) -> tuple[np.ndarray, np.ndarray]:
    """The columns (n, n_dofs) of a joint that best give rotations, and the remaining angles (n,), rad.

    A joint with three dofs takes any rotation; a hinge comes as near as it can.
    """
    if bone.n_dofs == 3:
        return columns_of(bone, rotations, np.zeros(3)), np.zeros(len(rotations))
    if bone.n_dofs == 0:
        return np.zeros((len(rotations), 0)), rotations.magnitude()
    axes = axes_of(bone)
    if bone.n_dofs == 1:
        quaternions = rotations.as_quat(canonical=True)
        columns = 2.0 * np.arctan2(quaternions[:, :3] @ axes[0], quaternions[:, 3])[:, None]
    else:
        # R = R_b(β) · R_a(α). The axis b, seen before both, shows α, and the axis a, seen after both, shows β.
        a, b = axes if bone.dofs.islower() else axes[::-1]
        normal = np.cross(b, a)
        before, after = rotations.inv().apply(b), rotations.apply(a)
        columns = np.stack([np.arctan2(before @ normal, before @ b), np.arctan2(after @ normal, after @ a)], axis=1)
        columns = columns if bone.dofs.islower() else columns[:, ::-1]
    return columns, (rotations_of(bone, columns).inv() * rotations).magnitude()


def euler_angles(order: str, rotations: Rotation) -> np.ndarray:
    """Euler triples (n, 3) about three different axes, the middle angle in [−π/2, π/2].

    scipy's `as_euler` sets an angle to zero within 1e-7 rad of gimbal lock, which moves the rotation by as much. These
    are exact there too: E. Bernardes, S. Viollet, "Quaternion to Euler angles conversion: A direct, general and
    computationally efficient method", PLOS ONE 2022, doi:10.1371/journal.pone.0276302.
    """
    extrinsic = order.lower() if order.islower() else order[::-1].lower()
    i, j, k = ("xyz".index(axis) for axis in extrinsic)
    sign, quaternions = _parity(extrinsic), rotations.as_quat()
    w, x, y, z = quaternions[:, 3], quaternions[:, i], quaternions[:, j], sign * quaternions[:, k]
    a, b, c, d = w - y, x + z, y + w, z - x
    half_sum, half_difference = np.arctan2(b, a), np.arctan2(d, c)
    middle = 2.0 * np.arctan2(np.hypot(c, d), np.hypot(a, b)) - np.pi / 2
    triple = [half_sum - half_difference, middle, sign * (half_sum + half_difference)]
    return np.stack(triple if order.islower() else triple[::-1], axis=1)


def resolve_gimbal_lock(order: str, angles: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Euler triples (n, 3), with gimbal lock resolved by the triples of the same rotation nearest to others.

    In gimbal lock the first and the third axis are one line, so that only the sum of these angles, or their difference,
    is defined.
    """
    locked = np.abs(np.cos(angles[:, 1])) < LOCKED
    if not locked.any():
        return angles
    first, middle, third = angles.T
    near_first, near_third = near[..., 0], near[..., 2]
    same = np.sign(np.sin(middle)) * _parity(order)  # of the two axes: 1 if first + s, third + s are one rotation
    excess = _wrap((near_first - same * near_third) - (first - same * third)) / 2.0
    nearest = np.stack([near_first - excess, middle, near_third + same * excess], axis=1)
    return np.where(locked[:, None], nearest, angles)


def shortest_rotations(starts: np.ndarray, ends: np.ndarray) -> Rotation:
    """The rotations (n,) by the least angle that take unit vectors, (n, 3) or one (3,), to others (n, 3)."""
    starts = np.broadcast_to(starts, ends.shape)
    quaternions = np.column_stack([np.cross(starts, ends), 1.0 + (starts * ends).sum(axis=1)])  # the scalar last
    opposite = np.linalg.norm(quaternions, axis=1) < OPPOSITE  # half a turn, about any axis across
    quaternions[opposite, :3] = np.cross(starts, np.eye(3)[np.abs(starts).argmin(axis=1)])[opposite]
    return Rotation.from_quat(quaternions)


def nearest_vectors(vectors: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Add whole turns to rotation vectors (n, 3), so that they come nearest to others."""
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    near_size = np.linalg.norm(near, axis=-1, keepdims=True)
    # A rotation by zero has any axis: it takes the axis of the others rather than one left by rounding.
    turned = size > NO_TURN
    axis = np.where(turned, vectors / np.where(turned, size, 1.0), near / np.where(near_size > 0, near_size, 1))
    turns = np.rint(((axis * near).sum(axis=-1, keepdims=True) - size) / TWO_PI)
    return vectors + turns * TWO_PI * axis


def nearest_angles(angles: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Euler triples (n, 3) of the same rotations nearest to others.

    About three different axes, (a, b, c) and (a + π, π − b, c + π) are one rotation.
    """
    twins = np.stack([angles, twin(angles)])
    twins -= TWO_PI * np.rint((twins - near) / TWO_PI)
    second_is_nearer = np.subtract(*np.square(twins - near).sum(axis=-1)) > 0.0
    return np.where(second_is_nearer[..., None], twins[1], twins[0])


def twin(angles: np.ndarray) -> np.ndarray:
    """The other Euler triples (n, 3) of the same rotations."""
    return angles * [1.0, -1.0, 1.0] + np.pi


def squared_gap(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The squared differences of angles (n, 3), each wrapped to [−π, π], summed to (n,)."""
    return np.square(_wrap(a - b)).sum(axis=-1)


def _wrap(angles: np.ndarray) -> np.ndarray:
    return angles - TWO_PI * np.rint(angles / TWO_PI)


def _parity(order: str) -> int:
    """1 if the extrinsic order of the axes is right-handed, otherwise −1."""
    extrinsic = order if order.islower() else order[::-1].lower()
    return 1 if extrinsic in "xyzxy" else -1


# --- joint positions --------------------------------------------------------------------------------------------------
# Positions of joints by scipy's rotations, for modules below `skpose.kinematics`.


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


# --- continuity -------------------------------------------------------------------------------------------------------
# Joint columns that are continuous in time: each frame has the numbers nearest to the frame before.


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
