"""A matrix in tiles that is computed by threads, workers or a cluster, and written into memory or a file.

Of the matrix only its shape, the numbers of one tile and an estimate of the work are known here: `DistanceMatrix` is
one of distances between poses, `skpose.motions._matrix.MotionMatrix` one of distances between motions.
"""

import hashlib
import json
from collections.abc import Generator
from contextlib import closing
from importlib.metadata import version
from typing import Any

import numpy as np
from joblib import effective_n_jobs

from skpose._parallel.backends import from_workers, in_processes
from skpose._parallel.progress import progress
from skpose._parallel.tasks import TASKS_PER_WORKER, WORK_PER_TASK
from skpose.metrics._convergence import Unconverged
from skpose.metrics._metric import Metric
from skpose.metrics._output import Destination
from skpose.metrics._own import fingerprint_of_functions
from skpose.metrics._run import Computed, WorkerOutput
from skpose.metrics._tiles import Tile, Tiling

LARGEST_TILE, LARGEST_SENT = 2**27, 2**25  # bytes; the tiles that workers send back wait here to be written
WORK_PER_TILE = 50 * WORK_PER_TASK  # lost if it is interrupted
WORTH_SENDING = 5 * WORK_PER_TASK  # to other processes


class TiledMatrix:
    """The distances between some rows and some columns, computed in `dtype` and written in `result_dtype`."""

    shape: tuple[int, int]
    dtype: np.dtype
    result_dtype: np.dtype
    smallest_edge: int  # of a tile; a power of two

    def __str__(self) -> str:
        return f"{self.shape[0]:,} × {self.shape[1]:,} distances"

    @property
    def symmetric(self) -> bool:
        """True where one triangle is computed, and the diagonal is zero."""
        raise NotImplementedError

    @property
    def largest_edge(self) -> int:
        """The longest edge of a tile, a power of two."""
        raise NotImplementedError

    @property
    def n_pairs(self) -> int:
        return self.shape[0] * (self.shape[0] - 1) // 2 if self.symmetric else self.shape[0] * self.shape[1]

    @property
    def work_per_pair(self) -> float:
        """The mean work, in the unit of `skpose._parallel.tasks`."""
        raise NotImplementedError

    def fingerprint(self) -> dict[str, Any]:
        """Return what identifies the matrix to the last bit: digests of all that its distances depend on, by name."""
        raise NotImplementedError

    def distances(self, tile: Tile, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        """Return the distances of a tile, in `out` if that is given, and how many geodesics did not converge."""
        raise NotImplementedError

    def tiling(self, n_threads: int, n_workers: int = 1, chunk: int = 1) -> Tiling:
        """Return square tiles that take some seconds each, some for each worker; their edge is a power of two.

        Where the edge of a chunk of the destination is no longer than that, it is a multiple of the chunk's edge; for
        workers also where it is no longer than the tiles of one process are.
        """
        most_bytes = LARGEST_TILE if n_workers == 1 else LARGEST_SENT
        most_pairs = min(WORK_PER_TILE * n_threads / self.work_per_pair, most_bytes / self.dtype.itemsize)
        edge, smallest = self.largest_edge, self.smallest_edge
        while edge > smallest and edge * edge > most_pairs:
            edge //= 2
        longest = edge
        if n_workers > 1:
            enough = self.n_pairs / (TASKS_PER_WORKER * n_workers)
            while edge > smallest and edge * edge > enough and edge * edge * self.work_per_pair > WORK_PER_TASK:
                edge //= 2
        return Tiling(self.shape, edge, self.symmetric).in_chunks(chunk, longest)

    def write(self, out: Any, n_jobs: int | None, verbose: int = 0) -> tuple[Any, list[Unconverged]]:
        """Compute all tiles that are not in `out` yet, None for a new array; return it and the unconverged."""
        destination = Destination(out, self.shape, self.result_dtype)
        n_workers = effective_n_jobs(n_jobs)
        remote = self.n_pairs * self.work_per_pair > WORTH_SENDING and in_processes(n_jobs)
        n_threads = 1 if remote else n_workers
        tiling = self.tiling(n_threads, n_workers if remote else 1, destination.chunk)
        with destination.start_run(tiling, self.fingerprint() if destination.resumable else None) as run:
            run.resume(n_jobs, n_threads, remote)
            results: Generator[tuple[Tile, Computed], None, None]
            if remote:
                results = from_workers(_compute_in_worker, (self, run.output), run.tiles, n_jobs)
            else:
                results = ((t, self._compute(t, n_workers, destination.view(t, self.dtype))) for t in run.tiles)
            with (
                progress(str(self), len(run.tiles), verbose) as advance,
                closing(results),  # an interruption here also ends the work of others for it
                closing(run.complete(results)) as completed,
            ):
                for _ in completed:
                    advance()
        return destination.array, run.unconverged

    def _compute(self, tile: Tile, n_jobs: int, out: np.ndarray | None) -> Computed:
        distances, unconverged = self.distances(tile, n_jobs, out)
        return Computed(unconverged, distances)


def _compute_in_worker(shared: tuple[TiledMatrix, WorkerOutput | None], tile: Tile) -> Computed:
    """Compute a tile in a worker, and write it there where that is possible."""
    matrix, output = shared
    distances, unconverged = matrix.distances(tile)
    return Computed(unconverged, distances) if output is None else output.write(tile, distances, unconverged)


def metric_fingerprint(metric: Metric) -> dict[str, Any]:
    """Return the part of a fingerprint that is of the version and the metric."""
    kind = type(metric)
    return {
        "version of skpose": version("skpose"),
        "metric or parameters of it": [
            f"{kind.__module__}.{kind.__qualname__}",
            *map(repr, metric._parameters()),
            *fingerprint_of_functions(metric),
        ],
    }


def digest(*arrays: np.ndarray) -> str:
    known = hashlib.sha256()
    for array in arrays:
        known.update(json.dumps([array.dtype.str, array.shape]).encode())
        known.update(np.ascontiguousarray(array))
    return known.hexdigest()
