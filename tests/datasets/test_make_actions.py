"""Generated actions: key poses, differences between people, feet that stand."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.datasets import humanoid, make_actions
from skpose.datasets._performance import ACTIONS, Leg, solve_leg

DOFS = humanoid().dof_names
BOTH_FEET = ["lift", "reach", "sit down", "squat", "wave"]  # on which people stand all the time


@pytest.fixture(scope="module")
def dataset():
    return make_actions(2, 1, random_state=0)


def in_world(motion):
    """Return joint positions (n_frames, 3) by name, and those of the root."""
    F = forward_kinematics(motion.angles, motion.skeleton)
    rotation = Rotation.from_euler(motion.root_axes, motion.root_angles)
    joints = {name: rotation.apply(F[:, k]) for k, name in enumerate(motion.skeleton.joint_names)}
    return {name: P + motion.root_positions for name, P in joints.items()} | {"root": motion.root_positions}


def of_action(dataset, *actions):
    return [motion for motion, action in zip(dataset, dataset.actions, strict=True) if action in actions]


def test_actions_have_the_requested_motions(dataset):
    assert dataset.actions.tolist() == [*ACTIONS, *ACTIONS]
    some = make_actions(2, 2, actions=["squat", "wave"], frame_rate=20, random_state=0)
    assert list(some.subjects) == ["01"] * 4 + ["02"] * 4
    assert list(some.actions[:4]) == ["squat", "squat", "wave", "wave"]
    assert list(some.trials[:4]) == ["01", "02", "03", "04"]
    assert all(motion.frame_rate == 20 for motion in some)
    with pytest.raises(ValueError, match="actions"):
        make_actions(actions=["squat", "swim"])
    with pytest.raises(ValueError, match="n_sequences"):
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


@pytest.mark.parametrize("seed", [0, 1])
def test_joints_stay_in_human_range(seed):
    for motion in make_actions(1, 2, rotations="file", random_state=seed):
        angles = dict(zip(DOFS, np.degrees(motion.angles).T, strict=True))
        for name, (low, high) in HINGES.items():
            for side in ("left", "right"):
                assert low - 1e-6 <= angles[f"{side}_{name}"].min(), (side, name)
                assert angles[f"{side}_{name}"].max() <= high + 1e-6, (side, name)
        for side in ("left", "right"):
            arm = Rotation.from_euler("xyz", motion.angles[:, [DOFS.index(f"{side}_upper_arm_r{x}") for x in "xyz"]])
            _, y, _, w = arm.as_quat().T
            about = np.degrees(np.angle(np.exp(2j * np.arctan2(y, w))))[np.hypot(y, w) > 0.5]
            assert np.abs(about).max() < 125


def test_actions_look_like_what_they_are(dataset):
    def world(action):
        return [in_world(motion) for motion in of_action(dataset, action)]

    def highest(P, joint):
        return P[joint][:, 1].max()

    for P in world("squat"):
        assert P["root"][:, 1].min() < 0.8 * P["root"][0, 1]
    for P in world("sit down"):
        assert 0.4 < P["root"][-1, 1] / P["root"][0, 1] < 0.7
        assert P["root"][-1, 2] < P["root"][0, 2] - 0.2  # behind the feet
    for P in world("jump"):
        assert np.minimum(P["left_toes"][:, 1], P["right_toes"][:, 1]).max() > 0.05
    for P in world("step up"):
        np.testing.assert_allclose(P["left_foot"][-1, 1], P["right_foot"][-1, 1], atol=0.02)
        assert P["left_foot"][-1, 1] > 0.15
    for P in world("reach") + world("wave"):
        assert highest(P, "right_hand") > highest(P, "left_hand") + 0.3
    for P in world("kick"):
        assert highest(P, "right_foot") > 0.3
    for motion in of_action(dataset, "turn"):
        np.testing.assert_allclose(np.degrees(motion.root_angles[[0, -1], 0]), [0, 180], atol=2)


def test_a_solved_leg_reaches_the_foot():
    skeleton, rng, n = humanoid(), np.random.default_rng(0), 100
    pose = 0.2 * rng.normal(size=(n, len(DOFS)))
    pose[:, DOFS.index("left_shank_rx")] = rng.uniform(0.2, 2.0, n)
    ball = forward_kinematics(pose, skeleton)[:, skeleton.joint_names.index("left_foot")]
    parts = [
        pose[:, [k for k, name in enumerate(DOFS) if name.startswith(f"left_{part}_r")]]
        for part in ("thigh", "shank", "foot")
    ]
    hip, foot = Rotation.from_euler("xyz", parts[0]), Rotation.from_euler("xz", parts[2])
    rotation = hip * Rotation.from_euler("x", parts[1]) * foot
    found = solve_leg(Leg.of(skeleton, "left"), np.zeros((n, 3)), Rotation.identity(n), ball, rotation)
    np.testing.assert_allclose(found["shank"], parts[1], atol=1e-9)
    np.testing.assert_allclose(found["foot"], parts[2], atol=1e-9)
    assert (found["thigh"].inv() * hip).magnitude().max() < 1e-7
