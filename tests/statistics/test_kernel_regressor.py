import numpy as np
import pandas as pd
import pytest
import reference
from conftest import SKELETONS, random_tree
from scipy.optimize import least_squares
from sklearn.exceptions import ConvergenceWarning, UndefinedMetricWarning
from sklearn.metrics import r2_score
from sklearn.model_selection import GridSearchCV
from sklearn.neighbors import NearestNeighbors
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from skpose import Skeleton, forward_kinematics, pose_distances
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean
from skpose.geodesics._weightings import WeightedMeans
from skpose.metrics import Angle, Geodesic, Spatial
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


@pytest.mark.parametrize("name", ["chain", "humanoid", "mixed joints", "weights"])
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


def test_positions_do_not_depend_on_the_numbers_of_the_file():
    walk = make_gait(1, 1, activities=["walk"], duration=2, frame_rate=20, random_state=0)[0]
    time = np.arange(len(walk.angles))[:, None] / walk.frame_rate
    ball = walk.to_rotvec()  # joints of two angles become freer, and their means others
    F = []
    for motion in (ball, ball.to_euler("ZXY"), ball.to_euler("xyz")):
        model = PoseKernelRegressor(motion.skeleton, gamma=60.0).fit(time, motion.angles)
        F.append(forward_kinematics(model.predict(time), motion.skeleton))
    np.testing.assert_allclose(F[1], F[0], rtol=0, atol=1e-6)
    np.testing.assert_allclose(F[2], F[0], rtol=0, atol=1e-6)


@pytest.mark.parametrize("metric", ["rotation", Spatial(8), Geodesic(8)])
def test_it_is_the_mean_of_the_metric(metric, data):
    X, y, queries, _ = data
    predicted = PoseKernelRegressor(ARM, gamma=2.0, metric=metric).fit(X, y).predict(queries[:2])
    for pose, weights in zip(predicted, kernel(queries[:2], X, 2.0), strict=True):
        mean = frechet_mean(y, ARM, metric=metric, sample_weight=weights)
        apart = pose_distances(pose[None], mean.pose[None], skeleton=ARM, metric="position").item()
        assert apart < 5e-3 * mean.variance**0.5


def test_wrapped_angles_may_jump_by_whole_turns(data):
    X, y, queries, _ = data
    turns = 2 * np.pi * np.random.default_rng(1).integers(-2, 3, size=y.shape)
    model = PoseKernelRegressor(metric=Angle(wrap=True), gamma=1.0)
    plain, jumping = model.fit(X, y).predict(queries), model.fit(X, y + turns).predict(queries)
    np.testing.assert_allclose(np.exp(1j * jumping), np.exp(1j * plain), rtol=0, atol=1e-9)
    literal = PoseKernelRegressor(metric="angle", gamma=1.0).fit(X, y).predict(queries)
    np.testing.assert_allclose(plain, literal, rtol=0, atol=1e-4)  # all within half a turn of each other


# --- neighbours, far queries, weights --------------------------------------------------------------------------------


@pytest.mark.parametrize("k", [1, 4, 40, 90])
def test_neighbours_that_count(k, data):
    X, y, queries, _ = data
    model = PoseKernelRegressor(metric="angle", gamma=0.0, n_neighbors=k).fit(X, y)
    nearest = NearestNeighbors(n_neighbors=min(k, len(X))).fit(X).kneighbors(queries, return_distance=False)
    np.testing.assert_allclose(model.predict(queries), y[nearest].mean(axis=1), rtol=0, atol=1e-12)


def test_of_equally_far_neighbours_all_count():
    X, y = [[-2.0], [-1.0], [1.0], [2.0]], [[0.0], [1.0], [3.0], [9.0]]
    for k in (1, 2):
        model = PoseKernelRegressor(metric="angle", gamma=0.0, n_neighbors=k).fit(X, y)
        np.testing.assert_allclose(model.predict([[0.0]]), [[2.0]])


@pytest.mark.parametrize("gamma", [1e-3, 1.0, 1e300])
@pytest.mark.parametrize("far", [1e5, 1e9, 1e80, 1e200, 1.7e308])
def test_far_queries_get_the_pose_of_the_nearest_row(gamma, far, data):
    X, y, _, w = data
    X = np.append(X, [[50.0, 0.0]], axis=0)
    model = PoseKernelRegressor(metric="angle", gamma=gamma)
    model.fit(X, np.append(y, [[5.0, 5.0, 5.0]], axis=0), sample_weight=np.append(w, 1e-300))
    predicted = model.predict([[far, 0.0], [-far, far / 3]])
    assert np.isfinite(predicted).all()
    if 1e5 < far < 1e15:  # of farther ones the distances to all rows are equal but for rounding
        np.testing.assert_allclose(predicted[0], 5.0, rtol=0, atol=1e-12)


def test_a_query_between_two_far_rows_gets_their_mean():
    model = PoseKernelRegressor(metric="angle", gamma=1.0).fit([[-1e4], [1e4], [3e4]], [[0.0], [1.0], [7.0]])
    np.testing.assert_allclose(model.predict([[0.0]]), [[0.5]])


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


def test_score_where_variance_is_not_defined(data):
    X, y, _, _ = data
    model = PoseKernelRegressor(ARM, gamma=1e6).fit(X, y)
    with pytest.warns(UndefinedMetricWarning, match="less than two poses"):
        assert np.isnan(model.score(X[:1], y[:1]))
    model.set_params(metric="angle").fit(X, y)
    assert model.score(X[[3, 3]], y[[3, 3]]) == 1.0
    assert model.score(X[[3, 4]], y[[3, 3]]) == 0.0


def test_means_that_do_not_converge_are_counted(data, monkeypatch):
    X, y, queries, _ = data
    model = PoseKernelRegressor(ARM).fit(X, y)
    found = WeightedMeans.means
    monkeypatch.setattr(WeightedMeans, "means", lambda self, w: (found(self, w)[0], np.arange(len(w)) > 1))
    with pytest.warns(ConvergenceWarning, match="2 of the 9 predicted means did not converge"):
        model.predict(queries)


def test_a_score_by_a_mean_that_did_not_converge_is_said(data, monkeypatch):
    X, y, _, _ = data
    model = PoseKernelRegressor(ARM).fit(X, y)
    expected, found = model.score(X, y), WeightedMeans.means
    # One mean is that of the given poses; the predictions are 40.
    monkeypatch.setattr(WeightedMeans, "means", lambda self, w: (found(self, w)[0], np.full(len(w), len(w) > 1)))
    with pytest.warns(ConvergenceWarning, match="the mean of the 40 given poses did not converge"):
        assert model.score(X, y) == expected


# --- as scikit-learn's -----------------------------------------------------------------------------------------------


def test_a_grid_search_finds_the_width():
    walk = make_gait(1, 1, activities=["walk"], duration=4, frame_rate=20, random_state=0)[0]
    time = np.arange(len(walk.angles))[:, None] / walk.frame_rate
    pipeline = make_pipeline(StandardScaler(), PoseKernelRegressor(walk.skeleton))
    prefix = "posekernelregressor__"
    grid = {prefix + "gamma": [0.01, 300.0, 1e9], prefix + "n_neighbors": [None, 2], prefix + "metric": ["position"]}
    order = np.random.default_rng(0).permutation(len(time))
    search = GridSearchCV(pipeline, grid, cv=4).fit(time[order], walk.angles[order])
    assert search.best_params_[prefix + "gamma"] == 300.0
    assert search.best_score_ > 0.9
    assert not np.isnan(search.cv_results_["mean_test_score"]).any()


def test_threads_do_not_change_predictions(data):
    X, y, queries, _ = data
    queries = np.tile(queries, (9, 1))
    one, two = (PoseKernelRegressor(ARM, n_jobs=n).fit(X, y).predict(queries) for n in (1, 2))
    np.testing.assert_array_equal(one, two)


def test_targets_are_checked_as_poses(data):
    X, y, queries, _ = data
    model = PoseKernelRegressor(ARM)
    frame = pd.DataFrame(y, columns=ARM.dof_names)
    np.testing.assert_array_equal(model.fit(X, frame).predict(queries), model.fit(X, y).predict(queries))
    for call in (model.fit, model.score):
        with pytest.raises(ValueError, match="columns of y are named after degrees of freedom"):
            call(X, frame[frame.columns[::-1]])
        model.fit(X, y)
        with pytest.raises(ValueError, match="y has 2 columns, but the skeleton has 3"):
            call(X, y[:, :2])
        model.fit(X, y)
        with pytest.raises(TypeError, match="y must be an array of poses, got a Skeleton"):
            call(X, ARM)
        model.fit(X, y)
        with pytest.warns(UserWarning, match=r"values of y reach .* pass np.radians"):
            call(X, 100 * y)
    with pytest.raises(ValueError, match="y must have shape"):
        model.fit(X, y.reshape(-1, 3, 1))
    with pytest.raises(ValueError, match="the metric 'position' needs a skeleton"):
        PoseKernelRegressor(metric="position").fit(X, y)
    with pytest.warns(UserWarning, match='"auto" without a skeleton means "angle"'):
        PoseKernelRegressor().fit(X, y)


def test_weights_that_are_all_zero_are_refused(data):
    X, y, _, w = data
    model = PoseKernelRegressor(metric="angle").fit(X, y)
    for method in (model.score, model.fit):
        with pytest.raises(ValueError, match="sample_weight must be somewhere positive"):
            method(X, y, sample_weight=0.0 * w)


def test_one_dof_and_the_dtype_of_poses_come_back(data):
    X, y, queries, _ = data
    hinge = Skeleton.chain(1)
    column, matrix = PoseKernelRegressor(hinge).fit(X, y[:, 0]), PoseKernelRegressor(hinge).fit(X, y[:, :1])
    assert column.predict(queries).shape == (9,)
    np.testing.assert_array_equal(column.predict(queries), matrix.predict(queries)[:, 0])
    assert column.score(X, y[:, 0]) == matrix.score(X, y[:, :1])
    single = PoseKernelRegressor(ARM).fit(X, y.astype(np.float32))
    assert single.predict(queries).dtype == np.float32
    assert PoseKernelRegressor(ARM).fit(X.astype(np.float32), y).predict(queries).dtype == np.float64


def test_angles_that_move_no_joint_are_those_of_the_nearest_pose():
    """Positions do not show a twist about the last bone."""
    skeleton = random_tree(1, offset_frame="parent")
    y = np.random.default_rng(0).uniform(-1, 1, size=(5, skeleton.n_dofs))
    found = PoseKernelRegressor(skeleton, gamma=1e9).fit(np.arange(5.0)[:, None], y).predict([[3.0]])
    np.testing.assert_allclose(found[0], y[3], rtol=0, atol=1e-9)
    seen = y.copy()
    seen[:, -1] = 0.0
    assert pose_distances(y, skeleton=skeleton, metric="position").diagonal(1).min() > 0.1
    np.testing.assert_allclose(
        pose_distances(y, seen, skeleton=skeleton, metric="position").diagonal(), 0.0, rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("metric", ["angle", "position"])
def test_score_of_equal_poses_is_one_where_they_are_predicted(metric):
    """Rounding is not divided by rounding."""
    x, y = np.arange(10.0)[:, np.newaxis], np.tile([0.3, 0.1], (10, 1))
    regressor = PoseKernelRegressor(Skeleton.chain(2), metric=metric).fit(x, y)
    assert regressor.score(x, y) == 1.0
    assert regressor.score(x, y + 0.5) == 0.0
