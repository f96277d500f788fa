"""The energy of inverse kinematics, its gradient and its Hessian, at one pose.

The energy is Σ w ‖R·F(θ) + o − p‖² + ρ² ‖θ ⊖ θ₀‖² over the joints that are seen, with the root's orientation R as a
ball joint of the tree and its position o as three dofs more. Joints with three dofs are rotations, not numbers:
derivatives are by turns in their own axes.

No Jacobian is formed: sums over the joints that a frame moves, gathered from the leaves to the root, give gradient and
matrix, as in `path.normal_equations`, which does so for the many poses of a path.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.path.block_cholesky import Band, clear, factorise_band, substitute_back, substitute_forward
from skpose._compiled.path.energy import LANES
from skpose._compiled.pose.chart import free_tree, keep_bounded, rotation_of
from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.jacobian import place_with_screws
from skpose._compiled.pose.rotation import inverse, product, put_quaternion, quaternion_at, sign_towards, vector_of
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.pose.tree import Tree
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.lanes import copy_to, empty_aligned
from skpose._compiled.simd.signatures import FLAG, FLAG_VECTOR, MATRIX, REAL, VECTOR, tuple_type

N_ORIGIN = 3  # dofs of the root's position


class Equations(NamedTuple):
    """The equations H·step = −gradient."""

    matrix: np.ndarray  # (n, n) lower triangle; zero where two dofs move no joint in common
    gradient: np.ndarray  # (n,)
    step: np.ndarray  # (n,)
    fixed: np.ndarray  # (n,) bool: dofs that do not move
    cells: np.ndarray  # (n_registers, LANES) a band of one block, and the solution


EQUATIONS = tuple_type(Equations, MATRIX, VECTOR, VECTOR, FLAG_VECTOR, MATRIX)


@internal
def _band_of(n):
    """The band of n dofs, padded to whole registers."""
    width = -(-n // LANES)
    return Band(1, width, 0, width * LANES * 2 * width)


@internal
def equations_of(tree):
    """Equations for a tree, not yet filled, no dof fixed."""
    n = N_ORIGIN + tree.column.shape[0]
    band = _band_of(n)
    cells = empty_aligned(band.solution + band.n, LANES, np.float64)
    return Equations(np.zeros((n, n)), np.zeros(n), np.zeros(n), np.zeros(n, np.bool_), cells)


@by_address(lambda: FLAG(EQUATIONS, REAL))
def factorise(equations, damping):
    """Factorise the matrix plus a multiple of the identity; return whether that is positive definite.

    Fixed and padded dofs get a row of the identity.
    """
    matrix, fixed, cells, n = equations.matrix, equations.fixed, equations.cells, equations.step.shape[0]
    band, numbers = _band_of(n), cells.reshape(cells.size)
    width = 2 * band.n * LANES
    clear(cells, 0, band.solution)
    for k in range(band.n * LANES):
        numbers[k * width + k] = 1.0
    for k in range(n):
        if not fixed[k]:
            for j in range(k):
                numbers[j * width + k] = 0.0 if fixed[j] else matrix[k, j]
            numbers[k * width + k] = matrix[k, k] + damping
    return factorise_band(cells, band)


@by_address(lambda: REAL(EQUATIONS, REAL))
def solve(equations, damping):
    """Compute the step from the factors; return the decrease of the quadratic model, without the damping."""
    cells, gradient, step, lowered = equations.cells, equations.gradient, equations.step, 0.0
    band, numbers = _band_of(step.shape[0]), cells.reshape(cells.size)
    at = band.solution * LANES
    clear(cells, band.solution, band.n)
    for k in range(step.shape[0]):
        numbers[at + k] = 0.0 if equations.fixed[k] else -gradient[k]
    substitute_forward(cells, band)
    substitute_back(cells, band)
    for k in range(step.shape[0]):
        step[k] = numbers[at + k]
        lowered += 0.5 * step[k] * (damping * step[k] - gradient[k])
    return lowered


# --- energy -----------------------------------------------------------------------------------------------------------


class State(NamedTuple):
    """A pose, as rotations of the frames that turn freely and angles of the others."""

    rotations: np.ndarray  # (n_frames, 4) quaternions of the frames that turn freely
    dofs: np.ndarray  # (n_dofs,) angles, rad; zero where frames turn freely
    origin: np.ndarray  # (3,) position of the root, m
    P: np.ndarray  # (3 n_joints + 3,) positions from the root, m
    screws: np.ndarray  # (n_dofs, 6) see `screws.set_screws`


class Target(NamedTuple):
    """Positions that are to be reached, and what settles the rest."""

    positions: np.ndarray  # (n_joints + 1, 3) m, in the tree's order, the root's first; finite everywhere
    weights: np.ndarray  # (n_joints + 1,) zero where not seen
    prior: np.ndarray  # (n_frames, 4) rotations θ₀ of ball joints
    prior_dofs: np.ndarray  # (n_dofs,) angles θ₀, rad
    stiffness: float  # ρ², m²/rad²
    lower: np.ndarray  # (n_dofs,) rad
    upper: np.ndarray  # (n_dofs,) rad


class Workspace(NamedTuple):
    """Arrays that every frame uses again."""

    tree: Tree  # its references are the rotations of the state that was placed last
    here: State
    there: State
    best: State
    kept: State  # for the caller
    equations: Equations
    sums: np.ndarray  # (n_frames, 25) over the joints that a frame moves: w p rᵀ, w r, w p pᵀ, w p, w
    scratch: np.ndarray


STATE = tuple_type(State, MATRIX, VECTOR, VECTOR, VECTOR, MATRIX)
TARGET = tuple_type(Target, MATRIX, VECTOR, MATRIX, VECTOR, REAL, VECTOR, VECTOR)
WORKSPACE = tuple_type(Workspace, TREE, STATE, STATE, STATE, STATE, EQUATIONS, MATRIX, VECTOR)


@internal
def _empty_state(tree):
    n_frames, n_dofs = tree.frame_parent.shape[0], tree.column.shape[0]
    return State(
        np.zeros((n_frames, 4)),
        np.zeros(n_dofs),
        np.zeros(3),
        np.zeros(3 * tree.offset.shape[0]),
        np.zeros((n_dofs, 6)),
    )


@internal
def workspace_of(tree, lower, upper):
    """Arrays for the search for poses of a tree, whose joints of three angles turn freely without bounds."""
    free = free_tree(tree, True)
    keep_bounded(tree, free, lower, upper)
    return Workspace(
        free,
        _empty_state(tree),
        _empty_state(tree),
        _empty_state(tree),
        _empty_state(tree),
        equations_of(tree),
        np.zeros((tree.frame_parent.shape[0], 25)),
        np.empty(workspace_rows(tree)),
    )


@by_address(lambda: types.void(STATE, STATE))
def copy_state(source, target):
    """Copy a state to another."""
    copy_to(target.rotations, source.rotations)
    copy_to(target.dofs, source.dofs)
    copy_to(target.origin, source.origin)
    copy_to(target.P, source.P)
    copy_to(target.screws, source.screws)


@by_address(lambda: types.void(WORKSPACE, STATE))
def place_state(work, state):
    """Compute the positions and the screws of a state."""
    copy_to(work.tree.reference, state.rotations)
    place_with_screws(work.tree, state.dofs, work.scratch, state.P, state.screws)


@internal
def set_pose(tree, dofs, rotations, angles):
    """Write a pose as rotations of the frames that may turn freely, and as angles."""
    for f in range(1, tree.frame_parent.shape[0]):
        if tree.end_dof[f] - tree.first_dof[f] == 3:
            put_quaternion(rotation_of(tree, dofs, f), rotations, f)
    copy_to(angles, dofs)


@internal
def start_at(tree, state, rotations, angles):
    """Let a state have the rotations and angles of a pose, with the root at the origin."""
    copy_to(state.rotations, rotations)
    copy_to(state.dofs, angles)
    state.origin[:] = 0.0
    for f in range(1, tree.frame_parent.shape[0]):
        if tree.ball[f] >= 0:
            state.dofs[tree.first_dof[f] : tree.end_dof[f]] = 0.0


@internal
def _turn_from(before, now, f):
    """The rotation vector of a frame from one set of rotations to another, in the rotated axes."""
    p, q = quaternion_at(before, f), quaternion_at(now, f)
    sign = sign_towards(p, q)
    w, x, y, z = product(inverse(p), q)
    return vector_of((sign * w, sign * x, sign * y, sign * z))


@internal
def half_square_away(tree, state, target):
    """Half the squared distance from θ₀ in rad²; the root's frame, the first one, has no part in it."""
    half = 0.0
    for f in range(2, tree.frame_parent.shape[0]):
        if tree.ball[f] >= 0:
            x, y, z = _turn_from(target.prior, state.rotations, f)
            half += 0.5 * (x * x + y * y + z * z)
        else:
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                half += 0.5 * (state.dofs[d] - target.prior_dofs[d]) ** 2
    return half


@by_address(lambda: REAL(WORKSPACE, STATE, TARGET, REAL))
def evaluate_pose(work, state, target, stiffness):
    """Place the joints; return half the energy."""
    place_state(work, state)
    half = 0.0
    for j in range(1, target.weights.shape[0]):
        w = target.weights[j]
        if w > 0.0:
            x = state.P[3 * j] + state.origin[0] - target.positions[j, 0]
            y = state.P[3 * j + 1] + state.origin[1] - target.positions[j, 1]
            z = state.P[3 * j + 2] + state.origin[2] - target.positions[j, 2]
            half += 0.5 * w * (x * x + y * y + z * z)
    if stiffness > 0.0:
        half += stiffness * half_square_away(work.tree, state, target)
    return half


@internal
def _sum_joints(tree, state, target, sums):
    """Sum the moments of the joints that each frame moves."""
    sums[:] = 0.0
    for j in range(1, target.weights.shape[0]):
        w = target.weights[j]
        if w == 0.0:
            continue
        total = sums[tree.joint_frame[j]]
        for i in range(3):
            p = state.P[3 * j + i]
            for k in range(3):
                q = state.P[3 * j + k]
                total[3 * i + k] += p * (w * (q + state.origin[k] - target.positions[j, k]))
                total[12 + 3 * i + k] += w * p * q
            total[9 + i] += w * (p + state.origin[i] - target.positions[j, i])
            total[21 + i] += w * p
        total[24] += w
    for f in range(tree.frame_parent.shape[0] - 1, 0, -1):
        p = tree.frame_parent[f]
        for i in range(25):
            sums[p, i] += sums[f, i]


@by_address(lambda: types.void(STATE, TARGET, REAL, WORKSPACE))
def fill_gradient(state, target, stiffness, work):
    """Compute the gradient of half the energy by turns, angles and the root's position."""
    tree, gradient, sums, screws = work.tree, work.equations.gradient, work.sums, state.screws
    _sum_joints(tree, state, target, sums)
    for i in range(N_ORIGIN):
        gradient[i] = sums[0, 9 + i]
    for f in range(1, tree.frame_parent.shape[0]):
        first = tree.first_dof[f]
        _, xv, xt, yu, _, yt, zu, zv, _, u, v, t = sums[f, :12]
        for d in range(first, tree.end_dof[f]):
            slope = (yt - zv) * screws[d, 0] + (zu - xt) * screws[d, 1] + (xv - yu) * screws[d, 2]
            gradient[N_ORIGIN + d] = slope + u * screws[d, 3] + v * screws[d, 4] + t * screws[d, 5]
        if stiffness == 0.0 or f == 1:
            continue
        if tree.ball[f] >= 0:  # the gradient of ½ |v|² by a turn in the rotated axes is v
            x, y, z = _turn_from(target.prior, state.rotations, f)
            gradient[N_ORIGIN + first] += stiffness * x
            gradient[N_ORIGIN + first + 1] += stiffness * y
            gradient[N_ORIGIN + first + 2] += stiffness * z
        else:
            for d in range(first, tree.end_dof[f]):
                gradient[N_ORIGIN + d] += stiffness * (state.dofs[d] - target.prior_dofs[d])


@by_address(lambda: types.void(STATE, REAL, WORKSPACE))
def fill_matrix(state, stiffness, work):
    """Compute the Gauss-Newton matrix, after the gradient."""
    tree, sums, screws, matrix = work.tree, work.sums, state.screws, work.equations.matrix
    for i in range(N_ORIGIN):
        for j in range(i + 1):
            matrix[i, j] = sums[0, 24] if i == j else 0.0
    for f in range(1, tree.frame_parent.shape[0]):
        xx, xy, xz, _, yy, yz, _, _, zz, px, py, pz, n = sums[f, 12:]
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            a, b, c, p, q, r = screws[d]
            j0 = (yy + zz) * a - xy * b - xz * c + py * r - pz * q
            j1 = (xx + zz) * b - xy * a - yz * c + pz * p - px * r
            j2 = (xx + yy) * c - xz * a - yz * b + px * q - py * p
            j3 = b * pz - c * py + n * p
            j4 = c * px - a * pz + n * q
            j5 = a * py - b * px + n * r
            matrix[N_ORIGIN + d, 0], matrix[N_ORIGIN + d, 1], matrix[N_ORIGIN + d, 2] = j3, j4, j5
            for s in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
                for e in range(tree.dof_ranges[s, 0], min(tree.dof_ranges[s, 1], d + 1)):
                    jj = j0 * screws[e, 0] + j1 * screws[e, 1] + j2 * screws[e, 2]
                    jj += j3 * screws[e, 3] + j4 * screws[e, 4] + j5 * screws[e, 5]
                    matrix[N_ORIGIN + d, N_ORIGIN + e] = jj
            if f > 1:
                matrix[N_ORIGIN + d, N_ORIGIN + d] += stiffness


@internal
def add_second_derivatives_of_pose(state, work):
    """Add what Gauss-Newton leaves out: residuals times second derivatives.

    As in `path.curvature`. The axes of a ball joint, whose turn is a rotation vector at zero, have the mean of the two
    orders.
    """
    tree, sums, screws, matrix = work.tree, work.sums, state.screws, work.equations.matrix
    for f in range(1, tree.frame_parent.shape[0]):
        xu, xv, xt, yu, yv, yt, zu, zv, zt, u, v, t = sums[f, :12]
        trace = xu + yv + zt
        for d in range(tree.first_dof[f], tree.end_dof[f]):
            a, b, c, p, q, r = screws[d]
            x = xu * a + xv * b + xt * c - trace * a + (q * t - r * v)
            y = yu * a + yv * b + yt * c - trace * b + (r * u - p * t)
            z = zu * a + zv * b + zt * c - trace * c + (p * v - q * u)
            for s in range(tree.first_dof_range[f], tree.first_dof_range[f + 1]):
                for e in range(tree.dof_ranges[s, 0], min(tree.dof_ranges[s, 1], d + 1)):
                    second = x * screws[e, 0] + y * screws[e, 1] + z * screws[e, 2]
                    matrix[N_ORIGIN + d, N_ORIGIN + e] += second
        if tree.ball[f] >= 0:
            # The two orders differ by half the moment of the residuals along the third axis.
            o = 3 * tree.pivot[f]
            ox, oy, oz = state.P[o], state.P[o + 1], state.P[o + 2]
            m0 = yt - zv - (oy * t - oz * v)
            m1 = zu - xt - (oz * u - ox * t)
            m2 = xv - yu - (ox * v - oy * u)
            for d in range(tree.first_dof[f], tree.end_dof[f]):
                for e in range(tree.first_dof[f], d):
                    k0 = screws[e, 1] * screws[d, 2] - screws[e, 2] * screws[d, 1]
                    k1 = screws[e, 2] * screws[d, 0] - screws[e, 0] * screws[d, 2]
                    k2 = screws[e, 0] * screws[d, 1] - screws[e, 1] * screws[d, 0]
                    matrix[N_ORIGIN + d, N_ORIGIN + e] -= 0.5 * (m0 * k0 + m1 * k1 + m2 * k2)
