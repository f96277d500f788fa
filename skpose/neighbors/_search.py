"""Exact search of the nearest poses, by filter and refine.

The *filter* computes lower bounds of distances, see `skpose.neighbors._index`. To *refine* is to measure: a distance
decides what the bounds leave open.

A search for the k nearest takes the poses with the least bounds in the whole index first, the *candidates*, and
measures them, until no bound that is left is within the k-th least distance. Most queries find them in the boxes next
to them and need 16 + 1.5 k. The others take more candidates, those within the k-th least distance so far, and then
more; the few for which that is not enough measure all *groups* of poses, those that fill a vector register, whose least
bound is within it. A search within a radius does so from the start. Every pose that is left for any query is encoded
once: as a row of codes, from which those of a query are gathered into lanes, or in groups.

A sample of the queries is searched first to estimate whether the filter is worth its cost; without it all groups are
measured. So no search costs much more than brute force, and memory holds no more than some codes of poses, and where
groups are measured one bound for each query and group. The unit of work is that of `Metric.measure_work`: adding one
square to a sum in float64, at most 0.2 ns on one core. The times below are of CMU poses on one AVX-512 core.

Under "geodesic", a geodesic is solved only where its interval, from the chord to the length of the straight line, can
change the answer: no k-th nearest is further away than the k-th shortest line, so what may have to be solved are the
poses within that chord, in order of chord, until the next chord is longer than the k-th shortest geodesic so far. Both
ends of the intervals are found by searches of their own.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple, cast

import numpy as np

from skpose._compiled.pose.candidates import Candidates, Known, nearest_of_candidates
from skpose._compiled.pose.loops import FLOAT64_LANES, encode_poses, in_lanes
from skpose._compiled.pose.nearest import Groups, Heaps, nearest_of_groups
from skpose._utils.parallel import TASKS_PER_JOB_UNEVEN, over_rows
from skpose._utils.typing import ArrayLike
from skpose.metrics import Metric
from skpose.neighbors._index import (
    FILTER_WORK,
    FLOAT32,
    LANES,
    ChordFilter,
    FilterPoints,
    Neighbors,
    PoseIndex,
    order_of_groups,
)

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
CODES_AT_ONCE = 2**15  # poses that are encoded at once, where the index has more
# Work of a search by brute force from which on a filter is tried; it then takes 20 ms or more. Below, a filter saves 15
# ms at most ("spatial") and may take longer than brute force ("angle").
LEAST_WORK_TO_FILTER = 400_000_000
# One query in so many is searched first, to estimate what the filter leaves: that is 1.6 % of the filter's work.
QUERIES_PER_SAMPLE = 64
SOLVED_AT_ONCE = 16  # geodesics of a query: few enough that Ctrl-C does not wait long
ROUNDING = 1e-9  # relative to the size of the skeleton: a chord may exceed a curve by it, as after a whole turn


class Queries(NamedTuple):
    """Poses whose neighbours are searched."""

    codes: np.ndarray  # (n_queries, n_codes)
    excluded: np.ndarray  # (n_queries,) index of a pose that is not a neighbour, or -1
    points: FilterPoints | None  # where the filter is used

    def take(self, rows: np.ndarray) -> "Queries":
        return Queries(self.codes[rows], self.excluded[rows], None if self.points is None else self.points.take(rows))


class Search:
    """A search of an index for no more than QUERIES poses at once, under a metric that is measured directly.

    Attributes
    ----------
    n_measured : int
        Pairs measured so far.
    unconverged : list of (int, float)
        Numbers of geodesics that did not converge, and the largest gap of each.
    """

    def __init__(self, index: PoseIndex, metric: Metric, n_jobs: int):
        self.index, self.metric, self.n_jobs = index, metric, n_jobs
        self._chords = cast(ChordFilter, index.filter)  # None if there is no filter
        self._tree, self._steps = metric.tree_for(index.skeleton), metric.steps
        self._n_codes = metric.n_codes(self._tree, index.poses.shape[1])
        self.n_measured = 0
        self.unconverged: list[tuple[int, float]] = []

    def nearest(self, poses: np.ndarray, excluded: np.ndarray, k: int) -> Neighbors:
        """Find the k nearest poses of each query."""
        queries, best = self._queries(poses, excluded), Heaps.of(np.full(len(poses), np.inf), k)
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
            queries_left, best_of_rest = queries.take(some), Heaps.of(best.current_limits[some], k)
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
            found = Heaps.of(limits, LANES * len(numbers))
            self._measure_groups(queries, bounds, numbers, found)
            parts.append(found.entries())
        return Neighbors.sort(parts or [Heaps.of(limits, 1).entries()])

    def refine(self, codes: np.ndarray, candidates: Candidates, best: Heaps, at_once: int) -> None:
        """Measure the candidates of each query in order, but for those whose bound shows that they are not kept."""
        candidates, poses = self._gather(candidates, best.current_limits)
        others, tail = self._encode(poses), (self.metric.measure, self._tree, self._steps, best)
        for n_measured, *unconverged in over_rows(
            lambda first, last: nearest_of_candidates(codes, others, candidates, first, last, at_once, *tail),
            len(codes),
            self._work_of_pairs(candidates.counts.sum()),
            self.n_jobs,
            TASKS_PER_JOB_UNEVEN,
        ):
            self.n_measured += n_measured
            self.unconverged.append(tuple(unconverged))

    def _gather(self, candidates: Candidates, limits: np.ndarray) -> tuple[Candidates, np.ndarray]:
        """Return candidates with their rows among the poses that are those of any query within limits, and these."""
        indices, _, bounds, counts = candidates
        used = (np.arange(indices.shape[1]) < counts[:, np.newaxis]) & (bounds <= limits[:, np.newaxis])
        chosen, places = np.zeros(len(self.index.poses), bool), np.empty(len(self.index.poses), np.int64)
        chosen[indices[used]] = True
        union = np.flatnonzero(chosen)
        places[union] = np.arange(len(union))
        rows = np.zeros_like(indices)
        rows[used] = places[indices[used]]
        return candidates._replace(rows=rows), self.index.poses[union]

    def _encode(self, poses: np.ndarray) -> np.ndarray:
        """Return the codes of poses as rows."""
        codes = np.empty((len(poses), self._n_codes))

        def task(first: int, last: int) -> None:
            encode_poses(poses[first:last], self.metric.encode, self._tree, self._steps, codes[first:last])

        over_rows(task, len(poses), codes.size * self.metric.encode_work, self.n_jobs)
        return codes

    def _queries(self, poses: np.ndarray, excluded: np.ndarray) -> Queries:
        """Return the queries, with points of the filter if there is one and brute force takes so long that it saves."""
        used = self.index.filter is not None and self._work_of_brute_force(len(poses)) >= LEAST_WORK_TO_FILTER
        codes = self.metric.encode_poses(poses, self.index.skeleton)
        return Queries(codes, excluded, self._chords.points(poses) if used else None)

    def _bounds(self, queries: Queries) -> np.ndarray:
        """Compute the bounds of all groups by the filter."""
        return self._chords.bounds(cast(FilterPoints, queries.points), self.n_jobs)

    def _within_reach(self, queries: Queries, bounds: np.ndarray, limits: np.ndarray) -> np.ndarray:
        """Return of some groups whether their bounds are within the limit of each query."""
        return bounds <= self._chords.limits(cast(FilterPoints, queries.points), limits)[:, np.newaxis]

    def _measure_candidates(self, queries: Queries, numbers: Sequence[int], best: Heaps) -> np.ndarray:
        """Measure so many poses with the least bounds, and then so many more; return the queries that may need more."""
        rest, poses_of_groups = np.arange(len(queries.codes)), self.index.groups.ravel()
        last_bounds, last_indices = np.full(len(rest), -1.0, FLOAT32), np.full(len(rest), -1)
        for n in numbers:
            some, best_of_some = queries.take(rest), best.take(rest)
            points, known = cast(FilterPoints, some.points), Known(some.excluded, last_bounds, last_indices)
            limits = self._chords.limits(points, best_of_some.current_limits)
            near = self._chords.nearest(points, poses_of_groups, known, limits, n, self.n_jobs)
            bounds = self._chords.lowest(points, near.values)
            self._refine_in_parts(some.codes, Candidates(near.indices, near.indices, bounds, near.counts), best_of_some)
            best.put(rest, best_of_some)
            last_bounds, last_indices = (part[:, -1] for part in (near.values, near.indices))
            left = near.counts == n
            left[left] = last_bounds[left] <= self._chords.limits(points, best_of_some.current_limits)[left]
            rest, last_bounds, last_indices = rest[left], last_bounds[left], last_indices[left]
            if len(rest) == 0 or (n > min(numbers) and left.mean() > MOST_LEFT):
                break
        return rest

    def _refine_in_parts(self, codes: np.ndarray, candidates: Candidates, best: Heaps) -> None:
        """Measure candidates of queries with as many together, some at a time where the index has many poses."""
        order = candidates.counts.argsort()
        n_codes = candidates.counts[order].cumsum() if len(self.index.poses) > CODES_AT_ONCE else np.zeros(len(order))
        for rows in np.split(order, np.flatnonzero(np.diff(n_codes // CODES_AT_ONCE)) + 1):
            best_of_some, most = best.take(rows), candidates.counts[rows[-1:]].max(initial=0)
            indices, bounds = candidates.indices[rows, :most], candidates.bounds[rows, :most]
            some = Candidates(indices, indices, bounds, candidates.counts[rows])
            self.refine(codes[rows], some, best_of_some, FLOAT64_LANES)
            best.put(rows, best_of_some)

    def _numbers(self, queries: Queries, bounds: np.ndarray | None, limits: np.ndarray) -> Iterator[np.ndarray]:
        """Yield the numbers of all groups within reach, some at a time: few as long as no limit is known."""
        numbers = np.arange(len(self.index.groups))
        if bounds is not None:
            numbers = np.flatnonzero(self._within_reach(queries, bounds, limits).any(axis=0))
        start, size = 0, GROUPS_AT_ONCE if np.isfinite(limits).all() else FIRST_GROUPS
        while start < len(numbers):
            yield numbers[start : start + size]
            start, size = start + size, min(2 * size, GROUPS_AT_ONCE)

    def _measure_groups(self, queries: Queries, bounds: np.ndarray | None, numbers: np.ndarray, best: Heaps) -> None:
        """Measure some groups for the queries that they are within reach of."""
        near = np.zeros((len(queries.codes), len(numbers)), FLOAT32)
        if bounds is not None:
            near[~self._within_reach(queries, bounds[:, numbers], best.current_limits)] = np.inf
        indices = self.index.groups[numbers].ravel()
        groups = Groups(in_lanes(self._encode(self.index.poses[np.maximum(indices, 0)])), indices, near)
        tail = queries.excluded, self.metric.measure, self._tree, self._steps, best
        self.n_measured += sum(
            over_rows(
                lambda first, last: nearest_of_groups(queries.codes, groups, first, last, *tail),
                len(queries.codes),
                float(np.count_nonzero(near < np.inf)) * LANES * self._n_codes * self.metric.measure_work,
                self.n_jobs,
            )
        )

    def _filter_is_worth_it_for_nearest(self, queries: Queries, n_first: int, k: int) -> bool:
        """Search for the k nearest of a sample of the queries, and estimate the cost of the search from it."""
        if queries.points is None or 4 * n_first > len(self.index.poses):
            return False
        sample = queries.take(np.arange(0, len(queries.codes), QUERIES_PER_SAMPLE))
        best, points = Heaps.of(np.full(len(sample.codes), np.inf), k), cast(FilterPoints, sample.points)
        rest = self._measure_candidates(sample, (n_first,), best)
        limits = self._chords.limits(points.take(rest), best.current_limits[rest])
        share = self._chords.share_within(points.take(rest), limits, self.n_jobs) * len(rest) / len(sample.codes)
        return self._saves_work(len(queries.codes), n_first, share)

    def _filter_is_worth_it_within(self, queries: Queries, limits: np.ndarray) -> bool:
        """Filter for a sample of the queries, and estimate the cost of the search from it."""
        if queries.points is None:
            return False
        rows = np.arange(0, len(queries.codes), QUERIES_PER_SAMPLE)
        sample = queries.take(rows)
        left = self._within_reach(sample, self._bounds(sample), limits[rows])
        return self._saves_work(len(queries.codes), 0, left.mean())

    def _work_of_pairs(self, n_pairs: float) -> float:
        """Estimate the work of measuring pairs one at a time, the pose of each encoded anew."""
        return n_pairs * self._n_codes * (self.metric.encode_work + self.metric.measure_work)

    def _work_of_brute_force(self, n_queries: int) -> float:
        """Estimate the work of measuring all pairs of queries and poses, each pose encoded once."""
        work = self.metric.encode_work + n_queries * self.metric.measure_work
        return len(self.index.poses) * self._n_codes * work

    def _saves_work(self, n_queries: int, n_first: int, share: float) -> bool:
        """Return whether filter and refine takes less than brute force.

        n_first poses are measured for each query, and then this share of all pairs.
        """
        brute_force = self._work_of_brute_force(n_queries)
        work = self._work_of_pairs(n_queries * n_first) + FILTER_WORK * n_queries * len(self.index.poses)
        return work + share * brute_force < brute_force


class GeodesicSearch(Search):
    """A search under "geodesic", whose chords and straight lines leave few geodesics to solve.

    It may need memory for all chords between queries and poses at once.
    """

    def __init__(self, index: PoseIndex, n_jobs: int):
        super().__init__(index, index.metric, n_jobs)
        bounds = cast(Metric, self.metric.lower_bound()), cast(Metric, self.metric.upper_bound())
        self.chords, self.lines = (Search(index, metric, n_jobs) for metric in bounds)
        self.rounding = 0.0 if index.skeleton is None else ROUNDING * np.abs(index.skeleton.offsets).sum()

    def nearest(self, poses: np.ndarray, excluded: np.ndarray, k: int) -> Neighbors:
        """Find the k nearest poses of each query."""
        limits = np.full(len(poses), np.inf)
        if self.index.filter is not None:
            limits = self.lines.nearest(poses, excluded, k).distances.reshape(-1, k)[:, -1] + self.rounding
        best = Heaps.of(limits, k)
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
        best = Heaps.of(limits, max(1, np.bincount(near.queries, minlength=1).max()))
        self._solve(poses, near, best)
        parts.append(best.entries())
        return Neighbors.sort(parts)

    def _solve(self, poses: np.ndarray, chords: Neighbors, best: Heaps) -> None:
        """Solve the geodesics that may be among the best, in order of chord."""
        counts = np.bincount(chords.queries, minlength=len(poses))
        shape = len(poses), max(1, counts.max())
        indices, bounds = np.zeros(shape, np.int64), np.zeros(shape)
        ranks = np.arange(len(chords.queries)) - np.repeat(np.cumsum(counts) - counts, counts)
        indices[chords.queries, ranks] = chords.indices
        if self.index.filter is not None:
            bounds[chords.queries, ranks] = chords.distances - self.rounding
        codes = self.metric.encode_poses(poses, self.index.skeleton)
        for start in range(0, indices.shape[1], SOLVED_AT_ONCE):
            some, their_bounds = (
                np.ascontiguousarray(part[:, start : start + SOLVED_AT_ONCE]) for part in (indices, bounds)
            )
            candidates = Candidates(some, some, their_bounds, np.clip(counts - start, 0, SOLVED_AT_ONCE))
            self.refine(codes, candidates, best, 1)
