"""The compiled kernels: turn frames, place joints, encode a pose.

The skeleton as the kernels see it
----------------------------------
A `Tree` holds *frames* and *joints*. A frame is a coordinate system with one to three degrees of freedom (dofs); a
joint is a point at a fixed offset from the joint before it, measured in one of the frames. Rigid bones need no frame
of their own, and bones that start at one joint may share one. `skpose._tree` turns every frame so that its dofs are
rotations about z, y and x in that order, the last one or two of these where it has fewer than three: a frame is
``H = H_parent · Rz · Ry · Rx`` whatever the order of axes was in the file, and nothing below branches on axes. What
constant rotation lies between two frames goes into the zeros of their angles (`shift`); the rest of it, if any, is a
frame without dofs between the two, a constant turn about one axis.

Lanes
-----
A kernel is written once, with the `rows` of `skpose._lanes`. On arrays of shape (n, lanes) it works on as many poses at
once as fill a vector register, on arrays of shape (n,) on one. Lanes never mix: a distance does not depend on its
neighbours in the block, nor on the number of threads.

The curve without trigonometry
------------------------------
The straight line in angle space, sampled at n = 0 … N, adds δ = (b − a)/N to the angles at each step. With the cosines
and sines of θ/2N kept for every pose, those of δ/2 follow for a pair by the subtraction formulas, and those of each
sample from the last by the addition formulas: no trigonometry per pair, error 1e-14 after ten steps. These take
1 − cos δ = 2 sin² δ/2 instead of cos δ, whose rounding would make the frames grow or shrink from step to step. A
difference taken the short way round, b − a ∓ 2π, turns δ by ∓ 2π/N. The two end poses are placed once per pose and not
once per pair, so a pair costs N − 1 forward kinematics.

What a step leaves out
----------------------
A *tip* is a frame that ends the tree and holds one joint: there the joint's offset is turned, a vector, and not the
frame. Of a frame's rotation only two rows are kept, since the third is their cross product. Joints fixed to the root
are not placed again. Frames with equally many dofs stand together in *batches*, so that the processor meets the same
instructions again and again.

Two stages
----------
A metric is a pair of functions. Its *encode* writes down what it needs to know of a pose; its *measure*, in
`skpose._measures`, takes one encoded pose to others. The loops over poses and over pairs are in `skpose._loops` and
`skpose._nearest`.
"""

import functools
import math
import warnings
from typing import NamedTuple

import numpy as np
from numba import njit

from skpose._lanes import every, nearest, numbers, rows, smaller

TWO_PI = 2.0 * math.pi


class Tree(NamedTuple):
    """A skeleton as flat arrays; frame 0 and joint 0 are the root, unrotated and at the origin.

    Frames stand in batches, tips last; joints in the order of their frames; dofs depth first.
    """

    frame_parent: np.ndarray  # (n_frames,) frame that each frame turns with
    first_dof: np.ndarray  # (n_frames,) dofs of frame f are first_dof[f]:end_dof[f]; the root's frame has none
    end_dof: np.ndarray  # (n_frames,)
    fixed_axis: np.ndarray  # (n_frames,) axis about which a frame without dofs is turned: 0, 1 or 2
    fixed_turn: np.ndarray  # (n_frames, 4) cosine and sine of that turn, and of half of it
    weight: np.ndarray  # (n_frames,) summed squared lengths of the bones fixed to the frame, m²
    pivot: np.ndarray  # (n_frames,) joint about which the frame turns
    batch_dofs: np.ndarray  # (n_batches,) how many dofs the frames of a batch have
    first_frame: np.ndarray  # (n_batches + 1,) frames of batch b are first_frame[b]:first_frame[b + 1]; then the tips
    branch: np.ndarray  # (n_branches + 1,) dofs of branch b, all that hangs on one frame at the root, lie between
    column: np.ndarray  # (n_dofs,) where a pose holds each dof
    sign: np.ndarray  # (n_dofs,) -1 where the frame's axis points against the skeleton's, else 1
    shift: np.ndarray  # (n_dofs,) what to add to the angle, rad
    joint_parent: np.ndarray  # (n_joints + 1,) joint before each joint
    joint_frame: np.ndarray  # (n_joints + 1,) frame in which the joint's offset is given
    offset: np.ndarray  # (n_joints + 1, 3) from the joint before, m; of a tip's joint the last is nought
    place: np.ndarray  # (n_joints + 1,) the skeleton's number of each joint, counted from one
    first_run: np.ndarray  # (n_frames + 1,) runs of frame f are runs[first_run[f]:first_run[f + 1]]
    runs: np.ndarray  # (n_runs, 2) the dofs of a frame and of those before it, as ranges


class Plan(NamedTuple):
    """What a step reads of a Tree, without references to count."""

    n_dofs: int
    n_batches: int
    first_moving: int  # joint; those before are fixed to the root
    first_tip: int  # joint
    n_joints: int  # the root's included
    frame_parent: np.ndarray
    first_dof: np.ndarray
    end_dof: np.ndarray
    fixed_axis: np.ndarray
    fixed_turn: np.ndarray
    batch_dofs: np.ndarray
    first_frame: np.ndarray
    joint_parent: np.ndarray
    joint_frame: np.ndarray
    offset: np.ndarray


class Steps(NamedTuple):
    """How a metric walks from one pose to another."""

    n_steps: int  # chords along the curve
    half_turn: float  # a larger difference of angles is taken the other way round; inf takes all as they are
    cos_turn: float  # of π / n_steps
    sin_turn: float

    @classmethod
    def of(cls, n_steps: int, wrap: bool) -> "Steps":
        turn = math.pi / n_steps
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
jit = functools.partial(njit, cache=_can_cache(), nogil=True, fastmath={"contract"})
inlined = functools.partial(jit, forceinline=True)


# --- forward kinematics of one pose, every frame whole ---------------------------------------------------------------


@jit
def workspace_rows(tree):
    """Rows of the one scratch array that all kernels share."""
    return 4 * tree.column.shape[0] + 9 * tree.frame_parent.shape[0] + 3 * tree.offset.shape[0]


@jit
def workspace(tree, scratch):
    """A (workspace_rows,) array's parts: cosines C and sines S of the angles, orientations H, positions P, all nought.

    (n_dofs,) each, (9 n_frames,) and (3 n_joints + 3,); the root's orientation is the identity.
    """
    n, h = tree.column.shape[0], 9 * tree.frame_parent.shape[0]
    H, P = scratch[2 * n : 2 * n + h], scratch[2 * n + h : 2 * n + h + 3 * tree.offset.shape[0]]
    for i in range(9):
        H[i] = 1.0 if i % 4 == 0 else 0.0
    P[:] = 0.0
    return scratch[:n], scratch[n : 2 * n], H, P


@inlined
def rotated(u, v, c, s):
    """The two columns that a rotation about the third axis mixes."""
    return c * u + s * v, c * v - s * u


@jit
def orient(tree, angles, C, S, H):
    """World orientation H of every frame, row by row, the angles in the tree's order."""
    for d in range(angles.shape[0]):
        C[d], S[d] = math.cos(angles[d] + tree.shift[d]), math.sin(angles[d] + tree.shift[d])
    for f in range(1, tree.frame_parent.shape[0]):
        p, a, end = tree.frame_parent[f], tree.fixed_axis[f], tree.end_dof[f]
        b, c = (a + 1) % 3, (a + 2) % 3
        n_dofs = end - tree.first_dof[f]
        for i in range(0, 9, 3):
            row, before = 9 * f + i, 9 * p + i
            if n_dofs == 0:
                H[row + a] = H[before + a]
                H[row + b], H[row + c] = rotated(
                    H[before + b], H[before + c], tree.fixed_turn[f, 0], tree.fixed_turn[f, 1]
                )
                continue
            x, y, z = H[before], H[before + 1], H[before + 2]
            if n_dofs > 2:
                x, y = rotated(x, y, C[end - 3], S[end - 3])
            if n_dofs > 1:
                z, x = rotated(z, x, C[end - 2], S[end - 2])
            y, z = rotated(y, z, C[end - 1], S[end - 1])
            H[row], H[row + 1], H[row + 2] = x, y, z


@jit
def place_joints(tree, H, P):
    """Overwrite the joint positions P with those of the frames H; return the squared distance that they moved."""
    square = 0.0
    for j in range(1, tree.offset.shape[0]):
        p, f = 3 * tree.joint_parent[j], 9 * tree.joint_frame[j]
        x, y, z = tree.offset[j, 0], tree.offset[j, 1], tree.offset[j, 2]
        for i in range(3):
            h = f + 3 * i
            new = P[p + i] + (H[h] * x + H[h + 1] * y + H[h + 2] * z)
            square += (new - P[3 * j + i]) ** 2
            P[3 * j + i] = new
    return square


# --- one step of the angles, in lanes --------------------------------------------------------------------------------


@inlined
def plan_of(tree):
    """What a step reads of a tree."""
    first_moving = 1
    while first_moving < tree.joint_frame.shape[0] and tree.joint_frame[first_moving] == 0:
        first_moving += 1
    n_tips = tree.frame_parent.shape[0] - tree.first_frame[-1]
    return Plan(
        tree.column.shape[0],
        tree.batch_dofs.shape[0],
        first_moving,
        tree.offset.shape[0] - n_tips,
        tree.offset.shape[0],
        numbers(tree.frame_parent),
        numbers(tree.first_dof),
        numbers(tree.end_dof),
        numbers(tree.fixed_axis),
        numbers(tree.fixed_turn),
        numbers(tree.batch_dofs),
        numbers(tree.first_frame),
        numbers(tree.joint_parent),
        numbers(tree.joint_frame),
        numbers(tree.offset),
    )


@inlined
def parts_of(tree, scratch):
    """The parts of a scratch array that a step works in, the root's frame and position set.

    Cosines C and sines S of the angles, A = 1 - cos δ and B = sin δ of the step, (n_dofs,) each; two rows of every
    orientation, H, (6 n_frames,); positions P, (3 n_joints + 3,).
    """
    n, h = tree.column.shape[0], 6 * tree.frame_parent.shape[0]
    H, P = rows(scratch, 4 * n), rows(scratch, 4 * n + h)
    for i in range(6):
        H[i] = 1.0 if i % 4 == 0 else 0.0
    for i in range(3):
        P[i] = 0.0
    return rows(scratch, 0), rows(scratch, n), rows(scratch, 2 * n), rows(scratch, 3 * n), H, P


@inlined
def _turn_batch(n_dofs, first, last, plan, C, S, H):
    """Orientations of frames that have equally many dofs."""
    for f in range(first, last):
        before, row, d = 6 * plan.frame_parent[f], 6 * f, plan.end_dof[f] - 1
        cx, sx = C[d], S[d]
        cy, sy, cz, sz = cx, sx, cx, sx
        if n_dofs > 1:
            cy, sy = C[d - 1], S[d - 1]
        if n_dofs > 2:
            cz, sz = C[d - 2], S[d - 2]
        for i in range(0, 6, 3):
            x, y, z = H[before + i], H[before + i + 1], H[before + i + 2]
            if n_dofs > 2:
                x, y = rotated(x, y, cz, sz)
            if n_dofs > 1:
                z, x = rotated(z, x, cy, sy)
            y, z = rotated(y, z, cx, sx)
            H[row + i], H[row + i + 1], H[row + i + 2] = x, y, z


@inlined
def _turn_fixed(first, last, plan, H):
    """Orientations of frames without dofs."""
    for f in range(first, last):
        before, row, a = 6 * plan.frame_parent[f], 6 * f, plan.fixed_axis[f]
        b, c = (a + 1) % 3, (a + 2) % 3
        cos, sin = plan.fixed_turn[4 * f], plan.fixed_turn[4 * f + 1]
        for i in range(0, 6, 3):
            u, v = rotated(H[before + i + b], H[before + i + c], cos, sin)
            H[row + i + a], H[row + i + b], H[row + i + c] = H[before + i + a], u, v


@inlined
def _move(P, j, p, value, square):
    """Put one coordinate of a joint, its parent's plus a value; add its squared move."""
    new = P[p] + value
    move = new - P[j]
    P[j] = new
    return square + move * move


@inlined
def _reach(H, h, P, j, p, x, y, z, squares):
    """Put joint j at (x, y, z), in the frame at row h, from joint p; add its squared move."""
    a, b, c, d, e, f = H[h], H[h + 1], H[h + 2], H[h + 3], H[h + 4], H[h + 5]
    first = _move(P, 3 * j, 3 * p, a * x + b * y + c * z, squares[0])
    second = _move(P, 3 * j + 1, 3 * p + 1, d * x + e * y + f * z, squares[1])
    third = (b * f - c * e) * x + (c * d - a * f) * y + (a * e - b * d) * z
    return first, second, _move(P, 3 * j + 2, 3 * p + 2, third, squares[2])


@inlined
def take_step(plan, C, S, A, B, H, P):
    """Turn all angles by one step and place the joints; return the squared distance that these moved."""
    for d in range(plan.n_dofs):
        c, s, a, b = C[d], S[d], A[d], B[d]
        C[d], S[d] = c - a * c - b * s, s - a * s + b * c
    for b in range(plan.n_batches):
        n_dofs, first, last = plan.batch_dofs[b], plan.first_frame[b], plan.first_frame[b + 1]
        # A number that is written out folds the branches on it away.
        if n_dofs == 3:
            _turn_batch(3, first, last, plan, C, S, H)
        elif n_dofs == 2:
            _turn_batch(2, first, last, plan, C, S, H)
        elif n_dofs == 1:
            _turn_batch(1, first, last, plan, C, S, H)
        else:
            _turn_fixed(first, last, plan, H)
    nought = every(P, 0.0)
    squares = nought, nought, nought  # by coordinate: three sums, so that an addition need not await the last one
    for j in range(plan.first_moving, plan.first_tip):
        x, y, z = plan.offset[3 * j], plan.offset[3 * j + 1], plan.offset[3 * j + 2]
        squares = _reach(H, 6 * plan.joint_frame[j], P, j, plan.joint_parent[j], x, y, z, squares)
    for j in range(plan.first_tip, plan.n_joints):
        f = plan.joint_frame[j]
        d, n_dofs = plan.end_dof[f] - 1, plan.end_dof[f] - plan.first_dof[f]
        x, y, z = every(P, plan.offset[3 * j]), C[d] * plan.offset[3 * j + 1], S[d] * plan.offset[3 * j + 1]
        if n_dofs > 1:
            x, z = rotated(x, z, C[d - 1], S[d - 1])
        if n_dofs > 2:
            y, x = rotated(y, x, C[d - 2], S[d - 2])
        squares = _reach(H, 6 * plan.frame_parent[f], P, j, plan.joint_parent[j], x, y, z, squares)
    return squares[0] + squares[1] + squares[2]


# --- encode: what a metric needs to know of a pose -------------------------------------------------------------------

# π in three parts, the first two of so few bits that their multiples by less than 2²² are exact.
_PI_PARTS = 3.1415926534682512, 1.2154201018028943e-10, -5.016557612668332e-20
_SINE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(11))
_COSINE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(12))


@inlined
def series(coefficients, t, value):
    for k in range(len(coefficients) - 1, -1, -1):
        value = value * t + coefficients[k]
    return value


@inlined
def cosine_sine(angle):
    """Cosine and sine of an angle, to 2e-16 up to some million turns: less its half turns, by Taylor's series.

    numba has neither in lanes; one by one, by the C library, they take twenty times as long.
    """
    half_turns = nearest(angle * (1.0 / math.pi))
    rest = ((angle - half_turns * _PI_PARTS[0]) - half_turns * _PI_PARTS[1]) - half_turns * _PI_PARTS[2]
    bound = 0.0 * rest + 1.6  # more than π/2: where an angle is so large that nothing of it is left, it is some angle
    rest = 0.0 - smaller(0.0 - smaller(rest, bound), bound)
    odd = half_turns - 2.0 * nearest(half_turns * 0.5)
    sign = 1.0 - 2.0 * (odd * odd)
    t = rest * rest
    return sign * series(_COSINE, t, 0.0 * t), sign * (rest * series(_SINE, t, 0.0 * t))


@inlined
def _principal(angle, steps):
    """The angle less its whole turns, in [-π, π], where differences are to go the short way round.

    Rounding half to even makes this an odd function, so that a half turn is the same way round from either end and
    the distances stay symmetric.
    """
    if steps.half_turn == math.inf:
        return angle
    return angle - TWO_PI * nearest(angle * (1.0 / TWO_PI))


@inlined
def _place_pose(pose, tree, plan, C, S, A, B, H, P):
    """Joint positions of a pose, as one step of the whole angles from nought."""
    sign, column, shift = numbers(tree.sign), numbers(tree.column), numbers(tree.shift)
    for d in range(plan.n_dofs):
        C[d], S[d] = 1.0, 0.0
        c, s = cosine_sine(pose[column[d]] * sign[d] + shift[d])
        A[d], B[d] = 1.0 - c, s
    for j in range(1, plan.first_moving):
        for i in range(3):
            P[3 * j + i] = P[3 * plan.joint_parent[j] + i] + plan.offset[3 * j + i]
    for i in range(3 * plan.first_moving, 3 * plan.n_joints):
        P[i] = 0.0
    take_step(plan, C, S, A, B, H, P)


@jit
def encode_angles(pose, tree, steps, scratch, code):
    """The angles themselves; the one code that needs no skeleton."""
    angles, put = rows(pose, 0), rows(code, 0)
    for d in range(pose.shape[0]):
        put[d] = _principal(angles[d], steps)


@jit
def encode_positions(pose, tree, steps, scratch, code):
    """F(θ): the joint positions in the skeleton's order, the root's left out."""
    plan, put, place = plan_of(tree), rows(code, 0), numbers(tree.place)
    C, S, A, B, H, P = parts_of(tree, scratch)
    _place_pose(rows(pose, 0), tree, plan, C, S, A, B, H, P)
    for j in range(1, plan.n_joints):
        for i in range(3):
            put[3 * place[j] - 3 + i] = P[3 * j + i]


@inlined
def _spin(Q, q, axis, cos, sin):
    """Turn the quaternion (w, x, y, z) at row q about an axis, given the cosine and sine of half the angle."""
    a, b, c = q + 1 + axis, q + 1 + (axis + 1) % 3, q + 1 + (axis + 2) % 3
    Q[a], Q[q] = rotated(Q[a], Q[q], cos, sin)
    Q[b], Q[c] = rotated(Q[b], Q[c], cos, sin)


@jit
def encode_rotations(pose, tree, steps, scratch, code):
    """World orientation of every frame but the root's, as unit quaternions (w, x, y, z) of either sign."""
    plan, angles, put, Q = plan_of(tree), rows(pose, 0), rows(code, 0), rows(scratch, 0)
    sign, column, shift = numbers(tree.sign), numbers(tree.column), numbers(tree.shift)
    for i in range(4):
        Q[i] = 1.0 if i == 0 else 0.0
    for f in range(1, tree.frame_parent.shape[0]):
        q, end = 4 * f, plan.end_dof[f]
        for i in range(4):
            Q[q + i] = Q[4 * plan.frame_parent[f] + i]
        if end == plan.first_dof[f]:
            _spin(Q, q, plan.fixed_axis[f], plan.fixed_turn[4 * f + 2], plan.fixed_turn[4 * f + 3])
        for d in range(plan.first_dof[f], end):
            cos, sin = cosine_sine((angles[column[d]] * sign[d] + shift[d]) * 0.5)
            _spin(Q, q, end - 1 - d, cos, sin)
        for i in range(4):
            put[q - 4 + i] = Q[q + i]


@jit
def encode_curve_end(pose, tree, steps, scratch, code):
    """θ, cos θ/2N, sin θ/2N, cos θ, sin θ (n_dofs each, the last two of the shifted angles) and F(θ) (3 n_joints)."""
    plan, angles, put = plan_of(tree), rows(pose, 0), rows(code, 0)
    sign, column, n = numbers(tree.sign), numbers(tree.column), plan.n_dofs
    C, S, A, B, H, P = parts_of(tree, scratch)
    _place_pose(angles, tree, plan, C, S, A, B, H, P)
    for d in range(n):
        angle = _principal(angles[column[d]] * sign[d], steps)
        put[d] = angle
        put[n + d], put[2 * n + d] = cosine_sine(angle * (0.5 / steps.n_steps))
        put[3 * n + d], put[4 * n + d] = C[d], S[d]
    for i in range(3, 3 * plan.n_joints):
        put[5 * n + i - 3] = P[i]
