"""A matrix of distances: its tiles, the distances in each, and the work of writing them all."""

import functools
import hashlib
import json
from collections.abc import Callable, Iterator
from contextlib import closing
from importlib.metadata import version
from typing import Any

import numpy as np
from joblib import effective_n_jobs

from skpose._compiled import loops
from skpose._compiled.tree import Steps
from skpose._parallel.backends import from_workers, in_processes
from skpose._parallel.progress import progress
from skpose._parallel.tasks import LITTLE_WORK, TASKS_PER_JOB, TASKS_PER_WORKER, WORK_PER_TASK
from skpose._parallel.threads import in_threads
from skpose.kinematics._tree import tree_of
from skpose.metrics._convergence import Unconverged
from skpose.metrics._output import MIRROR_EDGE, Destination
from skpose.metrics._registry import METRICS
from skpose.metrics._tiles import Tile, Tiling
from skpose.skeleton import Skeleton

ENCODED_AT_ONCE = 4096  # poses, 12 MB for "spatial" and 56 dofs: the longest edge of a tile
SMALLEST_EDGE = 16
LARGEST_TILE, LARGEST_SENT = 2**27, 2**25  # bytes; the tiles that workers send back wait here to be written
WORK_PER_TILE = 50 * WORK_PER_TASK  # lost if it is interrupted
WORTH_SENDING = 5 * WORK_PER_TASK  # to other processes


class DistanceMatrix:
    """The distances between poses X and poses Y, where Y=None is X and one triangle is computed.

    They are computed in `dtype`, and have `result_dtype` when they are written.
    """

    def __init__(self, X: np.ndarray, Y: np.ndarray | None, metric: str, skeleton: Skeleton | None, steps: Steps):
        self.X, self.Y, self.metric, self.steps = X, Y, metric, steps
        self.skeleton = skeleton if METRICS[metric].needs_skeleton else None
        self.result_dtype = X.dtype if Y is None else np.result_type(X, Y)
        self.dtype = np.dtype(np.float64) if METRICS[metric].always_float64 else self.result_dtype
        self.shape = len(X), len(X if Y is None else Y)
        self._rows: tuple[tuple[int, int], np.ndarray] | None = None

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_rows": None}

    def __str__(self) -> str:
        return f"{self.shape[0]:,} × {self.shape[1]:,} distances"

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

    def fingerprint(self) -> dict[str, Any]:
        """Return what identifies the matrix to the last bit: digests of all that its distances depend on, by name."""
        steps = [float(step) for field in self.steps for step in np.ravel(field)]
        return {
            "version of skpose": version("skpose"),
            "metric, n_steps or wrap": [self.metric, _digest(np.array(steps))],
            "dtype": self.dtype.str,
            "X": _digest(self.X),
            "Y": "X" if self.Y is None else _digest(self.Y),
            "skeleton": _digest(*tree_of(self.skeleton)),
        }

    def tiling(self, n_threads: int, n_workers: int = 1) -> Tiling:
        """Return square tiles that take some seconds each, some for each worker; their edge is a power of two."""
        most_bytes = LARGEST_TILE if n_workers == 1 else LARGEST_SENT
        most_pairs = min(WORK_PER_TILE * n_threads / self.work_per_pair, most_bytes / self.dtype.itemsize)
        edge = ENCODED_AT_ONCE
        while edge > SMALLEST_EDGE and edge * edge > most_pairs:
            edge //= 2
        if n_workers > 1:
            enough = self.n_pairs / (TASKS_PER_WORKER * n_workers)
            while edge > SMALLEST_EDGE and edge * edge > enough and edge * edge * self.work_per_pair > WORK_PER_TASK:
                edge //= 2
        return Tiling(self.shape, edge, self.symmetric)

    def written(self, out: Any, n_jobs: int | None, verbose: int = 0) -> tuple[Any, list[Unconverged]]:
        """Compute all tiles that are not in `out` yet, None for a new array; return it and the unconverged."""
        destination = Destination(out, self.shape, self.result_dtype)
        n_workers = effective_n_jobs(n_jobs)
        remote = self.n_pairs * self.work_per_pair > WORTH_SENDING and in_processes(n_jobs)
        tiling = self.tiling(1, n_workers) if remote else self.tiling(n_workers)
        with (
            destination.resumed(tiling, self.fingerprint() if destination.resumable else None) as (tiles, parts, note),
            progress(str(self), len(tiles), verbose) as advance,
        ):
            if remote:
                results = from_workers(DistanceMatrix.distances, self, tiles, n_jobs)
            else:
                results = ((t, self.distances(t, n_workers, destination.view(t, self.dtype))) for t in tiles)
            with closing(results):  # an interruption here also ends the work of others for it
                for tile, (distances, unconverged) in results:
                    destination.write(tile, tiling.mirror_of(tile), distances)
                    note(tile, unconverged)
                    parts.append(unconverged)
                    advance()
        return destination.array, parts

    def distances(self, tile: Tile, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        """Return the distances of a tile, in `out` if that is given, and how many of them did not converge."""
        out = np.empty(tile.shape, self.dtype) if out is None else out
        diagonal = self.symmetric and tile.top == tile.left
        unconverged = Unconverged.joined(in_threads(self._tasks(tile, diagonal, n_jobs, out), n_jobs))
        if diagonal:
            _mirror(out)
        return out, unconverged

    def _tasks(
        self, tile: Tile, diagonal: bool, n_jobs: int, out: np.ndarray
    ) -> Iterator[Callable[[], tuple[int, float]]]:
        """Yield the tasks of a tile as functions to call."""
        metric = METRICS[self.metric]
        tree, loop = tree_of(self.skeleton, self.dtype), loops.pair_distances_loop(self.dtype)
        latest = self._rows
        if latest is None or latest[0] != (tile.top, tile.bottom):
            latest = self._rows = (tile.top, tile.bottom), self._encoded(self.X[tile.top : tile.bottom])
        rows = latest[1]
        columns = rows if diagonal else self._encoded((self.X if self.Y is None else self.Y)[tile.left : tile.right])
        lanes = loops.in_lanes(columns)
        work = WORK_PER_TASK
        if n_jobs > 1:
            work = min(work, max(LITTLE_WORK, out.size * self.work_per_pair / (TASKS_PER_JOB * n_jobs)))
        n_groups, width = len(lanes) // rows.shape[1], lanes.shape[1]
        for pairs in _pair_ranges(len(rows), n_groups, width, diagonal, max(1, int(work / self.work_per_pair))):
            yield functools.partial(loop, rows, lanes, pairs, metric.measure, tree, self.steps, out)

    def _encoded(self, poses: np.ndarray) -> np.ndarray:
        codes = METRICS[self.metric].encoded(poses, self.skeleton, self.steps)
        return codes.astype(self.dtype, copy=False)


def _digest(*arrays: np.ndarray) -> str:
    known = hashlib.sha256()
    for array in arrays:
        known.update(json.dumps([array.dtype.str, array.shape]).encode())
        known.update(np.ascontiguousarray(array))
    return known.hexdigest()


def _pair_ranges(
    n_rows: int, n_groups: int, width: int, triangle: bool, pairs_per_task: int
) -> Iterator[loops.PairRange]:
    """Yield ranges of no more than so many pairs each, in groups of `width` columns."""
    group_step = min(n_groups, max(1, pairs_per_task // width))
    row_step = max(1, pairs_per_task // (group_step * width))
    for first in range(0, n_rows, row_step):
        last = min(first + row_step, n_rows)
        for group in range(first // width if triangle else 0, n_groups, group_step):
            yield loops.PairRange(first, last, group, min(group + group_step, n_groups), triangle)


def _mirror(distances: np.ndarray) -> None:
    """Copy the upper triangle into the lower one, a square at a time for the cache's sake, and clear the diagonal."""
    n = len(distances)
    for start in range(0, n, MIRROR_EDGE):
        stop = min(start + MIRROR_EDGE, n)
        distances[stop:, start:stop] = distances[start:stop, stop:].T
        square = distances[start:stop, start:stop]
        square[...] = np.triu(square, 1) + np.triu(square, 1).T
