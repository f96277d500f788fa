"""Distances between poses row by row."""

from functools import partial

import numpy as np

from skpose._parallel.threads import in_threads
from skpose.metrics._convergence import Unconverged, warn_of_unconverged
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._registry import METRICS, resolve
from skpose.skeleton import Skeleton

TILE = 16  # rows whose full matrix costs less than as many calls


def paired_distances(
    X: np.ndarray, Y: np.ndarray, skeleton: Skeleton | None, metric: str, parameters: dict, n_jobs: int
) -> np.ndarray:
    """Return the distances (n_poses,) from each row of X to the same row of Y: poses that are checked already.

    `parameters` are `n_steps` and `wrap`, where the metric has them.
    """
    _, _, steps = resolve(metric, skeleton, parameters.get("n_steps", 1), parameters.get("wrap", "auto"))
    distances, tile = np.empty(len(X)), 1 if METRICS[metric].always_float64 else TILE
    unconverged: list[Unconverged] = []

    def measure(start: int) -> None:
        rows = slice(start, start + tile)
        matrix = DistanceMatrix(X[rows], Y[rows], metric, skeleton, steps)
        values, parts = matrix.written(None, 1)
        distances[rows] = values.diagonal()
        unconverged.extend(parts)

    in_threads((partial(measure, start) for start in range(0, len(X), tile)), n_jobs)
    warn_of_unconverged(unconverged, len(X))
    return distances
