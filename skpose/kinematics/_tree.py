"""A `Skeleton` as the `Tree` of flat arrays that compiled code sees, and angles in the tree's order.

A skeleton's joints rotate about any axes in any order, or freely, have rest rotations, and may be rigid, or slide. A
tree's frames all rotate about z, y and x in that order (or the last one or two of these), about one of these, or
freely. They have no rest rotation.
`tree_of` gets there in four passes:

1. `frames_of`: one frame for each joint with dofs, its axes renamed so that its dofs are about z, y, x. A rigid joint
   shares its parent's frame; the frame of a slide does not rotate. The constant rotations that this needs stand before
   the frames (`rest`).
2. `absorb`: each rest rotation is split into three rotations about axes. The first goes into the zero of the parent's
   last angle, the last one into the zero of the frame's own first angle (`shift`), where they cost nothing. The middle
   one, if it is not zero, becomes a frame without dofs. The frame of a hinge is free except for its axis, which may be
   any of three: hinges about parallel axes, or about axes at right angles, need no such frame. A ball joint takes any
   rest rotation into its quaternion, and its axes are chosen so that what follows is simple.
3. `_in_batches`: frames in the order in which they are computed.
4. `_arrays`: all of it as flat arrays.

An example: an upper arm with three dofs, a forearm with one, about y.

>>> from skpose import Bone, Skeleton
>>> arm = Skeleton([Bone("elbow", None, (0.3, 0, 0), "xyz"), Bone("wrist", "elbow", (0.25, 0, 0), "y")])
>>> tree = tree_of(arm)

The product of rotations of "xyz" is Rz·Ry·Rx, so the three columns of the elbow come in the order 2, 1, 0. Then the
wrist's:

>>> tree.column
array([2, 1, 0, 3])

The wrist's only dof is about y, and the tree wants the last dof about x. So pass 1 renames the axes of its frame by a
rotation Q that takes y to x (and x to y, and z to −z): R_y(θ) = Qᵀ·R_x(θ)·Q. The offset becomes Q·(0.25, 0, 0):

>>> tree.offset[2].round(2)  # from the elbow to the wrist, in the wrist's frame
array([0.  , 0.25, 0.  ])

Qᵀ stands as a rest rotation between the two frames. Pass 2 splits it: Qᵀ = Rx(α)·Ry(β)·Rx(γ), with α = γ = −π/2.
α is added to the elbow's rotation about x and γ to the wrist's angle. What is left is β, a rotation about y by a right
angle, in a frame of its own. So the tree has the root's frame, the elbow's, the constant one, and the wrist's:

>>> tree.shift.round(2)
array([ 0.  ,  0.  , -1.57, -1.57])
>>> tree.frame_parent, tree.end_dof - tree.first_dof
(array([0, 0, 1, 2]), array([0, 3, 0, 1]))
"""

import functools
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.pose.chart import chart_at, pose_of
from skpose._compiled.pose.jacobian import position_jacobians
from skpose._compiled.pose.tree import BALL, HINGE, TWO_PI, Tree
from skpose.skeleton._bone import with_columns
from skpose.skeleton._skeleton import Skeleton, with_carriers

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


# --- first pass: one frame for each joint with dofs -------------------------------------------------------------------


def frames_of(skeleton: Skeleton | None) -> Frames:
    """Give each joint with dofs a frame.

    Every joint's world orientation is a frame's times a constant: H_j = K_f · A_j. A rigid joint shares the
    frame of its parent. A joint with dofs has a frame K_f = K_parent · rest · Rz · Ry · Rx of its own.
    """
    root = Frame(None, 0, 0, None, 0)
    frames = Frames([root], np.zeros((1, 3)), [], [])
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
        frame_of[j + 1], constant[j + 1] = frame, Q
        frames.moving.append(frame)
        frames.column.extend(columns)
        frames.sign.extend(signs)
    offset = np.zeros((n_joints + 1, 3))
    carriers = np.arange(1, n_joints + 1) if own else skeleton.parents + 1  # the joints whose axes the offsets are in
    for j, carrier in enumerate(carriers, start=1):
        offset[j] = constant[carrier] @ skeleton.offsets[j - 1]
        # A slide moves its own joint, its frame's first, also where the offset is in the axes of the parent.
        frame_of[j if bones[j - 1][0].is_slide else carrier].joints.append(j)
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
            _rotate_behind(child, (_about(*constants[1]) @ _about(*constants[0])).T @ child.rest, frames.offset)
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


# --- tree -------------------------------------------------------------------------------------------------------------


FLOAT64 = np.dtype(np.float64)


@functools.lru_cache(maxsize=64)
def tree_of(skeleton: Skeleton | None, dtype: np.dtype = FLOAT64) -> Tree:
    """The joints that count in distances as flat arrays, reals of the given dtype; None is the root alone.

    Joints without weight that carry no joint with weight are left out, with their columns.
    """
    if skeleton is None:
        return _as_arrays(None, np.zeros(0, dtype=int), np.zeros(0), dtype)
    part = _drop_weightless(skeleton)
    return _as_arrays(part, part.columns_in(skeleton), skeleton.weights[counted_joints(skeleton)], dtype)


def counted_joints(skeleton: Skeleton) -> np.ndarray:
    """The indices of the joints of `tree_of`, in the order of its positions."""
    number = {name: j for j, name in enumerate(skeleton.joint_names)}
    return np.array([number[name] for name in _drop_weightless(skeleton).joint_names])


def _drop_weightless(skeleton: Skeleton) -> Skeleton:
    """The part of a skeleton that counts: joints with weight, and joints that carry them."""
    bones = with_carriers(skeleton, np.array(skeleton.joint_names)[skeleton.weights > 0.0])
    return replace(skeleton, bones=bones) if any(bone.dofs for bone in bones) else skeleton


@functools.lru_cache(maxsize=64)
def tree_of_all_joints(skeleton: Skeleton) -> Tree:
    """The skeleton as flat arrays, each joint of weight one."""
    return _as_arrays(skeleton, np.arange(skeleton.n_dofs), np.ones(skeleton.n_joints), FLOAT64)


def _as_arrays(skeleton: Skeleton | None, columns: np.ndarray, weights: np.ndarray, dtype: np.dtype) -> Tree:
    """A skeleton as flat arrays; `columns` are its dofs' columns in an array of poses."""
    frames = frames_of(skeleton)
    shift = np.zeros(len(frames.column))
    for frame in frames.moving:
        absorb(frame, frames, shift)
    tree = _arrays(skeleton, frames, shift, np.concatenate([[0.0], np.sqrt(weights)]))
    tree = tree._replace(column=columns[tree.column])
    # Left writeable: read-only arrays are another type to numba, and pickling would make them this one.
    return Tree(*(np.ascontiguousarray(a, dtype if a.dtype == float else np.int64) for a in tree))


def to_tree_order(tree: Tree, poses: np.ndarray) -> np.ndarray:
    """Reorder poses (..., n_dofs) from the skeleton's columns to the tree's dofs, about the tree's axes."""
    dofs = np.ascontiguousarray(poses[..., tree.column] * tree.sign)
    for f in tree.ball_frame:
        ball = slice(tree.first_dof[f], tree.end_dof[f])
        dofs[..., ball] = dofs[..., ball] @ tree.ball_axes[f].T
    return dofs


def from_tree_order(tree: Tree, dofs: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Invert `to_tree_order`: a copy of poses (..., n_dofs) with the tree's columns from its dofs."""
    dofs, poses = dofs * tree.sign, poses.copy()
    for f in tree.ball_frame:
        ball = slice(tree.first_dof[f], tree.end_dof[f])
        dofs[..., ball] = dofs[..., ball] @ tree.ball_axes[f]
    poses[..., tree.column] = dofs
    return poses


def wrap_dofs(tree: Tree, dofs: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Wrap the differences of angles from another pose to [−π, π]; poses are in the tree's order."""
    dofs = dofs.copy()
    angles = dofs[..., tree.angle_dof]
    dofs[..., tree.angle_dof] = angles - TWO_PI * np.rint((angles - near[..., tree.angle_dof]) / TWO_PI)
    return dofs


# --- third pass: the order of frames ----------------------------------------------------------------------------------


def _in_batches(root: Frame) -> tuple[list[Frame], list[int], list[int]]:
    """All frames, parents first and leaves last; of each batch the kind and the first frame."""
    frames, starts = [root], []
    kinds: list[int] = []
    waiting, leaves = list(root.children), []
    while inner := [frame for frame in waiting if not frame.is_leaf]:
        leaves += [frame for frame in waiting if frame.is_leaf]
        counts = [frame.kind for frame in inner]
        if not kinds or kinds[-1] not in counts:
            kinds.append(max(counts, key=counts.count))
            starts.append(len(frames))
        taken = [frame for frame in inner if frame.kind == kinds[-1]]
        frames += taken
        waiting = [frame for frame in inner if frame.kind != kinds[-1]]
        waiting += [child for frame in taken for child in frame.children]
    leaves += waiting
    starts.append(len(frames))
    return frames + sorted(leaves, key=lambda frame: frame.kind), kinds, starts


# --- fourth pass: flat arrays -----------------------------------------------------------------------------------------


def _arrays(skeleton: Skeleton | None, built: Frames, shift: np.ndarray, scale: np.ndarray) -> Tree:
    """Frames and joints as the arrays of a Tree; with scales of the root and of the joints."""
    frames, batch_kind, first_frame = _in_batches(built.moving[0])
    balls = [f for f, frame in enumerate(frames) if frame.is_ball]
    is_angle = np.zeros(len(built.column), dtype=bool)
    for frame in built.moving:
        is_angle[frame.first_dof : frame.end_dof] = frame.n_angles > 0
    slides = [frame for frame in built.moving if frame.slide is not None]
    n_angles_to = np.concatenate([[0], np.cumsum(is_angle)])
    reference = np.tile([1.0, 0.0, 0.0, 0.0], (len(frames), 1))
    if balls:
        from scipy.spatial.transform import Rotation  # 0.1 s to import, for ball joints only

        reference[balls] = Rotation.from_matrix([frames[f].rest for f in balls]).as_quat()[:, [3, 0, 1, 2]]
    end_dof = np.array([frame.end_dof for frame in frames])
    number: dict[Frame | None, int] = {frame: f for f, frame in enumerate(frames)}
    order = [0, *(j for frame in frames for j in frame.joints)]  # the skeleton's number of each joint in the tree
    tree_joint = np.argsort(order)
    parents = np.zeros(0, dtype=int) if skeleton is None else skeleton.parents
    joint_frame = np.array([0, *(f for f, frame in enumerate(frames) for _ in frame.joints)])
    ranges = [_dof_ranges(frame) for frame in frames]
    weighted_squares = np.square(scale[order]) * np.square(built.offset[order]).sum(axis=1)
    joint_slide = np.full(len(order), -1)
    joint_slide[tree_joint[[frame.joints[0] for frame in slides]]] = np.arange(len(slides))
    angles = np.array([[frame.angle, frame.angle / 2] for frame in frames])
    fixed_rotation = np.stack([np.cos(angles), np.sin(angles)], axis=2).reshape(-1, 4)
    fixed_rotation[np.abs(fixed_rotation) < ROUNDING] = 0.0  # of right angles
    return Tree(
        frame_parent=np.array([number.get(frame.parent, 0) for frame in frames]),
        first_dof=np.array([frame.first_dof for frame in frames]),
        end_dof=end_dof,
        end_angle=n_angles_to[end_dof],
        ball=np.array([balls.index(f) if f in balls else -1 for f in range(len(frames))]),
        reference=reference,
        ball_axes=np.stack([frame.axes.T for frame in frames]),
        single_axis=np.array([frame.axis for frame in frames]),
        fixed_rotation=fixed_rotation,
        weight=np.bincount(joint_frame, weighted_squares, minlength=len(frames)),
        pivot=tree_joint[[frame.pivot for frame in frames]],
        batch_kind=np.array(batch_kind, dtype=int),
        first_frame=np.array(first_frame),
        column=np.array(built.column, dtype=int),
        sign=np.array(built.sign, dtype=float),
        shift=shift,
        angle_dof=np.flatnonzero(is_angle),
        slide=np.array([slides.index(frame) if frame in slides else -1 for frame in frames]),
        slide_dof=np.array([frame.first_dof for frame in slides], dtype=int),
        slide_axis=np.array([frame.slide for frame in slides], dtype=float).reshape(-1, 3),
        joint_slide=joint_slide,
        ball_frame=np.array(balls, dtype=int),
        first_joint=_joint_ranges(frames, joint_frame, joint_slide, built.offset[order], scale[order], first_frame[-1]),
        first_leaf=_leaf_ranges(frames, joint_frame, scale[order], first_frame[-1]),
        joint_parent=tree_joint[[0, *(parents + 1)]][order],
        joint_frame=joint_frame,
        offset=built.offset[order],
        scale=scale[order],
        code_joint=np.array(order),
        first_dof_range=np.cumsum([0, *map(len, ranges)]),
        dof_ranges=np.array([one for frame_ranges in ranges for one in frame_ranges], dtype=int).reshape(-1, 2),
    )


def _joint_ranges(
    frames: list[Frame],
    joint_frame: np.ndarray,
    joint_slide: np.ndarray,
    offset: np.ndarray,
    scale: np.ndarray,
    first_leaf: int,
) -> np.ndarray:
    """The starts of ranges of joints, in turns: other joints, ball joints' children along x, slides.

    Three ranges in a row have one weight.
    """
    moving = [j for j, f in enumerate(joint_frame) if 0 < f < first_leaf]
    starts = moving[:1] or [0]
    for j in moving:
        along_x = frames[joint_frame[j]].is_ball and not offset[j, 1:].any()
        kind = 2 if joint_slide[j] >= 0 else 1 if along_x else 0
        if scale[j] != scale[starts[-1]]:
            starts += [j] * (3 - (len(starts) - 1) % 3)
        starts += [j] * ((kind - (len(starts) - 1)) % 3)
    end = moving[-1] + 1 if moving else 0
    return np.array(starts + [end] * (3 - (len(starts) - 1) % 3))


def _leaf_ranges(frames: list[Frame], joint_frame: np.ndarray, scale: np.ndarray, first_leaf: int) -> np.ndarray:
    """The starts of ranges of leaves' joints of one weight, and of the joints of ball joints."""
    leaves = [j for j, f in enumerate(joint_frame) if f >= first_leaf and not frames[f].is_ball]
    end = len(joint_frame) - sum(f >= first_leaf and frames[f].is_ball for f in joint_frame)
    return np.array([j for j in leaves if j == leaves[0] or scale[j] != scale[j - 1]] + [end])


def _dof_ranges(frame: Frame) -> list[tuple[int, int]]:
    """The dofs of a frame and of its ancestors, as ranges that do not touch."""
    ranges: list[tuple[int, int]] = []
    while frame.parent is not None:
        if ranges and ranges[-1][0] == frame.end_dof:
            ranges[-1] = frame.first_dof, ranges[-1][1]
        elif frame.n_dofs > 0:
            ranges.append((frame.first_dof, frame.end_dof))
        frame = frame.parent
    return ranges[::-1]


# --- chart ------------------------------------------------------------------------------------------------------------
# Derivatives at a pose and steps from it, in the chart at the pose: rotations of ball joints about their own axes.


STEP = 1e-5  # of differences, rad: their error is some 1e-10 relative to the derivative


def jacobian_at(tree: Tree, pose: np.ndarray, frees_angles: bool) -> np.ndarray:
    """The derivative (3 n_joints, n_dofs) of scaled positions in the chart at a pose."""
    free, coordinates = chart_at(tree, pose, frees_angles)
    jacobians = np.empty((1, 3 * len(tree.offset) - 3, len(pose)))
    position_jacobians(coordinates[None], free, jacobians)
    return jacobians[0]


def retract(tree: Tree, pose: np.ndarray, step: np.ndarray, frees_angles: bool) -> np.ndarray:
    """Move a pose by a step in the chart at the pose."""
    free, coordinates = chart_at(tree, pose, frees_angles)
    return pose_of(tree, free, coordinates + step, pose)


def columns_around(
    tree: Tree, pose: np.ndarray, step: np.ndarray, shifts: np.ndarray, others: np.ndarray, frees_angles: bool
) -> np.ndarray:
    """The columns of the pose a step away, and of those shifts (n, n_dofs) further and shifts back.

    Dofs that move no joint are those of `others`.
    """
    free, coordinates = chart_at(tree, pose, frees_angles)
    ends = coordinates + step + np.concatenate([np.zeros((1, len(pose))), shifts, -shifts])
    near = np.stack([pose_of(tree, free, end, pose) for end in ends])
    return from_tree_order(tree, near, np.repeat(others[None], len(near), axis=0))
