"""Exact search of the windows of long motions in which a query lies best, by filter and refine.

A *window* ends at a frame of a motion and begins where the least path of the query to that frame begins, an open path of
`skpose._compiled.warping`. The best window is the one with the least sum; then the best of those that overlap no more
than half with it, and so on: the k best.

1. Every box of frames gets a lower bound of all paths through it: the sums of the boxes before it and behind it.
2. Around the boxes with the least bounds, k windows are found by the frames' bounds, and their paths are measured. The
   largest of these sums is a limit: k windows that are no further away exist.
3. Where the bounds of boxes are within the limit, runs of them are regions, and no path within the limit leaves one.
   Each is searched cell by cell. All windows within the limit are known then, and so the k best.

Windows that overlap may leave fewer than k within the limit; it is then raised.
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.loops import in_lanes
from skpose._compiled.warping import accumulate, path_to
from skpose._compiled.warping_within import path_sum_loop
from skpose._parallel.progress import progress
from skpose._parallel.threads import in_threads
from skpose.motions._bounds import FRAMES_PER_BOX, OPEN, Bounds, left_over
from skpose.motions._index import SequenceIndex
from skpose.motions._results import MotionEvaluations
from skpose.motions._search import FLOAT64, ROUNDING, Aligner

RAISED = 1.25  # factor of a limit that left too few windows
ROUNDS = 12  # with a limit; the next is without
TRIES = 6  # places for each window that is wanted, where the first windows are looked for


class Window(NamedTuple):
    """A part of a motion, and the sum of the path that takes the query through it."""

    sum: float
    motion: int
    start: int  # frames of the index
    stop: int

    def overlaps(self, other: "Window") -> bool:
        """Return whether more than half of the shorter window lies in the other one."""
        common = min(self.stop, other.stop) - max(self.start, other.start)
        return 2 * common > min(self.stop - self.start, other.stop - other.start)


class WindowSearch:
    """A search of an index for the windows in which one motion lies best."""

    def __init__(self, index: SequenceIndex, n_jobs: int, verbose: int = 0):
        self.index, self.n_jobs, self.verbose = index, n_jobs, verbose
        self.evaluations = MotionEvaluations(0, 0)
        self.unconverged: list[tuple[int, float]] = []

    def best(self, query: np.ndarray, k: int) -> list[Window]:
        """Return the k best windows, or all if there are fewer, by their sums."""
        codes = Aligner(self.index, self.index.metric, OPEN).encoded(query)
        whole = list(zip(self.index.sequences.starts[:-1], self.index.sequences.starts[1:], strict=True))
        if self.index.filter is None:
            return chosen(self._within(codes, None, whole, np.inf), k)
        bounds = Bounds(self.index, query)
        by_boxes = self._bounds_of_boxes(bounds)
        limit = self._first_limit(bounds, by_boxes, codes, k)
        for _ in range(ROUNDS):
            regions = self._regions(by_boxes, limit * (1.0 + ROUNDING))
            found = chosen(self._within(codes, bounds, regions, limit), k)
            if len(found) == k or np.isinf(limit):
                return found
            limit *= RAISED
        return chosen(self._within(codes, bounds, whole, np.inf), k)

    def _run(self, what: str, tasks: list[Callable[[], Any]]) -> list[Any]:
        with progress(what, len(tasks), self.verbose) as advance:

            def counted(task: Callable[[], Any]) -> Any:
                result = task()
                advance()
                return result

            return in_threads([lambda task=task: counted(task) for task in tasks], self.n_jobs)

    def _bounds_of_boxes(self, bounds: Bounds) -> np.ndarray:
        """Return, for each box, a lower bound of the sums of all paths through it."""
        through = np.empty(len(self.index.boxes))

        def fill(first: int, last: int) -> None:
            distances = bounds.of_boxes(first, last)
            to, onwards = distances.copy(), left_over(distances, OPEN)
            accumulate(to, OPEN)
            to += onwards
            to -= distances
            through[first:last] = to.min(axis=0)

        starts = self.index.box_starts
        self._run("bounds", [lambda a=a, b=b: fill(a, b) for a, b in zip(starts[:-1], starts[1:], strict=True)])
        return through

    def _first_limit(self, bounds: Bounds, by_boxes: np.ndarray, codes: np.ndarray, k: int) -> float:
        """Return the largest sum of k windows that exist; infinity where k are not found."""
        found: list[Window] = []
        free = np.ones(len(by_boxes), np.bool_)
        order = by_boxes.argsort(kind="stable")
        n_tries = 0
        for box in order:
            if len(found) == k or n_tries == TRIES * k:
                break
            if not free[box]:
                continue
            n_tries += 1
            window, boxes = self._window_around(int(box), bounds, codes)
            free[boxes] = False
            free[box] = False
            if not any(window.overlaps(other) for other in found):
                found.append(window)
        return max(window.sum for window in found) if len(found) == k else np.inf

    def _window_around(self, box: int, bounds: Bounds, codes: np.ndarray) -> tuple[Window, slice]:
        """Return a window near a box, measured along the path that is best by the bounds, and the boxes in it."""
        sequences, box_starts = self.index.sequences, self.index.box_starts
        motion = int(np.searchsorted(box_starts, box, side="right")) - 1
        origin, end = int(sequences.starts[motion]), int(sequences.starts[motion + 1])
        at = origin + (box - int(box_starts[motion])) * FRAMES_PER_BOX
        start, stop = max(origin, at - 2 * bounds.n), min(end, at + FRAMES_PER_BOX + 2 * bounds.n)
        distances = bounds.of_frames(start, stop)
        onwards = left_over(distances, OPEN)
        accumulate(distances, OPEN)
        through = distances + onwards - bounds.of_frames(start, stop)
        inside = slice(max(0, at - start), at - start + FRAMES_PER_BOX)
        # The path through the box: from its best cell back to the first row, and on to the last one.
        row, column = np.unravel_index(through[:, inside].argmin(), through[:, inside].shape)
        column += inside.start
        before = path_to(np.ascontiguousarray(distances[: row + 1]), True, column)
        reverse = np.ascontiguousarray(onwards[row:, ::-1][::-1])
        behind = path_to(reverse, True, stop - start - 1 - column)[:-1][::-1]
        behind = np.column_stack([len(onwards) - 1 - behind[:, 0], stop - start - 1 - behind[:, 1]])
        path = np.ascontiguousarray(np.concatenate([before, behind]))
        aligner = Aligner(self.index, self.index.metric, OPEN)
        lanes = in_lanes(aligner.encoded(sequences.poses[start:stop]))
        total = aligner.path_sum(codes, lanes, path)
        window = Window(total, motion, start + int(path[0, 1]), start + int(path[-1, 1]) + 1)
        first = int(box_starts[motion]) + (window.start - origin) // FRAMES_PER_BOX
        return window, slice(first, int(box_starts[motion]) + -(-(window.stop - origin) // FRAMES_PER_BOX))

    def _regions(self, by_boxes: np.ndarray, limit: float) -> list[tuple[int, int]]:
        """Return the frames of runs of boxes that are within a limit, as first and last, which is not included."""
        starts, box_starts = self.index.sequences.starts, self.index.box_starts
        boxes = np.flatnonzero(by_boxes <= limit)
        motions = np.searchsorted(box_starts, boxes, side="right") - 1
        if not len(boxes):
            return []
        begins = np.concatenate([[True], (np.diff(boxes) > 1) | (np.diff(motions) > 0)])
        firsts, lasts = np.flatnonzero(begins), np.append(np.flatnonzero(begins)[1:], len(boxes)) - 1
        offsets = starts[motions] - FRAMES_PER_BOX * box_starts[motions]
        frames = offsets + FRAMES_PER_BOX * boxes
        ends = np.minimum(frames + FRAMES_PER_BOX, starts[motions + 1])
        return list(zip(frames[firsts].tolist(), ends[lasts].tolist(), strict=True))

    def _within(
        self, codes: np.ndarray, bounds: Bounds | None, regions: Iterable[tuple[int, int]], limit: float
    ) -> list[Window]:
        """Return, for each frame of the regions, the best window that ends there, if it is within the limit."""

        def windows(start: int, stop: int) -> tuple[list[Window], Aligner]:
            aligner = Aligner(self.index, self.index.metric, OPEN)
            sums, starts = aligner.sums(codes, start, stop, bounds, limit)
            motion = int(np.searchsorted(self.index.sequences.starts, start, side="right")) - 1
            ends = np.flatnonzero(np.isfinite(sums))
            found = [Window(float(sums[e]), motion, start + int(starts[e]), start + int(e) + 1) for e in ends]
            return found, aligner

        tasks = [lambda a=int(a), b=int(b): windows(a, b) for a, b in regions]
        results = self._run("windows", tasks)
        for _, aligner in results:
            self.evaluations += aligner.evaluations
            self.unconverged += aligner.unconverged
        return [window for found, _ in results for window in found]


def chosen(windows: list[Window], k: int) -> list[Window]:
    """Return the k best windows of which no two overlap by more than half; of equal sums the first comes first."""
    best: list[Window] = []
    for window in sorted(windows, key=lambda window: (window.sum, window.stop)):
        if not any(window.overlaps(other) for other in best):
            best.append(window)
            if len(best) == k:
                break
    return best
