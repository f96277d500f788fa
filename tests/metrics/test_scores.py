"""Scores against the definitions, what leaves them unchanged, what is left out, and what is refused."""

import copy
import pickle

import numpy as np
import pytest
import reference
import score_conventions as conventions
from conftest import SKELETONS
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from skpose import Motion
from skpose.metrics import (
    Score,
    acceleration_error,
    dtw_mje,
    geodesic_error,
    mean_angle_error,
    mpjpe,
    npss,
    pck,
    pck_auc,
    pose_score,
)

POSITIONS = {"mpjpe": mpjpe, "pck": pck, "pck_auc": pck_auc, "acceleration_error": acceleration_error}


@pytest.fixture(scope="module")
def data():
    return conventions.Data(25, seed=0)


CHECKS = list(conventions.checks(conventions.Data(25, seed=0)))


@pytest.mark.parametrize(
    ("signature", "who", "true", "pred", "expected"), CHECKS, ids=[" ".join(check[:2]) for check in CHECKS]
)
def test_agrees_with_its_definition(signature, who, true, pred, expected):
    np.testing.assert_allclose(float(pose_score(signature, true, pred)), expected, rtol=0, atol=1e-9)


# --- alignment -------------------------------------------------------------------------------------------------------


def similar(positions, seed=1, scale=1.7):
    rng = np.random.default_rng(seed)
    rotations = Rotation.random(len(positions), rng=rng).as_matrix()
    return scale * np.einsum("fij,fnj->fni", rotations, positions) + rng.normal(size=(len(positions), 1, 3))


def test_alignment_undoes_what_it_is_named_after(data):
    moved, rigid, mirrored = similar(data.true), similar(data.true, scale=1.0), -similar(data.true)
    assert mpjpe(data.true, moved, align="similarity") < 1e-9
    assert mpjpe(data.true, rigid, align="rigid") < 1e-9
    assert mpjpe(data.true, moved, align="rigid") > 50
    assert mpjpe(data.true, 3.0 * data.true, align="scale") < 1e-9
    assert mpjpe(data.true, mirrored, align="similarity") > 50
    assert mpjpe(data.true, mirrored, align="similarity", reflection=True) < 1e-9
    shifted = data.true + np.array([0.1, 0.2, 0.3])
    assert mpjpe(data.true, shifted, root=3) < 1e-9 < mpjpe(data.true, shifted)


@pytest.mark.parametrize("how", ["rigid", "similarity"])
def test_alignment_is_the_least_squares_one(how, data):
    """A search over rotations, scales and translations finds none that fits better, for mirror images either."""
    for true, pred in [(data.true[0], data.moved[0]), (data.true[1], -data.true[1])]:

        def moved(x, pred=pred):
            size = np.exp(x[6]) if how == "similarity" else 1.0
            return size * Rotation.from_rotvec(x[:3]).apply(pred) + x[3:6]

        starts = np.random.default_rng(0).normal(size=(12, 7))
        found = [minimize(lambda x: ((moved(x) - true) ** 2).sum(), x, tol=1e-14) for x in starts]  # noqa: B023
        best = moved(min(found, key=lambda one: one.fun).x)
        expected = 1e3 * np.linalg.norm(best - true, axis=1).mean()
        assert mpjpe(true[None], pred[None], align=how) == pytest.approx(expected, abs=0.05)


def test_alignment_leaves_unseen_joints_out(data):
    """With joints missing it is the alignment of the others, and what is predicted for the missing ones has no part."""
    true, pred = data.true[:1].copy(), data.moved[:1].copy()
    true[0, [2, 9]] = np.nan
    others = [j for j in range(conventions.N_JOINTS) if j not in (2, 9)]
    for options in ({"align": "similarity"}, {"align": "rigid"}, {"align": "scale"}, {"root": 0}, {}):
        expected = mpjpe(true[:, others], pred[:, others], **options)
        pred[0, 2] = 99.0
        found = mpjpe(true, pred, **options)
        assert found == pytest.approx(expected, abs=1e-9)
        assert (found.n_counted, found.n_missing) == (22, 2)


@pytest.mark.parametrize("options", [{"root": 3}, {"root": [2, 3]}, {"align": "similarity"}, {"align": "scale"}])
def test_a_frame_that_cannot_be_aligned_to_is_left_out(data, options):
    """Without the root of the truth, or without any of its joints, the frame counts for nothing."""
    true = data.true.copy()
    true[1, 3 if "root" in options else slice(None)] = np.nan
    others = np.arange(len(true)) != 1
    expected = mpjpe(data.true[others], data.moved[others], **options)
    found = mpjpe(true, data.moved, **options)
    assert found == pytest.approx(expected, abs=1e-9)
    assert (found.n_counted, found.n_missing) == (expected.n_counted, data.true.shape[1])


def test_many_frames_are_aligned_in_parts(data):
    many = np.tile(data.true, (800, 1, 1))  # more than are aligned at once
    expected = mpjpe(data.true, data.moved, align="similarity")
    assert mpjpe(many, np.tile(data.moved, (800, 1, 1)), align="similarity") == pytest.approx(expected, abs=1e-9)


LINE = np.linspace(0, 1, 6)[:, None] * [1.0, 2.0, -1.0]


@pytest.mark.parametrize(
    ("true", "pred", "message"),
    [
        (LINE, None, "frame 3 is not determined: the joints that are seen lie on one line"),
        (None, LINE, "frame 3 is not determined: the joints that are seen lie on one line"),
        (np.ones((6, 3)), None, "all joints of frame 3 of y_true are one point"),
        (None, np.full((6, 3), 1e3), "all joints of frame 3 of y_pred are one point"),
        (
            np.r_[np.eye(3)[:2], np.full((4, 3), np.nan)],
            None,
            "needs three joints at least, and frame 3 of y_true has 2",
        ),
        (
            np.vstack([np.eye(3), -np.eye(3)]),
            -np.vstack([np.eye(3), -np.eye(3)]),
            "mirror image of the truth, which several",
        ),
    ],
)
@pytest.mark.parametrize("align", ["rigid", "similarity"])
def test_an_alignment_that_is_not_determined_is_refused(true, pred, message, align):
    rng = np.random.default_rng(0)
    trues, preds = rng.normal(size=(2, 5, 6, 3))
    trues[3] = trues[3] if true is None else true
    preds[3] = preds[3] if pred is None else pred
    with pytest.raises(ValueError, match=message):
        mpjpe(trues, preds, align=align)
    assert mpjpe(trues, preds) > 0  # needs no rotation


def test_planar_joints_are_aligned():
    """A rotation is determined by two directions; with a reflection allowed, too."""
    true = np.random.default_rng(0).normal(size=(4, 6, 3)) * [1.0, 1.0, 0.0]
    for reflection in (False, True):
        assert mpjpe(true, similar(true), align="similarity", reflection=reflection) < 1e-9


def test_no_scale_takes_the_origin_anywhere(data):
    pred = data.pred[:4].copy()
    pred[2] = 0.0
    with pytest.raises(ValueError, match="frame 2 of y_pred are all at the origin"):
        mpjpe(data.true[:4], pred, align="scale")


# --- means, weights, units -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", POSITIONS)
@pytest.mark.parametrize("average", ["points", "frames", "joints"])
def test_averages_are_equal_where_nothing_is_missing(name, average, data):
    score = POSITIONS[name]
    assert score(data.true, data.pred, average=average) == pytest.approx(score(data.true, data.pred), abs=1e-9)


def test_averages_differ_where_joints_are_missing():
    true = np.array([[[0.0, 0, 0], [1, 0, 0]], [[0, 0, 0], [np.nan, 0, 0]]])
    pred = np.nan_to_num(true, nan=1.0) + np.array([[[0.001, 0, 0], [0.003, 0, 0]], [[0.008, 0, 0], [9, 9, 9]]])
    assert mpjpe(true, pred) == pytest.approx((1 + 3 + 8) / 3)
    assert mpjpe(true, pred, average="frames") == pytest.approx((2 + 8) / 2)
    assert mpjpe(true, pred, average="joints") == pytest.approx((4.5 + 3) / 2)


@pytest.mark.parametrize("average", ["points", "frames", "joints"])
@pytest.mark.parametrize("name", ["mpjpe", "pck", "pck_auc"])
def test_a_weight_of_two_is_a_frame_twice(name, average, data):
    score, weights = POSITIONS[name], np.random.default_rng(0).integers(0, 4, size=len(data.true))
    twice = np.repeat(np.arange(len(weights)), weights)
    found = score(data.unseen(), data.pred, average=average, sample_weight=weights)
    assert found == pytest.approx(score(data.unseen()[twice], data.pred[twice], average=average), abs=1e-9)
    assert found.n_counted == data.seen[weights > 0].sum()


def test_units(data):
    in_mm = mpjpe(data.true, data.pred)
    assert mpjpe(data.true, data.pred, unit="m") == pytest.approx(in_mm / 1e3)
    assert mpjpe(data.true, data.pred, unit="cm") == pytest.approx(in_mm / 10)
    assert mpjpe(1e3 * data.true, 1e3 * data.pred, data_unit="mm") == pytest.approx(in_mm)
    assert pck(data.true, data.pred, threshold=0.1, threshold_unit="m") == pck(data.true, data.pred, threshold=100)
    assert pck(data.true, data.pred, unit="share") == pytest.approx(pck(data.true, data.pred) / 100)
    rate = acceleration_error(data.true, data.pred, frame_rate=50, unit="m")
    assert rate == pytest.approx(2.5 * acceleration_error(data.true, data.pred))
    assert (in_mm.unit, rate.unit) == ("mm", "m/s²")


@pytest.mark.parametrize(("factor", "likely"), [(1e3, "mm"), (1e2, "cm")])
def test_another_unit_is_noticed(factor, likely, data):
    with pytest.warns(UserWarning, match=f'data_unit="{likely}"'):
        mpjpe(factor * data.true, factor * data.pred)


def test_shapes_of_one_thing(data):
    """Rows of regressors, frames, motions and lists of them are the same frames."""
    true, pred, expected = data.unseen()[:24], data.pred[:24], mpjpe(data.unseen()[:24], data.pred[:24])
    assert mpjpe(true.reshape(24, -1), pred.reshape(24, -1)) == expected
    assert mpjpe(true.reshape(4, 6, -1, 3), pred.reshape(4, 6, -1, 3)) == expected
    assert mpjpe([true[:5], true[5:]], [pred[:5], pred[5:]]) == expected
    assert mpjpe(np.ma.masked_invalid(true), pred) == expected
    assert mpjpe(true.tolist(), pred.tolist()) == expected
    weighted = mpjpe([true[:5], true[5:]], [pred[:5], pred[5:]], sample_weight=[1, 0])
    assert weighted == pytest.approx(mpjpe(true[:5], pred[:5]))


def test_joints_that_count(data):
    gaps = conventions.distances(data.true, data.pred)
    assert mpjpe(data.true, data.pred, joints=[1, 5]) == pytest.approx(1e3 * gaps[:, [1, 5]].mean())
    assert mpjpe(data.true, data.pred, root=0, joints=0) == 0.0


@pytest.mark.parametrize("name", ["chain", "humanoid", "mixed joints"])
def test_poses_are_scored_by_their_positions(name):
    skeleton, rng = SKELETONS[name], np.random.default_rng(0)
    poses = rng.uniform(-1, 1, size=(2, 9, skeleton.n_dofs))
    true, pred = (reference.forward_kinematics(one, skeleton) for one in poses)
    expected = 1e3 * np.linalg.norm(true - pred, axis=2).mean()
    assert mpjpe(*poses, skeleton=skeleton) == pytest.approx(expected, abs=1e-9)
    joint = skeleton.joint_names[-1]
    by_name = mpjpe(*poses, skeleton=skeleton, joints=joint)
    assert by_name == pytest.approx(mpjpe(true, pred, joints=skeleton.n_joints - 1), abs=1e-9)
    poses[0, 4, 0] = np.nan  # of which joints after it are not known
    missing = mpjpe(*poses, skeleton=skeleton)
    assert missing.n_missing == skeleton.n_joints
    assert missing == pytest.approx(mpjpe(*np.delete(poses, 4, axis=1), skeleton=skeleton), abs=1e-9)


# --- the number ------------------------------------------------------------------------------------------------------


def test_a_score_is_a_number_that_says_what_it_is(data):
    score = mpjpe(data.unseen(), data.pred, align="similarity")
    assert isinstance(score, float)
    assert score.signature == "PA-MPJPE|mm|scale"
    assert (score.n_counted, score.n_missing) == (data.seen.sum(), (~data.seen).sum())
    for other in (pickle.loads(pickle.dumps(score)), copy.deepcopy(score)):
        assert (other, vars_of(other)) == (score, vars_of(score))
    assert str(score) == str(float(score))
    assert f"{score:.1f}" == f"{float(score):.1f}"
    assert repr(Score(1.5, "MPJPE|mm", 7, 3)) == "Score(1.5, 'MPJPE|mm', 7 counted, 3 missing)"
    assert Score(1.5, "NPSS|spectrum=power", 7, 3).unit == ""


@pytest.mark.parametrize(
    ("score", "options"),
    [
        (mpjpe, {"root": np.int64(0)}),
        (mpjpe, {"joints": np.int64(3)}),
        (mpjpe, {"root": [np.int64(0), np.uint8(2)], "joints": np.array([1, 2])}),
        (dtw_mje, {"pool": np.True_, "joints": np.int32(3)}),
        (pck_auc, {"n_thresholds": np.int64(31)}),
        (pck, {"threshold": np.float32(0.5), "threshold_unit": "m"}),
        (acceleration_error, {"frame_rate": np.int64(30)}),
        (acceleration_error, {"frame_rate": np.float32(29.97)}),
    ],
)
def test_numbers_of_numpy_are_those_of_python(score, options, data):
    plain = {key: np.asarray(value).tolist() for key, value in options.items()}
    found, expected = (score(data.true, data.pred, **given) for given in (options, plain))
    assert vars_of(found) == vars_of(expected)
    assert found == pytest.approx(expected, abs=1e-9)
    assert pose_score(found.signature, data.true, data.pred) == found


def vars_of(score):
    return score.signature, score.unit, score.n_counted, score.n_missing


# --- what is refused -------------------------------------------------------------------------------------------------


A = np.random.default_rng(0).normal(scale=0.3, size=(6, 5, 3))
BAD = A.copy()
BAD[2, 1, 0] = np.nan
INFINITE = A.copy()
INFINITE[2, 1, 0] = np.inf


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: mpjpe(A, A[:5]), r"equal shapes, .* got \(6, 5, 3\) and \(5, 5, 3\)"),
        (lambda: mpjpe(A, A[:, :4]), "equal shapes"),
        (lambda: mpjpe(A[0], A[0]), r"y_true\[None\] for one frame of 5 joints"),
        (lambda: mpjpe(A[:, :, :2], A[:, :, :2]), "two dimensions are not scored"),
        (
            lambda: mpjpe(A.reshape(6, 15)[:, :14], A.reshape(6, 15)[:, :14]),
            "14 columns, .* multiple of three.*skeleton=",
        ),
        (lambda: mpjpe(A[:0], A[:0]), "no frames"),
        (lambda: mpjpe(A, BAD), r"y_pred has 1 numbers that are NaN, the first at \[2, 1, 0\]"),
        (lambda: mpjpe(INFINITE, A), r"y_true is infinite at \[2, 1, 0\]"),
        (lambda: mpjpe(A, INFINITE), r"y_pred is infinite at \[2, 1, 0\]"),
        (lambda: mpjpe(np.full_like(A, np.nan), A), "no joint of y_true is seen"),
        (lambda: mpjpe(A, A, unit="inch"), "unit must be 'm' or 'cm' or 'mm', got 'inch'"),
        (lambda: mpjpe(A, A, data_unit="px"), "data_unit must be"),
        (lambda: mpjpe(A, A, align="procrustes"), "align must be None, 'scale', 'rigid' or 'similarity'"),
        (lambda: mpjpe(A, A, reflection=True), "reflection=True needs align="),
        (lambda: mpjpe(A, A, average="all"), "average must be"),
        (lambda: mpjpe(A, A, root=5), "root must be indices from 0 to 4"),
        (lambda: mpjpe(A, A, root="hips"), "root='hips' needs skeleton="),
        (lambda: mpjpe(A, A, joints=[1, 1]), "different ones"),
        (lambda: mpjpe(A, A, sample_weight=[1, 2]), r"sample_weight must have shape \(6,\)"),
        (lambda: mpjpe(A, A, sample_weight=-np.ones(6)), "not negative"),
        (lambda: mpjpe(A, A, sample_weight=np.zeros(6)), "somewhere positive"),
        (lambda: mpjpe([A, A[:, :3]], [A, A[:, :3]]), "the same joints"),
        (lambda: mpjpe(A, A, skeleton=SKELETONS["chain"]), "poses of shape|columns"),
        (lambda: mpjpe(A, A, skeleton=SKELETONS["chain"], data_unit="mm"), "data_unit must be 'm' with a skeleton"),
        (lambda: pck(A, A, threshold=0), "threshold must be a positive number"),
        (lambda: pck(A, A, unit="mm"), "unit must be '%' or 'share'"),
        (lambda: pck_auc(A, A, n_thresholds=1), "n_thresholds must be a whole number of at least 2"),
        (lambda: pck_auc(A, A, rule="simpson"), "rule must be"),
        (lambda: acceleration_error(A[:2], A[:2]), "needs three frames, and the motion has 2"),
        (lambda: acceleration_error([A, A[:1]], [A, A[:1]]), "motion 1 has 1"),
        (lambda: acceleration_error(A, A, frame_rate=0), "frame_rate must be a positive number"),
    ],
)
def test_scores_of_positions_refuse(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_an_object_with_positions_is_refused_with_the_remedy():
    class Recording:
        positions = A

    with pytest.raises(TypeError, match=r"pass y_true\.positions"):
        mpjpe(Recording(), A)


@pytest.mark.parametrize("score", [*POSITIONS.values(), dtw_mje, geodesic_error])
def test_a_motion_is_refused_with_the_remedy(score):
    skeleton = SKELETONS["humanoid"]
    walk = Motion(skeleton, np.zeros((4, skeleton.n_dofs)), frame_rate=30)
    with pytest.raises(TypeError, match=r"pass y_true\.angles, with skeleton=y_true\.skeleton"):
        score(walk, walk)
    with pytest.raises(
        TypeError, match=r"\[motion\.angles for motion in y_true\], with skeleton=y_true\[0\]\.skeleton"
    ):
        score([walk, walk], [walk, walk])
    with pytest.raises(TypeError, match=r"pass y_true\.angles$"):
        score(walk, walk, skeleton=skeleton)
    assert score(walk.angles, walk.angles, skeleton=walk.skeleton) >= 0.0


@pytest.mark.parametrize("score", [*POSITIONS.values(), dtw_mje])
@pytest.mark.parametrize("name", ["hip_rx", "hip_ry", "hip_rz", "hip_rotvec_y"])
def test_data_frames_of_angles_are_refused(score, name):
    pandas = pytest.importorskip("pandas")
    names = ["hip_x", "hip_y", "hip_z"]
    frame = pandas.DataFrame(A[:, 0], columns=names).join(pandas.DataFrame(A[:, 1], columns=[name, "b", "c"]))
    with pytest.raises(ValueError, match=f"1 of its 6 columns are named after joint angles, the first '{name}'"):
        score(frame, frame)
    with pytest.raises(ValueError, match=r"y_true\[1\] must be positions"):
        score([A[:, :2], frame], [A[:, :2], frame])
    other = frame.set_axis(["a_x", "a_y", "a_z", "hip_x", "hip_y", "hip_z"], axis=1)
    assert score(other, other) >= 0.0


def test_degrees_are_noticed():
    skeleton = SKELETONS["humanoid"]
    poses = np.full((3, skeleton.n_dofs), 90.0)
    with pytest.warns(UserWarning, match="np.radians"):
        mpjpe(poses, poses, skeleton=skeleton)
    with pytest.warns(UserWarning, match="np.radians"):
        geodesic_error(poses, poses, skeleton=skeleton)


def test_all_scores_are_perfect_for_the_truth(data):
    true = data.true[:20]
    assert mpjpe(true, true) == acceleration_error(true, true) == dtw_mje(true, true) == 0.0
    assert pck(true, true) == 100.0
    assert pck_auc(true, true, inclusive=True) == 100.0
    assert npss(data.motions[0], data.motions[0]) == mean_angle_error(data.angles[0], data.angles[0]) == 0.0
    assert geodesic_error(data.rotations[0], data.rotations[0]) == 0.0
