"""From a `Skeleton` to the `Tree` of flat arrays that the kernels see."""

import functools

import numpy as np

from skpose._compiled.tree import Tree
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


def _about(axis: int, angle: float) -> np.ndarray:
    """Rotation about a coordinate axis."""
    b, c = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[b, b] = R[c, c] = np.cos(angle)
    R[c, b] = np.sin(angle)
    R[b, c] = -R[c, b]
    return R


def _angle_of(u: float, v: float) -> float:
    """Direction of the vector (v, u); nought where it is so but for rounding."""
    angle = np.arctan2(u, v) if max(abs(u), abs(v)) > ROUNDING else 0.0
    return float(angle) if abs(angle) > ROUNDING else 0.0


def _split(R: np.ndarray, n_dofs: int) -> tuple[float, int, float, float]:
    """α, m, β and γ of R = Rx(α) · Rm(β) · Rk(γ), with k the axis of the first of so many dofs: z, y or x.

    β turns about y, or about z where k is y. The last frame's x takes α and the next frame's first dof takes γ, so
    that β is all that a constant rotation costs between two frames.
    """
    k, m = n_dofs - 1, 2 if n_dofs == 2 else 1
    other = 3 - m  # of y and z
    sign = 1.0 if m == 2 else -1.0
    alpha = _angle_of(sign * R[m, k], R[other, k])
    turned = _about(0, -alpha) @ R
    a, b = (2, 0) if m == 1 else (0, 1)  # the axes that a turn about m mixes
    along, across = (a, b) if k == a else (b, a)
    beta = _angle_of(turned[across, k] * (1.0 if along == a else -1.0), turned[along, k])
    turned = _about(m, -beta) @ turned
    return alpha, m, beta, _angle_of(turned[(k + 2) % 3, (k + 1) % 3], turned[(k + 1) % 3, (k + 1) % 3])


class _Frame:
    """A coordinate system that turns about z, y and x by its dofs; without dofs, about one axis by a constant."""

    def __init__(self, parent, first_dof, end_dof, rest, pivot):
        self.parent: _Frame | None = parent
        self.first_dof, self.end_dof = first_dof, end_dof
        self.rest = rest  # between the parent and the dofs, until `_settle` has taken it apart
        self.pivot = pivot
        self.children: list[_Frame] = []
        self.joints: list[int] = []
        self.axis, self.turn = 0, 0.0
        if parent is not None:
            parent.children.append(self)

    @property
    def n_dofs(self) -> int:
        return self.end_dof - self.first_dof

    @property
    def is_tip(self) -> bool:
        return self.n_dofs > 0 and not self.children and len(self.joints) == 1


def _settle(frame: _Frame, offset: np.ndarray, shift: np.ndarray) -> None:
    """Put the constant rotations behind this frame into the zeros of the angles, or into frames of their own.

    Parents come first, since what they give to their angles turns what hangs on them.
    """
    if frame.n_dofs > 0 and (frame.children or frame.is_tip):
        if frame.children:
            alpha = _split(frame.children[0].rest, frame.children[0].n_dofs)[0]
        else:  # turn the offset into the plane of x and y
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
        for axis, turn in ((m, beta), (0, alpha)):  # from the child up
            if turn != 0.0:
                fixed = _Frame(None, child.first_dof, child.first_dof, None, 0)
                fixed.axis, fixed.turn, fixed.children = axis, turn, [frame.children[i]]
                frame.children[i].parent, fixed.parent, frame.children[i] = fixed, frame, fixed


def _in_batches(root: _Frame) -> tuple[list[_Frame], list[int], list[int]]:
    """All frames, parents first and tips last, and what starts and is in each batch of equally many dofs."""
    frames, n_dofs, starts = [root], [], []
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


def _runs(frame: _Frame) -> list[tuple[int, int]]:
    """The dofs of a frame and of those before it, as ranges that do not touch."""
    runs: list[tuple[int, int]] = []
    while frame.parent is not None:
        if runs and runs[-1][0] == frame.end_dof:
            runs[-1] = frame.first_dof, runs[-1][1]
        elif frame.n_dofs > 0:
            runs.append((frame.first_dof, frame.end_dof))
        frame = frame.parent
    return runs[::-1]


@functools.lru_cache(maxsize=64)
def tree_of(skeleton: Skeleton | None, dtype: np.dtype = FLOAT64) -> Tree:
    """The skeleton as flat arrays, reals of the given dtype; None is the root alone, for metrics that need none.

    Every joint's world orientation is that of a frame times a constant: H_j = K_f · A_j. A rigid joint shares the
    frame of its parent; a joint with dofs has a frame K_f = K_parent · rest · Rz · Ry · Rx of its own, and the rest is
    then taken apart.
    """
    bones = () if skeleton is None else skeleton.bones
    own = skeleton is not None and skeleton.offset_frame == "own"
    parents = np.zeros(0, dtype=int) if skeleton is None else skeleton.parents
    root = _Frame(None, 0, 0, None, 0)
    turning = [root]
    frame_of, constant = [root] * (len(bones) + 1), [np.eye(3)] * (len(bones) + 1)  # f and A_j of the root, all joints
    column, sign, branch = [], [], [0]
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
        if frame_of[parent] is root and column:
            branch.append(len(column))
        first, end = len(column), len(column) + len(axes)
        constant[j + 1] = Q
        frame_of[j + 1] = _Frame(frame_of[parent], first, end, before @ Q.T, parent if own else j + 1)
        turning.append(frame_of[j + 1])
        column.extend(columns)
        sign.extend(signs)
    holders = [0, *(np.arange(1, len(bones) + 1) if own else parents + 1)]  # in whose axes each offset is given
    offset = np.zeros((len(bones) + 1, 3))
    for j, holder in enumerate(holders[1:], start=1):
        offset[j] = constant[holder] @ skeleton.offsets[j - 1]
        frame_of[holder].joints.append(j)
    shift = np.zeros(len(column))
    for frame in turning:
        _settle(frame, offset, shift)
    frames, batch_dofs, first_frame = _in_batches(root)
    number = {frame: f for f, frame in enumerate(frames)}
    order = [0, *(j for frame in frames for j in frame.joints)]  # the skeleton's number of each joint in the tree
    place = np.argsort(order)
    joint_frame = np.array([0, *(f for f, frame in enumerate(frames) for _ in frame.joints)])
    runs = [_runs(frame) for frame in frames]
    turns = np.array([[frame.turn, frame.turn / 2] for frame in frames])
    fixed_turn = np.stack([np.cos(turns), np.sin(turns)], axis=2).reshape(-1, 4)
    fixed_turn[np.abs(fixed_turn) < ROUNDING] = 0.0  # of quarter turns
    tree = Tree(
        frame_parent=np.array([number.get(frame.parent, 0) for frame in frames]),
        first_dof=np.array([frame.first_dof for frame in frames]),
        end_dof=np.array([frame.end_dof for frame in frames]),
        fixed_axis=np.array([frame.axis for frame in frames]),
        fixed_turn=fixed_turn,
        weight=np.bincount(joint_frame, np.square(offset[order]).sum(axis=1), minlength=len(frames)),
        pivot=place[[frame.pivot for frame in frames]],
        batch_dofs=np.array(batch_dofs, dtype=int),
        first_frame=np.array(first_frame),
        branch=np.array([*branch, len(column)]),
        column=np.array(column, dtype=int),
        sign=np.array(sign, dtype=float),
        shift=shift,
        joint_parent=place[[0, *(parents + 1)]][order],
        joint_frame=joint_frame,
        offset=offset[order],
        place=np.array(order),
        first_run=np.cumsum([0, *map(len, runs)]),
        runs=np.array([run for frame_runs in runs for run in frame_runs], dtype=int).reshape(-1, 2),
    )
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
