"""The poses of a mean or a median as they are given, checked, and the search for it under a metric."""

from numbers import Integral, Real
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs

from skpose._compat.sklearn import Interval
from skpose._typing import ArrayLike
from skpose._validation.numbers import as_numbers
from skpose.geodesics._descent import Spread, descend
from skpose.geodesics._quasi_newton import minimise_sum
from skpose.metrics import Metric
from skpose.metrics._shared import MEAN_CONSTRAINTS, Sample
from skpose.skeleton import Skeleton

CONSTRAINTS = MEAN_CONSTRAINTS | {
    "sample_weight": ["array-like", None],
    "max_iter": [Interval(Integral, 1, None, closed="left")],
    "tol": [Interval(Real, 0, None, closed="left")],
    "n_jobs": [None, Integral],
}


class WeightedPoses(NamedTuple):
    """Poses of weight, in float64, and their weights of sum 1."""

    X: np.ndarray  # (n_poses, n_dofs)
    weights: np.ndarray  # (n_poses,)
    skeleton: Skeleton | None

    @classmethod
    def of(cls, poses: np.ndarray, skeleton: Skeleton, sample_weight: ArrayLike | None) -> "WeightedPoses":
        """Check the weights of poses, which are checked already, and leave out those of weight zero."""
        weights = _check_weights(sample_weight, len(poses))
        counted = weights > 0.0
        return cls(poses[counted], weights[counted], skeleton)

    def sample(self, metric: Metric, n_jobs: int | None) -> Sample:
        """Return the poses under a metric."""
        return metric.sample(self.X, self.weights, self.skeleton, effective_n_jobs(n_jobs))


def minimise(
    metric: Metric, sample: Sample, start: np.ndarray, power: int, max_iter: int, tol: float
) -> tuple[Spread, int, str]:
    """Return the mean or median from a start, the iterations, and why it did not converge: empty if it did."""
    search = descend if metric.has_gradients else minimise_sum
    spread, n_iter, reason = search(sample, start, power, max_iter, tol)
    lengths = sample.remeasure(spread.pose, spread.lengths)
    if lengths is not spread.lengths:
        spread = spread._replace(value=float(sample.weights @ lengths**power))
    return spread, n_iter, reason


def _check_weights(sample_weight: ArrayLike | None, n_poses: int) -> np.ndarray:
    """Return weights whose sum is one."""
    if sample_weight is None:
        return np.full(n_poses, 1.0 / n_poses)
    weights = as_numbers(sample_weight, "sample_weight")
    if weights.shape != (n_poses,):
        raise ValueError(f"sample_weight must have shape ({n_poses},), one for each pose, got {weights.shape}")
    if not (np.isfinite(weights).all() and (weights >= 0).all() and weights.any()):
        raise ValueError("sample_weight must be finite, nowhere negative, and somewhere positive")
    weights = weights / weights.max()  # whose sum is finite
    return weights / weights.sum()
