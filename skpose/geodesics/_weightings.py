"""Means of many weightings of one set of poses, under every metric, with or without a skeleton."""

from collections.abc import Callable
from functools import partial

import numpy as np
from joblib import effective_n_jobs

from skpose._parallel.threads import in_threads
from skpose.geodesics._descent import MEAN, descend
from skpose.geodesics._extrinsic import ExtrinsicMeans
from skpose.geodesics._given import Given
from skpose.geodesics._views import AnglePoses
from skpose.skeleton import Skeleton

TASK = 16  # means; some milliseconds
MAX_ITER, TOL, FEWEST_STEPS = 200, 1e-3, 2  # as `frechet_mean`
# Norm of the gradient at which an extrinsic mean has converged, m²/rad: less exact than `frechet_mean`, which goes on
# for many iterations where an angle moves joints very little.
TOL_EXTRINSIC = 1e-6


class WeightedMeans:
    """Poses, and the Fréchet means of any weightings of them.

    Parameters
    ----------
    poses : ndarray of shape (n_poses, n_dofs)
        Poses that are checked already, rad.
    skeleton : Skeleton or None
        None with "angle" alone.
    metric : str
        The metric.
    parameters : dict
        Its `n_steps` and `wrap`, where it has them.
    n_jobs : int or None
        Threads.
    """

    def __init__(self, poses: np.ndarray, skeleton: Skeleton | None, metric: str, parameters: dict, n_jobs: int | None):
        self.poses = poses.astype(np.float64, copy=False)
        self.skeleton, self.metric, self.parameters, self.n_jobs = skeleton, metric, parameters, n_jobs
        self._find: Callable[[np.ndarray], tuple[np.ndarray, bool]]
        self._n_threads = 1  # one mean after the other, each on all threads
        if skeleton is None or metric == "angle":
            self._find = self._mean_of_wrapped if parameters["wrap"] else self._mean_of_columns
        elif metric == "position":
            self._find = partial(_extrinsic_mean, ExtrinsicMeans.of(self.poses, skeleton))
            self._n_threads = effective_n_jobs(n_jobs)
        else:
            self._find = partial(self._descended, skeleton)

    def means(self, weightings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the means (n_means, n_dofs) under weightings (n_means, n_poses), and whether each one converged.

        Weights are not negative, and the sum of each row is positive.
        """
        means = np.empty((len(weightings), self.poses.shape[1]))
        converged = np.ones(len(weightings), dtype=bool)

        def find_some(start: int) -> None:
            for i in range(start, min(start + TASK, len(weightings))):
                counted = np.flatnonzero(weightings[i])
                if len(counted) == 1:
                    means[i] = self.poses[counted[0]]
                else:
                    means[i], converged[i] = self._find(weightings[i])

        in_threads((partial(find_some, start) for start in range(0, len(weightings), TASK)), self._n_threads)
        return means, converged

    def _mean_of_columns(self, weights: np.ndarray) -> tuple[np.ndarray, bool]:
        return weights @ self.poses / weights.sum(), True

    def _mean_of_wrapped(self, weights: np.ndarray) -> tuple[np.ndarray, bool]:
        counted = weights > 0.0
        angles = AnglePoses(self.poses[counted], weights[counted] / weights.sum(), True)
        spread, _, reason = descend(angles, angles.start(), MEAN, MAX_ITER, TOL)
        return spread.pose, not reason

    def _descended(self, skeleton: Skeleton, weights: np.ndarray) -> tuple[np.ndarray, bool]:
        counted = weights > 0.0
        given = Given(self.poses[counted], weights[counted] / weights.sum(), skeleton)
        n_steps, wrap = self.parameters.get("n_steps", FEWEST_STEPS), self.parameters.get("wrap", "auto")
        poses, start, others = given.viewed(self.metric, n_steps, wrap, self.n_jobs)
        spread, _, reason = given.minimised(poses, start, MEAN, MAX_ITER, TOL)
        return given.columns_of(self.metric, spread.pose, others), not reason


def _extrinsic_mean(means: ExtrinsicMeans, weights: np.ndarray) -> tuple[np.ndarray, bool]:
    found = means.mean(weights, MAX_ITER, TOL_EXTRINSIC)
    return found.pose, found.converged
