"""Distances written into arrays of the user: in memory, in files, h5py, zarr and others."""

import joblib
import numpy as np
import pytest
from conftest import random_tree

from skpose import Skeleton, pose_distances
from skpose.metrics._registry import METRICS

TREE = random_tree(0)
ARRAYS = ["ndarray", "Fortran", "memmap", "zarr", "h5py", "other"]


class Other:
    """Supports nothing but assignment."""

    def __init__(self, shape):
        self.content = np.full(shape, np.nan)

    def __setitem__(self, key, block):
        self.content[key] = block


@pytest.fixture(scope="module")
def X():
    return np.cumsum(np.random.default_rng(0).normal(0, 0.1, size=(150, TREE.n_dofs)), axis=0)


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 64)


def make(kind, folder, shape, dtype=np.float64):
    """An array of a kind, and a function that reads it anew."""
    path = folder / f"D.{kind}"
    if kind == "zarr":
        zarr = pytest.importorskip("zarr")
        out = zarr.create_array(path, shape=shape, dtype=dtype, chunks=(40, 50), overwrite=True)
        return out, lambda: zarr.open_array(path, mode="r")[:]
    if kind == "h5py":
        file = pytest.importorskip("h5py").File(path, "w")
        out = file.create_dataset("D", shape, dtype, chunks=(20, 30))
        return out, lambda: out[:]
    if kind == "memmap":
        return np.lib.format.open_memmap(path, "w+", dtype, shape), lambda: np.load(path)
    out = Other(shape) if kind == "other" else np.full(shape, np.nan, dtype, order="F" if kind == "Fortran" else "C")
    return out, lambda: getattr(out, "content", out)


@pytest.mark.parametrize("kind", ARRAYS)
def test_out_has_the_same_distances(kind, X, tmp_path):
    for Y in (None, X[:70] + 0.1):
        expected = pose_distances(X, Y, skeleton=TREE)
        out, read = make(kind, tmp_path, expected.shape)
        assert pose_distances(X, Y, skeleton=TREE, out=out, n_jobs=2) is out
        np.testing.assert_array_equal(read(), expected)


@pytest.mark.parametrize("metric", METRICS)
def test_every_metric_in_float32(metric, X, tmp_path):
    skeleton, X = Skeleton.chain(3), 0.1 * X[:70, :3].astype(np.float32)
    X = X[:20] if metric == "geodesic" else X
    expected = pose_distances(X, skeleton=skeleton, metric=metric)
    for kind in ("ndarray", "zarr"):
        out, read = make(kind, tmp_path, expected.shape, expected.dtype)
        pose_distances(X, skeleton=skeleton, metric=metric, out=out)
        np.testing.assert_array_equal(read(), expected)


@pytest.mark.slow
def test_tiles_of_workers(X, tmp_path, monkeypatch):
    monkeypatch.setattr("skpose.metrics._matrix.WORTH_SENDING", 0)
    expected = pose_distances(X, skeleton=TREE)
    out, read = make("zarr", tmp_path, expected.shape)
    with joblib.parallel_config("loky", n_jobs=2):
        pose_distances(X, skeleton=TREE, out=out)
    np.testing.assert_array_equal(read(), expected)


def test_parts_of_arrays_and_unaligned_ones(X, tmp_path):
    expected = pose_distances(X, skeleton=TREE)
    whole = np.full((300, 300), np.nan)
    pose_distances(X, skeleton=TREE, out=whole[150:, ::2])
    np.testing.assert_array_equal(whole[150:, ::2], expected)
    assert np.isnan(whole[:150]).all()
    assert np.isnan(whole[:, 1::2]).all()
    unaligned = np.memmap(tmp_path / "D", float, "w+", shape=(150, 150), offset=3)
    np.testing.assert_array_equal(pose_distances(X, skeleton=TREE, out=unaligned), expected)


@pytest.mark.parametrize(
    "out",
    [np.zeros((150, 149)), np.zeros((150, 150), np.float32), np.broadcast_to(0.0, (150, 150)), "D.npy"],
    ids=["shape", "dtype", "read-only", "path"],
)
def test_another_out_is_refused(out, X):
    with pytest.raises(ValueError, match="out"):
        pose_distances(X, skeleton=TREE, out=out)
