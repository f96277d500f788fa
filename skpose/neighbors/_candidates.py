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

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import PoseKNeighborsTransformer
    >>> from skpose.datasets import make_gait
    >>> motions = make_gait(1, 1, random_state=0)
    >>> X, _ = motions.poses(frame_rate=30)
    >>> neighbors = PoseKNeighborsTransformer(motions.skeleton, n_neighbors=1).fit(X)
    >>> nearest = neighbors.approximate_kneighbors(np.array([[0, 1, 2]]), X[:1])
    >>> nearest.indices.tolist(), nearest.distances.tolist(), nearest.recall
    ([[0]], [[0.0]], 1.0)
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
        if isinstance(candidates, np.ma.MaskedArray):
            raise ValueError("candidates must be an array without a mask: candidates.filled(-1) has -1 for none")
        try:
            rows = np.array(candidates)
        except ValueError:  # rows of several lengths
            rows = np.array(candidates, dtype=object)
        if rows.ndim != 2 or len(rows) != n_queries or rows.dtype.kind not in "iu":
            raise ValueError(
                f"candidates must be whole numbers, a row for each of the {n_queries} queries (if X is None, the "
                f"training poses), or a sparse graph, got an array of shape {rows.shape} and dtype {rows.dtype}: fill "
                "shorter rows up with -1, pass indices without their distances, and numbers with .astype(int)"
            )
        if rows.shape[1] == n_poses > 2 and rows.min() == 0 and rows.max() == 1:
            raise ValueError(
                "candidates has a column for each training pose, and zeros and ones alone, as a graph: pass it as "
                "scipy.sparse.csr_array(candidates)"
            )
    if rows.size and not -1 <= int(rows.min()) <= int(rows.max()) < n_poses:
        raise ValueError(
            f"candidates must be indices of the {n_poses} poses that fit got, or -1 for none, got {rows.min()} to "
            f"{rows.max()}"
        )
    rows = rows.astype(np.int64)
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
