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

import numpy as np

from skpose._compiled.pose.tree import TWO_PI, Tree
from skpose.kinematics._frames import ROUNDING, Frame, Frames, absorb, frames_of
from skpose.skeleton import Skeleton
from skpose.skeleton._selection import with_carriers

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
    slides = [frame for frame, _ in built.slides]
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
    joint_slide[tree_joint[[j for _, j in built.slides]]] = np.arange(len(slides))
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
