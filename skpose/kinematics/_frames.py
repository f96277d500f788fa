"""Frames of a skeleton, and the constant rotations between them: the first two passes of `skpose.kinematics._tree`."""

from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.pose.tree import BALL
from skpose.skeleton import Skeleton

# Constant rotations that differ from the identity by rounding alone are the identity: a frame less per joint.
ROUNDING = 8 * np.finfo(np.float64).eps


class Frame:
    """A coordinate system that rotates about z, y and x by its dofs; without dofs, about one axis by a constant."""

    def __init__(
        self, parent: "Frame | None", first_dof: int, end_dof: int, rest: Any, pivot: int, is_ball: bool = False
    ):
        self.parent = parent
        self.first_dof, self.end_dof, self.is_ball = first_dof, end_dof, is_ball
        self.rest = rest  # between the parent and the dofs, until `absorb` has split it
        self.pivot = pivot
        self.children: list[Frame] = []
        self.joints: list[int] = []
        self.axis, self.angle = 0, 0.0
        self.axes = np.eye(3)  # of a ball joint: takes vectors in its frame to the joint's own axes
        if parent is not None:
            parent.children.append(self)

    @property
    def n_dofs(self) -> int:
        return self.end_dof - self.first_dof

    @property
    def kind(self) -> int:
        return BALL if self.is_ball else self.n_dofs

    @property
    def is_leaf(self) -> bool:
        return self.n_dofs > 0 and not self.children and len(self.joints) == 1


class Frames(NamedTuple):
    """The result of the first pass."""

    root: Frame
    rotating: list[Frame]  # the root's frame and all frames with dofs, parents first
    offset: np.ndarray  # (n_joints + 1, 3) of each joint from its parent, in the axes of the frame that carries it
    column: list[int]  # as in Tree
    sign: list[int]


# --- first pass: one frame for each joint with dofs -------------------------------------------------------------------


def frames_of(skeleton: Skeleton | None) -> Frames:
    """Give each joint with dofs a frame.

    Every joint's world orientation is that of a frame times a constant: H_j = K_f · A_j. A rigid joint shares the
    frame of its parent. A joint with dofs has a frame K_f = K_parent · rest · Rz · Ry · Rx of its own.
    """
    root = Frame(None, 0, 0, None, 0)
    frames = Frames(root, [root], np.zeros((1, 3)), [], [])
    if skeleton is None:
        return frames
    n_joints, own = skeleton.n_joints, skeleton.offset_frame == "own"
    frame_of, constant = [root] * (n_joints + 1), [np.eye(3)] * (n_joints + 1)  # f and A_j of the root and all joints
    first_column = np.cumsum([0] + [bone.n_dofs for bone in skeleton.bones])
    for j in _depth_first(skeleton.parents):
        bone, parent = skeleton.bones[j], skeleton.parents[j] + 1
        before = constant[parent] @ skeleton.rest_rotations[j]
        if not bone.dofs:
            frame_of[j + 1], constant[j + 1] = frame_of[parent], before
            continue
        columns = list(range(first_column[j], first_column[j + 1]))
        if bone.is_ball:
            Q, signs = np.eye(3), [1, 1, 1]
        elif bone.is_hinge:
            Q, signs = _axis_to_x(np.array(bone.axis)), [1]
        else:
            axes = ["xyz".index(axis) for axis in bone.dofs.lower()]
            if bone.dofs.islower():  # extrinsic: the last one listed is the first factor of the product
                columns, axes = columns[::-1], axes[::-1]
            Q, signs = _axes_to_zyx(axes)
        first = len(frames.column)
        pivot = parent if own else j + 1
        frame = Frame(frame_of[parent], first, first + len(columns), before @ Q.T, pivot, bone.is_ball)
        frame_of[j + 1], constant[j + 1] = frame, Q
        frames.rotating.append(frame)
        frames.column.extend(columns)
        frames.sign.extend(signs)
    offset = np.zeros((n_joints + 1, 3))
    carriers = np.arange(1, n_joints + 1) if own else skeleton.parents + 1  # the joints whose axes the offsets are in
    for j, carrier in enumerate(carriers, start=1):
        offset[j] = constant[carrier] @ skeleton.offsets[j - 1]
        frame_of[carrier].joints.append(j)
    return frames._replace(offset=offset)


def _axes_to_zyx(axes: list[int]) -> tuple[np.ndarray, list[int]]:
    """Return a rotation Q that takes the last axis to x, the one before to y, the first to ± z; and that sign.

    The rotation about an axis a by θ is Qᵀ·R·Q, with R the rotation by θ about Qa, so a product of rotations about
    any axes is one about z, y and x between Qᵀ and Q.
    """
    Q = np.zeros((3, 3))
    targets = [0, 1, 2]
    for axis, target in zip([*reversed(axes), *(set(range(3)) - set(axes))], targets, strict=True):
        Q[target, axis] = 1.0
    signs = [1] * len(axes)
    if np.linalg.det(Q) < 0:  # the order is left-handed: reverse the axis that goes to z, with or without a dof
        Q[2] *= -1.0
        if len(axes) == 3:
            signs[0] = -1
    return Q, signs


def _axis_to_x(axis: np.ndarray) -> np.ndarray:
    """Return a rotation that takes a direction to x."""
    across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    across /= np.linalg.norm(across)
    return np.stack([axis, across, np.cross(axis, across)])


def _depth_first(parents: np.ndarray) -> list[int]:
    """Return the joints in an order in which all descendants of a joint follow it at once."""
    children: list[list[int]] = [[] for _ in range(len(parents) + 1)]  # the root's last, as its index is -1
    for joint, parent in enumerate(parents):
        children[parent].append(joint)
    order, waiting = [], children[-1][::-1]
    while waiting:
        order.append(waiting.pop())
        waiting.extend(reversed(children[order[-1]]))
    return order


# --- second pass: constant rotations into the zeros of angles ---------------------------------------------------------


def _about(axis: int, angle: float) -> np.ndarray:
    """Return the rotation matrix about a coordinate axis."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[b, b] = R[c, c] = np.cos(angle)
    R[c, b] = np.sin(angle)
    R[b, c] = -R[c, b]
    return R


def _angle_of(u: float, v: float) -> float:
    """Return the direction of the vector (v, u), rounded to zero where only rounding keeps it from zero."""
    angle = np.arctan2(u, v) if max(abs(u), abs(v)) > ROUNDING else 0.0
    return float(angle) if abs(angle) > ROUNDING else 0.0


def _split(R: np.ndarray, n_dofs: int) -> tuple[float, int, float, float]:
    """Split a rotation R = Rx(α) · Rm(β) · Rk(γ) into α, m, β and γ, with k the axis of the first dof: z, y or x.

    The axis m is y, or z where k is y. The x of the frame before takes α and the first dof of the next frame takes γ,
    so that β is all that a constant rotation costs between two frames.
    """
    k, m = n_dofs - 1, 2 if n_dofs == 2 else 1
    other = 3 - m  # of y and z
    sign = 1.0 if m == 2 else -1.0
    alpha = _angle_of(sign * R[m, k], R[other, k])
    rest = _about(0, -alpha) @ R
    a, b = (2, 0) if m == 1 else (0, 1)  # the axes that a rotation about m mixes
    along, across = (a, b) if k == a else (b, a)
    beta = _angle_of(rest[across, k] * (1.0 if along == a else -1.0), rest[along, k])
    rest = _about(m, -beta) @ rest
    return alpha, m, beta, _angle_of(rest[(k + 2) % 3, (k + 1) % 3], rest[(k + 1) % 3, (k + 1) % 3])


def absorb(frame: Frame, offset: np.ndarray, shift: np.ndarray) -> None:
    """Move the constant rotations behind a frame into the zeros of angles, or into frames of their own.

    Parents come first, since what they take rotates their children. A child that is a ball joint keeps its rest
    rotation, as the start of its quaternion.
    """
    angular = [child for child in frame.children if not child.is_ball]
    if frame.is_ball:
        _choose_axes(frame, angular, offset)
    elif frame.n_dofs > 0 and (angular or frame.is_leaf):
        if angular:
            alpha = _split(angular[0].rest, angular[0].n_dofs)[0]
        else:  # rotate the offset into the plane of x and y
            alpha = _angle_of(offset[frame.joints[0], 2], offset[frame.joints[0], 1])
        shift[frame.end_dof - 1] += alpha
        _rotate_behind(frame, _about(0, -alpha), offset)
    if frame.is_leaf:
        offset[frame.joints[0], 2] = 0.0
    for child in angular:
        alpha, m, beta, gamma = _split(child.rest, child.n_dofs)
        shift[child.first_dof] += gamma
        i, upper = frame.children.index(child), child
        for axis, angle in ((m, beta), (0, alpha)):  # from the child up
            if angle != 0.0:
                constant = Frame(None, child.first_dof, child.first_dof, None, 0)
                constant.axis, constant.angle, constant.children = axis, angle, [upper]
                upper.parent, constant.parent, frame.children[i], upper = constant, frame, constant, constant


def _rotate_behind(frame: Frame, back: np.ndarray, offset: np.ndarray) -> None:
    """Rotate what a frame carries by a constant, whose inverse the frame itself takes."""
    for j in frame.joints:
        offset[j] = back @ offset[j]
    for child in frame.children:
        child.rest = back @ child.rest


def _choose_axes(frame: Frame, angular: list[Frame], offset: np.ndarray) -> None:
    """Choose the axes of a ball joint's frame: those of the first child with angles, or x along the first offset."""
    R = np.eye(3)
    if angular:
        R = angular[0].rest
    elif frame.joints:
        along = offset[frame.joints[0]]
        length = np.linalg.norm(along)
        if length > 0.0:
            across = np.eye(3)[np.abs(along).argmin()]
            y = np.cross(along / length, across)
            y /= np.linalg.norm(y)
            R = np.stack([along / length, y, np.cross(along / length, y)], axis=1)
    _rotate_behind(frame, R.T, offset)
    if angular:
        angular[0].rest = np.eye(3)
    elif frame.joints:  # exactly along x
        offset[frame.joints[0]] = np.linalg.norm(offset[frame.joints[0]]), 0.0, 0.0
    frame.axes, frame.rest = R, frame.rest @ R
