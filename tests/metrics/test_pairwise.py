"""What `pose_distances` promises for every metric."""

import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pandas as pd
import pytest
import reference
from competition import Competition
from conftest import SKELETONS, random_tree, with_either_wrap
from joblib import parallel_config

from skpose import Skeleton, pose_distances
from skpose.metrics import Spatial, _matrix
from skpose.metrics._registry import METRICS

ALL_METRICS = pytest.mark.parametrize("metric", METRICS, indirect=True)
HUMANOID = SKELETONS["humanoid"]


@pytest.fixture
def metric(request):
    return getattr(request, "param", "spatial")


@pytest.fixture
def skeleton(metric):
    """A humanoid; a smaller tree where geodesics take long."""
    return SKELETONS["tree"] if metric == "geodesic" else HUMANOID


def random_poses(n, skeleton, metric, seed=0):
    return (0.1 if metric == "geodesic" else 1.0) * np.random.default_rng(seed).normal(size=(n, skeleton.n_dofs))


@pytest.fixture
def X(metric, skeleton):
    """Poses in three groups of lanes, two of them equal."""
    X = random_poses(19, skeleton, metric)
    X[17] = X[5]
    return X


@ALL_METRICS
def test_one_triangle_is_symmetric_with_zero_diagonal(metric, skeleton, X):
    D = pose_distances(X, skeleton=skeleton, metric=metric)
    np.testing.assert_array_equal(D, D.T)
    np.testing.assert_array_equal(np.diag(D), 0)
    assert D[17, 5] == 0
    assert (D >= 0).all()
    for dtype in (np.float64, np.float32):
        twice = pose_distances(X.astype(dtype), X.astype(dtype), skeleton=skeleton, metric=metric)
        np.testing.assert_array_equal(np.diag(twice), 0)
        assert twice.dtype == dtype
        np.testing.assert_allclose(twice, D, rtol=1e-10 if dtype == np.float64 else 2e-5, atol=1e-5)


@ALL_METRICS
def test_shapes_that_fill_groups_of_lanes_or_not(metric, skeleton):
    for n_x, n_y in [(1, 1), (1, 40), (9, 17), (30 if metric == "geodesic" else 700, 3)]:
        X, Y = (random_poses(n, skeleton, metric, seed) for n, seed in ((n_x, 1), (n_y, 2)))
        D = pose_distances(X, Y, skeleton=skeleton, metric=metric)
        assert D.shape == (n_x, n_y)
        for i, j in [(0, 0), (n_x - 1, n_y - 1), (n_x // 2, n_y // 2)]:
            assert D[i, j] == pose_distances(X[[i]], Y[[j]], skeleton=skeleton, metric=metric)[0, 0]


@ALL_METRICS
def test_threads_tiles_and_tasks_change_nothing(metric, skeleton, X, monkeypatch):
    pairs = [(X, None), (X, X[::2] + 0.1)]
    one = [pose_distances(A, B, skeleton=skeleton, metric=metric) for A, B in pairs]
    monkeypatch.setattr(_matrix, "WORK_PER_TASK", 1.0)  # a task for every row and group of lanes
    with monkeypatch.context() as patch:
        patch.setattr(_matrix, "in_threads", competition := Competition())
        for (A, B), expected in zip(pairs, one, strict=True):
            two = pose_distances(A, B, skeleton=skeleton, metric=metric, n_jobs=2)
            np.testing.assert_array_equal(two, expected)
            with parallel_config(n_jobs=3):
                np.testing.assert_array_equal(pose_distances(A, B, skeleton=skeleton, metric=metric), expected)
        assert competition.n_threads == [2, 3, 2, 3]
    monkeypatch.setattr(_matrix, "ENCODED_AT_ONCE", 8)
    for (A, B), expected in zip(pairs, one, strict=True):
        np.testing.assert_array_equal(pose_distances(A, B, skeleton=skeleton, metric=metric), expected)


@pytest.mark.parametrize("n", [0, 128, 3 * 128 + 5])
def test_the_lower_triangle_is_copied_from_the_upper(n, monkeypatch):
    monkeypatch.setattr(_matrix, "WORTH_A_THREAD", 1)
    whole = np.random.default_rng(n).normal(size=(n + 3, n + 2))
    whole[np.tril_indices(n)] = np.nan  # not read
    upper, outside = np.triu(whole[:n, :n], 1), whole[n:].copy()
    _matrix.mirror(whole[:n, :n], 2)
    np.testing.assert_array_equal(whole[:n, :n], upper + upper.T)
    np.testing.assert_array_equal(whole[n:], outside)


@ALL_METRICS
def test_all_kinds_of_arrays(metric, skeleton, X):
    before, expected = X.copy(), pose_distances(X, X[:5].copy(), skeleton=skeleton, metric=metric)
    frozen = X.copy()
    frozen.setflags(write=False)
    for same in (X.tolist(), np.asfortranarray(X), np.repeat(X, 2, axis=1)[:, ::2], pd.DataFrame(X), frozen):
        np.testing.assert_array_equal(pose_distances(same, same[:5], skeleton=skeleton, metric=metric), expected)
    np.testing.assert_array_equal(X, before)
    assert pose_distances(X.astype(np.float32), X, skeleton=skeleton, metric=metric).dtype == np.float64
    assert pose_distances(np.zeros_like(X, int), skeleton=skeleton, metric=metric).dtype == np.float64


def test_auto_without_a_skeleton_is_angle_with_a_warning(X):
    with pytest.warns(UserWarning, match="skeleton"):
        angle = pose_distances(X)
    np.testing.assert_array_equal(angle, pose_distances(X, metric="angle"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"X": np.zeros((2, 5))}, "X has 5 columns"),
        ({"X": np.zeros((2, 5)), "skeleton": None, "metric": "angle"}, "Y has 4"),
        ({"Y": [[0, 0, 0, np.nan]]}, "Y contains NaN"),
        ({"skeleton": None, "metric": "spatial"}, "'spatial' needs a skeleton"),
        ({"skeleton": "humanoid"}, "skeleton"),
        ({"metric": "velocity"}, "metric"),
        ({"metric": Spatial}, "metric"),
        ({"metric": Spatial(0)}, "'n_steps' parameter of Spatial"),
    ],
)
def test_bad_input_is_refused(arguments, message):
    good = {"X": np.zeros((3, 4)), "Y": np.ones((2, 4)), "skeleton": Skeleton.chain(4)}
    with pytest.raises((ValueError, TypeError), match=message):
        pose_distances(**(good | arguments))


def test_columns_are_matched_by_name():
    skeleton = Skeleton.chain(3)
    frame = pd.DataFrame(np.random.default_rng(0).normal(size=(4, 3)), columns=skeleton.dof_names)
    swapped = frame[["joint_2_rz", "joint_1_rz", "joint_3_rz"]]
    with pytest.raises(ValueError, match="joint_2_rz"):
        pose_distances(swapped, skeleton=skeleton)
    expected = pose_distances(frame.to_numpy(), skeleton=skeleton)
    np.testing.assert_array_equal(pose_distances(swapped[list(skeleton.dof_names)], skeleton=skeleton), expected)


def test_long_chains_and_large_trees():
    rng = np.random.default_rng(0)
    for skeleton in (Skeleton.chain(1), random_tree(2, n=103)):
        X = 0.3 * rng.normal(size=(2, skeleton.n_dofs)).astype(np.float32)
        for metric in [*with_either_wrap(name for name in METRICS if name != "geodesic"), Spatial(100)]:
            expected = reference.distance(*X.astype(float), skeleton, metric.name, **metric.get_params())
            found = pose_distances(X.astype(float), skeleton=skeleton, metric=metric)[0, 1]
            np.testing.assert_allclose(found, expected, rtol=1e-10)
            np.testing.assert_allclose(pose_distances(X, skeleton=skeleton, metric=metric)[0, 1], expected, rtol=2e-5)


def test_memory_beyond_the_result_is_that_of_the_poses_encoded_at_once(skeleton):
    X = np.random.default_rng(0).normal(size=(40_000, skeleton.n_dofs))
    out = np.empty((len(X), 1))
    pose_distances(X[:1], X[:1], skeleton=skeleton)  # compiles
    tracemalloc.start()
    try:
        pose_distances(X, X[:1].copy(), skeleton=skeleton, out=out)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    n_codes = 5 * skeleton.n_dofs + 3 * skeleton.n_joints
    assert peak < 4 * _matrix.ENCODED_AT_ONCE * n_codes * 8 < len(X) * n_codes * 8 / 2


@pytest.mark.slow
def test_two_processes_may_fill_one_cache(tmp_path):
    code = "import skpose; print(skpose.pose_distances([[0.0], [1.0]], metric='angle')[0, 1])"
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def start():
        return subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True)

    both = [start(), start()]
    assert [process.communicate()[0].strip() for process in both] == ["1.0", "1.0"]
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nb*")}
    assert start().communicate()[0].strip() == "1.0"
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nb*")} == kept != {}
