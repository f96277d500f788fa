"""The geodesic between two poses, and the metric that measures its length.

The discretisation check
------------------------
Few poses can sit where their chords are short while the motion between them is long. So every path is measured again on
a fine grid. Where the two lengths disagree, the energy is taken over `SUBSTEPS` chords between each two free poses,
then over more free poses.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.jit import internal, jit, unfolded
from skpose._compiled.measure import measure_line, turns_off
from skpose._compiled.minimiser import FIRST_DAMPING, MAX_GAP, ROUNDING, Settings, minimise, rounding_length, unbounded
from skpose._compiled.path_energy import chords, curve_length, divided, path_of
from skpose._compiled.tree import TWO_PI

MAX_ITER, TOL = 500, 1e-7  # iterations in each refinement; norm of the gradient, m²/rad
SUBSTEPS = 4
REFINEMENTS = ((1, 1), (1, SUBSTEPS), (2, SUBSTEPS), (4, SUBSTEPS))  # free steps over n_steps, chords in each
NEAR = 1e-3  # a relative decrease of the energy below which the exact Hessian takes over, on refined paths
LEAST_CHANGE = 0.1  # see `minimiser.Settings`
PATIENCE = 10  # iterations, on paths that are not refined
NEVER = 1 << 62  # iterations
AGREE = 1e-6  # relative difference of chord and line within which the line's length is the geodesic's


class Curve(NamedTuple):
    """A geodesic: its samples, and how they were found."""

    poses: np.ndarray  # (n_points, n_dofs) angles in the tree's order, rad
    energy: float  # m²
    length: float  # sum of the chords, m
    curve_length: float  # on the fine grid, m
    gradient_norm: float  # of the energy in the free poses, m²/rad
    n_iter: int  # of all refinements
    converged: bool


@unfolded
def _settings_for(substeps, max_iter, tol):
    exact_below, patience = (0.0, PATIENCE) if substeps == 1 else (NEAR, NEVER)
    return Settings(max_iter, tol, FIRST_DAMPING, exact_below, LEAST_CHANGE, False, patience)


@internal
def find_geodesic(tree, start, end, n_steps, bounds, max_iter, tol):
    """Find a path of least energy from start to end, angles in the tree's order, that passes the discretisation check.

    Where none is found that is no longer than the straight line, the path is that line, unconverged.
    """
    line = np.empty((2, start.shape[0]))
    line[0], line[1] = start, end
    poses = divided(line, n_steps)
    noise, straight = rounding_length(tree), chords(tree, poses)[0]
    n_iter = 0
    for factor, substeps in REFINEMENTS:
        if substeps > 1:
            poses = divided(line, n_steps) if factor == 1 else divided(poses, 2)
        settings = _settings_for(substeps, max_iter, tol)
        path = path_of(tree, poses, substeps)
        outcome = minimise(tree, path, bounds, settings)
        n_iter += outcome.n_iter
        poses = path.poses
        samples = divided(poses, substeps)
        length, energy = chords(tree, samples)
        along = curve_length(tree, samples)
        if along - length <= MAX_GAP * along + noise and (
            along <= straight or along <= curve_length(tree, divided(line, samples.shape[0] - 1)) + noise
        ):
            return Curve(samples, energy, length, along, outcome.gradient_norm, n_iter, outcome.converged)
    poses = divided(line, n_steps)
    length, energy = chords(tree, poses)
    return Curve(poses, energy, length, curve_length(tree, poses), math.nan, n_iter, False)


@jit
def measure_geodesic(x, Y, first, last, tree, steps, scratch, results):
    """Compute the length of the geodesic, eq. 3; where chord and straight line agree already, that of the line.

    Sets the gap of a geodesic that did not converge.
    """
    measure_line(x, Y, first, last, tree, steps, scratch, results)
    n, n_codes = tree.column.shape[0], x.shape[0]
    width, n_groups = Y.size // Y.shape[0], results.distances.shape[0]
    codes, distances = Y.reshape((Y.shape[0], width)), results.distances.reshape((n_groups, width))
    skip, gaps = results.skip.reshape((n_groups, width)), results.gap.reshape((n_groups, width))
    bounds, noise = unbounded(n), rounding_length(tree)
    start, end = np.empty(n), np.empty(n)
    for k in range(first, last):
        code, group = codes[k * n_codes : (k + 1) * n_codes], k - first
        for w in range(width):
            line = distances[group, w]
            square = 0.0
            for i in range(5 * n, n_codes):
                square += (code[i, w] - x[i]) ** 2
            chord = math.sqrt(square)
            if skip[group, w] or line - chord <= AGREE * line + noise:
                continue
            ahead = 0  # sign of the first difference of angles that is not zero: both directions give the same number
            for d in range(n):
                gap = code[d, w] - x[d]
                if ahead == 0 and gap != 0.0:
                    ahead = 1 if gap > 0.0 else -1
                gap -= turns_off(gap, steps) * TWO_PI
                start[d] = x[d] if ahead >= 0 else code[d, w]
                end[d] = start[d] + gap * ahead
            curve = find_geodesic(tree, start, end, steps.n_steps, bounds, MAX_ITER, TOL)
            distances[group, w] = max(chord, min(curve.length, line))
            if not curve.converged:
                gaps[group, w] = max((curve.curve_length - curve.length) / curve.curve_length, ROUNDING)
