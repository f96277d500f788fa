"""Poses in dask arrays give lazy distances, equal to those that are computed at once."""

import dask
import dask.array as da
import numpy as np
import pytest
from conftest import random_tree

from skpose import Skeleton, pose_distances

TREE = random_tree(0)


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(size=(50, TREE.n_dofs))


@pytest.mark.parametrize(
    ("metric", "chunks", "dtype"),
    [("spatial", (20, -1), np.float32), ("angle", (7, 10), np.int64), ("rotation", (50, -1), np.float64)],
)
def test_the_same_to_the_last_bit(X, chunks, metric, dtype):
    X = X.astype(dtype)
    Y, parameters = X[:30] + dtype(1), {"skeleton": TREE, "metric": metric}
    lazy = da.from_array(X, chunks=chunks)
    for ours, expected in [
        (pose_distances(lazy, **parameters), pose_distances(X, **parameters)),
        (pose_distances(lazy, da.from_array(Y, chunks=(11, -1)), **parameters), pose_distances(X, Y, **parameters)),
        (pose_distances(Y, lazy, **parameters), pose_distances(Y, X, **parameters)),
    ]:
        assert (ours.dtype, ours.shape) == (expected.dtype, expected.shape)
        np.testing.assert_array_equal(ours.compute(scheduler="synchronous"), expected)


def test_geodesics(X):
    arm, poses = Skeleton.chain(3), X[:12, :3]
    lazy = pose_distances(da.from_array(poses, chunks=(5, -1)), skeleton=arm, metric="geodesic")
    np.testing.assert_array_equal(lazy.compute(), pose_distances(poses, skeleton=arm, metric="geodesic"))


def test_only_what_is_needed_is_computed(X):
    rows = []

    def read(chunk):
        rows.append(len(chunk))
        return chunk

    lazy = da.from_array(X, chunks=(10, -1)).map_blocks(read, dtype=X.dtype, meta=np.empty((0, 0)))
    D = pose_distances(lazy, skeleton=TREE)
    assert rows == []
    corner = D[:10, :10].compute(scheduler="synchronous")
    assert rows == [10]
    np.testing.assert_array_equal(corner, pose_distances(X[:10], skeleton=TREE))
    (optimised,) = dask.optimize(pose_distances(da.from_array(X, chunks=(5, -1)), skeleton=TREE))
    assert sum("Skeleton(" in repr(task) for task in optimised.__dask_graph__().values()) <= 1  # sent once


def test_bad_input_is_refused(X):
    lazy = da.from_array(X, chunks=(20, -1))
    for call, message in [
        (lambda: pose_distances(lazy[:, :5], skeleton=TREE), "X has 5 columns"),
        (lambda: pose_distances(lazy, lazy[:, :5], metric="angle"), "Y has 5"),
        (lambda: pose_distances(lazy[lazy[:, 0] > 0], skeleton=TREE), "compute_chunk_sizes"),
        (lambda: pose_distances(lazy, metric="angle", out=np.empty((50, 50))), "out"),
        (lambda: pose_distances(lazy, da.full_like(lazy, np.nan), skeleton=TREE).compute(), "Y contains NaN"),
    ]:
        with pytest.raises(ValueError, match=message):
            call()
