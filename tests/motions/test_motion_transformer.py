"""Distances to the training motions in scikit-learn's tools: forms of X, pipelines, searches, what is refused."""

import pickle

import numpy as np
import pandas as pd
import pytest
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import Skeleton, motion_distances, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import Angle, Spatial
from skpose.motions import MotionDistanceTransformer

ARM = Skeleton.chain(3)


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


# --- distances -------------------------------------------------------------------------------------------------------


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


# --- forms of X ------------------------------------------------------------------------------------------------------


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
    assert (fitted.metric_, fitted.frame_rate_, fitted.n_features_in_) == (Spatial(), 12, gait.skeleton.n_dofs)
    np.testing.assert_array_equal(fitted.transform(gait), motion_distances(gait, list(gait), skeleton=gait.skeleton))
    for other in (list(gait), gait.motions):
        np.testing.assert_array_equal(MotionDistanceTransformer().fit_transform(other), motion_distances(gait))
    given = MotionDistanceTransformer(gait[0].skeleton).fit(gait)
    assert given.skeleton_ == gait[0].skeleton
    assert MotionDistanceTransformer(gait.skeleton).fit([m.angles for m in gait]).frame_rate_ is None


# --- in scikit-learn's tools -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("form", ["dataset", "arrays", "array"])
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
        {"metric": Spatial(2)},
    ],
    ids=str,
)
def test_parameters_that_change_after_fit_change_nothing(motions, change):
    transformer = MotionDistanceTransformer(ARM).fit(motions)
    expected = transformer.transform(motions)
    np.testing.assert_array_equal(transformer.set_params(**change).transform(motions), expected)
    assert np.abs(transformer.fit(motions).transform(motions) - expected).max() > 1e-6  # each of them matters


# --- what is refused -------------------------------------------------------------------------------------------------


def test_motions_of_another_kind_than_in_fit_are_refused(gait):
    arrays = [motion.angles for motion in gait]
    on_motions = MotionDistanceTransformer().fit(gait)
    on_arrays = MotionDistanceTransformer(gait.skeleton).fit(arrays)
    with pytest.raises(TypeError, match="X holds arrays"):
        on_motions.transform(arrays)
    with pytest.raises(TypeError, match="X holds arrays"):
        on_motions.transform(arrays[0])
    with pytest.raises(TypeError, match="X holds Motion"):
        on_arrays.transform(gait)
    with pytest.raises(ValueError, match="X has 6 Hz"):
        on_motions.transform([motion.resample(6) for motion in gait])
    with pytest.raises(ValueError, match=r"X\[0\]"):
        on_motions.transform([gait[0].select(drop=["left_hand"])])
