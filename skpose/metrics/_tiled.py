"""A matrix of distances that is computed tile by tile, and written into memory or into any other array.

`DistanceMatrix` has the distances between poses, `skpose.motions._matrix.MotionMatrix` those between motions.
"""

import functools
from contextlib import closing
from typing import Any, NamedTuple

import numpy as np
from joblib import effective_n_jobs

from skpose._utils.backends import from_workers, in_processes
from skpose._utils.parallel import TASKS_PER_WORKER, WORK_PER_TASK, in_threads
from skpose._utils.progress import progress
from skpose.metrics._convergence import Unconverged

LARGEST_TILE, LARGEST_SENT = 2**27, 2**25  # bytes; tiles that workers send back wait here to be written
WORK_PER_TILE = 50 * WORK_PER_TASK
WORTH_SENDING = 5 * WORK_PER_TASK  # to other processes
TRANSPOSED_EDGE = 512  # of the squares that are transposed at once, which fit into the cache
EDGE = 128  # of the squares that are mirrored; in both smaller and larger ones a number takes more time
WORTH_A_THREAD = 2**19  # numbers to mirror, some milliseconds


class Tile(NamedTuple):
    """Rows top:bottom and columns left:right of a matrix."""

    top: int
    bottom: int
    left: int
    right: int

    @property
    def slices(self) -> tuple[slice, slice]:
        return slice(self.top, self.bottom), slice(self.left, self.right)

    @property
    def shape(self) -> tuple[int, int]:
        return self.bottom - self.top, self.right - self.left


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
        """Whether only one triangle is computed; the diagonal is then zero."""
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
        """The mean work, in the unit of `skpose._utils.parallel`."""
        raise NotImplementedError

    def distances(self, tile: Tile, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        """The distances of a tile, in `out` if given, and how many geodesics did not converge."""
        raise NotImplementedError

    def tiles(self, n_threads: int, n_workers: int = 1, chunks: tuple[int, ...] = (1,)) -> list[Tile]:
        """Square tiles that take some seconds each, with several for each worker.

        Their edge is a power of two, or a multiple of the edges of the chunks in which `out` is stored, unless these
        are longer than a tile. Of a symmetric matrix, only the tiles on the diagonal and above it.
        """
        most_bytes = LARGEST_TILE if n_workers == 1 else LARGEST_SENT
        most_pairs = min(WORK_PER_TILE * n_threads / self.work_per_pair, most_bytes / self.dtype.itemsize)
        edge, smallest, chunk = self.largest_edge, self.smallest_edge, int(np.lcm.reduce(chunks))
        while edge > smallest and edge * edge > most_pairs:
            edge //= 2
        longest = edge
        if n_workers > 1:
            enough = self.n_pairs / (TASKS_PER_WORKER * n_workers)
            while edge > smallest and edge * edge > enough and edge * edge * self.work_per_pair > WORK_PER_TASK:
                edge //= 2
        if chunk <= longest:
            edge = max(chunk, edge // chunk * chunk)
        n_rows, n_columns = self.shape
        return [
            Tile(top, min(top + edge, n_rows), left, min(left + edge, n_columns))
            for top in range(0, n_rows, edge)
            for left in range(top if self.symmetric else 0, n_columns, edge)
        ]

    def write(self, out: Any, n_jobs: int | None, verbose: int = 0) -> tuple[Any, list[Unconverged]]:
        """Write each tile into `out` once it is computed, None for a new array; return it and the unconverged."""
        out = np.empty(self.shape, self.result_dtype) if out is None else out
        self._check_out(out)
        n_workers = effective_n_jobs(n_jobs)
        remote = self.n_pairs * self.work_per_pair > WORTH_SENDING and in_processes(n_jobs)
        chunks = getattr(out, "shards", None) or getattr(out, "chunks", None) or (1,)  # of zarr or h5py
        tiles = self.tiles(1, n_workers, chunks) if remote else self.tiles(n_workers, 1, chunks)
        array = np.asarray(out) if isinstance(out, np.ndarray) else None
        if remote:
            results = from_workers(type(self).distances, self, tiles, n_jobs)
        else:
            results = ((tile, self.distances(tile, n_workers, self._part(array, tile))) for tile in tiles)
        unconverged = []
        with progress(str(self), len(tiles), verbose) as advance, closing(results):  # which also stops the workers
            for tile, (distances, count) in results:
                self._write_tile(out if array is None else array, tile, distances)
                unconverged.append(count)
                advance()
        return out, unconverged

    def _check_out(self, out: Any) -> None:
        shape, dtype = tuple(getattr(out, "shape", self.shape)), getattr(out, "dtype", self.result_dtype)
        if shape != self.shape or dtype != self.result_dtype:
            raise ValueError(
                f"out must have shape {self.shape} and dtype {self.result_dtype}, got shape {shape} and dtype {dtype}"
            )
        if isinstance(out, np.ndarray) and not out.flags.writeable:
            raise ValueError("out must be writeable, got a read-only array")

    def _part(self, array: np.ndarray | None, tile: Tile) -> np.ndarray | None:
        """The part of an array into which the distances of a tile can be computed, None if they must be copied."""
        return array[tile.slices] if array is not None and array.dtype == self.dtype and array.flags.aligned else None

    def _write_tile(self, out: Any, tile: Tile, distances: np.ndarray) -> None:
        """Write a tile, unless it was computed in place, and its mirror image."""
        rows, columns = tile.slices
        mirrored = self.symmetric and tile.top != tile.left
        if not isinstance(out, np.ndarray):
            distances = distances.astype(self.result_dtype, copy=False)
            out[rows, columns] = distances
            if mirrored:
                out[columns, rows] = np.ascontiguousarray(distances.T)
            return
        if not np.may_share_memory(distances, out):
            out[rows, columns] = distances
        if mirrored:
            _transpose(distances, out[columns, rows])


def _transpose(distances: np.ndarray, target: np.ndarray) -> None:
    """Copy the transpose, one square at a time.

    Each square is first copied to rows whose distance is not a power of two, which would share a few places of the
    cache and take twice as long.
    """
    edge = min(TRANSPOSED_EDGE, max(target.shape))
    square = np.empty((edge, edge + 16), target.dtype)
    for top in range(0, len(target), edge):
        for left in range(0, target.shape[1], edge):
            part = distances[left : left + edge, top : top + edge]
            copied = square[: part.shape[0], : part.shape[1]]
            copied[...] = part
            target[top : top + edge, left : left + edge] = copied.T


def mirror(distances: np.ndarray, n_threads: int) -> None:
    """Copy the upper triangle into the lower one, and clear the diagonal."""

    def fill_rows(top: int) -> None:
        rows = slice(top, top + EDGE)
        for left in range(0, top, EDGE):
            columns = slice(left, left + EDGE)
            distances[rows, columns] = distances[columns, rows].T
        square = distances[rows, rows]
        square[...] = np.triu(square, 1) + np.triu(square, 1).T

    tops = range(0, len(distances), EDGE)[::-1]  # the longest rows first, so that no thread waits for another
    n_threads = max(1, min(n_threads, distances.size // 2 // WORTH_A_THREAD))
    in_threads((functools.partial(fill_rows, top) for top in tops), n_threads)
