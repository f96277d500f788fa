"""Sets of motions under metrics of motions, and motions one by one against a set: by definition, and what they find."""

from dataclasses import replace

import numpy as np
import pytest
import reference
from conftest import in_turns
from sklearn.metrics import roc_auc_score

from skpose import inverse_kinematics
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import Centered, Jerk, Velocity, _matrix
from skpose.statistics import outlier_test, two_sample_test

OF_MOTIONS = [Velocity(), Velocity(0.01), Jerk(), Centered()]
STATISTICS = ["energy", "mmd"]


@pytest.fixture(scope="module")
def gait():
    """Walks and runs of three people, of different lengths."""
    gait = make_gait(n_subjects=3, n_sequences=2, duration=1.0, frame_rate=30, random_state=0)
    shorter = [motion[: 20 + i % 7] for i, motion in enumerate(gait)]
    return MotionDataset(shorter, gait.subjects, gait.trials, gait.actions)


def jittered(motion, sigma, seed=0):
    """Add noise to the positions of the joints, m, and make poses of them."""
    positions = reference.F(motion.angles, motion.skeleton).reshape(len(motion), -1, 3)
    positions += np.random.default_rng(seed).normal(0, sigma, positions.shape)
    fitted = inverse_kinematics(positions, motion.skeleton, initial=motion.angles, regularization=0.02)
    return replace(motion, angles=fitted.poses)


def rows_of(motion, metric, skeleton):
    """What is compared, frame by frame: positions are those of a reference, and differences are written down."""
    positions = reference.F(motion.angles, skeleton)
    n, rate = len(positions), motion.frame_rate
    if isinstance(metric, Centered):
        return positions - positions.mean(axis=0)
    if isinstance(metric, Jerk):
        four = [positions[min(max(i - 1, 0), n - 4) :][:4] for i in range(n)]
        return np.array([d - 3 * c + 3 * b - a for a, b, c, d in four]) * rate**3
    reach = max(1, round(metric.span * rate / 2))
    ends = [(max(0, i - reach), min(n - 1, i + reach)) for i in range(n)]
    return np.array([(positions[b] - positions[a]) * rate / (b - a) for a, b in ends])


def euclidean(a, b):
    return float(np.linalg.norm(a - b))


@pytest.mark.slow
@pytest.mark.parametrize("metric", OF_MOTIONS, ids=str)
@pytest.mark.parametrize("statistic", STATISTICS)
def test_sets_under_metrics_of_motions_are_sets_of_their_rows(metric, statistic, gait):
    X, Y = gait.motions[:3], gait.motions[4:6]
    found = two_sample_test(X, Y, skeleton=gait.skeleton, metric=metric, statistic=statistic)
    a, b = ([rows_of(motion, metric, gait.skeleton) for motion in one] for one in (X, Y))
    if statistic == "energy":
        expected = reference.two_sample_statistic(a, b, euclidean)
    else:
        expected = -reference.two_sample_statistic(
            a, b, lambda p, q: np.exp(-0.5 * (euclidean(p, q) / found.width) ** 2)
        )
    assert found.statistic == pytest.approx(expected, rel=1e-9)
    assert found.least_pvalue == 1 / 10
    if metric.label == metric.name:
        named = two_sample_test(X, Y, skeleton=gait.skeleton, metric=metric.name, statistic=statistic)
        assert named.statistic == found.statistic


@pytest.mark.parametrize(("metric", "tile"), in_turns(["position", *OF_MOTIONS], [None, 13]))
def test_each_motion_is_tested_as_a_set_of_one(metric, tile, gait, monkeypatch):
    """By permutations of it and the others, one test at a time."""
    if tile:
        monkeypatch.setattr(_matrix, "ENCODED_AT_ONCE", tile)
    X, Y = [*gait.motions[:3], jittered(gait[0], 0.01)], gait.motions[3:]
    found = outlier_test(X, Y, skeleton=gait.skeleton, metric=metric)
    monkeypatch.undo()
    assert (found.n_x, found.n_y, found.least_pvalue) == (4, len(Y), 1 / (len(Y) + 1))
    for i, motion in enumerate(X):
        alone = two_sample_test([motion], Y, skeleton=gait.skeleton, metric=metric)
        assert alone.exact
        assert found.statistic[i] == pytest.approx(alone.statistic, rel=1e-10)
        assert found.pvalue[i] == alone.pvalue


@pytest.mark.slow
def test_pvalues_of_exchangeable_motions_are_no_smaller_than_their_share():
    """Every level is kept, over draws of a set and one more; one from elsewhere is found."""
    rng, least = np.random.default_rng(0), 1 / 10
    drawn = rng.normal(size=(400, 10, 3))
    own = np.array([outlier_test(one[:1], one[1:], metric="angle").pvalue[0] for one in drawn])
    for level in (least, 0.2, 0.5):
        assert abs((own <= level + 1e-9).mean() - level) < 4 * np.sqrt(level * (1 - level) / len(own))
    other = np.array([outlier_test(one[:1] + 6, one[1:], metric="angle").pvalue[0] for one in drawn[:50]])
    assert (other == least).mean() > 0.9


@pytest.mark.parametrize("metric", ["position", *OF_MOTIONS], ids=str)
def test_where_people_go_and_face_has_no_part(metric, gait):
    rng = np.random.default_rng(0)
    moved = [
        replace(motion, root_positions=rng.normal(size=(len(motion), 3)), root_angles=rng.normal(size=(len(motion), 3)))
        for motion in gait[:3]
    ]
    expected = outlier_test(gait[:3], gait[3:], skeleton=gait.skeleton, metric=metric).statistic
    found = outlier_test(moved, gait[3:], skeleton=gait.skeleton, metric=metric).statistic
    np.testing.assert_array_equal(found, expected)


def test_velocities_tell_a_motion_from_itself_backwards_and_poses_do_not(gait):
    backwards = [replace(motion, angles=motion.angles[::-1]) for motion in gait[:6]]
    of_poses, of_velocities = (
        two_sample_test(gait[:6], backwards, metric=metric) for metric in ("position", Velocity())
    )
    assert abs(of_poses.statistic) < 1e-12
    assert of_velocities.statistic > 0.1


def test_jitter_of_two_millimetres_is_found_in_people_left_out(gait):
    """One motion at a time; poses and velocities do not find it."""
    new, seen = gait[gait.subjects == "03"], gait[gait.subjects != "03"]
    jittery = [jittered(motion, 0.002, i) for i, motion in enumerate(new)]
    truth = np.repeat([0, 1], len(new))
    auc = {
        metric: roc_auc_score(
            truth, outlier_test([*new, *jittery], seen, skeleton=seen.skeleton, metric=metric).statistic
        )
        for metric in ("position", "velocity", "jerk")
    }
    assert auc["jerk"] == 1.0
    assert max(auc["position"], auc["velocity"]) < 0.8


# --- errors ----------------------------------------------------------------------------------------------------------


# --- real data -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_jitter_in_squats_of_a_person_of_hdm05_who_is_not_in_the_set(hdm05):
    squats = MotionDataset(hdm05[hdm05.actions == "squat"].motions, hdm05[hdm05.actions == "squat"].subjects)
    squats = squats.retarget(squats.skeleton)
    real = [motion.resample(30) for motion in squats]
    new, seen = ([m for m, s in zip(real, squats.subjects, strict=True) if (s == "bd") is own] for own in (True, False))
    jittery = [jittered(motion, 0.002, i) for i, motion in enumerate(new[:6])]
    found = [outlier_test(some, seen, skeleton=squats.skeleton, metric="jerk").statistic for some in (new, jittery)]
    assert found[0].max() < found[1].min()
