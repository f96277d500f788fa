"""Exact search of the nearest poses, by filter and refine.

The *filter* computes lower bounds of all distances, see `skpose.neighbors._filter`. Poses whose bound is within the
limit of a query are its *candidates*. To *refine* is to measure them: a distance decides what the bound leaves open.

A search for the k nearest takes the candidates with the least bounds in the whole index first and measures them in that
order, until no bound that is left is within the k-th least distance. For most queries that is all. The others, those
whose last candidate is still within reach, go over the whole index, one panel of poses after another: filter by the
k-th least distance so far, and refine. A search within a radius goes over the panels from the start.

Where the filter leaves most of a panel, the panel is measured whole, which costs less per pair; and a sample of the
queries is searched first to estimate whether the filter is worth its cost at all (`skpose.neighbors._cost`). So no
search costs much more than brute force, and memory holds no more than the bounds of one panel.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from skpose._compiled.loops import FLOAT64_LANES, in_lanes
from skpose._compiled.nearest import Batch, Candidates, Span, nearest_of_candidates_loop, nearest_of_tile_loop
from skpose._parallel.rows import TASKS_PER_JOB_UNEVEN, over_rows
from skpose.kinematics._tree import tree_of
from skpose.metrics._matrix import ENCODED_AT_ONCE
from skpose.metrics._registry import Metric
from skpose.neighbors._cost import CostModel, count_in_lanes, sample_of
from skpose.neighbors._filter import ChordFilter
from skpose.neighbors._index import PoseIndex
from skpose.neighbors._nearest_so_far import NearestSoFar
from skpose.neighbors._results import Evaluations, Neighbors

FLOAT64 = np.dtype(np.float64)
QUERIES = 1024  # searched for at once; memory is proportional to it
FIRST_CANDIDATES = 16  # of each query, in addition to 1.5 k


@dataclass(frozen=True)
class Queries:
    """Poses whose neighbours are searched."""

    codes: np.ndarray  # (n_queries, n_codes)
    excluded: np.ndarray  # (n_queries,) index of a pose that is not a neighbour, or -1
    points: Any  # FilterPoints, or None where the filter is not used

    def __len__(self) -> int:
        return len(self.codes)

    def take(self, rows: np.ndarray) -> "Queries":
        points = None if self.points is None else self.points.take(rows)
        return Queries(self.codes[rows], self.excluded[rows], points)


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
        self._measure = metric.measure
        if index.filter is not None and metric.measure_within is not None:
            self._measure = metric.measure_within
        self._tree = tree_of(index.skeleton if metric.needs_skeleton else None, FLOAT64)
        n_poses, n_dofs = index.poses.shape
        self._cost = CostModel(metric, metric.n_codes(self._tree, n_dofs), n_poses)
        self.n_measured = 0
        self.unconverged: list[tuple[int, float]] = []

    @property
    def evaluations(self) -> Evaluations:
        return Evaluations(self.n_measured, 0)

    def nearest(self, poses: np.ndarray, excluded: np.ndarray, k: int) -> Neighbors:
        """Find the k nearest poses of each query."""
        queries, n_first = self._queries(poses, excluded), FIRST_CANDIDATES + 3 * k // 2
        best, rest = NearestSoFar(np.full(len(queries), np.inf), k), np.arange(len(queries))
        filtered = self._filter_is_worth_it_for_nearest(queries, n_first, k)
        if filtered:
            rest = self._measure_first(queries, n_first, best)
        if len(rest):
            queries_left, best_of_rest = queries.take(rest), NearestSoFar(best.current_limits[rest], k)
            for start, stop in self._panels(len(rest)):
                self._search_panel(queries_left, start, stop, filtered, best_of_rest)
            best.put(rest, best_of_rest)
        return Neighbors(*best.sorted_entries())

    def within(self, poses: np.ndarray, excluded: np.ndarray, limits: ArrayLike, *, measured: bool = True) -> Neighbors:
        """Find all poses that are no further away from a query than its limit; distances are always measured."""
        limits, parts = np.array(np.broadcast_to(limits, len(poses))), []
        queries = self._queries(poses, excluded)
        filtered = self._filter_is_worth_it_within(queries, limits)
        for start, stop in self._panels(len(queries)):
            found = NearestSoFar(limits, stop - start)
            self._search_panel(queries, start, stop, filtered, found)
            parts.append(found.entries())
        return Neighbors.sorted(parts)

    def refine(
        self, codes: np.ndarray, candidates: Candidates, best: NearestSoFar, at_once: int = FLOAT64_LANES
    ) -> None:
        """Measure the candidates of each query in order, but for those whose bound shows that they are not kept."""
        index, loop = self.index, nearest_of_candidates_loop(self.index.poses.dtype)
        tail = self.metric.encode, self._measure, self._tree, index.steps, best.heaps
        for n_measured, n_unconverged, worst in over_rows(
            lambda first, last: loop(codes, index.poses, candidates, Batch(first, last, at_once), *tail),
            len(codes),
            self._cost.work_of_pairs(candidates.counts.sum()),
            self.n_jobs,
            TASKS_PER_JOB_UNEVEN,
        ):
            self.n_measured += n_measured
            self.unconverged.append((n_unconverged, worst))

    @property
    def _chords(self) -> ChordFilter:
        """The filter, for callers that know that there is one."""
        return cast(ChordFilter, self.index.filter)

    def _queries(self, poses: np.ndarray, excluded: np.ndarray) -> Queries:
        """Return the queries, with points of the filter if there is one and work enough to use it."""
        codes = self.metric.encoded(poses, self.index.skeleton, self.index.steps)
        used = self.index.filter is not None and self._cost.filter_is_worth_a_trial(len(poses))
        return Queries(codes, excluded, self._chords.points(poses) if used else None)

    def _filter(self, queries: Queries, limits: np.ndarray, start: int, stop: int, capacity: int) -> NearestSoFar:
        """Find the poses start:stop whose lower bound is within a limit."""
        points, excluded = queries.points, queries.excluded
        return self._chords.within(points, excluded, limits, start, stop, capacity, self.n_jobs)

    def _measure_first(self, queries: Queries, n_first: int, best: NearestSoFar) -> np.ndarray:
        """Measure the poses with the least bounds in the whole index; return the queries that may need more."""
        near = self._filter(queries, np.full(len(queries), np.inf), 0, len(self.index.poses), n_first)
        near.sort_by_value()
        candidates = self._chords.candidates(queries.points, near)
        self.refine(queries.codes, candidates, best)
        return np.flatnonzero(candidates.bounds[:, -1] <= best.current_limits)

    def _search_panel(self, queries: Queries, start: int, stop: int, filtered: bool, best: NearestSoFar) -> None:
        """Search the poses start:stop, by filter and refine or by brute force."""
        if filtered:
            near = self._filter(queries, best.current_limits, start, stop, stop - start)
            if self._cost.refine_is_worth_it(near.heaps.counts, stop - start):
                self.refine(queries.codes, self._chords.candidates(queries.points, near), best)
                return
        self._measure_tile(queries, start, stop, best)

    def _filter_is_worth_it_for_nearest(self, queries: Queries, n_first: int, k: int) -> bool:
        """Search for the k nearest of a sample of the queries, and estimate the cost of the search from it."""
        if queries.points is None or 4 * n_first > len(self.index.poses):
            return False
        sample = queries.take(sample_of(len(queries)))
        best = NearestSoFar(np.full(len(sample), np.inf), k)
        rest = self._measure_first(sample, n_first, best)
        n_candidates = n_first * len(sample) + self._n_candidates(sample.take(rest), best.current_limits[rest])
        return self._cost.filter_is_worth_it(len(queries), len(sample), n_candidates)

    def _filter_is_worth_it_within(self, queries: Queries, limits: np.ndarray) -> bool:
        """Filter for a sample of the queries, and estimate the cost of the search from it."""
        if queries.points is None:
            return False
        rows = sample_of(len(queries))
        n_candidates = self._n_candidates(queries.take(rows), limits[rows])
        return self._cost.filter_is_worth_it(len(queries), len(rows), n_candidates)

    def _n_candidates(self, queries: Queries, limits: np.ndarray) -> int:
        """Count the candidates that the filter leaves in the whole index, in full lanes."""
        if len(queries) == 0:
            return 0
        return sum(
            count_in_lanes(self._filter(queries, limits, start, stop, stop - start).heaps.counts)
            for start, stop in self._panels(len(queries))
        )

    def _panels(self, n_queries: int) -> Iterator[tuple[int, int]]:
        """Return parts of the index, which are larger for fewer queries."""
        n_poses = len(self.index.poses)
        return itertools.pairwise([*range(0, n_poses, ENCODED_AT_ONCE * max(1, QUERIES // max(1, n_queries))), n_poses])

    def _measure_tile(self, queries: Queries, start: int, stop: int, best: NearestSoFar) -> None:
        """Measure all of the poses start:stop."""
        index, loop = self.index, nearest_of_tile_loop(FLOAT64)
        for left, right in itertools.pairwise([*range(start, stop, ENCODED_AT_ONCE), stop]):
            groups = in_lanes(self.metric.encoded(index.poses[left:right], index.skeleton, index.steps))
            tail = queries.excluded, self._measure, self._tree, index.steps, best.heaps

            def task(first, last, left=left, right=right, groups=groups, tail=tail):
                return loop(queries.codes, groups, Span(first, last, left, right), *tail)

            work = self._cost.work_of_tile(len(queries), right - left)
            self.n_measured += sum(over_rows(task, len(queries), work, self.n_jobs))
