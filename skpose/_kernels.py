"""The compiled loops: turn frames, place joints, measure; over poses and over pairs.

The skeleton as the kernels see it
----------------------------------
A `Tree` holds *frames* and *joints*. A frame is a coordinate system with one to three degrees of freedom (dofs); a
joint is a point at a fixed offset from the joint before it, measured in one of the frames. Rigid bones need no frame
of their own, and bones that start at one joint may share one. `skpose.skeleton` turns every frame so that its dofs are
rotations about z, y and x in that order, the last one or two of these where it has fewer than three: a frame is
``H = H_parent · rest · Rz · Ry · Rx`` whatever the order of axes was in the file, and nothing below branches on axes.

Lanes
-----
A kernel is written once, with the `load` and `store` of `skpose._lanes`. On arrays of shape (n, lanes) it works on as
many poses at once as fill a vector register, on arrays of shape (n,) on one. Lanes never mix: a distance does not
depend on its neighbours in the block, nor on the number of threads.

The curve without trigonometry
------------------------------
The straight line in angle space, sampled at n = 0 … N, adds δ = (b − a)/N to the angles at each step. With the cosines
and sines of θ/N kept for every pose, those of δ follow for a pair by the subtraction formulas, and those of each
sample from the last by the addition formulas: no trigonometry per pair, error 1e-14 after ten steps. A difference
taken the short way round, b − a ∓ 2π, turns δ by ∓ 2π/N. The two end poses are placed once per pose and not once per
pair, so a pair costs N − 1 forward kinematics.

Two stages
----------
A metric is a pair of functions. Its *encode* writes down what it needs to know of one pose; its *measure* takes one
encoded pose to others. `encode_poses` and `pair_distances` are the only loops over poses and over pairs.
"""

import functools
import math
import warnings
from typing import NamedTuple

import numpy as np
from numba import from_dtype, njit, types

from skpose._lanes import exceeds, lanes, load, root, smaller, store, zero

TWO_PI = 2.0 * math.pi


class Tree(NamedTuple):
    """A skeleton as flat arrays; frame 0 and joint 0 are the root, unrotated and at the origin."""

    frame_parent: np.ndarray  # (n_frames,) frame that each frame turns with
    first_dof: np.ndarray  # (n_frames + 1,) dofs of frame f are first_dof[f]:first_dof[f + 1]; frame 0 has none
    at_rest: np.ndarray  # (n_frames,) 1 where the rotation `rest` is the identity
    rest: np.ndarray  # (n_frames, 3, 3) constant rotation before the frame's dofs
    weight: np.ndarray  # (n_frames,) summed squared lengths of the bones fixed to the frame, m²
    pivot: np.ndarray  # (n_frames,) joint about which the frame turns
    branch: np.ndarray  # (n_branches + 1,) dofs of branch b, all that hangs on one frame at the root, lie between
    column: np.ndarray  # (n_dofs,) where a pose holds each dof
    sign: np.ndarray  # (n_dofs,) -1 where the frame's axis points against the skeleton's, else 1
    joint_parent: np.ndarray  # (n_joints + 1,) joint before each joint
    joint_frame: np.ndarray  # (n_joints + 1,) frame in which the joint's offset is given
    offset: np.ndarray  # (n_joints + 1, 3) from the joint before, m
    first_run: np.ndarray  # (n_frames + 1,) runs of frame f are runs[first_run[f]:first_run[f + 1]]
    runs: np.ndarray  # (n_runs, 2) the dofs of a frame and of those before it, as ranges


class Steps(NamedTuple):
    """How a metric walks from one pose to another."""

    n_steps: int  # chords along the curve
    half_turn: float  # a larger difference of angles is taken the other way round; inf takes all as they are
    cos_turn: float  # of 2π / n_steps
    sin_turn: float

    @classmethod
    def of(cls, n_steps: int, wrap: bool) -> "Steps":
        turn = TWO_PI / n_steps
        return cls(n_steps, math.pi if wrap else math.inf, math.cos(turn), math.sin(turn))


def _can_cache() -> bool:
    """Whether numba finds a folder for its compiled functions; it refuses to define a cached one where it does not."""
    try:
        njit(cache=True)(_can_cache)
    except RuntimeError:
        warnings.warn(
            "numba finds no folder that it may write compiled functions to, so every process compiles skpose's afresh; "
            "set the environment variable NUMBA_CACHE_DIR to one",
            stacklevel=2,
        )
        return False
    return True


# Contraction to fused multiply-add is the one liberty taken: it moves no NaN and is the same in every lane.
_jit = functools.partial(njit, cache=_can_cache(), nogil=True, fastmath={"contract"})


# --- forward kinematics ----------------------------------------------------------------------------------------------


@_jit
def workspace_rows(tree):
    """Rows of the one scratch array that all kernels share."""
    return 4 * tree.column.shape[0] + 9 * tree.rest.shape[0] + 3 * tree.offset.shape[0]


@_jit
def _workspace(tree, scratch):
    """The scratch array's parts, the root's frame and position set.

    Cosines C and sines S of the angles, those of one step dC and dS, (n_dofs,) each; orientations H, (9 n_frames,);
    positions P, (3 n_joints + 3,).
    """
    n, h = tree.column.shape[0], 9 * tree.rest.shape[0]
    H, P = scratch[4 * n : 4 * n + h], scratch[4 * n + h : 4 * n + h + 3 * tree.offset.shape[0]]
    for i in range(9):
        store(H, i, 1.0 if i % 4 == 0 else 0.0)
    for i in range(3):
        store(P, i, 0.0)
    return scratch[:n], scratch[n : 2 * n], scratch[2 * n : 3 * n], scratch[3 * n : 4 * n], H, P


@_jit
def _rotated(u, v, c, s):
    """The two columns that a rotation about the third axis mixes."""
    return c * u + s * v, c * v - s * u


@_jit
def _turn_frames(tree, C, S, H):
    """World orientation H of every frame, row by row: H_f = H_parent · rest · Rz · Ry · Rx."""
    for f in range(1, tree.rest.shape[0]):
        p, r, at_rest = tree.frame_parent[f], tree.rest[f], tree.at_rest[f]
        end = tree.first_dof[f + 1]
        n_dofs = end - tree.first_dof[f]
        for i in range(0, 9, 3):
            x, y, z = load(H, 9 * p + i), load(H, 9 * p + i + 1), load(H, 9 * p + i + 2)
            if not at_rest:
                x, y, z = (
                    x * r[0, 0] + y * r[1, 0] + z * r[2, 0],
                    x * r[0, 1] + y * r[1, 1] + z * r[2, 1],
                    x * r[0, 2] + y * r[1, 2] + z * r[2, 2],
                )
            if n_dofs > 2:
                x, y = _rotated(x, y, load(C, end - 3), load(S, end - 3))
            if n_dofs > 1:
                z, x = _rotated(z, x, load(C, end - 2), load(S, end - 2))
            y, z = _rotated(y, z, load(C, end - 1), load(S, end - 1))
            store(H, 9 * f + i, x)
            store(H, 9 * f + i + 1, y)
            store(H, 9 * f + i + 2, z)


@_jit
def _place_joints(tree, H, P):
    """Overwrite the joint positions P with those of the frames H; return the squared distance that they moved."""
    square = zero(P)
    for j in range(1, tree.offset.shape[0]):
        p, f = 3 * tree.joint_parent[j], 9 * tree.joint_frame[j]
        x, y, z = tree.offset[j, 0], tree.offset[j, 1], tree.offset[j, 2]
        for i in range(3):
            h = f + 3 * i
            new = load(P, p + i) + (load(H, h) * x + load(H, h + 1) * y + load(H, h + 2) * z)
            move = new - load(P, 3 * j + i)
            square = square + move * move
            store(P, 3 * j + i, new)
    return square


@_jit
def _angle(tree, pose, d):
    """Angle of dof d about its frame's axis, rad."""
    return tree.sign[d] * pose[tree.column[d]]


@_jit
def _orient(tree, pose, scratch):
    """Turn the frames of one pose; return the parts of the workspace that say how."""
    C, S, _, _, H, P = _workspace(tree, scratch)
    for d in range(tree.column.shape[0]):
        angle = _angle(tree, pose, d)
        C[d], S[d] = math.cos(angle), math.sin(angle)
    _turn_frames(tree, C, S, H)
    return C, S, H, P


# --- encode: what a metric needs to know of one pose -----------------------------------------------------------------


@_jit
def _principal(angle, steps):
    """The angle less its whole turns, in [-π, π], where differences are to go the short way round.

    Rounding half to even makes this an odd function, so that a half turn is the same way round from either end and
    the distances stay symmetric.
    """
    return angle - TWO_PI * np.rint(angle / TWO_PI) if steps.half_turn < math.inf else angle


@_jit
def encode_angles(pose, tree, steps, scratch, code):
    """The angles themselves; the one code that needs no skeleton."""
    for d in range(pose.shape[0]):
        code[d] = _principal(pose[d], steps)


@_jit
def encode_positions(pose, tree, steps, scratch, code):
    """F(θ): the joint positions, the root's left out."""
    _, _, H, P = _orient(tree, pose, scratch)
    _place_joints(tree, H, P)
    code[:] = P[3:]


@_jit
def encode_rotations(pose, tree, steps, scratch, code):
    """World orientation of every frame but the root's, as unit quaternions (w, x, y, z) of either sign.

    By Shepperd's method: the largest of the four components is found first and divides the others.
    """
    _, _, H, _ = _orient(tree, pose, scratch)
    for f in range(1, tree.rest.shape[0]):
        h, q = H[9 * f : 9 * f + 9], code[4 * f - 4 : 4 * f]
        trace = h[0] + h[4] + h[8]
        largest = max(trace, h[0], h[4], h[8])
        if largest == trace:
            q[0], q[1], q[2], q[3] = 1.0 + trace, h[7] - h[5], h[2] - h[6], h[3] - h[1]
        else:
            i = 0 if largest == h[0] else (1 if largest == h[4] else 2)
            j, k = (i + 1) % 3, (i + 2) % 3
            q[0] = h[3 * k + j] - h[3 * j + k]
            q[1 + i] = 1.0 + 2.0 * h[4 * i] - trace
            q[1 + j] = h[3 * j + i] + h[3 * i + j]
            q[1 + k] = h[3 * k + i] + h[3 * i + k]
        norm = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        for i in range(4):
            q[i] /= norm


@_jit
def encode_curve_end(pose, tree, steps, scratch, code):
    """θ, cos θ/N, sin θ/N, cos θ, sin θ (n_dofs each) and F(θ) (3 n_joints)."""
    n = tree.column.shape[0]
    C, S, H, P = _orient(tree, pose, scratch)
    _place_joints(tree, H, P)
    for d in range(n):
        angle = _principal(_angle(tree, pose, d), steps)
        code[d] = angle
        code[n + d], code[2 * n + d] = math.cos(angle / steps.n_steps), math.sin(angle / steps.n_steps)
        code[3 * n + d], code[4 * n + d] = C[d], S[d]
    code[5 * n :] = P[3:]


# --- measure: from one encoded pose x to others Y --------------------------------------------------------------------


@_jit
def _turns(gap, steps):
    """Whole turns (-1, 0 or 1) to take off a difference of angles so that it goes the short way round."""
    return exceeds(gap, steps.half_turn) - exceeds(0.0 - gap, steps.half_turn)


@_jit
def measure_euclidean(x, Y, tree, steps, scratch, out):
    """‖y − x‖₂, every difference the short way round where the metric wraps."""
    square = zero(Y)
    for d in range(x.shape[0]):
        gap = load(Y, d) - x[d]
        gap = gap - _turns(gap, steps) * TWO_PI
        square = square + gap * gap
    store(out, 0, root(square))


def _squared_angle_series(degree=24):
    """Coefficients in t of φ² / 4m for two unit quaternions at squared distance m = 1 + t, 0 ≤ m ≤ 2.

    φ = 4 arcsin(√m / 2), whose square is analytic in m up to m = 4: interpolation in Chebyshev's points on [0, 2]
    gains a factor 3 + √8 per degree and is exact to rounding at degree 24.
    """
    series = np.polynomial.Chebyshev.interpolate(lambda m: (2.0 * np.arcsin(np.sqrt(m) / 2.0)) ** 2 / m, degree, (0, 2))
    return np.polynomial.chebyshev.cheb2poly(series.coef)


_SQUARED_ANGLE = _squared_angle_series()


@_jit
def measure_rotations(x, Y, tree, steps, scratch, out):
    """√Σ ℓ² φ² over the bones, φ the angle between the orientations of the bone's frame."""
    total = zero(Y)
    for f in range(1, tree.rest.shape[0]):
        minus, plus = zero(Y), zero(Y)
        for i in range(4 * f - 4, 4 * f):
            q = load(Y, i)
            minus, plus = minus + (q - x[i]) * (q - x[i]), plus + (q + x[i]) * (q + x[i])
        m = smaller(minus, plus)  # q and −q are one rotation
        t = m - 1.0
        series = zero(Y) + _SQUARED_ANGLE[-1]
        for i in range(_SQUARED_ANGLE.shape[0] - 2, -1, -1):
            series = series * t + _SQUARED_ANGLE[i]
        total = total + tree.weight[f] * 4.0 * m * series
    store(out, 0, root(total))


@_jit
def measure_line(x, Y, tree, steps, scratch, out):
    """Length of the straight line in angle space as a sum of chords ‖F(c_n) − F(c_{n−1})‖, sec. 2.2 of the paper."""
    n = tree.column.shape[0]
    C, S, dC, dS, H, P = _workspace(tree, scratch)
    apart = zero(Y)
    for d in range(n):
        gap = load(Y, d) - x[d]
        turns = _turns(gap, steps)
        gap = gap - turns * TWO_PI
        apart = apart + gap * gap
        c, s = load(Y, n + d), load(Y, 2 * n + d)
        c, s = c * x[n + d] + s * x[2 * n + d], s * x[n + d] - c * x[2 * n + d]
        # cos and sin of the turns taken off, for turns in {-1, 0, 1}
        cos_off, sin_off = turns * turns * (steps.cos_turn - 1.0) + 1.0, turns * steps.sin_turn
        store(dC, d, c * cos_off + s * sin_off)
        store(dS, d, s * cos_off - c * sin_off)
        store(C, d, x[3 * n + d])
        store(S, d, x[4 * n + d])
    for i in range(3, P.shape[0]):
        store(P, i, x[5 * n + i - 3])
    length = zero(Y)
    for _ in range(steps.n_steps - 1):
        for d in range(n):
            c, s, dc, ds = load(C, d), load(S, d), load(dC, d), load(dS, d)
            store(C, d, c * dc - s * ds)
            store(S, d, s * dc + c * ds)
        _turn_frames(tree, C, S, H)
        length = length + root(_place_joints(tree, H, P))
    square = zero(Y)
    for i in range(3, P.shape[0]):
        move = load(Y, 5 * n + i - 3) - load(P, i)
        square = square + move * move
    # From a pose to itself the samples differ by rounding; the distance is nought.
    store(out, 0, (length + root(square)) * exceeds(apart, 0.0))


# --- the loops ------------------------------------------------------------------------------------------------------


def _encode_poses(poses, encode, tree, steps, codes):
    scratch = np.empty(workspace_rows(tree))
    for i in range(poses.shape[0]):
        encode(poses[i], tree, steps, scratch, codes[i])


def _pair_distances(X, Y, first, last, first_block, last_block, triangle, measure, tree, steps, distances):
    width = Y.shape[2]
    scratch = np.empty((workspace_rows(tree), width), X.dtype)
    out = np.zeros((2, width), X.dtype)
    n_doubtful, worst = 0, 0.0
    for i in range(first, last):
        for block in range(max(first_block, i // width) if triangle else first_block, last_block):
            start = block * width
            for w in range(width):
                wanted = start + w < distances.shape[1] and not (triangle and start + w <= i)
                out[1, w] = 0.0 if wanted else -1.0
            measure(X[i], Y[block], tree, steps, scratch, out)
            for w in range(min(width, distances.shape[1] - start)):
                distances[i, start + w] = out[0, w]
                if out[1, w] > 0.0:
                    n_doubtful += 1
                    worst = max(worst, out[1, w])
    return n_doubtful, worst


def _pair_distance(x, y, n_codes, encode, measure, tree, steps):
    scratch, out = np.empty(workspace_rows(tree)), np.zeros(2)
    codes = np.empty((2, n_codes))
    encode(x, tree, steps, scratch, codes[0])
    encode(y, tree, steps, scratch, codes[1])
    measure(codes[0], codes[1], tree, steps, scratch, out)
    return out[0]


def _array(dtype, ndim, *, readonly, layout="C"):
    return types.Array(dtype, ndim, layout, readonly=readonly)


@functools.cache
def _shared_types(dtype):
    """numba's types of a Tree and of Steps."""
    whole, real = types.int64, from_dtype(dtype)
    kinds = {"rest": (real, 3), "weight": (real, 1), "sign": (real, 1), "offset": (real, 2), "runs": (whole, 2)}
    fields = [_array(*kinds.get(name, (whole, 1)), readonly=False) for name in Tree._fields]
    steps = [whole, types.float64, types.float64, types.float64]
    return types.NamedTuple(fields, Tree), types.NamedTuple(steps, Steps)


# A function passed to a compiled function keeps it from numba's disk cache unless its type is spelled out, and what is
# spelled out is compiled at once; hence the three below are compiled when they are first asked for.


@functools.cache
def _encode_poses_loop():
    real = types.float64
    tree, steps = _shared_types(np.dtype(np.float64))
    row = _array(real, 1, readonly=False)
    encode = types.FunctionType(types.void(_array(real, 1, readonly=True), tree, steps, row, row))
    poses, codes = _array(real, 2, readonly=True), _array(real, 2, readonly=False)
    return _jit([types.void(poses, encode, tree, steps, codes)])(_encode_poses)


def encode_poses(poses, encode, n_codes, tree, steps):
    """Codes (n_poses, n_codes) of poses (n_poses, n_dofs), in float64."""
    codes = np.empty((len(poses), n_codes))
    _encode_poses_loop()(np.ascontiguousarray(poses, dtype=np.float64), encode, tree, steps, codes)
    return codes


@functools.cache
def pair_distance_function():
    """``pair(x, y, n_codes, encode, measure, tree, steps)``: the distance of two poses, in float64."""
    real = types.float64
    tree, steps = _shared_types(np.dtype(np.float64))
    pose, row = _array(real, 1, readonly=True), _array(real, 1, readonly=False)
    encode = types.FunctionType(types.void(pose, tree, steps, row, row))
    measure = types.FunctionType(types.void(row, row, tree, steps, row, row))
    return _jit([real(pose, pose, types.intp, encode, measure, tree, steps)])(_pair_distance)


@functools.cache
def pair_distances_loop(dtype):
    """``loop(X, Y, first, last, first_block, last_block, triangle, measure, tree, steps, distances)``: one tile.

    X holds codes as rows, Y as blocks of shape (n_codes, lanes). With ``triangle`` X and Y are the same poses and only
    the columns from the diagonal's block on are written. Returns how many distances are in doubt, and by how much at
    most: a measure says so in the second row of what it puts out, which holds -1 on entry where nobody wants one.
    """
    real = from_dtype(dtype)
    tree, steps = _shared_types(dtype)
    x, Y = _array(real, 1, readonly=True), _array(real, 2, readonly=True)
    scratch = _array(real, 2, readonly=False)
    measure = types.FunctionType(types.void(x, Y, tree, steps, scratch, scratch))
    X, blocks = _array(real, 2, readonly=True), _array(real, 3, readonly=True)
    distances = _array(real, 2, readonly=False, layout="A")
    found, at = types.Tuple((types.int64, types.float64)), types.intp
    signature = found(X, blocks, at, at, at, at, types.boolean, measure, tree, steps, distances)
    return _jit([signature])(_pair_distances)


def in_lanes(codes):
    """Codes (n, n_codes) as blocks of lanes (n_blocks, n_codes, lanes), the last block filled up with copies."""
    width = lanes(codes.dtype)
    padded = codes[np.minimum(np.arange(-(-len(codes) // width) * width), len(codes) - 1)]
    return np.ascontiguousarray(padded.reshape(-1, width, codes.shape[1]).transpose(0, 2, 1))


# --- Jacobian -------------------------------------------------------------------------------------------------------


@_jit
def turn_axes(tree, C, S, H, axes):
    """The axis of every dof in the world, (n_dofs, 3)."""
    for f in range(1, tree.rest.shape[0]):
        end = tree.first_dof[f + 1]
        n_dofs = end - tree.first_dof[f]
        for i in range(3):
            # The columns of H are the axes after all the dofs; undo these from the last on.
            x, y, z = H[9 * f + 3 * i], H[9 * f + 3 * i + 1], H[9 * f + 3 * i + 2]
            axes[end - 1, i] = x
            y, z = _rotated(y, z, C[end - 1], -S[end - 1])
            if n_dofs > 1:
                axes[end - 2, i] = y
                z, x = _rotated(z, x, C[end - 2], -S[end - 2])
            if n_dofs > 2:
                axes[end - 3, i] = z


@_jit
def fill_jacobian(tree, P, axes, jacobian):
    """Change of the joint positions with the tree's dofs, (3 n_joints, n_dofs); noughts are left as they are.

    A rotation about the unit axis a through the point o moves a point p at the rate a × (p − o).
    """
    for j in range(1, tree.offset.shape[0]):
        row, f = 3 * j - 3, tree.joint_frame[j]
        while f > 0:
            o = 3 * tree.pivot[f]
            x, y, z = P[3 * j] - P[o], P[3 * j + 1] - P[o + 1], P[3 * j + 2] - P[o + 2]
            for d in range(tree.first_dof[f], tree.first_dof[f + 1]):
                a, b, c = axes[d, 0], axes[d, 1], axes[d, 2]
                jacobian[row, d], jacobian[row + 1, d], jacobian[row + 2, d] = (
                    b * z - c * y,
                    c * x - a * z,
                    a * y - b * x,
                )
            f = tree.frame_parent[f]


@_jit
def position_jacobians(poses, tree, jacobians):
    """∂F/∂θ of every pose into jacobians (n_poses, 3 n_joints, n_dofs)."""
    n_dofs = tree.column.shape[0]
    scratch, axes = np.empty(workspace_rows(tree)), np.empty((n_dofs, 3))
    jacobian = np.zeros((jacobians.shape[1], n_dofs))
    for n in range(poses.shape[0]):
        C, S, H, P = _orient(tree, poses[n], scratch)
        _place_joints(tree, H, P)
        turn_axes(tree, C, S, H, axes)
        fill_jacobian(tree, P, axes, jacobian)
        for d in range(n_dofs):
            jacobians[n, :, tree.column[d]] = tree.sign[d] * jacobian[:, d]


# --- medoid shift ---------------------------------------------------------------------------------------------------


@_jit
def shift_in_graph(indptr, indices, squared, factor, tie, target, staying):
    """Where each sample of a graph moves to: the neighbour j with the least Σ_k w_ik d_jk², w = exp(factor · d²).

    The graph is symmetric, with sorted rows that hold the diagonal. Where it lacks d_jk², d_ij² + d_ik² stands in: what
    that is on average if j and k lie in independent directions from i.
    """
    n = target.shape[0]
    weight, from_i = np.zeros(n), np.zeros(n)  # w_ik and d_ik² of the present i, nought but for its neighbours
    for i in range(n):
        total, moment = 0.0, 0.0  # Σ w_ik and Σ w_ik d_ik²
        for e in range(indptr[i], indptr[i + 1]):
            k = indices[e]
            weight[k], from_i[k] = math.exp(factor * squared[e]), squared[e]
            total += weight[k]
            moment += weight[k] * from_i[k]
        best = math.inf
        for e in range(indptr[i], indptr[i + 1]):
            j = indices[e]
            cost, seen, seen_moment = 0.0, 0.0, 0.0
            for f in range(indptr[j], indptr[j + 1]):
                k = indices[f]
                cost += weight[k] * squared[f]
                seen += weight[k]
                seen_moment += weight[k] * from_i[k]
            cost += from_i[j] * (total - seen) + (moment - seen_moment)
            if cost < best * (1.0 - tie):
                best, target[i] = cost, j
            if j == i:
                staying[i] = cost
        for e in range(indptr[i], indptr[i + 1]):
            weight[indices[e]] = 0.0
