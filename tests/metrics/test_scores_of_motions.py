"""Scores of motions, angles and rotations: what they see, what they leave out, and what they refuse."""

import numpy as np
import pytest
import reference
import score_conventions as conventions
from conftest import SKELETONS
from scipy.spatial.transform import Rotation

from skpose import rotations_from_poses
from skpose.metrics import acceleration_error, dtw_mje, geodesic_error, mean_angle_error, mpjpe, npss
from skpose.motions import align_motions


@pytest.fixture(scope="module")
def data():
    return conventions.Data(25, seed=1)


# --- acceleration ----------------------------------------------------------------------------------------------------


def test_accelerations_end_with_their_motion(data):
    true, pred = data.true[:20].reshape(4, 5, -1, 3), data.pred[:20].reshape(4, 5, -1, 3)
    each = [acceleration_error(t, p) for t, p in zip(true, pred, strict=True)]
    found = acceleration_error(true, pred)
    assert found == pytest.approx(np.mean(each), abs=1e-9)
    assert found.n_counted == 4 * 3 * conventions.N_JOINTS
    assert acceleration_error(list(true), list(pred)) == found
    weighted = acceleration_error(true, pred, sample_weight=[0, 1, 0, 3])
    assert weighted == pytest.approx((each[1] + 3 * each[3]) / 4, abs=1e-9)


def test_constant_and_linear_errors_are_no_acceleration(data):
    time = np.arange(len(data.true))[:, None, None]
    assert acceleration_error(data.true, data.true + 0.01 * time + 0.2) < 1e-9


def test_a_missing_joint_takes_three_accelerations_of_its_own(data):
    true = data.true.copy()
    true[10, 3] = np.nan
    found = acceleration_error(true, data.pred)
    assert (found.n_missing, found.n_counted) == (3, 23 * conventions.N_JOINTS - 3)


# --- dynamic time warping --------------------------------------------------------------------------------------------


def test_time_has_no_part_in_warped_errors(data):
    true = np.cumsum(data.true[:12], axis=0)
    slow = np.repeat(true, np.random.default_rng(0).integers(1, 4, size=12), axis=0)
    assert dtw_mje(true, slow) == dtw_mje(slow, true) == 0.0


def test_is_the_alignment_of_skpose_under_position():
    """Under "norm" the path and the sum are those of `align_motions`, which divides by the frames of both."""
    skeleton, rng = SKELETONS["chain"], np.random.default_rng(0)
    a, b = (np.cumsum(rng.normal(scale=0.2, size=(n, skeleton.n_dofs)), axis=0) for n in (15, 11))
    alignment = align_motions(a, b, skeleton=skeleton, metric="position")
    found = dtw_mje(a, b, skeleton=skeleton, cost="norm", divide=None, unit="m")
    assert found == pytest.approx(alignment.distance * 26, abs=1e-9)
    mean = dtw_mje(a, b, skeleton=skeleton, cost="norm", error="joints", unit="m")
    assert mean == pytest.approx(alignment.joint_distances.mean(), abs=1e-9)


def test_missing_joints_are_left_out_of_warped_errors(data):
    true, pred = data.true[:6].copy(), data.pred[:8]
    true[2, 5] = np.nan

    def cost(t, p):
        seen = ~np.isnan(t).any(axis=1)
        return conventions.joint_error(t[seen], p[seen])

    total, path = conventions.warp(true, pred, cost)
    found = dtw_mje(true, pred)
    assert found == pytest.approx(1e3 * total / len(path), abs=1e-9)
    assert (found.n_counted, found.n_missing) == (6 * conventions.N_JOINTS - 1, 1)


def test_several_motions_are_weighed(data):
    true, pred = map(list, zip(*data.pairs, strict=True))
    each = [dtw_mje(t, p) for t, p in data.pairs]
    assert dtw_mje(true, pred) == pytest.approx(np.mean(each), abs=1e-9)
    assert dtw_mje(true, pred, sample_weight=[0, 1, 1]) == pytest.approx(np.mean(each[1:]), abs=1e-9)
    assert dtw_mje(true, pred, sample_weight=[0, 1, 0], pool=True) == pytest.approx(each[1], abs=1e-9)


@pytest.mark.parametrize("align", ["scale", "rigid", "similarity"])
def test_all_joints_take_part_in_the_alignment(align, data):
    """As in `mpjpe`, which of one frame is the same."""
    true, pred, joints = data.true[:1].copy(), data.pred[:1], [1, 2, 5]
    true[0, [2, 3]] = np.nan
    several = dtw_mje(true, pred, align=align, joints=joints)
    assert several == pytest.approx(mpjpe(true, pred, align=align, joints=joints), abs=1e-9)
    assert (several.n_counted, several.n_missing) == (2, 1)
    assert dtw_mje(true, pred, align=align, joints=1) == pytest.approx(
        mpjpe(true, pred, align=align, joints=1), abs=1e-9
    )


@pytest.mark.parametrize("warp", ["pose", "joint"])
def test_joints_that_count_are_warped_alone(warp, data):
    true, pred, joints = data.true[:6], data.pred[:8], [5, 1]
    expected = dtw_mje(true[:, joints], pred[:, joints], warp=warp)
    assert dtw_mje(true, pred, joints=joints, warp=warp) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("factor", "likely"), [(1e3, "mm"), (1e2, "cm")])
def test_another_unit_of_a_warped_motion_is_noticed(factor, likely, data):
    with pytest.warns(UserWarning, match=f'data_unit="{likely}"'):
        dtw_mje(factor * data.true[:4], factor * data.pred[:5])


# --- spectra ---------------------------------------------------------------------------------------------------------


def test_power_spectra_do_not_see_shifts_and_real_parts_do(data):
    shifted = np.roll(data.motions[0], 3, axis=1)
    assert npss(data.motions[0], shifted) < 1e-9
    assert npss(data.motions[0], shifted, spectrum="real") > 1e-2


def test_columns_of_spectra(data):
    true, pred = data.motions.copy()
    expected = npss(true[:, :, 1:], pred[:, :, 1:])
    true[:, 3, 0] = np.nan
    found = npss(true, pred)
    assert found == pytest.approx(expected, abs=1e-12)
    assert (found.n_counted, found.n_missing) == (5 * 11, 5)
    true[:, :, 0] = 0.0  # without power
    assert npss(true, pred) == pytest.approx(expected, abs=1e-12)
    assert npss(list(true), list(pred), sample_weight=[1, 0, 0, 0, 0]) == pytest.approx(
        npss(true[0], pred[0]), abs=1e-12
    )
    different = npss([true[0], true[1, :30]], [pred[0], pred[1, :30]])
    assert 0 < different < 20


# --- angles ----------------------------------------------------------------------------------------------------------


def test_whole_turns_are_no_difference(data):
    true, pred = data.angles
    turned = pred + 2 * np.pi * np.random.default_rng(0).integers(-2, 3, size=pred.shape)
    for kind in ("each", "norm"):
        assert mean_angle_error(true, turned, kind=kind) == pytest.approx(
            mean_angle_error(true, pred, kind=kind), abs=1e-9
        )
    in_degrees = mean_angle_error(np.degrees(true), np.degrees(turned), data_unit="deg", unit="deg")
    assert in_degrees == pytest.approx(np.degrees(mean_angle_error(true, pred)), abs=1e-9)


def test_unknown_angles_are_left_out(data):
    true, pred = data.angles.copy()
    gaps = np.abs((true - pred + np.pi) % (2 * np.pi) - np.pi)
    true[3, 4] = true[5] = np.nan
    each, norm = (mean_angle_error(true, pred, kind=kind) for kind in ("each", "norm"))
    assert each == pytest.approx(gaps[~np.isnan(true)].mean(), abs=1e-9)
    whole = np.delete(gaps, [3, 5], axis=0)
    assert norm == pytest.approx(np.linalg.norm(whole, axis=1).mean(), abs=1e-9)
    assert (each.n_missing, norm.n_missing) == (1 + 99, 2 * 99)


def test_weights_of_angles(data):
    true, pred = data.angles
    weights = np.arange(len(true))
    twice = np.repeat(weights, weights)
    for kind in ("each", "norm"):
        found = mean_angle_error(true, pred, kind=kind, sample_weight=weights)
        assert found == pytest.approx(mean_angle_error(true[twice], pred[twice], kind=kind), abs=1e-9)
    assert mean_angle_error(true[:, 0], pred[:, 0]) == mean_angle_error(true[:, :1], pred[:, :1])  # one target


def test_angles_in_degrees_are_noticed():
    true, pred = np.random.default_rng(0).uniform(-60, 60, size=(2, 30, 8))
    true[3, 2] = np.nan
    with pytest.warns(UserWarning, match='y_true reach .* pass data_unit="deg"'):
        mean_angle_error(true, pred, unit="deg")
    with pytest.warns(UserWarning, match="y_pred reach"):
        mean_angle_error([np.radians(true)], [pred])
    in_degrees = mean_angle_error(true, pred, unit="deg", data_unit="deg")
    assert in_degrees == pytest.approx(mean_angle_error(*np.radians([true, pred]), unit="deg"), abs=1e-9)
    true[4, 2:4] = np.nan
    with pytest.warns(UserWarning, match=r"np\.radians\(y_true\)"):
        geodesic_error(true[:, :6], np.radians(pred[:, :6]), form="rotvec")


# --- rotations -------------------------------------------------------------------------------------------------------


FORMS = {
    "quaternion_wxyz": lambda r: r.as_quat()[:, [3, 0, 1, 2]],
    "quaternion_xyzw": lambda r: -r.as_quat(),
    "matrix": Rotation.as_matrix,
    "6d": lambda r: 3.0 * np.concatenate([r.as_matrix()[:, :, 0], r.as_matrix()[:, :, 1]], axis=1),
    "rotvec": Rotation.as_rotvec,
}


@pytest.mark.parametrize("form", FORMS)
def test_forms_of_rotations_are_one(form, data):
    expected = geodesic_error(*data.rotations)
    true, pred = (FORMS[form](Rotation.from_matrix(one.reshape(-1, 3, 3))) for one in data.rotations)
    shape = (*data.rotations.shape[1:3], *true.shape[1:])
    assert geodesic_error(true.reshape(shape), pred.reshape(shape), form=form) == pytest.approx(expected, abs=1e-9)
    rows = (len(data.rotations[0]), -1)
    assert geodesic_error(true.reshape(rows), pred.reshape(rows), form=form) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("angle", [1e-12, 1e-8, 1e-3, 1.0, np.pi - 1e-9, np.pi])
def test_small_and_large_angles_are_exact(angle):
    true = np.array([[[0.3, -0.2, 0.5]]])
    pred = (Rotation.from_rotvec(true[0]) * Rotation.from_rotvec([[0.0, angle, 0.0]])).as_rotvec()[None]
    found = geodesic_error(true, pred, form="rotvec", unit="rad")
    assert found == pytest.approx(angle, rel=1e-3 if angle < 1e-11 else 1e-7, abs=1e-15)


def test_unknown_rotations_are_left_out(data):
    true = data.rotations[0].copy()
    true[2, 3] = np.nan
    seen = np.ones(true.shape[:2], dtype=bool)
    seen[2, 3] = False
    found = geodesic_error(true, data.rotations[1])
    expected = conventions.angle_between(data.rotations[0][seen], data.rotations[1][seen]).mean()
    assert found == pytest.approx(np.degrees(expected), abs=1e-9)
    assert (found.n_counted, found.n_missing) == (seen.sum(), 1)


@pytest.mark.parametrize("name", ["chain", "humanoid", "mixed joints"])
def test_poses_are_scored_by_their_rotations(name):
    skeleton, rng = SKELETONS[name], np.random.default_rng(0)
    poses = rng.uniform(-1, 1, size=(2, 9, skeleton.n_dofs))
    own = geodesic_error(*(rotations_from_poses(one, skeleton, form="matrix") for one in poses))
    assert geodesic_error(*poses, skeleton=skeleton) == pytest.approx(own, abs=1e-9)
    true, pred = (reference.orientations_and_positions(one, skeleton)[0] for one in poses)
    world = np.mean([(a.inv() * b).magnitude() for a, b in zip(true, pred, strict=True)])
    assert geodesic_error(*poses, skeleton=skeleton, frame="world", unit="rad") == pytest.approx(world, abs=1e-9)
    weighted = geodesic_error(*poses, skeleton=skeleton, sample_weight=[1, *[0] * 8])
    assert weighted == pytest.approx(geodesic_error(*poses[:, :1], skeleton=skeleton), abs=1e-9)


def test_a_list_of_motions_is_their_frames(data):
    true, pred = data.rotations
    expected = geodesic_error(true, pred)
    assert geodesic_error([true[:4], true[4:]], [pred[:4], pred[4:]]) == expected


# --- what is refused -------------------------------------------------------------------------------------------------


R = Rotation.random(6, rng=np.random.default_rng(0)).as_matrix().reshape(3, 2, 3, 3)
M = np.random.default_rng(0).normal(size=(4, 8, 5))
P = np.random.default_rng(1).normal(scale=0.3, size=(6, 5, 3))
HOLED = P.copy()
HOLED[2, 1] = np.nan
NO_FRAME = P.copy()
NO_FRAME[2] = np.nan
CHAIN = SKELETONS["chain"]
ZERO = M.copy()
ZERO[1, :, 2] = 0.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: dtw_mje(P, P, cost="cosine"), "cost must be"),
        (lambda: dtw_mje(P, P, divide="both"), "divide must be 'path', 'true' or None"),
        (lambda: dtw_mje(P, P, divide="true", pool=True), "pool=True is the mean over all pairs"),
        (lambda: dtw_mje(P, P, align="rigid", cost="norm"), "align= needs cost='joints'"),
        (lambda: dtw_mje(P, P[:, :3]), "same joints, and motion 0 has 5 and 3"),
        (lambda: dtw_mje([P], P), "both be lists"),
        (lambda: dtw_mje([P, P], [P]), "as many motions, got 2 and 1"),
        (lambda: dtw_mje(P, HOLED), "NaN"),
        (lambda: dtw_mje(HOLED, P, cost="norm"), "'norm' needs all joints"),
        (lambda: dtw_mje(NO_FRAME, P), "no joint of frame 2"),
        (lambda: dtw_mje(P[:0], P), "no frames"),
        (lambda: dtw_mje(P[None][:0], P[None][:0]), "no motions"),
        (lambda: dtw_mje(P[:, :2], P[:, :2], align="similarity"), "less than three joints"),
        (lambda: npss(M, M[:, :7]), "equal shapes"),
        (lambda: npss(M[:, :1], M[:, :1]), "two frames at least, and motion 0 has one"),
        (lambda: npss(M, ZERO), "y_pred is zero in all frames of column 2 of motion 1"),
        (lambda: npss(0 * M, M), "it has no power"),
        (lambda: npss(M, np.where(M > 1, np.nan, M)), r"y_pred\[\d\] has .* NaN"),
        (lambda: npss(M, M, spectrum="phase"), "spectrum must be 'power' or 'real'"),
        (lambda: npss(M[0], M[0], sample_weight=np.arange(8)), "one number a motion"),
        (lambda: npss(P, P), r"6 motions of 5 frames and three features, or 6 frames of 5 joints\?"),
        (lambda: mean_angle_error(M, M, kind="sum"), "kind must be"),
        (lambda: mean_angle_error(M, M, unit="turns"), "unit must be 'rad' or 'deg'"),
        (lambda: mean_angle_error(M, M, drop_constant="both"), "drop_constant must be"),
        (lambda: mean_angle_error(0 * M, M, drop_constant="true"), "no angle is left"),
        (
            lambda: mean_angle_error(M[0, 0], M[0, 0], kind="norm"),
            r"reshape\(y_true, \(1, -1\)\) for one frame of 5",
        ),
        (lambda: geodesic_error(R, R[:2]), "equal shapes"),
        (lambda: geodesic_error([R, R[:2]], [R[:2], R]), "motions of 3, 2 and 2, 3 frames"),
        (lambda: geodesic_error([R], R), "both be lists"),
        (lambda: geodesic_error([R, R[:, :1]], [R, R]), "the same columns"),
        (lambda: geodesic_error([P[:3, 0], P[3:, 0]], [P[3:, 0], P[:2, 0]], form="rotvec"), "motions of 3, 3 and 3, 2"),
        (
            lambda: geodesic_error([P[:4, :, 0], P[4:, :, 0]], [P[:2, :, 0], P[2:, :, 0]], skeleton=CHAIN),
            "4, 2 and 2, 4",
        ),
        (lambda: geodesic_error(R, 2 * R), r"y_pred\[0, 0\] must be a rotation matrix.*\"6d\""),
        (lambda: geodesic_error(-R, R), r"y_true\[0, 0\] must be a rotation matrix"),
        (lambda: geodesic_error(R, R, form="rotvec"), "for form 'rotvec'"),
        (lambda: geodesic_error(R, R, form="euler"), "form must be"),
        (lambda: geodesic_error(R, R, frame="world"), "needs skeleton="),
        (lambda: geodesic_error(R, np.where(R > 0.3, np.nan, R)), "NaN"),
        (lambda: geodesic_error(R * np.nan, R), "nothing to score"),
        (lambda: geodesic_error(np.zeros((3, 2, 4)), np.zeros((3, 2, 4)), form="quaternion_wxyz"), "length one"),
    ],
)
def test_scores_of_motions_refuse(call, message):
    with pytest.raises(ValueError, match=message):
        call()
