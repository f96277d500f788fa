"""Means of many weightings of one set of poses, under every metric, with or without a skeleton."""

import warnings
from collections.abc import Callable
from functools import partial

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._parallel.threads import in_threads
from skpose.geodesics._extrinsic import ExtrinsicMeans
from skpose.geodesics._mean import frechet_mean
from skpose.skeleton import Skeleton
from skpose.skeleton._rotations import TWO_PI

TASK = 16  # means; some milliseconds
STEPS_OF_ANGLES = 100  # of the mean of wrapped angles; some three are enough
SAME = 1e-12  # rad, a step that is rounding


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
        self._find: Callable[[np.ndarray], tuple[np.ndarray, bool]] = self._mean_of_angles
        self._n_threads = 1
        if metric == "position" and skeleton is not None:
            self._find = partial(_extrinsic_mean, ExtrinsicMeans.of(self.poses, skeleton))
            self._n_threads = effective_n_jobs(n_jobs)
        elif metric != "angle":  # one mean after the other, each on all threads
            self._find = self._intrinsic_mean

    def means(self, weightings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the means (n_means, n_dofs) under weightings (n_means, n_poses), and whether each one converged.

        Weights are not negative, and the sum of each row is positive.
        """
        means = np.empty((len(weightings), self.poses.shape[1]))
        converged = np.ones(len(weightings), dtype=bool)

        def find_some(start: int) -> None:
            for i in range(start, min(start + TASK, len(weightings))):
                means[i], converged[i] = self._find(weightings[i])

        in_threads((partial(find_some, start) for start in range(0, len(weightings), TASK)), self._n_threads)
        return means, converged

    def _mean_of_angles(self, weights: np.ndarray) -> tuple[np.ndarray, bool]:
        return _mean_of_angles(self.poses, weights, self.parameters["wrap"]), True

    def _intrinsic_mean(self, weights: np.ndarray) -> tuple[np.ndarray, bool]:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # the caller counts them
            found = frechet_mean(
                self.poses,
                self.skeleton,  # type: ignore[arg-type]  # None with "angle" alone
                metric=self.metric,
                sample_weight=weights,
                **self.parameters,
                n_jobs=self.n_jobs,
            )
        return found.pose, found.converged


def _extrinsic_mean(means: ExtrinsicMeans, weights: np.ndarray) -> tuple[np.ndarray, bool]:
    found = means.mean(weights)
    return found.pose, found.converged


def _mean_of_angles(poses: np.ndarray, weights: np.ndarray, wrap: bool) -> np.ndarray:
    """Return the mean of columns; of wrapped ones a minimum, downhill from the pose of the largest weight."""
    shares = weights / weights.sum()
    if not wrap:
        return shares @ poses
    mean = poses[shares.argmax()]
    for _ in range(STEPS_OF_ANGLES):
        gaps = poses - mean
        step = shares @ (gaps - TWO_PI * np.rint(gaps / TWO_PI))
        mean = mean + step
        if np.abs(step).max() <= SAME:
            break
    return mean
