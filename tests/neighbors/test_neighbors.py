"""The two transformers into graphs of neighbours, compared with scikit-learn's own."""

import pickle

import numpy as np
import pandas as pd
import pytest
from conftest import SKELETONS
from numba import njit
from reference import distances as reference_distances
from sklearn import config_context, get_config
from sklearn.base import clone
from sklearn.exceptions import ConvergenceWarning, NotFittedError
from sklearn.neighbors import KNeighborsTransformer, RadiusNeighborsTransformer

from skpose import (
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    Skeleton,
    forward_kinematics,
    pose_distances,
)
from skpose.datasets import make_gait
from skpose.metrics import Angle, Geodesic, Position, Spatial
from skpose.metrics._registry import METRICS
from skpose.neighbors import Evaluations, _cost

HUMANOID = SKELETONS["humanoid"]
BOTH = [PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer]


@pytest.fixture(autouse=True)
def filter_small_searches(monkeypatch):
    monkeypatch.setattr(_cost, "LEAST_WORK_TO_FILTER", 0)


@pytest.fixture(scope="module")
def X():
    X, _ = make_gait(2, 1, random_state=0).poses(frame_rate=30)
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
            if graphs == "radius_neighbors_graph" and options:
                options["sort_results"] = True
            assert_same_graph(getattr(ours, graphs)(**options), getattr(theirs, graphs)(**options))
    shared = set(KNeighborsTransformer().get_params()) - set(PoseKNeighborsTransformer().get_params())
    assert shared == {"leaf_size", "p", "metric_params"}


@pytest.mark.skipif("sparse_interface" not in get_config(), reason="of scikit-learn 1.9 and later")
def test_sparse_arrays_where_scikit_learn_gives_them(X):
    with config_context(sparse_interface="sparray"):
        assert_same_graph(
            PoseKNeighborsTransformer(metric="angle").fit_transform(X[:40]),
            KNeighborsTransformer().fit_transform(X[:40]),
        )


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


def test_brute_force_and_threads_change_nothing(X, queries):
    for each in BOTH:
        plain = each(HUMANOID).fit(X).transform(queries)
        for parameters in ({"algorithm": "brute"}, {"n_jobs": 2}):
            other = each(HUMANOID, **parameters).fit(X).transform(queries)
            for part in ("indptr", "indices", "data"):
                np.testing.assert_array_equal(getattr(other, part), getattr(plain, part))


def test_evaluations_are_returned_on_request(X, queries):
    knn = PoseKNeighborsTransformer(HUMANOID, n_neighbors=2).fit(X)
    plain = knn.kneighbors(queries)
    *same, evaluations = knn.kneighbors(queries, return_evaluations=True)
    np.testing.assert_array_equal(same, plain)
    assert 2 * len(queries) <= evaluations.lengths < 0.2 * len(queries) * len(X)
    indices, again = knn.kneighbors(queries, return_distance=False, return_evaluations=True)
    np.testing.assert_array_equal(indices, plain[1])
    assert again == evaluations
    knn.set_params(algorithm="brute").fit(X)
    every_pair = Evaluations(lengths=len(queries) * len(X), geodesics=0)
    assert knn.kneighbors(queries, return_evaluations=True)[2] == every_pair
    geodesics = PoseKNeighborsTransformer(HUMANOID, n_neighbors=2, metric="geodesic", n_jobs=2).fit(X)
    assert 10 <= geodesics.kneighbors(queries[:5], return_evaluations=True)[2].geodesics < 50
    near = PoseRadiusNeighborsTransformer(HUMANOID, radius=0.1).fit(X)
    distances, indices, evaluations = near.radius_neighbors(queries, return_evaluations=True)
    assert sum(map(len, indices)) == sum(map(len, distances)) <= evaluations.lengths < len(queries) * len(X)
    indices, again = near.radius_neighbors(queries, return_distance=False, return_evaluations=True)
    assert [set(row) for row in indices] == [set(row) for row in near.radius_neighbors(queries)[1]]
    assert again == evaluations


def test_metric_in_use_and_its_parameters(X):
    cases = {
        ("angle", None): Angle(),
        ("auto", HUMANOID): Spatial(),
        ("position", HUMANOID): Position(),
        (Geodesic(4, wrap=False), HUMANOID): Geodesic(4, wrap=False),
    }
    for (metric, skeleton), expected in cases.items():
        knn = PoseKNeighborsTransformer(skeleton, metric=metric).fit(X)
        assert knn.metric_ == expected
        assert knn.metric_ is not metric


@pytest.mark.parametrize("each", BOTH)
def test_survives_pickle_and_clone(each, X, queries):
    fitted = each(HUMANOID).fit(X)
    expected = fitted.transform(queries)
    for other in (pickle.loads(pickle.dumps(fitted)), clone(fitted).fit(X)):
        np.testing.assert_array_equal(other.transform(queries).toarray(), expected.toarray())


@pytest.mark.parametrize("radius", [np.full(3, 0.5), [0.5], "0.5", np.array(0.5)], ids=["array", "list", "word", "0d"])
def test_a_radius_is_one_number(X, radius):
    """As scikit-learn's brute force has it; its trees take an array, which their docstring does not say."""
    near = PoseRadiusNeighborsTransformer(metric="angle").fit(X)
    for method in (near.radius_neighbors, near.radius_neighbors_graph):
        with pytest.raises(TypeError, match=r"radius must be one number for all poses, got .*: call once for each"):
            method(X[:3], radius)


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


def test_messages_about_bad_input(X):
    knn, near = PoseKNeighborsTransformer(HUMANOID).fit(X[:10]), PoseRadiusNeighborsTransformer(HUMANOID).fit(X[:10])
    for call, message in [
        (lambda: knn.kneighbors(n_neighbors=10), "Expected n_neighbors < n_samples_fit, but n_neighbors = 10"),
        (
            lambda: knn.kneighbors(X, 11),
            "Expected n_neighbors <= n_samples_fit, but n_neighbors = 11, n_samples_fit = 10",
        ),
        (lambda: knn.kneighbors(X, 0), "n_neighbors must be 1 or more, got 0"),
        (lambda: knn.kneighbors_graph(X, mode="dense"), 'mode must be "connectivity" or "distance", got \'dense\''),
        (lambda: near.radius_neighbors(X, -1.0), "radius must be zero or more, got -1.0"),
        (lambda: near.radius_neighbors(X, np.nan), "radius must be zero or more, got nan"),
        (
            lambda: near.radius_neighbors(X, return_distance=False, sort_results=True),
            "return_distance must be True if sort_results is True",
        ),
        (lambda: knn.kneighbors(X[:, :3]), f"X has 3 features, but .* is expecting {HUMANOID.n_dofs} features"),
        (lambda: PoseKNeighborsTransformer(HUMANOID).fit(X[:, :3]), "X has 3 columns, but the skeleton has"),
        (lambda: PoseKNeighborsTransformer(metric="spatial").fit(X), "the metric 'spatial' needs a skeleton"),
        (
            lambda: knn.kneighbors(pd.DataFrame(X, columns=HUMANOID.dof_names[::-1])),
            f"column 0 is .* and should be '{HUMANOID.dof_names[0]}'",
        ),
    ]:
        with pytest.raises(ValueError, match=message):
            call()
    with pytest.raises(TypeError, match=r"n_neighbors must be a whole number, got 2\.5"):
        knn.kneighbors(X, 2.5)
    for method in ("transform", "kneighbors", "kneighbors_graph"):
        with pytest.raises(NotFittedError):
            getattr(PoseKNeighborsTransformer(), method)(X)


def test_one_training_pose():
    arm = Skeleton.chain(2)
    knn = PoseKNeighborsTransformer(arm, n_neighbors=1, mode="connectivity").fit([[0.0, 0.0]])
    assert knn.transform([[1.0, 0.0], [0.0, 0.0]]).toarray().tolist() == [[1.0], [1.0]]
    near = PoseRadiusNeighborsTransformer(arm).fit([[0.0, 0.0]])
    assert [len(i) for i in near.radius_neighbors([[1.0, 0.0], [0.0, 0.0]])[1]] == [0, 1]
    assert near.radius_neighbors()[0][0].shape == (0,)
