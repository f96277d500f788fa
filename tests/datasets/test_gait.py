"""Generated gait: published curves, differences between people."""

import numpy as np
import pytest

from skpose import forward_kinematics
from skpose.datasets import humanoid, make_gait
from skpose.datasets._gait import CURVES, evaluate, series_of

DOFS = humanoid().dof_names


def test_gait_has_the_requested_motions_and_depends_on_the_seed():
    one, same, other = (make_gait(1, 1, random_state=seed)[0] for seed in (0, 0, 1))
    np.testing.assert_array_equal(one.angles, same.angles)
    assert one.skeleton == same.skeleton != other.skeleton
    gait = make_gait(3, 2, activities=["run"], duration=1.5, frame_rate=20, random_state=0)
    assert len(gait) == 6
    assert set(gait.actions) == {"run"}
    assert list(gait.subjects) == ["01", "01", "02", "02", "03", "03"]
    assert all(len(motion) == 30 and motion.frame_rate == 20 for motion in gait)
    with pytest.raises(ValueError, match="activities"):
        make_gait(activities=["walk", "swim"])
    with pytest.raises(ValueError, match="n_subjects"):
        make_gait(0)


# Degrees and hundredths of the gait cycle within which curves of healthy adults peak.
PUBLISHED_PEAKS = {
    ("walk", "hip_flexion", "max"): ((18, 38), (80, 112)),
    ("walk", "knee_flexion", "max"): ((45, 78), (60, 85)),
    ("walk", "ankle_dorsiflexion", "min"): ((-30, -8), (50, 72)),
    ("run", "knee_flexion", "max"): ((80, 110), (55, 80)),
    ("run", "ankle_dorsiflexion", "min"): ((-30, -12), (30, 55)),
}


@pytest.mark.parametrize(("activity", "curve", "peak"), PUBLISHED_PEAKS)
def test_gait_curves_peak_at_the_published_times(activity, curve, peak):
    (low, high), (early, late) = PUBLISHED_PEAKS[activity, curve, peak]
    cycle = np.linspace(0, 1, 500, endpoint=False)
    values = evaluate(series_of(CURVES[activity][curve]), cycle)
    at = values.argmax() if peak == "max" else values.argmin()
    assert low < values[at] < high
    assert early <= 100 * cycle[at] <= late or early <= 100 * cycle[at] + 100 <= late


def test_gait_moves_like_gait():
    """Feet alternate, arms swing against the legs, and running flexes knees and elbows more than walking."""
    gait = make_gait(2, 1, frame_rate=30, random_state=0)
    flexion = {}
    for motion, action in zip(gait, gait.actions, strict=True):
        P = dict(
            zip(
                motion.skeleton.joint_names,
                forward_kinematics(motion.angles, motion.skeleton).swapaxes(0, 1),
                strict=True,
            )
        )
        z = {name: P[name][:, 2] for name in P}
        assert np.corrcoef(z["left_foot"], z["right_foot"])[0, 1] < -0.5
        assert np.corrcoef(z["left_hand"], z["left_foot"])[0, 1] < -0.3
        assert P["head"][:, 1].min() > 0.3
        assert P["left_foot"][:, 1].max() < 0
        angles = dict(zip(motion.skeleton.dof_names, np.degrees(motion.angles).T, strict=True))
        flexion.setdefault(action, []).append((angles["left_shank_rx"].max(), -angles["left_forearm_rx"].mean()))
    knee, elbow = (np.mean(flexion["run"], axis=0) - np.mean(flexion["walk"], axis=0)).tolist()
    assert knee > 15
    assert elbow > 40


def test_humanoid_has_the_requested_height():
    for height in (1.5, 2.0):
        skeleton = humanoid(height)
        P = forward_kinematics(np.zeros((1, skeleton.n_dofs)), skeleton)[0]
        P = dict(zip(skeleton.joint_names, P, strict=True))
        np.testing.assert_allclose(P["head"][1] - P["left_foot"][1], height, rtol=0.01)
        np.testing.assert_allclose(P["left_hand"] * [-1, 1, 1], P["right_hand"], atol=1e-12)
    longer = humanoid(proportions={"thigh": 2.0})
    ratio = np.linalg.norm(longer.offsets, axis=1) / np.linalg.norm(humanoid().offsets, axis=1)
    assert {name for name, r in zip(longer.joint_names, ratio, strict=True) if r > 1.5} == {"left_thigh", "right_thigh"}
    with pytest.raises(ValueError, match="proportions"):
        humanoid(proportions={"tail": 2.0})
    with pytest.raises(ValueError, match="height"):
        humanoid(0)
    with pytest.raises(ValueError, match="proportions"):
        humanoid(proportions={"thigh": -1.0})


def test_people_and_recordings_differ():
    """By posture, more than the recordings of one person do."""
    gait = make_gait(30, 3, activities=["walk"], frame_rate=20, rotations="file", random_state=0)
    means = np.degrees([motion.angles.mean(axis=0) for motion in gait]).reshape(30, 3, -1)
    within = np.sqrt(means.var(axis=1, ddof=1).mean(axis=0))
    between = means.mean(axis=1).std(axis=0)
    assert 1.0 < np.median(within) < 3.0
    assert 4.0 < np.median(between) < 8.0
