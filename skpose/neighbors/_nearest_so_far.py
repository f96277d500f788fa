"""The nearest poses that a search has found so far, as the compiled loops keep them, and in the end."""

import copy
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from skpose._compiled.pose.nearest import Heaps


class NearestSoFar:
    """The nearest poses found so far, for each query: at most `capacity`, none beyond the query's limit.

    Attributes
    ----------
    heaps : Heaps
        The arrays that the compiled loops write: values, which are distances or lower bounds of them, indices and
        counts.
    """

    def __init__(self, limits: np.ndarray, capacity: int, dtype: DTypeLike = np.float64):
        shape = len(limits), capacity
        self.heaps = Heaps(
            np.ascontiguousarray(limits, dtype),
            np.empty(shape, dtype),
            np.empty(shape, np.int64),
            np.zeros(len(limits), np.int64),
        )

    @property
    def current_limits(self) -> np.ndarray:
        """The largest value that each query would still keep."""
        limits, values, _, counts = self.heaps
        return np.where(counts == values.shape[1], values[:, 0], limits)

    def take(self, rows: np.ndarray) -> "NearestSoFar":
        """Return a copy of some rows."""
        some = copy.copy(self)
        some.heaps = Heaps(*(part[rows] for part in self.heaps))
        return some

    def put(self, rows: np.ndarray, other: "NearestSoFar") -> None:
        """Replace the entries of some rows by those of another of the same capacity."""
        for name in ("values", "indices", "counts"):
            getattr(self.heaps, name)[rows] = getattr(other.heaps, name)

    def sorted_entries(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return row, index and value of all entries, by row, value and index; every row must be full."""
        _, values, indices, counts = self.heaps
        order = np.lexsort((indices, values), axis=1)
        indices, values = (np.take_along_axis(part, order, axis=1).ravel() for part in (indices, values))
        return np.repeat(np.arange(len(counts)), counts), indices, values

    def entries(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return row, index and value of all entries, by row."""
        _, values, indices, counts = self.heaps
        kept = np.arange(values.shape[1]) < counts[:, np.newaxis]
        return np.repeat(np.arange(len(counts)), counts), indices[kept], values[kept]


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
