"""A matrix of distances, block by block."""

import functools
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from skpose._compiled import loops
from skpose._compiled.tree import Steps
from skpose._parallel.tasks import BLOCKS_PER_WORKER, LITTLE_WORK, TASKS_PER_JOB, WORK_PER_TASK
from skpose._parallel.threads import in_threads
from skpose.kinematics._tree import tree_of
from skpose.metrics._convergence import Unconverged
from skpose.metrics._registry import METRICS
from skpose.skeleton import Skeleton

PANEL = 4096  # poses that are encoded at once, 12 MB for "spatial" and 56 dofs
SMALLEST_EDGE = 16
LARGEST_BLOCK, LARGEST_SHIPPED = 2**27, 2**25  # bytes; what workers send back waits here to be written
WORK_PER_BLOCK = 50 * WORK_PER_TASK  # what is lost if it is interrupted
MIRROR_BLOCK = 512


class Block(NamedTuple):
    """Rows top:bottom and columns left:right of a matrix."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def place(self) -> tuple[slice, slice]:
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def mirrored(self) -> "Block":
        return Block(self.left, self.right, self.top, self.bottom)

    @property
    def shape(self) -> tuple[int, int]:
        return self.bottom - self.top, self.right - self.left


class DistanceMatrix:
    """The distances between poses X and poses Y, where Y=None is X and one triangle is computed."""

    def __init__(
        self, X: np.ndarray, Y: np.ndarray | None, metric: str, skeleton: Skeleton | None, steps: Steps, dtype: np.dtype
    ):
        self.X, self.Y, self.metric, self.steps = X, Y, metric, steps
        self.skeleton = skeleton if METRICS[metric].needs_skeleton else None
        self.dtype = np.dtype(np.float64) if METRICS[metric].always_float64 else dtype
        self.shape = len(X), len(X if Y is None else Y)
        self._rows: tuple[tuple[int, int], np.ndarray] | None = None

    def __getstate__(self):
        return self.__dict__ | {"_rows": None}

    @property
    def symmetric(self) -> bool:
        return self.Y is None

    @property
    def n_pairs(self) -> int:
        return self.shape[0] * (self.shape[0] - 1) // 2 if self.symmetric else self.shape[0] * self.shape[1]

    @functools.cached_property
    def work_per_pair(self) -> float:
        metric = METRICS[self.metric]
        return max(1.0, metric.n_codes(tree_of(self.skeleton), self.X.shape[1]) * metric.measure_work)

    def edge(self, n_threads: int, n_workers: int = 1) -> int:
        """Of square blocks that take some seconds each, and of which there are some for each worker, a power of two."""
        most_bytes = LARGEST_BLOCK if n_workers == 1 else LARGEST_SHIPPED
        most_pairs = min(WORK_PER_BLOCK * n_threads / self.work_per_pair, most_bytes / self.dtype.itemsize)
        edge = PANEL
        while edge > SMALLEST_EDGE and edge * edge > most_pairs:
            edge //= 2
        if n_workers > 1:
            enough = self.n_pairs / (BLOCKS_PER_WORKER * n_workers)
            while edge > SMALLEST_EDGE and edge * edge > enough and edge * edge * self.work_per_pair > WORK_PER_TASK:
                edge //= 2
        return edge

    def blocks(self, edge: int) -> list[Block]:
        """All blocks, or those on the diagonal and above it, row by row."""
        n_rows, n_columns = self.shape
        return [
            Block(top, min(top + edge, n_rows), left, min(left + edge, n_columns))
            for top in range(0, n_rows, edge)
            for left in range(top if self.symmetric else 0, n_columns, edge)
        ]

    def distances(self, block: Block, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        """The distances of a block, in `out` if that is given, and how many of them are in doubt."""
        out = np.empty(block.shape, self.dtype) if out is None else out
        diagonal = self.symmetric and block.top == block.left
        unconverged = Unconverged.joined(in_threads(self._tasks(block, diagonal, n_jobs, out), n_jobs))
        if diagonal:
            mirror(out)
        return out, unconverged

    def _tasks(
        self, block: Block, diagonal: bool, n_jobs: int, out: np.ndarray
    ) -> Iterator[Callable[[], tuple[int, float]]]:
        """Tiles of a block as functions to call."""
        metric = METRICS[self.metric]
        tree, loop = tree_of(self.skeleton, self.dtype), loops.pair_distances_loop(self.dtype)
        held = self._rows
        if held is None or held[0] != (block.top, block.bottom):
            held = self._rows = (block.top, block.bottom), self._encoded(self.X[block.top : block.bottom])
        rows = held[1]
        columns = rows if diagonal else self._encoded((self.X if self.symmetric else self.Y)[block.left : block.right])
        lanes = loops.in_lanes(columns)
        work = WORK_PER_TASK
        if n_jobs > 1:
            work = min(work, max(LITTLE_WORK, out.size * self.work_per_pair / (TASKS_PER_JOB * n_jobs)))
        n_blocks, width = len(lanes) // rows.shape[1], lanes.shape[1]
        for tile in _tiles(len(rows), n_blocks, width, diagonal, max(1, int(work / self.work_per_pair))):
            pairs = loops.PairRange(*tile, diagonal)
            yield functools.partial(loop, rows, lanes, pairs, metric.measure, tree, self.steps, out)

    def _encoded(self, poses: np.ndarray) -> np.ndarray:
        codes = METRICS[self.metric].encoded(poses, self.skeleton, self.steps)
        return codes.astype(self.dtype, copy=False)


def _tiles(
    n_rows: int, n_blocks: int, width: int, triangle: bool, pairs_per_task: int
) -> Iterator[tuple[int, int, int, int]]:
    """First and last row, first and last block of lanes of tiles of no more than so many pairs each."""
    block_step = min(n_blocks, max(1, pairs_per_task // width))
    row_step = max(1, pairs_per_task // (block_step * width))
    for first in range(0, n_rows, row_step):
        last = min(first + row_step, n_rows)
        for block in range(first // width if triangle else 0, n_blocks, block_step):
            yield first, last, block, min(block + block_step, n_blocks)


def mirror(distances: np.ndarray) -> None:
    """Copy the upper triangle into the lower one, by blocks for the cache's sake, and clear the diagonal."""
    n = len(distances)
    for start in range(0, n, MIRROR_BLOCK):
        stop = min(start + MIRROR_BLOCK, n)
        distances[stop:, start:stop] = distances[start:stop, stop:].T
        block = distances[start:stop, start:stop]
        block[...] = np.triu(block, 1) + np.triu(block, 1).T
