"""From a `Skeleton` to the `Tree` of flat arrays that the kernels see."""

import functools

import numpy as np

from skpose._kernels import Tree
from skpose.skeleton import Skeleton

FLOAT64 = np.dtype(np.float64)

# Constant rotations that differ from the identity by rounding alone are the identity: a matrix product less per joint.
ROUNDING = 8 * np.finfo(np.float64).eps


def _axes_to_zyx(axes: list[int]) -> tuple[np.ndarray, list[int]]:
    """A rotation Q that takes the last axis to x, the one before to y, the one before that to ± z; and that sign.

    The rotation about an axis a by θ is Qᵀ·R·Q, with R the rotation by θ about Qa, so a product of rotations about
    any axes is one about z, y and x between Qᵀ and Q.
    """
    Q = np.zeros((3, 3))
    targets = [0, 1, 2]
    for axis, target in zip([*reversed(axes), *(set(range(3)) - set(axes))], targets, strict=True):
        Q[target, axis] = 1.0
    signs = [1] * len(axes)
    if np.linalg.det(Q) < 0:  # the order is left-handed: turn the axis that goes to z about, be there a dof or not
        Q[2] *= -1.0
        if len(axes) == 3:
            signs[0] = -1
    return Q, signs


def _depth_first(parents: np.ndarray) -> list[int]:
    """The joints in an order in which all that hang on one follow it at once."""
    children: list[list[int]] = [[] for _ in range(len(parents) + 1)]  # of the root in the last place, which is -1
    for joint, parent in enumerate(parents):
        children[parent].append(joint)
    order, waiting = [], children[-1][::-1]
    while waiting:
        order.append(waiting.pop())
        waiting.extend(reversed(children[order[-1]]))
    return order


def _runs(frame: int, frame_parent: list[int], first_dof: list[int]) -> list[tuple[int, int]]:
    """The dofs of a frame and of those before it, as ranges that do not touch."""
    runs: list[tuple[int, int]] = []
    while frame > 0:
        first, end = first_dof[frame], first_dof[frame + 1]
        if runs and runs[-1][0] == end:
            runs[-1] = first, runs[-1][1]
        else:
            runs.append((first, end))
        frame = frame_parent[frame]
    return runs[::-1]


@functools.lru_cache(maxsize=64)
def tree_of(skeleton: Skeleton | None, dtype: np.dtype = FLOAT64) -> Tree:
    """The skeleton as flat arrays, reals of the given dtype; None is the root alone, for metrics that need none.

    Every joint's world orientation is that of a frame times a constant: H_j = K_f · A_j. A rigid joint shares the
    frame of its parent; a joint with dofs has a frame K_f = K_parent · rest · Rz · Ry · Rx of its own. Joints are in
    the skeleton's order, frames depth first, so that what hangs on a frame is a range of dofs.
    """
    bones = () if skeleton is None else skeleton.bones
    own = skeleton is not None and skeleton.offset_frame == "own"
    parents = np.zeros(0, dtype=int) if skeleton is None else skeleton.parents
    frame_parent, first_dof, rest, pivot, column, sign = [0], [0, 0], [np.eye(3)], [0], [], []
    branch = [0]
    frame_of, constant = [0] * (len(bones) + 1), [np.eye(3)] * (len(bones) + 1)  # f and A_j of the root and all joints
    first_column = np.cumsum([0] + [len(bone.dofs) for bone in bones])
    for j in _depth_first(parents):
        dofs, parent = bones[j].dofs, parents[j] + 1
        before = constant[parent] @ skeleton.rest_rotations[j]
        if not dofs:
            frame_of[j + 1], constant[j + 1] = frame_of[parent], before
            continue
        columns = list(range(first_column[j], first_column[j + 1]))
        axes = ["xyz".index(axis) for axis in dofs.lower()]
        if dofs.islower():  # extrinsic: the last one listed is the first factor of the product
            columns, axes = columns[::-1], axes[::-1]
        Q, signs = _axes_to_zyx(axes)
        if frame_of[parent] == 0 and column:
            branch.append(len(column))
        frame_of[j + 1], constant[j + 1] = len(rest), Q
        frame_parent.append(frame_of[parent])
        first_dof.append(first_dof[-1] + len(axes))
        rest.append(before @ Q.T)
        pivot.append(parent if own else j + 1)
        column.extend(columns)
        sign.extend(signs)
    holders = [0, *(np.arange(1, len(bones) + 1) if own else parents + 1)]  # in whose axes each offset is given
    joint_frame = [frame_of[holder] for holder in holders]
    offset = [
        np.zeros(3),
        *(constant[h] @ o for h, o in zip(holders[1:], skeleton.offsets if bones else (), strict=True)),
    ]
    runs = [_runs(frame, frame_parent, first_dof) for frame in range(len(rest))]
    rest = np.array(rest)
    at_rest = np.abs(rest - np.eye(3)).max(axis=(1, 2)) < ROUNDING
    rest[at_rest] = np.eye(3)
    weight = np.bincount(joint_frame, np.square(offset).sum(axis=1), minlength=len(rest))
    tree = Tree(
        frame_parent=np.array(frame_parent),
        first_dof=np.array(first_dof),
        at_rest=at_rest,
        rest=rest,
        weight=weight,
        pivot=np.array(pivot),
        branch=np.array([*branch, len(column)]),
        column=np.array(column, dtype=int),
        sign=np.array(sign, dtype=float),
        joint_parent=np.array([-1, *(parents + 1)]),
        joint_frame=np.array(joint_frame),
        offset=np.array(offset),
        first_run=np.cumsum([0, *map(len, runs)]),
        runs=np.array([run for frame_runs in runs for run in frame_runs], dtype=int).reshape(-1, 2),
    )
    # Left writeable: read-only arrays are another type to numba, and pickling would make them this one.
    return Tree(*(np.ascontiguousarray(a, dtype if a.dtype == float else np.int64) for a in tree))
