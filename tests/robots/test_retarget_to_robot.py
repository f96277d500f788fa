"""Retargeting from people to robots of hinges with limits."""

import re
from dataclasses import replace

import numpy as np
import pytest
import reference
from conftest import in_space
from robot_of_hinges import counterparts, robot, walk
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton
from skpose.datasets import humanoid, make_gait
from skpose.robots import retarget_to_robot

# Some motions here ask for more than a robot can do.
pytestmark = pytest.mark.filterwarnings("ignore:the pelvis is up to")

FASTEST = 20.0  # rad/s


def to_robot(motion, skeleton, **options):
    return retarget_to_robot(motion, skeleton, joints=counterparts(skeleton), **options)


def report_of(motion, skeleton, capsys):
    to_robot(motion, skeleton, verbose=1)
    return capsys.readouterr().out


def in_world(motion):
    """Positions (n_frames, n_joints, 3) of joints by the definition."""
    root = Rotation.from_euler(motion.root_axes, motion.root_angles)
    here = reference.forward_kinematics(motion.angles, motion.skeleton)
    return (
        np.stack([turn.apply(points) for turn, points in zip(root, here, strict=True)]) + motion.root_positions[:, None]
    )


def at(motion, *names):
    """Positions (n_frames, n_names, 3) of joints by name."""
    return in_world(motion)[:, [motion.skeleton.joint_names.index(name) for name in names]]


def noise(size=0.6, n=90, seed=0):
    rng = np.random.default_rng(seed)
    person = humanoid()
    root = rng.normal((0.0, 0.9, 0.0), 0.3, (n, 3))
    return Motion(person, rng.normal(scale=size, size=(n, person.n_dofs)), 30, root, rng.normal(size=(n, 3)))


MOTIONS = {"walk": walk()[0], "run": make_gait(1, 1, random_state=0)[1], "noise": noise()}


@pytest.mark.parametrize(
    ("name", "options"), [("walk", {"arms": False}), ("run", {"legs": False}), ("noise", {"tilt": 0.3, "seed": 1})]
)
def test_angles_stay_in_their_limits_and_do_not_jump(name, options):
    skeleton = robot(**options)
    result = to_robot(MOTIONS[name], skeleton)
    lower, upper = np.array(skeleton.limits).T
    assert ((result.angles >= lower) & (result.angles <= upper)).all()
    steps = np.abs(np.diff(result.angles, axis=0)) * result.frame_rate
    assert steps.max() <= FASTEST * (1.0 + 1e-9)
    unlimited = Skeleton([bone._replace(limits=None) for bone in skeleton.bones], "parent")
    free = to_robot(MOTIONS["noise"], unlimited).angles
    assert ((free < lower) | (free > upper)).any()


@pytest.mark.parametrize("options", [{"tilt": 0.3, "seed": 1}, {"size": 1.5}, {"thigh": 0.25, "shank": 0.36}])
def test_feet_that_stand_are_still_flat_and_on_the_floor(options):
    motion, stands = walk()
    result = to_robot(motion, robot(**options))
    for k, side in enumerate(("left", "right")):
        ankle, toe = at(result, f"{side}_ankle_2", f"{side}_toe").swapaxes(0, 1)
        still = stands[k][1:] & stands[k][:-1]
        assert np.linalg.norm(np.diff(toe, axis=0), axis=1)[still].max() < 2e-4
        flat = np.flatnonzero(stands[k])[5:-5]  # frames from the edges of a contact are within the time of blending
        flat = flat[stands[k][flat - 4] & stands[k][np.minimum(flat + 4, len(motion) - 1)]]
        assert np.abs(toe[flat, 1]).max() < 5e-4
        assert np.allclose(ankle[flat, 1] - toe[flat, 1], 0.05 * options.get("size", 1.0), atol=5e-4)


def test_feet_that_are_not_still_are_held():
    """The person's feet slide by a part of each step, as noise makes them; the robot's do not."""
    motion, stands = walk()
    shaking = 0.01 * np.sin(np.arange(len(motion)))
    motion = replace(motion, root_positions=motion.root_positions + np.outer(shaking, [1.0, 0.3, 0.5]))
    result = to_robot(motion, robot())
    moved = {}
    for one, names in ((motion, ("left_foot", "right_foot")), (result, ("left_toe", "right_toe"))):
        steps = np.linalg.norm(np.diff(at(one, *names), axis=0), axis=2).T
        inner = stands[:, 1:] & stands[:, :-1] & np.roll(stands, 6, axis=1)[:, 1:] & np.roll(stands, -6, axis=1)[:, 1:]
        moved[names[0]] = steps[inner].max()
    assert moved["left_foot"] > 0.01
    assert moved["left_toe"] < 5e-4


def test_arms_and_legs_point_as_those_of_the_person():
    motion = MOTIONS["walk"]
    rng = np.random.default_rng(0)
    angles = motion.angles.copy()
    waves = np.sin(np.arange(len(motion))[:, None] / 9.0 + rng.uniform(0.0, 6.0, 4))
    for wave, name in zip(
        waves.T, ("left_upper_arm_rx", "right_upper_arm_rx", "left_forearm_rx", "right_forearm_rx"), strict=True
    ):
        angles[:, motion.skeleton.dof_names.index(name)] = 0.5 * wave - 0.8 * ("forearm" in name)
    motion = replace(motion, angles=angles)
    result = to_robot(motion, robot(tilt=0.3, seed=1))
    bones = {("thigh", "shank"): ("knee", "ankle_1"), ("pelvis", "thigh"): ("hip_1", "knee")}
    bones |= {("clavicle", "upper_arm"): ("shoulder_1", "elbow"), ("upper_arm", "forearm"): ("elbow", "hand")}
    for side in ("left", "right"):
        for theirs, ours in bones.items():
            a, b = (at(one, *(f"{side}_{end}" for end in ends)) for one, ends in ((motion, theirs), (result, ours)))
            a, b = ((x[:, 1] - x[:, 0]) / np.linalg.norm(x[:, 1] - x[:, 0], axis=1, keepdims=True) for x in (a, b))
            apart = np.degrees(np.arccos(np.clip((a * b).sum(axis=1), -1.0, 1.0)))
            assert apart.max() < 3.0, (side, ours)


def test_angles_do_not_depend_on_the_world():
    motion, _ = walk()
    t = np.arange(len(motion))
    shaking = np.stack([np.sin(0.2 * t), 0.0 * t, np.cos(0.31 * t) ** 2], axis=1)  # feet are not still
    motion = replace(motion, root_positions=motion.root_positions + 0.01 * shaking)
    expected = to_robot(motion, robot())
    turn = Rotation.from_rotvec([0.0, 2.0, 0.0])
    root = Rotation.from_euler(motion.root_axes, motion.root_angles)
    turned = replace(
        motion,
        root_positions=turn.apply(motion.root_positions) + np.array([3.0, 0.4, 1.0]),
        root_angles=(turn * root).as_euler("xyz"),
    )
    for cycle, up, one in ((np.eye(3), "y", turned), (np.eye(3)[[2, 0, 1]], "z", motion)):
        rotation = Rotation.from_matrix(cycle)
        there = Rotation.from_euler(one.root_axes, one.root_angles)
        moved = replace(
            one,
            root_positions=one.root_positions @ cycle.T,
            root_angles=(rotation * there).as_euler("xyz"),
            up=up,
        )
        result = to_robot(moved, robot())
        assert result.up == up
        assert np.abs(result.angles - expected.angles).max() < 1e-7
        assert np.ptp(result.root_positions[:, "xyz".index(up)]) == pytest.approx(
            np.ptp(expected.root_positions[:, 1]), abs=1e-7
        )


def test_robots_without_legs_stand_on_the_floor_or_move_by_the_joints_of_their_base():
    motion, arms = walk()[0], robot(legs=False)
    result = to_robot(motion, arms)
    up = Rotation.from_euler(result.root_axes, result.root_angles).apply([0.0, 0.0, 1.0])
    assert np.allclose(up, [0.0, 1.0, 0.0], atol=1e-3)
    assert np.abs(result.root_positions[:, 1]).max() < 1e-3
    axes = zip(
        ("base_x", "base_y", "base"), ("slide", "slide", "hinge"), np.eye(3), (None, "base_x", "base_y"), strict=True
    )
    base = [Bone(name, above, (0, 0, 0), dofs, axis=axis) for name, dofs, axis, above in axes]
    on_base = [bone._replace(parent="base") if bone.parent is None else bone for bone in arms.bones]
    mobile = retarget_to_robot(motion, Skeleton([*base, *on_base], "parent"), joints=counterparts(arms))
    assert not np.ptp(np.c_[mobile.root_positions, mobile.root_angles], axis=0).any()
    np.testing.assert_allclose(in_space(mobile)[:, 3:], in_space(result), rtol=0, atol=1e-4)


def test_joints_without_counterpart_stay_at_rest():
    skeleton = robot()
    bones = [bone._replace(limits=[(0.1, 0.5)]) if bone.name == "head" else bone for bone in skeleton.bones]
    for one, angle in ((skeleton, 0.0), (Skeleton(bones, "parent"), 0.1)):
        result = to_robot(MOTIONS["walk"], one)
        assert (result.angles[:, skeleton.dof_names.index("head_joint")] == angle).all()


def test_a_robot_is_raised_where_its_soles_would_be_below_the_floor(capsys):
    narrow = {"ankle_1": (0.0, 0.05), "ankle_2": (0.1, 0.2)}
    bones = [
        bone._replace(limits=[narrow[bone.name.split("_", 1)[1]]]) if "ankle" in bone.name else bone
        for bone in robot().bones
    ]
    stiff = Skeleton(bones, "parent")
    result = to_robot(walk()[0], stiff, verbose=1)
    report = capsys.readouterr().out
    corners = np.array([[x, y, -0.05] for x in (-0.075, 0.12) for y in (-0.0375, 0.0375)])
    soles = [Bone(f"{side}{i}", f"{side}_ankle_2", c) for side in ("left", "right") for i, c in enumerate(corners)]
    lowest = in_world(replace(result, skeleton=Skeleton([*stiff.bones, *soles], "parent"), seen=None))[:, -8:, 1].min()
    assert -1e-6 < lowest < 1e-3
    assert re.search(r"raised by up to [\d.]+ mm", report)
    assert "angles reach their limits" in report


def test_the_report(capsys):
    report = report_of(MOTIONS["walk"], robot(), capsys)
    assert re.match(r"limbs, 14 places, soles .* mm off .*, hands .*, feet stand 5 times .*; at rest: head\n", report)


def with_legs_turned(motion, joint, angle):
    """The same motion on a skeleton whose leg, from a joint on, is rotated about x at angle zero."""
    turn, bones = Rotation.from_rotvec([angle, 0.0, 0.0]), []
    chain = ["thigh", "shank", "foot", "toes"]
    names = [f"{side}_{name}" for side in ("left", "right") for name in chain[chain.index(joint) :]]
    for bone in motion.skeleton.bones:
        bones.append(bone._replace(offset=turn.apply(bone.offset)) if bone.name in names else bone)
    angles = motion.angles.copy()
    for side in ("left", "right"):
        angles[:, motion.skeleton.dof_names.index(f"{side}_{joint}_rx")] -= angle
    return replace(motion, skeleton=Skeleton(bones, motion.skeleton.offset_frame), angles=angles)


@pytest.mark.parametrize(("joint", "angle"), [("foot", np.arctan2(0.1548, 0.06708)), ("thigh", np.pi)])
def test_a_zero_pose_with_other_legs_changes_nothing(joint, angle):
    """Feet that point along the shank, and legs that point up, do not show how feet stand; the motion does."""
    motion, _ = walk()
    turned = with_legs_turned(motion, joint, angle)
    assert np.allclose(at(turned, "left_foot", "right_toes"), at(motion, "left_foot", "right_toes"))
    apart = np.abs(to_robot(turned, robot()).angles - to_robot(motion, robot()).angles)
    assert apart.max() < 1e-2


G1_LINKS = {"hip_1": "hip_pitch", "knee": "knee", "ankle_1": "ankle_pitch", "ankle_2": "ankle_roll"}
G1_LINKS |= {"shoulder_1": "shoulder_pitch", "elbow": "elbow", "hand": "wrist_pitch"}


def with_known_links(skeleton):
    """The robot with the names of links of a Unitree G1."""
    names = {f"{side}_{a}": f"{side}_{b}_link" for side in ("left", "right") for a, b in G1_LINKS.items()}
    bones = [
        bone._replace(name=names.get(bone.name, bone.name), parent=names.get(bone.parent, bone.parent))
        for bone in skeleton.bones
    ]
    hands = [
        Bone(f"{side}_wrist_yaw_link", f"{side}_wrist_pitch_link", (0.0, 0.0, -0.05)) for side in ("left", "right")
    ]
    return Skeleton([*bones, *hands], "parent")


@pytest.mark.parametrize("rotvec", [(0, 0, np.pi), (0.3, 1.0, -2.0), (0, 0, 0.35), (0, 0.15, 0)])
def test_a_known_robot_is_known_however_its_root_is_turned(rotvec):
    motion, _ = walk()
    known = with_known_links(robot())
    inner = Bone("inner", None, (0.02, 0.1, 0.3), rest_rotation=Rotation.from_rotvec(rotvec).as_matrix())
    bones = [bone._replace(parent="inner") if bone.parent is None else bone for bone in known.bones]
    turned, expected = (retarget_to_robot(motion, one) for one in (Skeleton([inner, *bones], "parent"), known))
    assert np.abs(turned.angles - expected.angles).max() < 1e-5
    np.testing.assert_allclose(in_world(turned)[:, 1:], in_world(expected), atol=1e-5)


def test_joints_that_are_exchanged_or_missing_are_refused():
    motion, skeleton = walk()[0], robot()
    full = counterparts(skeleton)
    other = {"left": "right", "right": "left"}
    swapped = {link: f"{other[bone.split('_', 1)[0]]}_{bone.split('_', 1)[1]}" for link, bone in full.items()}
    plain = {name: name.replace("left", "a").replace("right", "b") for name in skeleton.joint_names}
    bones = [bone._replace(name=plain[bone.name], parent=bone.parent and plain[bone.parent]) for bone in skeleton.bones]
    backward = {plain[link]: bone for link, bone in swapped.items()}
    knee = full | {"left_hip_1": full["left_knee"], "left_knee": full["left_hip_1"]}
    some = {link: bone for link, bone in full.items() if link != "left_knee"}
    for target, joints, message in (
        (skeleton, swapped, "exchanges left and right"),
        (Skeleton(bones, "parent"), backward, "backward"),
        (skeleton, knee, "does not come after"),
        (skeleton, some, "left_knee"),
        (skeleton, {link: bone for link, bone in full.items() if "toe" not in link}, "front"),
    ):
        with pytest.raises(ValueError, match=message):
            retarget_to_robot(motion, target, joints=joints)
    with pytest.raises(ValueError, match="legs of the motion"):
        to_robot(motion.select(drop=["left_pelvis", "right_pelvis"]), robot(legs=False))


def test_a_robot_whose_names_are_unknown_is_found_by_its_lengths():
    """Hips, knees, ankles, elbows and hands are where they were named, without names that are given."""
    motion, skeleton = walk()[0], robot()
    found, expected = retarget_to_robot(motion, skeleton), to_robot(motion, skeleton)
    for name in ("left_ankle_1", "right_ankle_1", "left_hand", "right_hand"):
        np.testing.assert_allclose(at(found, name), at(expected, name), atol=0.03)


def test_likely_faults_are_warned_of():
    motion, skeleton = walk()[0], robot()
    bones = [bone._replace(offset=np.multiply(100.0, bone.offset)) for bone in motion.skeleton.bones]
    large = replace(motion, skeleton=Skeleton(bones, "own"), root_positions=100.0 * motion.root_positions)
    with pytest.warns(UserWarning, match="not metres"):
        result = to_robot(large, skeleton)
    assert np.abs(result.angles - to_robot(motion, skeleton).angles).max() < 1e-6
    angles = motion.angles.copy()
    angles[60:, motion.skeleton.dof_names.index("left_foot_rx")] += 3.0
    with pytest.warns(UserWarning, match=r"left foot turns by .* from frame 59 to 60"):
        to_robot(replace(motion, angles=angles), skeleton)


def test_a_given_scale_is_that_of_the_way():
    motion, _ = walk()
    skeleton = robot()
    result = to_robot(motion, skeleton, scale=1.0)
    assert np.ptp(result.root_positions[:, 2]) == pytest.approx(np.ptp(motion.root_positions[:, 2]), rel=1e-2)
    expected = to_robot(motion, skeleton)
    assert result.root_positions[:, 1] == pytest.approx(expected.root_positions[:, 1], abs=0.02)
    assert np.abs(at(result, "left_toe", "right_toe")[..., 1].min(axis=1)).max() < 5e-3


def test_joints_are_seen_where_their_counterparts_are():
    motion, skeleton = walk()[0], robot()
    seen = np.ones((len(motion), motion.skeleton.n_joints), bool)
    seen[30:40, motion.skeleton.joint_names.index("left_thigh")] = False  # the knee
    result = to_robot(replace(motion, seen=seen), skeleton)
    for name in ("left_hip_2", "left_hip_3", "left_knee"):
        assert not result.seen[30:40, skeleton.joint_names.index(name)].any()
        assert result.seen[:30, skeleton.joint_names.index(name)].all()
    for name in ("right_knee", "left_elbow", "left_toe", "waist_1"):
        assert result.seen[:, skeleton.joint_names.index(name)].all()
    assert not result.seen[:, skeleton.joint_names.index("head")].any()
    assert to_robot(motion, skeleton).seen is None
