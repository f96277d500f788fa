"""Exact search of nearest poses under "geodesic".

A geodesic is solved only where its interval, from the chord to the length of the straight line, can change the answer:
no k-th nearest is further away than the k-th shortest line, so what may have to be solved are the poses within that
chord, in order of chord, until the next chord is longer than the k-th shortest geodesic so far. Both kinds of interval
ends are found by searches of their own.
"""

import numpy as np
from numpy.typing import ArrayLike

from skpose._compiled.nearest import Kept
from skpose.metrics._registry import METRICS
from skpose.neighbors._search import Evaluations, Neighbors, PoseIndex, Search

SOLVED_AT_ONCE = 16  # for a query: few enough that Ctrl-C is heard
ROUNDING = 1e-9  # of a body: so much longer may a chord be than a curve, as from a pose to itself after a whole turn


def search_of(index: PoseIndex, n_jobs: int) -> "Search | GeodesicSearch":
    """A new search of an index."""
    return GeodesicSearch(index, n_jobs) if index.metric == "geodesic" else Search(index, METRICS[index.metric], n_jobs)


class GeodesicSearch:
    """A search under "geodesic", for which a chord and a straight line leave as little to solve as they can.

    It may hold all chords between queries and poses at once.
    """

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
    def unconverged(self) -> list[tuple[int, float]]:
        return self.geodesics.unconverged

    def nearest(self, poses: np.ndarray, own: np.ndarray, k: int) -> Neighbors:
        """The k nearest of each query."""
        limits = np.full(len(own), np.inf)
        if self.index.screen is not None:
            limits = self.lines.nearest(poses, own, k).distances.reshape(-1, k)[:, -1] + self.rounding
        return Neighbors(*self._solve(poses, self.chords.within(poses, own, limits), Kept(limits, k)).sorted())

    def within(self, poses: np.ndarray, own: np.ndarray, limits: ArrayLike, *, measured: bool = True) -> Neighbors:
        """All poses that are no further away from a query than its limit.

        If they need not be measured, the distance of those whose straight line is short enough is the line's.
        """
        limits, parts = np.array(np.broadcast_to(limits, len(poses))), []
        near = self.chords.within(poses, own, limits + self.rounding)
        if not measured:
            lines, size = self.lines.within(poses, own, limits), len(self.index.poses)
            parts.append(lines)
            open_ = ~np.isin(near.queries * size + near.indices, lines.queries * size + lines.indices)
            near = Neighbors(*(field[open_] for field in near))
        room = np.bincount(near.queries, minlength=1).max()
        parts.append(self._solve(poses, near, Kept(limits, max(1, room))).entries())
        return Neighbors.sorted(parts)

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
        for start in range(0, candidates.shape[1], SOLVED_AT_ONCE):
            some = (np.ascontiguousarray(part[:, start : start + SOLVED_AT_ONCE]) for part in (candidates, bounds))
            self.geodesics.refine(codes, *some, np.clip(counts - start, 0, SOLVED_AT_ONCE), best, at_once=1)
        return best
