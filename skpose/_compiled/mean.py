"""The pose nearest to given positions of the joints."""

import math

import numpy as np

from skpose._compiled.chart import chart_at, pose_of
from skpose._compiled.copying import copy_to
from skpose._compiled.forward import workspace_rows
from skpose._compiled.geodesic import NEVER
from skpose._compiled.jit import jit
from skpose._compiled.minimiser import LEAST_DAMPING, Outcome, Settings, Stop, minimise, unbounded
from skpose._compiled.path_energy import empty_path, place


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
    for i in range(3):
        copy_to(path.poses[i], coordinates)
        copy_to(path.P[i], target)
    settings = Settings(Stop(max_iter, 2.0 * tol, 0.0), LEAST_DAMPING, math.inf, math.inf, True, NEVER)
    outcome = minimise(free, path, unbounded(pose.shape[0]), settings)
    found = pose_of(tree, free, path.poses[1], pose)
    return found, Outcome(0.5 * outcome.gradient_norm, outcome.gain, outcome.n_iter, outcome.converged)
