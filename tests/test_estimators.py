"""What all estimators promise: answers as fitted, warnings at the user's line, and documentation for HTML."""

import inspect
from functools import partial
from pathlib import Path

import joblib
import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import ConvergenceWarning, NotFittedError
from sklearn.model_selection import cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import PoseKNeighborsTransformer, Skeleton, forward_kinematics, geodesic, pose_distances, pose_metric
from skpose.cluster import MedoidShift, PoseKMeans
from skpose.geodesics import frechet_mean
from skpose.manifold import SpatialMDS
from skpose.metrics import Angle, pose_distances_chunked
from skpose.motions import MotionDistanceTransformer, MotionKNeighborsTransformer
from skpose.neighbors import PoseRadiusNeighborsTransformer
from skpose.preprocessing import PoseDistanceTransformer, PoseFromPositions
from skpose.statistics import PoseKernelRegressor, PoseTangentPCA

ROOT = Path(__file__).parent.parent
ARM, LONGER = (
    Skeleton.chain(3),
    Skeleton([(b.name, b.parent, 2 * np.array(b.offset), b.dofs) for b in Skeleton.chain(3).bones]),
)
CLASSES = [
    PoseDistanceTransformer,
    SpatialMDS,
    MedoidShift,
    PoseKMeans,
    PoseKernelRegressor,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    MotionDistanceTransformer,
    MotionKNeighborsTransformer,
    PoseTangentPCA,
]
ALL = [*CLASSES, PoseFromPositions]
HOW_TO_ANSWER = {"n_jobs": 2, "verbose": 0, "n_neighbors": 3, "radius": 0.4, "mode": "connectivity"}
HOW_TO_ANSWER |= {"joint_limits": "enforce", "regularization": 0.1}
# Estimators, and another value of each parameter that determines what they learn.
OTHER = {"skeleton": LONGER, "metric": "angle"}
LEARNT = {
    PoseDistanceTransformer(ARM, kernel="rbf", psd="clip"): OTHER | {"kernel": None, "gamma": 0.1, "psd": "shift"},
    PoseDistanceTransformer(ARM): OTHER | {"kernel": "rbf", "gamma": 0.1, "psd": "clip"},
    SpatialMDS(ARM, n_components=1): OTHER | {"n_components": 3, "landmarks": 5, "random_state": 1},
    MedoidShift(ARM, bandwidth=3.0): OTHER | {"bandwidth": 9.0, "n_clusters": 2},
    PoseKMeans(ARM, n_clusters=3, metric="position", random_state=0): OTHER
    | {"n_clusters": 2, "n_init": 2, "max_iter": 9, "tol": 1.0, "random_state": 1},
    PoseKernelRegressor(ARM, n_neighbors=6): OTHER | {"gamma": 9.0},
    PoseKNeighborsTransformer(ARM, n_neighbors=2): OTHER | {"algorithm": "brute"},
    PoseRadiusNeighborsTransformer(ARM, radius=3.0): OTHER | {"algorithm": "brute"},
    PoseFromPositions(ARM): {"skeleton": LONGER},
    PoseTangentPCA(ARM): OTHER | {"n_components": 1},
    MotionDistanceTransformer(ARM): OTHER
    | {"alignment": "subsequence", "window": 0.1, "kernel": "rbf", "gamma": 0.1, "psd": "clip"},
    MotionDistanceTransformer(ARM, kernel="rbf", psd="clip"): OTHER
    | {"alignment": "frames", "window": 0.1, "kernel": None, "gamma": 0.1, "psd": "shift"},
    MotionKNeighborsTransformer(ARM, n_neighbors=2): OTHER | {"algorithm": "brute", "window": 0.1},
}
ESTIMATORS = list(LEARNT)
# `fit` gets the poses as targets too, which all but the regressor ignore.
METHODS = "transform", "predict", "kneighbors", "kneighbors_graph", "radius_neighbors", "radius_neighbors_graph"


@pytest.fixture(scope="module")
def X():
    return np.random.default_rng(0).uniform(-3, 3, size=(40, 3))


@pytest.fixture(scope="module")
def queries():
    return np.random.default_rng(1).uniform(-3, 3, size=(7, 3))


def data_for(estimator, poses):
    """Return poses as an estimator takes them: positions of their joints, distances between them, or motions."""
    if isinstance(estimator, PoseFromPositions):
        return forward_kinematics(poses, ARM).reshape(len(poses), -1)
    if isinstance(estimator, MotionDistanceTransformer | MotionKNeighborsTransformer):
        return np.stack([poses, poses[::-1]], axis=1)
    return pose_distances(poses, skeleton=ARM) if estimator.metric == "precomputed" else poses.copy()


def answers(estimator, X):
    """Return what all methods of a fitted estimator answer, as flat arrays."""
    found = {name: getattr(estimator, name)(X) for name in METHODS if hasattr(estimator, name)}
    if hasattr(estimator, "get_feature_names_out"):
        found["names"] = estimator.get_feature_names_out()
    return {name: np.concatenate([np.ravel(part) for part in _parts(answer)]) for name, answer in found.items()}


def _parts(answer):
    if isinstance(answer, tuple) or (isinstance(answer, np.ndarray) and answer.dtype == object and answer.ndim == 1):
        return [part for one in answer for part in _parts(one)] if not isinstance(answer[0], str) else [answer]
    return [answer.toarray() if hasattr(answer, "toarray") else np.asarray(answer)]


def assert_same_answers(a, b):
    assert a.keys() == b.keys()
    for name in a:
        np.testing.assert_array_equal(a[name], b[name], err_msg=name)


# --- answers as fitted -----------------------------------------------------------------------------------------------


def test_every_parameter_is_learnt_or_states_how_to_answer():
    for estimator, changes in LEARNT.items():
        assert set(estimator.get_params()) == set(changes) | set(HOW_TO_ANSWER) & set(estimator.get_params())


@pytest.mark.parametrize(
    ("estimator", "change"),
    [(estimator, {name: value}) for estimator, changes in LEARNT.items() for name, value in changes.items()],
    ids=str,
)
def test_a_fitted_estimator_answers_as_it_was_fitted(estimator, change, X, queries):
    X, queries = data_for(estimator, X), data_for(estimator, queries)
    fitted = clone(estimator).fit(X, X)
    expected = answers(fitted, queries)
    assert_same_answers(answers(fitted.set_params(**change), queries), expected)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=str)
def test_poses_that_change_after_fit_change_nothing(estimator, X, queries):
    poses, queries = data_for(estimator, X), data_for(estimator, queries)
    fitted = clone(estimator).fit(poses, poses)
    expected = answers(fitted, queries)
    poses += 1.0
    assert_same_answers(answers(fitted, queries), expected)


def test_parameters_that_state_how_to_answer_are_read_when_they_are_used(X, queries):
    knn = PoseKNeighborsTransformer(ARM).fit(X).set_params(n_neighbors=2, mode="connectivity", n_jobs=2)
    assert knn.kneighbors(queries, return_distance=False).shape == (7, 2)
    assert knn.transform(queries).nnz == 14
    near = PoseRadiusNeighborsTransformer(ARM).fit(X).set_params(radius=0.0)
    assert near.transform(X).nnz == len(X)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=str)
def test_only_fit_changes_an_estimator(estimator, X, queries):
    X, queries = data_for(estimator, X), data_for(estimator, queries)
    fitted = clone(estimator).fit(X, X)
    before = joblib.hash(fitted)
    answers(fitted, queries)
    assert joblib.hash(fitted) == before


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (PoseDistanceTransformer(ARM, kernel="rbf", psd="clip"), {"kernel": None, "psd": "ignore"}),
        (PoseDistanceTransformer(ARM, kernel="rbf", psd="clip"), {"psd": "ignore"}),
        (SpatialMDS(ARM, n_components=2), {"metric": "precomputed"}),
        (MedoidShift(ARM, bandwidth=3.0), {"metric": "precomputed"}),
        (PoseKMeans(ARM, n_clusters=3, metric="position", random_state=0), {"metric": "angle", "n_clusters": 2}),
        (PoseKernelRegressor(ARM), {"metric": "angle", "gamma": 0.5}),
        (PoseKNeighborsTransformer(ARM), {"metric": "angle", "algorithm": "brute"}),
        (PoseRadiusNeighborsTransformer(ARM), {"metric": "position", "skeleton": LONGER}),
        (MotionDistanceTransformer(ARM), {"metric": "position", "alignment": "subsequence"}),
        (PoseTangentPCA(ARM), {"metric": "angle", "n_components": 1}),
    ],
    ids=str,
)
def test_a_second_fit_leaves_nothing_of_the_first(first, second, X):
    data = pose_distances(X, skeleton=ARM) if second.get("metric") == "precomputed" else X
    twice = clone(first).fit(X, X).set_params(**second).fit(data, data)
    once = clone(first).set_params(**second).fit(data, data)
    assert set(vars(twice)) == set(vars(once))
    assert joblib.hash(twice) == joblib.hash(once)


@pytest.mark.parametrize("estimator", ESTIMATORS, ids=str)
def test_a_fit_that_fails_leaves_no_fit(estimator, X, queries):
    X, queries = data_for(estimator, X), data_for(estimator, queries)
    fitted = clone(estimator).fit(X, X)
    with pytest.raises(ValueError, match="contains infinity"):
        fitted.fit(np.full((4, X.shape[1]), np.inf), np.zeros((4, X.shape[1])))
    for name in METHODS:
        if hasattr(fitted, name):
            with pytest.raises(NotFittedError):
                getattr(fitted, name)(queries)


# --- the skeleton first, all others by name --------------------------------------------------------------------------


@pytest.mark.parametrize("each", ALL)
def test_the_skeleton_is_first_and_all_others_need_their_names(each):
    first, *others = inspect.signature(each).parameters.values()
    assert (first.name, first.kind, first.default) == ("skeleton", first.POSITIONAL_OR_KEYWORD, None)
    assert {other.kind for other in others} == {inspect.Parameter.KEYWORD_ONLY}


# --- no skeleton -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("each", CLASSES)
def test_a_metric_that_needs_a_skeleton_fails_in_fit(each, X):
    with pytest.raises(ValueError, match="skeleton"):
        each(metric="position").fit(X, X)


# The poses are no clusters for the default bandwidth.
MAKE = {each.__name__: each for each in CLASSES} | {"MedoidShift": partial(MedoidShift, bandwidth=3.0)}
IMPLICIT = {name: lambda X, make=make, **kw: make(**kw).fit(X, X) for name, make in MAKE.items()} | {
    "fit_transform": lambda X, **kw: PoseDistanceTransformer(**kw).fit_transform(X),
    "pose_distances": pose_distances,
    "pose_distances_chunked": lambda X, **kw: list(pose_distances_chunked(X, **kw)),
    "pose_metric": lambda X, **kw: pose_metric(**kw),
}


@pytest.mark.filterwarnings("ignore:ball trees:UserWarning")
@pytest.mark.parametrize("call", IMPLICIT.values(), ids=IMPLICIT)
def test_angles_that_are_not_asked_for_are_said_in_words_once(call, X):
    with pytest.warns(UserWarning, match="without a skeleton") as caught:
        call(X)
    assert [warning.filename for warning in caught] == [__file__]
    call(X, metric="angle")  # without a warning, which would be an error
    call(X, skeleton=ARM)


def test_a_fitted_estimator_does_not_repeat_it(X, queries):
    for make in MAKE.values():
        with pytest.warns(UserWarning, match="without a skeleton"):
            fitted = make().fit(X, X)
        answers(fitted, queries)
        assert fitted.metric_ == Angle()


# --- warnings at the user's line -------------------------------------------------------------------------------------


def line_of(call):
    return call.__code__.co_firstlineno


WARN = {
    "fit": lambda X: SpatialMDS(n_components=5, metric="angle").fit(X),
    "fit_transform": lambda X: SpatialMDS(n_components=5, metric="angle").fit_transform(X),
    "with set_output": lambda X: (
        SpatialMDS(n_components=5, metric="angle").set_output(transform="pandas").fit_transform(X)
    ),
    "in a pipeline": lambda X: make_pipeline(SpatialMDS(n_components=5, metric="angle")).fit_transform(X),
    "no clusters": lambda X: MedoidShift(n_clusters=2, metric="precomputed").fit(1.0 - np.eye(3)),
    "fit_predict": lambda X: MedoidShift(n_clusters=2, metric="precomputed").fit_predict(1.0 - np.eye(3)),
    "geodesic": lambda X: geodesic([0.0, 0.0, 0.0], [1.0, 2.0, -1.0], ARM, max_iter=1),
    "frechet_mean": lambda X: frechet_mean(X, ARM, max_iter=1),
    "cross-validation": lambda X: cross_val_score(
        make_pipeline(PoseDistanceTransformer(), KNeighborsClassifier(1, metric="precomputed")), X, X[:, 0] > 0, cv=2
    ),
    "joblib": lambda X: joblib.Parallel(1)(joblib.delayed(pose_distances)(x) for x in [X]),
}


@pytest.mark.parametrize("call", WARN.values(), ids=WARN)
def test_warnings_are_at_the_users_line(call, X):
    with pytest.warns((UserWarning, ConvergenceWarning)) as caught:
        call(X)
    for warning in caught:
        assert warning.filename == __file__
        assert line_of(call) <= warning.lineno <= line_of(call) + 2
