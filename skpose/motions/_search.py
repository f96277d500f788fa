"""Exact search of the nearest motions, by filter and refine.

The bounds of `skpose.motions._index` are taken in order of their cost. The ends bound all motions of the index. The
motions that come first are bounded by their frames, and the k first of these are aligned: the k-th distance is a limit.
Motions within the limit by their ends are bounded by boxes, those still within it by frames, and the rest are aligned
in the order of their bounds, cell by cell, until no bound is within the k-th distance so far.

`find` answers many queries, in threads or workers of joblib.
"""

import bisect
from contextlib import closing
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import gen_batches

from skpose._compiled.pose import loops
from skpose._compiled.warping.paths import Paths
from skpose._compiled.warping.within import Ends, Within, warp_within
from skpose._utils.backends import from_workers, in_processes
from skpose._utils.parallel import TASKS_PER_WORKER, in_threads
from skpose._utils.progress import progress
from skpose.motions._index import Bounds, SequenceIndex, sums_to_end
from skpose.motions._inputs import Sequences
from skpose.motions._matrix import MotionMatrix, share_of_band, work_per_cell

FLOAT64 = np.dtype(np.float64)
FIRST_MOTIONS = 48  # bounded by their frames before there is a limit, in addition to 2 k
MOST_CELLS = 2**24  # whose bounds of the rest of a path are stored, 128 MB
ROUNDING = 1e-9  # relative, of sums that are compared with a limit
NO_BOUNDS = np.zeros((0, 0))
LARGEST = 1e300  # a limit that no sum exceeds
FEWEST_QUERIES = 4  # in a task
MOST_DISTANCES = 2**22  # of brute force, in memory at once
WORTH_FILTERING = 2e7  # work of brute force for a query, 4 ms: a search takes some milliseconds in any case
FEWEST_PER_NEIGHBOR = 5  # motions: with fewer, most have to be aligned, which is faster all at once
WORTH_SENDING = 1e8  # pairs of frames; geodesics always are


class Aligner:
    """Sums of distances under the metric of an index, up to a limit; counts the cells that it measures."""

    def __init__(self, index: SequenceIndex, paths: Paths):
        self.index, self.paths, self.metric = index, paths, index.metric
        self._tree = self.metric.tree_for(index.skeleton, FLOAT64)
        self.n_cells = 0
        self.unconverged: list[tuple[int, float]] = []

    def encode(self, poses: np.ndarray) -> np.ndarray:
        return self.metric.encode_poses(poses, self.index.skeleton)

    def ends(self, codes: np.ndarray, start: int, stop: int, bounds: Bounds | None, limit: float) -> Ends:
        """The paths that end at the frames start:stop; sums above the limit are infinite."""
        remaining = NO_BOUNDS
        if bounds is not None and np.isfinite(limit) and len(codes) * (stop - start) <= MOST_CELLS:
            remaining = sums_to_end(bounds.of_frames(start, stop), self.paths)
        return self._ends(codes, start, stop, Within(limit * (1.0 + ROUNDING), remaining))

    def path_sum(self, codes: np.ndarray, start: int, path: np.ndarray) -> float:
        """The sum of the distances along one path to the frames from `start` on: no other cell is within reach."""
        remaining = np.full(path[-1] + 1, np.inf)
        remaining[tuple(path.T)] = 0.0
        ends = self._ends(codes, start, start + remaining.shape[1], Within(LARGEST, remaining))
        return float(ends.sums[-1])

    def _ends(self, codes: np.ndarray, start: int, stop: int, within: Within) -> Ends:
        n_columns = stop - start
        ends = Ends(np.empty(n_columns), np.empty(n_columns, np.int64))
        lanes = loops.in_lanes(self.encode(self.index.sequences.poses[start:stop]))
        n_cells, *unconverged = warp_within(
            codes, lanes, self.paths, within, self.metric.measure, self._tree, self.metric.steps, ends
        )
        self.n_cells += n_cells
        self.unconverged.append(tuple(unconverged))
        return ends


class MotionSearch:
    """A search of an index with a filter for the motions nearest to one motion at a time."""

    def __init__(self, index: SequenceIndex, window: float | None):
        self.index, self.paths = index, Paths.of(window)
        self.aligner = Aligner(index, self.paths)
        # The length of the straight line is an upper bound at a thousandth of the cost, as `measure_geodesic` returns
        # the shorter of the two. So k motions are within the k-th of these.
        above = index.metric.upper_bound()
        self._lines = None if above is None else MotionSearch(index.under(above), window)

    def nearest(self, query: np.ndarray, excluded: int, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Distances and indices of the k nearest motions, by distance and then by index."""
        bounds, codes = Bounds(self.index, query), self.aligner.encode(query)
        n_frames, starts = len(query) + self.index.sequences.lengths, self.index.sequences.starts
        best: list[tuple[float, int]] = []
        start = np.inf if self._lines is None else self._lines.nearest(query, excluded, k)[0][-1] * (1.0 + ROUNDING)

        def limit() -> float:
            return best[k - 1][0] if len(best) >= k else start

        def align(motions: np.ndarray, by_frames: np.ndarray) -> None:
            for i in by_frames.argsort(kind="stable"):
                if by_frames[i] > limit():
                    return
                motion = int(motions[i])
                ends = self.aligner.ends(codes, starts[motion], starts[motion + 1], bounds, limit() * n_frames[motion])
                distance = float(ends.sums[-1] / n_frames[motion])
                if distance <= limit():
                    bisect.insort(best, (distance, motion))
                    del best[k:]

        by_ends = bounds.ends() / n_frames
        order = by_ends.argsort(kind="stable")
        order = order[order != excluded]
        n_first = FIRST_MOTIONS + 2 * k
        first, rest = order[:n_first], order[n_first:]
        by_frames = bounds.frames(first, self.paths) / n_frames[first]
        nearest = by_frames.argsort(kind="stable")
        align(first[nearest[:k]], by_frames[nearest[:k]])
        rest = rest[by_ends[rest] <= limit()]
        if len(rest):
            rest = rest[bounds.boxes(rest) / n_frames[rest] <= limit()]
        candidates, by_frames = first[nearest[k:]], by_frames[nearest[k:]]
        if len(rest):
            candidates = np.concatenate([candidates, rest])
            by_frames = np.concatenate([by_frames, bounds.frames(rest, self.paths) / n_frames[rest]])
        align(candidates, by_frames)
        distances, indices = zip(*best, strict=True)
        return np.array(distances), np.array(indices)


class Request(NamedTuple):
    """Motions, and how many of the nearest of an index to find."""

    index: SequenceIndex  # type: ignore[assignment]  # which is a method of tuples too
    queries: Sequences
    excluded: np.ndarray  # (n_queries,) index of a motion that is not a neighbour, or -1
    k: int
    window: float | None


class Nearest(NamedTuple):
    """The nearest motions of each query, by distance and then by index."""

    distances: np.ndarray  # (n_queries, k)
    indices: np.ndarray  # (n_queries, k)
    n_cells: int  # pairs of frames measured
    unconverged: list[tuple[int, float]]


def find(request: Request, n_jobs: int | None, verbose: int) -> Nearest:
    """Find the nearest motions of all queries."""
    n_queries, n_workers = request.queries.n_motions, effective_n_jobs(n_jobs)
    n_cells = len(request.queries.poses) * len(request.index.sequences.poses)
    remote = (request.index.metric.iterative or n_cells > WORTH_SENDING) and in_processes(n_jobs)
    size = max(FEWEST_QUERIES, n_queries // (TASKS_PER_WORKER * n_workers))
    tasks = [(rows.start, rows.stop) for rows in gen_batches(n_queries, size)]
    found: dict[tuple[int, int], Nearest] = {}
    title = f"neighbours of {n_queries:,} motions among {request.index.sequences.n_motions:,}"
    with progress(title, len(tasks), verbose) as advance:
        if remote:
            with closing(from_workers(find_some, request, tasks, n_jobs)) as results:
                for task, result in results:
                    found[task] = result
                    advance()
        else:

            def find_here(task: tuple[int, int]) -> None:
                found[task] = find_some(request, task)
                advance()

            in_threads([lambda task=task: find_here(task) for task in tasks], n_workers)  # type: ignore[misc]
    parts = [found[task] for task in tasks]
    return Nearest(
        np.concatenate([part.distances for part in parts]),
        np.concatenate([part.indices for part in parts]),
        sum(part.n_cells for part in parts),
        [one for part in parts for one in part.unconverged],
    )


def find_some(request: Request, rows: tuple[int, int]) -> Nearest:
    """Find the nearest motions of the queries first:last."""
    queries, excluded = request.queries.slice(*rows), request.excluded[slice(*rows)]
    index = request.index
    work = work_per_cell(index.metric, index.skeleton, index.sequences) * share_of_band(request.window)
    work *= len(queries.poses) * len(index.sequences.poses)
    # A pair of frames that is solved takes so long that to leave out a few is worth it.
    many = not index.metric.iterative and request.k * FEWEST_PER_NEIGHBOR > index.sequences.n_motions
    if index.filter is None or work < WORTH_FILTERING * queries.n_motions or many:
        return _by_brute_force(request, queries, excluded)
    search = MotionSearch(index, request.window)
    found = [search.nearest(queries.motion(i), excluded[i], request.k) for i in range(queries.n_motions)]
    distances, indices = (np.stack(part) for part in zip(*found, strict=True))
    return Nearest(distances, indices, search.aligner.n_cells, search.aligner.unconverged)


def _by_brute_force(request: Request, queries: Sequences, excluded: np.ndarray) -> Nearest:
    index, motions = request.index, request.index.sequences.in_float64()
    parts, unconverged = [], []
    for rows in gen_batches(queries.n_motions, max(1, MOST_DISTANCES // motions.n_motions)):
        some = queries.slice(rows.start, rows.stop).in_float64()
        matrix = MotionMatrix(some, motions, index.metric, index.skeleton, window=request.window)
        distances, counts = matrix.write(None, 1)
        left_out = np.flatnonzero(excluded[rows] >= 0)
        distances[left_out, excluded[rows][left_out]] = np.inf
        order = distances.argsort(axis=1, kind="stable")[:, : request.k]
        parts.append((np.take_along_axis(distances, order, axis=1), order))
        unconverged += [(one.count, one.gap) for one in counts]
    nearest, indices = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Nearest(nearest, indices, len(queries.poses) * len(motions.poses), unconverged)
