"""The pose nearest to given positions of the joints, and the geodesics from a pose to others."""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.chart import chart_at, free_tree, pose_of, slopes_of_turns
from skpose._compiled.forward import workspace_rows
from skpose._compiled.geodesic import MAX_ITER, NEVER, SUBSTEPS, TOL, find_geodesic, shorter_line
from skpose._compiled.jit import internal, jit
from skpose._compiled.minimiser import LEAST_DAMPING, Outcome, Settings, minimise, unbounded
from skpose._compiled.path_energy import add_gradient, empty_path, place, sum_moments


class Geodesics(NamedTuple):
    """Geodesics from one pose to n others."""

    energies: np.ndarray  # (n,) times the number of chords, which makes them squares of lengths, m²
    lengths: np.ndarray  # (n,) m
    gradients: np.ndarray  # (n, n_dofs) of half that energy by the one pose's coordinates, m²/rad
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
    free, coordinates = chart_at(tree, pose, True)
    path = empty_path(free, 3, 2)
    path.poses[:] = coordinates
    path.P[:] = target
    settings = Settings(max_iter, 2.0 * tol, LEAST_DAMPING, math.inf, math.inf, True, NEVER)
    outcome = minimise(free, path, unbounded(pose.shape[0]), settings)
    found = pose_of(tree, free, path.poses[1], pose)
    return found, Outcome(0.5 * outcome.gradient_norm, outcome.n_iter, outcome.converged)


@internal
def record(free, curve, n_steps, scratch, i, found):
    """Write energy, length and gradient of the geodesic to pose i, a curve in the coordinates of the free tree."""
    n_dofs = curve.poses.shape[1]
    moments, gradient = np.empty((free.frame_parent.shape[0], 12)), np.zeros((2, n_dofs))
    start = empty_path(free, 2, SUBSTEPS)  # the samples that move with the first pose
    n_chords = curve.poses.shape[0] - 1
    substeps = 1 if n_chords == n_steps else SUBSTEPS
    for k in range(substeps + 1):
        place(free, curve.poses[k], scratch, start.P[k], start.screws[k])
    for k in range(substeps):
        sum_moments(free, start.P[max(k - 1, 0)], start.P[k], start.P[k + 1], moments)
        add_gradient(free, start.screws[k], moments, k / substeps, gradient)
    slopes_of_turns(free, curve.poses[0], gradient[0])
    found.energies[i] = n_chords * curve.energy
    found.lengths[i] = curve.length
    for d in range(n_dofs):
        found.gradients[i, d] = n_chords * gradient[0, d]
    found.converged[i] = curve.converged


@jit
def geodesics_from(tree, pose, ends, first, last, n_steps, frees_angles, found):
    """Compute the geodesics from a pose to the ends first:last, the difference of angles wrapped already."""
    free, bounds, scratch = free_tree(tree, frees_angles), unbounded(pose.shape[0]), np.empty(workspace_rows(tree))
    for i in range(first, last):
        line, _ = shorter_line(tree, free, pose, ends[i], n_steps)
        record(free, find_geodesic(free, line, bounds, MAX_ITER, TOL), n_steps, scratch, i, found)
