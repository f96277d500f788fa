"""The pose nearest to given positions of the joints."""

import numpy as np

from skpose._compiled.path.energy import Path
from skpose._compiled.path.geodesic import NEVER
from skpose._compiled.path.minimiser import Outcome, Settings, Stop, minimise, no_bounds
from skpose._compiled.pose.chart import chart_at, pose_of
from skpose._compiled.simd.jit import jit
from skpose._compiled.simd.lanes import copy_to


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
