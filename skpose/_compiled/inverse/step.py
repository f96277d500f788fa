"""Inverse kinematics of one frame: the pose, and the position and orientation of the root, of least `energy`.

Gauss-Newton in a trust region. A step turns joints in their own axes (`retract`), and its matrix is factorised as a
whole (`equations`). Where positions cannot be reached the terms that Gauss-Newton leaves out are added, once
they count. Angles that the positions leave open are settled by the stiffness; without one, by the first step, which
goes a part of the way to θ₀ in them.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.inverse.energy import (
    N_ORIGIN,
    TARGET,
    WORKSPACE,
    add_second_derivatives_of_pose,
    copy_state,
    evaluate_pose,
    factorise,
    fill_gradient,
    fill_matrix,
    half_square_away,
    solve,
)
from skpose._compiled.pose.rotation import product, put_quaternion, quaternion_at, quaternion_of
from skpose._compiled.simd.jit import by_address, internal
from skpose._compiled.simd.signatures import FLAG, INTEGER, REAL, tuple_type

PRECISION = 1e-9  # steps that bring the joints less near than this do not count, m
NEGLIGIBLE = 1e-10  # decrease relative to the energy that is none, far below what noise makes of it
FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-10  # as all damping, relative to the mean diagonal of the matrix
RAISED_DAMPING, MAX_DAMPING = 2e-9, 1e6  # after a step that fails, at least and at most
CERTAIN = 1e-6  # damping up to which a short step means that the minimum is near
LEAST_RATIO = 1e-4  # of actual to predicted decrease, for a step to be taken
PULL, SHARE = 1e-5, 0.1  # ρ of the first step at least, m/rad; its share of the way to θ₀ in open angles
SLOW = 0.5  # relative decrease of the energy below which the exact Hessian takes over


class Fit(NamedTuple):
    """The end of the search for a pose."""

    half: float  # half the weighted sum of squared distances, with the regularisation, m²
    n_iter: int
    converged: bool


FIT = tuple_type(Fit, REAL, INTEGER, FLAG)


@internal
def _fix_at_bounds(state, target, equations):
    """Fix the dofs at a bound that the gradient pushes against."""
    for d in range(state.dofs.shape[0]):
        slope = equations.gradient[N_ORIGIN + d]
        low = state.dofs[d] <= target.lower[d] and slope > 0.0
        equations.fixed[N_ORIGIN + d] = low or (state.dofs[d] >= target.upper[d] and slope < 0.0)


@internal
def retract(tree, state, step, target, moved):
    """Move a state by a step: turn its ball joints in their own axes, add to angles within bounds, move the root."""
    for i in range(N_ORIGIN):
        moved.origin[i] = state.origin[i] + step[i]
    for f in range(1, tree.frame_parent.shape[0]):
        first, end = tree.first_dof[f], tree.end_dof[f]
        if tree.ball[f] >= 0:
            k = N_ORIGIN + first
            turn = quaternion_of(step[k], step[k + 1], step[k + 2])
            w, x, y, z = product(quaternion_at(state.rotations, f), turn)
            size = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
            put_quaternion((size * w, size * x, size * y, size * z), moved.rotations, f)
        else:
            for d in range(first, end):
                angle = state.dofs[d] + step[N_ORIGIN + d]
                moved.dofs[d] = min(max(angle, target.lower[d]), target.upper[d])


@by_address(lambda: FIT(WORKSPACE, TARGET, REAL, INTEGER))
def minimise_pose(work, target, first_damping, max_iter):
    """Find the minimum from the state `work.here` on, in place.

    The first step also goes a part of the way to θ₀ in angles that the positions leave open; the others do so only as
    far as the stiffness asks for.
    """
    tree, here, there, equations = work.tree, work.here, work.there, work.equations
    stiffness = max(target.stiffness, PULL * PULL)
    half = evaluate_pose(work, here, target, stiffness)
    scale, damping, exact = 0.0, 0.0, False
    for iteration in range(max_iter):
        if iteration == 1 and stiffness > target.stiffness:
            half -= (stiffness - target.stiffness) * half_square_away(tree, here, target)
            stiffness = target.stiffness
        fill_gradient(here, target, stiffness, work)
        fill_matrix(here, stiffness, work)
        if iteration == 0:
            scale = np.trace(equations.matrix) / equations.matrix.shape[0]
            damping = max(first_damping * scale, PULL * PULL / SHARE)
        _fix_at_bounds(here, target, equations)
        if exact:
            add_second_derivatives_of_pose(here, work)
        falling = True  # the energy, with this damping
        least = max(PRECISION * PRECISION, NEGLIGIBLE * half)
        while True:
            if not factorise(equations, damping):
                if exact:
                    exact = False
                    fill_matrix(here, stiffness, work)
                    continue
                return Fit(half, iteration, False)
            predicted = solve(equations, damping)
            certain = damping <= CERTAIN * scale
            if predicted <= least:
                if certain or not falling:
                    return Fit(half, iteration, certain)
                damping = CERTAIN * scale
                continue
            retract(tree, here, equations.step, target, there)
            reached = evaluate_pose(work, there, target, stiffness)
            ratio = (half - reached) / predicted
            if ratio > LEAST_RATIO:
                break
            damping, falling = max(4.0 * damping, RAISED_DAMPING * scale), False
            if damping > MAX_DAMPING * scale:
                return Fit(half, iteration, False)
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
