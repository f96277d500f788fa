"""Weighted poses, and the search for their mean or median."""

from numbers import Integral, Real

import numpy as np

from skpose._utils.sklearn import Interval, check_sample_weight
from skpose._utils.typing import ArrayLike
from skpose.geodesics._descent import Spread, descend
from skpose.geodesics._quasi_newton import minimise_sum
from skpose.metrics import Metric
from skpose.metrics._registry import MEAN_CONSTRAINTS
from skpose.metrics._sample import Sample

CONSTRAINTS = MEAN_CONSTRAINTS | {
    "sample_weight": ["array-like", None],
    "max_iter": [Interval(Integral, 1, None, closed="left")],
    "tol": [Interval(Real, 0, None, closed="left")],
    "n_jobs": [None, Integral],
}


def positive_weights(X: np.ndarray, sample_weight: ArrayLike | None) -> tuple[np.ndarray, np.ndarray]:
    """Poses of positive weight, and their weights, which sum to 1."""
    weights = check_sample_weight(sample_weight, X)
    weights = weights / weights.max()  # avoids overflow of the sum
    weights = weights / weights.sum()
    counted = weights > 0.0
    return X[counted], weights[counted]


def minimise(
    metric: Metric, sample: Sample, start: np.ndarray, power: int, max_iter: int, tol: float
) -> tuple[Spread, int, bool]:
    """The mean or median from a start, the number of iterations, and whether it converged."""
    search = descend if metric.has_gradients else minimise_sum
    spread, n_iter, converged = search(sample, start, power, max_iter, tol)
    lengths = sample.remeasure(spread.pose, spread.lengths)
    if lengths is not spread.lengths:
        spread = spread._replace(value=float(sample.weights @ lengths**power))
    return spread, n_iter, bool(converged)
