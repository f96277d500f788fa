"""Distances between corresponding rows."""

from functools import partial
from itertools import chain

import numpy as np
from sklearn.utils import gen_batches

from skpose._utils.parallel import in_threads
from skpose.metrics._convergence import Unconverged, warn_of_unconverged
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._metric import Metric
from skpose.skeleton import Skeleton

TILE = 16  # rows whose full matrix costs less than as many calls


def paired_distances(
    X: np.ndarray, Y: np.ndarray, skeleton: Skeleton | None, metric: Metric, n_jobs: int
) -> np.ndarray:
    """Distances (n_poses,) from each row of X to the same row of Y, without checks."""
    distances, tile = np.empty(len(X)), 1 if metric.iterative else TILE

    def measure(rows: slice) -> list[Unconverged]:
        values, unconverged = DistanceMatrix(X[rows], Y[rows], metric, skeleton).write(None, 1)
        distances[rows] = values.diagonal()
        return unconverged

    parts = in_threads((partial(measure, rows) for rows in gen_batches(len(X), tile)), n_jobs)
    warn_of_unconverged(chain.from_iterable(parts), len(X))
    return distances
