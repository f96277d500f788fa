"""Scores without a truth: against closed forms and a direct implementation of the published rule."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from skpose import Keypoints, Motion
from skpose.datasets import humanoid, make_actions
from skpose.scores import foot_floating, foot_penetration, foot_skating, jerk

FEET = ["left_ankle", "left_foot"], ["right_ankle", "right_foot"]


def steps(n=61, rate=20.0):
    """Ankles and feet of a person who steps from foot to foot, and a head; now and then a foot slides."""
    rng = np.random.default_rng(0)
    positions = np.zeros((n, 5, 3))
    positions[:, :2, 1], positions[:, 4, 1] = 0.1, 1.7
    for side in range(2):
        lift = 0.3 * np.maximum(0.0, np.sin(np.arange(n) / 4.0 + side * np.pi))
        along = np.cumsum(rng.uniform(0.0, 0.05, n))
        for point in (side, 2 + side):
            positions[:, point, 1] += lift
            positions[:, point, 2] = along
            positions[:, point, 0] = side
    return Keypoints(positions, ["left_ankle", "right_ankle", "left_foot", "right_foot", "head"], rate)


def skating_ratio(positions):
    """The rule of Guided Motion Diffusion as its program states it, for feet (n, 2, 3) at 20 Hz, y up."""
    feet = positions - [0.0, positions[..., 1].min(), 0.0]
    count = 0
    speeds = [np.hypot(*(b - a)[:, [0, 2]].T) * 20.0 for a, b in pairwise(feet)]
    for f, speed in enumerate(speeds):
        window = [speeds[g] if 0 <= g < len(speeds) else np.zeros(2) for g in range(f - 2, f + 3)]
        touches = (feet[f, :, 1] < 0.05) & (feet[f + 1, :, 1] < 0.05)
        count += (touches & (speed > 0.5) & (np.mean(window, axis=0) > 0.5)).any()
    return count / len(speeds)


def test_the_published_rule_against_a_direct_implementation():
    person = steps()
    ratio = foot_skating(person, rule="gmd", feet=FEET)
    assert 0.0 < ratio < 1.0
    assert ratio == pytest.approx(skating_ratio(person.positions[:, 2:4]), abs=1e-12)
    assert (foot_skating(person, rule="gmd", feet=FEET, average=None) <= ratio).all()


@pytest.mark.parametrize("rate", [20, 30, 120])
def test_the_speed_of_sliding_feet_does_not_depend_on_the_rate(rate):
    n = 2 * rate + 1
    slide = Motion(humanoid(), np.zeros((n, 42)), rate, np.linspace([0, 0, 0], [0.6, 0, 0], n))
    assert foot_skating(slide) == pytest.approx(0.3, rel=1e-9)
    np.testing.assert_allclose(foot_skating(slide, average=None), 0.3)
    assert foot_skating(slide, rule="gmd") == 0.0
    fast = replace(slide, root_positions=2.0 * slide.root_positions)
    assert foot_skating(fast, rule="gmd") > 0.8  # all but the ends of the window


@pytest.mark.parametrize("score", [foot_skating, foot_floating, foot_penetration])
def test_a_motion_without_the_movement_of_its_root_has_no_score_of_feet(score):
    kick = make_actions(1, 1, actions=["kick"], random_state=0)[0]
    with pytest.raises(ValueError, match="root"):
        score(replace(kick, root_positions=np.tile(kick.root_positions[:1], (len(kick), 1))))


def test_keypoints_are_scored_as_motions():
    kick = make_actions(1, 1, actions=["kick"], random_state=0)[0]
    points, feet = kick.to_keypoints(), [["left_foot", "left_toes"], ["right_foot", "right_toes"]]
    for score in (foot_skating, foot_floating, foot_penetration):
        assert score(points, feet=feet) == pytest.approx(score(kick, feet=feet), rel=1e-9)
    assert jerk(points) == pytest.approx(jerk(kick), rel=1e-9)


def test_heights_above_and_below_a_floor():
    n, up = 240, np.zeros((240, 3))
    up[:60, 1], up[60:120, 1] = 0.1, -0.2
    person = Motion(humanoid(), np.zeros((n, 42)), 30, up)
    assert foot_floating(person) == pytest.approx(25.0)
    assert foot_penetration(person) == pytest.approx(50.0)
    np.testing.assert_allclose(foot_penetration(person, average=None), 50.0)
    assert foot_floating(person, tolerance=0.1001) == 0.0
    level = foot_penetration(person, floor=0.0) - foot_floating(person, floor=0.0)
    assert level == pytest.approx(1e3 * -(person.positions()[..., 1].min(axis=1)).mean(), rel=0.2)


def test_frames_without_feet_do_not_count():
    down = np.repeat([0.0, -0.1], [30, 30])[:, None] * [0.0, 1.0, 0.0]
    points = Motion(humanoid(), np.zeros((60, 42)), 30, down).to_keypoints()
    feet = (["left_foot"], ["right_foot"])
    whole = foot_penetration(points, feet=feet, floor=0.0, tolerance=0.0)
    lost = points.positions.copy()
    lost[::2] = np.nan
    again = replace(points, positions=lost)
    assert foot_penetration(again, feet=feet, floor=0.0, tolerance=0.0) == pytest.approx(whole)
    with pytest.raises(ValueError, match="all frames"):
        foot_skating(again, feet=feet, rule="gmd")


def test_jerk_is_per_second():
    for rate in (30, 60):
        along = (np.arange(rate + 1)[:, None] / rate) ** 3 * [2.0, 0.0, 0.0]
        motion = Motion(humanoid(), np.zeros((rate + 1, 42)), rate, along)
        assert jerk(motion) == pytest.approx(12.0)
        assert jerk(motion, kind="area", reference=2.0) == pytest.approx(10.0)


def test_feet_that_are_not_there():
    points = Keypoints(np.zeros((9, 2, 3)), ["head", "left_hand"], 30)
    with pytest.raises(ValueError, match="feet="):
        foot_skating(points)
    with pytest.raises(ValueError, match="left"):
        foot_skating(points, feet=(["head"], ["nose"]))
    with pytest.raises(ValueError, match="four"):
        jerk(points[:3])
