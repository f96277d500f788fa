"""Exact search of the nearest motions, by filter and refine.

The bounds of `SequenceIndex` are taken in order of their cost. The ends bound all motions of the index. The
motions that come first are bounded by their frames, and the k first of these are aligned: the k-th distance is a limit.
Motions within the limit by their ends are bounded by boxes, those still within it by frames, and the rest are aligned
in the order of their bounds, cell by cell, until no bound is within the k-th distance so far.

`find` answers many queries, in threads or workers of joblib.
"""

import bisect
import copy
import functools
import itertools
from collections.abc import Iterable
from typing import NamedTuple, cast

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import gen_batches

from skpose._compiled.pose import loops
from skpose._compiled.pose.measure import measure_boxes, measure_euclidean
from skpose._compiled.pose.tree import Steps
from skpose._compiled.warping.paths import Encoded, MotionPairs, Paths, accumulate, accumulate_from, path_to, warp_pairs
from skpose._compiled.warping.within import Ends, Within, warp_within
from skpose._utils.parallel import TASKS_PER_WORKER, in_processes, in_threads, results_of
from skpose.kinematics._tree import tree_of
from skpose.metrics import Metric
from skpose.motions._distances import MotionMatrix, share_of_band, work_per_cell
from skpose.motions._inputs import Sequences
from skpose.neighbors._graph import Found
from skpose.neighbors._index import FLOAT32, ChordFilter, FilterPoints, Neighbors, PoseIndex
from skpose.skeleton import Skeleton

FRAMES_PER_BOX = 8
CLOSED, OPEN = Paths(1.0, False), Paths(1.0, True)
NO_TREE, NO_WRAP = tree_of(None, FLOAT32), Steps.of(1, wrap=False)


class SequenceIndex:
    """Motions to search under a metric, with boxes around every few frames along the axes of the filter.

    Attributes
    ----------
    filter : ChordFilter or None
        None is brute force: requested, or because the metric has no lower bound.
    box_starts : ndarray of shape (n_motions + 1,)
        The boxes of motion i are box_starts[i]:box_starts[i + 1]. Only with a filter, as the next two.
    boxes : ndarray of shape (n_boxes, 2 n_coordinates)
        Lower and upper corners of the smallest boxes that hold the coordinates of the frames.
    ends : ndarray of shape (2, n_motions, n_coordinates)
        Coordinates of the first and the last frame of each motion.
    """

    def __init__(self, sequences: Sequences, skeleton: Skeleton | None, metric: Metric, *, brute: bool = False):
        self.sequences, self.skeleton, self.metric = sequences, skeleton, metric
        self.filter: ChordFilter | None = PoseIndex(sequences.poses, skeleton, metric, brute=brute).filter
        if self.filter is not None:
            starts = sequences.starts
            self.ends = np.stack([self.coordinates(starts[:-1]), self.coordinates(starts[1:] - 1)])
            counts = -(-sequences.lengths // FRAMES_PER_BOX)
            self.box_starts = np.concatenate([[0], np.cumsum(counts)])
            firsts = np.repeat(starts[:-1] - FRAMES_PER_BOX * self.box_starts[:-1], counts)
            self.box_firsts = firsts + FRAMES_PER_BOX * np.arange(self.box_starts[-1])
            coordinates = self.coordinates(np.arange(len(sequences.poses)))
            low, high = (edge.reduceat(coordinates, self.box_firsts, axis=0) for edge in (np.minimum, np.maximum))
            self.boxes = np.concatenate([low, high], axis=1)

    def under(self, metric: Metric) -> "SequenceIndex":
        """The same motions under another metric with the same bound."""
        other = copy.copy(self)
        other.metric = metric
        return other

    def coordinates(self, frames: np.ndarray) -> np.ndarray:
        """The filter's coordinates of some frames, (n_frames, n_coordinates), in float32."""
        return cast(ChordFilter, self.filter).coordinates(frames)


def gather_rows(starts: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows of chosen parts, part i being starts[i]:starts[i + 1], and where each begins among them."""
    counts = starts[chosen + 1] - starts[chosen]
    begins = np.concatenate([[0], np.cumsum(counts)])
    return np.arange(begins[-1]) + np.repeat(starts[chosen] - begins[:-1], counts), begins


class Bounds:
    """Lower bounds of the sums of distances along paths from one motion to the motions of an index with a filter."""

    def __init__(self, index: SequenceIndex, query: np.ndarray):
        self.index, self.n = index, len(query)
        chords = cast(ChordFilter, index.filter)
        self.points: FilterPoints = chords.points(query)
        self.scale, self.slack = chords.scale, float(self.points.slack.max())

    def ends(self) -> np.ndarray:
        """Bounds of closed paths to all motions, by their ends."""
        q, (first, last) = self.points.coordinates.astype(np.float64), self.index.ends
        at_first = np.linalg.norm(first - q[0], axis=1)
        at_last = np.linalg.norm(last - q[-1], axis=1)
        one_cell = (self.n == 1) & (self.index.sequences.lengths == 1)
        return self._in_units(np.where(one_cell, at_first, at_first + at_last), 2)

    def boxes(self, motions: np.ndarray) -> np.ndarray:
        """Bounds of closed paths to some motions, by boxes."""
        rows, starts = gather_rows(self.index.box_starts, motions)
        return self._warp(self.index.boxes[rows], starts, measure_boxes, CLOSED)

    def frames(self, motions: np.ndarray, paths: Paths) -> np.ndarray:
        """Bounds of the paths to some motions, by frames."""
        rows, starts = gather_rows(self.index.sequences.starts, motions)
        return self._warp(self.index.coordinates(rows), starts, measure_euclidean, paths)

    def _warp(self, rows: np.ndarray, starts: np.ndarray, measure: object, paths: Paths) -> np.ndarray:
        n_motions = len(starts) - 1
        sums = np.empty((1, n_motions))
        query, pairs = Encoded(self.points.coordinates, np.array([0, self.n])), MotionPairs(0, 1, 0, n_motions, False)
        lanes = loops.in_lanes(rows.astype(FLOAT32, copy=False))
        warp_pairs(query, Encoded(lanes, starts), pairs, paths, measure, NO_TREE, NO_WRAP, sums)
        return self._in_units(sums[0], self.n + np.diff(starts))

    def of_frames(self, start: int, stop: int) -> np.ndarray:
        """Bounds of the distances (n, stop − start) from each frame of the query to some frames."""
        return self._distances(self.index.coordinates(np.arange(start, stop)), measure_euclidean)

    def of_boxes(self, first: int, last: int) -> np.ndarray:
        """Bounds of the distances (n, last − first) from each frame of the query to all frames of some boxes."""
        return self._distances(self.index.boxes[first:last], measure_boxes)

    def _distances(self, rows: np.ndarray, measure: object) -> np.ndarray:
        points, lanes = self.points.coordinates, loops.in_lanes(rows)
        distances = np.empty((self.n, len(rows)), FLOAT32)
        pairs = loops.PairRange(0, self.n, 0, -(-len(rows) // lanes.shape[1]), triangle=False)
        loops.pair_distances(points, lanes, pairs, measure, NO_TREE, NO_WRAP, distances)
        bounds = distances.astype(np.float64)
        bounds -= self.points.slack[:, np.newaxis]
        np.maximum(bounds, 0.0, out=bounds)
        bounds *= self.scale
        return bounds

    def _in_units(self, sums: np.ndarray, n_cells: np.ndarray | int) -> np.ndarray:
        return np.maximum(sums - n_cells * self.slack, 0.0) * self.scale


def sums_to_end(bounds: np.ndarray, paths: Paths, behind: np.ndarray | None = None) -> np.ndarray:
    """Least sums (n, m) of the bounds from each cell, itself included, to the end of a path.

    `behind` are the sums of the column after the last one, for open paths.
    """
    reverse = np.ascontiguousarray(bounds[::-1, ::-1])
    edge = np.full(len(bounds), np.inf) if behind is None else np.ascontiguousarray(behind[::-1])
    accumulate_from(reverse, paths, edge)
    return np.ascontiguousarray(reverse[::-1, ::-1])


# --- search -----------------------------------------------------------------------------------------------------------


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
        rest = rest[bounds.boxes(rest) / n_frames[rest] <= limit()]
        by_frames = np.concatenate([by_frames[nearest[k:]], bounds.frames(rest, self.paths) / n_frames[rest]])
        align(np.concatenate([first[nearest[k:]], rest]), by_frames)
        distances, indices = zip(*best, strict=True)
        return np.array(distances), np.array(indices)


class Request(NamedTuple):
    """Motions, and how many of the nearest of an index to find."""

    index: SequenceIndex  # type: ignore[assignment]  # which is a method of tuples too
    queries: Sequences
    excluded: np.ndarray  # (n_queries,) index of a motion that is not a neighbour, or -1
    k: int
    window: float | None


def find(request: Request, n_jobs: int | None, verbose: int) -> Found:
    """Find the nearest motions of all queries."""
    n_queries, n_motions = request.queries.n_motions, request.index.sequences.n_motions
    n_cells = len(request.queries.poses) * len(request.index.sequences.poses)
    remote = (request.index.metric.iterative or n_cells > WORTH_SENDING) and in_processes(n_jobs)
    size = max(FEWEST_QUERIES, n_queries // (TASKS_PER_WORKER * effective_n_jobs(n_jobs)))
    size = max(1, min(size, MOST_DISTANCES // n_motions))
    tasks = [(rows.start, rows.stop) for rows in gen_batches(n_queries, size)]
    what = f"neighbours of {n_queries:,} motions among {n_motions:,}"
    parts = results_of(find_some, request, tasks, n_jobs, remote, what, verbose)
    return Found(
        Neighbors.join(part.neighbors for part in parts),
        sum(part.n_measured for part in parts),
        [one for part in parts for one in part.unconverged],
    )


def find_some(request: Request, rows: tuple[int, int]) -> Found:
    """Find the nearest motions of the queries first:last."""
    queries, excluded = request.queries.slice(*rows), request.excluded[slice(*rows)]
    index = request.index
    n_cells = len(queries.poses) * len(index.sequences.poses)
    work = n_cells * work_per_cell(index.metric, index.skeleton, index.sequences) * share_of_band(request.window)
    # A pair of frames that is solved takes so long that to leave out a few is worth it.
    many = not index.metric.iterative and request.k * FEWEST_PER_NEIGHBOR > index.sequences.n_motions
    if index.filter is None or work < WORTH_FILTERING * queries.n_motions or many:
        among = queries.in_float64(), index.sequences.in_float64()
        matrix = MotionMatrix(*among, index.metric, index.skeleton, window=request.window)
        distances, counts = matrix.write(None, 1)
        left_out = np.flatnonzero(excluded >= 0)
        distances[left_out, excluded[left_out]] = np.inf
        indices = distances.argsort(axis=1, kind="stable")[:, : request.k]
        distances = np.take_along_axis(distances, indices, axis=1)
        unconverged = [(one.count, one.gap) for one in counts]
    else:
        search = MotionSearch(index, request.window)
        found = [search.nearest(queries.motion(i), excluded[i], request.k) for i in range(queries.n_motions)]
        distances, indices = (np.stack(part) for part in zip(*found, strict=True))
        n_cells, unconverged = search.aligner.n_cells, search.aligner.unconverged
    neighbors = Neighbors(np.repeat(np.arange(*rows), request.k), indices.ravel(), distances.ravel())
    return Found(neighbors, n_cells, unconverged)


# --- windows ----------------------------------------------------------------------------------------------------------
# Exact search of the windows of long motions that match a query best, by filter and refine.
#
# A *window* ends at a frame of a motion and begins where the least path of the query to that frame begins, an open
# path of `_compiled.warping.paths`. The best window has the least sum; the next is the best window that overlaps it
# by at most half, and so on.
#
# 1. Every *box* of frames gets a lower bound of all paths through it: the least cost up to the box plus the least
# cost    from there on. The boxes with the least bounds are scanned first. 2. To *scan* frames is to compute the same
# bounds of the frames themselves. In the order of the bounds of their ends,    windows are measured along the path
# that is best by the bounds, until the k best do not change for a while. The    k-th sum is a limit: no path with a
# larger sum is one of the k best. Boxes within it are scanned too. 3. Runs of frames whose bounds are within the
# limit are *regions*, and no path within the limit leaves one. They are    searched cell by cell, which finds all
# windows within the limit, and so the k best.
#
# If overlapping windows leave fewer than k within the limit, it is raised.


FIRST_SHARE = 0.05  # of the boxes, scanned first
SCANNED_AT_ONCE = 2**17  # cells
LONGEST = 3  # window measured for the limit, in lengths of the query
NEAR = 4  # regions less than this fraction of a query apart are searched as one, which is faster
PATIENCE = 20  # windows in a row, at least, measured without a change of the k best
# Cost of the limit, in the unit of `skpose._utils.parallel`: a millisecond for each window.
WORK_PER_WINDOW, FEWEST_WINDOWS, WINDOWS_PER_K = 5e6, 10, 3
RAISED = 1.1  # factor for a limit with too few windows


class Window(NamedTuple):
    """A part of a motion in frames of the index, and the sum of the path that takes the query through it."""

    sum: float
    start: int
    stop: int


class WindowSearch:
    """A search of an index for the windows that match one motion best."""

    def __init__(self, index: SequenceIndex, n_jobs: int):
        self.index, self.n_jobs = index, n_jobs
        self.n_cells = 0
        self.unconverged: list[tuple[int, float]] = []

    def best(self, query: np.ndarray, k: int) -> list[Window]:
        """The k best windows by their sums, or all if there are fewer."""
        index, codes = self.index, Aligner(self.index, OPEN).encode(query)
        work = len(query) * len(index.sequences.poses) * work_per_cell(index.metric, index.skeleton, index.sequences)
        # Brute force may take less time than measuring the windows for the limit.
        if index.filter is None or work <= WORK_PER_WINDOW * (FEWEST_WINDOWS + WINDOWS_PER_K * k):
            starts = index.sequences.starts.tolist()
            return choose_windows(self._within(codes, None, itertools.pairwise(starts), np.inf), k)
        bounds = Bounds(index, query)
        by_boxes = self._bounds_of_boxes(bounds)
        covered = float(np.quantile(by_boxes, FIRST_SHARE))  # all paths up to this sum are in the scanned boxes
        measured: dict[int, Window] = {}
        while True:
            by_frames, ends = self._scan_boxes(bounds, by_boxes, covered)
            limit = self._limit(bounds, codes, ends, k, measured)
            while limit <= covered:
                near = max(FRAMES_PER_BOX, len(query) // NEAR)
                regions = self._find_regions(by_frames <= limit * (1.0 + ROUNDING), near)
                found = choose_windows(self._within(codes, bounds, regions, limit), k)
                if len(found) == k or np.isinf(limit):
                    return found
                limit = limit * RAISED if 0.0 < limit < by_boxes.max() else np.inf  # a factor does not raise zero
            covered = limit

    def _bounds_of_boxes(self, bounds: Bounds) -> np.ndarray:
        """A lower bound of the sums of all paths through each box."""
        least, none = np.empty(len(self.index.boxes)), np.full(bounds.n, np.inf)

        def fill(first: int, last: int) -> None:
            distances = bounds.of_boxes(first, last)
            least[first:last] = sums_through(distances, none, none)[0]

        starts = self.index.box_starts.tolist()
        in_threads((functools.partial(fill, *ends) for ends in itertools.pairwise(starts)), self.n_jobs)
        return least

    def _scan_boxes(self, bounds: Bounds, by_boxes: np.ndarray, limit: float) -> tuple[np.ndarray, np.ndarray]:
        """Lower bounds of the sums of all paths through each frame, and of all paths that end there.

        Only boxes within the limit are scanned; elsewhere the bounds are infinite.
        """
        frames = np.repeat(by_boxes, np.diff(self.index.box_firsts, append=self.index.sequences.starts[-1]))
        by_frames, ends = np.full(len(frames), np.inf), np.full(len(frames), np.inf)
        regions = self._find_regions(frames <= limit * (1.0 + ROUNDING), 0)

        def scan(start: int, stop: int) -> None:
            step = max(FRAMES_PER_BOX, SCANNED_AT_ONCE // bounds.n)
            chunks = [(at, min(at + step, stop)) for at in range(start, stop, step)]
            edge = np.full(bounds.n, np.inf)
            behind = [edge]  # sums to the end from the first column of each chunk, from the last chunk on
            for chunk in chunks[:0:-1]:
                behind.append(sums_to_end(bounds.of_frames(*chunk), OPEN, behind[-1])[:, 0])
            for chunk in chunks:
                distances = bounds.of_frames(*chunk)
                by_frames[slice(*chunk)], to = sums_through(distances, behind.pop(), edge)
                ends[slice(*chunk)], edge = to[-1], to[:, -1].copy()

        in_threads((functools.partial(scan, *region) for region in regions), self.n_jobs)
        return by_frames, ends

    def _limit(self, bounds: Bounds, codes: np.ndarray, ends: np.ndarray, k: int, measured: dict[int, Window]) -> float:
        """The largest sum of k windows that exist; infinity if there are fewer. `measured` has windows by their end."""
        found: list[Window] = []
        best: list[Window] = []
        batch = max(PATIENCE, k // 4)
        free = np.isfinite(ends)
        for end in ends.argsort(kind="stable")[: free.sum()].tolist():
            if not free[end]:
                continue
            if len(best) == k and ends[end] > best[-1].sum:
                break
            if end not in measured:
                measured[end] = self._measure_window(bounds, codes, end)
            window = measured[end]
            found.append(window)
            half = max(1, (window.stop - window.start) // 2)  # windows that end here overlap this one
            free[max(0, end - half) : end + half] = False
            if len(found) % batch == 0:
                before, best = best, choose_windows(found, k)
                if len(best) == k and best == before:
                    break
        best = choose_windows(found, k)
        return best[-1].sum if len(best) == k else np.inf

    def _measure_window(self, bounds: Bounds, codes: np.ndarray, end: int) -> Window:
        """The window that ends at a frame, with the sum along the path that is best by the bounds."""
        starts = self.index.sequences.starts
        begin = starts[np.searchsorted(starts, end, side="right") - 1]
        start = max(int(begin), end + 1 - LONGEST * bounds.n)
        sums = bounds.of_frames(start, end + 1)
        accumulate(sums, OPEN)
        path = path_to(sums, True, end - start)
        first = start + int(path[0, 1])
        total = Aligner(self.index, OPEN).path_sum(codes, first, path - [0, first - start])
        return Window(total, first, end + 1)

    def _find_regions(self, chosen_frames: np.ndarray, near: int) -> list[tuple[int, int]]:
        """Ranges of chosen frames, start and stop; ranges of one motion that are near each other are joined."""
        frames = np.flatnonzero(chosen_frames)
        if not len(frames):
            return []
        motions = np.searchsorted(self.index.sequences.starts, frames, side="right")
        begins = np.flatnonzero((np.diff(frames) > near + 1) | (np.diff(motions) > 0)) + 1
        firsts, lasts = np.append(0, begins), np.append(begins, len(frames)) - 1
        return list(zip(frames[firsts].tolist(), (frames[lasts] + 1).tolist(), strict=True))

    def _within(
        self, codes: np.ndarray, bounds: Bounds | None, regions: Iterable[tuple[int, int]], limit: float
    ) -> list[Window]:
        """For each frame of the regions, the best window that ends there, if it is within the limit."""

        def windows(start: int, stop: int) -> tuple[list[Window], Aligner]:
            aligner = Aligner(self.index, OPEN)
            sums, starts = aligner.ends(codes, start, stop, bounds, limit)
            ends = np.flatnonzero(np.isfinite(sums))
            return [Window(float(sums[e]), start + int(starts[e]), start + int(e) + 1) for e in ends], aligner

        results = in_threads((functools.partial(windows, *region) for region in regions), self.n_jobs)
        for _, aligner in results:
            self.n_cells += aligner.n_cells
            self.unconverged += aligner.unconverged
        return [window for found, _ in results for window in found]


def sums_through(distances: np.ndarray, behind: np.ndarray, edge: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least sum of the open paths through each column, and the sums of those to each cell.

    `behind` has the sums from the column after the last one on, `edge` those to the column before the first one.
    """
    to, through = distances.copy(), sums_to_end(distances, OPEN, behind)
    accumulate_from(to, OPEN, edge)
    through -= distances
    through += to
    return through.min(axis=0), to


def choose_windows(windows: Iterable[Window], k: int) -> list[Window]:
    """The k best windows of which no two overlap by more than half of the shorter one; the first of equal sums."""
    ordered = sorted(windows, key=lambda window: (window.sum, window.stop))
    starts, stops = np.array([(window.start, window.stop) for window in ordered], np.int64).reshape(-1, 2).T
    best, free = [], np.ones(len(ordered), bool)
    for i, window in enumerate(ordered):
        if free[i]:
            best.append(window)
            if len(best) == k:
                break
            common = np.minimum(stops, window.stop) - np.maximum(starts, window.start)
            free &= 2 * common <= np.minimum(stops - starts, window.stop - window.start)
    return best
