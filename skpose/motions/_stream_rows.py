"""The templates of a stream as one column of sums, frame by frame, and the windows that are not decided yet."""

import numpy as np

from skpose._compiled.pose.loops import in_lanes
from skpose._compiled.warping.stream import Column, Windows, advance_loop, decide, insert_window
from skpose.metrics import Metric
from skpose.motions._inputs import Sequences
from skpose.motions._windows import Window
from skpose.skeleton import Skeleton

FLOAT64 = np.dtype(np.float64)
FIRST_ROOM = 64  # windows of a template


class Rows:
    """The frames of templates as the rows of a matrix of sums, one template after another."""

    def __init__(self, templates: Sequences, metric: Metric, skeleton: Skeleton | None):
        self.starts, self.lengths = templates.starts, templates.lengths
        self.last = self.starts[1:] - 1
        self.counts = np.arange(1, len(templates.poses) + 1) - np.repeat(self.starts[:-1], self.lengths)  # of prefixes
        self.metric, self.skeleton = metric, skeleton
        self._tree = metric.tree_for(skeleton, FLOAT64)
        self._lanes = in_lanes(self.encode(templates.poses))
        self.forget_counts()

    def forget_counts(self) -> None:
        """Count the geodesics that do not converge anew."""
        self.unconverged: list[tuple[int, float]] = []
        self.n_measured = 0

    def take_counts(self, other: "Rows") -> None:
        """Add the geodesics of other rows."""
        self.unconverged += other.unconverged
        self.n_measured += other.n_measured

    def first_column(self) -> Column:
        """Return the column before the first frame, to which no path leads."""
        return Column(np.full(len(self.counts), np.inf), np.zeros(len(self.counts), np.int64))

    def encode(self, poses: np.ndarray) -> np.ndarray:
        return self.metric.encode_poses(poses, self.skeleton)

    def advance(self, code: np.ndarray, column: Column, frame: int) -> None:
        """Replace a column by that of the next frame."""
        loop, metric = advance_loop(FLOAT64), self.metric
        unconverged = loop(code, self._lanes, self.starts, frame, metric.measure, self._tree, metric.steps, column)
        self.n_measured += len(self.counts)
        if unconverged[0]:
            self.unconverged.append(unconverged)

    def least_sums(self, poses: np.ndarray) -> np.ndarray:
        """Return, for each row, the least sum of the open paths to it that end anywhere in a motion."""
        column = self.first_column()
        least = column.sums.copy()
        for frame, code in enumerate(self.encode(poses)):
            self.advance(code, column, frame)
            np.minimum(least, column.sums, out=least)
        return least


class TemplateWindows:
    """The windows of a template that are undecided, and its last match, as start and stop."""

    def __init__(self) -> None:
        self._pending, self.n_pending = _room(FIRST_ROOM), 0
        self.last = 0, 0

    def insert(self, total: float, start: int, stop: int) -> None:
        """Take a window that ends at the last frame."""
        if self.n_pending == len(self._pending.sums):
            self._pending = _room(2 * self.n_pending, self._pending)
        self.n_pending = insert_window(self._pending, self.n_pending, total, start, stop, *self.last)

    def decide(self, column: Column, first: int, end: int, frame: int) -> list[Window]:
        """Return the windows that have become matches for good."""
        matches = _room(self.n_pending)
        self.n_pending, n_matches = decide(self._pending, self.n_pending, matches, column, first, end, frame)
        found = _list(matches, n_matches)
        self.last = max([self.last, *((w.start, w.stop) for w in found)], key=lambda window: window[1])
        return found

    def list_undecided(self) -> list[Window]:
        """Return the windows that are undecided, by their sums."""
        return _list(self._pending, self.n_pending)


def _room(size: int, windows: Windows | None = None) -> Windows:
    """Return room for so many windows, which begins with the given ones."""
    room = Windows(np.empty(size), np.empty(size, np.int64), np.empty(size, np.int64))
    if windows is not None:
        for new, old in zip(room, windows, strict=True):
            new[: len(old)] = old
    return room


def _list(windows: Windows, n: int) -> list[Window]:
    return [Window(float(windows.sums[k]), 0, int(windows.starts[k]), int(windows.stops[k])) for k in range(n)]
