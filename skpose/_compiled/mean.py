"""The pose nearest to given positions of the joints, and the ways from a pose to others: compiled."""

import math

import numpy as np

from skpose._compiled.block_cholesky import band_shape, solve
from skpose._compiled.forward import workspace_rows
from skpose._compiled.jit import jit
from skpose._compiled.minimiser import (
    DAMPING,
    FLAT,
    HOPELESS,
    KICK,
    LEAST_RATIO,
    MAX_ITER,
    MAX_KICKS,
    ROUNDING,
    SUBSTEPS,
    TOL,
    find_geodesic,
)
from skpose._compiled.path_energy import add_curvature, add_gradient, normal_equations, place, sum_moments
from skpose._compiled.tree import TWO_PI


@jit
def place_all(tree, poses, positions):
    """Joint positions of poses, angles and joints in the tree's order, the root first: (n_poses, 3 n_joints + 3)."""
    scratch, screws = np.empty(workspace_rows(tree)), np.empty((6, poses.shape[1]))
    for i in range(poses.shape[0]):
        place(tree, poses[i], scratch, positions[i], screws)


@jit
def _error(positions, target):
    total = 0.0
    for k in range(3, target.shape[0]):
        total += (positions[k] - target[k]) ** 2
    return total


@jit
def approach(tree, target, pose, max_iter, tol):
    """Lower ‖F(θ) − target‖² in place, by Newton's method in a trust region.

    This is half the energy of a path of two chords whose ends are both at the target, so that gradient and Hessian are
    the middle blocks of such a path's. Returns the norm of the gradient, the number of iterations and whether it
    converged.
    """
    n_dofs = pose.shape[0]
    scratch, band = np.empty(workspace_rows(tree)), np.empty(band_shape(tree, 3))
    P, screws = np.empty((3, target.shape[0])), np.zeros((3, 6, n_dofs))
    trial_P, trial_screws = np.empty(target.shape[0]), np.empty((6, n_dofs))
    diagonal, beside = np.empty((3, n_dofs, n_dofs)), np.empty((2, n_dofs, n_dofs))
    gradient, step, held = np.empty((3, n_dofs)), np.zeros((3, n_dofs)), np.zeros((3, n_dofs), np.bool_)
    P[0], P[2] = target, target
    place(tree, pose, scratch, P[1], screws[1])
    error, norm, scale, damping, n_kicks = _error(P[1], target), math.inf, 0.0, 0.0, 0
    for iteration in range(max_iter):
        normal_equations(tree, 1, P, screws, diagonal, beside, gradient)
        norm = math.sqrt(np.sum(gradient[1] ** 2))
        if iteration == 0:
            scale = np.trace(diagonal[1]) / n_dofs
            damping = DAMPING[1] * scale
            if scale == 0.0:  # nothing moves
                return norm, iteration, True
        add_curvature(tree, 1, P, screws, diagonal, beside)
        shift = damping
        while shift < HOPELESS * scale and not solve(tree, diagonal, beside, gradient, shift, held, band, step):
            shift = max(10.0 * shift, DAMPING[0] * scale)
        if not shift < HOPELESS * scale:
            return norm, iteration, False
        predicted = 0.5 * (shift * np.sum(step[1] ** 2) - np.sum(gradient[1] * step[1]))
        if norm <= tol or predicted <= ROUNDING * error:
            if n_kicks == MAX_KICKS or solve(tree, diagonal, beside, gradient, FLAT * scale, held, band, step):
                return norm, iteration, True
            # A saddle, as of a mean between two opposite poses: leave it.
            n_kicks += 1
            for d in range(n_dofs):
                pose[d] += KICK * math.cos(1.0 + d * d)
            place(tree, pose, scratch, P[1], screws[1])
            error = _error(P[1], target)
            continue
        place(tree, pose + step[1], scratch, trial_P, trial_screws)
        lower = _error(trial_P, target)
        ratio = (error - lower) / predicted
        if ratio > LEAST_RATIO:
            pose += step[1]
            P[1], screws[1], error = trial_P, trial_screws, lower
        if ratio > 0.75:
            damping = max(0.1 * damping, DAMPING[1] * scale)
        elif ratio < 0.25:
            damping = 4.0 * shift
    return norm, max_iter, False


@jit
def set_out(tree, pose, poses, first, last, n_steps, wrap, gradients, energies, lengths, converged):
    """The geodesics from one pose to others: energies, lengths, and how the energy changes with that pose.

    Energies are times the number of chords, which makes them squares of lengths; gradients are of half of that.
    """
    n_dofs = pose.shape[0]
    free, end = np.full(n_dofs, math.inf), np.empty(n_dofs)
    scratch, moments = np.empty(workspace_rows(tree)), np.empty((tree.frame_parent.shape[0], 12))
    P, screws = np.empty((SUBSTEPS + 1, 3 * tree.offset.shape[0])), np.empty((SUBSTEPS + 1, 6, n_dofs))
    gradient = np.empty((2, n_dofs))
    for i in range(first, last):
        for d in range(n_dofs):
            gap = poses[i, d] - pose[d]
            end[d] = poses[i, d] - (TWO_PI * np.rint(gap / TWO_PI) if wrap else 0.0)
        path, energy, lengths[i], _, _, _, converged[i] = find_geodesic(
            pose, end, -free, free, tree, n_steps, MAX_ITER, TOL
        )
        n_chords = path.shape[0] - 1
        substeps = 1 if n_chords == n_steps else SUBSTEPS
        energies[i] = n_chords * energy
        gradient[:] = 0.0
        for k in range(substeps + 1):
            place(tree, path[k], scratch, P[k], screws[k])
        for k in range(substeps):
            sum_moments(tree, P[max(k - 1, 0)], P[k], P[k + 1], moments)
            add_gradient(tree, screws[k], moments, k / substeps, gradient)
        for d in range(n_dofs):
            gradients[i, d] = n_chords * gradient[0, d]
