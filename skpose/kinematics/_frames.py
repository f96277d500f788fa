"""Frames of a skeleton, and the constant rotations between them: the first two passes of `skpose.kinematics._tree`."""

from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.pose.tree import BALL, HINGE
from skpose.skeleton import Skeleton
from skpose.skeleton._bone import with_columns

# Constant rotations that differ from the identity by rounding alone are the identity: a frame less per joint.
ROUNDING = 8 * np.finfo(np.float64).eps


class Frame:
    """A coordinate system that rotates about z, y and x by its dofs.

    The frame of a hinge rotates about any one of these, a frame without dofs by a constant; a slide does not rotate.
    """

    def __init__(
        self, parent: "Frame | None", first_dof: int, end_dof: int, rest: Any, pivot: int, is_ball: bool = False
    ):
        self.parent = parent
        self.first_dof, self.end_dof, self.is_ball = first_dof, end_dof, is_ball
        self.rest = rest  # between the parent and the dofs, until `absorb` has split it
        self.pivot = pivot
        self.children: list[Frame] = []
        self.joints: list[int] = []
        self.axis, self.angle = 0, 0.0  # the last axis about which it rotates; the constant
        self.hinge: np.ndarray | None = None  # the direction of a hinge's axis, until `absorb` has chosen its frame
        self.slide: np.ndarray | None = None  # the direction of a slide
        self.axes = np.eye(3)  # of a ball joint: takes vectors in its frame to the joint's own axes
        if parent is not None:
            parent.children.append(self)

    @property
    def n_dofs(self) -> int:
        return self.end_dof - self.first_dof

    @property
    def n_angles(self) -> int:
        return 0 if self.is_ball or self.slide is not None else self.n_dofs

    @property
    def kind(self) -> int:
        if self.is_ball:
            return BALL
        return HINGE if self.n_angles == 1 and self.axis != 0 else self.n_angles

    @property
    def is_leaf(self) -> bool:
        return (self.is_ball or self.n_angles > 0) and self.axis == 0 and not self.children and len(self.joints) == 1


class Frames(NamedTuple):
    """The result of the first pass."""

    moving: list[Frame]  # the root's frame and all frames with dofs, parents first
    offset: np.ndarray  # (n_joints + 1, 3) of each joint from its parent, in the axes of the frame that carries it
    column: list[int]  # as in Tree
    sign: list[int]
    slides: list[tuple[Frame, int]]  # of each slide its frame, and the joint that it moves


# --- first pass: one frame for each joint with dofs -------------------------------------------------------------------


def frames_of(skeleton: Skeleton | None) -> Frames:
    """Give each joint with dofs a frame.

    Every joint's world orientation is a frame's times a constant: H_j = K_f · A_j. A rigid joint shares the
    frame of its parent. A joint with dofs has a frame K_f = K_parent · rest · Rz · Ry · Rx of its own.
    """
    root = Frame(None, 0, 0, None, 0)
    frames = Frames([root], np.zeros((1, 3)), [], [], [])
    if skeleton is None:
        return frames
    n_joints, own = skeleton.n_joints, skeleton.offset_frame == "own"
    frame_of, constant = [root] * (n_joints + 1), [np.eye(3)] * (n_joints + 1)  # f and A_j of the root and all joints
    bones = list(with_columns(skeleton.bones))
    for j in _depth_first(skeleton.parents):
        (bone, own_columns), parent = bones[j], skeleton.parents[j] + 1
        before = constant[parent] @ skeleton.rest_rotations[j]
        if not bone.dofs:
            frame_of[j + 1], constant[j + 1] = frame_of[parent], before
            continue
        columns = list(range(own_columns.start, own_columns.stop))
        if bone.is_ball or bone.axis is not None:
            Q, signs = np.eye(3), [1] * bone.n_dofs
        else:
            axes = ["xyz".index(axis) for axis in bone.dofs.lower()]
            if bone.dofs.islower():  # extrinsic: the last one listed is the first factor of the product
                columns, axes = columns[::-1], axes[::-1]
            Q, signs = _axes_to_zyx(axes)
        first = len(frames.column)
        pivot = parent if own else j + 1
        frame = Frame(frame_of[parent], first, first + len(columns), before @ Q.T, pivot, bone.is_ball)
        if bone.is_hinge:
            frame.hinge = np.array(bone.axis)
        elif bone.is_slide:
            frame.slide, frame.rest, Q = before @ bone.axis, np.eye(3), before
            frames.slides.append((frame, j + 1))
        frame_of[j + 1], constant[j + 1] = frame, Q
        frames.moving.append(frame)
        frames.column.extend(columns)
        frames.sign.extend(signs)
    offset = np.zeros((n_joints + 1, 3))
    carriers = np.arange(1, n_joints + 1) if own else skeleton.parents + 1  # the joints whose axes the offsets are in
    for j, carrier in enumerate(carriers, start=1):
        offset[j] = constant[carrier] @ skeleton.offsets[j - 1]
        frame_of[carrier].joints.append(j)
    for frame, j in frames.slides:  # which moves its joint, also where the offset is in the axes of the parent
        carrier = frame_of[carriers[j - 1]]
        if carrier is not frame:
            carrier.joints.remove(j)
            frame.joints.insert(0, j)  # before the joints that it carries
    return frames._replace(offset=offset)


def _axes_to_zyx(axes: list[int]) -> tuple[np.ndarray, list[int]]:
    """A rotation Q that takes the last axis to x, the one before to y, the first to ± z; and that sign.

    The rotation about an axis a by θ is Qᵀ·R·Q, with R the rotation by θ about Qa, so a product of rotations about
    any axes is one about z, y and x between Qᵀ and Q.
    """
    Q = np.eye(3)[[*reversed(axes), *(set(range(3)) - set(axes))]]
    signs = [1] * len(axes)
    if np.linalg.det(Q) < 0:  # the order is left-handed: reverse the axis that goes to z, with or without a dof
        Q[2] *= -1.0
        if len(axes) == 3:
            signs[0] = -1
    return Q, signs


def _depth_first(parents: np.ndarray, root: int = -1) -> list[int]:
    """The joints in an order in which all descendants of a joint follow it at once."""
    order: list[int] = []
    for joint in np.flatnonzero(parents == root).tolist():
        order += [joint, *_depth_first(parents, joint)]
    return order


# --- second pass: constant rotations into the zeros of angles ---------------------------------------------------------


def _about(axis: int, angle: float) -> np.ndarray:
    """The rotation matrix about a coordinate axis."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[np.ix_([b, c], [b, c])] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return R


def _angle_of(u: float, v: float) -> float:
    """The direction of the vector (v, u), zero within rounding errors."""
    angle = np.arctan2(u, v) if max(abs(u), abs(v)) > ROUNDING else 0.0
    return float(angle) if abs(angle) > ROUNDING else 0.0


def _split(R: np.ndarray, p: int, k: int) -> tuple[float, int, float, float]:
    """Split a rotation R = Rp(α) · Rm(β) · Rk(γ) into α, m, β and γ.

    With p the axis of the last dof of the frame before, which takes α, and k the axis of the first dof of the next
    frame, which takes γ, β is all that a constant rotation costs between two frames.
    """
    alpha, m, beta = _turn_to(R[:, k], p, k)
    rest = _about(m, -beta) @ _about(p, -alpha) @ R
    return alpha, m, beta, _angle_of(rest[(k + 2) % 3, (k + 1) % 3], rest[(k + 1) % 3, (k + 1) % 3])


def _turn_to(direction: np.ndarray, p: int, k: int) -> tuple[float, int, float]:
    """α, m and β for which Rp(α) · Rm(β) takes the axis k to a direction."""
    m = 3 - p - k if p != k else 1 if k == 0 else 0
    b, c = (p + 1) % 3, (p + 2) % 3
    u, v = (direction[c], direction[b]) if m == c else (-direction[b], direction[c])
    alpha = _angle_of(u, v)
    turned = _about(p, -alpha) @ direction
    return alpha, m, _angle_of(turned @ np.cross(np.eye(3)[m], np.eye(3)[k]), turned[k])


def _turn_hinge(direction: np.ndarray, p: int) -> tuple[int, int, tuple[int, float], tuple[int, float]]:
    """The fewest rotations that take an axis of a frame to the direction of a hinge: Rp(α) · Rm(β) · e_k times a sign.

    The result is the sign, k, (m, β) and (p, α). Along an axis no rotation is needed. Across the axis p, about which
    the frame before rotates, α is enough, which costs nothing there.
    """
    k = int(np.abs(direction).argmax())
    if np.abs(np.delete(direction, k)).max() <= ROUNDING:
        return 1 if direction[k] > 0.0 else -1, k, (p, 0.0), (p, 0.0)
    k = 0 if p != 0 or abs(direction[p]) > ROUNDING else 1
    alpha, m, beta = _turn_to(direction, p, k)
    return 1, k, (m, beta), (p, alpha)


def absorb(frame: Frame, frames: Frames, shift: np.ndarray) -> None:
    """Move the constant rotations behind a frame into the zeros of angles, or into frames of their own.

    Parents come first, since what they take rotates their children. A child that is a ball joint keeps its rest
    rotation, as the start of its quaternion.
    """
    angular = [child for child in frame.children if child.n_angles > 0]
    if frame.is_ball:
        _choose_axes(frame, angular, frames.offset)
    elif frame.n_angles > 0 and (angular or frame.is_leaf):
        if angular:
            alpha = _alpha_of(frame, angular)
        else:  # rotate the offset into the plane of x and y
            alpha = _angle_of(frames.offset[frame.joints[0], 2], frames.offset[frame.joints[0], 1])
        shift[frame.end_dof - 1] += alpha
        _rotate_behind(frame, _about(frame.axis, -alpha), frames.offset)
    if frame.is_leaf:
        frames.offset[frame.joints[0], 2] = 0.0
    for child in angular:
        if child.hinge is not None:
            candidates = [_turn_hinge(child.rest @ child.hinge, (frame.axis + i) % 3) for i in range(3)]
            sign, axis, *constants = min(candidates, key=lambda one: (one[2][1] != 0.0) + (one[3][1] != 0.0))
            child.axis, frames.sign[child.first_dof] = axis, sign
            turned = _about(*constants[1]) @ _about(*constants[0])
            _rotate_behind(child, turned.T @ child.rest, frames.offset)
        else:
            alpha, m, beta, gamma = _split(child.rest, frame.axis, child.n_dofs - 1)
            shift[child.first_dof] += gamma
            constants = [(m, beta), (frame.axis, alpha)]
        i, upper = frame.children.index(child), child
        for axis, angle in constants:  # from the child up
            if angle != 0.0:
                constant = Frame(None, child.first_dof, child.first_dof, None, 0)
                constant.axis, constant.angle, constant.children = axis, angle, [upper]
                upper.parent, constant.parent, frame.children[i], upper = constant, frame, constant, constant


def _alpha_of(frame: Frame, angular: list[Frame]) -> float:
    """The constant that a frame takes: its first child's, or if that is zero, the first hinge's."""
    first = angular[0]
    alphas = [] if first.hinge is not None else [_split(first.rest, frame.axis, first.n_dofs - 1)[0]]
    alphas += [_turn_hinge(one.rest @ one.hinge, frame.axis)[3][1] for one in angular if one.hinge is not None]
    return next((alpha for alpha in alphas if alpha != 0.0), 0.0)


def _rotate_behind(frame: Frame, back: np.ndarray, offset: np.ndarray) -> None:
    """Rotate what a frame carries by a constant, whose inverse the frame itself takes."""
    for j in frame.joints:
        offset[j] = back @ offset[j]
    for child in frame.children:
        if child.slide is not None:
            child.slide = back @ child.slide
            _rotate_behind(child, back, offset)
        else:
            child.rest = back @ child.rest


def _choose_axes(frame: Frame, angular: list[Frame], offset: np.ndarray) -> None:
    """Choose the axes of a ball joint's frame: the first child's with angles, or x along the first offset."""
    R = np.eye(3)
    first = angular[0] if angular else None
    if first is not None:
        R = first.rest if first.hinge is None else first.rest @ _axes_along(first.hinge)
    elif frame.joints and offset[frame.joints[0]].any():
        R = _axes_along(offset[frame.joints[0]])
    _rotate_behind(frame, R.T, offset)
    if first is not None:
        first.rest = np.eye(3) if first.hinge is None else first.rest
    elif frame.joints:  # exactly along x
        offset[frame.joints[0]] = np.linalg.norm(offset[frame.joints[0]]), 0.0, 0.0
    frame.axes, frame.rest = R, frame.rest @ R


def _axes_along(direction: np.ndarray) -> np.ndarray:
    """A rotation matrix whose first axis is along a vector."""
    x = direction / np.linalg.norm(direction)
    y = np.cross(x, np.eye(3)[np.abs(x).argmin()])
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)], axis=1)
