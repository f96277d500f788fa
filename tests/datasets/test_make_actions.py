"""Generated actions: key poses, people who differ as real ones do, feet that stand."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from skpose import forward_kinematics
from skpose.datasets import humanoid, make_actions
from skpose.datasets._action_spreads import EXECUTION, TEMPO, TIMING
from skpose.datasets._actions import _spread_over_keys, draw_departures
from skpose.datasets._key_poses import ACTIONS
from skpose.datasets._legs import Leg, LegAngles, place_foot, solve_leg
from skpose.datasets._performance import perform

ROOT = Path(__file__).parents[2]
DOFS = humanoid().dof_names
BOTH_FEET = ["lift", "reach", "sit down", "squat", "wave"]  # on which people stand all the time


@pytest.fixture(scope="module")
def dataset():
    return make_actions(random_state=0)


def in_world(motion):
    """Return joint positions (n_frames, 3) by name, and those of the root."""
    F = forward_kinematics(motion.angles, motion.skeleton)
    rotation = Rotation.from_euler(motion.root_axes, motion.root_angles)
    joints = {name: rotation.apply(F[:, k]) for k, name in enumerate(motion.skeleton.joint_names)}
    return {name: P + motion.root_positions for name, P in joints.items()} | {"root": motion.root_positions}


def of_action(dataset, *actions):
    return [motion for motion, action in zip(dataset, dataset.actions, strict=True) if action in actions]


def test_actions_are_determined_by_their_seed():
    one, same, other = (make_actions(2, 1, actions=["kick"], random_state=seed) for seed in (0, 0, 1))
    for a, b, c in zip(one, same, other, strict=True):
        np.testing.assert_array_equal(a.angles, b.angles)
        np.testing.assert_array_equal(a.root_positions, b.root_positions)
        assert a.skeleton == b.skeleton != c.skeleton


def test_actions_have_the_requested_motions(dataset):
    assert len(dataset) == 3 * 6 * len(ACTIONS)
    assert {action: int((dataset.actions == action).sum()) for action in ACTIONS} == dict.fromkeys(ACTIONS, 18)
    assert sorted(set(dataset.subjects)) == ["01", "02", "03"]
    some = make_actions(2, 2, actions=["squat", "wave"], frame_rate=20, random_state=0)
    assert list(some.subjects) == ["01"] * 4 + ["02"] * 4
    assert list(some.actions[:4]) == ["squat", "squat", "wave", "wave"]
    assert list(some.trials[:4]) == ["01", "02", "03", "04"]
    assert all(motion.frame_rate == 20 for motion in some)
    with pytest.raises(ValueError, match=r"actions must be among \['jump', .*\], got 'swim'"):
        make_actions(actions=["squat", "swim"])
    with pytest.raises(ValueError, match="The 'n_sequences' parameter of make_actions must be"):
        make_actions(1, 0)


def test_feet_that_stand_stay(dataset):
    """To a millimetre: balls and toes, on the ground."""
    for motion in of_action(dataset, *BOTH_FEET):
        P = in_world(motion)
        for side in ("left", "right"):
            for joint in ("foot", "toes"):
                assert np.ptp(P[f"{side}_{joint}"], axis=0).max() < 2e-3
            assert np.abs(P[f"{side}_foot"][:, 1]).max() < 1e-3
    for motion in of_action(dataset, "kick"):
        assert np.ptp(in_world(motion)["left_foot"], axis=0).max() < 2e-3


def test_nobody_sinks_into_the_ground_or_moves_as_nobody_can(dataset):
    for motion in dataset:
        P = np.stack(list(in_world(motion).values()), axis=1)
        assert P[..., 1].min() > -0.15
        assert np.linalg.norm(np.diff(P, axis=0), axis=2).max() * motion.frame_rate < 25  # m/s


# Degrees: what joints of healthy adults reach, some more for hands and ankles, as the measured spreads contain markers.
HINGES = {
    "shank_rx": (0, 150),
    "forearm_rx": (-150, 0),
    "foot_rx": (-65, 75),
    "foot_rz": (-50, 50),
    "hand_rx": (-80, 80),
}


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_joints_stay_in_human_range(seed):
    for motion in make_actions(3, 2, random_state=seed):
        angles = dict(zip(DOFS, np.degrees(motion.angles).T, strict=True))
        for name, (low, high) in HINGES.items():
            for side in ("left", "right"):
                assert low - 1e-6 <= angles[f"{side}_{name}"].min(), (side, name)
                assert angles[f"{side}_{name}"].max() <= high + 1e-6, (side, name)
        for side in ("left", "right"):
            arm = Rotation.from_euler("xyz", motion.angles[:, [DOFS.index(f"{side}_upper_arm_r{x}") for x in "xyz"]])
            _, y, _, w = arm.as_quat().T
            about = np.degrees(np.angle(np.exp(2j * np.arctan2(y, w))))[np.hypot(y, w) > 0.5]
            assert np.abs(about).max() < 110


def test_actions_look_like_what_they_are(dataset):
    def world(action):
        return [in_world(motion) for motion in of_action(dataset, action)]

    def highest(P, joint):
        return P[joint][:, 1].max()

    for P in world("squat"):
        assert P["root"][:, 1].min() < 0.75 * P["root"][0, 1]
    for P in world("sit down"):
        assert 0.4 < P["root"][-1, 1] / P["root"][0, 1] < 0.7
        assert P["root"][-1, 2] < P["root"][0, 2] - 0.2  # behind the feet
    for P in world("jump"):
        assert np.minimum(P["left_toes"][:, 1], P["right_toes"][:, 1]).max() > 0.05
    for P in world("step up"):
        np.testing.assert_allclose(P["left_foot"][-1, 1], P["right_foot"][-1, 1], atol=0.02)
        assert P["left_foot"][-1, 1] > 0.15
    for P in world("reach"):
        assert highest(P, "right_hand") > highest(P, "head")
        assert highest(P, "left_hand") < highest(P, "head")
    for P in world("wave"):
        assert highest(P, "right_hand") > P["root"][:, 1].max() + 0.3
    for P in world("kick"):
        assert highest(P, "right_foot") > 0.3
        assert highest(P, "left_foot") < 1e-3
    for motion in of_action(dataset, "turn"):
        np.testing.assert_allclose(np.degrees(motion.root_angles[[0, -1], 0]), [0, 180], atol=2)
    for P in world("lift"):
        for side in ("left", "right"):
            assert P[f"{side}_hand"][:, 1].min() < P["root"][0, 1] - 0.2


def within_chance(values, spread):
    """Whether independent normal values have this standard deviation, but for one case in a million."""
    if spread == 0.0:
        return not np.any(values)
    n = np.size(values)
    low, high = chi2.ppf([5e-7, 1 - 5e-7], n) / n
    return low <= np.mean(np.square(values)) / spread**2 <= high


@pytest.mark.parametrize("part", ["person", "person_key", "recording", "recording_key"])
def test_departures_have_the_spreads_of_the_table(part):
    drawn = draw_departures(np.random.RandomState(0), DOFS, part, 4000)
    for name, column in zip(DOFS, drawn.T, strict=True):
        key = name.removeprefix("left_").removeprefix("right_")
        assert within_chance(column, getattr(EXECUTION[key], part)), name
    moving = drawn[:, drawn.any(axis=0)]
    assert np.abs(np.corrcoef(moving.T) - np.eye(moving.shape[1])).max() < 5 / np.sqrt(4000)


@pytest.mark.parametrize("action", ACTIONS)
def test_departures_at_key_poses_are_as_large_at_all_phases(action):
    """Their mean over the phases is zero, and their mean square that of what is drawn, along straight lines."""
    times = [key.time for key in ACTIONS[action].keys]
    drawn = np.random.default_rng(0).normal(size=(len(times), 2_000))
    phases = np.linspace(0.0, 1.0, 9)
    at_phases = np.array([np.interp(phases, times, column) for column in (_spread_over_keys(times) @ drawn).T])
    np.testing.assert_allclose(at_phases.mean(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.sqrt(np.mean(np.square(at_phases))), 1.0, rtol=0.05)


def test_durations_have_the_spreads_of_the_table():
    """A person has a tempo in each action, from which repetitions differ."""
    actions = make_actions(60, 4, actions=["wave"], frame_rate=120, random_state=0)
    logs = np.log([(len(motion) - 1) / motion.frame_rate / ACTIONS["wave"].duration for motion in actions])
    logs = logs.reshape(60, 4)
    within = np.sqrt(np.mean(np.var(logs, axis=1, ddof=1)))
    between = np.sqrt(max(0.0, np.var(logs.mean(axis=1), ddof=1) - within**2 / 4))
    np.testing.assert_allclose([between, within], TEMPO, rtol=0.35)


def test_arms_and_trunk_depart_by_the_spreads_of_the_table():
    """Over people and repetitions together, in the mean over phases: of dofs that nothing keeps in their place."""
    from skpose.datasets._spreads import POSTURE

    people = make_actions(150, 1, actions=["wave"], frame_rate=10, random_state=0)
    phases = [np.rint(np.linspace(0, len(motion) - 1, 9)).astype(int) for motion in people]
    found = np.degrees([motion.angles[rows] for motion, rows in zip(people, phases, strict=True)])
    for key in ("abdomen_rx", "head_ry", "left_hand_rz", "right_hand_rx"):
        name = key.removeprefix("left_").removeprefix("right_")
        spread = np.sqrt(POSTURE[name].people ** 2 + np.square(EXECUTION[name]).sum())
        column = found[..., DOFS.index(key)]
        np.testing.assert_allclose(np.sqrt(column.var(axis=0).mean()), spread, rtol=0.2, err_msg=key)


def test_late_movements_are_late():
    """In the middle, by that share of their duration; the poses are the same."""
    skeleton, action = humanoid(), ACTIONS["squat"]
    still = np.zeros((len(action.keys), len(DOFS)))
    usual, late = (perform(skeleton, action, still, 2.0, share, 120.0) for share in (0.0, 0.1))
    lowest = [motion.root_positions[:, 1].argmin() / 240 for motion in (usual, late)]
    np.testing.assert_allclose(lowest, [0.5, 0.6], atol=0.01)
    assert 0.0 < min(TIMING) < 0.1


def test_a_leg_is_solved_as_it_was_bent():
    rng = np.random.default_rng(0)
    leg, n = Leg.of(humanoid(), "left"), 500
    hip = Rotation.from_euler("xyz", rng.normal(size=(n, 3)) * [0.6, 0.2, 0.2] - [0.4, 0.0, 0.0])
    angles = LegAngles(hip, rng.uniform(0.15, 2.0, n), 0.2 * rng.normal(size=(n, 2)))
    ball, foot = place_foot(leg, angles)
    root, pelvis = rng.normal(size=(n, 3)), Rotation.from_rotvec(rng.normal(size=(n, 3)))
    found = solve_leg(leg, root, pelvis, root + pelvis.apply(ball), pelvis * foot)
    np.testing.assert_allclose(found.knee, angles.knee, atol=1e-12)
    np.testing.assert_allclose(found.ankle, angles.ankle, atol=1e-12)
    assert (found.hip.inv() * hip).magnitude().max() < 1e-12


def test_a_leg_is_that_of_forward_kinematics():
    skeleton = humanoid()
    pose = np.random.default_rng(1).normal(size=(1, len(DOFS))) * 0.3
    P = dict(zip(skeleton.joint_names, forward_kinematics(pose, skeleton)[0], strict=True))
    for side in ("left", "right"):
        hip, knee, ankle = (
            pose[:, [k for k, name in enumerate(DOFS) if name.startswith(f"{side}_{part}_r")]]
            for part in ("thigh", "shank", "foot")
        )
        ball, _ = place_foot(Leg.of(skeleton, side), LegAngles(Rotation.from_euler("xyz", hip), knee[:, 0], ankle))
        np.testing.assert_allclose(ball[0], P[f"{side}_foot"], atol=1e-12)


@pytest.fixture(scope="module")
def benchmark():
    """The program that measures the spreads."""
    path = ROOT / "benchmarks" / "action_spreads.py"
    if not path.is_file():
        pytest.skip("the benchmarks are not here")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(path.parent))
        spec = importlib.util.spec_from_file_location("action_spreads", path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    for name in ("common", "spreads"):
        sys.modules.pop(name, None)
    return module


@pytest.mark.slow
def test_the_tables_are_what_the_benchmark_measures(benchmark, hdm05):
    found = benchmark.spreads(benchmark.recordings(benchmark.on_feet(hdm05)))
    for key, spread in found.execution.items():
        np.testing.assert_allclose(spread, EXECUTION[key], atol=0.051, err_msg=key)
    np.testing.assert_allclose(found.tempo, TEMPO, atol=0.00051)
    np.testing.assert_allclose(found.timing, TIMING, atol=0.00051)
