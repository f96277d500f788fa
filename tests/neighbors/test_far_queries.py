"""Queries that are far from all poses, where bounds leave many: groups of poses, their order, and the coarse bound."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import PoseKNeighborsTransformer, pose_distances
from skpose.metrics import Spatial
from skpose.neighbors import PoseRadiusNeighborsTransformer, _search
from skpose.neighbors._graph import Request, find

RNG = np.random.default_rng(0)


@pytest.fixture(autouse=True)
def always_filter(monkeypatch):
    monkeypatch.setattr(_search, "LEAST_WORK_TO_FILTER", 0)
    monkeypatch.setattr(_search.Search, "_saves_work", lambda *_: True)


def sequences(skeleton, n_sequences=6, n_frames=100, seed=0):
    """Poses along random curves, one sequence after another; the first frames of each come twice."""
    rng, t = np.random.default_rng(seed), np.linspace(0, 1, n_frames)[:, None]
    X = []
    for _ in range(n_sequences):
        start, speed, size = (rng.normal(size=skeleton.n_dofs) for _ in range(3))
        frames = start + size * np.sin(speed * t + start)
        X += [frames, frames[:5]]
    return np.concatenate(X)


def assert_equal_to_brute_force(X, queries, skeleton, metric="spatial", *, n_jobs=1, ks=(1, 5, 40)):
    """Indices and distances to the last bit, for some k and some radii."""
    D = pose_distances(queries, X, skeleton=skeleton, metric=metric)
    order = np.argsort(D, axis=1, kind="stable")
    knn = PoseKNeighborsTransformer(skeleton, metric=metric, n_jobs=n_jobs).fit(X)
    for k in ks:
        distances, indices = knn.kneighbors(queries, k)
        np.testing.assert_array_equal(indices, order[:, :k])
        np.testing.assert_array_equal(distances, np.take_along_axis(D, order[:, :k], axis=1))
    near = PoseRadiusNeighborsTransformer(skeleton, metric=metric, n_jobs=n_jobs).fit(X)
    for radius in (0.0, *np.quantile(D, [0.01, 0.3]), D.min(axis=1).max()):
        for row, distances, indices in zip(D, *near.radius_neighbors(queries, radius), strict=True):
            inside = np.flatnonzero(row <= radius)
            inside = inside[np.argsort(row[inside], kind="stable")]
            np.testing.assert_array_equal(indices, inside)
            np.testing.assert_array_equal(distances, row[inside])


@pytest.mark.parametrize("shuffled", [False, True])
def test_every_skeleton(skeleton, shuffled):
    X = sequences(skeleton)
    if shuffled:
        X = np.random.default_rng(1).permutation(X)
    queries = sequences(skeleton, n_sequences=2, seed=1)[::20]
    assert_equal_to_brute_force(X, queries, skeleton)


@pytest.mark.parametrize("wrap", [True, False])
@pytest.mark.parametrize("name", ["humanoid", "mixed joints"])
def test_half_turns_and_whole_turns(name, wrap):
    """At half a turn either side is the shorter one, which float32 cannot see."""
    skeleton, rng = SKELETONS[name], np.random.default_rng(0)
    X = sequences(skeleton)
    queries = X[::60] + np.pi * rng.integers(-2, 3, size=X[::60].shape)
    queries = np.concatenate([queries, queries + 1e-8 * rng.normal(size=queries.shape)])
    assert_equal_to_brute_force(X, queries, skeleton, Spatial(wrap=wrap))


@pytest.mark.parametrize("name", ["humanoid", "ball joints"])
def test_few_lengths_are_measured_in_any_order(name):
    skeleton = SKELETONS[name]
    X, queries = sequences(skeleton, 40, 200), sequences(skeleton, 4, 10, seed=1)
    counts = []
    for index in (X, RNG.permutation(X)):
        knn = PoseKNeighborsTransformer(skeleton).fit(index)
        found = find(Request(knn._index, queries, np.full(len(queries), -1), k=5), 1, 0)
        counts.append(found.n_measured / len(queries))
    assert max(counts) < 0.06 * len(X)
    assert max(counts) < 1.5 * min(counts)


# --- the order of groups ---------------------------------------------------------------------------------------------
