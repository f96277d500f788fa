"""Exact search of nearest poses under "geodesic".

A geodesic is solved only where its interval, from the chord to the length of the straight line, can change the answer:
no k-th nearest is further away than the k-th shortest line, so what may have to be solved are the poses within that
chord, in order of chord, until the next chord is longer than the k-th shortest geodesic so far. Both kinds of interval
ends are found by searches of their own.
"""

from collections.abc import Iterator

import numpy as np
from sklearn.utils import gen_batches

from skpose._nearest import Kept
from skpose._search import QUERIES, Evaluations, Neighbors, PoseIndex, Search
from skpose.metrics import METRICS

MAX_CHORDS = 2**24  # held at once
ROUNDING = 1e-9  # of a body: so much longer may a chord be than a curve, as from a pose to itself after a whole turn


def search_of(index: PoseIndex, n_jobs: int) -> "Search | GeodesicSearch":
    """A new search of an index."""
    return GeodesicSearch(index, n_jobs) if index.metric == "geodesic" else Search(index, METRICS[index.metric], n_jobs)


class GeodesicSearch:
    """A search under "geodesic", for which a chord and a straight line leave as little to solve as they can."""

    def __init__(self, index: PoseIndex, n_jobs: int):
        self.index = index
        self.chords, self.lines, self.geodesics = (
            Search(index, METRICS[metric], n_jobs) for metric in ("position", "spatial", "geodesic")
        )
        self.rounding = ROUNDING * np.abs(index.skeleton.offsets).sum()

    @property
    def evaluations(self) -> Evaluations:
        return Evaluations(self.lines.n_measured, self.geodesics.n_measured)

    @property
    def doubts(self) -> list[tuple[int, float]]:
        return self.geodesics.doubts

    def nearest(self, poses: np.ndarray, own: np.ndarray, k: int) -> Neighbors:
        """The k nearest of each query."""
        parts = []
        for rows in self._batches(len(poses)):
            limits = np.full(len(own[rows]), np.inf)
            if self.index.screen is not None:
                lines = self.lines.nearest(poses[rows], own[rows], k).distances
                limits = lines.reshape(-1, k)[:, -1] + self.rounding
            chords = self.chords.within(poses[rows], own[rows], limits)
            parts.append(self._solve(poses[rows], chords, Kept(limits, k)).sorted(rows.start))
        return Neighbors.joined(parts)

    def within(self, poses: np.ndarray, own: np.ndarray, limits: np.ndarray, *, measured: bool = True) -> Neighbors:
        """All poses that are no further away from a query than its limit.

        If they need not be measured, the distance of those whose straight line is short enough is the line's.
        """
        parts = []
        for rows in self._batches(len(poses)):
            near = self.chords.within(poses[rows], own[rows], limits[rows] + self.rounding)
            if not measured:
                lines = self.lines.within(poses[rows], own[rows], limits[rows])
                parts.append((lines.queries + rows.start, lines.indices, lines.distances))
                size = len(self.index.poses)
                open_ = ~np.isin(near.queries * size + near.indices, lines.queries * size + lines.indices)
                near = Neighbors(*(field[open_] for field in near))
            room = np.bincount(near.queries, minlength=1).max()
            parts.append(self._solve(poses[rows], near, Kept(limits[rows], max(1, room))).entries(rows.start))
        return Neighbors.sorted(parts)

    def _batches(self, n_queries: int) -> Iterator[slice]:
        return gen_batches(n_queries, max(1, min(QUERIES, MAX_CHORDS // len(self.index.poses))))

    def _solve(self, poses: np.ndarray, chords: Neighbors, best: Kept) -> Kept:
        """Solve what the chords leave open, the shortest first."""
        counts = np.bincount(chords.queries, minlength=len(poses))
        shape = len(poses), max(1, counts.max())
        candidates, bounds = np.zeros(shape, np.int64), np.zeros(shape)
        place = chords.queries, np.arange(len(chords.queries)) - np.repeat(np.cumsum(counts) - counts, counts)
        candidates[place] = chords.indices
        if self.index.screen is not None:
            bounds[place] = chords.distances - self.rounding
        codes = METRICS["geodesic"].encoded(poses, self.index.skeleton, self.index.steps)
        self.geodesics.refine(codes, candidates, bounds, counts, best, at_once=1)
        return best
