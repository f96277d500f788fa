"""The two transformers into graphs of neighbours, compared with scikit-learn's own."""

import numpy as np
import pytest
from conftest import SKELETONS
from numba import njit
from reference import distances as reference_distances
from sklearn.exceptions import ConvergenceWarning
from sklearn.neighbors import KNeighborsTransformer, RadiusNeighborsTransformer

from skpose import (
    PoseKNeighborsTransformer,
    forward_kinematics,
    pose_distances,
)
from skpose.datasets import make_gait
from skpose.metrics import Geodesic
from skpose.metrics._registry import METRICS
from skpose.neighbors import PoseRadiusNeighborsTransformer, _search

HUMANOID = SKELETONS["humanoid"]


@pytest.fixture(autouse=True)
def filter_small_searches(monkeypatch):
    monkeypatch.setattr(_search, "LEAST_WORK_TO_FILTER", 0)


@pytest.fixture(scope="module")
def X():
    X, _ = make_gait(2, 1, rotations="file", random_state=0).poses(frame_rate=30)
    X = X[:200].copy()
    X[50:60] = X[:10]
    return X


@pytest.fixture(scope="module")
def queries(X):
    return X[::9] + 0.02 * np.random.default_rng(0).normal(size=X[::9].shape)


# --- compared with the definition ------------------------------------------------------------------------------------


@pytest.mark.parametrize("metric", [metric for metric in METRICS if metric != "geodesic"])  # which has no formula
def test_neighbours_by_definition(metric, X, queries):
    few, X = queries[:3], X[:120]
    D = reference_distances(few, X, HUMANOID, metric, **METRICS[metric]().get_params())
    distances, indices = PoseKNeighborsTransformer(HUMANOID, metric=metric).fit(X).kneighbors(few, 7)
    np.testing.assert_allclose(distances, np.sort(D, axis=1)[:, :7], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(np.take_along_axis(D, indices, axis=1), distances, rtol=1e-6, atol=1e-9)
    radius = np.quantile(D, 0.1)
    near = PoseRadiusNeighborsTransformer(HUMANOID, metric=metric, radius=radius).fit(X)
    for row, d, i in zip(D, *near.radius_neighbors(few), strict=True):
        assert set(i) == set(np.flatnonzero(row <= radius))
        np.testing.assert_allclose(d, row[i], rtol=1e-6, atol=1e-9)
        assert (np.diff(d) >= 0).all()


# --- compared with scikit-learn's ------------------------------------------------------------------------------------


def assert_same_graph(ours, theirs):
    assert type(ours) is type(theirs)
    assert ours.dtype == theirs.dtype
    assert ours.shape == theirs.shape
    np.testing.assert_array_equal(ours.indptr, theirs.indptr)
    np.testing.assert_allclose(ours.data, theirs.data, atol=1e-6)  # theirs is not zero between equal poses
    np.testing.assert_allclose(ours.toarray(), theirs.toarray(), atol=1e-6)


@pytest.mark.parametrize("mode", ["distance", "connectivity"])
def test_graphs_are_scikit_learns_on_joint_positions(mode, X, queries):
    F, G = (forward_kinematics(poses, HUMANOID).reshape(len(poses), -1) for poses in (X, queries))
    F[50:60] += 1e-3 * np.arange(1, 11)[:, None]  # scikit-learn breaks ties arbitrarily
    angles, positions = (np.delete(poses, range(50, 60), axis=0) for poses in (X, F))
    for ours, theirs in [
        (PoseKNeighborsTransformer(HUMANOID, metric="position", mode=mode), KNeighborsTransformer(mode=mode)),
        (
            PoseRadiusNeighborsTransformer(HUMANOID, metric="position", radius=0.3, mode=mode),
            RadiusNeighborsTransformer(radius=0.3, mode=mode),
        ),
    ]:
        assert_same_graph(ours.fit_transform(angles), theirs.fit_transform(positions))
        assert_same_graph(ours.transform(queries), theirs.transform(G))
        for name in ("n_samples_fit_", "_n_features_out"):
            assert getattr(ours, name) == getattr(theirs, name)
        names = [len(each.get_feature_names_out()) for each in (ours, theirs)]
        assert names[0] == names[1]
        graphs = "kneighbors_graph" if hasattr(ours, "kneighbors") else "radius_neighbors_graph"
        for options in ({}, {"mode": "distance"}):
            sort = {"sort_results": True} if graphs == "radius_neighbors_graph" and options else {}
            assert_same_graph(getattr(ours, graphs)(**options), getattr(theirs, graphs)(**options, **sort))
    shared = set(KNeighborsTransformer().get_params()) - set(PoseKNeighborsTransformer().get_params())
    assert shared == {"leaf_size", "p", "metric_params"}


# --- properties ------------------------------------------------------------------------------------------------------


def test_a_training_pose_is_its_own_neighbour_only_if_it_is_a_query(X):
    """Its duplicates are its neighbours, whichever comes first."""
    D = pose_distances(X, X.copy(), skeleton=HUMANOID)
    knn = PoseKNeighborsTransformer(HUMANOID, n_neighbors=3).fit(X)
    distances, indices = knn.kneighbors(X)
    assert (distances[:, 0] == 0).all()
    np.fill_diagonal(D, np.inf)
    order = np.argsort(D, axis=1, kind="stable")[:, :3]
    distances, indices = knn.kneighbors()
    np.testing.assert_array_equal(indices, order)
    np.testing.assert_array_equal(distances, np.take_along_axis(D, order, axis=1))
    np.testing.assert_array_equal(knn.kneighbors(return_distance=False), order)
    assert list(indices[:10, 0]) == list(range(50, 60))
    near = PoseRadiusNeighborsTransformer(HUMANOID, radius=0.0).fit(X)
    distances, indices = near.radius_neighbors()
    assert [len(i) for i in indices] == [1] * 10 + [0] * 40 + [1] * 10 + [0] * 140
    without = near.radius_neighbors(return_distance=False)
    assert all(np.array_equal(a, b) for a, b in zip(indices, without, strict=True))
    assert knn.kneighbors(n_neighbors=len(X) - 1)[1].shape == (len(X), len(X) - 1)


def test_zeros_are_explicit_and_rows_sorted(X):
    graph = PoseKNeighborsTransformer(HUMANOID, n_neighbors=4).fit_transform(X)
    assert graph.nnz == 5 * len(X)
    rows = graph.data.reshape(-1, 5)
    assert (rows[:, 0] == 0).all()
    assert (np.diff(rows, axis=1) >= 0).all()
    assert PoseKNeighborsTransformer(HUMANOID, n_neighbors=4, mode="connectivity").fit_transform(X).nnz == 4 * len(X)


def test_float32_poses_give_distances_in_float64_as_in_scikit_learn(X, queries):
    knn = PoseKNeighborsTransformer(HUMANOID).fit(X.astype(np.float32))
    distances, _ = knn.kneighbors(queries.astype(np.float32))
    D = pose_distances(queries.astype(np.float32).astype(float), X.astype(np.float32).astype(float), skeleton=HUMANOID)
    np.testing.assert_array_equal(distances, np.sort(D, axis=1)[:, :5])


@njit
def never_converges(x, Y, first, last, tree, steps, scratch, results):
    for w in range(results.gap.shape[1]):
        if not results.skip[0, w]:
            results.distances[0, w], results.gap[0, w] = 0.0, 0.25


@pytest.mark.parametrize("method", ["kneighbors", "kneighbors_graph", "radius_neighbors", "radius_neighbors_graph"])
def test_geodesics_that_do_not_converge_are_warned_of_at_the_users_line(method, monkeypatch, X, queries):
    monkeypatch.setattr(Geodesic, "measure", staticmethod(never_converges))
    each = PoseRadiusNeighborsTransformer if "radius" in method else PoseKNeighborsTransformer
    search = getattr(each(HUMANOID, metric="geodesic").fit(X), method)
    options = {"mode": "distance"} if "graph" in method else {}  # connections need no geodesics
    pattern = r"(\d+) of \1 geodesics did not converge.* is 0\.25"
    with pytest.warns(ConvergenceWarning, match=pattern) as caught:
        search(queries[:2], **options)
    assert [warning.filename for warning in caught] == [__file__]


# --- errors ----------------------------------------------------------------------------------------------------------
