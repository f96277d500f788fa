"""Signatures of scores as texts, and scorers in scikit-learn."""

import pickle

import numpy as np
import pytest
import score_conventions as conventions
from sklearn.base import clone
from sklearn.compose import TransformedTargetRegressor
from sklearn.linear_model import LinearRegression, Ridge
from sklearn.metrics import make_scorer
from sklearn.model_selection import GridSearchCV, cross_val_score, cross_validate
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

from skpose import Skeleton, forward_kinematics
from skpose.metrics import get_scorer, mpjpe, pose_score
from skpose.metrics._scores._signature import KINDS
from skpose.statistics import PoseKernelRegressor

CHECKS = list(conventions.checks(conventions.Data(15, seed=2)))


@pytest.mark.parametrize("check", CHECKS, ids=[" ".join(check[:2]) for check in CHECKS])
def test_the_signature_of_a_score_gives_it_again(check):
    signature, _, true, pred, _ = check
    score = pose_score(signature, true, pred)
    again = pose_score(score.signature, true, pred)
    assert (again, again.signature) == (score, score.signature)
    given = {part for part in signature.split("|")[2:] if not part.endswith("=None")}
    assert given <= {*score.signature.split("|")}


def test_every_name_has_a_check():
    names = {signature.split("|")[0].removeprefix("PA-").removeprefix("N-") for signature, *_ in CHECKS}
    assert names == {*KINDS}


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("mpjpe", "MPJPE|mm"),
        (" pa-mpjpe | cm ", "PA-MPJPE|cm|scale"),
        ("PA-MPJPE|rigid|reflection", "PA-MPJPE|mm|rigid|reflection"),
        ("PA-MPJPE|mm|rigid|root=2,3", "PA-MPJPE|mm|rigid|root=2,3"),
        ("MPJPE|m|average=frames|joints=4", "MPJPE|m|joints=4|average=frames"),
        ("PCK|share|5cm|inclusive", "PCK|share|5cm|inclusive"),
        ("N-PCK-AUC|%|0.2 m|n_thresholds=5", "N-PCK-AUC|%|0.2m|n_thresholds=5|rule=mean"),
        ("accel|cm/s^2|frame_rate=25", "Accel|cm/s²|frame_rate=25"),
        ("Accel|mm/frame2", "Accel|mm/frame²"),
        ("DTW-MJE|error=l1|divide=None|pool=False", "DTW-MJE|mm|cost=joints|divide=None|error=l1"),
        ("MPJPE|mm|data_unit=cm", "MPJPE|mm|data_unit=cm"),
    ],
)
def test_texts_that_are_understood(text, canonical):
    true, pred = np.random.default_rng(0).normal(size=(2, 9, 6, 3))
    if "data_unit=cm" in text:
        true, pred = 100 * true, 100 * pred
    assert pose_score(text, true, pred).signature == canonical


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "must be a text such as"),
        (None, "must be a text such as"),
        ("MPJE|mm", "no score 'MPJE'; did you mean 'MPJPE'"),
        ("PA-NPSS", "no score 'PA-NPSS'"),
        ("MPJPE|inch", "'inch' is no unit and no option of MPJPE: its unit, 'mm' or 'cm' or 'm'"),
        ("MPJPE|mm|scale", "'scale' is no unit and no option"),
        ("MPJPE|mm|align=rigid", "no option 'align'"),
        ("PCK|150mm|inclusive=True", "no option 'inclusive'"),
        ("PCK|%|150mm|100mm", "says threshold twice"),
        ("MPJPE|mm|root=0|root=1", "says root twice"),
        ("PA-MPJPE|mm|scale|rigid", "says align twice"),
        ("PA-DTW-MJE|mm|rigid|rigid", "says align twice"),
        ("PCK-AUC|n_thresholds=many", "must have a value that n_thresholds takes"),
        ("Accel|mm/s²", "needs the frame rate"),
        ("Accel|mm/frame²|frame_rate=30", "per frame, and has a frame rate"),
        ("NPSS|mm", "its unit, none"),
        ("Angle|rad|wrap=yes", "must have a value that wrap takes"),
        ("PA-DTW-MJE|mm|reflection", "'reflection' is no unit"),
    ],
)
def test_texts_that_are_refused(text, message):
    true, pred = np.random.default_rng(0).normal(size=(2, 9, 6, 3))
    with pytest.raises(ValueError, match=message):
        pose_score(text, true, pred)


def test_a_score_of_angles_takes_no_skeleton():
    with pytest.raises(ValueError, match="takes no skeleton="):
        pose_score("Angle|rad", [[0.0]], [[0.0]], skeleton=Skeleton.chain(1))


# --- scorers ---------------------------------------------------------------------------------------------------------


ARM = Skeleton.chain(4)  # twelve columns of positions, four of angles


@pytest.fixture(scope="module")
def regression():
    """Features, poses of an arm, and positions of its joints in rows."""
    rng = np.random.default_rng(0)
    X = rng.normal(size=(60, 3))
    poses = 0.5 * np.tanh(X @ rng.normal(size=(3, 4))) + rng.normal(scale=0.05, size=(60, 4))
    return X, poses, forward_kinematics(poses, ARM).reshape(60, -1)


def test_errors_are_negative_and_shares_are_not(regression):
    X, _, positions = regression
    model = Ridge().fit(X, positions)
    for signature, sign in (("PA-MPJPE|mm", -1), ("PCK|%|50mm", 1), ("PCK-AUC|%", 1)):
        expected = sign * pose_score(signature, positions, model.predict(X))
        found = get_scorer(signature)(model, X, positions)
        assert type(found) is float
        assert found == expected
    weights = np.arange(60)
    expected = -pose_score("MPJPE|mm", positions, model.predict(X), sample_weight=weights)
    assert get_scorer("MPJPE|mm")(model, X, positions, sample_weight=weights) == expected


def test_in_cross_validation_and_search(regression):
    X, _, positions = regression
    scorer = get_scorer("MPJPE|mm")
    scores = cross_val_score(Ridge(), X, positions, scoring=scorer, cv=3)
    same = cross_val_score(Ridge(), X, positions, scoring=make_scorer(mpjpe, greater_is_better=False), cv=3)
    np.testing.assert_array_equal(scores, same)
    several = cross_validate(Ridge(), X, positions, scoring={"a": scorer, "b": get_scorer("PCK|%|20mm")}, cv=3)
    np.testing.assert_array_equal(several["test_a"], scores)
    search = GridSearchCV(Ridge(), {"alpha": [1e-3, 1e3]}, scoring=scorer, cv=3).fit(X, positions)
    assert search.best_params_ == {"alpha": 1e-3}
    assert search.score(X, positions) == scorer(search, X, positions)
    assert clone(search).scoring == scorer


def test_regressors_of_poses_are_scored_on_their_skeleton(regression):
    X, poses, positions = regression
    model = PoseKernelRegressor(ARM).fit(X, poses)
    expected = -pose_score("PA-MPJPE|mm", positions, forward_kinematics(model.predict(X), ARM).reshape(60, -1))
    scorer = get_scorer("PA-MPJPE|mm")
    assert scorer(model, X, poses) == pytest.approx(expected, abs=1e-9)
    assert get_scorer("PA-MPJPE|mm", skeleton=ARM)(model, X, poses) == scorer(model, X, poses)
    geodesic = -pose_score("Geodesic|deg", poses, model.predict(X), skeleton=ARM)
    assert get_scorer("Geodesic|deg")(model, X, poses) == geodesic
    assert get_scorer("Angle|rad")(model, X, poses) == -pose_score("Angle|rad", poses, model.predict(X))
    piped = make_pipeline(StandardScaler(), PoseKernelRegressor(ARM))
    assert get_scorer("MPJPE|mm")(piped.fit(X, poses), X, poses) < 0
    search = GridSearchCV(piped, {"posekernelregressor__gamma": [1.0, 9.0]}, scoring=scorer, cv=2).fit(X, poses)
    assert scorer(search, X, poses) < 0
    assert scorer(search, X, poses) == scorer(search.best_estimator_, X, poses)
    inner = TransformedTargetRegressor(PoseKernelRegressor(ARM), check_inverse=False)
    assert scorer(inner.fit(X, poses), X, poses) == pytest.approx(scorer(model, X, poses), abs=1e-9)


def test_joint_angles_are_not_taken_for_positions(regression):
    """Their number of columns may be a multiple of three."""
    X, poses, _ = regression
    six = np.hstack([poses, poses[:, :2]])
    model = PoseKernelRegressor(metric="angle").fit(X, six)
    with pytest.raises(ValueError, match="has learnt joint angles without a skeleton"):
        get_scorer("MPJPE|mm")(model, X, six)
    assert get_scorer("Angle|rad")(model, X, six) < 0


def test_a_skeleton_for_any_regressor_of_poses(regression):
    X, poses, _ = regression
    model = LinearRegression().fit(X, poses)
    expected = -mpjpe(poses, model.predict(X), skeleton=ARM)
    assert get_scorer("MPJPE|mm", skeleton=ARM)(model, X, poses) == expected


@pytest.mark.parametrize("signature", ["Accel|mm", "DTW-MJE|mm", "NPSS"])
def test_scores_of_motions_say_what_a_row_is(signature, regression):
    X, _, positions = regression
    model = Ridge().fit(X, positions)
    pred = model.predict(X)
    with pytest.raises(ValueError, match="n_frames= says how many frames each row of y has"):
        get_scorer(signature)
    found = get_scorer(signature, n_frames="all")(model, X, positions)
    assert found == -pose_score(signature, positions, pred)
    rows, motions = positions.reshape(12, -1), positions.reshape(12, 5, -1)  # a motion of five frames a row
    model = Ridge().fit(X[::5], rows)
    found = get_scorer(signature, n_frames=5)(model, X[::5], rows)
    assert found == -pose_score(signature, list(motions), list(model.predict(X[::5]).reshape(12, 5, -1)))
    with pytest.raises(ValueError, match="rows of n_frames=7 frames"):
        get_scorer(signature, n_frames=7)(model, X[::5], rows)


def test_scorers_refuse_and_show():
    with pytest.raises(ValueError, match="takes no n_frames="):
        get_scorer("MPJPE|mm", n_frames=3)
    with pytest.raises(ValueError, match="n_frames must be a whole number"):
        get_scorer("NPSS", n_frames=1)
    with pytest.raises(ValueError, match="no score"):
        get_scorer("neg_mean_squared_error")
    scorer = get_scorer("Accel|mm/s²|frame_rate=30", skeleton=ARM, n_frames=5)
    other = pickle.loads(pickle.dumps(scorer))
    assert (other.signature, other.skeleton, other.n_frames) == (scorer.signature, ARM, 5)
    assert repr(get_scorer("NPSS", n_frames="all")) == "get_scorer('NPSS', n_frames='all')"
