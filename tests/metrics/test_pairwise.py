"""The contract of `pose_distances`, the same for every metric."""

import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pandas as pd
import pytest
import reference
from competition import Competition
from conftest import SKELETONS, metric_of, random_tree, with_either_wrap
from joblib import parallel_config

from skpose import Skeleton, pose_distances
from skpose.metrics import Spatial, _matrix
from skpose.metrics._registry import METRICS

ALL_METRICS = pytest.mark.parametrize("metric", METRICS, indirect=True)
HUMANOID = SKELETONS["humanoid"]


@pytest.fixture
def metric(request):
    """The metric of tests that are not for all of them."""
    return getattr(request, "param", "spatial")


@pytest.fixture
def skeleton(metric):
    """A humanoid; a smaller tree where geodesics take long."""
    return SKELETONS["tree"] if metric == "geodesic" else HUMANOID


def random_poses(n, skeleton, metric, seed=0):
    """Return poses as far from each other as they may be; nearer where geodesics take long."""
    return (0.1 if metric == "geodesic" else 1.0) * np.random.default_rng(seed).normal(size=(n, skeleton.n_dofs))


@pytest.fixture
def X(metric, skeleton):
    """Poses in three groups of lanes, two of them equal."""
    X = random_poses(19, skeleton, metric)
    X[17] = X[5]
    return X


@ALL_METRICS
@pytest.mark.parametrize("kind", [np.int32, np.uint8])
def test_parameters_may_be_numpys_integers(metric, skeleton, kind):
    X = random_poses(3, skeleton, metric)
    found = pose_distances(X, skeleton=skeleton, metric=metric_of(metric, n_steps=kind(4)))
    np.testing.assert_array_equal(found, pose_distances(X, skeleton=skeleton, metric=metric_of(metric, n_steps=4)))


@ALL_METRICS
def test_one_triangle_is_symmetric_with_zero_diagonal(metric, skeleton, X):
    D = pose_distances(X, skeleton=skeleton, metric=metric)
    np.testing.assert_array_equal(D, D.T)
    np.testing.assert_array_equal(np.diag(D), 0)
    assert D[17, 5] == 0
    assert (D >= 0).all()
    np.testing.assert_allclose(D, pose_distances(X, X.copy(), skeleton=skeleton, metric=metric), rtol=1e-10, atol=1e-12)


@ALL_METRICS
def test_equal_poses_are_at_distance_zero_between_two_arrays(metric, skeleton, X):
    for dtype in (np.float64, np.float32):
        D = pose_distances(X.astype(dtype), X.astype(dtype).copy(), skeleton=skeleton, metric=metric)
        np.testing.assert_array_equal(np.diag(D), 0)


@ALL_METRICS
@pytest.mark.parametrize(("n_x", "n_y"), [(1, 1), (1, 40), (7, 8), (9, 17), (700, 3)])
def test_shapes_that_fill_groups_of_lanes_or_do_not(metric, skeleton, n_x, n_y):
    if metric == "geodesic":
        n_x = min(n_x, 30)
    X, Y = (random_poses(n, skeleton, metric, seed) for n, seed in ((n_x, 1), (n_y, 2)))
    D = pose_distances(X, Y, skeleton=skeleton, metric=metric)
    assert D.shape == (n_x, n_y)
    for i, j in [(0, 0), (n_x - 1, n_y - 1), (n_x // 2, n_y // 2)]:
        assert D[i, j] == pose_distances(X[[i]], Y[[j]], skeleton=skeleton, metric=metric)[0, 0]


def test_a_triangle_larger_than_what_is_mirrored_at_once():
    X = np.random.default_rng(0).normal(size=(1200, 4))
    D = pose_distances(X, skeleton=Skeleton.chain(4))
    np.testing.assert_array_equal(D, D.T)
    rows = [0, 511, 512, 1023, 1024, 1199]
    np.testing.assert_allclose(D[rows], pose_distances(X[rows], X, skeleton=Skeleton.chain(4)), rtol=1e-10, atol=1e-12)


@ALL_METRICS
def test_the_number_of_threads_changes_nothing(metric, skeleton, X, monkeypatch):
    pairs = [(X, None), (X, X[::2] + 0.1)]
    one = [pose_distances(A, B, skeleton=skeleton, metric=metric) for A, B in pairs]
    monkeypatch.setattr(_matrix, "WORK_PER_TASK", 1.0)  # a task for every row and group of lanes
    monkeypatch.setattr(_matrix, "in_threads", competition := Competition())
    for (A, B), expected in zip(pairs, one, strict=True):
        two = pose_distances(A, B, skeleton=skeleton, metric=metric, n_jobs=2)
        np.testing.assert_array_equal(two, expected)
        with parallel_config(n_jobs=3):
            np.testing.assert_array_equal(pose_distances(A, B, skeleton=skeleton, metric=metric), expected)
    assert competition.n_threads == [2, 3, 2, 3]


@ALL_METRICS
def test_float32_in_float32_out(metric, skeleton, X):
    single = pose_distances(X.astype(np.float32), skeleton=skeleton, metric=metric)
    assert single.dtype == np.float32
    exact = pose_distances(X.astype(np.float32).astype(np.float64), skeleton=skeleton, metric=metric)
    np.testing.assert_allclose(single, exact, rtol=2e-5, atol=1e-6)
    assert pose_distances(X.astype(np.float32), X, skeleton=skeleton, metric=metric).dtype == np.float64
    whole_numbers = np.zeros((2, skeleton.n_dofs), dtype=int)
    assert pose_distances(whole_numbers, skeleton=skeleton, metric=metric).dtype == np.float64


@ALL_METRICS
@pytest.mark.parametrize(
    "convert",
    [
        np.ndarray.tolist,
        np.asfortranarray,
        lambda X: np.repeat(X, 2, axis=1)[:, ::2],
        lambda X: pd.DataFrame(X),
        lambda X: (X.setflags(write=False), X)[1],
    ],
    ids=["list", "Fortran", "strided", "data frame", "read-only"],
)
def test_all_kinds_of_arrays(metric, skeleton, convert, X):
    expected = pose_distances(X, X[:5].copy(), skeleton=skeleton, metric=metric)
    distances = pose_distances(convert(X), convert(X[:5]), skeleton=skeleton, metric=metric)
    np.testing.assert_array_equal(distances, expected)


def test_leaves_the_input_as_it_was(skeleton, X):
    before = X.copy()
    pose_distances(X, skeleton=skeleton)
    np.testing.assert_array_equal(X, before)


def test_out_is_written_and_returned(skeleton, X, tmp_path):
    expected = pose_distances(X, skeleton=skeleton)
    memmap = np.memmap(tmp_path / "D", dtype=np.float64, mode="w+", shape=expected.shape)
    for out in (np.full(expected.shape, np.nan), np.full(expected.shape, np.nan, order="F"), memmap):
        assert pose_distances(X, skeleton=skeleton, out=out) is out
        np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize(
    "out",
    [np.empty((19, 18)), np.empty((19, 19), np.float32), np.broadcast_to(0.0, (19, 19))],
    ids=["shape", "dtype", "read-only"],
)
def test_out_that_does_not_fit(out, skeleton, X):
    with pytest.raises(ValueError, match=r"out must be a writeable float64 array of shape \(19, 19\), got"):
        pose_distances(X, skeleton=skeleton, out=out)


def test_auto_is_spatial_with_a_skeleton_and_angle_without(skeleton, X):
    spatial = pose_distances(X, skeleton=skeleton, metric="spatial")
    np.testing.assert_array_equal(pose_distances(X, skeleton=skeleton), spatial)
    with pytest.warns(UserWarning, match='without a skeleton means "angle"'):
        angle = pose_distances(X)
    np.testing.assert_array_equal(angle, pose_distances(X, metric="angle"))


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (
            {"X": np.zeros((2, 5))},
            ValueError,
            "X has 5 columns, but the skeleton has 4 degrees of freedom: one column per",
        ),
        (
            {"Y": np.zeros((2, 5))},
            ValueError,
            "Y has 5 columns, but the skeleton has 4 degrees of freedom: one column per",
        ),
        ({"X": np.zeros((2, 5)), "skeleton": None, "metric": "angle"}, ValueError, "X has 5 columns and Y has 4"),
        ({"X": [[0, 0, 0, np.nan]]}, ValueError, "X contains NaN"),
        ({"Y": [[0, 0, 0, np.inf]]}, ValueError, "Y contains infinity"),
        ({"X": [0.0, 1, 2, 3]}, ValueError, "Expected 2D array"),
        ({"X": np.zeros((0, 4))}, ValueError, "Found array with 0 sample"),
        ({"skeleton": None, "metric": "spatial"}, ValueError, "the metric 'spatial' needs a skeleton"),
        ({"skeleton": "humanoid"}, ValueError, r"skeleton must be a skpose\.Skeleton, got str: "),
        ({"metric": "euclidean"}, ValueError, "The 'metric' parameter of pose_distances must be a str among"),
        ({"metric": Spatial(0)}, ValueError, "The 'n_steps' parameter of Spatial must be an int in the range"),
        ({"metric": Spatial(wrap="yes")}, ValueError, "The 'wrap' parameter of Spatial must be"),
        ({"n_jobs": 1.5}, ValueError, "The 'n_jobs' parameter of pose_distances must be"),
        ({"out": [[0.0]]}, ValueError, r"out must be a writeable float64 array of shape \(3, 2\), got list"),
        ({"out": 1.0}, ValueError, "The 'out' parameter of pose_distances must be"),
    ],
)
def test_bad_input_is_refused_in_the_users_words(arguments, error, message):
    good = {"X": np.zeros((3, 4)), "Y": np.ones((2, 4)), "skeleton": Skeleton.chain(4)}
    with pytest.raises(error, match=message):
        pose_distances(**(good | arguments))


def test_columns_are_matched_by_name():
    skeleton = Skeleton.chain(3)
    frame = pd.DataFrame(np.random.default_rng(0).normal(size=(4, 3)), columns=skeleton.dof_names)
    swapped = frame[["joint_2_rz", "joint_1_rz", "joint_3_rz"]]
    with pytest.raises(ValueError, match="column 0 is 'joint_2_rz' and should be 'joint_1_rz'"):
        pose_distances(swapped, skeleton=skeleton)
    with pytest.raises(ValueError, match="missing: 'joint_3_rz'; not a dof of it: 'elbow'"):
        pose_distances(frame.rename(columns={"joint_3_rz": "elbow"}), skeleton=skeleton)
    expected = pose_distances(frame.to_numpy(), skeleton=skeleton)
    np.testing.assert_array_equal(pose_distances(frame, skeleton=skeleton), expected)
    np.testing.assert_array_equal(pose_distances(swapped[list(skeleton.dof_names)], skeleton=skeleton), expected)


@pytest.mark.filterwarnings("ignore:values of .* reach:UserWarning")
@pytest.mark.parametrize("turns", [0, 1000])
@pytest.mark.parametrize("n_dofs", [1, 200, pytest.param(1000, marks=pytest.mark.slow)])
def test_long_chains_and_large_trees(n_dofs, turns):
    rng = np.random.default_rng(0)
    for skeleton in (Skeleton.chain(n_dofs), random_tree(2, n=n_dofs + 3)):
        X = 0.3 * rng.normal(size=(2, skeleton.n_dofs))
        X += 2 * np.pi * rng.integers(-turns, turns + 1, X.shape)
        if turns == 0:
            X = X.astype(np.float32).astype(np.float64)  # one reference for both dtypes
        # Without geodesics, whose time is proportional to the cube of the number of dofs.
        metrics = with_either_wrap(name for name in METRICS if name != "geodesic")
        for metric in [*metrics, Spatial(100), Spatial(100, wrap=False)]:
            if turns == 0 or getattr(metric, "wrap", True):
                expected = reference.distance(*X, skeleton, metric.name, **metric.get_params())
                found = pose_distances(X, skeleton=skeleton, metric=metric)[0, 1]
                np.testing.assert_allclose(found, expected, rtol=1e-10)
                if turns == 0:
                    single = pose_distances(X.astype(np.float32), skeleton=skeleton, metric=metric)[0, 1]
                    np.testing.assert_allclose(single, expected, rtol=2e-5)


@ALL_METRICS
def test_sizes_of_tiles_and_tasks_change_nothing(metric, skeleton, X, monkeypatch):
    pairs = [(X, None), (X, X[::2] + 0.1)]
    whole = [pose_distances(A, B, skeleton=skeleton, metric=metric) for A, B in pairs]
    monkeypatch.setattr(_matrix, "ENCODED_AT_ONCE", 8)
    monkeypatch.setattr(_matrix, "WORK_PER_TASK", 1.0)
    for (A, B), expected in zip(pairs, whole, strict=True):
        np.testing.assert_array_equal(pose_distances(A, B, skeleton=skeleton, metric=metric), expected)


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
    assert kept
    assert start().communicate()[0].strip() == "1.0"
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nb*")} == kept
