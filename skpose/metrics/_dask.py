"""Lazy distances between poses in dask arrays."""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from skpose.skeleton import Skeleton
from skpose.skeleton._validation import check_same_width, check_width


def is_lazy(X: Any) -> bool:
    """Whether this is a dask array, without importing dask."""
    arrays = sys.modules.get("dask.array")
    return arrays is not None and isinstance(X, arrays.Array)


def lazy_distances(pose_distances: Callable, X: Any, Y: Any, skeleton: Skeleton | None, **parameters) -> Any:
    """A dask array of the distances between X and Y, or among X; a block for each chunk of poses of either.

    What can be checked without computing is checked at once, the numbers themselves when a block is computed.
    """
    import dask
    import dask.array as da

    symmetric = Y is None or Y is X
    X, Y = _whole_rows(da, X, skeleton, "X"), None if symmetric else _whole_rows(da, Y, skeleton, "Y")
    if not symmetric:
        check_same_width(X, Y)
    dtype = np.result_type(X.dtype, X.dtype if symmetric else Y.dtype)
    shared = dask.delayed((skeleton, parameters), pure=True)  # so that it is shipped once
    options = {"dtype": dtype, "meta": np.empty((0, 0), dtype), "concatenate": True}
    if not symmetric:
        return da.blockwise(
            _distances, "ij", X, "ik", Y, "jk", pose_distances=pose_distances, shared=shared, dtype_=dtype, **options
        )
    n_blocks = X.numblocks[0]
    number = da.arange(n_blocks, chunks=1)
    upper = da.blockwise(
        _upper_distances,
        "ij",
        *(X, "ik", X, "jk", number, "i", number, "j"),
        pose_distances=pose_distances,
        shared=shared,
        dtype_=dtype,
        align_arrays=False,
        **options,
    )
    return da.blockwise(
        _mirrored, "ij", upper, "ij", upper, "ji", number, "i", number, "j", align_arrays=False, **options
    )


def _whole_rows(da: Any, X: Any, skeleton: Skeleton | None, name: str) -> Any:
    """An array of which every chunk has whole poses."""
    X = da.asarray(X)
    if X.ndim != 2 or np.isnan(X.shape[1]):
        raise ValueError(f"{name} must be a two-dimensional array with a known number of columns, got {X}")
    if np.isnan(X.shape[0]):
        raise ValueError(f"{name} has chunks of unknown length; call {name}.compute_chunk_sizes() first")
    if skeleton is not None:
        check_width(X, skeleton, name)
    if X.dtype != np.float32:
        X = X.astype(np.float64)
    return X.rechunk({1: -1})


def _distances(X, Y, pose_distances, shared, dtype_):
    skeleton, parameters = shared
    return pose_distances(X, Y, skeleton=skeleton, n_jobs=1, **parameters).astype(dtype_, copy=False)


def _upper_distances(X, Y, row, column, pose_distances, shared, dtype_):
    """A block on the diagonal or above it; below it nothing, which `_mirrored` does not look at."""
    if row[0] > column[0]:
        return np.broadcast_to(np.zeros((), dtype_), (len(X), len(Y)))
    return _distances(X, None if row[0] == column[0] else Y, pose_distances, shared, dtype_)


def _mirrored(block, mirror, row, column):
    return mirror.T if row[0] > column[0] else block
