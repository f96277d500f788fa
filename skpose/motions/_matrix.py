"""A matrix of distances between motions, computed tile by tile."""

import functools
from collections.abc import Callable, Iterator

import numpy as np

from skpose._compiled.pose import loops
from skpose._compiled.warping.paths import Encoded, MotionPairs, Paths, warp_pairs
from skpose._utils.parallel import LITTLE_WORK, TASKS_PER_JOB, WORK_PER_TASK, in_threads
from skpose.metrics import Metric
from skpose.metrics._convergence import Unconverged
from skpose.metrics._matrix import ENCODED_AT_ONCE, DistanceMatrix
from skpose.metrics._tiled import Tile, TiledMatrix, mirror
from skpose.motions._inputs import Sequences
from skpose.skeleton import Skeleton

ALIGNMENTS = ("dtw", "subsequence", "frames")
WORK_PER_CELL = 6.0  # of the recursion, added to the work of the distance


class MotionMatrix(TiledMatrix):
    """The distances between motions X and motions Y, where Y=None is X.

    See `motion_distances` for `alignment` and `window`; `normalize` divides by the number of frames.
    """

    smallest_edge = 1

    def __init__(
        self,
        X: Sequences,
        Y: Sequences | None,
        metric: Metric,
        skeleton: Skeleton | None,
        *,
        alignment: str = "dtw",
        window: float | None = None,
        normalize: bool = True,
    ):
        self.X, self.Y, self.metric = X, Y, metric
        self.alignment, self.normalize = alignment, normalize
        self.paths = Paths.of(window, alignment == "subsequence")
        self.skeleton = skeleton if metric.needs_skeleton else None
        self.result_dtype = np.result_type(X.poses, (X if Y is None else Y).poses)
        self.dtype = np.dtype(np.float64) if metric.iterative else self.result_dtype
        self.shape = X.n_motions, (X if Y is None else Y).n_motions

    @property
    def columns(self) -> Sequences:
        return self.X if self.Y is None else self.Y

    @property
    def symmetric(self) -> bool:
        return self.Y is None and self.alignment != "subsequence"

    @property
    def n_cells(self) -> int:
        """The number of pairs of frames, in one triangle if symmetric."""
        if self.alignment == "frames":
            return len(self.X.poses) // self.X.n_motions * self.n_pairs
        n_frames = len(self.X.poses)
        if self.symmetric:
            return (n_frames * n_frames - int((self.X.lengths**2).sum())) // 2
        return n_frames * len(self.columns.poses)

    @functools.cached_property
    def work_per_cell(self) -> float:
        return work_per_cell(self.metric, self.skeleton, self.X)

    @property
    def work_per_pair(self) -> float:
        work = self.work_per_cell * share_of_band(self.paths.window) * self.n_cells
        return max(1.0, work / max(1, self.n_pairs))

    @property
    def largest_edge(self) -> int:
        """About as many motions as have ENCODED_AT_ONCE frames; a power of two."""
        longest = max(self.X.lengths.mean(), self.columns.lengths.mean())
        return 2 ** int(np.log2(max(1.0, ENCODED_AT_ONCE / longest)))

    def distances(self, tile: Tile, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        rows, columns = self.X.slice(tile.top, tile.bottom), self.columns.slice(tile.left, tile.right)
        diagonal = self.symmetric and tile.top == tile.left
        if self.alignment == "frames":
            sums, unconverged = self._sums_of_frames(rows, None if diagonal else columns, n_jobs)
        else:
            sums = np.zeros(tile.shape)
            tasks = self._tasks(rows, columns, diagonal, n_jobs, sums)
            unconverged = Unconverged.join(in_threads(tasks, n_jobs))
        if diagonal:
            mirror(sums, n_jobs)
        if self.normalize:
            n = rows.lengths[:, np.newaxis]
            sums /= n + columns.lengths if self.alignment == "dtw" else n
        if out is None:
            return sums.astype(self.dtype, copy=False), unconverged
        out[...] = sums
        return out, unconverged

    def _sums_of_frames(
        self, rows: Sequences, columns: Sequences | None, n_jobs: int
    ) -> tuple[np.ndarray, Unconverged]:
        """Sums of the distances between frames i of both motions, all of equal length."""
        n_rows, n_columns = rows.n_motions, (rows if columns is None else columns).n_motions
        sums, parts = np.zeros((n_rows, n_columns)), []
        X = rows.poses.reshape(n_rows, -1, rows.poses.shape[1])
        Y = None if columns is None else columns.poses.reshape(n_columns, -1, X.shape[2])
        for frame in range(X.shape[1]):
            poses = np.ascontiguousarray(X[:, frame]), None if Y is None else np.ascontiguousarray(Y[:, frame])
            matrix = DistanceMatrix(*poses, self.metric, self.skeleton)
            distances, unconverged = matrix.distances(Tile(0, n_rows, 0, n_columns), n_jobs)
            sums += distances
            parts.append(unconverged)
        return sums, Unconverged.join(parts)

    def _tasks(
        self, rows: Sequences, columns: Sequences, diagonal: bool, n_jobs: int, sums: np.ndarray
    ) -> Iterator[Callable[[], tuple[int, float]]]:
        metric, tree = self.metric, self.metric.tree_for(self.skeleton, self.dtype)
        X = self._encode(rows.poses)
        Y = loops.in_lanes(X if diagonal else self._encode(columns.poses))
        work = WORK_PER_TASK
        if n_jobs > 1:
            whole = len(rows.poses) * len(columns.poses) * self.work_per_cell
            work = min(work, max(LITTLE_WORK, whole / (TASKS_PER_JOB * n_jobs)))
        for pairs in motion_pairs(rows.lengths, columns.lengths, diagonal, work / self.work_per_cell):
            x, y = Encoded(X, rows.starts), Encoded(Y, columns.starts)
            yield functools.partial(warp_pairs, x, y, pairs, self.paths, metric.measure, tree, metric.steps, sums)

    def _encode(self, poses: np.ndarray) -> np.ndarray:
        return self.metric.encode_poses(poses, self.skeleton).astype(self.dtype, copy=False)


def work_per_cell(metric: Metric, skeleton: Skeleton | None, motions: Sequences) -> float:
    """The work of a pair of frames, in the unit of `skpose._utils.parallel`."""
    return WORK_PER_CELL + metric.n_codes(metric.tree_for(skeleton), motions.poses.shape[1]) * metric.measure_work


def share_of_band(window: float | None) -> float:
    """The share of all pairs of frames inside the band, for long motions."""
    w = 1.0 if window is None else min(1.0, window)
    return max(0.01, w * (2.0 - w))


def motion_pairs(n: np.ndarray, m: np.ndarray, triangle: bool, most_cells: float) -> Iterator[MotionPairs]:
    """Yield ranges of rows and columns of at most `most_cells` cells, or of one pair; n and m are numbers of frames."""
    ends_n, ends_m = np.cumsum(n), np.cumsum(m)

    def end_of(ends: np.ndarray, start: int, most: float) -> int:
        before = ends[start - 1] if start else 0
        return max(start + 1, int(np.searchsorted(ends, before + most, side="right")))

    first = 0
    while first < len(n):
        left = first + 1 if triangle else 0
        whole = ends_m[-1] - (ends_m[left - 1] if left else 0)
        last = end_of(ends_n, first, most_cells / max(1, whole))
        frames = ends_n[last - 1] - (ends_n[first - 1] if first else 0)
        while left < len(m):
            right = end_of(ends_m, left, most_cells / frames)
            yield MotionPairs(first, last, left, right, triangle)
            left = right
        first = last
