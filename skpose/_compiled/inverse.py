"""Inverse kinematics: the pose, and the place and orientation of the root, nearest to given positions of the joints.

The least of ½ Σ w ‖R·F(θ) + o − p‖² + ½ ρ² ‖θ ⊖ θ₀‖² over the joints that are seen, with the root's orientation R as a
ball joint of the tree and its position o as three dofs more. ρ is so small that it settles only what the positions
leave open.

Gauss-Newton in a trust region. Joints with three dofs are rotations, not numbers: a step turns them in their own axes
(`retract`). Sums over the joints that a frame moves, gathered from the tips to the root, give gradient and matrix
without any Jacobian, and the matrix is factorised along the tree (`tree_cholesky`). Where positions cannot be reached
the terms that Gauss-Newton leaves out are added, once they count.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.chart import free_tree, rotation_of
from skpose._compiled.forward import workspace_rows
from skpose._compiled.jit import internal, jit, unfolded
from skpose._compiled.path_energy import place
from skpose._compiled.rotation import inverse, product, quaternion_of, sign_towards, vector_of
from skpose._compiled.tree import Tree
from skpose._compiled.tree_cholesky import N_ORIGIN, Equations, equations_of, factorise, solve

MAX_ITER = 1000
PRECISION = 1e-9  # a step that brings the joints no nearer than this is no step, m
NEGLIGIBLE = 1e-10  # decrease relative to the energy that is none, far below what noise makes of it
FIRST_DAMPING, LEAST_DAMPING, RAISED_DAMPING, MAX_DAMPING = (
    1e-3,
    1e-10,
    2e-9,
    1e6,
)  # relative to the mean diagonal of the matrix
CERTAIN = 1e-6  # damping, relative again, up to which a short step means that the minimum is near
LEAST_RATIO = 1e-4  # of actual to predicted decrease, for a step to be taken
PULL, SHARE = 1e-5, 0.1  # ρ of the first step at least, m/rad; how far that goes to θ₀ in what is open
SLOW = 0.5  # relative decrease of the energy below which the exact Hessian takes over


class State(NamedTuple):
    """A pose: rotations of ball joints are the references of its own tree, whose dofs are zero there."""

    tree: Tree
    dofs: np.ndarray  # (n_dofs,) angles, rad
    origin: np.ndarray  # (3,) position of the root, m
    P: np.ndarray  # (3 n_joints + 3,) positions from the root, m
    screws: np.ndarray  # (6, n_dofs) see `path_energy.place`


class Target(NamedTuple):
    """Positions that are to be reached, and what settles the rest."""

    positions: np.ndarray  # (n_joints + 1, 3) m, in the tree's order, the root's first; finite everywhere
    weights: np.ndarray  # (n_joints + 1,) zero where not seen
    prior: np.ndarray  # (n_frames, 4) rotations θ₀ of ball joints
    prior_dofs: np.ndarray  # (n_dofs,) angles θ₀, rad
    stiffness: float  # ρ², m²/rad²
    lower: np.ndarray  # (n_dofs,) rad
    upper: np.ndarray  # (n_dofs,) rad


class Fit(NamedTuple):
    """The end of the search for a pose."""

    half: float  # half the weighted sum of squared distances, with the regularisation, m²
    n_iter: int
    converged: bool


class Workspace(NamedTuple):
    """Arrays that every frame uses again."""

    here: State
    there: State
    beyond: State
    best: State
    kept: State  # for the caller
    equations: Equations
    sums: np.ndarray  # (n_frames, 22) over the joints that a frame moves: w p rᵀ, w r, w p pᵀ, w p, w
    scratch: np.ndarray


@internal
def empty_state(tree, frees_angles):
    n_dofs = tree.column.shape[0]
    return State(
        free_tree(tree, frees_angles),
        np.zeros(n_dofs),
        np.zeros(3),
        np.zeros(3 * tree.offset.shape[0]),
        np.zeros((6, n_dofs)),
    )


@jit
def workspace_of(tree, frees_angles):
    """Return arrays for the search for poses of a tree."""
    return Workspace(
        empty_state(tree, frees_angles),
        empty_state(tree, frees_angles),
        empty_state(tree, frees_angles),
        empty_state(tree, frees_angles),
        empty_state(tree, frees_angles),
        equations_of(tree),
        np.zeros((tree.frame_parent.shape[0], 22)),
        np.empty(workspace_rows(tree)),
    )


@internal
def copy_state(source, target):
    """Copy a state to another one."""
    target.tree.reference[:] = source.tree.reference
    target.dofs[:] = source.dofs
    target.origin[:] = source.origin
    target.P[:] = source.P
    target.screws[:] = source.screws


@jit
def set_pose(tree, dofs, rotations, angles):
    """Write a pose as rotations of frames with three dofs, where these are free, and angles of the others."""
    for f in range(1, tree.frame_parent.shape[0]):
        first, end = tree.first_dof[f], tree.end_dof[f]
        if end - first == 3:
            w, x, y, z = rotation_of(tree, dofs, f)
            rotations[f, 0], rotations[f, 1], rotations[f, 2], rotations[f, 3] = w, x, y, z
    angles[:] = dofs


@internal
def start_at(state, rotations, angles):
    """Let a state have the rotations and angles of a pose."""
    free = state.tree
    for f in range(1, free.frame_parent.shape[0]):
        is_ball = free.ball[f] >= 0
        for d in range(free.first_dof[f], free.end_dof[f]):
            state.dofs[d] = 0.0 if is_ball else angles[d]
        if is_ball:
            for i in range(4):
                free.reference[f, i] = rotations[f, i]


@internal
def _turn_from(before, now, f):
    """Return the rotation vector of a frame from one set of rotations to another, in the rotated axes."""
    p = before[f, 0], before[f, 1], before[f, 2], before[f, 3]
    q = now[f, 0], now[f, 1], now[f, 2], now[f, 3]
    sign = sign_towards(p, q)
    w, x, y, z = product(inverse(p), q)
    return vector_of((sign * w, sign * x, sign * y, sign * z))


@internal
def _away(state, target):
    """Return half the squared distance from θ₀ in rad²; the root's frame, the first one, has no part in it."""
    free, half = state.tree, 0.0
    for f in range(2, free.frame_parent.shape[0]):
        if free.ball[f] >= 0:
            x, y, z = _turn_from(target.prior, free.reference, f)
            half += 0.5 * (x * x + y * y + z * z)
        else:
            for d in range(free.first_dof[f], free.end_dof[f]):
                half += 0.5 * (state.dofs[d] - target.prior_dofs[d]) ** 2
    return half


@internal
def _evaluate(state, target, stiffness, scratch):
    """Place the joints; return half the energy."""
    place(state.tree, state.dofs, scratch, state.P, state.screws)
    half = 0.0
    for j in range(1, target.weights.shape[0]):
        w = target.weights[j]
        if w > 0.0:
            x = state.P[3 * j] + state.origin[0] - target.positions[j, 0]
            y = state.P[3 * j + 1] + state.origin[1] - target.positions[j, 1]
            z = state.P[3 * j + 2] + state.origin[2] - target.positions[j, 2]
            half += 0.5 * w * (x * x + y * y + z * z)
    if stiffness > 0.0:
        half += stiffness * _away(state, target)
    return half


@internal
def _sum_joints(state, target, sums):
    """Sum the moments of the joints that each frame moves."""
    tree = state.tree
    sums[:] = 0.0
    for j in range(1, target.weights.shape[0]):
        w = target.weights[j]
        if w == 0.0:
            continue
        total = sums[tree.joint_frame[j]]
        x, y, z = state.P[3 * j], state.P[3 * j + 1], state.P[3 * j + 2]
        u = w * (x + state.origin[0] - target.positions[j, 0])
        v = w * (y + state.origin[1] - target.positions[j, 1])
        t = w * (z + state.origin[2] - target.positions[j, 2])
        total[0] += x * u
        total[1] += x * v
        total[2] += x * t
        total[3] += y * u
        total[4] += y * v
        total[5] += y * t
        total[6] += z * u
        total[7] += z * v
        total[8] += z * t
        total[9] += u
        total[10] += v
        total[11] += t
        total[12] += w * x * x
        total[13] += w * x * y
        total[14] += w * x * z
        total[15] += w * y * y
        total[16] += w * y * z
        total[17] += w * z * z
        total[18] += w * x
        total[19] += w * y
        total[20] += w * z
        total[21] += w
    for f in range(tree.frame_parent.shape[0] - 1, 0, -1):
        p = tree.frame_parent[f]
        for i in range(22):
            sums[p, i] += sums[f, i]


@internal
def _gradient(state, target, stiffness, work):
    """Compute the gradient of half the energy by turns, angles and the root's position."""
    tree, gradient, sums, screws = state.tree, work.equations.gradient, work.sums, state.screws
    _sum_joints(state, target, sums)
    for i in range(N_ORIGIN):
        gradient[i] = sums[0, 9 + i]
    for f in range(1, tree.frame_parent.shape[0]):
        first = tree.first_dof[f]
        _, xv, xt, yu, _, yt, zu, zv, _, u, v, t = sums[f, :12]
        for d in range(first, tree.end_dof[f]):
            slope = (yt - zv) * screws[0, d] + (zu - xt) * screws[1, d] + (xv - yu) * screws[2, d]
            gradient[N_ORIGIN + d] = slope + u * screws[3, d] + v * screws[4, d] + t * screws[5, d]
        if stiffness == 0.0 or f == 1:
            continue
        if tree.ball[f] >= 0:  # the gradient of ½ |v|² by a turn in the rotated axes is v
            x, y, z = _turn_from(target.prior, tree.reference, f)
            gradient[N_ORIGIN + first] += stiffness * x
            gradient[N_ORIGIN + first + 1] += stiffness * y
            gradient[N_ORIGIN + first + 2] += stiffness * z
        else:
            for d in range(first, tree.end_dof[f]):
                gradient[N_ORIGIN + d] += stiffness * (state.dofs[d] - target.prior_dofs[d])


@internal
def _fill_matrix(state, stiffness, work):
    """Compute the Gauss-Newton matrix, after the gradient."""
    tree, sums, screws, matrix = state.tree, work.sums, state.screws, work.equations.matrix
    for i in range(N_ORIGIN):
        for j in range(i + 1):
            matrix[i, j] = sums[0, 21] if i == j else 0.0
    for f in range(1, tree.frame_parent.shape[0]):
        xx, xy, xz, yy, yz, zz, px, py, pz, n = sums[f, 12:]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            a, b, c, p, q, r = screws[:, d]
            j0 = (yy + zz) * a - xy * b - xz * c + py * r - pz * q
            j1 = (xx + zz) * b - xy * a - yz * c + pz * p - px * r
            j2 = (xx + yy) * c - xz * a - yz * b + px * q - py * p
            j3 = b * pz - c * py + n * p
            j4 = c * px - a * pz + n * q
            j5 = a * py - b * px + n * r
            matrix[N_ORIGIN + d, 0], matrix[N_ORIGIN + d, 1], matrix[N_ORIGIN + d, 2] = j3, j4, j5
            for s in range(tree.first_run[f], tree.first_run[f + 1]):
                for e in range(tree.runs[s, 0], min(tree.runs[s, 1], d + 1)):
                    jj = j0 * screws[0, e] + j1 * screws[1, e] + j2 * screws[2, e]
                    jj += j3 * screws[3, e] + j4 * screws[4, e] + j5 * screws[5, e]
                    matrix[N_ORIGIN + d, N_ORIGIN + e] = jj
            if f > 1:
                matrix[N_ORIGIN + d, N_ORIGIN + d] += stiffness


@internal
def _add_second_derivatives(state, work):
    """Add what Gauss-Newton leaves out: residuals times second derivatives.

    For axes a and c, where c is a or an axis between a and the root, ∂²p = c × (a × (p − o)). The axes of a ball joint,
    whose turn is a rotation vector at zero, have the mean of the two orders.
    """
    tree, sums, screws, matrix = state.tree, work.sums, state.screws, work.equations.matrix
    for f in range(1, tree.frame_parent.shape[0]):
        xu, xv, xt, yu, yv, yt, zu, zv, zt, u, v, t = sums[f, :12]
        o = 3 * tree.pivot[f]
        ox, oy, oz = state.P[o], state.P[o + 1], state.P[o + 2]
        trace = xu + yv + zt - ox * u - oy * v - oz * t
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            a, b, c = screws[0, d], screws[1, d], screws[2, d]
            along = u * a + v * b + t * c
            x = xu * a + xv * b + xt * c - along * ox - trace * a
            y = yu * a + yv * b + yt * c - along * oy - trace * b
            z = zu * a + zv * b + zt * c - along * oz - trace * c
            for s in range(tree.first_run[f], tree.first_run[f + 1]):
                for e in range(tree.runs[s, 0], min(tree.runs[s, 1], d + 1)):
                    second = x * screws[0, e] + y * screws[1, e] + z * screws[2, e]
                    matrix[N_ORIGIN + d, N_ORIGIN + e] += second
        if tree.ball[f] >= 0:
            # The two orders differ by half the moment of the residuals along the third axis.
            m0 = yt - zv - (oy * t - oz * v)
            m1 = zu - xt - (oz * u - ox * t)
            m2 = xv - yu - (ox * v - oy * u)
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                for e in range(tree.first_dof[f], d):
                    k0 = screws[1, e] * screws[2, d] - screws[2, e] * screws[1, d]
                    k1 = screws[2, e] * screws[0, d] - screws[0, e] * screws[2, d]
                    k2 = screws[0, e] * screws[1, d] - screws[1, e] * screws[0, d]
                    matrix[N_ORIGIN + d, N_ORIGIN + e] -= 0.5 * (m0 * k0 + m1 * k1 + m2 * k2)


@internal
def _fix_at_bounds(state, target, equations):
    """Fix the dofs at a bound that the gradient pushes against."""
    for d in range(state.dofs.shape[0]):
        slope = equations.gradient[N_ORIGIN + d]
        low = state.dofs[d] <= target.lower[d] and slope > 0.0
        equations.fixed[N_ORIGIN + d] = low or (state.dofs[d] >= target.upper[d] and slope < 0.0)


@internal
def retract(state, step, target, moved):
    """Move a state by a step: turn its ball joints in their own axes, add to angles within bounds, move the root."""
    free = state.tree
    for i in range(N_ORIGIN):
        moved.origin[i] = state.origin[i] + step[i]
    for f in range(1, free.frame_parent.shape[0]):
        first, end = free.first_dof[f], free.end_dof[f]
        if free.ball[f] >= 0:
            q = free.reference[f, 0], free.reference[f, 1], free.reference[f, 2], free.reference[f, 3]
            k = N_ORIGIN + first
            w, x, y, z = product(q, quaternion_of(step[k], step[k + 1], step[k + 2]))
            size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
            moved.tree.reference[f, 0], moved.tree.reference[f, 1] = size * w, size * x
            moved.tree.reference[f, 2], moved.tree.reference[f, 3] = size * y, size * z
        else:
            for d in range(first, end):
                angle = state.dofs[d] + step[N_ORIGIN + d]
                moved.dofs[d] = min(max(angle, target.lower[d]), target.upper[d])


@unfolded
def _mean_diagonal(matrix):
    return np.trace(matrix) / matrix.shape[0]


@internal
def _corrected(work, target, stiffness, damping):
    """Take a second step from where a first one led, by the same equations; return the energy reached.

    Where the energy has not fallen, the reason is most often a narrow curved valley, which a straight step leaves and
    this one leads back to: the second-order correction of J. Nocedal, S. J. Wright, "Numerical Optimization", 2006,
    sec. 18.3.
    """
    equations = work.equations
    _gradient(work.there, target, stiffness, work)
    solve(work.there.tree, equations, damping)
    retract(work.there, equations.step, target, work.beyond)
    return _evaluate(work.beyond, target, stiffness, work.scratch)


@internal
def minimise_pose(work, target, first_damping, max_iter):
    """Find the minimum from the state `work.here` on, in place.

    The first step also goes a part of the way to θ₀ in what the positions leave open; the others only so far as the
    stiffness asks for.
    """
    here, there, equations = work.here, work.there, work.equations
    stiffness = max(target.stiffness, PULL * PULL)
    half = _evaluate(here, target, stiffness, work.scratch)
    scale, damping, exact = 0.0, 0.0, False
    for iteration in range(max_iter):
        if iteration == 1 and stiffness > target.stiffness:
            half -= (stiffness - target.stiffness) * _away(here, target)
            stiffness = target.stiffness
        _gradient(here, target, stiffness, work)
        _fill_matrix(here, stiffness, work)
        if iteration == 0:
            scale = _mean_diagonal(equations.matrix)
            damping = max(first_damping * scale, PULL * PULL / SHARE)
        _fix_at_bounds(here, target, equations)
        if exact:
            _add_second_derivatives(here, work)
        falling = True  # the energy, with this damping
        least = max(PRECISION * PRECISION, NEGLIGIBLE * half)
        while True:
            if not factorise(here.tree, equations, damping):
                if exact:
                    exact = False
                    _fill_matrix(here, stiffness, work)
                    continue
                return Fit(half, iteration, False)
            predicted = solve(here.tree, equations, damping)
            certain = damping <= CERTAIN * scale
            if predicted <= least:
                if certain:
                    return Fit(half, iteration, True)
                if falling:  # is the step so short because of the damping, or because this is the minimum?
                    damping = CERTAIN * scale
                    continue
                if not predicted > 0.0:
                    return Fit(half, iteration, False)
            retract(here, equations.step, target, there)
            reached = _evaluate(there, target, stiffness, work.scratch)
            if not half - reached > LEAST_RATIO * predicted:
                again = _corrected(work, target, stiffness, damping)
                if again < reached:
                    reached = again
                    copy_state(work.beyond, there)
            ratio = (half - reached) / predicted
            if ratio > LEAST_RATIO:
                break
            damping, falling = max(4.0 * damping, RAISED_DAMPING * scale), False
            if damping > MAX_DAMPING * scale:
                return Fit(half, iteration, False)
            _gradient(here, target, stiffness, work)
        exact = half - reached < SLOW * half
        copy_state(there, here)
        half = reached
        if certain and abs(1.0 - ratio) * predicted <= least and ratio > 0.5:
            return Fit(half, iteration + 1, True)
        if ratio > 0.75:
            damping = max((0.1 if falling and abs(1.0 - ratio) < 0.1 else 0.5) * damping, LEAST_DAMPING * scale)
        elif ratio < 0.25:
            damping = max(4.0 * damping, RAISED_DAMPING * scale)
    return Fit(half, max_iter, False)
