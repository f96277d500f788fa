"""Queries that are far from all poses, where bounds leave many: groups of poses, their order, and the coarse bound."""

import numpy as np
import pytest
from conftest import SKELETONS

from skpose import Bone, PoseKNeighborsTransformer, PoseRadiusNeighborsTransformer, Skeleton, pose_distances
from skpose._compiled.pose.candidates import Known
from skpose.metrics import Angle, Spatial
from skpose.neighbors import _cost
from skpose.neighbors._filter import ChordFilter
from skpose.neighbors._index import LANES
from skpose.neighbors._order import order_of_groups
from skpose.neighbors._refine import FLOAT32, FLOAT64, Refinement

HUMANOID = SKELETONS["humanoid"]
RNG = np.random.default_rng(0)


@pytest.fixture(autouse=True)
def always_filter(monkeypatch):
    monkeypatch.setattr(_cost, "LEAST_WORK_TO_FILTER", 0)
    monkeypatch.setattr(_cost.CostModel, "filter_is_worth_it", lambda *_: True)


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


def test_where_the_middle_is_no_sample_it_bounds_nothing():
    """Each of three steps of some angles is a whole turn: the line is short, and its middle half a turn away."""
    X = sequences(HUMANOID)
    queries = X[::60].copy()
    X[:, ::4] -= 3 * np.pi
    queries[:, ::4] += 3 * np.pi
    assert_equal_to_brute_force(X, queries, HUMANOID, Spatial(3, wrap=False))


def test_threads_change_nothing():
    X = np.random.default_rng(1).permutation(sequences(HUMANOID, n_sequences=20))
    assert_equal_to_brute_force(X, sequences(HUMANOID, n_sequences=3, seed=1)[::3], HUMANOID, n_jobs=2)


@pytest.mark.parametrize("name", ["humanoid", "ball joints"])
def test_few_lengths_are_measured_in_any_order(name):
    skeleton = SKELETONS[name]
    X, queries = sequences(skeleton, 40, 200), sequences(skeleton, 4, 10, seed=1)
    counts = []
    for index in (X, RNG.permutation(X)):
        knn = PoseKNeighborsTransformer(skeleton).fit(index)
        *_, evaluations = knn.kneighbors(queries, 5, return_evaluations=True)
        counts.append(evaluations.lengths / len(queries))
    assert max(counts) < 0.06 * len(X)
    assert max(counts) < 1.5 * min(counts)


def test_the_coarse_bound_leaves_little_of_what_the_filter_leaves(monkeypatch):
    """So little that most of it is not even encoded for lengths."""
    encoded, n_poses = Refinement._encode, {FLOAT32: 0, FLOAT64: 0}

    def counting(self, poses, encode, n_codes, dtype):
        n_poses[dtype] += len(poses)
        return encoded(self, poses, encode, n_codes, dtype)

    monkeypatch.setattr(Refinement, "_encode", counting)
    knn = PoseKNeighborsTransformer(HUMANOID).fit(sequences(HUMANOID, 40, 200))
    for query in sequences(HUMANOID, 4, 10, seed=1):
        knn.kneighbors(query[np.newaxis], 5)
    assert 0 < n_poses[FLOAT64] < 0.5 * n_poses[FLOAT32]


@pytest.mark.parametrize("n_poses", [3, 20 * LANES, 300 * LANES + 5])
def test_the_poses_with_the_least_bounds_are_found_some_and_then_more(n_poses):
    """In order, without the excluded one, within limits; poses in boxes of boxes, many of them there twice."""
    rng = np.random.default_rng(0)
    X = rng.normal(size=(n_poses, 10))
    X[n_poses // 2 :: 3] = X[0]
    order = rng.permutation(n_poses)
    chords, indices = ChordFilter(X, Angle(), None), np.full(-(-n_poses // LANES) * LANES, -1)
    chords.reorder(order)
    indices[:n_poses] = order
    points = chords.points(np.concatenate([X[[0, 1, 2, 0]], X[:1] + 9.0]))
    Y = np.empty((n_poses, chords.n_coordinates), FLOAT32)
    Y[order] = chords.coordinates(np.arange(n_poses))
    excluded, limits = np.array([0, 1, 2, 1, 0]), np.array([0.0, 1.0, 2.0, 3.0, 99.0], FLOAT32)
    known = Known(excluded, np.full(5, -1.0, FLOAT32), np.full(5, -1))
    found = [[] for _ in limits]
    for n in (1, 7, n_poses):
        near = chords.nearest(points, indices, known, limits, n, 1).heaps
        for i, count in enumerate(near.counts):
            found[i] += near.indices[i, :count].tolist()
            if count:
                known.values[i], known.indices[i] = near.values[i, count - 1], near.indices[i, count - 1]
    for i, (point, limit) in enumerate(zip(points.coordinates, limits, strict=True)):
        bounds = np.linalg.norm(Y.astype(float) - point, axis=1)
        bounds[excluded[i]] = np.inf
        np.testing.assert_array_equal(np.sort(found[i]), np.flatnonzero(bounds <= limit * (1 + 1e-6)))
        assert (np.diff(bounds[found[i]]) >= -1e-6).all()
        same = [j for j in found[i] if (Y[j] == Y[0]).all()]
        assert same == sorted(same)


def test_training_poses_are_no_neighbours_of_themselves():
    X = sequences(HUMANOID)
    D = pose_distances(X, X.copy(), skeleton=HUMANOID)
    np.fill_diagonal(D, np.inf)
    order = np.argsort(D, axis=1, kind="stable")[:, :5]
    distances, indices = PoseKNeighborsTransformer(HUMANOID).fit(X).kneighbors(n_neighbors=5)
    np.testing.assert_array_equal(indices, order)
    np.testing.assert_array_equal(distances, np.take_along_axis(D, order, axis=1))


@pytest.mark.filterwarnings("ignore:values of X reach")  # they are no degrees
@pytest.mark.parametrize("large", [1e5, 1e14, 1e16])
def test_angles_without_digits(large):
    """Half of such an angle is another direction than the angle's."""
    skeleton = Skeleton.chain(4)
    X = np.random.default_rng(0).normal(size=(300, 4))
    X[::7, 0] = large
    D = pose_distances(X[:14], X.copy(), skeleton=skeleton)
    found = PoseRadiusNeighborsTransformer(skeleton).fit(X).radius_neighbors(X[:14], 1.0)[1]
    for row, expected in zip(found, D, strict=True):
        np.testing.assert_array_equal(np.sort(row), np.flatnonzero(expected <= 1.0))
    nearest = PoseKNeighborsTransformer(skeleton, n_neighbors=5).fit(X).kneighbors(X[:14])[1]
    np.testing.assert_array_equal(nearest, np.argsort(D, axis=1, kind="stable")[:, :5])


@pytest.mark.parametrize("length", [1e12, 1e20, 1e22])
def test_long_bones_of_little_weight(length):
    """Their squares are beyond float32, but not times the weight."""
    bones = [Bone(str(i), str(i - 1) if i else None, (1.0 if i < 4 else length, 0, 0), "z") for i in range(5)]
    skeleton = Skeleton(bones).with_weights([1.0, 1.0, 1.0, 1.0, length**-2.0])
    X = np.random.default_rng(0).normal(size=(300, 5))
    D = pose_distances(X[:20], X.copy(), skeleton=skeleton)
    radius = np.median(D)
    found = PoseRadiusNeighborsTransformer(skeleton).fit(X).radius_neighbors(X[:20], radius)[1]
    assert sum(map(len, found)) == (radius >= D).sum()


# --- the order of groups ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 15, 16, 17, 100, 1000])
def test_an_order_has_every_point_once(n):
    points = np.random.default_rng(0).normal(size=(n, 3)).astype(np.float32)
    for some in (points, 0 * points):
        np.testing.assert_array_equal(np.sort(order_of_groups(some, LANES)), np.arange(n))


def test_points_that_stand_together_stay_as_they_are():
    t = np.linspace(0, 10, 1000)
    curve = np.stack([np.sin(t), np.cos(3 * t), t], axis=1).astype(np.float32)
    np.testing.assert_array_equal(order_of_groups(curve, LANES), np.arange(1000))
    shuffled = np.random.default_rng(0).permutation(curve)
    sorted_ = shuffled[order_of_groups(shuffled, LANES)]
    within = sorted_[:992].reshape(-1, LANES, 3).var(axis=1).sum(axis=1).mean()
    assert within < 0.01 * curve.var(axis=0).sum()
