"""A matrix of distances between poses: the numbers of each tile, and their cost."""

import functools
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils import gen_batches

from skpose._compiled.pose import loops
from skpose._utils.parallel import (
    LITTLE_WORK,
    TASKS_PER_JOB,
    TASKS_PER_WORKER,
    WORK_PER_TASK,
    from_workers,
    in_processes,
    in_threads,
)
from skpose._utils.progress import progress
from skpose._utils.validation import check_layout, check_poses, check_same_width, check_width
from skpose._utils.warnings import warn
from skpose.metrics._metric import Metric
from skpose.skeleton import Skeleton


class Unconverged(NamedTuple):
    """Number of geodesics that did not converge, and the largest relative gap of these curves.

    The gap is between the length of a curve, measured on a fine grid, and the sum of its chords.
    """

    count: int  # type: ignore[assignment]  # which is a method of tuples too
    gap: float

    @classmethod
    def join(cls, parts: Iterable[tuple[int, float]]) -> "Unconverged":
        """Sum of the counts and maximum of the gaps."""
        counts, gaps = zip((0, 0.0), *parts, strict=True)
        return cls(sum(counts), max(gaps))


def warn_of_unconverged(parts: Iterable[tuple[int, float]], n_pairs: int) -> None:
    """Warn if some geodesics did not converge."""
    count, gap = Unconverged.join(parts)
    if count:
        warn(
            f"{count} of {n_pairs} geodesics did not converge: the curves found may not be the shortest. The largest "
            f"relative gap between the length of one and the sum of its chords is {gap:.2g}",
            ConvergenceWarning,
        )


# --- tiled ------------------------------------------------------------------------------------------------------------
# A matrix of distances that is computed tile by tile, and written into memory or into any other array.
#
# `DistanceMatrix` has the distances between poses, `skpose.motions._distances.MotionMatrix` those between motions.


LARGEST_TILE, LARGEST_SENT = 2**27, 2**25  # bytes; tiles that workers send back wait here to be written
WORK_PER_TILE = 50 * WORK_PER_TASK
WORTH_SENDING = 5 * WORK_PER_TASK  # to other processes
EDGE = 256  # of the squares that are transposed at once, which fit into the cache
WORTH_A_THREAD = 2**19  # numbers to mirror, some milliseconds


Tile = tuple[slice, slice]  # rows and columns of a matrix


class TiledMatrix:
    """The distances between some rows and some columns, computed in `dtype` and written in `result_dtype`."""

    shape: tuple[int, int]
    dtype: np.dtype
    result_dtype: np.dtype
    symmetric: bool  # whether only one triangle is computed; the diagonal is then zero
    smallest_edge: int  # of a tile; a power of two

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
            (slice(top, min(top + edge, n_rows)), slice(left, min(left + edge, n_columns)))
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
        array = np.asarray(out) if isinstance(out, np.ndarray) else out
        in_place = isinstance(array, np.ndarray) and array.dtype == self.dtype and array.flags.aligned
        if remote:
            results = from_workers(type(self).distances, self, tiles, n_jobs)
        else:
            results = ((tile, self.distances(tile, n_workers, array[tile] if in_place else None)) for tile in tiles)
        unconverged = []
        what = f"{self.shape[0]:,} × {self.shape[1]:,} distances"
        with progress(what, len(tiles), verbose) as advance, closing(results):  # which also stops the workers
            for tile, (distances, count) in results:
                self._write_tile(array, tile, distances)
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

    def _write_tile(self, out: Any, tile: Tile, distances: np.ndarray) -> None:
        """Write a tile, unless it was computed in place, and its mirror image."""
        rows, columns = tile
        distances = distances.astype(self.result_dtype, copy=False)
        if not isinstance(out, np.ndarray) or not np.may_share_memory(distances, out):
            out[rows, columns] = distances
        if self.symmetric and rows.start != columns.start:
            if isinstance(out, np.ndarray):
                _transpose(distances, out[columns, rows])
            else:
                out[columns, rows] = np.ascontiguousarray(distances.T)


def _transpose(distances: np.ndarray, target: np.ndarray) -> None:
    """Copy the transpose, one square at a time.

    Each square is first copied to rows whose distance is not a power of two, which would share a few places of the
    cache and take twice as long.
    """
    square = np.empty((EDGE, EDGE + 16), target.dtype)
    for top in range(0, len(target), EDGE):
        for left in range(0, target.shape[1], EDGE):
            part = distances[left : left + EDGE, top : top + EDGE]
            copied = square[: part.shape[0], : part.shape[1]]
            copied[...] = part
            target[top : top + EDGE, left : left + EDGE] = copied.T


def mirror(distances: np.ndarray, n_threads: int) -> None:
    """Copy the upper triangle into the lower one, and clear the diagonal."""

    def fill_rows(top: int) -> None:
        rows = slice(top, top + EDGE)
        _transpose(distances[:top, rows], distances[rows, :top])
        square = distances[rows, rows]
        square[...] = np.triu(square, 1) + np.triu(square, 1).T

    tops = range(0, len(distances), EDGE)[::-1]  # the longest rows first, so that no thread waits for another
    n_threads = max(1, min(n_threads, distances.size // 2 // WORTH_A_THREAD))
    in_threads((functools.partial(fill_rows, top) for top in tops), n_threads)


# --- matrix -----------------------------------------------------------------------------------------------------------


ENCODED_AT_ONCE = 4096  # poses, 12 MB for "spatial" and 56 dofs: the longest edge of a tile


class DistanceMatrix(TiledMatrix):
    """The distances between poses X and poses Y, where Y=None is X and one triangle is computed."""

    smallest_edge = 16

    def __init__(self, X: np.ndarray, Y: np.ndarray | None, metric: Metric, skeleton: Skeleton | None):
        self.X, self.Y, self.metric = X, Y, metric
        self.skeleton = skeleton if metric.needs_skeleton else None
        self.result_dtype = X.dtype if Y is None else np.result_type(X, Y)
        self.dtype = np.dtype(np.float64) if metric.iterative else self.result_dtype
        self.shape, self.symmetric = (len(X), len(X if Y is None else Y)), Y is None

    @property
    def largest_edge(self) -> int:
        return ENCODED_AT_ONCE

    @functools.cached_property
    def work_per_pair(self) -> float:
        n_codes = self.metric.n_codes(self.metric.tree_for(self.skeleton), self.X.shape[1])
        return max(1.0, n_codes * self.metric.measure_work)

    def distances(self, tile: Tile, n_jobs: int = 1, out: np.ndarray | None = None) -> tuple[np.ndarray, Unconverged]:
        """The distances of a tile, in `out` if given, and how many geodesics did not converge."""
        rows, columns = tile
        shape = rows.stop - rows.start, columns.stop - columns.start
        out = np.empty(shape, self.dtype) if out is None else out
        diagonal = self.symmetric and rows.start == columns.start
        unconverged = Unconverged.join(in_threads(self._tasks(tile, diagonal, n_jobs, out), n_jobs))
        if diagonal:
            mirror(out, n_jobs)
        return out, unconverged

    def _tasks(
        self, tile: Tile, diagonal: bool, n_jobs: int, out: np.ndarray
    ) -> Iterator[Callable[[], tuple[int, float]]]:
        """The tasks of a tile, as functions to call."""
        tree = self.metric.tree_for(self.skeleton, self.dtype)
        rows = self._encode(self.X[tile[0]])
        columns = rows if diagonal else self._encode((self.X if self.Y is None else self.Y)[tile[1]])
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


# --- dask -------------------------------------------------------------------------------------------------------------
# Lazy distances between poses in dask arrays, one tile for each pair of chunks.


def is_lazy(X: Any) -> bool:
    """Whether this is a dask array, without importing dask."""
    arrays = sys.modules.get("dask.array")
    return arrays is not None and isinstance(X, arrays.Array)


def lazy_distances(X: Any, Y: Any, skeleton: Skeleton | None, metric: Metric) -> Any:
    """Dask array of the distances between X and Y, or among X.

    Shapes are checked at once, numbers when a tile is computed.
    """
    import dask.array as da
    from dask.delayed import delayed

    symmetric = Y is None or Y is X
    X, Y = _rechunk_rows(da, X, skeleton, "X"), None if symmetric else _rechunk_rows(da, Y, skeleton, "Y")
    if not symmetric:
        check_same_width(X, Y)
    dtype = np.result_type(X.dtype, X.dtype if symmetric else Y.dtype)
    shared = delayed((metric, skeleton), pure=True)  # so that it is sent once
    options = {"dtype": dtype, "meta": np.empty((0, 0), dtype), "concatenate": True, "align_arrays": False}
    if not symmetric:
        return da.blockwise(_distances, "ij", X, "ik", Y, "jk", shared=shared, **options)
    number = da.arange(X.numblocks[0], chunks=1)
    numbers = number, "i", number, "j"
    upper = da.blockwise(_upper_distances, "ij", X, "ik", X, "jk", *numbers, shared=shared, **options)
    return da.blockwise(_mirror_below_diagonal, "ij", upper, "ij", upper, "ji", *numbers, **options)


def _rechunk_rows(da: Any, X: Any, skeleton: Skeleton | None, name: str) -> Any:
    """Make each chunk hold whole poses."""
    check_layout(X, skeleton, name)
    X = da.asarray(X)
    if X.ndim != 2 or np.isnan(X.shape[1]):
        raise ValueError(f"{name} must have two dimensions and a known number of columns, got {X}")
    if np.isnan(X.shape[0]):
        raise ValueError(f"{name} has chunks of unknown length; call {name}.compute_chunk_sizes() first")
    if skeleton is not None:
        check_width(X, skeleton, name)
    if X.dtype != np.float32:
        X = X.astype(np.float64)
    return X.rechunk({1: -1})


def _distances(X: Any, Y: Any, shared: tuple, name: str = "Y") -> np.ndarray:
    """Distances between two chunks, or among one if Y is None; `name` is the array of the second chunk."""
    metric, skeleton = shared
    X, Y = check_poses(X, skeleton, "X"), None if Y is None else check_poses(Y, skeleton, name)
    matrix = DistanceMatrix(X, Y, metric, skeleton)
    distances, unconverged = matrix.write(None, n_jobs=1)
    warn_of_unconverged(unconverged, matrix.n_pairs)
    return distances


def _upper_distances(X: Any, Y: Any, row: Any, column: Any, shared: tuple) -> np.ndarray:
    """A tile on the diagonal or above it; below it zeros, which `_mirror_below_diagonal` does not read."""
    if row[0] > column[0]:
        return np.broadcast_to(np.zeros((), X.dtype), (len(X), len(Y)))
    return _distances(X, None if row[0] == column[0] else Y, shared, name="X")


def _mirror_below_diagonal(tile: Any, mirrored: Any, row: Any, column: Any) -> np.ndarray:
    return mirrored.T if row[0] > column[0] else tile
