"""Metrics as objects: parameters, copies, searches over them, bounds, and what "auto" means."""

import copy
import pickle

import numpy as np
import pytest
from conftest import SKELETONS
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

import skpose
from skpose import PoseKNeighborsTransformer, Skeleton, motion_distances, pose_distances
from skpose.geodesics import frechet_mean
from skpose.metrics import Angle, Geodesic, Position, Rotation, Spatial
from skpose.metrics._registry import METRICS, resolve
from skpose.motions import find_motion
from skpose.preprocessing import PoseDistanceTransformer
from skpose.statistics import PoseKernelRegressor

ARM = Skeleton.chain(3)
DEFAULTS = [metric() for metric in METRICS.values()]
CHANGED = [Angle(wrap=True), Spatial(3), Spatial(wrap=False), Geodesic(3), Geodesic(3, wrap=False)]


@pytest.fixture
def X():
    """Poses so far apart that the parameters of metrics change distances."""
    return np.random.default_rng(0).uniform(-3, 3, size=(12, ARM.n_dofs))


def test_copies_are_equal_and_others_are_not():
    every = DEFAULTS + CHANGED
    for metric in every:
        copies = [
            type(metric)(**metric.get_params()),
            clone(metric),
            eval(repr(metric), vars(skpose.metrics)),
            copy.deepcopy(metric),
            pickle.loads(pickle.dumps(metric)),
        ]
        for one in copies:
            assert one is not metric
            assert (one, hash(one), one.label) == (metric, hash(metric), metric.label)
    assert len(set(every)) == len({one.label for one in every}) == len(every)
    assert Spatial() != "spatial"
    assert Spatial(np.int64(3), np.bool_(True)) == Spatial(3)


def test_labels():
    assert [metric.label for metric in DEFAULTS] == list(METRICS)
    assert Spatial(10, wrap=True).label == "spatial"
    assert Geodesic(20, wrap=False).label == "Geodesic(n_steps=20, wrap=False)"


def test_a_name_stands_for_the_defaults_and_parameters_change_distances(X):
    for name, metric in METRICS.items():
        D = pose_distances(X, skeleton=ARM, metric=metric())
        np.testing.assert_array_equal(pose_distances(X, skeleton=ARM, metric=name), D)
    for metric in CHANGED:
        D, default = (pose_distances(X, skeleton=ARM, metric=one) for one in (metric, type(metric)()))
        assert np.abs(D - default).max() > 1e-3


def test_parameters_can_be_searched_over():
    X = np.random.default_rng(1).uniform(-3, 3, size=(60, ARM.n_dofs))
    y = pose_distances(X, X[:2], skeleton=ARM, metric=Spatial(4)).argmin(axis=1)

    def pipeline(metric):
        return make_pipeline(PoseDistanceTransformer(ARM, metric=metric), KNeighborsClassifier(3, metric="precomputed"))

    values, name, metric = [1, 2, 4], "posedistancetransformer__metric__n_steps", Spatial()
    search = GridSearchCV(pipeline(metric), {name: values}, cv=4).fit(X, y)
    scores = [cross_val_score(pipeline(Spatial(n)), X, y, cv=4).mean() for n in values]
    np.testing.assert_array_equal(search.cv_results_["mean_test_score"], scores)
    assert len(set(scores)) > 1
    assert metric == Spatial()
    assert search.best_estimator_[0].metric_ == Spatial(search.best_params_[name])


@pytest.mark.parametrize("estimator", [PoseDistanceTransformer(ARM), PoseKernelRegressor(ARM)])
def test_a_metric_that_changes_after_fit_changes_no_answer(estimator, X):
    metric = Angle()
    fitted = clone(estimator).set_params(metric=metric).fit(X, X)
    method = fitted.predict if hasattr(fitted, "predict") else fitted.transform
    before = method(X[::2])
    metric.set_params(wrap=True)
    assert (fitted.metric, fitted.metric_) == (Angle(wrap=True), Angle())
    np.testing.assert_array_equal(method(X[::2]), before)


def test_a_metric_lies_between_its_bounds():
    for skeleton in (SKELETONS["humanoid"], SKELETONS["mixed joints"]):
        for metric in DEFAULTS + CHANGED:
            X = np.random.default_rng(0).uniform(-1, 1, size=(4, skeleton.n_dofs)) * (0.3 if metric.iterative else 3.0)
            X = np.concatenate([X, X[:1] + 1e-6, X[:1]])
            D = pose_distances(X, skeleton=skeleton, metric=metric)
            lower, upper = metric.lower_bound(), metric.upper_bound()
            if lower is not None:
                bounds, codes = pose_distances(X, skeleton=skeleton, metric=lower), lower.encode_poses(X, skeleton)
                assert (bounds <= D * (1 + 1e-12) + 1e-12).all()
                np.testing.assert_allclose(bounds, np.linalg.norm(codes[:, None] - codes, axis=2), 1e-12, 1e-12)
            if upper is not None:
                assert (pose_distances(X, skeleton=skeleton, metric=upper) >= D * (1 - 1e-12) - 1e-12).all()


def test_which_metrics_have_bounds():
    for metric in (Rotation(), Angle(wrap=True)):
        assert metric.lower_bound() is metric.upper_bound() is None
    assert (Angle().lower_bound(), Position().lower_bound()) == (Angle(), Position())
    for metric in (Spatial(3), Geodesic(3)):
        assert metric.lower_bound() == Position()
    assert Geodesic(3, wrap=False).upper_bound() == Spatial(3, wrap=False)


# Calls whose results show which metric they took, and what "auto" is with a skeleton.
AUTO = {
    "pose_distances": (lambda X, **kw: pose_distances(X, **kw), Spatial()),
    "motion_distances": (lambda X, **kw: motion_distances([X[:5], X[5:]], **kw), Spatial()),
    "find_motion": (lambda X, **kw: [one.distance for one in find_motion(X[:2] + 0.1, [X], **kw)], Spatial()),
    "neighbours": (lambda X, **kw: PoseKNeighborsTransformer(**kw).fit_transform(X).toarray(), Spatial()),
    "regressor": (lambda X, **kw: PoseKernelRegressor(**kw).fit(X, X).metric_, Position()),
}


@pytest.mark.parametrize("name", AUTO)
def test_what_auto_is(name, X):
    call, metric = AUTO[name]
    np.testing.assert_array_equal(call(X, skeleton=ARM, metric="auto"), call(X, skeleton=ARM, metric=metric))
    assert np.any(call(X, skeleton=ARM, metric=metric) != call(X, skeleton=ARM, metric=Angle()))
    with pytest.warns(UserWarning, match="skeleton") as caught:
        found = call(X, metric="auto")
    assert [warning.filename for warning in caught] == [__file__]
    np.testing.assert_array_equal(found, call(X, metric=Angle()))


def test_resolve_copies_and_means_have_another_default(X):
    metric = Spatial(3)
    assert resolve(metric, ARM) == metric
    assert resolve(metric, ARM) is not metric
    np.testing.assert_array_equal(frechet_mean(X / 3, ARM).pose, frechet_mean(X / 3, ARM, metric="position").pose)
