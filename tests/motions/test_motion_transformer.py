"""Distances to the training motions in scikit-learn's tools: forms of X, pipelines, searches, what is refused."""

import pickle

import numpy as np
import pandas as pd
import pytest
import reference
from sklearn.base import clone
from sklearn.cluster import HDBSCAN
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import GridSearchCV, GroupKFold, LeaveOneGroupOut, cross_val_score, train_test_split
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline
from sklearn.utils import get_tags

from skpose import (
    MedoidShift,
    MotionDistanceTransformer,
    Skeleton,
    SpatialMDS,
    motion_distances,
    pose_distances,
)
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import Angle, Spatial

ARM = Skeleton.chain(3)
WEIGHTED = ARM.with_weights([0.2, 1.0, 2.0])


@pytest.fixture(scope="module")
def gait():
    """Walks and runs of three people, of different lengths, on three skeletons."""
    gait = make_gait(n_subjects=3, n_sequences=2, duration=1.5, frame_rate=12, random_state=0)
    shorter = [motion[: 12 + i % 5] for i, motion in enumerate(gait)]
    return MotionDataset(shorter, gait.subjects, gait.trials, gait.actions)


@pytest.fixture(scope="module")
def motions():
    rng = np.random.default_rng(0)
    return [rng.uniform(-3, 3, size=(n, 3)) for n in (4, 7, 1, 5, 6, 3, 8)]


@pytest.fixture
def knn():
    return make_pipeline(MotionDistanceTransformer(), KNeighborsClassifier(1, metric="precomputed"))


def warped(a, b, **parameters):
    """The least sum along a path, divided by both lengths."""
    return reference.least_sum(pose_distances(a, b, **parameters)) / (len(a) + len(b))


# --- distances -------------------------------------------------------------------------------------------------------


def test_distances_are_those_of_dynamic_time_warping(motions):
    fitted = MotionDistanceTransformer(ARM, metric="position").fit(motions[:4])
    expected = [[warped(a, b, skeleton=ARM, metric="position") for b in motions[:4]] for a in motions]
    np.testing.assert_allclose(fitted.transform(motions), expected, rtol=1e-12, atol=1e-8)


@pytest.mark.parametrize(
    "parameters",
    [
        {},
        {"metric": "rotation", "window": 0.2},
        {"alignment": "subsequence", "metric": Spatial(3)},
        {"metric": Angle(wrap=True), "n_jobs": 2},
    ],
    ids=str,
)
def test_distances_are_those_of_motion_distances(motions, parameters):
    transformer = MotionDistanceTransformer(ARM, **parameters).fit(motions[:4])
    expected = motion_distances(motions, motions[:4], skeleton=ARM, **parameters)
    np.testing.assert_array_equal(transformer.transform(motions), expected)
    among = motion_distances(motions[:4], skeleton=ARM, **parameters)
    np.testing.assert_array_equal(transformer.fit_transform(motions[:4]), among)
    again = motion_distances(
        motions, motions[:4], skeleton=ARM, metric=transformer.metric_, alignment=transformer.alignment_,
        window=transformer.window_,
    )  # fmt: skip
    np.testing.assert_array_equal(again, expected)
    assert transformer.n_samples_fit_ == 4
    assert list(transformer.get_feature_names_out()) == [f"motiondistancetransformer{i}" for i in range(4)]


def test_frames_are_compared_one_by_one():
    X = np.random.default_rng(0).uniform(-3, 3, size=(5, 4, 3))
    D = MotionDistanceTransformer(ARM, alignment="frames").fit(X[:2]).transform(X)
    expected = [[np.mean(pose_distances(a, b, skeleton=ARM).diagonal()) for b in X[:2]] for a in X]
    np.testing.assert_allclose(D, expected, rtol=1e-12, atol=1e-12)


def test_float32_stays_float32(motions):
    small = [motion.astype(np.float32) for motion in motions]
    transformer = MotionDistanceTransformer(ARM).fit(small)
    assert transformer.transform(small).dtype == np.float32
    assert transformer.transform(motions).dtype == np.float64
    np.testing.assert_allclose(transformer.transform(small), transformer.transform(motions), atol=1e-5)


# --- forms of X ------------------------------------------------------------------------------------------------------


def test_motions_as_lists_arrays_frames_of_data_and_one_array(motions):
    D = MotionDistanceTransformer(ARM).fit_transform(motions)
    forms = {
        "tuple": tuple(motions),
        "nested lists": [motion.tolist() for motion in motions],
        "data frames": [pd.DataFrame(motion, columns=ARM.dof_names) for motion in motions],
        "array of arrays": np.array([*motions, None], dtype=object)[:-1],
    }
    for name, form in forms.items():
        np.testing.assert_array_equal(MotionDistanceTransformer(ARM).fit_transform(form), D, err_msg=name)
    X = np.random.default_rng(0).uniform(-3, 3, size=(5, 4, 3))
    np.testing.assert_array_equal(
        MotionDistanceTransformer(ARM).fit_transform(X), MotionDistanceTransformer(ARM).fit_transform(list(X))
    )


def test_rows_are_motions_of_one_frame(motions):
    rows = motions[1]
    D = MotionDistanceTransformer(ARM).fit_transform(rows)
    np.testing.assert_allclose(D, pose_distances(rows, skeleton=ARM) / 2, rtol=1e-12)
    np.testing.assert_array_equal(MotionDistanceTransformer(ARM).fit_transform(rows[:, np.newaxis]), D)
    named = MotionDistanceTransformer(ARM).fit(pd.DataFrame(rows, columns=ARM.dof_names))
    assert tuple(named.feature_names_in_) == ARM.dof_names
    with pytest.raises(ValueError, match="columns"):
        named.transform(pd.DataFrame(rows, columns=ARM.dof_names[::-1]))


def test_the_skeleton_and_the_frame_rate_of_motions_are_learnt(gait):
    fitted = MotionDistanceTransformer().fit(gait)
    assert fitted.skeleton_ == gait.skeleton
    assert (fitted.metric_, fitted.frame_rate_, fitted.n_features_in_) == (Spatial(), 12, 42)
    np.testing.assert_array_equal(fitted.transform(gait), motion_distances(gait, list(gait), skeleton=gait.skeleton))
    for other in (list(gait), gait.motions):
        np.testing.assert_array_equal(MotionDistanceTransformer().fit_transform(other), motion_distances(gait))
    given = MotionDistanceTransformer(gait[0].skeleton).fit(gait)
    assert given.skeleton_ == gait[0].skeleton
    assert MotionDistanceTransformer(gait.skeleton).fit([m.angles for m in gait]).frame_rate_ is None


def test_angles_that_are_not_asked_for_are_said_in_words_once(motions):
    with pytest.warns(UserWarning, match='"auto" without a skeleton means "angle"') as caught:
        fitted = MotionDistanceTransformer().fit(motions)
    assert [warning.filename for warning in caught] == [__file__]
    fitted.transform(motions)  # without a warning, which would be an error
    assert get_tags(fitted).input_tags.three_d_array
    assert not get_tags(fitted).input_tags.pairwise


def test_motions_of_other_people_are_compared_on_the_learnt_skeleton(gait):
    train, test = gait[gait.subjects != "03"], gait[gait.subjects == "03"]
    D = MotionDistanceTransformer().fit(train).transform(test)
    angles = [[motion.angles for motion in part] for part in (test, train)]
    np.testing.assert_array_equal(D, motion_distances(*angles, skeleton=train.skeleton))


# --- in scikit-learn's tools -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["dataset", "list", "arrays", "array"])
def test_cross_validation_leaves_people_out(gait, knn, form):
    X = {"dataset": gait, "list": list(gait), "arrays": [m.angles for m in gait]}.get(form)
    if form == "array":
        X = np.stack([motion.angles[:12] for motion in gait])
    if form in ("arrays", "array"):
        knn.set_params(motiondistancetransformer__skeleton=gait.skeleton)
    scores = cross_val_score(knn, X, gait.actions, groups=gait.subjects, cv=LeaveOneGroupOut(), error_score="raise")
    expected = []
    for person in np.unique(gait.subjects):
        train, test = np.flatnonzero(gait.subjects != person), np.flatnonzero(gait.subjects == person)
        skeleton = gait[train].skeleton if form in ("dataset", "list") else gait.skeleton
        parts = [[X[i] if form == "array" else gait[i].angles for i in rows] for rows in (test, train)]
        nearest = motion_distances(*parts, skeleton=skeleton).argmin(axis=1)
        expected.append(np.mean(gait.actions[train][nearest] == gait.actions[test]))
    np.testing.assert_allclose(scores, expected)


def test_grid_search_over_metric_window_and_skeleton(gait, knn):
    grid = {
        "motiondistancetransformer__metric": ["angle", "spatial"],
        "motiondistancetransformer__window": [None, 0.1],
        "motiondistancetransformer__skeleton": [None, gait.skeleton.with_weights({"left_hand": 0.0})],
    }
    search = GridSearchCV(knn, grid, cv=GroupKFold(3), error_score="raise")
    search.fit(gait, gait.actions, groups=gait.subjects)
    assert len(search.cv_results_["params"]) == 8
    np.testing.assert_array_equal(search.predict(gait), gait.actions)


def test_a_collection_can_be_split(gait):
    train, test = train_test_split(gait, random_state=0)
    assert MotionDistanceTransformer().fit(train).transform(test).shape == (len(test), len(train))


def test_estimators_that_take_distances(motions):
    D = MotionDistanceTransformer(ARM).fit_transform(motions)
    for estimator in (
        HDBSCAN(2, metric="precomputed", copy=True),
        MedoidShift(bandwidth=0.5, metric="precomputed"),
        SpatialMDS(n_components=2, metric="precomputed"),
    ):
        pipeline = make_pipeline(MotionDistanceTransformer(ARM), clone(estimator)).fit(motions)
        alone = clone(estimator).fit(D)
        name = "embedding_" if isinstance(estimator, SpatialMDS) else "labels_"
        np.testing.assert_array_equal(getattr(pipeline[-1], name), getattr(alone, name))


def test_output_as_a_data_frame(motions):
    transformer = MotionDistanceTransformer(ARM).set_output(transform="pandas")
    frame = transformer.fit_transform(motions)
    assert isinstance(frame, pd.DataFrame)
    assert list(frame.columns) == list(transformer.get_feature_names_out())


def test_clones_and_pickles(motions):
    transformer = MotionDistanceTransformer(ARM, metric="position", window=0.3).fit(motions)
    assert clone(transformer).get_params() == transformer.get_params()
    with pytest.raises(NotFittedError):
        clone(transformer).transform(motions)
    again = pickle.loads(pickle.dumps(transformer))
    np.testing.assert_array_equal(again.transform(motions), transformer.transform(motions))


@pytest.mark.parametrize(
    "change",
    [
        {"window": 0.1},
        {"alignment": "subsequence"},
        {"metric": "angle"},
        {"skeleton": WEIGHTED},
        {"metric": Spatial(2)},
    ],
    ids=str,
)
def test_parameters_that_change_after_fit_change_nothing(motions, change):
    transformer = MotionDistanceTransformer(ARM).fit(motions)
    expected = transformer.transform(motions)
    np.testing.assert_array_equal(transformer.set_params(**change).transform(motions), expected)
    assert np.abs(transformer.fit(motions).transform(motions) - expected).max() > 1e-6  # each of them matters


def test_motions_that_change_after_fit_change_nothing(motions):
    for X in ([motion.copy() for motion in motions], motions[0].copy(), motions[0][np.newaxis].copy()):
        transformer = MotionDistanceTransformer(ARM).fit(X)
        expected = transformer.transform(motions)
        X[0] += 1.0
        np.testing.assert_array_equal(transformer.transform(motions), expected)


def test_geodesics_that_do_not_converge_are_said_once(motions, monkeypatch):
    monkeypatch.setattr(
        "skpose.motions._matrix.MotionMatrix.write", lambda self, *_: (np.zeros(self.shape), [(2, 0.5)])
    )
    transformer = MotionDistanceTransformer(ARM, metric="geodesic").fit(motions)
    with pytest.warns(UserWarning, match="2 of 1156 geodesics did not converge") as caught:
        transformer.transform(motions)
    assert [warning.filename for warning in caught] == [__file__]


# --- what is refused -------------------------------------------------------------------------------------------------


def test_motions_of_another_kind_than_in_fit_are_refused(gait):
    arrays = [motion.angles for motion in gait]
    on_motions = MotionDistanceTransformer().fit(gait)
    on_arrays = MotionDistanceTransformer(gait.skeleton).fit(arrays)
    with pytest.raises(TypeError, match="X holds arrays, but MotionDistanceTransformer was fitted on Motions: pass"):
        on_motions.transform(arrays)
    with pytest.raises(TypeError, match="X holds arrays"):
        on_motions.transform(arrays[0])
    with pytest.raises(TypeError, match="X holds Motions, but MotionDistanceTransformer was fitted on arrays: pass"):
        on_arrays.transform(gait)
    with pytest.raises(
        ValueError, match=r"X has 6 Hz, but .* fitted on motions of 12 Hz.* pass \[motion.resample\(12\)"
    ):
        on_motions.transform([motion.resample(6) for motion in gait])
    with pytest.raises(ValueError, match=r"X\[0\]: .*"):
        on_motions.transform([gait[0].select(drop=["left_hand"])])
    with pytest.raises(TypeError, match="got one Motion: pass"):
        on_motions.transform(gait[0])


def test_another_width_than_in_fit_is_refused(motions):
    wide = [np.zeros((3, 4))]
    with pytest.raises(ValueError, match=r"X\[0\] has 4 columns, but the skeleton has 3 degrees of freedom"):
        MotionDistanceTransformer(ARM).fit(motions).transform(wide)
    angle = MotionDistanceTransformer(metric="angle").fit(motions)
    for X in (wide, np.zeros((2, 4)), np.zeros((2, 5, 4))):
        with pytest.raises(ValueError, match="X has 4 features, but MotionDistanceTransformer is expecting 3 features"):
            angle.transform(X)


@pytest.mark.parametrize(
    ("X", "error", "message"),
    [
        ([], ValueError, "X must be motions: .* got none"),
        ("motions", TypeError, "X must be motions: .* got 'motions'"),
        (None, TypeError, "X must be motions: .* got None"),
        (ARM, TypeError, "got a Skeleton"),
        ([np.zeros((2, 3)), np.full((2, 3), np.nan)], ValueError, r"Input X\[1\] contains NaN"),
        ([np.zeros((2, 3)), np.zeros((0, 3))], ValueError, r"X\[1\] has no frames: leave it out"),
        ([np.zeros((2, 3)), np.zeros((2, 2))], ValueError, r"X\[1\] has 2 columns"),
        (np.zeros(3), ValueError, "Expected 2D array, got 1D array instead"),
        (np.zeros((2, 2, 2, 3)), ValueError, "got an array of shape"),
    ],
    ids=str,
)
def test_what_are_no_motions_is_refused_in_words(X, error, message):
    with pytest.raises(error, match=message):
        MotionDistanceTransformer(ARM).fit(X)


def test_lengths_and_windows_without_a_use_are_refused(motions):
    with pytest.raises(
        ValueError, match=r'"frames" compares motions of equal length, but X\[0\] has 4 frames and X\[1\]'
    ):
        MotionDistanceTransformer(ARM, alignment="frames").fit(motions)
    equal = MotionDistanceTransformer(ARM, alignment="frames").fit(motions[:1] * 2)
    with pytest.raises(ValueError, match=r"X\[0\] has 7 frames and X_fit\[0\] 4"):
        equal.transform(motions[1:2])
    with pytest.raises(ValueError, match=r'window is the band of alignment="dtw", got window=0\.1'):
        MotionDistanceTransformer(ARM, alignment="frames", window=0.1).fit(motions[:1])
