"""Exact search of nearest poses: a bound tells what cannot be near, the rest is measured.

A search for the k nearest looks at the `Screen` once for the most promising poses of each query and measures them in
that order, until none that is left can be among the k nearest. Where the last promising pose is too far away already,
that is all. The other queries sweep over the index, a panel of poses after the other: look at who may be nearer than
the k-th so far, and measure those. A search within a radius sweeps from the start.

Where looking leaves most of a panel, the panel is measured whole, which costs less per pair, and so are the next ones
without a look. So no search costs much more than brute force, and no more is held at once than a panel's bounds.

A geodesic is solved only where its interval, from the chord to the length of the straight line, can change the answer:
no k-th nearest is further away than the k-th shortest line, so what is to be solved are the poses within that chord, in
order of chord, until the next chord is longer than the k-th shortest geodesic so far.
"""

import functools
import itertools
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from sklearn.utils import gen_batches

from skpose import _loops
from skpose._kernels import Steps
from skpose._nearest import Kept, keep_nearest_loop, keep_nearest_of_loop
from skpose._screen import FLOAT32, Screen
from skpose._threads import in_threads
from skpose._tree import tree_of
from skpose.metrics import METRICS, Metric
from skpose.pairwise import PANEL, TASKS_PER_JOB
from skpose.skeleton import Skeleton

FLOAT64 = np.dtype(np.float64)
AT_ONCE = _loops.FLOAT64_LANES
QUERIES = 1024  # searched for at once
FIRST_LOOK = 16  # promising poses, besides 1.5 k
WHOLE_PANELS = 7  # measured without a look after one where looking did not pay
LOOKS_PER_TASK = 50_000_000  # so that Ctrl-C is heard
MAX_CHORDS = 2**24  # held at once
ABOUT = 1.0 + 1e-12  # two ways to compute one chord differ by less


class Evaluations(NamedTuple):
    """What a search cost.

    Attributes
    ----------
    lengths : int
        Pairs whose distance was measured; for "geodesic", along the straight line.
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
    def of(cls, parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> "Neighbors":
        queries, indices, distances = (np.concatenate(part) for part in zip(*parts, strict=True))
        order = np.lexsort((indices, distances, queries))
        return cls(queries[order], indices[order], distances[order])


class Queries(NamedTuple):
    """Poses whose neighbours are searched."""

    codes: np.ndarray  # (n_queries, n_codes)
    own: np.ndarray  # (n_queries,) index of a pose that does not count, or -1
    coordinates: np.ndarray  # on the screen, if there is one, and the slack of their bounds
    slack: np.ndarray


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

    def search(self, n_jobs: int) -> "Search | GeodesicSearch":
        """A new search of the index."""
        if self.metric == "geodesic":
            return GeodesicSearch(self, n_jobs)
        return Search(self, METRICS[self.metric], n_jobs)


class Search:
    """A search of an index, under a metric that is measured at once.

    Attributes
    ----------
    n_measured : int
        Pairs measured so far.
    doubts : list of (int, float)
        How many distances are in doubt, and by how much at most.
    """

    def __init__(self, index: PoseIndex, metric: Metric, n_jobs: int):
        self.index, self.metric, self.n_jobs = index, metric, n_jobs
        self.n_measured = 0
        self.doubts: list[tuple[int, float]] = []

    @property
    def evaluations(self) -> Evaluations:
        return Evaluations(self.n_measured, 0)

    def nearest(self, poses: np.ndarray, own: np.ndarray, k: int) -> Neighbors:
        """The k nearest of each query."""
        parts = []
        for rows in gen_batches(len(poses), QUERIES):
            queries = self.queries(poses[rows], own[rows])
            best, left = Kept(np.full(len(queries.own), np.inf), k), np.arange(len(queries.own))
            n_first = FIRST_LOOK + 3 * k // 2
            if self.index.screen is not None and 4 * n_first <= len(self.index.poses):
                left = self._first_look(queries, n_first, best)
            if len(left):
                rest = Kept(best.reach[left], k)
                for _ in self._sweep(Queries(*(field[left] for field in queries)), lambda _, rest=rest: rest):
                    pass
                best.put(left, rest)
            parts.append(best.entries(rows.start))
        return Neighbors.of(parts)

    def within(self, poses: np.ndarray, own: np.ndarray, limits: np.ndarray, *, measured: bool = True) -> Neighbors:
        """All poses that are no further away from a query than its limit; their distances come along."""
        parts = []
        for rows in gen_batches(len(poses), QUERIES):
            queries = self.queries(poses[rows], own[rows])
            sweep = self._sweep(queries, lambda n_poses, rows=rows: Kept(limits[rows], n_poses))
            parts += [near.entries(rows.start) for near in sweep]
        return Neighbors.of(parts)

    def queries(self, poses: np.ndarray, own: np.ndarray) -> Queries:
        codes = self.metric.encoded(poses, self.index.skeleton, self.index.steps)
        no_screen = np.empty((len(poses), 0)), np.empty(len(poses))
        return Queries(codes, own, *(no_screen if self.index.screen is None else self.index.screen.of(poses)))

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
        before = codes, index.poses, candidates, bounds, n_candidates
        after = at_once, self.metric.encode, self.metric.measure, tree, index.steps, *best.arrays
        pairs_per_row = max(1, min(best.values.shape[1], n_candidates.max(initial=1)))
        for n_measured, n_doubtful, worst in self._over_rows(
            lambda first, last: loop(*before, first, last, *after),
            len(codes),
            pairs_per_row,
            self.metric.pairs_per_task,
        ):
            self.n_measured += n_measured
            self.doubts.append((n_doubtful, worst))

    def _first_look(self, queries: Queries, n_first: int, best: Kept) -> np.ndarray:
        """Measure the most promising poses of the whole index; return the queries for which that may not be all."""
        promising = self._look(queries, np.full(len(queries.own), np.inf), 0, len(self.index.poses), n_first)
        order = promising.values.argsort(axis=1)
        promising.values, promising.found = (
            np.take_along_axis(part, order, axis=1) for part in (promising.values, promising.found)
        )
        bounds = self._bounds(queries, promising)
        self.refine(queries.codes, promising.found, bounds, promising.kept, best)
        return np.flatnonzero(bounds[:, -1] <= best.reach)

    def _sweep(self, queries: Queries, keeper: Callable[[int], Kept]) -> Iterator[Kept]:
        """Go over the index in panels; yield what was found, in what the keeper gave for so many poses."""
        n_poses, n_whole = len(self.index.poses), 0
        step = PANEL * (QUERIES // len(queries.own))
        for start in range(0, n_poses, step):
            stop = min(start + step, n_poses)
            best = keeper(stop - start)
            near = None
            if n_whole:
                n_whole -= 1
            elif self.index.screen is not None and np.isfinite(best.reach).any():
                near = self._look(queries, best.reach, start, stop, stop - start)
                if not self._pays(near):
                    near, n_whole = None, WHOLE_PANELS
            if near is None:
                self._measure_whole(queries, start, stop, best)
            else:
                self.refine(queries.codes, near.found, self._bounds(queries, near), near.kept, best)
            yield best

    def _pays(self, near: Kept) -> bool:
        """Whether to measure these one by one costs less than to measure their panel whole."""
        n_queries, n_poses = near.values.shape
        n_one_by_one = (-(-near.kept // AT_ONCE) * AT_ONCE).sum()
        return n_one_by_one * (self.metric.encode_cost + 1) < n_poses * (self.metric.encode_cost + n_queries)

    def _look(self, queries: Queries, limits: np.ndarray, start: int, stop: int, room: int) -> Kept:
        """Those of the poses start:stop whose bound is within a limit; the least if there is no room for all."""
        screen, angle = self.index.screen, METRICS["angle"]
        with np.errstate(over="ignore"):
            limits = np.minimum(limits / screen.scale + queries.slack, np.finfo(FLOAT32).max)
        near = Kept(limits, room, FLOAT32)
        loop, tree = keep_nearest_loop(FLOAT32), tree_of(None, FLOAT32)
        tail = start, stop, queries.own, angle.measure, tree, Steps.of(1, wrap=False), *near.arrays
        blocks = screen.part(start, stop)
        self._over_rows(
            lambda first, last: loop(queries.coordinates, blocks, first, last, *tail),
            len(limits),
            stop - start,
            LOOKS_PER_TASK,
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
            blocks = _loops.in_lanes(self.metric.encoded(index.poses[first:last], index.skeleton, index.steps))
            head = queries.codes, blocks
            tail = first, last, queries.own, self.metric.measure, tree, index.steps, *best.arrays
            self._over_rows(
                lambda *rows, head=head, tail=tail: loop(*head, *rows, *tail),
                len(queries.own),
                last - first,
                self.metric.pairs_per_task,
            )
        self.n_measured += len(queries.own) * (stop - start)

    def _tree(self, dtype):
        return tree_of(self.index.skeleton if self.metric.needs_skeleton else None, dtype)

    def _over_rows(self, task, n_rows: int, pairs_per_row: int, pairs_per_task: int) -> list:
        """Call the task for all rows, some at a time, in threads."""
        step = max(1, pairs_per_task // pairs_per_row)
        if self.n_jobs > 1:
            step = min(step, -(-n_rows // (TASKS_PER_JOB * self.n_jobs)))
        return in_threads(
            (functools.partial(task, rows.start, rows.stop) for rows in gen_batches(n_rows, step)), self.n_jobs
        )


class GeodesicSearch:
    """A search under "geodesic", for which a chord and a straight line leave as little to solve as they can."""

    def __init__(self, index: PoseIndex, n_jobs: int):
        self.index = index
        self.chords, self.lines, self.geodesics = (
            Search(index, METRICS[metric], n_jobs) for metric in ("position", "spatial", "geodesic")
        )

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
                limits = ABOUT * self.lines.nearest(poses[rows], own[rows], k).distances.reshape(-1, k)[:, -1]
            chords = self.chords.within(poses[rows], own[rows], limits)
            parts.append(self._solve(poses[rows], chords, Kept(limits, k)).entries(rows.start))
        return Neighbors.of(parts)

    def within(self, poses: np.ndarray, own: np.ndarray, limits: np.ndarray, *, measured: bool = True) -> Neighbors:
        """All poses that are no further away from a query than its limit.

        If they need not be measured, the distance of those whose straight line is short enough is the line's.
        """
        parts = []
        for rows in self._batches(len(poses)):
            near = self.chords.within(poses[rows], own[rows], ABOUT * limits[rows])
            if not measured:
                lines = self.lines.within(poses[rows], own[rows], limits[rows])
                parts.append((lines.queries + rows.start, lines.indices, lines.distances))
                size = len(self.index.poses)
                open_ = ~np.isin(near.queries * size + near.indices, lines.queries * size + lines.indices)
                near = Neighbors(*(field[open_] for field in near))
            room = np.bincount(near.queries, minlength=1).max()
            parts.append(self._solve(poses[rows], near, Kept(limits[rows], max(1, room))).entries(rows.start))
        return Neighbors.of(parts)

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
            bounds[place] = chords.distances / ABOUT
        codes = METRICS["geodesic"].encoded(poses, self.index.skeleton, self.index.steps)
        self.geodesics.refine(codes, candidates, bounds, counts, best, at_once=1)
        return best
