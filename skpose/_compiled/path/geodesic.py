"""The geodesic between two poses, and the metric that measures its length.

A path is found downhill from a straight line. Where joints with three dofs are given by angles there are two: the line
of the angles, and the one on which these joints turn by slerp (see `chart`). It starts from the shorter one.

The discretisation check
------------------------
Few poses can sit where their chords are short while the motion between them is long. So every path is measured again on
a fine grid. Where the two lengths disagree, the energy is taken over `SUBSTEPS` chords between each two free poses,
then over more free poses.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from skpose._compiled.path.energy import FINE, Path, chords, curve_length, divide, path_of
from skpose._compiled.path.minimiser import (
    BOUNDS,
    MAX_GAP,
    OUTCOME,
    ROUNDING,
    STOP,
    Outcome,
    Settings,
    Stop,
    minimise,
    no_bounds,
)
from skpose._compiled.pose.chart import (
    chart_at,
    coordinates_of,
    differs,
    dofs_of,
    free_tree,
    keep_bounded,
    line_of_angles,
    pose_of,
    set_references,
)
from skpose._compiled.pose.encode import n_line_codes
from skpose._compiled.pose.forward import SQRT2, size_of
from skpose._compiled.pose.measure import measure_line, turns_off
from skpose._compiled.pose.rotation import inverse, product, quaternion_at, vector_of
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.pose.tree import TWO_PI
from skpose._compiled.simd.jit import by_address, first_class, internal, jit
from skpose._compiled.simd.lanes import copy_to
from skpose._compiled.simd.signatures import FLAG, INTEGER, MATRIX, REAL, VECTOR, tuple_type

MAX_ITER, TOL = 500, 1e-6  # iterations in each refinement; share of the length that is left to gain
GRADIENT_NORM = 1e-7  # of the energy, where not only the length of a path matters but also its direction, m²/rad
SUBSTEPS = 4
REFINEMENTS = ((1, 1), (1, SUBSTEPS), (2, SUBSTEPS), (4, SUBSTEPS))  # free steps over n_steps, chords in each
PATIENCE = 10  # iterations, on paths that are not refined
NEVER = 1 << 62  # iterations
ARRIVED = 1e-9  # rounding of the last pose's dofs, rad
BITS = 2.0**36  # of dofs, see `_dofs_in`
AGREE = 1e-6  # relative difference of chord and line within which the line's length is the geodesic's


class Curve(NamedTuple):
    """A geodesic: its samples, and how they were found."""

    poses: np.ndarray  # (n_points, n_dofs) coordinates, see `chart`
    energy: float  # m²
    length: float  # sum of the chords, m
    curve_length: float  # on the fine grid, m
    gradient_norm: float  # of the energy in the free poses, m²/rad
    gain: float  # share of the length that is left to gain
    n_iter: int  # of all refinements
    converged: bool


CURVE = tuple_type(Curve, MATRIX, REAL, REAL, REAL, REAL, REAL, INTEGER, FLAG)


@by_address(lambda: MATRIX(TREE, TREE, VECTOR, VECTOR, INTEGER))
def slerp_line(tree, free, start, end, n_steps):
    """Set the references, and return the line on which ball joints turn by slerp, in coordinates."""
    ends = np.empty((2, start.shape[0]))
    set_references(tree, free, start, end)
    coordinates_of(tree, free, start, ends[0])
    coordinates_of(tree, free, end, ends[1])
    return divide(ends, n_steps)


@internal
def _curve_length(tree, local, poses):
    """The length of the curve through poses on a fine grid: straight from pose to pose, ball joints by slerp.

    The references of the local tree are set for each step.
    """
    along = 0.0
    for i in range(poses.shape[0] - 1):
        along += chords(local, slerp_line(tree, local, poses[i], poses[i + 1], FINE))[0]
    return along


@by_address(lambda: types.Tuple([CURVE, FLAG])(TREE, MATRIX, TREE, MATRIX, OUTCOME, INTEGER))
def check_discretisation(line_tree, line, tree, samples, outcome, n_iter):
    """The samples of a path as a curve, and whether it passes the discretisation check.

    It also has to be no longer than the line, whose coordinates may be others.
    """
    local, noise = free_tree(tree, False), ROUNDING * size_of(tree)
    length, energy = chords(tree, samples)
    along = _curve_length(tree, local, samples)
    passes = along - length <= MAX_GAP * along + noise
    if passes and along > chords(line_tree, line)[0]:
        finer = divide(line, (samples.shape[0] - 1) // (line.shape[0] - 1))
        passes = along <= curve_length(line_tree, finer) + noise
    gain = 0.5 * outcome.gain  # of the length, the square root of the energy
    return Curve(samples, energy, length, along, outcome.gradient_norm, gain, n_iter, outcome.converged), passes


@by_address(lambda: CURVE(TREE, MATRIX, BOUNDS, STOP))
def find_geodesic(tree, line, bounds, stop):
    """Find a path of least energy that passes the discretisation check, from a line of poses on.

    Where none is found that is no longer than that line, the path is the line, unconverged.
    """
    n_iter, poses = 0, line
    for factor, substeps in REFINEMENTS:
        if substeps > 1:
            poses = line if factor == 1 else divide(poses, 2)
        settings = Settings(stop, False, PATIENCE if substeps == 1 else NEVER)
        path = path_of(tree, poses, substeps)
        outcome = minimise(tree, path, bounds, settings)
        n_iter += outcome.n_iter
        poses = path.poses
        curve, passes = check_discretisation(tree, line, tree, divide(poses, substeps), outcome, n_iter)
        given_up = substeps == 1 and outcome.gain == math.inf  # in the middle of the search; refined, it may end
        if passes and not given_up:
            return curve
    length, energy = chords(tree, line)
    local = free_tree(tree, False)
    return Curve(line, energy, length, _curve_length(tree, local, line), math.nan, math.nan, n_iter, False)


@by_address(lambda: types.Tuple([MATRIX, REAL])(TREE, TREE, VECTOR, VECTOR, INTEGER))
def shorter_line(tree, free, start, end, n_steps):
    """The shorter straight line from a pose to another, in coordinates, and its length."""
    line = slerp_line(tree, free, start, end, n_steps)
    length = chords(free, line)[0]
    if differs(tree, free):
        other = np.empty(line.shape)
        if line_of_angles(tree, free, start, end, other):
            other_length = chords(free, other)[0]
            if other_length < length:
                return other, other_length
    return line, length


@jit
def path_between(tree, start, end, n_steps, frees_angles, bounds, max_iter, tol, bend):
    """Find the geodesic between two poses, the difference of angles wrapped already; return it as poses.

    Joints of three angles turn freely if so asked, but those with bounds. The search starts at the line between the
    poses, moved by `bend` in the middle.
    """
    free = free_tree(tree, frees_angles)
    keep_bounded(tree, free, bounds.lower, bounds.upper)
    line, _ = shorter_line(tree, free, start, end, n_steps)
    for i in range(1, n_steps):
        for d in range(end.shape[0]):
            moved = line[i, d] + 4.0 * i * (n_steps - i) / n_steps**2 * bend[d]
            line[i, d] = min(max(moved, bounds.lower[d]), bounds.upper[d]) if bend[d] != 0.0 else line[i, d]
    for d in range(end.shape[0]):
        if bounds.lower[d] > -math.inf or bounds.upper[d] < math.inf:
            line[n_steps, d] = end[d]  # without the rounding error of the line, which may be outside
    curve = find_geodesic(free, line, bounds, Stop(max_iter, 0.0, tol))
    poses, last = np.empty(curve.poses.shape), curve.poses.shape[0] - 1
    copy_to(poses[0], start)
    for i in range(1, last + 1):
        dofs_of(tree, free, curve.poses[i], poses[i - 1], poses[i])
    farthest = 0.0
    for d in range(end.shape[0]):
        farthest = max(farthest, abs(poses[last, d] - end[d]))
    if farthest < ARRIVED:
        copy_to(poses[last], end)
    return Curve(
        poses,
        curve.energy,
        curve.length,
        curve.curve_length,
        curve.gradient_norm,
        curve.gain,
        curve.n_iter,
        curve.converged,
    )


@internal
def _dofs_in(tree, code, dofs):
    """Read the dofs of a pose from its code; if it has ball joints, to 36 bits.

    The same rotation in other numbers differs by rounding, which the iterations of a long path make larger.
    """
    n, n_balls = tree.angle_dof.shape[0], tree.ball_frame.shape[0]
    for k in range(tree.slide_dof.shape[0]):
        dofs[tree.slide_dof[k]] = code[5 * n + 4 * n_balls + k]
    for k in range(n):
        dofs[tree.angle_dof[k]] = np.rint(code[k] * BITS) / BITS if n_balls > 0 else code[k]
    rotation = np.empty((1, 4))
    for k in range(n_balls):
        f = tree.ball_frame[k]
        for i in range(4):
            rotation[0, i] = np.rint(code[5 * n + 4 * k + i] / SQRT2 * BITS) / BITS
        d, turned = tree.first_dof[f], product(inverse(quaternion_at(tree.reference, f)), quaternion_at(rotation, 0))
        dofs[d], dofs[d + 1], dofs[d + 2] = vector_of(turned)


@internal
def _is_ahead(tree, x, y):
    """Whether the first dof in which two codes differ is larger in y: one rule for both orders of the two."""
    n = tree.angle_dof.shape[0]
    for k in range(n_line_codes(tree)):
        if not n <= k < 5 * n and x[k] != y[k]:
            return y[k] > x[k]
    return True


@first_class
def measure_geodesic(x, Y, first, last, tree, steps, scratch, results):
    """Compute the length of the geodesic, eq. 3; the line's, if that agrees with the chord already.

    Sets the gap of a geodesic that did not converge.
    """
    results.limit[0] = np.inf  # a geodesic may be within it where the line is not
    measure_line(x, Y, first, last, tree, steps, scratch, results)
    n, n_codes = tree.column.shape[0], x.shape[0]
    width, n_groups = Y.size // Y.shape[0], results.distances.shape[0]
    codes, distances = Y.reshape((Y.shape[0], width)), results.distances.reshape((n_groups, width))
    skip, gaps = results.skip.reshape((n_groups, width)), results.gap.reshape((n_groups, width))
    bounds, noise, free = no_bounds(n), ROUNDING * size_of(tree), free_tree(tree, steps.half_turn < math.inf)
    start, end, stop = np.empty(n), np.empty(n), Stop(MAX_ITER, 0.0, TOL)
    for k in range(first, last):
        code, group = codes[k * n_codes : (k + 1) * n_codes], k - first
        for w in range(width):
            line = distances[group, w]
            square = 0.0
            first_position = n_line_codes(tree)
            for i in range(first_position, n_codes):
                square += ((code[i, w] - x[i]) * tree.scale[1 + (i - first_position) // 3]) ** 2
            chord = math.sqrt(square)
            if skip[group, w] or line - chord <= AGREE * line + noise:
                continue
            if _is_ahead(tree, x, code[:, w]):  # both directions give the same number
                _dofs_in(tree, x, start)
                _dofs_in(tree, code[:, w], end)
            else:
                _dofs_in(tree, code[:, w], start)
                _dofs_in(tree, x, end)
            for d in tree.angle_dof:
                gap = end[d] - start[d]
                end[d] = start[d] + (gap - turns_off(gap, steps) * TWO_PI)
            path, shorter = shorter_line(tree, free, start, end, steps.n_steps)
            line = min(line, shorter)
            if line - chord <= AGREE * line + noise:
                distances[group, w] = max(chord, line)
                continue
            curve = find_geodesic(free, path, bounds, stop)
            distances[group, w] = max(chord, min(curve.length, line))
            if not curve.converged:
                gaps[group, w] = max((curve.curve_length - curve.length) / curve.curve_length, ROUNDING)


@jit
def project(tree, target, pose, max_iter, tol):
    """Find the pose nearest to given scaled positions, a minimum of ‖F(θ) − target‖², from a first pose on.

    This is half the energy of a path of two chords with both ends at the target. The Hessian is exact throughout.
    Returns the pose and the outcome, with the gradient of ‖F(θ) − target‖².
    """
    free, coordinates = chart_at(tree, pose, True)
    poses, ends = np.empty((3, pose.shape[0])), np.zeros((2, 3 * tree.offset.shape[0]))
    for i in range(3):
        copy_to(poses[i], coordinates)
    for j in range(1, tree.offset.shape[0]):
        for i in range(3 if tree.scale[j] > 0.0 else 0):
            ends[0, 3 * j + i] = target[3 * tree.code_joint[j] - 3 + i] / tree.scale[j]
    copy_to(ends[1], ends[0])
    path = Path(poses, ends, 1)
    settings = Settings(Stop(max_iter, 2.0 * tol, 0.0), True, NEVER)
    outcome = minimise(free, path, no_bounds(pose.shape[0]), settings)
    found = pose_of(tree, free, path.poses[1], pose)
    return found, Outcome(0.5 * outcome.gradient_norm, outcome.gain, outcome.n_iter, outcome.converged)
