"""Exact search of the nearest poses, by filter and refine.

The *filter* computes lower bounds of distances, see `skpose.neighbors._filter`. To *refine* is to measure: a distance
decides what the bounds leave open.

A search for the k nearest takes the poses with the least bounds in the whole index first, the *candidates*, and
measures them, until no bound that is left is within the k-th least distance. Most queries find them in the boxes next
to them and need 16 + 1.5 k. The others take more candidates, those within the k-th least distance so far, and then
more; the few for which that is not enough measure all *groups* of poses, those that fill a vector register, whose least
bound is within it (`skpose.neighbors._refine`). A search within a radius does so from the start.

A sample of the queries is searched first to estimate whether the filter is worth its cost (`skpose.neighbors._cost`);
without it all groups are measured. So no search costs much more than brute force, and memory holds no more than some
codes of poses, and where groups are measured one bound for each query and group.
"""

from collections.abc import Iterator, Sequence
from typing import cast

import numpy as np

from skpose._compiled.pose.candidates import Batch, Candidates, Known, nearest_of_candidates
from skpose._utils.parallel import TASKS_PER_JOB_UNEVEN, over_rows
from skpose._utils.typing import ArrayLike
from skpose.metrics import Metric
from skpose.neighbors._cost import QUERIES_PER_SAMPLE, CostModel
from skpose.neighbors._filter import FLOAT32, ChordFilter, FilterPoints
from skpose.neighbors._index import LANES, PoseIndex
from skpose.neighbors._nearest_so_far import NearestSoFar
from skpose.neighbors._order import order_of_groups
from skpose.neighbors._refine import Queries, Refinement
from skpose.neighbors._results import Neighbors

QUERIES = 1024  # searched for at once; memory is proportional to it
FIRST_CANDIDATES = 16  # of each query, in addition to 1.5 k
# A query that needs more candidates takes 8 and then 64 times as many, if the index has as many poses for each of them.
# If that is not enough, it measures groups.
POSES_PER_CANDIDATE = 32
# Share of the queries that may be left after they took more candidates, for these to take still more. Where more are
# left, each needs thousands of poses, many of which stand in the same groups.
MOST_LEFT = 0.5
MAX_BOUNDS = 2**23  # of groups of poses, in memory at once, a few times over
FIRST_GROUPS, GROUPS_AT_ONCE = 16, 512  # 256 and 8,192 poses, whose codes are in memory at once


class Search:
    """A search of an index for no more than QUERIES poses at once, under a metric that is measured directly.

    Attributes
    ----------
    unconverged : list of (int, float)
        Numbers of geodesics that did not converge, and the largest gap of each.
    """

    def __init__(self, index: PoseIndex, metric: Metric, n_jobs: int):
        self.index, self.metric, self.n_jobs = index, metric, n_jobs
        self._chords = cast(ChordFilter, index.filter)  # None if there is no filter
        self._groups = Refinement(index, metric, n_jobs)
        n_poses, n_dofs = index.poses.shape
        self._cost = CostModel(metric, metric.n_codes(self._groups.tree, n_dofs), n_poses)
        self._n_measured = 0
        self.unconverged: list[tuple[int, float]] = []

    @property
    def n_measured(self) -> int:
        """Pairs measured so far."""
        return self._n_measured + self._groups.n_measured

    def nearest(self, poses: np.ndarray, excluded: np.ndarray, k: int) -> Neighbors:
        """Find the k nearest poses of each query."""
        queries, best = self._queries(poses, excluded), NearestSoFar(np.full(len(poses), np.inf), k)
        order = np.arange(len(poses))
        if queries.points is not None:  # queries near each other, one after another, find the same poses in the cache
            order = order_of_groups(queries.points.coordinates, LANES)
            queries = queries.take(order)
        n_first, rest, is_filtered = FIRST_CANDIDATES + 3 * k // 2, np.arange(len(poses)), False
        if self._filter_is_worth_it_for_nearest(queries, n_first, k):
            most = len(self.index.poses) // POSES_PER_CANDIDATE
            sizes = [n for n in (n_first, 8 * n_first, 64 * n_first) if n == n_first or n <= most]
            rest, is_filtered = self._measure_candidates(queries, sizes, best), True
        at_once = max(1, MAX_BOUNDS // len(self.index.groups)) if is_filtered else QUERIES
        for some in (rest[start : start + at_once] for start in range(0, len(rest), at_once)):
            queries_left, best_of_rest = queries.take(some), NearestSoFar(best.current_limits[some], k)
            bounds = self._bounds(queries_left) if is_filtered else None
            for numbers in self._numbers(queries_left, bounds, best_of_rest.current_limits):
                self._measure_groups(queries_left, bounds, numbers, best_of_rest)
            best.put(some, best_of_rest)
        return Neighbors(*best.take(order.argsort()).sorted_entries())

    def within(self, poses: np.ndarray, excluded: np.ndarray, limits: ArrayLike, *, measured: bool = True) -> Neighbors:
        """Find all poses that are no further away from a query than its limit; distances are always measured."""
        limits, parts = np.array(np.broadcast_to(limits, len(poses))), []
        queries = self._queries(poses, excluded)
        bounds = self._bounds(queries) if self._filter_is_worth_it_within(queries, limits) else None
        for numbers in self._numbers(queries, bounds, limits):
            found = NearestSoFar(limits, LANES * len(numbers))
            self._measure_groups(queries, bounds, numbers, found)
            parts.append(found.entries())
        return Neighbors.sort(parts or [NearestSoFar(limits, 1).entries()])

    def refine(self, codes: np.ndarray, candidates: Candidates, best: NearestSoFar) -> None:
        """Measure the candidates of each query in order, but for those whose bound shows that they are not kept."""
        used, rows = np.unique(candidates.indices, return_inverse=True)
        poses = self._groups.encode(self.index.poses[used], self.metric.encode, codes)
        candidates = candidates._replace(rows=rows.reshape(candidates.rows.shape))
        tail = self._groups.measure, self._groups.tree, self.metric.steps, best.heaps
        for n_measured, n_unconverged, worst in over_rows(
            lambda first, last: nearest_of_candidates(codes, poses, candidates, Batch(first, last, 1, False), *tail),
            len(codes),
            self._cost.work_of_pairs(candidates.counts.sum()),
            self.n_jobs,
            TASKS_PER_JOB_UNEVEN,
        ):
            self._n_measured += n_measured
            self.unconverged.append((n_unconverged, worst))

    def _queries(self, poses: np.ndarray, excluded: np.ndarray) -> Queries:
        """Return the queries, with points of the filter if there is one and work enough to use it."""
        used = self.index.filter is not None and self._cost.filter_is_worth_a_trial(len(poses))
        return self._groups.queries(poses, excluded, self._chords.points(poses) if used else None)

    def _bounds(self, queries: Queries) -> np.ndarray:
        """Compute the bounds of all groups by the filter."""
        return self._chords.bounds(cast(FilterPoints, queries.points), self.n_jobs)

    def _within_reach(self, queries: Queries, bounds: np.ndarray, limits: np.ndarray) -> np.ndarray:
        """Return of some groups whether their bounds are within the limit of each query."""
        return bounds <= self._chords.limits(cast(FilterPoints, queries.points), limits)[:, np.newaxis]

    def _measure_candidates(self, queries: Queries, numbers: Sequence[int], best: NearestSoFar) -> np.ndarray:
        """Measure so many poses with the least bounds, and then so many more; return the queries that may need more."""
        rest, poses_of_groups = np.arange(len(queries)), self.index.groups.ravel()
        last_bounds, last_indices = np.full(len(rest), -1.0, FLOAT32), np.full(len(rest), -1)
        sort = self._groups.coarse is None  # else their order is that of the coarse bounds
        for n in numbers:
            some, best_of_some = queries.take(rest), best.take(rest)
            points, known = cast(FilterPoints, some.points), Known(some.excluded, last_bounds, last_indices)
            limits = self._chords.limits(points, best_of_some.current_limits)
            near = self._chords.nearest(points, poses_of_groups, known, limits, n, self.n_jobs, sort=sort).heaps
            bounds = self._chords.lowest(points, near.values)
            self._groups.measure_candidates(
                some, Candidates(near.indices, near.indices, bounds, near.counts), best_of_some
            )
            best.put(rest, best_of_some)
            last_bounds, last_indices = (part[:, -1 if sort else 0] for part in (near.values, near.indices))
            left = near.counts == n
            left[left] = last_bounds[left] <= self._chords.limits(points, best_of_some.current_limits)[left]
            rest, last_bounds, last_indices = rest[left], last_bounds[left], last_indices[left]
            if len(rest) == 0 or (n > min(numbers) and left.mean() > MOST_LEFT):
                break
        return rest

    def _numbers(self, queries: Queries, bounds: np.ndarray | None, limits: np.ndarray) -> Iterator[np.ndarray]:
        """Yield the numbers of all groups within reach, some at a time: few as long as no limit is known."""
        numbers = np.arange(len(self.index.groups))
        if bounds is not None:
            numbers = np.flatnonzero(self._within_reach(queries, bounds, limits).any(axis=0))
        start, size = 0, GROUPS_AT_ONCE if np.isfinite(limits).all() else FIRST_GROUPS
        while start < len(numbers):
            yield numbers[start : start + size]
            start, size = start + size, min(2 * size, GROUPS_AT_ONCE)

    def _measure_groups(
        self, queries: Queries, bounds: np.ndarray | None, numbers: np.ndarray, best: NearestSoFar
    ) -> None:
        """Measure some groups for the queries that they are within reach of."""
        near = np.zeros((len(queries), len(numbers)), FLOAT32)
        if bounds is not None:
            near[~self._within_reach(queries, bounds[:, numbers], best.current_limits)] = np.inf
        self._groups.measure_groups(queries, numbers, near, best)

    def _filter_is_worth_it_for_nearest(self, queries: Queries, n_first: int, k: int) -> bool:
        """Search for the k nearest of a sample of the queries, and estimate the cost of the search from it."""
        if queries.points is None or 4 * n_first > len(self.index.poses):
            return False
        sample = queries.take(np.arange(0, len(queries), QUERIES_PER_SAMPLE))
        best, points = NearestSoFar(np.full(len(sample), np.inf), k), cast(FilterPoints, sample.points)
        rest = self._measure_candidates(sample, (n_first,), best)
        limits = self._chords.limits(points.take(rest), best.current_limits[rest])
        share = self._chords.share_within(points.take(rest), limits, self.n_jobs) * len(rest) / len(sample)
        return self._cost.filter_is_worth_it(len(queries), n_first, share)

    def _filter_is_worth_it_within(self, queries: Queries, limits: np.ndarray) -> bool:
        """Filter for a sample of the queries, and estimate the cost of the search from it."""
        if queries.points is None:
            return False
        rows = np.arange(0, len(queries), QUERIES_PER_SAMPLE)
        sample = queries.take(rows)
        left = self._within_reach(sample, self._bounds(sample), limits[rows])
        return self._cost.filter_is_worth_it(len(queries), 0, left.mean())
