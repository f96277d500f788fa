"""Scores against their definitions, under transformations that must not change them, and inside scikit-learn."""

import conventions
import numpy as np
import pandas as pd
import pytest
import reference
from conftest import SKELETONS
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from sklearn.linear_model import Ridge
from sklearn.metrics import make_scorer
from sklearn.model_selection import GridSearchCV, cross_val_score

from skpose import Motion
from skpose.motions import align_motions
from skpose.scores import (
    acceleration_error,
    dtw_mje,
    geodesic_error,
    mean_angle_error,
    mpjpe,
    npss,
    pck,
    pck_auc,
)
from skpose.skeleton import rotations_from_poses
from skpose.statistics import PoseKernelRegressor

POSITIONS = [mpjpe, pck, pck_auc, acceleration_error]
AVERAGES = ["points", "frames", "joints"]
DATA = conventions.Data(25, seed=0)
TRUE, PRED, MOVED = DATA.true, DATA.pred, DATA.moved
CHECKS = list(conventions.checks(DATA))


@pytest.mark.parametrize("score", [*POSITIONS, dtw_mje, npss, mean_angle_error, geodesic_error])
def test_agrees_with_its_definition(score):
    for who, function, options, true, pred, expected in CHECKS:
        if function is score:
            np.testing.assert_allclose(score(true, pred, **options), expected, rtol=0, atol=1e-9, err_msg=who)


def test_scores_are_floats_and_perfect_for_the_truth():
    assert type(mpjpe(TRUE, PRED)) is type(pck_auc(TRUE, PRED)) is float
    assert mpjpe(TRUE, TRUE) == acceleration_error(TRUE, TRUE) == dtw_mje(TRUE, TRUE) == 0.0
    assert pck(TRUE, TRUE) == pck_auc(TRUE, TRUE, inclusive=True) == 100.0
    assert npss(DATA.motions[0], DATA.motions[0]) == mean_angle_error(DATA.angles[0], DATA.angles[0]) == 0.0
    assert geodesic_error(DATA.rotations[0], DATA.rotations[0]) == 0.0


@pytest.mark.parametrize("score", [*POSITIONS, geodesic_error])
def test_without_an_average_there_is_a_number_for_each_joint_and_frame(score):
    true, pred = DATA.rotations if score is geodesic_error else (DATA.unseen(), PRED)
    each = score(true, pred, average=None)
    inner = slice(1, -1) if score is acceleration_error else slice(None)
    assert each.shape == true[inner].shape[:2]
    assert np.nanmean(each) == pytest.approx(score(true, pred), abs=1e-9)
    assert np.nanmean(np.nanmean(each, axis=0)) == pytest.approx(score(true, pred, average="joints"), abs=1e-9)
    if score in (mpjpe, pck):
        np.testing.assert_array_equal(np.isnan(each), ~DATA.seen)


def test_numbers_of_angles_columns_and_motions():
    true, pred = DATA.angles
    assert mean_angle_error(true, pred, average=None).shape == true.shape
    np.testing.assert_allclose(
        mean_angle_error(true, pred, kind="norm", wrap=False, average=None), np.linalg.norm(true - pred, axis=1)
    )
    motions = DATA.motions
    each = npss(*motions, average=None)
    alone = [[npss(t[:, [k]], p[:, [k]]) for k in range(12)] for t, p in zip(*motions, strict=True)]
    np.testing.assert_allclose(each, alone, atol=1e-12)
    lists = [list(one) for one in zip(*DATA.pairs, strict=True)]
    np.testing.assert_allclose(dtw_mje(*lists, average=None), [dtw_mje(t, p) for t, p in DATA.pairs])


# --- alignment -------------------------------------------------------------------------------------------------------


def similar(positions, scale=1.7):
    rng = np.random.default_rng(1)
    rotations = Rotation.random(len(positions), rng=rng).as_matrix()
    return scale * np.einsum("fij,fnj->fni", rotations, positions) + rng.normal(size=(len(positions), 1, 3))


def test_alignment_undoes_a_transformation():
    rigid, mirrored, shifted = similar(TRUE, scale=1.0), -similar(TRUE), TRUE + 0.1
    assert mpjpe(TRUE, similar(TRUE), align="similarity") < 1e-9
    assert mpjpe(TRUE, rigid, align="rigid") < 1e-9 < 50 < mpjpe(TRUE, similar(TRUE), align="rigid")
    assert mpjpe(TRUE, 3.0 * TRUE, align="scale") < 1e-9
    assert mpjpe(TRUE, mirrored, align="similarity", reflection=True) < 1e-9
    assert mpjpe(TRUE, mirrored, align="similarity") > 50
    assert mpjpe(TRUE, shifted, root=3) < 1e-9 < mpjpe(TRUE, shifted)
    planar = TRUE * [1.0, 1.0, 0.0]
    assert mpjpe(planar, similar(planar), align="similarity") < 1e-9


@pytest.mark.parametrize("how", ["rigid", "similarity"])
def test_no_other_alignment_fits_better(how):
    true, pred = TRUE[1], -TRUE[1]

    def moved(x):
        return (np.exp(x[6]) if how == "similarity" else 1.0) * Rotation.from_rotvec(x[:3]).apply(pred) + x[3:6]

    starts = np.random.default_rng(0).normal(size=(5, 7))
    found = [minimize(lambda x: ((moved(x) - true) ** 2).sum(), x, tol=1e-10) for x in starts]
    best = moved(min(found, key=lambda one: one.fun).x)
    expected = 1e3 * np.linalg.norm(best - true, axis=1).mean()
    assert mpjpe(true[None], pred[None], align=how) == pytest.approx(expected, abs=0.05)


@pytest.mark.parametrize("options", [{"align": "similarity"}, {"align": "scale"}, {"root": 3}])
def test_unknown_joints_do_not_count(options):
    true, pred = TRUE[:3].copy(), MOVED[:3].copy()
    true[0, [2, 9]] = true[1] = np.nan  # some joints of a frame, and all of another
    pred[0, 2] = 99.0
    others = np.delete(np.arange(conventions.N_JOINTS), [2, 9])
    options_of_others = {**options, "root": 2} if "root" in options else options
    first = mpjpe(true[:1, others], pred[:1, others], **options_of_others)
    last = mpjpe(true[2:], pred[2:], **options)
    assert mpjpe(true, pred, **options) == pytest.approx((22 * first + 24 * last) / 46, abs=1e-9)
    if "root" in options:
        true[2, 3] = np.nan
        assert mpjpe(true, pred, **options) == pytest.approx(first, abs=1e-9)


LINE = np.linspace(0, 1, 6)[:, None] * [1.0, 2.0, -1.0]
OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])


@pytest.mark.parametrize(
    ("true", "pred"),
    [
        (LINE, None),
        (None, np.full((6, 3), 1e3)),
        (np.r_[np.eye(3)[:2], np.full((4, 3), np.nan)], None),
        (OCTAHEDRON, -OCTAHEDRON),  # whose mirror image several rotations fit equally well
    ],
)
def test_an_undetermined_rotation_is_refused(true, pred):
    trues, preds = np.random.default_rng(0).normal(size=(2, 5, 6, 3))
    trues[3] = trues[3] if true is None else true
    preds[3] = preds[3] if pred is None else pred
    with pytest.raises(ValueError, match="rotation of frame 3"):
        mpjpe(trues, preds, align="rigid")
    assert mpjpe(trues, preds) > 0


# --- weights, units, inputs ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("average", AVERAGES)
def test_a_weight_of_two_is_a_frame_twice(average):
    weights = np.random.default_rng(0).integers(0, 4, size=len(TRUE))
    twice = np.repeat(np.arange(len(weights)), weights)
    for score in (mpjpe, pck, pck_auc):
        found = score(DATA.unseen(), PRED, average=average, sample_weight=weights)
        assert found == pytest.approx(score(DATA.unseen()[twice], PRED[twice], average=average), abs=1e-9)
    for kind in ("each", "norm"):
        true, pred = DATA.angles
        found = mean_angle_error(true, pred, kind=kind, sample_weight=weights)
        assert found == pytest.approx(mean_angle_error(true[twice], pred[twice], kind=kind), abs=1e-9)


def test_units():
    in_mm = mpjpe(TRUE, PRED)
    assert mpjpe(TRUE, PRED, unit="m") == pytest.approx(in_mm / 1e3)
    assert mpjpe(1e3 * TRUE, 1e3 * PRED, data_unit="mm") == pytest.approx(in_mm)
    assert pck(TRUE, PRED, threshold=0.1, threshold_unit="m") == pck(TRUE, PRED, threshold=100)
    assert pck(TRUE, PRED, unit="share") == pytest.approx(pck(TRUE, PRED) / 100)
    with pytest.warns(UserWarning, match="data_unit='m'"):
        mpjpe(1e3 * TRUE, 1e3 * PRED)
    true, pred = np.degrees(DATA.angles)
    in_degrees = mean_angle_error(true, pred, data_unit="deg", unit="deg")
    assert in_degrees == pytest.approx(np.degrees(mean_angle_error(*DATA.angles)), abs=1e-9)
    with pytest.warns(UserWarning, match='data_unit="deg"'):
        mean_angle_error(true, pred)


def test_rows_frames_motions_and_lists_are_the_same():
    true, pred, expected = DATA.unseen()[:24], PRED[:24], mpjpe(DATA.unseen()[:24], PRED[:24])
    assert mpjpe(true.reshape(24, -1), pred.reshape(24, -1)) == expected
    assert mpjpe(true.reshape(4, 6, -1, 3), pred.reshape(4, 6, -1, 3)) == expected
    assert mpjpe([true[:5], true[5:]], [pred[:5], pred[5:]]) == expected
    assert mpjpe(np.ma.masked_invalid(true), pred.tolist()) == expected
    weighted = mpjpe([true[:5], true[5:]], [pred[:5], pred[5:]], sample_weight=[1, 0])
    assert weighted == pytest.approx(mpjpe(true[:5], pred[:5]))
    a, b = DATA.rotations
    assert geodesic_error([a[:4], a[4:]], [b[:4], b[4:]]) == geodesic_error(a, b)


@pytest.mark.parametrize("name", ["chain", "humanoid", "mixed joints"])
def test_poses_are_scored_by_positions_and_rotations(name):
    skeleton, rng = SKELETONS[name], np.random.default_rng(0)
    poses = rng.uniform(-1, 1, size=(2, 9, skeleton.n_dofs))
    true, pred = (reference.forward_kinematics(one, skeleton) for one in poses)
    assert mpjpe(*poses, skeleton=skeleton) == pytest.approx(mpjpe(true, pred), abs=1e-9)
    by_name = mpjpe(*poses, skeleton=skeleton, joints=skeleton.joint_names[-1])
    assert by_name == pytest.approx(mpjpe(true, pred, joints=skeleton.n_joints - 1), abs=1e-9)
    own = geodesic_error(*(rotations_from_poses(one, skeleton, form="matrix") for one in poses))
    assert geodesic_error(*poses, skeleton=skeleton) == pytest.approx(own, abs=1e-9)
    true, pred = (reference.orientations_and_positions(one, skeleton)[0] for one in poses)
    world = np.mean([(a.inv() * b).magnitude() for a, b in zip(true, pred, strict=True)])
    assert geodesic_error(*poses, skeleton=skeleton, frame="world", unit="rad") == pytest.approx(world, abs=1e-9)
    poses[0, 4, 0] = np.nan
    rest = np.delete(poses, 4, axis=1)
    assert mpjpe(*poses, skeleton=skeleton) == pytest.approx(mpjpe(*rest, skeleton=skeleton), abs=1e-9)


# --- motions, angles, rotations --------------------------------------------------------------------------------------


def test_accelerations_end_with_their_motion():
    true, pred = TRUE[:20].reshape(4, 5, -1, 3), PRED[:20].reshape(4, 5, -1, 3)
    each = [acceleration_error(t, p) for t, p in zip(true, pred, strict=True)]
    assert acceleration_error(true, pred) == pytest.approx(np.mean(each), abs=1e-9)
    weighted = acceleration_error(list(true), list(pred), sample_weight=[0, 1, 0, 3])
    assert weighted == pytest.approx((each[1] + 3 * each[3]) / 4, abs=1e-9)
    linear = 0.01 * np.arange(len(TRUE))[:, None, None] + 0.2
    assert acceleration_error(TRUE, TRUE + linear) < 1e-9


def test_warped_errors_are_those_of_align_motions():
    skeleton, rng = SKELETONS["chain"], np.random.default_rng(0)
    a, b = (np.cumsum(rng.normal(scale=0.2, size=(n, skeleton.n_dofs)), axis=0) for n in (15, 11))
    alignment = align_motions(a, b, skeleton=skeleton, metric="position")
    found = dtw_mje(a, b, skeleton=skeleton, cost="norm", divide=None, unit="m")
    assert found == pytest.approx(alignment.distance * 26, abs=1e-9)
    mean = dtw_mje(a, b, skeleton=skeleton, cost="norm", error="joints", unit="m")
    assert mean == pytest.approx(alignment.joint_distances.mean(), abs=1e-9)


def test_speed_unknown_joints_and_weights_of_warped_motions():
    true = np.cumsum(TRUE[:12], axis=0)
    assert dtw_mje(true, np.repeat(true, np.arange(12) % 3 + 1, axis=0)) == 0.0
    true, pred = TRUE[:1].copy(), PRED[:1]
    true[0, [2, 3]] = np.nan
    for align in (None, "rigid", "similarity"):  # of one frame it is the plain error
        expected = mpjpe(true, pred, align=align, joints=[1, 2, 5])
        assert dtw_mje(true, pred, align=align, joints=[1, 2, 5]) == pytest.approx(expected, abs=1e-9)
    true, pred = map(list, zip(*DATA.pairs, strict=True))
    each = dtw_mje(true, pred, average=None)
    assert dtw_mje(true, pred, sample_weight=[0, 1, 1]) == pytest.approx(np.mean(each[1:]), abs=1e-9)
    assert dtw_mje(true, pred, sample_weight=[0, 1, 0], average="pairs") == pytest.approx(each[1], abs=1e-9)


def test_spectra_do_not_depend_on_shifts_or_on_columns_without_power():
    true, pred = DATA.motions.copy()
    shifted = np.roll(true, 3, axis=1)
    assert npss(true, shifted) < 1e-9 < 1e-2 < npss(true, shifted, spectrum="real")
    expected = npss(true[:, :, 1:], pred[:, :, 1:])
    true[:, 3, 0] = np.nan
    assert npss(true, pred) == pytest.approx(expected, abs=1e-12)
    true[:, :, 0] = 0.0
    assert npss(true, pred) == pytest.approx(expected, abs=1e-12)
    weighted = npss([true[0], true[1, :30]], [pred[0], pred[1, :30]], sample_weight=[1, 0])
    assert weighted == pytest.approx(npss(true[0], pred[0]), abs=1e-12)


def test_whole_turns_and_unknown_angles_do_not_count():
    true, pred = DATA.angles.copy()
    turned = pred + 2 * np.pi * np.random.default_rng(0).integers(-1, 2, size=pred.shape)
    for kind in ("each", "norm"):
        expected = mean_angle_error(true, pred, kind=kind)
        assert mean_angle_error(true, turned, kind=kind) == pytest.approx(expected, abs=1e-9)
    gaps = np.abs((true - pred + np.pi) % (2 * np.pi) - np.pi)
    true[3, 4] = true[5] = np.nan
    assert mean_angle_error(true, pred) == pytest.approx(gaps[~np.isnan(true)].mean(), abs=1e-9)
    whole = np.linalg.norm(np.delete(gaps, [3, 5], axis=0), axis=1)
    assert mean_angle_error(true, pred, kind="norm") == pytest.approx(whole.mean(), abs=1e-9)


def test_forms_of_rotations_are_one():
    expected, shape = geodesic_error(*DATA.rotations), DATA.rotations.shape[1:3]
    forms = {
        "quaternion_wxyz": lambda r: r.as_quat()[:, [3, 0, 1, 2]],
        "quaternion_xyzw": lambda r: -r.as_quat(),
        "6d": lambda r: 3.0 * np.concatenate([r.as_matrix()[:, :, 0], r.as_matrix()[:, :, 1]], axis=1),
        "rotvec": Rotation.as_rotvec,
    }
    for form, write in forms.items():
        true, pred = (write(Rotation.from_matrix(one.reshape(-1, 3, 3))) for one in DATA.rotations)
        found = geodesic_error(true.reshape(*shape, -1), pred.reshape(*shape, -1), form=form)
        assert found == pytest.approx(expected, abs=1e-9)
        rows = geodesic_error(true.reshape(shape[0], -1), pred.reshape(shape[0], -1), form=form)
        assert rows == found


@pytest.mark.parametrize("angle", [1e-12, 1e-8, np.pi])
def test_small_and_large_angles_are_exact(angle):
    true = np.array([[[0.3, -0.2, 0.5]]])
    pred = (Rotation.from_rotvec(true[0]) * Rotation.from_rotvec([[0.0, angle, 0.0]])).as_rotvec()[None]
    found = geodesic_error(true, pred, form="rotvec", unit="rad")
    assert found == pytest.approx(angle, rel=1e-3 if angle < 1e-11 else 1e-7, abs=1e-15)


# --- scikit-learn ----------------------------------------------------------------------------------------------------


def test_scorers_work_in_searches_over_skpose_estimators():
    skeleton = SKELETONS["humanoid"]
    X = np.linspace(0, 6, 40)[:, None]
    poses = 0.3 * np.sin(X + np.linspace(0, 3, skeleton.n_dofs))
    scoring = {
        "mpjpe": make_scorer(mpjpe, greater_is_better=False, align="similarity", skeleton=skeleton),
        "pck": make_scorer(pck, threshold=20, skeleton=skeleton),
    }
    gammas = [0.1, 10.0, 1000.0]
    regressor = PoseKernelRegressor(skeleton, metric="angle")
    search = GridSearchCV(regressor, {"gamma": gammas}, scoring=scoring, refit="mpjpe", cv=3).fit(X, poses)
    errors = search.cv_results_["mean_test_mpjpe"]
    assert (errors < 0).all()
    assert search.best_params_["gamma"] == gammas[errors.argmax()]
    predicted = search.predict(X)
    assert search.score(X, poses) == -mpjpe(poses, predicted, align="similarity", skeleton=skeleton)
    assert (search.cv_results_["mean_test_pck"] <= 100).all()
    rows = TRUE.reshape(len(TRUE), -1)
    assert cross_val_score(Ridge(), rows, rows, scoring=make_scorer(mpjpe, greater_is_better=False), cv=3).shape == (3,)


# --- what is refused -------------------------------------------------------------------------------------------------

A = np.random.default_rng(0).normal(scale=0.3, size=(6, 5, 3))
HOLED = np.where(A[2, 1, 0] == A, np.nan, A)
INFINITE = np.where(A[2, 1, 0] == A, np.inf, A)
R = DATA.rotations[0]
M = DATA.motions[0]
CHAIN = SKELETONS["chain"]
WALK = Motion(CHAIN, np.zeros((4, CHAIN.n_dofs)), 30)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mpjpe(A, A[:5]), "equal shapes"),
        (lambda: mpjpe([A, A[:2]], [A[:2], A]), "equal shapes"),
        (lambda: mpjpe(A[0], A[0]), "y_true must have shape"),  # a frame of five joints, or five frames of one
        (lambda: mpjpe(A[:, :, :2], A[:, :, :2]), "y_true must have shape"),
        (lambda: mpjpe(A, HOLED), "y_pred must not contain NaN"),
        (lambda: mpjpe(INFINITE, A), "y_true must be finite"),
        (lambda: mpjpe(np.full_like(A, np.nan), A), "y_true must have a known"),
        (lambda: mpjpe(A, A, unit="inch"), "'unit'"),
        (lambda: mpjpe(A, A, reflection=True), "reflection"),
        (lambda: mpjpe(A, A, root="hips"), "root"),
        (lambda: mpjpe(A, A, sample_weight=[1, 2]), "sample_weight"),
        (lambda: mpjpe(A, A, skeleton=CHAIN, data_unit="mm"), "columns|data_unit"),
        (lambda: mpjpe(WALK, WALK, skeleton=CHAIN), "angles"),
        (lambda: mpjpe(pd.DataFrame(np.ones((2, 3)), columns=["a_rx", "a_ry", "a_rz"]), A), "skeleton="),
        (lambda: acceleration_error([A, A[:2]], [A, A[:2]]), "three frames"),
        (lambda: dtw_mje(A, A[:, :3]), "same joints"),
        (lambda: dtw_mje(HOLED, A, cost="norm"), "'norm' needs all joints"),
        (lambda: dtw_mje(A, A, divide="true", average="pairs"), "average"),
        (lambda: npss(M, 0 * M), "y_pred is zero"),
        (lambda: npss(A, A), "ambiguous"),
        (lambda: mean_angle_error(M[0, 0], M[0, 0], kind="norm"), "y_true must have shape"),
        (lambda: geodesic_error(R, 2 * R), r"y_pred\[0, 0\] must be a rotation"),
        (lambda: geodesic_error(R, R, frame="world"), "skeleton="),
    ],
)
def test_refuses(call, message):
    with pytest.raises((ValueError, TypeError), match=message):
        call()
