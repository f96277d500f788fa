"""Candidates of another index: what is measured of them is exact, and what they miss is estimated."""

import warnings

import numpy as np
import pytest
from scipy.sparse import csr_array
from sklearn.neighbors import NearestNeighbors

from skpose import Bone, PoseKNeighborsTransformer, Skeleton, forward_kinematics, pose_distances
from skpose.datasets import make_gait
from skpose.metrics import Angle, Spatial
from skpose.neighbors import _refine

MOTIONS = make_gait(3, 2, random_state=0)
SKELETON = MOTIONS.skeleton
X = MOTIONS.poses(frame_rate=30)[0]
QUERIES = X[::7] + 0.02
RNG = np.random.default_rng(0)
METRICS = "angle", Angle(wrap=True), "position", "rotation", "spatial", Spatial(3, wrap=False)


def nearest_among(candidates, metric, k, queries=QUERIES):
    """Brute force: distances and indices, filled up."""
    D = pose_distances(queries, X, skeleton=SKELETON, metric=metric)
    distances, indices = np.full((len(queries), k), np.inf), np.full((len(queries), k), -1)
    for i, row in enumerate(candidates):
        some = np.unique(row[row >= 0])
        order = some[np.argsort(D[i, some], kind="stable")][:k]
        distances[i, : len(order)], indices[i, : len(order)] = D[i, order], order
    return distances, indices


def some_candidates(n=40):
    """Indices in any order, some twice, some missing; one query has none and another less than are requested."""
    candidates = RNG.integers(-1, len(X), size=(len(QUERIES), n))
    candidates[3], candidates[4, 2:] = -1, -1
    return candidates


@pytest.mark.parametrize("metric", METRICS, ids=str)
@pytest.mark.parametrize("at_once", [2**15, 64])
def test_distances_of_candidates_are_those_of_the_matrix(metric, at_once, monkeypatch):
    monkeypatch.setattr(_refine, "CODES_AT_ONCE", at_once)
    candidates = some_candidates()
    for dtype, n_jobs in ((np.float64, 1), (np.float64, 2)):
        knn = PoseKNeighborsTransformer(SKELETON, metric=metric, n_jobs=n_jobs).fit(X.astype(dtype))
        found = knn.approximate_kneighbors(candidates, QUERIES, 5, n_checked=0)
        distances, indices = nearest_among(candidates, metric, 5)
        np.testing.assert_array_equal(found.indices, indices)
        np.testing.assert_array_equal(found.distances, distances)
        assert np.isnan(found.recall)


def test_geodesics_of_candidates():
    few, candidates = QUERIES[:3], RNG.integers(-1, len(X), size=(3, 12))
    knn = PoseKNeighborsTransformer(SKELETON, metric="geodesic").fit(X)
    found = knn.approximate_kneighbors(candidates, few, 3, n_checked=0)
    distances, indices = nearest_among(candidates, "geodesic", 3, few)
    np.testing.assert_array_equal(found.indices, indices)
    np.testing.assert_array_equal(found.distances, distances)


def test_all_poses_as_candidates_are_the_exact_search():
    knn = PoseKNeighborsTransformer(SKELETON, n_neighbors=4).fit(X)
    everything = np.tile(np.arange(len(X)), (len(QUERIES), 1))
    found = knn.approximate_kneighbors(everything, QUERIES)
    for mine, exact in zip(found[:2], knn.kneighbors(QUERIES), strict=True):
        np.testing.assert_array_equal(mine, exact)
    assert found.recall == 1.0


def test_training_poses_are_no_candidates_of_themselves():
    knn = PoseKNeighborsTransformer(SKELETON, n_neighbors=4).fit(X)
    found = knn.approximate_kneighbors(np.tile(np.arange(len(X)), (len(X), 1)))
    for mine, exact in zip(found[:2], knn.kneighbors(), strict=True):
        np.testing.assert_array_equal(mine, exact)


def test_float32_poses():
    small = X.astype(np.float32)
    knn = PoseKNeighborsTransformer(SKELETON).fit(small)
    candidates = some_candidates()
    found = knn.approximate_kneighbors(candidates, small[::7], 3)
    D = pose_distances(small[::7].astype(float), small.astype(float), skeleton=SKELETON)
    filled = found.indices >= 0
    rows = np.nonzero(filled)[0]
    np.testing.assert_array_equal(found.distances[filled], D[rows, found.indices[filled]])


@pytest.mark.parametrize("n_checked", [1, 60, 10_000])
def test_recall_is_the_share_of_the_nearest_that_is_found(n_checked, capsys):
    """Candidates are the true ones, but for two of five."""
    knn = PoseKNeighborsTransformer(SKELETON, n_neighbors=5, verbose=1).fit(X)
    true = knn.kneighbors(QUERIES, return_distance=False)
    true[:, 1:3] = -1
    n = min(n_checked, len(QUERIES))
    found = knn.approximate_kneighbors(true, QUERIES, n_checked=n_checked)
    assert found.recall == pytest.approx(0.6, abs=1e-15)
    assert knn.approximate_kneighbors(true, QUERIES, n_checked=n_checked).recall == found.recall
    assert f"recall {found.recall:.3f} of the 5 nearest, estimated from {n} of" in capsys.readouterr().out


def test_candidates_of_scikit_learn_as_an_array_and_as_a_graph():
    F, G = (forward_kinematics(some, SKELETON).reshape(len(some), -1) for some in (X, QUERIES))
    other = NearestNeighbors(n_neighbors=20).fit(F)
    knn = PoseKNeighborsTransformer(SKELETON, n_neighbors=3).fit(X)
    graph = other.kneighbors_graph(G, mode="distance")
    found = knn.approximate_kneighbors(other.kneighbors(G, return_distance=False), QUERIES)
    same = knn.approximate_kneighbors(csr_array(graph), QUERIES)
    np.testing.assert_array_equal(found.distances, same.distances)
    assert found.recall == same.recall > 0.8


def test_no_candidates():
    knn = PoseKNeighborsTransformer(SKELETON, n_neighbors=3).fit(X)
    found = knn.approximate_kneighbors(np.empty((len(QUERIES), 0), int), QUERIES)
    assert (found.indices == -1).all()
    assert np.isinf(found.distances).all()
    assert found.recall == 0.0


@pytest.mark.parametrize(
    ("candidates", "message"),
    [
        (np.zeros((2, 3)), "whole numbers, a row for each of the .* queries .* or a sparse graph, got an array of"),
        (np.zeros((2, 3), int), "a row for each"),
        (np.full((len(QUERIES), 3), len(X)), "indices of the .* poses that fit got, or -1 for none, got"),
        (np.full((len(QUERIES), 3), -2), "or -1 for none"),
        (csr_array((len(QUERIES), 5)), "shape .n_queries, n_samples_fit., here"),
    ],
)
def test_what_are_no_candidates_is_refused(candidates, message):
    knn = PoseKNeighborsTransformer(SKELETON).fit(X)
    with pytest.raises(ValueError, match=message):
        knn.approximate_kneighbors(candidates, QUERIES)
    with pytest.raises(ValueError, match="n_checked"):
        knn.approximate_kneighbors(np.zeros((len(QUERIES), 1), int), QUERIES, n_checked=-1)


def test_recall_of_queries_that_alternate():
    """As those of two people, of which the other index knows one; 199 queries, of which 100 evenly spaced are even."""
    queries = X[:199] + 0.02
    exact = PoseKNeighborsTransformer(SKELETON).fit(X).kneighbors(queries, 60, return_distance=False)
    candidates = exact[:, :5].copy()
    candidates[1::2] = exact[1::2, 55:]
    found = PoseKNeighborsTransformer(SKELETON).fit(X).approximate_kneighbors(candidates, queries, 5)
    assert found.recall == pytest.approx(0.5, abs=0.15)


@pytest.mark.parametrize(
    ("candidates", "remedy"),
    [
        ([[0, 1], *[[2]] * (len(QUERIES) - 1)], "fill shorter rows up with -1"),
        (np.ma.masked_array(np.zeros((len(QUERIES), 2), int), mask=True), r"candidates.filled\(-1\)"),
        (np.eye(len(QUERIES), len(X)).astype(int), r"scipy.sparse.csr_array\(candidates\)"),
        (np.full((len(QUERIES), 2), 2**64 - 1, np.uint64), "got 18446744073709551615 to"),
        (np.zeros((len(QUERIES), 2)), r"\.astype\(int\)"),
    ],
    ids=["ragged", "masked", "dense graph", "unsigned", "float"],
)
def test_what_is_no_candidates_is_refused(candidates, remedy):
    with pytest.raises(ValueError, match=remedy):
        PoseKNeighborsTransformer(SKELETON).fit(X).approximate_kneighbors(candidates, QUERIES, 2)


@pytest.mark.parametrize("unit", [1e-162, 1e-120, 1e120, 1e154])
def test_searches_in_any_unit_are_those_of_the_matrix(unit):
    skeleton = Skeleton([Bone(f"b{i}", f"b{i - 1}" if i else None, (unit, 0.0, 0.3 * unit), "xyz") for i in range(4)])
    poses = RNG.normal(size=(3000, 12))
    queries = poses[:40] + 0.01
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the unit
        D = pose_distances(queries, poses, skeleton=skeleton)
        distances, indices = PoseKNeighborsTransformer(skeleton, n_neighbors=10).fit(poses).kneighbors(queries)
    order = np.argsort(D, axis=1, kind="stable")[:, :10]
    np.testing.assert_array_equal(indices, order)
    np.testing.assert_array_equal(distances, np.take_along_axis(D, order, axis=1))
