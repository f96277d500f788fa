"""The contract of `pose_distances`, whatever the metric."""

import os
import subprocess
import sys
import tracemalloc

import numpy as np
import pandas as pd
import pytest
import reference
from conftest import SKELETONS, random_tree
from joblib import parallel_config

from skpose import Skeleton, pose_distances
from skpose.metrics._matrix import PANEL
from skpose.metrics._registry import METRICS

ALL_METRICS = pytest.mark.parametrize("metric", METRICS)
BODY = SKELETONS["humanoid"]


def spread(metric):
    return 0.1 if metric == "geodesic" else 1.0


@pytest.fixture
def X(request):
    """Poses in three blocks of lanes, two of them alike; near each other only where geodesics are to be quick."""
    parameters = request.node.callspec.params if hasattr(request.node, "callspec") else {}
    X = spread(parameters.get("metric")) * np.random.default_rng(0).normal(size=(19, BODY.n_dofs))
    X[17] = X[5]
    return X


@ALL_METRICS
def test_one_triangle_is_symmetric_with_zero_diagonal(metric, X):
    D = pose_distances(X, skeleton=BODY, metric=metric)
    np.testing.assert_array_equal(D, D.T)
    np.testing.assert_array_equal(np.diag(D), 0)
    assert D[17, 5] == 0
    assert (D >= 0).all()
    np.testing.assert_allclose(D, pose_distances(X, X.copy(), skeleton=BODY, metric=metric), rtol=1e-10, atol=1e-12)


@ALL_METRICS
def test_equal_poses_are_at_distance_zero_between_two_arrays(metric, X):
    for dtype in (np.float64, np.float32):
        D = pose_distances(X.astype(dtype), X.astype(dtype).copy(), skeleton=BODY, metric=metric)
        np.testing.assert_array_equal(np.diag(D), 0)


@ALL_METRICS
@pytest.mark.parametrize(("n_x", "n_y"), [(1, 1), (1, 40), (7, 8), (9, 17), (700, 3)])
def test_shapes_and_blocks(metric, n_x, n_y):
    if metric == "geodesic":
        n_x = min(n_x, 30)
    rng = np.random.default_rng(1)
    X, Y = (spread(metric) * rng.normal(size=(n, BODY.n_dofs)) for n in (n_x, n_y))
    D = pose_distances(X, Y, skeleton=BODY, metric=metric)
    assert D.shape == (n_x, n_y)
    for i, j in [(0, 0), (n_x - 1, n_y - 1), (n_x // 2, n_y // 2)]:
        assert D[i, j] == pose_distances(X[[i]], Y[[j]], skeleton=BODY, metric=metric)[0, 0]


def test_a_triangle_of_several_mirror_blocks():
    X = np.random.default_rng(0).normal(size=(1200, 4))
    D = pose_distances(X, skeleton=Skeleton.chain(4))
    np.testing.assert_array_equal(D, D.T)
    rows = [0, 511, 512, 1023, 1024, 1199]
    np.testing.assert_allclose(D[rows], pose_distances(X[rows], X, skeleton=Skeleton.chain(4)), rtol=1e-10, atol=1e-12)


@ALL_METRICS
def test_the_number_of_threads_changes_nothing(metric, X):
    for Y in (None, X[::2] + 0.1):
        one = pose_distances(X, Y, skeleton=BODY, metric=metric)
        np.testing.assert_array_equal(pose_distances(X, Y, skeleton=BODY, metric=metric, n_jobs=2), one)
        with parallel_config(n_jobs=3):
            np.testing.assert_array_equal(pose_distances(X, Y, skeleton=BODY, metric=metric), one)


@ALL_METRICS
def test_float32_in_float32_out(metric, X):
    single = pose_distances(X.astype(np.float32), skeleton=BODY, metric=metric)
    assert single.dtype == np.float32
    exact = pose_distances(X.astype(np.float32).astype(np.float64), skeleton=BODY, metric=metric)
    np.testing.assert_allclose(single, exact, rtol=2e-5, atol=1e-6)
    assert pose_distances(X.astype(np.float32), X, skeleton=BODY, metric=metric).dtype == np.float64
    assert pose_distances(np.zeros((2, BODY.n_dofs), dtype=int), skeleton=BODY, metric=metric).dtype == np.float64


@ALL_METRICS
@pytest.mark.parametrize(
    "convert",
    [
        np.ndarray.tolist,
        np.asfortranarray,
        lambda X: np.repeat(X, 2, axis=1)[:, ::2],
        lambda X: pd.DataFrame(X, columns=BODY.dof_names),
        lambda X: pd.DataFrame(X),
        lambda X: (X.setflags(write=False), X)[1],
    ],
    ids=["list", "Fortran", "strided", "data frame by name", "data frame", "read-only"],
)
def test_all_kinds_of_arrays(metric, convert, X):
    expected = pose_distances(X, X[:5].copy(), skeleton=BODY, metric=metric)
    np.testing.assert_array_equal(pose_distances(convert(X), convert(X[:5]), skeleton=BODY, metric=metric), expected)


def test_leaves_the_input_as_it_was(X):
    before = X.copy()
    pose_distances(X, skeleton=BODY)
    np.testing.assert_array_equal(X, before)


def test_out_is_written_and_returned(X, tmp_path):
    expected = pose_distances(X, skeleton=BODY)
    memmap = np.memmap(tmp_path / "D", dtype=np.float64, mode="w+", shape=expected.shape)
    for out in (np.full(expected.shape, np.nan), np.full(expected.shape, np.nan, order="F"), memmap):
        assert pose_distances(X, skeleton=BODY, out=out) is out
        np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize(
    "out", [np.empty((19, 18)), np.empty((19, 19), np.float32), np.broadcast_to(0.0, (19, 19))], ids=str
)
def test_out_that_does_not_fit(out, X):
    with pytest.raises(ValueError, match=r"out must be a writeable float64 array of shape \(19, 19\), got"):
        pose_distances(X, skeleton=BODY, out=out)


def test_auto_is_spatial_with_a_skeleton_and_angle_without(X):
    np.testing.assert_array_equal(pose_distances(X, skeleton=BODY), pose_distances(X, skeleton=BODY, metric="spatial"))
    np.testing.assert_array_equal(pose_distances(X), pose_distances(X, metric="angle"))


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
        ({"X": np.zeros((2, 5)), "skeleton": None}, ValueError, "X has 5 columns and Y has 4"),
        ({"X": [[0, 0, 0, np.nan]]}, ValueError, "X contains NaN"),
        ({"Y": [[0, 0, 0, np.inf]]}, ValueError, "Y contains infinity"),
        ({"X": [0.0, 1, 2, 3]}, ValueError, "Expected 2D array"),
        ({"X": np.zeros((0, 4))}, ValueError, "Found array with 0 sample"),
        ({"skeleton": None, "metric": "spatial"}, ValueError, 'metric="spatial" needs a skeleton'),
        ({"skeleton": "humanoid"}, ValueError, "The 'skeleton' parameter of pose_distances must be"),
        ({"metric": "euclidean"}, ValueError, "The 'metric' parameter of pose_distances must be a str among"),
        ({"n_steps": 0}, ValueError, "The 'n_steps' parameter of pose_distances must be an int in the range"),
        ({"wrap": "yes"}, ValueError, "The 'wrap' parameter of pose_distances must be"),
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
    np.testing.assert_array_equal(
        pose_distances(swapped[list(skeleton.dof_names)], skeleton=skeleton), pose_distances(frame, skeleton=skeleton)
    )


@pytest.mark.parametrize("turns", [0, 1000])
@pytest.mark.parametrize("n_steps", [10, 100])
@pytest.mark.parametrize("n_dofs", [1, 200, 1000])
def test_long_chains_and_large_trees(n_dofs, n_steps, turns):
    rng = np.random.default_rng(0)
    for skeleton in (Skeleton.chain(n_dofs), random_tree(2, n=n_dofs + 3)):
        X = 0.3 * rng.normal(size=(2, skeleton.n_dofs))
        X += 2 * np.pi * rng.integers(-turns, turns + 1, X.shape)
        for metric in ("angle", "position", "rotation", "spatial"):  # the time of "geodesic" goes with the dofs' cube
            for wrap in (True, False) if turns == 0 else (True,):
                parameters = {"skeleton": skeleton, "metric": metric, "n_steps": n_steps, "wrap": wrap}
                expected = reference.distance(*X, **parameters)
                np.testing.assert_allclose(pose_distances(X, **parameters)[0, 1], expected, rtol=1e-10)
                if turns == 0:
                    single = X.astype(np.float32)
                    expected = reference.distance(*single.astype(float), **parameters)
                    np.testing.assert_allclose(pose_distances(single, **parameters)[0, 1], expected, rtol=2e-5)


@ALL_METRICS
def test_panels_and_tiles_change_nothing(metric, X, monkeypatch):
    pairs = [(X, None), (X, X[::2] + 0.1)]
    whole = [pose_distances(A, B, skeleton=BODY, metric=metric) for A, B in pairs]
    monkeypatch.setattr("skpose.metrics._matrix.PANEL", 8)
    monkeypatch.setattr("skpose.metrics._matrix.WORK_PER_TASK", 1.0)
    for (A, B), expected in zip(pairs, whole, strict=True):
        np.testing.assert_array_equal(pose_distances(A, B, skeleton=BODY, metric=metric), expected)


def test_memory_beyond_the_result_is_that_of_some_panels():
    X = np.random.default_rng(0).normal(size=(40_000, BODY.n_dofs))
    out = np.empty((len(X), 1))
    pose_distances(X[:1], X[:1], skeleton=BODY)  # compiles
    tracemalloc.start()
    try:
        pose_distances(X, X[:1].copy(), skeleton=BODY, out=out)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    n_codes = 5 * BODY.n_dofs + 3 * BODY.n_joints
    assert peak < 4 * PANEL * n_codes * 8 < len(X) * n_codes * 8 / 2


def test_two_processes_may_fill_one_cache(tmp_path):
    code = "import skpose; print(skpose.pose_distances([[0.0], [1.0]])[0, 1])"
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}

    def start():
        return subprocess.Popen([sys.executable, "-c", code], env=environment, stdout=subprocess.PIPE, text=True)

    both = [start(), start()]
    assert [process.communicate()[0].strip() for process in both] == ["1.0", "1.0"]
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nb*")}
    assert kept
    assert start().communicate()[0].strip() == "1.0"
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nb*")} == kept
