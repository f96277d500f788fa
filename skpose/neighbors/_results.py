"""The neighbours that a search found."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np


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
