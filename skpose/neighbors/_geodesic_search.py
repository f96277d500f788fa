"""Exact search of the nearest poses under "geodesic".

A geodesic is solved only where its interval, from the chord to the length of the straight line, can change the answer:
no k-th nearest is further away than the k-th shortest line, so what may have to be solved are the poses within that
chord, in order of chord, until the next chord is longer than the k-th shortest geodesic so far. Both ends of the
intervals are found by searches of their own.
"""

from typing import cast

import numpy as np

from skpose._compiled.pose.candidates import Candidates
from skpose._utils.typing import ArrayLike
from skpose.metrics import Metric
from skpose.neighbors._index import PoseIndex
from skpose.neighbors._nearest_so_far import NearestSoFar
from skpose.neighbors._results import Neighbors
from skpose.neighbors._search import Search

SOLVED_AT_ONCE = 16  # candidates of a query: few enough that Ctrl-C does not wait long
ROUNDING = 1e-9  # relative to the size of the skeleton: a chord may exceed a curve by it, as after a whole turn


class GeodesicSearch:
    """A search under "geodesic", whose chords and straight lines leave few geodesics to solve.

    It may need memory for all chords between queries and poses at once.
    """

    def __init__(self, index: PoseIndex, n_jobs: int):
        self.index = index
        solved, skeleton = index.metric, index.skeleton
        bounds = cast(Metric, solved.lower_bound()), cast(Metric, solved.upper_bound())
        self.chords, self.lines, self.geodesics = (Search(index, metric, n_jobs) for metric in (*bounds, solved))
        self.rounding = 0.0 if skeleton is None else ROUNDING * np.abs(skeleton.offsets).sum()

    @property
    def n_measured(self) -> int:
        """Geodesics solved so far."""
        return self.geodesics.n_measured

    @property
    def unconverged(self) -> list[tuple[int, float]]:
        return self.geodesics.unconverged

    def nearest(self, poses: np.ndarray, excluded: np.ndarray, k: int) -> Neighbors:
        """Find the k nearest poses of each query."""
        limits = np.full(len(poses), np.inf)
        if self.index.filter is not None:
            limits = self.lines.nearest(poses, excluded, k).distances.reshape(-1, k)[:, -1] + self.rounding
        best = NearestSoFar(limits, k)
        self._solve(poses, self.chords.within(poses, excluded, limits), best)
        return Neighbors(*best.sorted_entries())

    def within(self, poses: np.ndarray, excluded: np.ndarray, limits: ArrayLike, *, measured: bool = True) -> Neighbors:
        """Find all poses that are no further away from a query than its limit.

        If they need not be measured, the distance of those whose straight line is short enough is the line's.
        """
        limits = np.array(np.broadcast_to(limits, len(poses)))
        parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
        near = self.chords.within(poses, excluded, limits + self.rounding)
        if not measured:
            lines, size = self.lines.within(poses, excluded, limits), len(self.index.poses)
            parts.append(lines)
            unsettled = ~np.isin(near.queries * size + near.indices, lines.queries * size + lines.indices)
            near = Neighbors(*(field[unsettled] for field in near))
        best = NearestSoFar(limits, max(1, np.bincount(near.queries, minlength=1).max()))
        self._solve(poses, near, best)
        parts.append(best.entries())
        return Neighbors.sort(parts)

    def _solve(self, poses: np.ndarray, chords: Neighbors, best: NearestSoFar) -> None:
        """Solve the geodesics that may be among the best, in order of chord."""
        counts = np.bincount(chords.queries, minlength=len(poses))
        shape = len(poses), max(1, counts.max())
        indices, bounds = np.zeros(shape, np.int64), np.zeros(shape)
        ranks = np.arange(len(chords.queries)) - np.repeat(np.cumsum(counts) - counts, counts)
        indices[chords.queries, ranks] = chords.indices
        if self.index.filter is not None:
            bounds[chords.queries, ranks] = chords.distances - self.rounding
        codes = self.index.metric.encode_poses(poses, self.index.skeleton)
        for start in range(0, indices.shape[1], SOLVED_AT_ONCE):
            some, their_bounds = (
                np.ascontiguousarray(part[:, start : start + SOLVED_AT_ONCE]) for part in (indices, bounds)
            )
            candidates = Candidates(some, some, their_bounds, np.clip(counts - start, 0, SOLVED_AT_ONCE))
            self.geodesics.refine(codes, candidates, best)
