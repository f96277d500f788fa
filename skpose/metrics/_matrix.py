"""A matrix of distances between poses: the numbers of each tile, and their cost."""

import functools
from collections.abc import Callable, Iterator
from itertools import chain

import numpy as np
from sklearn.utils import gen_batches

from skpose._compiled.pose import loops
from skpose._utils.parallel import LITTLE_WORK, TASKS_PER_JOB, WORK_PER_TASK, in_threads
from skpose.metrics._convergence import Unconverged, warn_of_unconverged
from skpose.metrics._metric import Metric
from skpose.metrics._tiled import Tile, TiledMatrix, mirror
from skpose.skeleton import Skeleton

ENCODED_AT_ONCE = 4096  # poses, 12 MB for "spatial" and 56 dofs: the longest edge of a tile


class DistanceMatrix(TiledMatrix):
    """The distances between poses X and poses Y, where Y=None is X and one triangle is computed."""

    smallest_edge = 16

    def __init__(self, X: np.ndarray, Y: np.ndarray | None, metric: Metric, skeleton: Skeleton | None):
        self.X, self.Y, self.metric = X, Y, metric
        self.skeleton = skeleton if metric.needs_skeleton else None
        self.result_dtype = X.dtype if Y is None else np.result_type(X, Y)
        self.dtype = np.dtype(np.float64) if metric.iterative else self.result_dtype
        self.shape = len(X), len(X if Y is None else Y)

    @property
    def symmetric(self) -> bool:
        return self.Y is None

    @property
    def largest_edge(self) -> int:
        return ENCODED_AT_ONCE

    @functools.cached_property
    def work_per_pair(self) -> float:
        n_codes = self.metric.n_codes(self.metric.tree_for(self.skeleton), self.X.shape[1])
        return max(1.0, n_codes * self.metric.measure_work)

    def distances(self, tile: Tile, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        """The distances of a tile, in `out` if given, and how many geodesics did not converge."""
        out = np.empty(tile.shape, self.dtype) if out is None else out
        diagonal = self.symmetric and tile.top == tile.left
        unconverged = Unconverged.join(in_threads(self._tasks(tile, diagonal, n_jobs, out), n_jobs))
        if diagonal:
            mirror(out, n_jobs)
        return out, unconverged

    def _tasks(
        self, tile: Tile, diagonal: bool, n_jobs: int, out: np.ndarray
    ) -> Iterator[Callable[[], tuple[int, float]]]:
        """The tasks of a tile, as functions to call."""
        tree = self.metric.tree_for(self.skeleton, self.dtype)
        rows = self._encode(self.X[tile.top : tile.bottom])
        columns = rows if diagonal else self._encode((self.X if self.Y is None else self.Y)[tile.left : tile.right])
        lanes = loops.in_lanes(columns)
        work = WORK_PER_TASK
        if n_jobs > 1:
            work = min(work, max(LITTLE_WORK, out.size * self.work_per_pair / (TASKS_PER_JOB * n_jobs)))
        n_groups, width = len(lanes) // rows.shape[1], lanes.shape[1]
        for pairs in _pair_ranges(len(rows), n_groups, width, diagonal, max(1, int(work / self.work_per_pair))):
            yield functools.partial(
                loops.pair_distances, rows, lanes, pairs, self.metric.measure, tree, self.metric.steps, out
            )

    def _encode(self, poses: np.ndarray) -> np.ndarray:
        return self.metric.encode_poses(poses, self.skeleton).astype(self.dtype, copy=False)


def _pair_ranges(
    n_rows: int, n_groups: int, width: int, triangle: bool, pairs_per_task: int
) -> Iterator[loops.PairRange]:
    """Ranges of at most `pairs_per_task` pairs each, in groups of `width` columns."""
    group_step = min(n_groups, max(1, pairs_per_task // width))
    row_step = max(1, pairs_per_task // (group_step * width))
    for first in range(0, n_rows, row_step):
        last = min(first + row_step, n_rows)
        for group in range(first // width if triangle else 0, n_groups, group_step):
            yield loops.PairRange(first, last, group, min(group + group_step, n_groups), triangle)


TILE = 16  # rows whose full matrix costs less than as many calls


def paired_distances(
    X: np.ndarray, Y: np.ndarray, skeleton: Skeleton | None, metric: Metric, n_jobs: int
) -> np.ndarray:
    """Distances (n_poses,) from each row of X to the same row of Y, without checks."""
    distances, tile = np.empty(len(X)), 1 if metric.iterative else TILE

    def measure(rows: slice) -> list[Unconverged]:
        values, unconverged = DistanceMatrix(X[rows], Y[rows], metric, skeleton).write(None, 1)
        distances[rows] = values.diagonal()
        return unconverged

    parts = in_threads((functools.partial(measure, rows) for rows in gen_batches(len(X), tile)), n_jobs)
    warn_of_unconverged(chain.from_iterable(parts), len(X))
    return distances
