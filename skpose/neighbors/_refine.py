"""Measuring the poses that a filter has left, for many queries at once: single ones, or groups of them.

Every pose that is left for any query is encoded once: as a row of codes, from which those of a query are gathered into
lanes, or in groups that fill the lanes of float32. The metric may have a coarse bound (`Metric.coarse_bound`): it is
computed first, in float32, and what it leaves is measured.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from skpose._compiled.pose.candidates import Batch, Candidates, nearest_of_candidates
from skpose._compiled.pose.loops import encode_poses, in_lanes
from skpose._compiled.pose.nearest import Groups, bounds_of_groups, nearest_of_groups
from skpose._compiled.simd.lanes import lanes
from skpose._utils.parallel import TASKS_PER_JOB_UNEVEN, over_rows
from skpose.metrics import Metric
from skpose.metrics._matrix import ENCODED_AT_ONCE
from skpose.metrics._metric import CoarseBound
from skpose.neighbors._filter import FLOAT32, FilterPoints
from skpose.neighbors._index import LANES, PoseIndex, largest_of
from skpose.neighbors._nearest_so_far import NearestSoFar

FLOAT64 = np.dtype(np.float64)
# Angles, rad, up to which half of one has the digits that a coarse bound in float32 needs.
LARGEST_ANGLE = 1e6
CODES_AT_ONCE = 2**15  # poses that are encoded at once, where the index has more
MOST = 0.8  # of all pairs: where filter and coarse bound leave as many, the latter is not computed again


@dataclass(frozen=True)
class Queries:
    """Poses whose neighbours are searched."""

    codes: np.ndarray  # (n_queries, n_codes)
    coarse: np.ndarray  # (n_queries, n_codes) of the coarse bound, in float32; without one there are no codes
    excluded: np.ndarray  # (n_queries,) index of a pose that is not a neighbour, or -1
    points: FilterPoints | None  # where the filter is used

    def __len__(self) -> int:
        return len(self.codes)

    def take(self, rows: np.ndarray) -> "Queries":
        points = None if self.points is None else self.points.take(rows)
        return Queries(self.codes[rows], self.coarse[rows], self.excluded[rows], points)


class Refinement:
    """Measures poses of an index, under a metric that is measured directly.

    Attributes
    ----------
    measure : callable
        The metric's measure; up to a limit, where the search is not by brute force.
    coarse : CoarseBound or None
        The metric's coarse bound, None where it does not save anything.
    n_measured : int
        Pairs measured so far.
    """

    def __init__(self, index: PoseIndex, metric: Metric, n_jobs: int):
        self.index, self.metric, self.n_jobs = index, metric, n_jobs
        self.tree, self.steps = metric.tree_for(index.skeleton, FLOAT64), metric.steps
        self.measure, self.n_measured = metric.measure, 0
        self.coarse: CoarseBound | None = None
        if index.filter is not None:
            self.measure = metric.measure_within or metric.measure
            if (coarse := metric.coarse_bound) is not None:
                self._slack = coarse.slack(self.tree)
                self.coarse = coarse if np.isfinite(self._slack) and index.largest <= LARGEST_ANGLE else None

    def queries(self, poses: np.ndarray, excluded: np.ndarray, points: FilterPoints | None) -> Queries:
        """Return queries, encoded."""
        codes, coarse = self.metric.encode_poses(poses, self.index.skeleton), np.empty((len(poses), 0))
        if largest_of(poses) > LARGEST_ANGLE:
            self.coarse = None
        if self.coarse is not None:
            coarse = np.empty((len(poses), self.coarse.n_codes(self.tree)))
            encode_poses(poses, self.coarse.encode, self.tree, self.steps, coarse)
        return Queries(codes, coarse.astype(FLOAT32), excluded, points)

    def measure_groups(self, queries: Queries, numbers: np.ndarray, near: np.ndarray, best: NearestSoFar) -> None:
        """Measure some groups, given by their numbers, and keep the best.

        Near (n_queries, n_groups), of float32, is zero where a group is to be measured for a query, else infinite.
        """
        indices = self.index.groups[numbers].ravel()
        poses = self.index.poses[np.maximum(indices, 0)].astype(FLOAT64, copy=False)
        limits = best.current_limits
        slack = np.zeros(len(queries))
        if self.coarse is not None and np.isfinite(limits).any():
            slack[:] = self._slack
            self._bound(self.coarse, queries.coarse, poses, near)
            is_left = near <= (limits + slack)[:, np.newaxis]
            if is_left.mean() > MOST:
                self.coarse = None
            left = np.flatnonzero(is_left.any(axis=0))
            near, rows = np.ascontiguousarray(near[:, left]), (LANES * left[:, np.newaxis] + np.arange(LANES)).ravel()
            poses, indices = poses[rows], indices[rows]
        if len(indices) == 0:
            return
        codes = in_lanes(self.encode(poses, self.metric.encode, queries.codes))
        groups = Groups(codes, indices, near, slack)
        tail = queries.excluded, self.measure, self.tree, self.steps, best.heaps
        self.n_measured += sum(
            over_rows(
                lambda first, last: nearest_of_groups(queries.codes, groups, first, last, *tail),
                len(queries),
                self._work(near, queries.codes.shape[1]),
                self.n_jobs,
            )
        )

    def measure_candidates(self, queries: Queries, candidates: Candidates, best: NearestSoFar) -> None:
        """Measure the candidates of each query, and keep the best."""
        # Queries with as many candidates together, some of them at a time where the index has many poses.
        order = candidates.counts.argsort()
        n_codes = candidates.counts[order].cumsum() if len(self.index.poses) > CODES_AT_ONCE else np.zeros(len(order))
        for rows in np.split(order, np.flatnonzero(np.diff(n_codes // CODES_AT_ONCE)) + 1):
            some, best_of_some, most = queries.take(rows), best.take(rows), candidates.counts[rows[-1:]].max(initial=0)
            cut = [part[rows, :most] for part in (candidates.indices, candidates.rows, candidates.bounds)]
            left = Candidates(cut[0], cut[1], cut[2], candidates.counts[rows])
            if self.coarse is not None:
                left = self._sharpen(self.coarse, some, left, best_of_some.current_limits)
            left, poses = self._gather(left, best_of_some.current_limits)
            codes = self.encode(poses, self.metric.encode, some.codes)
            measured = self._loop_over(some.codes, codes, left, self.measure, self.tree, best_of_some, sort=False)
            self.n_measured += sum(n for n, *_ in measured)
            best.put(rows, best_of_some)

    def _sharpen(self, coarse: CoarseBound, queries: Queries, candidates: Candidates, limits: np.ndarray) -> Candidates:
        """Return the candidates whose coarse bounds are within limits, by these bounds."""
        coarse_limits = (limits + self._slack) * (1.0 + 2.0**-22)
        candidates, poses = self._gather(candidates, coarse_limits)
        codes = self.encode(poses, coarse.encode, queries.coarse)
        near = NearestSoFar(coarse_limits, candidates.indices.shape[1], FLOAT32)
        tree = self.metric.tree_for(self.index.skeleton, FLOAT32)
        self._loop_over(queries.coarse, codes, candidates, coarse.measure, tree, near, sort=True)
        _, bounds, indices, counts = near.heaps
        with np.errstate(invalid="ignore"):  # beyond the counts
            return Candidates(indices, indices, bounds.astype(FLOAT64) - self._slack, counts)

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

    def encode(self, poses: np.ndarray, encode: Any, like: np.ndarray) -> np.ndarray:
        """Return the codes of poses as rows, which are as those of queries are."""
        codes = np.empty((len(poses), like.shape[1]), like.dtype)

        def task(first: int, last: int) -> None:
            if codes.dtype == FLOAT64:
                encode_poses(poses[first:last], encode, self.tree, self.steps, codes[first:last])
                return
            for start in range(first, last, ENCODED_AT_ONCE):
                some = np.empty((min(ENCODED_AT_ONCE, last - start), codes.shape[1]))
                encode_poses(poses[start : start + len(some)], encode, self.tree, self.steps, some)
                codes[start : start + len(some)] = some

        over_rows(task, len(poses), codes.size * self.metric.encode_work, self.n_jobs)
        return codes

    def _loop_over(
        self,
        queries: np.ndarray,
        codes: np.ndarray,
        candidates: Candidates,
        measure: Any,
        tree: Any,
        best: NearestSoFar,
        *,
        sort: bool,
    ) -> list:
        """Measure candidates that are encoded."""
        width = lanes(codes.dtype)
        tail = measure, tree, self.steps, best.heaps
        return over_rows(
            lambda first, last: nearest_of_candidates(
                queries, codes, candidates, Batch(first, last, width, sort), *tail
            ),
            len(queries),
            float(candidates.counts.sum()) * codes.shape[1] * self.metric.measure_work,
            self.n_jobs,
            TASKS_PER_JOB_UNEVEN,
        )

    def _bound(self, coarse: CoarseBound, codes: np.ndarray, poses: np.ndarray, near: np.ndarray) -> None:
        """Replace zeros by coarse bounds."""
        groups = in_lanes(self.encode(poses, coarse.encode, codes))
        tail: Any = (coarse.measure, self.metric.tree_for(self.index.skeleton, FLOAT32), self.steps, near)
        limits = np.zeros(len(codes), FLOAT32)
        over_rows(
            lambda first, last: bounds_of_groups(codes, groups, first, last, limits, *tail),
            len(codes),
            self._work(near, codes.shape[1]) / 4,
            self.n_jobs,
        )

    def _work(self, near: np.ndarray, n_codes: int) -> float:
        return float(np.count_nonzero(near < np.inf)) * LANES * n_codes * self.metric.measure_work
