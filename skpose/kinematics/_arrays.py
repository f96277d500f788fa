"""Positions and distances of poses in arrays of torch, JAX, CuPy and other libraries of the array API standard.

The formulas and the `Tree` of `skpose._compiled`, in array operations that every library has. The operations do not
depend on values, so ``torch.compile`` and ``jax.jit`` can trace them, and each joint has its own arrays over pairs and
steps, so compilers can fuse them. Where a formula has 0/0, both branches of a `where` are finite, since gradients
flow through both.

`array_api_compat`, which scikit-learn vendors, would hide torch's functions behind its own, where ``torch.compile``
stops. The functions used here have the same arguments in all libraries.
"""

import functools
import itertools
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
from sklearn.utils import gen_batches

from skpose._compiled.pose.rotation import TIE
from skpose._compiled.pose.tree import TWO_PI, Tree
from skpose._utils.validation import check_skeleton, check_width
from skpose.kinematics._tree import tree_of, tree_of_all_joints
from skpose.skeleton import Skeleton
from skpose.skeleton._bone import with_columns

Array: TypeAlias = Any  # of any library
Numbers: TypeAlias = Sequence[Any]  # of a quaternion (w, x, y, z) or a point: floats or arrays
TINY = 1e-16  # squared angle below which its sine is the angle, and its cosine 1


def namespace_of(*arrays: Any) -> Any:
    """The namespace of arrays of another library than numpy; None if they are of numpy, or no arrays."""
    found = [_namespace(X) for X in arrays if X is not None]
    if any(one is not found[0] for one in found):
        kinds = " and ".join(type(X).__name__ for X in arrays)
        raise TypeError(f"arrays must be of one library, got {kinds}")
    return found[0]


def _namespace(X: Any) -> Any:
    if isinstance(X, (np.ndarray, np.generic)):
        return None
    for name, kind in (("torch", "Tensor"), ("cupy", "ndarray")):  # these arrays do not name their namespace
        if name in sys.modules and isinstance(X, getattr(sys.modules[name], kind)):
            return sys.modules[name]
    return X.__array_namespace__() if hasattr(X, "__array_namespace__") else None


def _untraced(function: Callable) -> Callable:
    """The function; torch.compile runs it as it is and takes the result for constant."""
    dynamo = sys.modules.get("torch._dynamo")
    return function if dynamo is None else dynamo.disable(function)


def _plan_for(xp: Any, skeleton: Skeleton, all_joints: bool, **poses: Array) -> Any:
    """The plan of a skeleton, after a check of shapes and types; values are not read."""
    check_skeleton(skeleton)
    for name, X in poses.items():
        if X.ndim != 2:
            raise ValueError(f"{name} must have shape (n_poses, {skeleton.n_dofs}), got {tuple(X.shape)}")
        check_width(X, skeleton, name)
        xp.finfo(X.dtype)  # refuses integers
    return _plan_of(skeleton, all_joints)


@functools.lru_cache(maxsize=64)
def _plan_of(skeleton: Skeleton, all_joints: bool) -> Any:
    """A tree as lists, `ball_axes` and `reference` of shape (..., n_balls, 1)."""
    tree = tree_of_all_joints(skeleton) if all_joints else tree_of(skeleton)
    axes = np.moveaxis(tree.ball_axes[tree.ball_frame], 0, -1)[..., None]
    reference = tree.reference[tree.ball_frame].T[..., None]
    return Tree(*(a.tolist() for a in tree._replace(ball_axes=axes, reference=reference)))


# --- rotations --------------------------------------------------------------------------------------------------------


def constant(xp: Any, numbers: list, like: Array) -> Array:
    device = {"device": like.device} if xp.__name__ == "torch" else {}
    return xp.asarray(numbers, dtype=like.dtype, **device)


def at_least_tiny(xp: Any, square: Array) -> Array:
    """A square whose root has a finite derivative."""
    return xp.where(square > TINY, square, TINY)


def root(xp: Any, square: Array) -> Array:
    """The square root, with a derivative of zero at zero."""
    positive = square > 0.0
    return xp.where(positive, xp.sqrt(xp.where(positive, square, 1.0)), 0.0)


def product(p: Numbers, q: Numbers) -> Numbers:
    """The rotation q, then p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def rotate(q: Numbers, axis: int, cos: Any, sin: Any) -> Numbers:
    """The rotation about an axis, given the cosine and sine of half the angle, then q."""
    w, x, y, z = q[0], *(q[1 + (axis + i) % 3] for i in range(3))
    turned = cos * x + sin * w, cos * y + sin * z, cos * z - sin * y
    return [cos * w - sin * x, *(turned[(i - axis) % 3] for i in range(3))]


def _add_along(p: Numbers, q: Numbers, axis: int, length: Any) -> Numbers:
    """The point p plus a length along an axis that q has rotated."""
    w, x, y, z = q[0], *(q[1 + (axis + i) % 3] for i in range(3))
    twice = 2.0 * length
    shift = length - twice * (y * y + z * z), twice * (x * y + w * z), twice * (x * z - w * y)
    return [number + shift[(i - axis) % 3] for i, number in enumerate(p)]


def quaternion_of(xp: Any, x: Array, y: Array, z: Array) -> Numbers:
    """The quaternion of a rotation vector."""
    angle = xp.sqrt(at_least_tiny(xp, x * x + y * y + z * z))
    share = xp.sin(0.5 * angle) / angle
    return xp.cos(0.5 * angle), share * x, share * y, share * z


def _canonical(xp: Any, q: Numbers) -> Numbers:
    """The one of q and −q whose first number that is not rounding is positive."""
    first = q[3]
    for number in (q[2], q[1], q[0]):
        first = xp.where(xp.abs(number) > TIE, number, first)
    return [xp.where(first < 0.0, -number, number) for number in q]


# --- joints -----------------------------------------------------------------------------------------------------------


def _split_dofs(plan: Any, code: Array) -> tuple[Array, Numbers, Array]:
    """Angles, quaternions and slides of a code of `_encode_dofs`, joints first."""
    n_angles, n_balls = len(plan.angle_dof), len(plan.ball_frame)
    ends = [n_angles + i * n_balls for i in range(5)]
    return code[:n_angles, ...], [code[i:j, ...] for i, j in itertools.pairwise(ends)], code[ends[-1] :, ...]


def _encode_dofs(xp: Any, X: Array, plan: Any, wrap: bool) -> Array:
    """Angles, quaternions and slides of poses as one array (n_codes, n_poses)."""

    def rows(dofs: Iterable[int]) -> Array:
        return xp.stack([X[:, plan.column[d]] for d in dofs], axis=0)

    parts = []
    if plan.angle_dof:
        angles = rows(plan.angle_dof) * constant(xp, [[plan.sign[d]] for d in plan.angle_dof], X)
        parts.append(angles - TWO_PI * xp.round(angles * (1.0 / TWO_PI)) if wrap else angles)
    if plan.ball_frame:
        x, y, z = (rows(plan.first_dof[f] + i for f in plan.ball_frame) for i in range(3))
        axes = [[constant(xp, numbers, X) for numbers in row] for row in plan.ball_axes]
        before = [constant(xp, numbers, X) for numbers in plan.reference]
        turned = quaternion_of(xp, *(row[0] * x + row[1] * y + row[2] * z for row in axes))
        parts += _canonical(xp, product(before, turned))
    if plan.slide_dof:
        parts.append(rows(plan.slide_dof))
    return xp.concat(parts, axis=0)


def _place(
    xp: Any, plan: Any, half: Callable[[int], Array], ball: Callable[[int], Numbers], slide: Callable[[int], Array]
) -> tuple[list[Numbers], list[Numbers]]:
    """The world orientations of frames and the positions of joints; constant ones as floats.

    The functions return half of an angle, the quaternion of a ball joint and the displacement of a slide by its index.
    """
    Q: list[Numbers] = [(1.0, 0.0, 0.0, 0.0)]
    P: list[Numbers] = [(0.0, 0.0, 0.0)]
    for f in range(1, len(plan.frame_parent)):
        q, end = Q[plan.frame_parent[f]], plan.end_dof[f]
        if plan.ball[f] >= 0:
            q = product(q, ball(plan.ball[f]))
        elif plan.first_dof[f] == end:
            q = rotate(q, plan.single_axis[f], *plan.fixed_rotation[f][2:])
        elif plan.slide[f] < 0:
            for d in range(plan.first_dof[f], end):
                angle = half(plan.angle_dof.index(d)) + 0.5 * plan.shift[d]
                q = rotate(q, plan.single_axis[f] + end - 1 - d, xp.cos(angle), xp.sin(angle))
        Q.append(q)
    for j in range(1, len(plan.offset)):
        p, q, k = P[plan.joint_parent[j]], Q[plan.joint_frame[j]], plan.joint_slide[j]
        for axis, length in enumerate(plan.offset[j]):
            if k >= 0 and plan.slide_axis[k][axis] != 0.0:
                p = _add_along(p, q, axis, length + plan.slide_axis[k][axis] * slide(k))
            elif length != 0.0:
                p = _add_along(p, q, axis, length)
        P.append(p)
    return Q, P


def _place_poses(xp: Any, X: Array, plan: Any) -> tuple[list[Numbers], list[Numbers]]:
    """`_place` for poses, all as arrays (n_poses,)."""
    angles, balls, slides = _split_dofs(plan, _encode_dofs(xp, X, plan, False))
    Q, P = _place(
        xp,
        plan,
        lambda k: 0.5 * angles[k, ...],
        lambda k: [number[k, ...] for number in balls],
        lambda k: slides[k, ...],
    )
    zero = xp.zeros_like(X[:, 0])
    as_arrays = [[zero + x for x in one] if isinstance(one[0], float) else one for one in Q + P]
    return as_arrays[: len(Q)], as_arrays[len(Q) :]


def array_positions(xp: Any, X: Array, skeleton: Skeleton) -> Array:
    """`forward_kinematics` of an array of another library."""
    plan = _untraced(_plan_for)(xp, skeleton, True, angles=X)
    P = _place_poses(xp, X, plan)[1]
    return xp.stack([xp.stack(P[plan.code_joint.index(j)], axis=1) for j in range(1, len(P))], axis=1)


def array_orientations(xp: Any, X: Array, skeleton: Skeleton, relative: bool) -> Numbers:
    """Quaternions (n_poses, n_joints), times constants, of all joints, or of those with dofs relative to their parents.

    The constants are of the frames of the tree; angles between two orientations of one joint do not depend on them.
    """
    plan = _untraced(_plan_for)(xp, skeleton, True, poses=X)
    frames, own = _untraced(_frames_of)(skeleton)
    Q = _place_poses(xp, X, plan)[0]
    orientations = [Q[f] for f in frames]
    if relative:
        before = [(w, -x, -y, -z) for w, x, y, z in (Q[plan.frame_parent[f]] for f in own)]
        orientations = [product(p, Q[f]) for p, f in zip(before, own, strict=True)]
    return [xp.stack(numbers, axis=1) for numbers in zip(*orientations, strict=True)]


def _frames_of(skeleton: Skeleton) -> tuple[list[int], list[int]]:
    """The frame of each joint's orientation, and of each joint with dofs."""
    plan = _plan_of(skeleton, True)
    frame_at = {plan.column[d]: f for f, end in enumerate(plan.end_dof) for d in range(plan.first_dof[f], end)}
    frames: list[int] = []
    for (bone, columns), parent in zip(with_columns(skeleton.bones), skeleton.parents.tolist(), strict=True):
        frames.append(frame_at[columns.start] if bone.dofs else frames[parent] if parent >= 0 else 0)
    return frames, [f for f, bone in zip(frames, skeleton.bones, strict=True) if bone.dofs]


# --- distances --------------------------------------------------------------------------------------------------------


def array_distances(
    xp: Any,
    X: Array,
    Y: Array | None,
    skeleton: Skeleton,
    metric: str,
    memory: float,
    n_steps: int = 0,
    wrap: bool = True,
) -> Array:
    """`pose_distances` of arrays of another library, in tiles that take some `memory`, MiB, without gradients."""
    plan = _untraced(_plan_for)(xp, skeleton, False, X=X, Y=X if Y is None else Y)
    encode, measure = MEASURES[metric]
    A = encode(xp, X, plan, wrap)
    B = A if Y is None else encode(xp, Y, plan, wrap)
    # Of a pair, eight numbers for each frame.
    n_pairs = max(1, int(memory * 2**20) // (xp.finfo(X.dtype).bits * len(plan.frame_parent) * (n_steps + 1)))
    n_rows = math.isqrt(n_pairs) if Y is None else min(X.shape[0], math.isqrt(n_pairs))
    n_columns = n_rows if Y is None else n_pairs // n_rows
    rows, columns = [*gen_batches(A.shape[-1], n_rows)], [*gen_batches(B.shape[-1], n_columns)]
    tiles: list[list[Array]] = [[] for _ in rows]
    for i, k in itertools.product(range(len(rows)), range(len(columns))):
        if Y is None and k < i:
            tiles[i].append(tiles[k][i].T)
            continue
        tile = measure(xp, A[..., rows[i], None], B[..., None, columns[k]], plan, n_steps, wrap)
        if Y is None and k == i:  # exactly symmetric, and zero on the diagonal
            below = tile - xp.triu(tile)
            tile = below + below.T
        tiles[i].append(tile)
    return xp.concat([xp.concat(row, axis=1) for row in tiles], axis=0)


def _encode_positions(xp: Any, X: Array, plan: Any, wrap: bool) -> Array:
    placed = zip(_place_poses(xp, X, plan)[1], plan.scale, strict=True)
    return xp.stack([scale * x for p, scale in placed for x in p if scale > 0.0], axis=0)


def _measure_positions(xp: Any, a: Array, b: Array, plan: Any, n_steps: int, wrap: bool) -> Array:
    return root(xp, xp.sum(xp.square(b - a), axis=0))


def _encode_rotations(xp: Any, X: Array, plan: Any, wrap: bool) -> Array:
    Q = _place_poses(xp, X, plan)[0]
    return xp.stack([xp.stack(Q[f], axis=0) for f, weight in enumerate(plan.weight) if f > 0 and weight > 0.0], axis=1)


def _measure_rotations(xp: Any, a: Array, b: Array, plan: Any, n_steps: int, wrap: bool) -> Array:
    """√Σ ℓ² φ², where two unit quaternions at a distance r, or one of them reversed, are φ = 4 arcsin(r/2) apart."""
    gap, sum_ = b - a, b + a
    square = xp.minimum(xp.sum(gap * gap, axis=0), xp.sum(sum_ * sum_, axis=0))
    r = xp.sqrt(at_least_tiny(xp, square))
    share = 4.0 * xp.asin(0.5 * r) / r
    weights = [weight for f, weight in enumerate(plan.weight) if f > 0 and weight > 0.0]
    squares = square * share * share * constant(xp, [[[weight]] for weight in weights], a)
    return root(xp, xp.sum(squares, axis=0))


def _measure_lines(xp: Any, a: Array, b: Array, plan: Any, n_steps: int, wrap: bool) -> Array:
    """The lengths of straight lines in the dofs, sampled at u from −1 to 1 about their middles."""
    (start, balls, slides), (angles, end_balls, end_slides) = (_split_dofs(plan, code) for code in (a, b))
    u = constant(xp, [2.0 * n / n_steps - 1.0 for n in range(n_steps + 1)], a)
    if wrap:
        gap = angles - start
        angles = xp.where(gap > 0.5 * TWO_PI, angles - TWO_PI, xp.where(gap < -0.5 * TWO_PI, angles + TWO_PI, angles))
    middle, reach = 0.25 * (angles + start), 0.25 * (angles - start)  # of half angles
    slide_middle, slide_reach = 0.5 * (end_slides + slides), 0.5 * (end_slides - slides)
    # The line of a ball joint, from p to the nearer of q and −q, is cos(uh) m + sin(uh) d: m and d are the directions
    # of their sum and difference, and h is half the angle between them.
    far = sum(p * q for p, q in zip(balls, end_balls, strict=True)) < -TIE
    nearer = [xp.where(far, -q, q) for q in end_balls]
    m, d = ([q + sign * p for p, q in zip(balls, nearer, strict=True)] for sign in (1.0, -1.0))
    along, across = (xp.sqrt(at_least_tiny(xp, sum(x * x for x in numbers))) for numbers in (m, d))
    h, m, d = xp.atan2(across, along), [x / along for x in m], [x / across for x in d]

    def ball(k: int) -> Numbers:
        angle = h[k, ..., None] * u
        cos, sin = xp.cos(angle), xp.sin(angle)
        return [cos * x[k, ..., None] + sin * y[k, ..., None] for x, y in zip(m, d, strict=True)]

    P = _place(
        xp,
        plan,
        lambda k: middle[k, ..., None] + reach[k, ..., None] * u,
        ball,
        lambda k: slide_middle[k, ..., None] + slide_reach[k, ..., None] * u,
    )[1]
    squares: Any = 0.0
    for j, p in enumerate(P):
        if plan.scale[j] > 0.0 and not isinstance(p[0], float):
            x, y, z = (one[..., 1:] - one[..., :-1] for one in p)
            squares = squares + plan.scale[j] ** 2 * (x * x + y * y + z * z)
    return xp.sum(root(xp, squares), axis=-1)


MEASURES = {
    "position": (_encode_positions, _measure_positions),
    "rotation": (_encode_rotations, _measure_rotations),
    "spatial": (_encode_dofs, _measure_lines),
}
