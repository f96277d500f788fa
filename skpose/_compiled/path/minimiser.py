"""Newton's method in a trust region, for paths whose two ends are fixed.

The step is a Gauss-Newton step: the normal equations of the energy's residuals are block tridiagonal in the poses. They
are damped by a multiple λ of the identity, since JᵀJ is singular (a twist of the last bone moves nothing). λ follows
the ratio of actual to predicted decrease, as the radius of a trust region does.

The terms that Gauss-Newton leaves out make its steps too short, always by much the same factor near the end. So steps
are combined as in conjugate gradients, with the damped normal equations as the preconditioner, and their length is at
the minimum of the parabola through energy, slope and trial. Where almost nothing is left to gain, the exact Hessian
says whether that is true.

Where the gradient is zero but the curvature is negative in some direction, the path is at a saddle: it is perturbed.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.block_cholesky import Factors, factorise, factors_for, solve
from skpose._compiled.path.energy import (
    PATH,
    Samples,
    chords,
    copy_free,
    copy_of,
    curve_length,
    evaluate,
    samples_for,
)
from skpose._compiled.path.normal_equations import (
    NormalEquations,
    equations_for,
    mean_diagonal,
    normal_equations,
)
from skpose._compiled.pose.forward import size_of
from skpose._compiled.pose.signatures import TREE
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.signatures import FLAG, INTEGER, REAL, VECTOR, tuple_type

# λ is relative to the mean diagonal of the normal equations.
FIRST_DAMPING, LEAST_DAMPING, MAX_DAMPING = 1e-6, 1e-8, 1e6
# Where some energy may be left, λ is at least so many times that share of it: smaller, steps go far along directions
# in which almost no joint moves, and fail.
DAMPING_OVER_GAIN = 10.0
LEAST_CHANGE = 0.1  # of a step's length that is worth a second trial, relative
LONGEST = 4.0  # step that is tried, in steps of the quadratic model
LEAST_RATIO = 1e-4  # of actual to predicted decrease, for a step to be taken
ROUNDING = 1e-14  # relative to the energy or to the sum of the bones, what float64 cannot show
MAX_GAP = 5e-3  # relative difference of a path's two lengths within which it passes the discretisation check
DIVERGED = 4.0  # a path is given up whose gap is so many times larger
FLAT = 1e-4  # curvature below which the energy counts as flat, relative to the mean diagonal of the normal equations
PERTURBATION, MAX_PERTURBATIONS = 1e-2, 2  # of a path that has stopped at a saddle, rad; how many


class Bounds(NamedTuple):
    """The range of every angle, in the tree's order, rad; ±inf if it is free."""

    lower: np.ndarray  # (n_dofs,)
    upper: np.ndarray  # (n_dofs,)


class Stop(NamedTuple):
    """The end of the search for a minimum: one of these is reached."""

    max_iter: int
    gradient_norm: float  # of the energy, m²/rad
    gain: float  # relative decrease of the energy that the quadratic model, the exact one, has left


class Settings(NamedTuple):
    """Settings of the search for a minimum."""

    stop: Stop
    # Whether the Hessian is exact throughout, and not only where almost no energy is left. Then steps are tried once,
    # with little damping at first; a poor step multiplies the damping that was used, not the one before it was raised.
    exact: bool
    patience: int  # a path is checked for divergence every so many iterations


class Outcome(NamedTuple):
    """The end of the search for a minimum."""

    gradient_norm: float  # of the energy, of the part that the bounds leave, m²/rad
    gain: float  # relative decrease of the energy that the quadratic model has left
    n_iter: int
    converged: bool


BOUNDS, STOP = tuple_type(Bounds, VECTOR, VECTOR), tuple_type(Stop, INTEGER, REAL, REAL)
SETTINGS = tuple_type(Settings, STOP, FLAG, INTEGER)
OUTCOME = tuple_type(Outcome, REAL, REAL, INTEGER, FLAG)


class System(NamedTuple):
    """The equations of a step, and arrays to solve them in."""

    equations: NormalEquations
    fixed: np.ndarray  # (n_nodes, n_dofs) bool: dofs at an active bound
    factors: Factors
    samples: Samples


@internal
def no_bounds(n_dofs):
    """Bounds that leave all angles free."""
    return Bounds(np.full(n_dofs, -math.inf), np.full(n_dofs, math.inf))


@internal
def _dot(a, b):
    total = 0.0
    for i in range(a.shape[0]):
        for d in range(a.shape[1]):
            total += a[i, d] * b[i, d]
    return total


@internal
def _system_for(tree, path):
    """The system of a path, not yet filled, no dof fixed."""
    fixed, factors = np.zeros(path.poses.shape, np.bool_), factors_for(tree, path.poses.shape[0])
    return System(equations_for(tree, path), fixed, factors, samples_for(tree, path))


@internal
def _fix_at_bounds(path, bounds, system):
    """Fix the dofs at a bound that the gradient pushes against; return whether these are others than before.

    Fixed dofs, and the ends, get no gradient.
    """
    changed, gradient, fixed = False, system.equations.gradient, system.fixed
    gradient[0], gradient[-1] = 0.0, 0.0
    for i in range(1, gradient.shape[0] - 1):
        for d in range(gradient.shape[1]):
            angle, slope = path.poses[i, d], gradient[i, d]
            active = (angle <= bounds.lower[d] and slope > 0.0) or (angle >= bounds.upper[d] and slope < 0.0)
            changed = changed or active != fixed[i, d]
            fixed[i, d] = active
            if active:
                gradient[i, d] = 0.0
    return changed


@internal
def _damped_step(tree, system, damping, scale, step):
    """Compute the step with this damping, or with the next larger one that makes the matrix positive definite.

    The result is that damping, or inf if it would be hopelessly large.
    """
    while damping < MAX_DAMPING * scale:
        if factorise(tree, system.equations, damping, system.fixed, system.factors):
            solve(system.equations, system.factors, step)
            return damping
        damping = max(10.0 * damping, FIRST_DAMPING * scale)
    return math.inf


@internal
def _add_multiple(step, beta, direction):
    """Set the direction to step + β · direction."""
    for i in range(step.shape[0]):
        for d in range(step.shape[1]):
            direction[i, d] = step[i, d] + beta * direction[i, d]


@internal
def _combine(step, last_slope, last_step, slope, gradient, direction):
    """Update the direction by conjugate gradients (Polak-Ribière): step + β · direction, downhill.

    The last slope is zero where the directions start anew.
    """
    beta = 0.0
    if last_slope > 0.0:
        beta = min(max((slope + _dot(gradient, last_step)) / last_slope, 0.0), 2.0)
    _add_multiple(step, beta, direction)
    if _dot(gradient, direction) >= 0.0:
        _add_multiple(step, 0.0, direction)


@internal
def _try(tree, path, direction, size, bounds, trial, samples):
    """Move the free poses along a direction, within the bounds, to another path; return half its energy."""
    for i in range(1, path.poses.shape[0] - 1):
        for d in range(path.poses.shape[1]):
            angle = path.poses[i, d] + size * direction[i, d]
            trial.poses[i, d] = min(max(angle, bounds.lower[d]), bounds.upper[d])
    return evaluate(tree, trial, samples)


@internal
def _line_search(tree, path, direction, half, descent, least_change, bounds, first, second, samples):
    """Try the whole direction, then the minimum of the parabola through energy, slope and the first trial.

    The better of the two is left in the first path; returns half its energy. The path has half the energy given, which
    falls along the direction by the descent; a smaller relative change of its length is not worth a second trial.
    """
    lowest = _try(tree, path, direction, 1.0, bounds, first, samples)
    curvature = 2.0 * (lowest - half + descent)
    size = descent / curvature if curvature * LONGEST > descent else LONGEST
    while abs(size - 1.0) > least_change:
        again = _try(tree, path, direction, size, bounds, second, samples)
        if again < lowest:
            copy_free(second, first)
            return again
        if size < LONGEST:
            break
        size = math.sqrt(size)
    return lowest


@internal
def _is_minimum(tree, path, exact, scale, system):
    """Whether the curvature of the energy is positive, or flat, in all directions."""
    if not exact:
        normal_equations(tree, path, True, system.samples, system.equations)
    return factorise(tree, system.equations, FLAT * scale, system.fixed, system.factors)


@internal
def _perturb(path, bounds):
    """Move the free poses a little, in no direction that a symmetry would have."""
    last = path.poses.shape[0] - 1
    for i in range(1, last):
        for d in range(path.poses.shape[1]):
            change = PERTURBATION * math.sin(math.pi * i / last) * math.cos(1.0 + d * d)
            path.poses[i, d] = min(max(path.poses[i, d] + change, bounds.lower[d]), bounds.upper[d])


@internal
def _predict(system, damping, step):
    """The decrease by the quadratic model for a damped step, and minus the slope along it."""
    slope = -_dot(system.equations.gradient, step)
    return 0.5 * (damping * _dot(step, step) + slope), slope


@by_address(lambda: OUTCOME(TREE, PATH, BOUNDS, SETTINGS))
def minimise(tree, path, bounds, settings):
    """Minimise the energy of a path in place: its ends are fixed and placed already, its free poses within bounds."""
    shape = path.poses.shape
    system, trial, second, stop = _system_for(tree, path), copy_of(path), copy_of(path), settings.stop
    gradient = system.equations.gradient
    step, last_step, direction = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    half, noise = evaluate(tree, path, system.samples), (ROUNDING * size_of(tree)) ** 2
    if shape[0] < 3:
        return Outcome(0.0, 0.0, 0, True)
    norm, predicted, n_perturbations = math.inf, 0.0, 0
    last_slope = 0.0  # along the step before; zero where the conjugate directions start anew
    verified = False  # that almost no energy is left, by the exact model with the least damping
    exact, first_damping = settings.exact, LEAST_DAMPING if settings.exact else FIRST_DAMPING
    least_change = math.inf if settings.exact else LEAST_CHANGE
    least_gain, least_damping = max(ROUNDING, stop.gain), max(LEAST_DAMPING, DAMPING_OVER_GAIN * stop.gain)
    normal_equations(tree, path, False, system.samples, system.equations)
    scale = mean_diagonal(system.equations)
    damping = max(first_damping, least_damping) * scale
    for iteration in range(stop.max_iter):
        if exact or iteration > 0:
            normal_equations(tree, path, exact, system.samples, system.equations)
        if _fix_at_bounds(path, bounds, system):
            last_slope = 0.0
        norm = 2.0 * math.sqrt(_dot(gradient, gradient))
        if scale <= noise or half <= noise:  # nothing moves
            return Outcome(norm, 0.0, iteration, True)
        stationary, used, predicted, slope = norm <= stop.gradient_norm, math.inf, 0.0, 0.0
        if not stationary:
            used = _damped_step(tree, system, damping, scale, step)
            predicted, slope = _predict(system, used, step)
            if ROUNDING * half < predicted <= least_gain * half and not verified:
                if not exact:
                    normal_equations(tree, path, True, system.samples, system.equations)
                    _fix_at_bounds(path, bounds, system)
                verified, exact, last_slope, damping = True, True, 0.0, LEAST_DAMPING * scale
                used = _damped_step(tree, system, damping, scale, step)
                predicted, slope = _predict(system, used, step)
            stationary = predicted <= least_gain * half
            # Where the damping alone leaves no step.
            if used == math.inf or (predicted <= ROUNDING * half and damping > scale):
                return Outcome(norm, math.inf, iteration, False)
        if stationary:  # a minimum or a saddle
            is_known = exact and used <= FLAT * scale  # from the Hessian's factors
            if is_known or n_perturbations == MAX_PERTURBATIONS or _is_minimum(tree, path, exact, scale, system):
                return Outcome(norm, predicted / half if half > 0.0 else 0.0, iteration, True)
            n_perturbations += 1
            _perturb(path, bounds)
            half = evaluate(tree, path, system.samples)
            last_slope, damping = 0.0, max(first_damping, least_damping) * scale
            continue
        _combine(step, last_slope, last_step, slope, gradient, direction)
        descent = -_dot(gradient, direction)
        lowest = _line_search(tree, path, direction, half, descent, least_change, bounds, trial, second, system.samples)
        ratio = (half - lowest) / predicted
        if ratio > LEAST_RATIO:
            exact, verified = settings.exact, half - lowest <= least_gain * half
            copy_free(trial, path)
            half = lowest
            step, last_step = last_step, step
        last_slope = slope if ratio > 0.25 and not exact else 0.0
        raised = 4.0 * (used if settings.exact else damping)
        if ratio > 0.75:
            damping = max(0.1 * damping, least_damping * scale)
        elif ratio < 0.25:
            damping = raised
        if iteration % settings.patience == settings.patience - 1:
            along = curve_length(tree, path.poses)
            if along > 0.0 and (along - chords(tree, path.poses)[0]) / along > DIVERGED * MAX_GAP:
                return Outcome(norm, math.inf, iteration + 1, False)
    return Outcome(norm, predicted / half, stop.max_iter, False)
