"""The pose nearest to given positions of the joints."""

import numpy as np

from skpose._compiled.path.energy import Path
from skpose._compiled.path.geodesic import NEVER
from skpose._compiled.path.minimiser import Outcome, Settings, Stop, minimise, no_bounds
from skpose._compiled.pose.chart import chart_at, pose_of
from skpose._compiled.pose.forward import place, workspace_rows
from skpose._compiled.simd.jit import jit
from skpose._compiled.simd.lanes import copy_to


@jit
def place_all(tree, poses, positions):
    """Compute the joint positions of poses, angles and joints in the tree's order: (n_poses, 3 n_joints + 3)."""
    scratch = np.empty(workspace_rows(tree))
    for i in range(poses.shape[0]):
        place(tree, poses[i], scratch, positions[i])


@jit
def project(tree, target, pose, max_iter, tol):
    """Find the pose nearest to given joint positions, a minimum of ‖F(θ) − target‖², from a first pose on.

    This is half the energy of a path of two chords with both ends at the target. The Hessian is exact throughout.
    Returns the pose and the outcome, with the gradient of ‖F(θ) − target‖².
    """
    free, coordinates = chart_at(tree, pose, True)
    poses, ends = np.empty((3, pose.shape[0])), np.empty((2, target.shape[0]))
    for i in range(3):
        copy_to(poses[i], coordinates)
    for i in range(2):
        copy_to(ends[i], target)
    path = Path(poses, ends, 1)
    settings = Settings(Stop(max_iter, 2.0 * tol, 0.0), True, NEVER)
    outcome = minimise(free, path, no_bounds(pose.shape[0]), settings)
    found = pose_of(tree, free, path.poses[1], pose)
    return found, Outcome(0.5 * outcome.gradient_norm, outcome.gain, outcome.n_iter, outcome.converged)
