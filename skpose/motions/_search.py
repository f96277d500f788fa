"""Exact search of the nearest motions, by filter and refine.

The bounds of `skpose.motions._bounds` are taken in order of their cost. The ends bound all motions of the index. The
motions that come first by them are bounded by their frames, and the k first of these are aligned: the k-th distance is
a limit. What is within the limit by its ends is bounded by boxes, what is left then by frames, and what is left then is
aligned in the order of its bound, cell by cell, until no bound is within the k-th distance so far.
"""

import bisect

import numpy as np

from skpose._compiled.pose import loops
from skpose._compiled.warping.paths import Paths
from skpose._compiled.warping.within import Ends, Within, path_sum_loop, warp_within_loop
from skpose.motions._bounds import Bounds, sums_to_end
from skpose.motions._index import SequenceIndex
from skpose.motions._results import MotionEvaluations

FLOAT64 = np.dtype(np.float64)
FIRST_MOTIONS = 48  # that are bounded by their frames before there is a limit, in addition to 2 k
MOST_CELLS = 2**24  # of which what is left over is kept, 128 MB
ROUNDING = 1e-9  # relative, of sums that are compared with a limit
NO_BOUNDS = np.zeros((0, 0))


class Aligner:
    """Sums of distances under the metric of an index, up to a limit, and what they cost."""

    def __init__(self, index: SequenceIndex, paths: Paths):
        self.index, self.paths, self.metric = index, paths, index.metric
        self._tree = self.metric.tree_for(index.skeleton, FLOAT64)
        self.evaluations = MotionEvaluations(0, 0)
        self.unconverged: list[tuple[int, float]] = []

    def encode(self, poses: np.ndarray) -> np.ndarray:
        return self.metric.encode_poses(poses, self.index.skeleton)

    def ends(self, codes: np.ndarray, start: int, stop: int, bounds: Bounds | None, limit: float) -> Ends:
        """Return the paths that end at the frames start:stop.

        Sums above the limit are infinite. `bounds` are those of the query whose codes are given, None for none.
        """
        n_columns = stop - start
        remaining = NO_BOUNDS
        if bounds is not None and np.isfinite(limit) and len(codes) * n_columns <= MOST_CELLS:
            remaining = sums_to_end(bounds.of_frames(start, stop), self.paths)
        ends = Ends(np.empty(n_columns), np.empty(n_columns, np.int64))
        lanes = loops.in_lanes(self.encode(self.index.sequences.poses[start:stop]))
        within = Within(limit * (1.0 + ROUNDING), remaining)
        n_cells, *unconverged = warp_within_loop(FLOAT64)(
            codes, lanes, self.paths, within, self.metric.measure, self._tree, self.metric.steps, ends
        )
        self.evaluations += MotionEvaluations(1, n_cells)
        self.unconverged.append(tuple(unconverged))
        return ends

    def path_sum(self, codes: np.ndarray, lanes: np.ndarray, path: np.ndarray) -> float:
        """Return the sum of the distances along one path to encoded frames."""
        loop = path_sum_loop(FLOAT64)
        return loop(codes, lanes, path, self.metric.measure, self._tree, self.metric.steps)


class MotionSearch:
    """A search of an index with a filter for the motions nearest to one motion at a time."""

    def __init__(self, index: SequenceIndex, window: float | None):
        self.index, self.paths = index, Paths.of(window)
        self._aligner = Aligner(index, self.paths)
        # The distance along lines costs a thousandth, and is an upper bound: `measure_geodesic` returns the length of
        # the straight line where that is the shorter one. So k motions are within the k-th of these.
        above = index.metric.upper_bound()
        self._lines = None if above is None else MotionSearch(index.under(above), window)

    @property
    def evaluations(self) -> MotionEvaluations:
        return self._aligner.evaluations

    @property
    def unconverged(self) -> list[tuple[int, float]]:
        return self._aligner.unconverged

    def nearest(self, query: np.ndarray, excluded: int, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the distances and the indices of the k nearest motions, by distance and then by index."""
        bounds, codes = Bounds(self.index, query), self._aligner.encode(query)
        n_frames = len(query) + self.index.sequences.lengths
        best: list[tuple[float, int]] = []
        start = np.inf if self._lines is None else self._lines.nearest(query, excluded, k)[0][-1] * (1.0 + ROUNDING)

        def limit() -> float:
            return best[k - 1][0] if len(best) >= k else start

        def align(motions: np.ndarray, by_frames: np.ndarray) -> None:
            for i in by_frames.argsort(kind="stable"):
                if by_frames[i] > limit():
                    return
                distance = self._distance(int(motions[i]), bounds, codes, limit())
                if distance <= limit():
                    bisect.insort(best, (distance, int(motions[i])))
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

    def _distance(self, motion: int, bounds: Bounds, codes: np.ndarray, limit: float) -> float:
        """Return the distance to a motion; infinity where it is above the limit."""
        start, stop = self.index.sequences.starts[motion : motion + 2]
        n_frames = len(codes) + int(stop - start)
        ends = self._aligner.ends(codes, int(start), int(stop), bounds, limit * n_frames)
        return float(ends.sums[-1] / n_frames)
