"""The pose nearest to given positions of the joints, and the geodesics from a pose to others."""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.forward import workspace_rows
from skpose._compiled.geodesic import MAX_ITER, NEVER, SUBSTEPS, TOL, find_geodesic
from skpose._compiled.jit import jit
from skpose._compiled.minimiser import LEAST_DAMPING, Outcome, Settings, minimise, unbounded
from skpose._compiled.path_energy import add_gradient, empty_path, place, sum_moments


class Geodesics(NamedTuple):
    """Geodesics from one pose to n others."""

    energies: np.ndarray  # (n,) times the number of chords, which makes them squares of lengths, m²
    lengths: np.ndarray  # (n,) m
    gradients: np.ndarray  # (n, n_dofs) change of half that energy with the one pose, m²/rad
    converged: np.ndarray  # (n,) bool


@jit
def place_all(tree, poses, positions):
    """Compute the joint positions of poses, angles and joints in the tree's order: (n_poses, 3 n_joints + 3)."""
    scratch, screws = np.empty(workspace_rows(tree)), np.empty((6, poses.shape[1]))
    for i in range(poses.shape[0]):
        place(tree, poses[i], scratch, positions[i], screws)


@jit
def project(tree, target, pose, max_iter, tol):
    """Find the pose nearest to given joint positions, a minimum of ‖F(θ) − target‖², from a first pose on.

    This is half the energy of a path of two chords with both ends at the target. The Hessian is exact throughout.
    Returns the pose and the outcome, with the gradient of ‖F(θ) − target‖².
    """
    path = empty_path(tree, 3, 2)
    path.poses[:] = pose
    path.P[:] = target
    settings = Settings(max_iter, 2.0 * tol, LEAST_DAMPING, math.inf, math.inf, True, NEVER)
    outcome = minimise(tree, path, unbounded(pose.shape[0]), settings)
    return path.poses[1], Outcome(0.5 * outcome.gradient_norm, outcome.n_iter, outcome.converged)


@jit
def geodesics_from(tree, pose, ends, first, last, n_steps, found):
    """Compute the geodesics from a pose to the ends first:last, which are wrapped already."""
    n_dofs = pose.shape[0]
    bounds, scratch = unbounded(n_dofs), np.empty(workspace_rows(tree))
    moments, gradient = np.empty((tree.frame_parent.shape[0], 12)), np.empty((2, n_dofs))
    start = empty_path(tree, 2, SUBSTEPS)  # the samples that move with the pose
    for i in range(first, last):
        curve = find_geodesic(tree, pose, ends[i], n_steps, bounds, MAX_ITER, TOL)
        n_chords = curve.poses.shape[0] - 1
        substeps = 1 if n_chords == n_steps else SUBSTEPS
        for k in range(substeps + 1):
            place(tree, curve.poses[k], scratch, start.P[k], start.screws[k])
        gradient[:] = 0.0
        for k in range(substeps):
            sum_moments(tree, start.P[max(k - 1, 0)], start.P[k], start.P[k + 1], moments)
            add_gradient(tree, start.screws[k], moments, k / substeps, gradient)
        found.energies[i] = n_chords * curve.energy
        found.lengths[i] = curve.length
        for d in range(n_dofs):
            found.gradients[i, d] = n_chords * gradient[0, d]
        found.converged[i] = curve.converged
