"""Candidates that another index has found, as an array, and what is measured of them."""

from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import issparse

from skpose.neighbors._results import Neighbors


class ApproximateNeighbors(NamedTuple):
    """The nearest of some candidates, which may miss the nearest of all poses.

    Attributes
    ----------
    distances : ndarray of shape (n_queries, n_neighbors)
        In m, or rad for "angle"; exact. Infinite where a query has fewer candidates.
    indices : ndarray of shape (n_queries, n_neighbors)
        By distance, those equally far away by index; -1 where a query has fewer candidates.
    recall : float
        Share of the nearest of all poses that were found, estimated from some queries; NaN where none were checked.
    """

    distances: np.ndarray
    indices: np.ndarray
    recall: float


def check_candidates(candidates: Any, excluded: np.ndarray, n_poses: int) -> np.ndarray:
    """Return candidates as rows of indices, each pose once and those of no use last, as -1."""
    n_queries = len(excluded)
    if issparse(candidates):
        if candidates.shape != (n_queries, n_poses):
            raise ValueError(
                f"candidates must be a graph of shape (n_queries, n_samples_fit), here {(n_queries, n_poses)}, got "
                f"{candidates.shape}"
            )
        graph = candidates.tocsr()
        counts = np.diff(graph.indptr)
        rows = np.full((n_queries, counts.max(initial=0)), -1)
        rows[np.arange(rows.shape[1]) < counts[:, np.newaxis]] = graph.indices
    else:
        rows = np.array(candidates)
        if rows.ndim != 2 or len(rows) != n_queries or not np.issubdtype(rows.dtype, np.integer):
            raise ValueError(
                f"candidates must be whole numbers, a row for each of the {n_queries} queries, or a sparse graph, got "
                f"an array of shape {rows.shape} and dtype {rows.dtype}"
            )
        rows = rows.astype(np.int64, copy=False)
    if rows.size and not -1 <= rows.min() <= rows.max() < n_poses:
        raise ValueError(
            f"candidates must be indices of the {n_poses} poses that fit got, or -1 for none, got {rows.min()} to "
            f"{rows.max()}"
        )
    rows.sort(axis=1)
    rows[:, 1:][rows[:, 1:] == rows[:, :-1]] = -1
    rows[rows == excluded[:, np.newaxis]] = -1
    return -np.sort(-rows, axis=1)


def as_matrices(neighbors: Neighbors, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return distances and indices as matrices, filled up with infinity and -1."""
    distances, indices = np.full(shape, np.inf), np.full(shape, -1)
    ranks = np.arange(len(neighbors.queries)) - np.searchsorted(neighbors.queries, neighbors.queries)
    distances[neighbors.queries, ranks], indices[neighbors.queries, ranks] = neighbors.distances, neighbors.indices
    return distances, indices
