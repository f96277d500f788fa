"""The intrinsic mean: the pose at which the logarithms of the other poses cancel."""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from skpose._compiled.mean import Geodesics, geodesics_from
from skpose._compiled.tree import TWO_PI, Tree
from skpose._parallel.threads import in_threads

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
    step: np.ndarray  # (n_dofs,) the mean logarithm, as a change of the angles, rad
    norm: float  # its length, m
    converged: bool  # whether all geodesics converged


def spread_from(
    poses: np.ndarray,
    weights: np.ndarray,
    tree: Tree,
    metric_tensor_at: Callable[[np.ndarray], np.ndarray],
    n_steps: int,
    wrap: bool,
    n_jobs: int,
    pose: np.ndarray,
) -> Spread:
    """Compute the geodesics from a pose to all others, and their mean logarithm."""
    n = len(poses)
    found = Geodesics(np.empty(n), np.empty(n), np.empty(poses.shape), np.empty(n, dtype=bool))
    ends = poses - TWO_PI * np.rint((poses - pose) / TWO_PI) if wrap else poses
    in_threads(
        (partial(geodesics_from, tree, pose, ends, i, min(i + TASK, n), n_steps, found) for i in range(0, n, TASK)),
        n_jobs,
    )
    step, norm = _mean_logarithm(metric_tensor_at(pose), weights @ found.gradients)
    return Spread(pose, weights @ found.energies, weights @ found.lengths**2, step, norm, bool(found.converged.all()))


def _mean_logarithm(tensor: np.ndarray, gradient: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the mean logarithm as a step in angle space, and its length, m; zero along what moves no joint."""
    values, vectors = np.linalg.eigh(tensor)
    moving = values > FLAT * values[-1]
    along = gradient @ vectors[:, moving]
    # Damped: otherwise an angle that moves joints very little would change much, and lead to other geodesics.
    step = -vectors[:, moving] @ (along / (values[moving] + DAMPING * values[-1]))
    return step, float(np.sqrt((along**2 / values[moving]).sum()))


def karcher_mean(
    pose: np.ndarray, spread_at: Callable[[np.ndarray], Spread], max_iter: int, tol: float
) -> tuple[Spread, int, bool]:
    """Follow the mean logarithm from a pose on; return the last spread, the iterations and whether it converged."""
    here = spread_at(pose)
    falling = True  # the energy, until a path that is refined at one pose and not at the next makes it rise
    for iteration in range(max_iter):
        if here.norm <= tol * np.sqrt(here.variance):
            return here, iteration, here.converged
        step = here.step
        for _ in range(HALVINGS):
            trial = spread_at(here.pose + step)
            falling = falling and trial.energy < here.energy
            if falling or trial.norm < here.norm:
                break
            step = 0.5 * step
        else:
            return here, iteration, here.converged and here.norm <= KINK * np.sqrt(here.variance)
        here = trial
    return here, max_iter, False
