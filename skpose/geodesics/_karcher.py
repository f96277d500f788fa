"""The intrinsic mean: the pose at which the logarithms of the other poses cancel."""

from functools import partial
from typing import NamedTuple

import numpy as np

from skpose._compiled.chart import chart_at, pose_of
from skpose._compiled.jacobian import position_jacobians
from skpose._compiled.mean import Geodesics, geodesics_from
from skpose._compiled.tree import Tree
from skpose._parallel.threads import in_threads
from skpose.kinematics._tree import wrapped

TASK = 8  # geodesics; some tens of milliseconds
FLAT = 1e-6  # eigenvalue of the metric tensor, relative to the largest, below which a direction moves no joint
HALVINGS = 6  # of a step that does not bring the poses nearer
DAMPING = 1e-4  # of steps, relative to the largest eigenvalue of the metric tensor
KINK = 0.02  # length of the mean logarithm, relative to the standard deviation, where no step makes it shorter


class Spread(NamedTuple):
    """The poses as seen from one pose."""

    pose: np.ndarray  # (n_dofs,) rad
    energy: float  # mean energy of the geodesics, m²
    variance: float  # mean squared length, m²
    step: np.ndarray  # (n_dofs,) the mean logarithm, as a change of the pose's coordinates, rad
    norm: float  # its length, m
    unconverged: int  # geodesics that did not converge


class Poses(NamedTuple):
    """The poses of a mean, in the tree's order."""

    tree: Tree
    dofs: np.ndarray  # (n_poses, n_dofs)
    weights: np.ndarray  # (n_poses,) of sum 1
    n_steps: int
    wrap: bool
    n_jobs: int

    def spread_from(self, pose: np.ndarray) -> Spread:
        """Compute the geodesics from a pose to all poses, and their mean logarithm."""
        tree, n = self.tree, len(self.dofs)
        found = Geodesics(np.empty(n), np.empty(n), np.empty(self.dofs.shape), np.empty(n, dtype=bool))
        ends = wrapped(tree, self.dofs, pose[None]) if self.wrap else self.dofs
        in_threads(
            (
                partial(geodesics_from, tree, pose, ends, i, min(i + TASK, n), self.n_steps, self.wrap, found)
                for i in range(0, n, TASK)
            ),
            self.n_jobs,
        )
        free, coordinates = chart_at(tree, pose, self.wrap)
        jacobians = np.empty((1, 3 * len(tree.offset) - 3, len(pose)))
        position_jacobians(coordinates[None], free, jacobians)
        step, norm = _mean_logarithm(jacobians[0].T @ jacobians[0], self.weights @ found.gradients)
        variance = self.weights @ found.lengths**2
        return Spread(pose, self.weights @ found.energies, variance, step, norm, int((~found.converged).sum()))

    def moved(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a pose that is a step of its coordinates away from another one."""
        free, coordinates = chart_at(self.tree, pose, self.wrap)
        return pose_of(self.tree, free, coordinates + step, pose)


def _mean_logarithm(tensor: np.ndarray, gradient: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the mean logarithm as a step of coordinates, and its length, m; zero along what moves no joint."""
    values, vectors = np.linalg.eigh(tensor)
    moving = values > FLAT * values[-1]
    along = gradient @ vectors[:, moving]
    # Damped: otherwise a dof that moves joints very little would change much, and lead to other geodesics.
    step = -vectors[:, moving] @ (along / (values[moving] + DAMPING * values[-1]))
    return step, float(np.sqrt((along**2 / values[moving]).sum()))


def karcher_mean(poses: Poses, pose: np.ndarray, max_iter: int, tol: float) -> tuple[Spread, int, str]:
    """Follow the mean logarithm from a pose on; return the last spread, the iterations and why it did not converge.

    The reason, with its remedy, is empty if it converged.
    """
    here = poses.spread_from(pose)
    falling = True  # the energy, until a path that is refined at one pose and not at the next makes it rise
    for iteration in range(max_iter):
        if here.norm <= tol * np.sqrt(here.variance):
            return here, iteration, _unconverged(here, len(poses.dofs))
        step = here.step
        for _ in range(HALVINGS):
            trial = poses.spread_from(poses.moved(here.pose, step))
            falling = falling and trial.energy < here.energy
            if falling or trial.norm < here.norm:
                break
            step = 0.5 * step
        else:
            if here.norm <= KINK * np.sqrt(here.variance):
                return here, iteration, _unconverged(here, len(poses.dofs))
            return (
                here,
                iteration,
                (
                    f"after {iteration} iterations no step brought the poses nearer, as from some poses to others the "
                    "geodesics jump; a larger n_steps may help, a larger max_iter does not"
                ),
            )
        here = trial
    return here, max_iter, f"it was still moving after max_iter={max_iter} iterations; raise max_iter"


def _unconverged(here: Spread, n_poses: int) -> str:
    """Return the reason not to trust a mean that has been reached: geodesics that did not converge."""
    if not here.unconverged:
        return ""
    return (
        f"{here.unconverged} of the geodesics from it to the {n_poses} poses did not converge; a larger n_steps may "
        "help, a larger max_iter does not"
    )
