"""Weighted poses, and the search for their mean or median."""

from numbers import Integral, Real
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs

from skpose._utils.sklearn import Interval, check_sample_weight
from skpose._utils.typing import ArrayLike
from skpose.geodesics._descent import Spread, descend
from skpose.geodesics._quasi_newton import minimise_sum
from skpose.metrics import Metric
from skpose.metrics._registry import MEAN_CONSTRAINTS
from skpose.metrics._sample import Sample
from skpose.skeleton import Skeleton

CONSTRAINTS = MEAN_CONSTRAINTS | {
    "sample_weight": ["array-like", None],
    "max_iter": [Interval(Integral, 1, None, closed="left")],
    "tol": [Interval(Real, 0, None, closed="left")],
    "n_jobs": [None, Integral],
}


class WeightedPoses(NamedTuple):
    """Poses of positive weight; the weights sum to 1."""

    X: np.ndarray  # (n_poses, n_dofs)
    weights: np.ndarray  # (n_poses,)
    skeleton: Skeleton | None

    @classmethod
    def of(cls, poses: np.ndarray, skeleton: Skeleton, sample_weight: ArrayLike | None) -> "WeightedPoses":
        """Validate the weights of poses that are already validated."""
        weights = check_sample_weight(sample_weight, poses)
        weights = weights / weights.max()  # avoids overflow of the sum
        weights = weights / weights.sum()
        counted = weights > 0.0
        return cls(poses[counted], weights[counted], skeleton)

    def sample(self, metric: Metric, n_jobs: int | None) -> Sample:
        return metric.sample(self.X, self.weights, self.skeleton, effective_n_jobs(n_jobs))


def minimise(
    metric: Metric, sample: Sample, start: np.ndarray, power: int, max_iter: int, tol: float
) -> tuple[Spread, int, str]:
    """The mean or median from a start, the number of iterations, and why it did not converge, or ""."""
    search = descend if metric.has_gradients else minimise_sum
    spread, n_iter, reason = search(sample, start, power, max_iter, tol)
    lengths = sample.remeasure(spread.pose, spread.lengths)
    if lengths is not spread.lengths:
        spread = spread._replace(value=float(sample.weights @ lengths**power))
    return spread, n_iter, reason
