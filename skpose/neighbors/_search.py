"""Exact search of nearest poses: a bound tells what cannot be near, the rest is measured.

A search for the k nearest looks at the `Screen` once for the most promising poses of each query and measures them in
that order, until none that is left can be among the k nearest. Where the last promising pose is too far away already,
that is all. The other queries sweep over the index, a panel of poses after the other: look at who may be nearer than
the k-th so far, and measure those. A search within a radius sweeps from the start.

Where looking leaves most of a panel, the panel is measured whole, which costs less per pair; and a few queries go ahead
of the others to tell whether looking pays at all. So no search costs much more than brute force, and no more is held at
once than a panel's bounds.
"""

import functools
import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from sklearn.utils import gen_batches

from skpose._compiled import loops
from skpose._compiled.nearest import Batch, Candidates, Kept, Span, keep_nearest_loop, keep_nearest_of_loop
from skpose._compiled.tree import Steps
from skpose._parallel.tasks import LITTLE_WORK, TASKS_PER_JOB, WORK_PER_TASK
from skpose._parallel.threads import in_threads
from skpose.kinematics._tree import tree_of
from skpose.metrics._matrix import PANEL
from skpose.metrics._registry import METRICS, Metric
from skpose.neighbors._filter import FLOAT32, Screen
from skpose.skeleton import Skeleton

FLOAT64 = np.dtype(np.float64)
AT_ONCE = loops.FLOAT64_LANES
QUERIES = 1024  # searched for at once; memory goes with it
FIRST_LOOK = 16  # promising poses, besides 1.5 k
PROBE = 64  # of so many queries, one tells whether looking pays
# Work, in the unit of `Metric.measure_work`:
LOOK = 14  # of a look at a pair
NOT_WORTH_A_LOOK = 400_000_000
UNEVEN = 16  # tasks per job where some queries have many more candidates than others


class Evaluations(NamedTuple):
    """What a search cost.

    Attributes
    ----------
    lengths : int
        Pairs whose distance was measured and not only bounded; for "geodesic", along the straight line.
    geodesics : int
        Pairs whose geodesic was sought.
    """

    lengths: int
    geodesics: int


class Neighbors(NamedTuple):
    """Neighbours of several queries, sorted by query, distance and index."""

    queries: np.ndarray
    indices: np.ndarray
    distances: np.ndarray

    @classmethod
    def joined(cls, parts: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> "Neighbors":
        """Parts that are sorted already."""
        return cls(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    @classmethod
    def sorted(cls, parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> "Neighbors":
        """Parts in any order."""
        queries, indices, distances = cls.joined(parts)
        order = queries.argsort(kind="stable")
        for row in np.split(order, np.flatnonzero(np.diff(queries[order])) + 1):
            row[:] = row[np.lexsort((indices[row], distances[row]))]
        return cls(queries[order], indices[order], distances[order])


@dataclass(frozen=True)
class Queries:
    """Poses whose neighbours are searched."""

    codes: np.ndarray  # (n_queries, n_codes)
    own: np.ndarray  # (n_queries,) index of a pose that does not count, or -1
    coordinates: np.ndarray  # (n_queries, n_coordinates) on the screen, if at all
    slack: np.ndarray  # (n_queries,) of their bounds

    def __len__(self) -> int:
        return len(self.own)

    @property
    def on_screen(self) -> bool:
        return self.coordinates.shape[1] > 0

    def take(self, rows: np.ndarray) -> "Queries":
        return Queries(self.codes[rows], self.own[rows], self.coordinates[rows], self.slack[rows])


class PoseIndex:
    """Poses to search under a metric, and what to know of them.

    Attributes
    ----------
    screen : Screen or None
        None is brute force: asked for, or where nothing bounds the metric.
    evaluations : Evaluations
        What the last search cost.
    """

    def __init__(self, poses: np.ndarray, skeleton: Skeleton | None, metric: str, steps: Steps, *, brute: bool):
        self.poses, self.skeleton, self.metric, self.steps = np.ascontiguousarray(poses), skeleton, metric, steps
        self.screen, self.evaluations = None, Evaluations(0, 0)
        chosen = METRICS[metric]
        turned = chosen.wraps is False and steps.half_turn < np.inf  # while the bound takes differences as they are
        if not (brute or turned or chosen.bound is None):
            screen = Screen(self.poses, chosen.bound, skeleton, steps)
            self.screen = screen if np.isfinite(screen.norm) else None


class Search:
    """A search of an index for no more than QUERIES poses at once, under a metric that is measured at once.

    Attributes
    ----------
    n_measured : int
        Pairs measured so far.
    unconverged : list of (int, float)
        How many distances are in doubt, and by how much at most.
    """

    def __init__(self, index: PoseIndex, metric: Metric, n_jobs: int):
        self.index, self.metric, self.n_jobs = index, metric, n_jobs
        self.measure = metric.measure
        if index.screen is not None and metric.measure_within is not None:
            self.measure = metric.measure_within
        self.n_codes = metric.n_codes(self._tree(FLOAT64), index.poses.shape[1])
        self.n_measured = 0
        self.unconverged: list[tuple[int, float]] = []

    @property
    def evaluations(self) -> Evaluations:
        return Evaluations(self.n_measured, 0)

    def nearest(self, poses: np.ndarray, own: np.ndarray, k: int) -> Neighbors:
        """The k nearest of each query."""
        queries, n_first = self._queries(poses, own), FIRST_LOOK + 3 * k // 2
        best, left = Kept(np.full(len(queries), np.inf), k), np.arange(len(queries))
        looking = queries.on_screen and 4 * n_first <= len(self.index.poses)
        if looking:
            some = queries.take(np.arange(0, len(queries), PROBE))
            probe = Kept(best.limits[: len(some)], k)
            far = self._first_look(some, n_first, probe)
            looking = self._pays(queries, some.take(far), probe.reach[far], n_first * len(some))
        if looking:
            left = self._first_look(queries, n_first, best)
        if len(left):
            rest = Kept(best.reach[left], k)
            for _ in self._sweep(queries.take(left), looking, lambda _: rest):
                pass
            best.put(left, rest)
        return Neighbors(*best.sorted())

    def within(self, poses: np.ndarray, own: np.ndarray, limits: ArrayLike, *, measured: bool = True) -> Neighbors:
        """All poses that are no further away from a query than its limit; their distances come along."""
        limits = np.array(np.broadcast_to(limits, len(poses)))
        queries, some = self._queries(poses, own), np.arange(0, len(poses), PROBE)
        looking = queries.on_screen and self._pays(queries, queries.take(some), limits[some])
        return Neighbors.sorted([near.entries() for near in self._sweep(queries, looking, lambda n: Kept(limits, n))])

    def _queries(self, poses: np.ndarray, own: np.ndarray) -> Queries:
        """The queries, on the screen if there is one and work enough to look at it."""
        codes = self.metric.encoded(poses, self.index.skeleton, self.index.steps)
        if self.index.screen is None or self._whole(len(poses), len(self.index.poses)) < NOT_WORTH_A_LOOK:
            return Queries(codes, own, np.empty((len(poses), 0)), np.empty(len(poses)))
        return Queries(codes, own, *self.index.screen.of(poses))

    def refine(
        self,
        codes: np.ndarray,
        candidates: np.ndarray,
        bounds: np.ndarray,
        n_candidates: np.ndarray,
        best: Kept,
        at_once: int = AT_ONCE,
    ) -> None:
        """Measure candidates of each query in order, but for those whose bound says that they will not be kept."""
        index = self.index
        loop, tree = keep_nearest_of_loop(index.poses.dtype), self._tree(FLOAT64)
        before = codes, index.poses, Candidates(candidates, bounds, n_candidates)
        after = self.metric.encode, self.measure, tree, index.steps, best.heaps
        for n_measured, n_unconverged, worst in self._over_rows(
            lambda first, last: loop(*before, Batch(first, last, at_once), *after),
            len(codes),
            self._one_by_one(n_candidates.sum()),
            UNEVEN,
        ):
            self.n_measured += n_measured
            self.unconverged.append((n_unconverged, worst))

    def _first_look(self, queries: Queries, n_first: int, best: Kept) -> np.ndarray:
        """Measure the most promising poses of the whole index; return the queries for which that may not be all."""
        promising = self._look(queries, np.full(len(queries), np.inf), 0, len(self.index.poses), n_first)
        order = promising.values.argsort(axis=1)
        promising.values, promising.found = (
            np.take_along_axis(part, order, axis=1) for part in (promising.values, promising.found)
        )
        bounds = self._bounds(queries, promising)
        self.refine(queries.codes, promising.found, bounds, promising.kept, best)
        return np.flatnonzero(bounds[:, -1] <= best.reach)

    def _sweep(self, queries: Queries, looking: bool, keeper: Callable[[int], Kept]) -> Iterator[Kept]:
        """Go over the index in panels; yield what was found, in what the keeper gave for so many poses."""
        for start, stop in self._panels(len(queries)):
            best, near = keeper(stop - start), None
            if looking:
                near = self._look(queries, best.reach, start, stop, stop - start)
                if self._one_by_one(_in_lanes(near)) > self._whole(len(queries), stop - start):
                    near = None
            if near is None:
                self._measure_whole(queries, start, stop, best)
            else:
                self.refine(queries.codes, near.found, self._bounds(queries, near), near.kept, best)
            yield best

    def _panels(self, n_queries: int) -> Iterator[tuple[int, int]]:
        """Parts of the index, the larger the fewer queries there are."""
        n_poses = len(self.index.poses)
        return itertools.pairwise([*range(0, n_poses, PANEL * max(1, QUERIES // max(1, n_queries))), n_poses])

    def _pays(self, queries: Queries, some: Queries, limits: np.ndarray, n_measured: int = 0) -> bool:
        """Whether to look takes less than to measure all, as told by some of the queries, whose limits are known.

        For these so many pairs were measured before.
        """
        for start, stop in self._panels(len(some)) if len(some) else ():
            n_measured += _in_lanes(self._look(some, limits, start, stop, stop - start))
        n_poses, share = len(self.index.poses), -(-len(queries) // PROBE) / len(queries)
        looking = self._one_by_one(n_measured) / share + 2 * LOOK * len(queries) * n_poses
        return looking < self._whole(len(queries), n_poses)

    def _one_by_one(self, n_pairs: int) -> float:
        """The work of measuring so many pairs of poses, each by itself."""
        return n_pairs * self.n_codes * (self.metric.encode_work + self.metric.measure_work)

    def _whole(self, n_queries: int, n_poses: int) -> float:
        """The work of measuring so many poses for all queries."""
        return n_poses * self.n_codes * (self.metric.encode_work + n_queries * self.metric.measure_work)

    def _look(self, queries: Queries, limits: np.ndarray, start: int, stop: int, room: int) -> Kept:
        """Those of the poses start:stop whose bound is within a limit; the least if there is no room for all."""
        screen, angle = self.index.screen, METRICS["angle"]
        with np.errstate(over="ignore"):
            limits = np.minimum(limits / screen.scale + queries.slack, np.finfo(FLOAT32).max)
        near = Kept(limits, room, FLOAT32)
        loop, tree = keep_nearest_loop(FLOAT32), tree_of(None, FLOAT32)
        tail = queries.own, angle.measure, tree, Steps.of(1, wrap=False), near.heaps
        blocks = screen.part(start, stop)
        self._over_rows(
            lambda first, last: loop(queries.coordinates, blocks, Span(first, last, start, stop), *tail),
            len(limits),
            LOOK * len(limits) * (stop - start),
        )
        return near

    def _bounds(self, queries: Queries, near: Kept) -> np.ndarray:
        """What a look said, without its rounding."""
        n = near.kept.max(initial=0)
        with np.errstate(invalid="ignore"):  # in the room that is left
            return (near.values[:, :n] - queries.slack[:, np.newaxis]) * self.index.screen.scale

    def _measure_whole(self, queries: Queries, start: int, stop: int, best: Kept) -> None:
        """Measure the poses start:stop, all of them."""
        index = self.index
        loop, tree = keep_nearest_loop(FLOAT64), self._tree(FLOAT64)
        for first, last in itertools.pairwise([*range(start, stop, PANEL), stop]):
            blocks = loops.in_lanes(self.metric.encoded(index.poses[first:last], index.skeleton, index.steps))
            tail = queries.own, self.measure, tree, index.steps, best.heaps

            def task(top, bottom, first=first, last=last, blocks=blocks, tail=tail):
                return loop(queries.codes, blocks, Span(top, bottom, first, last), *tail)

            self.n_measured += sum(self._over_rows(task, len(queries), self._whole(len(queries), last - first)))

    def _tree(self, dtype):
        return tree_of(self.index.skeleton if self.metric.needs_skeleton else None, dtype)

    def _over_rows(self, task: Callable, n_rows: int, work: float, tasks_per_job: int = TASKS_PER_JOB) -> list:
        """Call the task, of so much work, for some rows at a time; in threads if that is worth their while."""
        n_jobs = self.n_jobs if work > LITTLE_WORK else 1
        n_tasks = max(work / WORK_PER_TASK, min(work / LITTLE_WORK, tasks_per_job * n_jobs) if n_jobs > 1 else 1)
        step = max(1, int(n_rows / n_tasks))
        tasks = (functools.partial(task, rows.start, rows.stop) for rows in gen_batches(n_rows, step))
        return in_threads(tasks, n_jobs)


def _in_lanes(near: Kept) -> int:
    """Pairs to measure if as many as there are lanes take as long as one."""
    return int((-(-near.kept // AT_ONCE) * AT_ONCE).sum())
