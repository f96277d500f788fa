import numpy as np
import pytest
import reference
from conftest import SKELETONS
from scipy.optimize import least_squares
from sklearn.metrics import r2_score
from sklearn.neighbors import NearestNeighbors

from skpose import Skeleton, forward_kinematics, pose_distances
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean
from skpose.metrics import Geodesic, Spatial
from skpose.statistics import PoseKernelRegressor

ARM = Skeleton.chain(3)


@pytest.fixture(scope="module")
def data():
    """Features, poses of an arm, queries, weights."""
    rng = np.random.default_rng(0)
    return rng.normal(size=(40, 2)), rng.uniform(-1, 1, size=(40, 3)), rng.normal(size=(9, 2)), rng.uniform(size=40)


def kernel(queries, X, gamma):
    return np.exp(-gamma * ((queries[:, None] - X) ** 2).sum(axis=2))


# --- predictions -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gamma", [0.0, 0.3, 5.0])
def test_of_angles_it_is_the_estimator_of_nadaraya_and_watson(gamma, data):
    X, y, queries, w = data
    weights = kernel(queries, X, gamma) * w
    expected = weights @ y / weights.sum(axis=1, keepdims=True)
    model = PoseKernelRegressor(metric="angle", gamma=gamma).fit(X, y, sample_weight=7.0 * w)
    # Weights below a millionth of the largest count as zero: 39 of them at most.
    np.testing.assert_allclose(model.predict(queries), expected, rtol=0, atol=8e-5)


@pytest.mark.parametrize("name", ["chain", "mixed joints", pytest.param("humanoid", marks=pytest.mark.slow), "weights"])
def test_a_prediction_is_the_pose_nearest_to_the_weighted_mean_of_the_positions(name):
    skeleton, rng = SKELETONS[name], np.random.default_rng(0)
    X, queries = rng.normal(size=(30, 2)), rng.normal(size=(3, 2))
    y = rng.uniform(-0.6, 0.6, size=(30, skeleton.n_dofs))
    predicted = PoseKernelRegressor(skeleton, gamma=0.5).fit(X, y).predict(queries)
    weights = kernel(queries, X, 0.5)
    targets = weights @ reference.F(y, skeleton) / weights.sum(axis=1, keepdims=True)
    for pose, target in zip(predicted, targets, strict=True):

        def gap(angles, target=target):
            return reference.F(angles, skeleton)[0] - target

        best = least_squares(gap, pose, xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=30)
        assert np.sum(gap(pose) ** 2) <= 2 * best.cost * (1 + 1e-4)


def test_bones_have_their_lengths_where_means_of_positions_have_shorter_ones():
    walk = make_gait(1, 1, activities=["walk"], duration=3, frame_rate=30, random_state=0)[0]
    time = np.arange(len(walk.angles))[:, None] / walk.frame_rate

    def lengths(positions):
        positions = np.concatenate([positions, np.zeros((len(positions), 1, 3))], axis=1)  # the last is the root
        return np.linalg.norm(positions[:, :-1] - positions[:, walk.skeleton.parents], axis=2)

    model = PoseKernelRegressor(walk.skeleton, gamma=20.0).fit(time, walk.angles)
    found = lengths(forward_kinematics(model.predict(time), walk.skeleton))
    exact = np.linalg.norm(walk.skeleton.offsets, axis=1)
    np.testing.assert_allclose(found, np.broadcast_to(exact, found.shape), rtol=0, atol=1e-12)
    weights = kernel(time, time, 20.0)
    means = np.tensordot(weights, forward_kinematics(walk.angles, walk.skeleton), 1)
    assert (exact - lengths(means / weights.sum(axis=1)[:, None, None])).max() > 0.01


@pytest.mark.parametrize("metric", ["rotation", Spatial(8), Geodesic(8)])
def test_it_is_the_mean_of_the_metric(metric, data):
    X, y, queries, _ = data
    predicted = PoseKernelRegressor(ARM, gamma=2.0, metric=metric).fit(X, y).predict(queries[:2])
    for pose, weights in zip(predicted, kernel(queries[:2], X, 2.0), strict=True):
        mean = frechet_mean(y, ARM, metric=metric, sample_weight=weights)
        apart = pose_distances(pose[None], mean.pose[None], skeleton=ARM, metric="position").item()
        assert apart < 5e-3 * mean.variance**0.5


# --- neighbours, far queries, weights --------------------------------------------------------------------------------


@pytest.mark.parametrize("k", [1, 4, 40, 90])
def test_neighbours_that_count(k, data):
    X, y, queries, _ = data
    model = PoseKernelRegressor(metric="angle", gamma=0.0, n_neighbors=k).fit(X, y)
    nearest = NearestNeighbors(n_neighbors=min(k, len(X))).fit(X).kneighbors(queries, return_distance=False)
    np.testing.assert_allclose(model.predict(queries), y[nearest].mean(axis=1), rtol=0, atol=1e-12)


@pytest.mark.parametrize("parameters", [{}, {"n_neighbors": 5}, {"gamma": 1.0}], ids=str)
def test_a_row_twice_is_a_row_of_twice_the_weight_in_any_order(parameters, data):
    X, y, queries, _ = data
    counts = np.random.default_rng(2).integers(0, 4, size=len(X))
    order = np.random.default_rng(3).permutation(counts.sum())
    model = PoseKernelRegressor(ARM, **parameters)
    expected = model.fit(X, y, sample_weight=counts).predict(queries)
    model.fit(np.repeat(X, counts, axis=0)[order], np.repeat(y, counts, axis=0)[order])
    np.testing.assert_allclose(model.predict(queries), expected, rtol=0, atol=1e-7)
    kept = counts > 0
    model.fit(X[kept], y[kept], sample_weight=0.01 * counts[kept])
    np.testing.assert_allclose(model.predict(queries), expected, rtol=0, atol=1e-7)


def test_the_width_of_scott_scales_with_the_features(data):
    X, y, queries, _ = data
    model = PoseKernelRegressor(metric="angle").fit(X, y)
    assert model.gamma_ == pytest.approx(0.5 / (X.var(axis=0).mean() * 40 ** (-1 / 3)))
    expected = model.predict(queries)
    np.testing.assert_allclose(model.fit(1e5 * X + 3, y).predict(1e5 * queries + 3), expected, rtol=0, atol=1e-9)
    assert PoseKernelRegressor(metric="angle").fit(np.ones((4, 2)), y[:4]).gamma_ == 1.0


# --- score -----------------------------------------------------------------------------------------------------------


def test_score_of_angles_is_that_of_scikit_learn(data):
    X, y, _, w = data
    model = PoseKernelRegressor(metric="angle", gamma=1.0).fit(X[:30], y[:30])
    for weights in (None, w):
        expected = r2_score(y, model.predict(X), sample_weight=weights, multioutput="variance_weighted")
        assert model.score(X, y, sample_weight=weights) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("metric", ["position", "geodesic"])
def test_score_is_the_share_of_variance_by_its_definition(metric, data):
    X, y, _, w = data
    model = PoseKernelRegressor(ARM, metric=metric, gamma=2.0, n_neighbors=4).fit(X[:20], y[:20])
    given, w = y[20:], w[20:]
    predicted = model.predict(X[20:])
    mean = frechet_mean(given, ARM, metric=metric, sample_weight=w).pose
    squares = pose_distances(given, np.vstack([predicted, mean]), skeleton=ARM, metric=metric) ** 2
    expected = 1 - w @ squares[:, :-1].diagonal() / (w @ squares[:, -1])
    assert model.score(X[20:], given, sample_weight=w) == pytest.approx(expected, abs=1e-9)


# --- as scikit-learn's -----------------------------------------------------------------------------------------------
