"""Lazy distances between poses in dask arrays, one tile for each pair of chunks."""

import sys
from typing import Any

import numpy as np

from skpose._utils.validation import check_dimensions, check_is_array, check_poses, check_same_width, check_width
from skpose.metrics._convergence import warn_of_unconverged
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._metric import Metric
from skpose.skeleton import Skeleton


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
    check_is_array(X, name)
    X = da.asarray(X)
    if skeleton is not None:
        check_dimensions(X, skeleton, name)
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
