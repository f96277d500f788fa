"""Poses in dask arrays give lazy distances, the same as those that are computed at once."""

import dask
import dask.array as da
import numpy as np
import pytest
from conftest import in_turns, random_tree

from skpose import Skeleton, pose_distances
from skpose.metrics._registry import METRICS

TREE = random_tree(0)
CHUNKS = [(20, -1), (7, 10), (50, -1)]


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).normal(size=(50, TREE.n_dofs))


@pytest.mark.parametrize(
    ("metric", "chunks", "dtype"),
    in_turns(["auto", *(name for name in METRICS if name != "geodesic")], CHUNKS, [np.float32, np.float64, np.int64]),
)
def test_the_same_to_the_last_bit(X, chunks, metric, dtype):
    X = X.astype(dtype)
    Y = X[:30] + dtype(1)
    parameters = {"skeleton": TREE, "metric": metric}
    lazy = da.from_array(X, chunks=chunks)
    for ours, expected in [
        (pose_distances(lazy, **parameters), pose_distances(X, **parameters)),
        (pose_distances(lazy, lazy, **parameters), pose_distances(X, **parameters)),
        (pose_distances(lazy, da.from_array(Y, chunks=(11, -1)), **parameters), pose_distances(X, Y, **parameters)),
        (pose_distances(lazy, Y, **parameters), pose_distances(X, Y, **parameters)),
        (pose_distances(Y, lazy, **parameters), pose_distances(Y, X, **parameters)),
    ]:
        assert isinstance(ours, da.Array)
        assert (ours.dtype, ours.shape) == (expected.dtype, expected.shape)
        found = ours.compute(scheduler="synchronous")
        assert (type(found), found.dtype) == (np.ndarray, expected.dtype)
        np.testing.assert_array_equal(found, expected)


def test_nothing_is_computed_before_it_is_asked_for(X):
    rows = []

    def read(chunk):
        rows.append(len(chunk))
        return chunk

    lazy = da.from_array(X, chunks=(10, -1)).map_blocks(read, dtype=X.dtype, meta=np.empty((0, 0)))
    D = pose_distances(lazy, skeleton=TREE)
    assert rows == []
    assert D.chunks == ((10,) * 5, (10,) * 5)
    corner = D[:10, :10].compute(scheduler="synchronous")
    assert rows == [10]
    np.testing.assert_array_equal(corner, pose_distances(X[:10], skeleton=TREE))


def test_the_skeleton_is_one_task_of_the_graph(X):
    D = pose_distances(da.from_array(X, chunks=(5, -1)), skeleton=TREE)
    (optimised,) = dask.optimize(D)
    tasks = [task for task in optimised.__dask_graph__().values() if "Skeleton(" in repr(task)]
    assert len(tasks) <= 1


def test_geodesics(X):
    arm, poses = Skeleton.chain(3), X[:12, :3]
    lazy = pose_distances(da.from_array(poses, chunks=(5, -1)), skeleton=arm, metric="geodesic")
    np.testing.assert_array_equal(
        lazy.compute(scheduler="synchronous"), pose_distances(poses, skeleton=arm, metric="geodesic")
    )


def test_bad_input_is_refused_at_once_where_it_can_be(X):
    lazy = da.from_array(X, chunks=(20, -1))
    with pytest.raises(ValueError, match=f"X has 5 columns, but the skeleton has {TREE.n_dofs} degrees of freedom"):
        pose_distances(lazy[:, :5], skeleton=TREE)
    with pytest.raises(ValueError, match=f"X has {TREE.n_dofs} columns and Y has 5"):
        pose_distances(lazy, lazy[:, :5], metric="angle")
    with pytest.raises(ValueError, match="the metric 'spatial' needs a skeleton"):
        pose_distances(lazy, metric="spatial")
    with pytest.raises(ValueError, match=r"chunks of unknown length; call X\.compute_chunk_sizes"):
        pose_distances(lazy[lazy[:, 0] > 0], skeleton=TREE)
    with pytest.raises(ValueError, match="out is for distances that are computed at once"):
        pose_distances(lazy, metric="angle", out=np.empty((50, 50)))


@pytest.mark.parametrize("start", [0, 20, 45])
def test_bad_numbers_are_of_the_array_that_the_user_passed(X, start):
    """Dask chooses which task runs first; a task on two chunks of X names X, whichever chunk has the NaN."""
    bad = X.copy()
    bad[start : start + 5] = np.nan
    bad, good = da.from_array(bad, chunks=(5, -1)), da.from_array(X, chunks=(5, -1))
    for arguments, name in [((bad,), "X"), ((bad, bad), "X"), ((bad, good), "X"), ((good, bad), "Y")]:
        D = pose_distances(*arguments, skeleton=TREE)
        row, column = D.blocks[0, start // 5], D.blocks[start // 5, 0]
        for part in (D, row) if name == "Y" else (D, column) if len(arguments) == 2 else (D, row, column):
            with pytest.raises(ValueError, match=f"Input {name} contains NaN"):
                part.compute(scheduler="synchronous")
