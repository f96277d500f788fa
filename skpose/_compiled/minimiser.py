"""The path of least energy between two poses, and what keeps it honest.

The step
--------
Gauss-Newton: the normal equations of the energy's residuals are block tridiagonal in the poses. They are damped by a
multiple λ of the identity, since JᵀJ is singular (a twist of the last bone moves nothing), and λ follows the ratio of
actual to predicted decrease, as the radius of a trust region would. What Gauss-Newton leaves out makes its steps too
short, always by much the same factor near the end; so steps are combined as in conjugate gradients, with the damped
normal equations as the preconditioner, and their length is that of the parabola through energy, slope and trial. On
refined paths, where more is left out, the exact Hessian takes over near the end.

Honesty
-------
Few poses can sit where their chords are short while the motion between them is long. So every path is measured again
on a fine grid. Where the two lengths disagree, the energy is taken over `SUBSTEPS` chords between each two free poses,
then over more free poses. Where the gradient is nought but the Hessian bends down, the path is a saddle and is left.
"""

import math

import numpy as np

from skpose._compiled.block_cholesky import band_shape, solve
from skpose._compiled.forward import workspace_rows
from skpose._compiled.jit import jit
from skpose._compiled.measure import measure_line, turns_off
from skpose._compiled.path_energy import add_curvature, chords, curve_length, divided, evaluate, normal_equations
from skpose._compiled.tree import TWO_PI

GAP = 5e-3  # how far, relatively, the two lengths of an honest path may differ
SUBSTEPS = 4
REFINEMENTS = ((1, 1), (1, SUBSTEPS), (2, SUBSTEPS), (4, SUBSTEPS))  # free steps over n_steps, chords in each
DAMPING = 1e-6, 1e-8  # λ at first and at least, over the mean diagonal of the normal equations
HOPELESS = 1e6  # λ at which to give up, likewise
LEAST_RATIO = 1e-4  # of actual to predicted decrease, for a step to be taken
NEAR = 1e-3  # a relative decrease of the energy below which the exact Hessian takes over
ROUNDING = 1e-14  # relative to the energy or to the sum of the bones, what float64 cannot show
PATIENCE, LOST = 10, 4.0  # every so many iterations a path is given up whose gap is so many times too wide
FLAT = 1e-4  # curvature below which the energy counts as flat, over the mean diagonal of the normal equations
KICK, MAX_KICKS = 1e-2, 2  # how far a path is bent that has stopped on a saddle, rad, and how often
MAX_ITER, TOL = 500, 1e-7  # iterations in each refinement; norm of the gradient, m²/rad
AGREE = 1e-6  # chord and line that differ by no more, relatively, are the geodesic's length


@jit
def _noise(tree):
    """A length that is nought but for rounding."""
    reach = 0.0
    for j in range(tree.offset.shape[0]):
        reach += abs(tree.offset[j, 0]) + abs(tree.offset[j, 1]) + abs(tree.offset[j, 2])
    return ROUNDING * reach


@jit
def _gap(tree, path):
    """How much longer the path is on the fine grid than by its chords, relatively."""
    along = curve_length(tree, path)
    return (along - chords(tree, path)[0]) / along if along > 0.0 else 0.0


@jit
def _dot(a, b):
    total = 0.0
    for i in range(a.shape[0]):
        for d in range(a.shape[1]):
            total += a[i, d] * b[i, d]
    return total


@jit
def _combine(step, turn, direction):
    """direction = step + turn · direction."""
    for i in range(step.shape[0]):
        for d in range(step.shape[1]):
            direction[i, d] = step[i, d] + turn * direction[i, d]


@jit
def _hold(path, lower, upper, gradient, held):
    """Hold the dofs of the free poses that are at a bound which the gradient pushes against; whether these are others.

    What is held, and the ends, have no gradient.
    """
    changed = False
    gradient[0], gradient[-1] = 0.0, 0.0
    for i in range(1, path.shape[0] - 1):
        for d in range(path.shape[1]):
            angle, slope = path[i, d], gradient[i, d]
            hold = (angle <= lower[d] and slope > 0.0) or (angle >= upper[d] and slope < 0.0)
            changed = changed or hold != held[i, d]
            held[i, d] = hold
            if hold:
                gradient[i, d] = 0.0
    return changed


@jit
def _move(path, direction, size, lower, upper, trial):
    """trial = path + size · direction, the free poses kept within their bounds."""
    for i in range(1, path.shape[0] - 1):
        for d in range(path.shape[1]):
            trial[i, d] = min(max(path[i, d] + size * direction[i, d], lower[d]), upper[d])


@jit
def _kick(path, lower, upper):
    """Bend the free poses a little, in no direction that a symmetry would have."""
    last = path.shape[0] - 1
    for i in range(1, last):
        for d in range(path.shape[1]):
            bend = KICK * math.sin(math.pi * i / last) * math.cos(1.0 + d * d)
            path[i, d] = min(max(path[i, d] + bend, lower[d]), upper[d])


@jit
def minimise(tree, path, substeps, lower, upper, max_iter, tol):
    """Lower the energy of the path in place, its ends fixed, the poses between within bounds.

    The energy is that over `substeps` chords a step. Returns the norm of its gradient (of what the bounds leave of it),
    the number of iterations, and whether it converged.
    """
    n_nodes, n_dofs = path.shape
    n_samples = (n_nodes - 1) * substeps + 1
    scratch = np.empty(workspace_rows(tree))
    # The samples of the path, of a trial, and of a second one.
    P, screws = np.empty((3, n_samples, 3 * tree.offset.shape[0])), np.empty((3, n_samples, 6, n_dofs))
    now, other, spare = 0, 1, 2
    half = evaluate(tree, path, substeps, scratch, P[now], screws[now])
    if n_nodes < 3:
        return 0.0, 0, True
    diagonal, beside = np.empty((n_nodes, n_dofs, n_dofs)), np.empty((n_nodes - 1, n_dofs, n_dofs))
    band = np.empty(band_shape(tree, n_nodes))
    gradient, held = np.empty(path.shape), np.zeros(path.shape, np.bool_)
    step, last_step, direction = np.zeros(path.shape), np.zeros(path.shape), np.zeros(path.shape)
    trial, second = path.copy(), path.copy()
    scale, damping = 0.0, 0.0
    last_slope = 0.0  # along the step before; nought where the conjugate directions begin anew
    exact, n_kicks = False, 0
    norm = math.inf
    for iteration in range(max_iter):
        normal_equations(tree, substeps, P[now], screws[now], diagonal, beside, gradient)
        if exact:
            add_curvature(tree, substeps, P[now], screws[now], diagonal, beside)
        if _hold(path, lower, upper, gradient, held):
            last_slope = 0.0
        norm = 2.0 * math.sqrt(_dot(gradient, gradient))
        if iteration == 0:
            for i in range(1, n_nodes - 1):
                scale += np.trace(diagonal[i]) / ((n_nodes - 2) * n_dofs)
            damping = DAMPING[0] * scale
            if scale <= _noise(tree) ** 2:  # nothing moves
                return norm, iteration, True
        done, predicted, slope = norm <= tol, 0.0, 0.0
        if not done:
            shift = damping  # or what more it takes to make the exact Hessian positive definite
            while shift < HOPELESS * scale and not solve(tree, diagonal, beside, gradient, shift, held, band, step):
                shift = max(10.0 * shift, DAMPING[0] * scale)
            if not shift < HOPELESS * scale:
                return norm, iteration, False
            slope = -_dot(gradient, step)
            predicted = 0.5 * (shift * _dot(step, step) + slope)
            done = predicted <= ROUNDING * half
            if done and shift > scale:  # it is the damping that leaves no step
                return norm, iteration, False
        if done:
            if not exact:
                add_curvature(tree, substeps, P[now], screws[now], diagonal, beside)
            if n_kicks == MAX_KICKS or solve(tree, diagonal, beside, gradient, FLAT * scale, held, band, direction):
                return norm, iteration, True
            # A saddle, such as the swing of an arm stretched in a plane: leave it, as it is no shortest way.
            n_kicks += 1
            _kick(path, lower, upper)
            half = evaluate(tree, path, substeps, scratch, P[now], screws[now])
            last_slope, damping = 0.0, DAMPING[0] * scale
            continue
        turn = 0.0
        if last_slope > 0.0:
            turn = min(max((slope + _dot(gradient, last_step)) / last_slope, 0.0), 2.0)
        _combine(step, turn, direction)
        if _dot(gradient, direction) >= 0.0:
            _combine(step, 0.0, direction)
        _move(path, direction, 1.0, lower, upper, trial)
        lowest = evaluate(tree, trial, substeps, scratch, P[other], screws[other])
        # The parabola through energy, slope and trial is least at this multiple of the direction.
        fall = -_dot(gradient, direction)
        bend = 2.0 * (lowest - half + fall)
        multiple = fall / bend if bend > 0.0 else 1.0
        if abs(multiple - 1.0) > 0.1 and multiple < 4.0:
            _move(path, direction, multiple, lower, upper, second)
            again = evaluate(tree, second, substeps, scratch, P[spare], screws[spare])
            if again < lowest:
                lowest = again
                trial, second = second, trial
                other, spare = spare, other
        ratio = (half - lowest) / predicted
        if ratio > LEAST_RATIO:
            exact = substeps > 1 and half - lowest < NEAR * half
            _move(trial, step, 0.0, lower, upper, path)
            now, other = other, now
            half = lowest
            step, last_step = last_step, step
            last_slope = slope if ratio > 0.25 and not exact else 0.0
        else:
            last_slope = 0.0
        if ratio > 0.75:
            damping = max(0.1 * damping, DAMPING[1] * scale)
        elif ratio < 0.25:
            damping *= 4.0
        if substeps == 1 and iteration % PATIENCE == PATIENCE - 1 and _gap(tree, path) > LOST * GAP:
            return norm, iteration + 1, False
    return norm, max_iter, False


# --- from pose to pose -----------------------------------------------------------------------------------------------


@jit
def find_geodesic(start, end, lower, upper, tree, n_steps, max_iter, tol):
    """A path of least energy from start to end, angles in the tree's order, that is as long as it says.

    Returns the path with all its samples, its energy, length and length on the fine grid, the norm of the energy's
    gradient in the free poses, the number of iterations and whether it converged. Where nothing honest was found that
    is no longer than the straight line, the path is that line, unconverged.
    """
    line = np.empty((2, start.shape[0]))
    line[0], line[1] = start, end
    path = divided(line, n_steps)
    noise, straight = _noise(tree), chords(tree, path)[0]
    n_iter = 0
    for factor, substeps in REFINEMENTS:
        if substeps > 1:
            path = divided(line, n_steps) if factor == 1 else divided(path, 2)
        norm, iterations, converged = minimise(tree, path, substeps, lower, upper, max_iter, tol)
        n_iter += iterations
        samples = divided(path, substeps)
        length, energy = chords(tree, samples)
        along = curve_length(tree, samples)
        if along - length <= GAP * along + noise and (
            along <= straight or along <= curve_length(tree, divided(line, samples.shape[0] - 1)) + noise
        ):
            return samples, energy, length, along, norm, n_iter, converged
    path = divided(line, n_steps)
    length, energy = chords(tree, path)
    return path, energy, length, curve_length(tree, path), math.nan, n_iter, False


@jit
def measure_geodesic(x, Y, first, last, tree, steps, scratch, results):
    """Length of the geodesic, eq. 3; where chord and straight line agree already, that of the line.

    Sets the gap of a geodesic that did not converge.
    """
    measure_line(x, Y, first, last, tree, steps, scratch, results)
    n, n_codes = tree.column.shape[0], x.shape[0]
    width, n_groups = Y.size // Y.shape[0], results.distances.shape[0]
    codes, distances = Y.reshape((Y.shape[0], width)), results.distances.reshape((n_groups, width))
    skip, gaps = results.skip.reshape((n_groups, width)), results.gap.reshape((n_groups, width))
    free, noise = np.full(n, math.inf), _noise(tree)
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
            ahead = 0  # 1 or -1 as the first angle that differs does; both directions are to give the same number
            for d in range(n):
                gap = code[d, w] - x[d]
                if ahead == 0 and gap != 0.0:
                    ahead = 1 if gap > 0.0 else -1
                gap -= turns_off(gap, steps) * TWO_PI
                start[d] = x[d] if ahead >= 0 else code[d, w]
                end[d] = start[d] + gap * ahead
            _, _, length, along, _, _, converged = find_geodesic(
                start, end, -free, free, tree, steps.n_steps, MAX_ITER, TOL
            )
            distances[group, w] = max(chord, min(length, line))
            if not converged:
                gaps[group, w] = max((along - length) / along, ROUNDING)
