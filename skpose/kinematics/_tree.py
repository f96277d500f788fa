"""A `Skeleton` as the `Tree` of flat arrays that compiled code sees, and angles in the tree's order.

A skeleton's joints rotate about any axes in any order, have rest rotations, and may be rigid. A tree's frames all
rotate about z, y and x in that order (or the last one or two of these) and have no rest rotation.
`tree_of` gets there in four passes:

1. `_frames`: one frame for each joint with dofs, its axes renamed so that its dofs are about z, y, x. A rigid joint
   shares its parent's frame. The constant rotations that this needs stand before the frames (`rest`).
2. `_absorb`: each rest rotation is split into three rotations about axes. The first goes into the zero of the parent's
   last angle, the last one into the zero of the frame's own first angle (`shift`), where they cost nothing. The middle
   one, if it is not zero, becomes a frame without dofs.
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
from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.tree import Tree
from skpose.skeleton import Skeleton

FLOAT64 = np.dtype(np.float64)

# Constant rotations that differ from the identity by rounding alone are the identity: a frame less per joint.
ROUNDING = 8 * np.finfo(np.float64).eps


class _Frame:
    """A coordinate system that rotates about z, y and x by its dofs; without dofs, about one axis by a constant."""

    def __init__(self, parent: "_Frame | None", first_dof: int, end_dof: int, rest: Any, pivot: int):
        self.parent = parent
        self.first_dof, self.end_dof = first_dof, end_dof
        self.rest = rest  # between the parent and the dofs, until `_absorb` has split it
        self.pivot = pivot
        self.children: list[_Frame] = []
        self.joints: list[int] = []
        self.axis, self.angle = 0, 0.0
        if parent is not None:
            parent.children.append(self)

    @property
    def n_dofs(self) -> int:
        return self.end_dof - self.first_dof

    @property
    def is_tip(self) -> bool:
        return self.n_dofs > 0 and not self.children and len(self.joints) == 1


class _Frames(NamedTuple):
    """The result of the first pass."""

    root: _Frame
    rotating: list[_Frame]  # the root's frame and all frames with dofs, parents first
    offset: np.ndarray  # (n_joints + 1, 3) of each joint from its parent, in the axes of the frame that carries it
    column: list[int]  # as in Tree
    sign: list[int]
    branch: list[int]


@functools.lru_cache(maxsize=64)
def tree_of(skeleton: Skeleton | None, dtype: np.dtype = FLOAT64) -> Tree:
    """Return the skeleton as flat arrays, reals of the given dtype; None is the root alone."""
    frames = _frames(skeleton)
    shift = np.zeros(len(frames.column))
    for frame in frames.rotating:
        _absorb(frame, frames.offset, shift)
    tree = _arrays(skeleton, frames, shift)
    # Left writeable: read-only arrays are another type to numba, and pickling would make them this one.
    return Tree(*(np.ascontiguousarray(a, dtype if a.dtype == float else np.int64) for a in tree))


def to_tree_order(tree: Tree, angles: np.ndarray) -> np.ndarray:
    """Reorder angles (..., n_dofs) from the skeleton's columns to the tree's dofs, about the tree's axes."""
    return np.ascontiguousarray(angles[..., tree.column] * tree.sign)


def from_tree_order(tree: Tree, angles: np.ndarray) -> np.ndarray:
    """Invert `to_tree_order`."""
    columns = np.empty_like(angles)
    columns[..., tree.column] = angles * tree.sign
    return columns


# --- first pass: one frame for each joint with dofs -------------------------------------------------------------------


def _frames(skeleton: Skeleton | None) -> _Frames:
    """Give each joint with dofs a frame.

    Every joint's world orientation is that of a frame times a constant: H_j = K_f · A_j. A rigid joint shares the
    frame of its parent. A joint with dofs has a frame K_f = K_parent · rest · Rz · Ry · Rx of its own.
    """
    root = _Frame(None, 0, 0, None, 0)
    frames = _Frames(root, [root], np.zeros((1, 3)), [], [], [0])
    if skeleton is None:
        return frames
    n_joints, own = skeleton.n_joints, skeleton.offset_frame == "own"
    frame_of, constant = [root] * (n_joints + 1), [np.eye(3)] * (n_joints + 1)  # f and A_j of the root and all joints
    first_column = np.cumsum([0] + [len(bone.dofs) for bone in skeleton.bones])
    for j in _depth_first(skeleton.parents):
        dofs, parent = skeleton.bones[j].dofs, skeleton.parents[j] + 1
        before = constant[parent] @ skeleton.rest_rotations[j]
        if not dofs:
            frame_of[j + 1], constant[j + 1] = frame_of[parent], before
            continue
        columns = list(range(first_column[j], first_column[j + 1]))
        axes = ["xyz".index(axis) for axis in dofs.lower()]
        if dofs.islower():  # extrinsic: the last one listed is the first factor of the product
            columns, axes = columns[::-1], axes[::-1]
        Q, signs = _axes_to_zyx(axes)
        if frame_of[parent] is root and frames.column:
            frames.branch.append(len(frames.column))
        first = len(frames.column)
        frame = _Frame(frame_of[parent], first, first + len(axes), before @ Q.T, parent if own else j + 1)
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


def _absorb(frame: _Frame, offset: np.ndarray, shift: np.ndarray) -> None:
    """Move the constant rotations behind a frame into the zeros of angles, or into frames of their own.

    Parents come first, since their shift rotates their children.
    """
    if frame.n_dofs > 0 and (frame.children or frame.is_tip):
        if frame.children:
            alpha = _split(frame.children[0].rest, frame.children[0].n_dofs)[0]
        else:  # rotate the offset into the plane of x and y
            alpha = _angle_of(offset[frame.joints[0], 2], offset[frame.joints[0], 1])
        shift[frame.end_dof - 1] += alpha
        back = _about(0, -alpha)
        for j in frame.joints:
            offset[j] = back @ offset[j]
        for child in frame.children:
            child.rest = back @ child.rest
        if frame.is_tip:
            offset[frame.joints[0], 2] = 0.0
    for i, child in enumerate(frame.children):
        alpha, m, beta, gamma = _split(child.rest, child.n_dofs)
        shift[child.first_dof] += gamma
        for axis, angle in ((m, beta), (0, alpha)):  # from the child up
            if angle != 0.0:
                constant = _Frame(None, child.first_dof, child.first_dof, None, 0)
                constant.axis, constant.angle, constant.children = axis, angle, [frame.children[i]]
                frame.children[i].parent, constant.parent, frame.children[i] = constant, frame, constant


# --- third pass: the order of frames ----------------------------------------------------------------------------------


def _in_batches(root: _Frame) -> tuple[list[_Frame], list[int], list[int]]:
    """Return all frames, parents first and tips last; of each batch the number of dofs and the first frame."""
    frames, starts = [root], []
    n_dofs: list[int] = []
    waiting, tips = list(root.children), []
    while waiting:
        tips += [frame for frame in waiting if frame.is_tip]
        waiting = [frame for frame in waiting if not frame.is_tip]
        counts = [frame.n_dofs for frame in waiting]
        if not waiting:
            break
        if not n_dofs or n_dofs[-1] not in counts:
            n_dofs.append(max(counts, key=counts.count))
            starts.append(len(frames))
        taken = [frame for frame in waiting if frame.n_dofs == n_dofs[-1]]
        frames += taken
        waiting = [frame for frame in waiting if frame.n_dofs != n_dofs[-1]]
        waiting += [child for frame in taken for child in frame.children]
    starts.append(len(frames))
    return frames + sorted(tips, key=lambda frame: frame.n_dofs), n_dofs, starts


# --- fourth pass: flat arrays -----------------------------------------------------------------------------------------


def _arrays(skeleton: Skeleton | None, built: _Frames, shift: np.ndarray) -> Tree:
    """Return frames and joints as the arrays of a Tree."""
    frames, batch_dofs, first_frame = _in_batches(built.root)
    number: dict[_Frame | None, int] = {frame: f for f, frame in enumerate(frames)}
    order = [0, *(j for frame in frames for j in frame.joints)]  # the skeleton's number of each joint in the tree
    tree_joint = np.argsort(order)
    parents = np.zeros(0, dtype=int) if skeleton is None else skeleton.parents
    joint_frame = np.array([0, *(f for f, frame in enumerate(frames) for _ in frame.joints)])
    ranges = [_dof_ranges(frame) for frame in frames]
    angles = np.array([[frame.angle, frame.angle / 2] for frame in frames])
    fixed_rotation = np.stack([np.cos(angles), np.sin(angles)], axis=2).reshape(-1, 4)
    fixed_rotation[np.abs(fixed_rotation) < ROUNDING] = 0.0  # of right angles
    return Tree(
        frame_parent=np.array([number.get(frame.parent, 0) for frame in frames]),
        first_dof=np.array([frame.first_dof for frame in frames]),
        end_dof=np.array([frame.end_dof for frame in frames]),
        fixed_axis=np.array([frame.axis for frame in frames]),
        fixed_rotation=fixed_rotation,
        weight=np.bincount(joint_frame, np.square(built.offset[order]).sum(axis=1), minlength=len(frames)),
        pivot=tree_joint[[frame.pivot for frame in frames]],
        batch_dofs=np.array(batch_dofs, dtype=int),
        first_frame=np.array(first_frame),
        branch=np.array([*built.branch, len(built.column)]),
        column=np.array(built.column, dtype=int),
        sign=np.array(built.sign, dtype=float),
        shift=shift,
        joint_parent=tree_joint[[0, *(parents + 1)]][order],
        joint_frame=joint_frame,
        offset=built.offset[order],
        skeleton_joint=np.array(order),
        first_run=np.cumsum([0, *map(len, ranges)]),
        runs=np.array([one for frame_ranges in ranges for one in frame_ranges], dtype=int).reshape(-1, 2),
    )


def _dof_ranges(frame: _Frame) -> list[tuple[int, int]]:
    """Return the dofs of a frame and of its ancestors, as ranges that do not touch."""
    ranges: list[tuple[int, int]] = []
    while frame.parent is not None:
        if ranges and ranges[-1][0] == frame.end_dof:
            ranges[-1] = frame.first_dof, ranges[-1][1]
        elif frame.n_dofs > 0:
            ranges.append((frame.first_dof, frame.end_dof))
        frame = frame.parent
    return ranges[::-1]
