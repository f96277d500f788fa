"""The results of a search: neighbours, and how many distances were evaluated for them."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np


class Evaluations(NamedTuple):
    """Numbers of distances that a search evaluated, which ``return_evaluations=True`` requests from a search.

    A search by brute force evaluates every pair of a query and a training pose. An exact search with lower bounds
    evaluates few of them; bounds are not counted.

    Attributes
    ----------
    lengths : int
        Pairs whose distance was computed. With "geodesic", pairs whose straight line in angle space was measured. Up to
        eight pairs of a query are computed at once, in the time of one.
    geodesics : int
        Pairs whose geodesic was solved for; zero with every metric but "geodesic".

    Examples
    --------
    >>> from skpose import PoseKNeighborsTransformer, Skeleton
    >>> X = [[0.0, 0.0], [0.1, 0.0], [1.5, 0.0], [1.6, 0.2]]
    >>> neighbors = PoseKNeighborsTransformer(Skeleton.chain(2), n_neighbors=1).fit(X)
    >>> distances, indices, evaluations = neighbors.kneighbors([[1.2, 0.1]], return_evaluations=True)
    >>> evaluations
    Evaluations(lengths=4, geodesics=0)
    """

    lengths: int
    geodesics: int


class Neighbors(NamedTuple):
    """Neighbours of several queries, sorted by query, then by distance, then by index."""

    queries: np.ndarray
    indices: np.ndarray
    distances: np.ndarray

    @classmethod
    def join(cls, parts: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> "Neighbors":
        """Concatenate parts that are sorted already."""
        return cls(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    @classmethod
    def sort(cls, parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> "Neighbors":
        """Concatenate and sort parts that are in any order."""
        queries, indices, distances = cls.join(parts)
        order = queries.argsort(kind="stable")
        for row in np.split(order, np.flatnonzero(np.diff(queries[order])) + 1):
            row[:] = row[np.lexsort((indices[row], distances[row]))]
        return cls(queries[order], indices[order], distances[order])


def select_requested(*parts: tuple[bool, Any]) -> Any:
    """Return those of some results that are requested: a tuple of them, or the only one itself."""
    chosen = tuple(result for is_requested, result in parts if is_requested)
    return chosen if len(chosen) > 1 else chosen[0]
