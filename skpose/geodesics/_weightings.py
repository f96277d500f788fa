"""Fréchet means of the same poses under many weightings."""

from functools import partial

import numpy as np
from joblib import effective_n_jobs

from skpose._utils.parallel import in_threads
from skpose.geodesics._descent import MEAN
from skpose.geodesics._weighted_poses import minimise
from skpose.metrics import Metric
from skpose.skeleton import Skeleton

MAX_ITER, TOL = 200, 1e-3  # as `frechet_mean`
# Gradient norm at which an extrinsic mean has converged, m²/rad. `frechet_mean` uses a smaller value, which takes many
# iterations if an angle hardly moves the joints.
TOL_DIRECT = 1e-6


class WeightedMeans:
    """Poses and their Fréchet means under any weighting.

    Parameters
    ----------
    poses : ndarray of shape (n_poses, n_dofs)
        Validated poses, rad.
    skeleton : Skeleton or None
        The skeleton of the poses; None for a metric that needs none.
    metric : Metric
        The metric.
    n_jobs : int or None
        Number of threads.
    """

    def __init__(self, poses: np.ndarray, skeleton: Skeleton | None, metric: Metric, n_jobs: int | None):
        self.poses = poses.astype(np.float64, copy=False)
        self.skeleton, self.metric, self.n_jobs = skeleton, metric, n_jobs
        self._direct = metric.direct_means(self.poses, skeleton)

    def means(self, weightings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means (n_means, n_dofs) under non-negative weightings (n_means, n_poses), and which converged."""
        means = np.empty((len(weightings), self.poses.shape[1]))
        converged = np.ones(len(weightings), dtype=bool)

        def find(i: int) -> None:
            counted = np.flatnonzero(weightings[i])
            if len(counted) == 1:
                means[i] = self.poses[counted[0]]
            else:
                means[i], converged[i] = self._find(weightings[i])

        # Iterative means run one after the other, each on all threads.
        n_threads = 1 if self._direct is None else effective_n_jobs(self.n_jobs)
        in_threads((partial(find, i) for i in range(len(weightings))), n_threads)
        return means, converged

    def _find(self, weights: np.ndarray) -> tuple[np.ndarray, bool]:
        if self._direct is not None:
            mean = self._direct.mean(weights, MAX_ITER, TOL_DIRECT)
            return mean.pose, mean.converged
        counted = weights > 0.0
        shares, n_threads = weights[counted] / weights.sum(), effective_n_jobs(self.n_jobs)
        sample = self.metric.sample(self.poses[counted], shares, self.skeleton, n_threads)
        start, others = sample.start()
        spread, _, converged = minimise(self.metric, sample, start, MEAN, MAX_ITER, TOL)
        return sample.columns(spread.pose, others), converged
