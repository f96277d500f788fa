"""Metrics as objects: their parameters, copies and names, what is refused, their bounds, and what "auto" means."""

import copy
import importlib
import inspect
import pickle
import pkgutil

import numpy as np
import pytest
from conftest import SKELETONS
from sklearn.base import clone
from sklearn.model_selection import GridSearchCV, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

import skpose
from skpose import (
    MedoidShift,
    MotionDistanceTransformer,
    MotionKNeighborsTransformer,
    PoseDistanceTransformer,
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    Skeleton,
    SpatialMDS,
    geodesic,
    motion_distances,
    pose_distances,
    pose_distances_chunked,
    pose_metric,
)
from skpose._cli import options
from skpose.cluster import PoseKMeans
from skpose.geodesics import exp_map, frechet_mean, geodesic_distances, geometric_median, interpolate, log_map
from skpose.metrics import Angle, Geodesic, Metric, Position, Rotation, Spatial
from skpose.metrics._registry import METRICS, resolve
from skpose.motions import MotionIndex, align_motions, find_motion, mean_motion, segment_repetitions
from skpose.plot import AlignmentDisplay, ConfusionDisplay, DistanceMatrixDisplay, GeodesicDisplay
from skpose.statistics import PoseKernelRegressor, PoseTangentPCA, outlier_test, two_sample_test

ARM = Skeleton.chain(3)
DEFAULTS = [metric() for metric in METRICS.values()]
CHANGED = [Angle(wrap=True), Spatial(3), Spatial(wrap=False), Geodesic(3), Geodesic(3, wrap=False)]
ALL = pytest.mark.parametrize("metric", DEFAULTS + CHANGED, ids=repr)


@pytest.fixture
def X():
    """Poses so far apart that the metrics, and their parameters, give other distances."""
    return np.random.default_rng(0).uniform(-3, 3, size=(12, ARM.n_dofs))


# --- parameters, copies and names ------------------------------------------------------------------------------------


@ALL
def test_copies_are_equal(metric):
    copies = {
        "get_params": type(metric)(**metric.get_params()),
        "set_params": type(metric)().set_params(**metric.get_params()),
        "clone": clone(metric),
        "repr": eval(repr(metric), vars(skpose.metrics)),
        "copy": copy.deepcopy(metric),
        "pickle": pickle.loads(pickle.dumps(metric)),
    }
    for how, one in copies.items():
        assert one is not metric, how
        assert one == metric, how
        assert hash(one) == hash(metric), how
        assert one.label == metric.label, how


def test_metrics_of_other_classes_or_parameters_are_unequal():
    every = DEFAULTS + CHANGED
    for i, one in enumerate(every):
        for other in every[:i]:
            assert one != other
    assert len(set(every)) == len({one.label for one in every}) == len(every)
    assert Spatial() != "spatial"
    assert Spatial(np.int64(3), np.bool_(True)) == Spatial(3)


def test_a_label_is_the_name_and_parameters_that_are_not_the_defaults():
    assert [metric.label for metric in DEFAULTS] == list(METRICS)
    assert Spatial(10, wrap=True).label == "spatial"
    assert Spatial(20).label == "Spatial(n_steps=20)"
    assert Geodesic(20, wrap=False).label == "Geodesic(n_steps=20, wrap=False)"


def test_numbers_of_numpy_are_shown_as_numbers():
    for metric in (Spatial(n_steps=np.int64(20), wrap=np.True_), Spatial(np.int32(20))):
        assert repr(metric) == "Spatial(n_steps=20)"
        assert "np." not in repr(PoseDistanceTransformer(ARM, metric=metric))
        assert clone(metric) == metric == Spatial(20)
        assert hash(metric) == hash(Spatial(20))
    assert repr(Spatial(n_steps=np.int64(10))) == "Spatial()"


def test_names_are_those_of_the_classes():
    assert {name: metric.__name__ for name, metric in METRICS.items()} == {
        name: name.capitalize() for name in ("angle", "position", "rotation", "spatial", "geodesic")
    }
    for metric in METRICS.values():
        assert getattr(skpose.metrics, metric.__name__) is metric
        assert metric.equation
        assert metric.source
        assert metric.unit in ("m", "rad")


def test_the_command_line_has_the_metrics_of_the_registry():
    assert list(options.METRICS) == list(METRICS)


@pytest.mark.parametrize("name", METRICS)
def test_a_name_stands_for_the_metric_with_its_defaults(name, X):
    metric = METRICS[name]()
    D = pose_distances(X, skeleton=ARM, metric=metric)
    np.testing.assert_array_equal(pose_distances(X, skeleton=ARM, metric=name), D)
    np.testing.assert_array_equal(pose_distances(X, skeleton=ARM, metric=METRICS[name](**metric.get_params())), D)
    graphs = [PoseKNeighborsTransformer(ARM, metric=one).fit_transform(X) for one in (name, metric)]
    np.testing.assert_array_equal(graphs[0].toarray(), graphs[1].toarray())
    sums = [motion_distances([X[:5], X[5:]], skeleton=ARM, metric=one) for one in (name, metric)]
    np.testing.assert_array_equal(*sums)


@pytest.mark.parametrize("metric", CHANGED, ids=repr)
def test_parameters_change_distances(metric, X):
    """So that a test that compares two results of them can fail."""
    D, default = (pose_distances(X, skeleton=ARM, metric=one) for one in (metric, type(metric)()))
    assert np.abs(D - default).max() > 1e-3


@ALL
def test_cloudpickle_as_of_dask_and_loky(metric):
    cloudpickle = pytest.importorskip("cloudpickle")
    assert pickle.loads(cloudpickle.dumps(metric)) == metric


# --- in scikit-learn -------------------------------------------------------------------------------------------------


def test_parameters_can_be_searched_over():
    rng = np.random.default_rng(1)
    X = rng.uniform(-3, 3, size=(60, ARM.n_dofs))
    y = pose_distances(X, X[:2], skeleton=ARM, metric=Spatial(4)).argmin(axis=1)

    def pipeline(metric):
        return make_pipeline(PoseDistanceTransformer(ARM, metric=metric), KNeighborsClassifier(3, metric="precomputed"))

    values, name = [1, 2, 4, 10], "posedistancetransformer__metric__n_steps"
    metric = Spatial()
    search = GridSearchCV(pipeline(metric), {name: values}, cv=4).fit(X, y)
    scores = [cross_val_score(pipeline(Spatial(n)), X, y, cv=4).mean() for n in values]
    np.testing.assert_array_equal(search.cv_results_["mean_test_score"], scores)
    assert len(set(scores)) > 1
    assert metric == Spatial()
    assert search.best_estimator_[0].metric_ == Spatial(search.best_params_[name])
    either = GridSearchCV(pipeline("auto"), {"posedistancetransformer__metric": [Angle(), Spatial(2)]}, cv=4).fit(X, y)
    assert either.cv_results_["mean_test_score"][1] == scores[1]


@pytest.mark.parametrize(
    "estimator",
    [
        PoseDistanceTransformer(ARM),
        PoseKNeighborsTransformer(ARM, n_neighbors=3),
        PoseRadiusNeighborsTransformer(ARM),
        SpatialMDS(ARM, n_components=2),
        PoseKMeans(ARM, n_clusters=2, random_state=0),
        PoseKernelRegressor(ARM),
        PoseTangentPCA(ARM),
        MotionDistanceTransformer(ARM),
        MotionKNeighborsTransformer(ARM, n_neighbors=3),
    ],
    ids=lambda estimator: type(estimator).__name__,
)
def test_a_metric_that_changes_after_fit_changes_no_answer(estimator, X):
    metric = Angle()
    data = np.stack([X, X[::-1]], axis=1) if "Motion" in type(estimator).__name__ else X
    fitted = clone(estimator).set_params(metric=metric).fit(data, X)
    method = fitted.predict if hasattr(fitted, "predict") else fitted.transform
    before = method(data[::2])
    metric.set_params(wrap=True)
    assert fitted.metric == Angle(wrap=True)
    assert fitted.metric_ == Angle()
    after = method(data[::2])
    np.testing.assert_array_equal(*(one.toarray() if hasattr(one, "toarray") else one for one in (before, after)))


def test_a_metric_that_changes_changes_no_index_no_function_and_no_lazy_matrix(X):
    da = pytest.importorskip("dask.array")
    metric = Spatial(3)
    index, function = MotionIndex([X[:6], X[6:]], skeleton=ARM, metric=metric), pose_metric(ARM, metric=metric)
    lazy = pose_distances(da.from_array(X), skeleton=ARM, metric=metric)
    found, distance = find_motion(X[2:5] + 0.1, index), function(X[0], X[1])
    metric.set_params(n_steps=1)
    assert find_motion(X[2:5] + 0.1, index) == found
    assert function(X[0], X[1]) == distance
    assert pose_metric(ARM, metric=Spatial(3)) is function
    assert pose_metric(ARM, metric=metric) is not function
    expected = pose_distances(da.from_array(X), skeleton=ARM, metric=Spatial(3))
    np.testing.assert_array_equal(lazy.compute(), expected.compute())


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("metric", [*METRICS.values(), Metric], ids=lambda metric: metric.__name__)
def test_a_class_in_the_place_of_a_metric_is_refused(metric, X):
    message = rf"metric is the class {metric.__name__}: pass a metric with its parameters, {metric.__name__}\(\)"
    for call in (
        lambda: pose_distances(X, skeleton=ARM, metric=metric),
        lambda: pose_metric(ARM, metric=metric),
        lambda: SpatialMDS(ARM, n_components=2, metric=metric).fit(X),
        lambda: PoseKNeighborsTransformer(ARM, metric=metric).fit(X),
        lambda: motion_distances([X], skeleton=ARM, metric=metric),
        lambda: geodesic(X[0], X[1], ARM, metric=metric),
    ):
        with pytest.raises(TypeError, match=message):
            call()


@pytest.mark.parametrize(
    ("metric", "name"),
    [
        (Spatial(0), "n_steps"),
        (Spatial(2.5), "n_steps"),
        (Spatial("ten"), "n_steps"),
        (Spatial(wrap="auto"), "wrap"),
        (Geodesic(-1), "n_steps"),
        (Geodesic(wrap=None), "wrap"),
        (Angle(wrap=2), "wrap"),
    ],
    ids=repr,
)
def test_parameters_are_checked_where_the_metric_is_used(metric, name, X):
    message = f"The '{name}' parameter of {type(metric).__name__} must be .* Got {getattr(metric, name)!r} instead"
    for call in (
        lambda: pose_distances(X, skeleton=ARM, metric=metric),
        lambda: pose_metric(ARM, metric=metric),
        lambda: PoseDistanceTransformer(ARM, metric=metric).fit(X),
        lambda: motion_distances([X], skeleton=ARM, metric=metric),
        lambda: frechet_mean(X, ARM, metric=metric),
    ):
        with pytest.raises(ValueError, match=message):
            call()


def test_words_that_are_nearly_a_metric(X):
    for word, near in (("Spatial", "spatial"), ("spatal", "spatial"), ("ANGLE", "angle"), ("geodesics", "geodesic")):
        for call in (
            lambda word=word: pose_distances(X, skeleton=ARM, metric=word),
            lambda word=word: PoseKNeighborsTransformer(ARM, metric=word).fit(X),
        ):
            with pytest.raises(ValueError, match=f"metric must be a word .* got {word!r}: did you mean {near!r}\\?"):
                call()
    words = "'auto', 'angle', 'position', 'rotation', 'spatial', 'geodesic'"  # in one order in every process
    with pytest.raises(ValueError, match=f"must be a str among {{{words}}} or an instance of"):
        pose_distances(X, skeleton=ARM, metric="manhattan")
    with pytest.raises(ValueError, match=r"must be a str among .* Got 'precomputed' instead"):
        pose_distances(X, skeleton=ARM, metric="precomputed")


def test_lists_have_no_hash_and_that_is_said():
    for metric in (Spatial([3]), Spatial(([3],))):
        with pytest.raises(TypeError, match=r"but n_steps of Spatial is .*\[3\].*: pass a tuple"):
            hash(metric)
    assert repr(Spatial([3])) == "Spatial(n_steps=[3])"


def test_parameters_of_other_metrics_are_refused():
    with pytest.raises(TypeError, match="unexpected keyword argument 'n_steps'"):
        Angle(n_steps=3)
    with pytest.raises(ValueError, match="Invalid parameter 'n_steps' for estimator Rotation"):
        Rotation().set_params(n_steps=3)


# --- bounds ----------------------------------------------------------------------------------------------------------


@ALL
@pytest.mark.parametrize("name", ["humanoid", "mixed joints"])
def test_a_metric_lies_between_its_bounds(metric, name):
    skeleton, rng = SKELETONS[name], np.random.default_rng(0)
    X = rng.uniform(-1, 1, size=(4, skeleton.n_dofs)) * (0.3 if metric.iterative else 3.0)
    X = np.concatenate([X, X[:1] + 1e-6, X[:1]])
    D = pose_distances(X, skeleton=skeleton, metric=metric)
    lower, upper = metric.lower_bound(), metric.upper_bound()
    if lower is not None:
        bounds = pose_distances(X, skeleton=skeleton, metric=lower)
        assert (bounds <= D * (1 + 1e-12) + 1e-12).all()
        codes = lower.encode_poses(X, skeleton)
        np.testing.assert_allclose(bounds, np.linalg.norm(codes[:, None] - codes, axis=2), rtol=1e-12, atol=1e-12)
        assert lower.lower_bound() == lower
    if upper is not None:
        assert (pose_distances(X, skeleton=skeleton, metric=upper) >= D * (1 - 1e-12) - 1e-12).all()


def test_which_metrics_have_bounds():
    bounds = {metric: (metric.lower_bound(), metric.upper_bound()) for metric in DEFAULTS + CHANGED}
    assert bounds.pop(Rotation()) == bounds.pop(Angle(wrap=True)) == (None, None)
    assert bounds.pop(Angle()) == (Angle(), None)
    assert bounds.pop(Position()) == (Position(), None)
    for metric, both in bounds.items():
        assert both == (Position(), Spatial(**metric.get_params()) if isinstance(metric, Geodesic) else None)


# --- "auto" ----------------------------------------------------------------------------------------------------------


def fitted_metric(estimator, X):
    """The metric of a fitted estimator; a motion is a pose and another one."""
    return estimator.fit(np.stack([X, X[::-1]], axis=1) if "Motion" in type(estimator).__name__ else X, X).metric_


def swing(X):
    """A motion of one arm that repeats itself."""
    turns = np.linspace(0, 6 * np.pi, 60)[:, None]
    return X[0] + np.sin(turns) * X[1] / 4


# What "auto" means with a skeleton, and calls whose results show which metric they took.
ON_SPATIAL = {
    "pose_distances": lambda X, **kw: pose_distances(X, **kw),
    "pose_distances_chunked": lambda X, **kw: np.concatenate(list(pose_distances_chunked(X, **kw))),
    "pose_metric": lambda X, **kw: pose_metric(**kw)(X[0], X[1]),
    "motion_distances": lambda X, **kw: motion_distances([X[:5], X[5:]], **kw),
    "align_motions": lambda X, **kw: align_motions(X[:5], X[5:], **kw).distance,
    "find_motion": lambda X, **kw: [match.distance for match in find_motion(X[:2] + 0.1, [X], **kw)],
    "MotionIndex": lambda X, **kw: [match.distance for match in find_motion(X[:2] + 0.1, MotionIndex([X], **kw))],
    "segment_repetitions": lambda X, **kw: segment_repetitions(swing(X), **kw).fitness,
    "two_sample_test": lambda X, **kw: two_sample_test(X[:5], X[5:], n_permutations=9, random_state=0, **kw).statistic,
    "outlier_test": lambda X, **kw: outlier_test(X[:5], X[5:], **kw).statistic,
    "DistanceMatrixDisplay.from_poses": lambda X, **kw: DistanceMatrixDisplay.from_poses(X, **kw).distances,
    "PoseDistanceTransformer": lambda X, **kw: fitted_metric(PoseDistanceTransformer(**kw), X),
    "PoseKNeighborsTransformer": lambda X, **kw: fitted_metric(PoseKNeighborsTransformer(**kw), X),
    "PoseRadiusNeighborsTransformer": lambda X, **kw: fitted_metric(PoseRadiusNeighborsTransformer(**kw), X),
    "SpatialMDS": lambda X, **kw: fitted_metric(SpatialMDS(**kw), X),
    "MedoidShift": lambda X, **kw: fitted_metric(MedoidShift(**kw), X),
    "MotionDistanceTransformer": lambda X, **kw: fitted_metric(MotionDistanceTransformer(**kw), X),
    "MotionKNeighborsTransformer": lambda X, **kw: fitted_metric(MotionKNeighborsTransformer(**kw), X),
}
ON_SPATIAL_OF_A_SKELETON = {
    "ConfusionDisplay.from_predictions": lambda X, **kw: [
        each.distance
        for each in ConfusionDisplay.from_predictions(
            list("aabb"), list("abba"), [X[:3], X[3:5], X[5:8], X[8:]], **kw
        ).confusions
    ],
    "AlignmentDisplay.from_motions": lambda X, **kw: AlignmentDisplay.from_motions(X, X / 2, **kw).alignment.distance,
}
ON_POSITION = {
    "PoseKMeans": lambda X, **kw: fitted_metric(PoseKMeans(n_clusters=2, random_state=0, **kw), X),
    "PoseKernelRegressor": lambda X, **kw: fitted_metric(PoseKernelRegressor(**kw), X),
    "PoseTangentPCA": lambda X, **kw: fitted_metric(PoseTangentPCA(**kw), X),
}
ON_POSITION_OF_A_SKELETON = {
    "frechet_mean": lambda X, **kw: frechet_mean(X / 3, **kw).pose,
    "geometric_median": lambda X, **kw: geometric_median(X / 3, **kw).pose,
    "mean_motion": lambda X, **kw: mean_motion([X[:5] / 3, X[5:] / 3], **kw).poses,
}
ON_GEODESIC_OF_A_SKELETON = {
    "geodesic": lambda X, **kw: geodesic(X[0], X[1], **kw).length,
    "GeodesicDisplay.from_poses": lambda X, **kw: GeodesicDisplay.from_poses(X[0], X[1], **kw).geodesic.length,
    "log_map": lambda X, **kw: log_map(X[0], X[0] + X[:2] / 9, **kw),
    "exp_map": lambda X, **kw: exp_map(X[0], np.full((1, 3, 3), 0.1), **kw),
    "geodesic_distances": lambda X, **kw: geodesic_distances(X[:4], X[:4], **kw),
    "interpolate": lambda X, **kw: interpolate(X[:4], [0.0, 1.0, 2.0, 3.0], frame_rate=2, **kw).angles,
}
WITH_A_SKELETON = {
    Spatial(): ON_SPATIAL | ON_SPATIAL_OF_A_SKELETON,
    Position(): ON_POSITION | ON_POSITION_OF_A_SKELETON,
    Geodesic(): ON_GEODESIC_OF_A_SKELETON,
}
WITHOUT_A_CHOICE = {"Alignment"}  # a result, which has the metric that was chosen


def test_the_lists_here_have_all_that_takes_a_metric():
    """All public functions, classes and methods with a parameter `metric`."""
    found = set()
    for module in pkgutil.iter_modules(skpose.__path__, "skpose."):
        if not module.name.startswith("skpose._"):
            package = importlib.import_module(module.name)
            for name in getattr(package, "__all__", []):
                one = getattr(package, name)
                methods = {f"{name}.{key}": getattr(one, key) for key in vars(one)} if inspect.isclass(one) else {}
                for key, each in ({name: one} | methods).items():
                    if callable(each) and "._" not in key and "metric" in inspect.signature(each).parameters:
                        found.add(key)
    assert found == WITHOUT_A_CHOICE | {name for calls in WITH_A_SKELETON.values() for name in calls}


@pytest.mark.parametrize(
    ("call", "metric"),
    [pytest.param(call, metric, id=name) for metric, calls in WITH_A_SKELETON.items() for name, call in calls.items()],
)
@pytest.mark.usefixtures("agg")
def test_auto_with_a_skeleton(call, metric, X):
    np.testing.assert_array_equal(call(X, skeleton=ARM, metric="auto"), call(X, skeleton=ARM, metric=metric))


@pytest.mark.parametrize("call", (ON_SPATIAL | ON_POSITION).values(), ids=ON_SPATIAL | ON_POSITION)
@pytest.mark.usefixtures("agg")
def test_auto_without_a_skeleton_is_angle_and_said(call, X):
    with pytest.warns(UserWarning, match='metric="auto" without a skeleton means "angle"') as caught:
        found = call(X, metric="auto")
    assert [warning.filename for warning in caught] == [__file__]
    np.testing.assert_array_equal(found, call(X, metric=Angle()))  # without a warning, which would be an error


def test_the_calls_above_show_which_metric_they_took(X):
    for call in (ON_SPATIAL | ON_POSITION).values():
        angle, position = (call(X, skeleton=ARM, metric=metric) for metric in (Angle(), Position()))
        assert np.any(angle != position)


def test_what_is_resolved_is_a_copy():
    metric = Spatial(3)
    assert resolve(metric, ARM) == metric
    assert resolve(metric, ARM) is not metric
    assert resolve("auto", ARM) == Spatial()
    assert resolve("auto", ARM, auto="position") == Position()
    assert resolve("auto", None, auto="position") == Angle()
