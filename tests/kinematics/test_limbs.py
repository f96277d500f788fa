"""Retargeting by limbs: from people to robots of hinges with limits."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
import reference
from conftest import in_space
from robot_of_hinges import counterparts, robot, walk
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton
from skpose.datasets import MotionDataset, humanoid, make_gait
from skpose.kinematics import retarget
from skpose.kinematics._by_limbs._contacts import Sole, find_contacts, find_floor, hold_foot
from skpose.kinematics._by_limbs._places import find_robot, find_stance, joint_places, sole_of
from skpose.kinematics._by_limbs._results import _warn_of_throws
from skpose.kinematics._by_limbs._robots import ROBOTS, places_of
from skpose.kinematics._by_limbs._stances import stances_of

# Motions here ask for more than a robot can: what that does is looked at, and the warning has a test of its own.
pytestmark = pytest.mark.filterwarnings("ignore:the pelvis of the given skeleton is faster")

FASTEST = 20.0  # rad/s


def to_robot(motion, skeleton, **options):
    return retarget(motion, skeleton, method="limbs", joints=counterparts(skeleton), **options)


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


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("options", [{}, {"legs": False}, {"arms": False}, {"tilt": 0.3, "seed": 1}])
def test_angles_stay_in_their_limits_and_do_not_jump(name, options):
    skeleton = robot(**options)
    result = to_robot(MOTIONS[name], skeleton)
    lower, upper = np.array(skeleton.limits).T
    assert ((result.angles >= lower) & (result.angles <= upper)).all()
    steps = np.abs(np.diff(result.angles, axis=0)) * result.frame_rate
    assert steps.max() <= FASTEST * (1.0 + 1e-9)


def test_limits_that_are_ignored_are_left():
    skeleton = robot()
    result = to_robot(MOTIONS["noise"], skeleton, joint_limits="ignore")
    lower, upper = np.array(skeleton.limits).T
    assert ((result.angles < lower) | (result.angles > upper)).any()


@pytest.mark.parametrize(
    "options", [{}, {"tilt": 0.3, "seed": 1}, {"size": 1.5}, {"thigh": 0.25, "shank": 0.36}, {"arms": False}]
)
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


def test_the_pelvis_comes_nearer_to_feet_that_it_cannot_reach():
    """So chest and arms, which count less than feet, are where they shall be."""
    motion, _ = walk()
    up = 0.05 * np.sin(np.arange(len(motion)) / 7.0)
    motion = replace(motion, root_positions=motion.root_positions + np.outer(up, [0.0, 1.0, 0.0]))
    skeleton = robot()
    report = MotionDataset([motion]).retarget(skeleton, method="limbs", joints=counterparts(skeleton)).retargeting[0]
    hands, slide = re.search(r"hands .*?\(95 %: (.*?)\).* slide by (.*?) mm", report).groups()
    assert float(hands) < 1.0  # mm
    assert float(slide) < 1.0


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


@pytest.mark.parametrize("options", [{}, {"tilt": 0.3, "seed": 1}])
def test_arms_and_legs_point_as_those_of_the_person(options):
    motion = MOTIONS["walk"]
    rng = np.random.default_rng(0)
    angles = motion.angles.copy()
    waves = np.sin(np.arange(len(motion))[:, None] / 9.0 + rng.uniform(0.0, 6.0, 4))
    for wave, name in zip(
        waves.T, ("left_upper_arm_rx", "right_upper_arm_rx", "left_forearm_rx", "right_forearm_rx"), strict=True
    ):
        angles[:, motion.skeleton.dof_names.index(name)] = 0.5 * wave - 0.8 * ("forearm" in name)
    motion = replace(motion, angles=angles)
    result = to_robot(motion, robot(**options))
    bones = {("thigh", "shank"): ("knee", "ankle_1"), ("pelvis", "thigh"): ("hip_1", "knee")}
    bones |= {("clavicle", "upper_arm"): ("shoulder_1", "elbow"), ("upper_arm", "forearm"): ("elbow", "hand")}
    for side in ("left", "right"):
        for theirs, ours in bones.items():
            a, b = (at(one, *(f"{side}_{end}" for end in ends)) for one, ends in ((motion, theirs), (result, ours)))
            a, b = ((x[:, 1] - x[:, 0]) / np.linalg.norm(x[:, 1] - x[:, 0], axis=1, keepdims=True) for x in (a, b))
            apart = np.degrees(np.arccos(np.clip((a * b).sum(axis=1), -1.0, 1.0)))
            assert apart.max() < 3.0, (side, ours)


def test_it_walks_as_far_as_its_legs_are_long():
    motion, _ = walk()
    person = humanoid()
    zero = reference.forward_kinematics(np.zeros((1, person.n_dofs)), person)[0]
    knee, ankle, hip = (zero[person.joint_names.index(f"left_{name}")] for name in ("thigh", "shank", "pelvis"))
    leg = np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee)
    walked = np.ptp(motion.root_positions[:, 2])
    for size in (1.0, 2.0):
        result = to_robot(motion, robot(size=size))
        assert np.ptp(result.root_positions[:, 2]) == pytest.approx(size * 0.6 / leg * walked, rel=1e-2)


@pytest.mark.parametrize("size", [0.0, 0.01])
def test_angles_do_not_depend_on_the_world(size):
    motion, _ = walk()
    t = np.arange(len(motion))
    shaking = np.stack([np.sin(0.2 * t), 0.0 * t, np.cos(0.31 * t) ** 2], axis=1)  # feet are not still
    motion = replace(motion, root_positions=motion.root_positions + size * shaking)
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


def test_a_person_who_turns_around():
    motion, _ = walk()
    heading = np.linspace(0.0, 2.0 * np.pi, len(motion))
    turned = replace(motion, root_angles=np.stack([heading, 0 * heading, 0 * heading], axis=1), root_axes="YXZ")
    result = to_robot(turned, robot())
    assert np.abs(np.diff(result.root_angles, axis=0)).max() < 0.3
    assert result.root_angles[-1, 0] - result.root_angles[0, 0] == pytest.approx(2.0 * np.pi, abs=0.2)


def test_a_robot_without_legs_stands_on_the_floor():
    motion, _ = walk()
    result = to_robot(motion, robot(legs=False))
    up = Rotation.from_euler(result.root_axes, result.root_angles).apply([0.0, 0.0, 1.0])
    assert np.allclose(up, [0.0, 1.0, 0.0], atol=1e-3)
    assert np.abs(result.root_positions[:, 1]).max() < 1e-3


def test_joints_without_counterpart_stay_at_rest():
    skeleton = robot()
    bones = [bone._replace(limits=[(0.1, 0.5)]) if bone.name == "head" else bone for bone in skeleton.bones]
    for one, angle in ((skeleton, 0.0), (Skeleton(bones, "parent"), 0.1)):
        result = to_robot(MOTIONS["walk"], one)
        assert (result.angles[:, skeleton.dof_names.index("head_joint")] == angle).all()


def test_auto_takes_limbs_for_a_robot_and_reports():
    skeleton = robot()
    dataset = MotionDataset([MOTIONS["walk"]]).retarget(skeleton, method="auto", joints=counterparts(skeleton))
    report = dataset.retargeting[0]
    assert report.startswith("limbs, 14 places, soles ")
    assert report.endswith("; at rest: head")
    assert "feet stand 5 times and slide by 0.0" in report
    again = dataset.retarget(skeleton, method="auto")
    assert again.retargeting == dataset.retargeting  # the same numbers
    treadmill = MotionDataset(make_gait(1, 1, random_state=0).motions[:1])
    assert (
        "feet stand nowhere"
        in treadmill.retarget(skeleton, method="limbs", joints=counterparts(skeleton)).retargeting[0]
    )


def test_what_cannot_be_reached_is_reported():
    motion, _ = walk()
    bones = [b._replace(limits=[(0.0, 0.05)]) if b.name.endswith("ankle_1") else b for b in robot().bones]
    stiff = Skeleton(bones, "parent")  # on which a foot is flat only where the shank is upright
    report = MotionDataset([motion]).retarget(stiff, method="limbs", joints=counterparts(stiff)).retargeting[0]
    assert "angles reach their limits" in report
    assert float(report.split("soles ")[1].split()[0]) > 1.0  # mm


def test_a_robot_is_raised_where_its_soles_would_be_below_the_floor():
    motion, _ = walk()
    narrow = {"ankle_1": (0.0, 0.05), "ankle_2": (0.1, 0.2)}
    bones = [
        bone._replace(limits=[narrow[bone.name.split("_", 1)[1]]]) if "ankle" in bone.name else bone
        for bone in robot().bones
    ]
    stiff = Skeleton(bones, "parent")
    result = to_robot(motion, stiff)
    _, ours = stances_of(motion.skeleton, stiff, counterparts(stiff))
    lowest = []
    for side in ("left", "right"):
        ankle = stiff.joint_names.index(f"{side}_ankle_2")
        corners = np.array([[x, y, -0.05] for x in (-0.075, 0.12) for y in (-0.0375, 0.0375)])
        bones = [Bone(f"{i}", f"{side}_ankle_2", corner) for i, corner in enumerate(corners)]
        more = replace(result, skeleton=Skeleton([*stiff.bones, *bones], "parent"))
        lowest.append(in_world(more)[:, -4:, 1].min())
        assert np.allclose(sole_of(ours, side).corners()[[1, 0, 3, 2]], corners)
        assert ours.feet[side][0] == ankle
    assert -1e-6 < min(lowest) < 1e-3
    report = MotionDataset([motion]).retarget(stiff, method="limbs", joints=counterparts(stiff)).retargeting[0]
    assert re.search(r"raised by up to [\d.]+ mm where soles would be below the floor", report)


def test_no_frames():
    skeleton = robot()
    assert to_robot(walk()[0][:0], skeleton).angles.shape == (0, skeleton.n_dofs)
    assert len(to_robot(walk()[0][:1], skeleton)) == 1


def test_robots_are_known_by_their_links():
    for known in ROBOTS:
        places = places_of(known)
        links = {link for link, _ in places.values()}
        bones = [Bone(link, None, (0.1, 0.0, 0.0), "x") for link in sorted(links)]
        assert find_robot(Skeleton(bones)) == known
        for mark, (link, offset) in places.items():
            side, _, name = mark.partition("_")
            other, mirrored = places[f"{'right' if side == 'left' else 'left'}_{name}"]
            assert link != other
            assert mirrored == (offset[0], -offset[1], offset[2])
    assert find_robot(humanoid()) is None


def test_refused():
    motion, skeleton = walk()[0], robot()
    with pytest.raises(ValueError, match="has the names of no person or robot that is known: pass joints="):
        retarget(motion, skeleton, method="limbs")
    with pytest.raises(ValueError, match="but the given skeleton has only left_knee"):
        retarget(motion, skeleton, method="limbs", joints={"left_knee": "left_thigh"})
    arms = counterparts(robot(legs=False))
    with pytest.raises(ValueError, match="needs the legs of the motion"):
        retarget(motion.select(drop=["left_pelvis", "right_pelvis"]), robot(legs=False), method="limbs", joints=arms)
    with pytest.raises(ValueError, match='joint_limits must be "ignore", "enforce" or None'):
        to_robot(motion, skeleton, joint_limits="hard")
    free = Skeleton([bone._replace(limits=None) for bone in skeleton.bones], "parent")
    with pytest.raises(ValueError, match="needs a skeleton with limits"):
        to_robot(motion, free, joint_limits="enforce")
    assert np.isfinite(to_robot(motion, free).angles).all()


def test_other_methods_refuse_or_enforce_limits():
    motion = walk()[0]
    bones = [bone._replace(limits=[(0.0, 0.3)]) if bone.name == "left_shank" else bone for bone in humanoid().bones]
    narrow = Skeleton(bones, humanoid().offset_frame)
    column = narrow.dof_names.index("left_shank_rx")
    assert retarget(motion, narrow).angles[:, column].max() > 0.3  # as files are
    for method in ("numbers", "orientations"):
        with pytest.raises(ValueError, match="1 angles leave the limits of the skeleton, most 'left_shank_rx' by"):
            retarget(motion, narrow, method=method, joint_limits="enforce")
    within = retarget(motion, narrow, method="positions", joint_limits="enforce")
    assert within.angles[:, column].max() <= 0.3
    report = MotionDataset([motion]).retarget(narrow, method="auto", joint_limits="enforce").retargeting[0]
    assert report.startswith("positions")


# --- when feet stand --------------------------------------------------------------------------------------------------


def path(pieces, rate=100.0):
    """Positions of a point that is still, or moves at a speed, for some seconds each."""
    steps = np.concatenate([np.full(round(seconds * rate), speed / rate) for seconds, speed in pieces])
    points = np.zeros((len(steps), 3))
    points[:, 0] = np.cumsum(steps)
    return points, np.arange(len(steps)) / rate


def test_contacts_are_the_times_when_a_foot_is_still():
    toes, times = path([(0.5, 0.0), (0.4, 3.0), (0.6, 0.0), (0.4, 3.0)])
    found = find_contacts(toes, toes, times, 1.0)
    assert np.abs(np.array([(c.first, c.end) for c in found]) - [(0, 50), (90, 150)]).max() <= 4
    assert all(c.flat_first - c.first <= 1 and c.end - c.flat_end <= 1 for c in found)


def test_toes_stand_while_the_heel_rises():
    toes, times = path([(1.0, 0.0)])
    ankles, _ = path([(0.5, 0.0), (0.5, 1.0)])
    (contact,) = find_contacts(toes, ankles, times, 1.0)
    assert (contact.first, contact.end) == (0, 100)
    assert contact.flat_end == pytest.approx(50, abs=4)


@pytest.mark.parametrize("speed", [0.15, 0.2, 0.5])
def test_a_foot_that_slides_on_does_not_stand(speed):
    toes, times = path([(3.0, speed)])
    assert not find_contacts(toes, toes, times, 1.0)


def test_a_foot_that_slides_from_one_place_to_another_stands_before_and_after():
    toes, times = path([(1.0, 0.0), (0.5, 0.4), (1.0, 0.0)])
    found = find_contacts(toes, toes, times, 1.0)
    assert np.abs(np.array([(c.first, c.end) for c in found]) - [(0, 100), (150, 250)]).max() <= 10


def test_a_drift_of_seconds_is_held_in_places():
    toes, times = path([(10.0, 0.02)])
    found = find_contacts(toes, toes, times, 1.0)
    assert 2 <= len(found) <= 3


def test_feet_that_are_not_seen_do_not_stand():
    toes, times = path([(1.5, 0.0)])
    seen = np.ones(len(toes), bool)
    seen[50:100] = False
    assert [(c.first, c.end) for c in find_contacts(toes, toes, times, 1.0, seen)] == [(0, 50), (100, 150)]


SOLE = Sole(np.array([-0.05, 0.0, -0.04]), np.array([0.12, 0.0, -0.04]), 0.04)


@pytest.mark.parametrize(
    "pieces", [[(1.0, 0.0), (0.5, 0.4), (1.0, 0.0)], [(10.0, 0.02)], [(1.0, 0.0), (0.06, 1.5)] * 3]
)
def test_a_held_foot_does_not_jump(pieces):
    ankles, times = path(pieces)
    ankles[:, 2] = 0.05
    frames = np.broadcast_to(np.eye(3), (len(ankles), 3, 3))
    toes = ankles + SOLE.tip
    held = hold_foot(ankles, frames, SOLE, find_contacts(toes, ankles, times, 1.0), times, 1.0)
    steps, theirs = (np.linalg.norm(np.diff(one, axis=0), axis=1) for one in (held.ankles, ankles))
    assert steps.max() < theirs.max() + 0.01  # m, a leg a second
    assert held.contacts
    for contact in held.contacts:
        assert np.ptp(held.ankles[contact.first : contact.end], axis=0).max() < 1e-12


def test_no_corner_of_a_sole_is_below_the_floor():
    rng = np.random.default_rng(0)
    times = np.arange(200) / 100.0
    ankles = np.cumsum(rng.normal(scale=0.01, size=(200, 3)), axis=0)
    ankles[:, 2] += 0.05
    frames = Rotation.from_rotvec(rng.normal(scale=0.4, size=(200, 3))).as_matrix()
    held = hold_foot(ankles, frames, SOLE, [], times, 1.0)
    corners = [[x, y, -0.04] for x in (-0.05, 0.12) for y in (-0.04, 0.04)]
    heights = (held.ankles[:, None] + np.array(corners) @ held.frames.transpose(0, 2, 1))[:, :, 2]
    assert heights.min() > -1e-12
    assert (np.abs(heights.min(axis=1)) < 1e-12).sum() > 20


def test_the_floor_is_in_legs():
    heights = np.array([0.0, 0.02, 0.04, 0.09])
    assert find_floor(heights, 1.0) == 0.02
    assert find_floor(100.0 * heights, 100.0) == 2.0


def test_a_foot_in_the_air_does_not_stand():
    low, times = path([(0.5, 0.0), (0.3, 3.0), (0.5, 0.0)])
    high = low + np.outer(np.arange(len(low)) > 65, [0.0, 0.0, 0.6])
    assert len(find_contacts(high, high, times, 1.0)) == 1


def test_a_mobile_base_moves_by_its_own_joints():
    arms = robot(legs=False)
    base = [
        Bone("base_x", None, (0, 0, 0), "slide", axis=(1, 0, 0)),
        Bone("base_y", "base_x", (0, 0, 0), "slide", axis=(0, 1, 0)),
        Bone("base", "base_y", (0, 0, 0), "hinge", axis=(0, 0, 1)),
    ]
    on_base = [bone._replace(parent="base") if bone.parent is None else bone for bone in arms.bones]
    motion, _ = walk()
    there = retarget(motion, arms, method="limbs", joints=counterparts(arms))
    mobile = retarget(motion, Skeleton([*base, *on_base], "parent"), method="limbs", joints=counterparts(arms))
    assert not np.ptp(mobile.root_positions, axis=0).any()
    assert not np.ptp(mobile.root_angles, axis=0).any()
    assert mobile.angles[-1, :2] - mobile.angles[0, :2] == pytest.approx(
        there.root_positions[-1, [2, 0]] - there.root_positions[0, [2, 0]], abs=1e-6
    )
    np.testing.assert_allclose(in_space(mobile)[:, 3:], in_space(there), rtol=0, atol=1e-4)


# --- zero poses -------------------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(("joint", "angle"), [("foot", np.arctan2(0.1548, 0.06708)), ("thigh", np.pi), ("foot", 0.7)])
def test_a_zero_pose_with_other_legs_changes_nothing(joint, angle):
    """Feet that point along the shank, and legs that point up, do not show how feet stand; the motion does."""
    motion, _ = walk()
    turned = with_legs_turned(motion, joint, angle)
    assert np.allclose(at(turned, "left_foot", "right_toes"), at(motion, "left_foot", "right_toes"))
    if (joint, angle) == ("foot", 0.7):  # a foot that shows a direction forward is taken as flat
        assert np.abs(to_robot(turned, robot()).angles - to_robot(motion, robot()).angles).max() > 0.1
        return
    apart = np.abs(to_robot(turned, robot()).angles - to_robot(motion, robot()).angles)
    assert apart.max() < 1e-2


def test_a_foot_whose_toes_point_up_does_not_stand():
    """Somebody who lies on the back has feet near the floor that are still."""
    motion, _ = walk()
    back = Rotation.from_rotvec([-np.pi / 2.0, 0.0, 0.0])
    lying = replace(
        motion[:60],
        angles=np.tile(motion.angles[18], (60, 1)),
        root_positions=np.tile([0.0, 0.1, 0.0], (60, 1)),
        root_angles=np.tile(back.as_euler("xyz"), (60, 1)),
        root_axes="xyz",
    )
    report = MotionDataset([lying]).retarget(robot(), method="limbs", joints=counterparts(robot())).retargeting[0]
    assert "feet stand nowhere" in report


def test_a_zero_pose_that_does_not_stand_needs_feet_that_stand():
    motion = with_legs_turned(MOTIONS["run"], "thigh", np.pi)
    treadmill = replace(motion, root_positions=motion.root_positions * [0.0, 1.0, 0.0])
    with pytest.raises(ValueError, match="does not stand at angle zero, and the left foot never stands flat"):
        to_robot(treadmill, robot())


def test_hands_and_toes_without_length_are_no_places():
    bones = [
        bone._replace(offset=(0.0, 0.0, 0.0)) if bone.name in ("left_hand", "right_hand", "left_foot") else bone
        for bone in humanoid().bones
    ]
    skeleton = Skeleton(bones, "own")
    names = {"hip": "pelvis", "knee": "thigh", "ankle": "shank", "ball": "foot"}
    names |= {"shoulder": "clavicle", "elbow": "upper_arm", "wrist": "forearm", "hand": "hand"}
    joints = {
        f"{side}_{mark}": skeleton.joint_names.index(f"{side}_{name}")
        for side in ("left", "right")
        for mark, name in names.items()
    }
    places = find_stance(skeleton, joint_places(skeleton, joints)).places
    assert set(joints) - set(places) == {"left_hand", "right_hand", "left_ball"}


# --- robots -----------------------------------------------------------------------------------------------------------

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


@pytest.mark.parametrize(
    "rotvec", [(0, 0, np.pi / 2), (0, 0, np.pi), (0, 0.35, 0), (np.pi / 2, 0, 0), (0.3, 1.0, -2.0)]
)
def test_a_known_robot_is_known_however_its_root_is_turned(rotvec):
    motion, _ = walk()
    known = with_known_links(robot())
    assert find_robot(known).name == "Unitree G1"
    inner = Bone("inner", None, (0.02, 0.1, 0.3), rest_rotation=Rotation.from_rotvec(rotvec).as_matrix())
    bones = [bone._replace(parent="inner") if bone.parent is None else bone for bone in known.bones]
    turned = retarget(motion, Skeleton([inner, *bones], "parent"), method="limbs")
    assert np.abs(turned.angles - retarget(motion, known, method="limbs").angles).max() < 1e-5
    expected = in_world(retarget(motion, known, method="limbs"))
    np.testing.assert_allclose(in_world(turned)[:, 1:], expected, atol=1e-5)


def test_a_robot_that_lacks_a_link_is_named():
    known = with_known_links(robot())
    bones = [bone._replace(name="hand_l") if bone.name == "left_wrist_yaw_link" else bone for bone in known.bones]
    with pytest.raises(ValueError, match="nearly the Unitree G1, but has no 'left_wrist_yaw_link'"):
        retarget(walk()[0], Skeleton(bones, "parent"), method="limbs")


def test_counterparts_that_miss_a_joint_are_refused():
    motion, skeleton = walk()[0], robot()
    full = counterparts(skeleton)
    for joint, mark in (("left_knee", "left_knee"), ("right_ankle_1", "right_ankle"), ("left_elbow", "left_elbow")):
        some = {link: bone for link, bone in full.items() if link != joint}
        with pytest.raises(ValueError, match=f"but {mark} has no counterpart: name the joints"):
            retarget(motion, skeleton, method="limbs", joints=some)
    known = with_known_links(skeleton)
    arms = {"shoulder_pitch": "clavicle", "elbow": "upper_arm", "wrist_pitch": "forearm"}
    pairs = {f"{side}_{a}_link": f"{side}_{b}" for side in ("left", "right") for a, b in arms.items()}
    with pytest.raises(ValueError, match="needs all joints of the legs of the given skeleton, but left_hip"):
        retarget(motion, known, method="limbs", joints=pairs)


def test_counterparts_that_are_exchanged_are_refused():
    motion, skeleton = walk()[0], robot()
    full = counterparts(skeleton)
    other = {"left": "right", "right": "left"}
    swapped = {link: f"{other[bone.split('_', 1)[0]]}_{bone.split('_', 1)[1]}" for link, bone in full.items()}
    with pytest.raises(ValueError, match="left and right are exchanged"):
        retarget(motion, skeleton, method="limbs", joints=swapped)
    plain = {name: name.replace("left", "a").replace("right", "b") for name in skeleton.joint_names}
    bones = [bone._replace(name=plain[bone.name], parent=bone.parent and plain[bone.parent]) for bone in skeleton.bones]
    with pytest.raises(ValueError, match="the feet of the given skeleton point backward"):
        retarget(
            motion,
            Skeleton(bones, "parent"),
            method="limbs",
            joints={plain[link]: bone for link, bone in swapped.items()},
        )
    knee = full | {"left_hip_1": full["left_knee"], "left_knee": full["left_hip_1"]}
    with pytest.raises(ValueError, match="but in the given skeleton the first does not carry the second"):
        retarget(motion, skeleton, method="limbs", joints=knee)


def test_soles_that_nobody_names_are_warned_of():
    motion, skeleton = walk()[0], robot()
    joints = {link: bone for link, bone in counterparts(skeleton).items() if "toe" not in link}
    for _ in range(2):  # each time, though what is known of skeletons is kept
        with pytest.warns(UserWarning, match="taken to be as low as its joints 'left_toe' and 'right_toe'"):
            result = retarget(motion, skeleton, method="limbs", joints=joints)
    assert at(result, "left_toe", "right_toe")[..., 1].min() > -1e-3
    with pytest.warns(UserWarning, match="no point of the soles"):
        report = MotionDataset([motion]).retarget(skeleton, method="limbs", joints=joints).retargeting[0]
    assert "soles as low as 'left_toe' and 'right_toe'" in report


def test_a_given_scale_is_that_of_the_way():
    motion, _ = walk()
    skeleton = robot()
    result = to_robot(motion, skeleton, scale=1.0)
    assert np.ptp(result.root_positions[:, 2]) == pytest.approx(np.ptp(motion.root_positions[:, 2]), rel=1e-2)
    expected = to_robot(motion, skeleton)
    assert result.root_positions[:, 1] == pytest.approx(expected.root_positions[:, 1], abs=0.02)
    assert np.abs(at(result, "left_toe", "right_toe")[..., 1].min(axis=1)).max() < 5e-3
    wheels = robot(legs=False)
    one, other = (to_robot(motion, wheels, scale=scale) for scale in (None, 1.0))
    assert np.abs(one.angles - other.angles).max() < 1e-3
    assert np.ptp(other.root_positions[:, 2]) == pytest.approx(np.ptp(motion.root_positions[:, 2]), rel=1e-3)


def test_motions_in_other_units_are_warned_of():
    motion, _ = walk()
    bones = [bone._replace(offset=np.multiply(100.0, bone.offset)) for bone in motion.skeleton.bones]
    large = replace(motion, skeleton=Skeleton(bones, "own"), root_positions=100.0 * motion.root_positions)
    with pytest.warns(UserWarning, match="legs of the motion's skeleton are 84.5 m long"):
        result = to_robot(large, robot())
    assert np.abs(result.angles - to_robot(motion, robot()).angles).max() < 1e-6


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


def test_feet_that_slide_do_not_jump():
    """A person who stands and slides, slowly, then faster, and stands again."""
    motion, _ = walk()
    frame = 18  # both feet stand
    speeds = np.repeat([0.0, 0.1, 0.3, 0.0], [60, 120, 30, 60])
    n = len(speeds)
    way = np.outer(np.cumsum(speeds) / 60.0, [0.6, 0.0, 0.8])
    sliding = Motion(motion.skeleton, np.tile(motion.angles[frame], (n, 1)), 60, motion.root_positions[frame] + way)
    result = to_robot(sliding, robot())
    steps = np.linalg.norm(np.diff(at(result, "left_toe", "right_toe"), axis=0), axis=2)
    assert steps.max() < 2.5 * 0.3 / 60.0
    report = MotionDataset([sliding]).retarget(robot(), method="limbs", joints=counterparts(robot())).retargeting[0]
    assert "faster than" not in report


def test_what_is_faster_than_the_person_is_reported():
    motion, _ = walk()
    angles = motion.angles.copy()
    angles[60:, motion.skeleton.dof_names.index("left_foot_rx")] += 3.0  # a foot that flips
    flipped = replace(motion, angles=angles)
    with pytest.warns(UserWarning, match="left foot of the motion turns by 1.* from frame 59 to 60"):
        report = MotionDataset([flipped]).retarget(robot(), method="limbs", joints=counterparts(robot())).retargeting[0]
    assert "faster than the person's: " in report


def test_throws_are_counted_and_named():
    still, thrown = np.zeros(9), np.array([0.0, 0.0, 5.6, 1.2, 0.0])
    with pytest.warns(UserWarning, match=r"by up to 5\.6 m/s, from frame 2 to 3 \(2 such frames\)"):
        _warn_of_throws(thrown)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _warn_of_throws(still)


def test_a_robot_is_no_source():
    g1_like = robot()
    names = dict(zip([link for link, _ in places_of(ROBOTS[0]).values()], range(99), strict=False))
    bones = [Bone(name, None, (0, 0, 0.1 * i), "hinge", axis=(0, 1, 0)) for i, name in enumerate(names)]
    motion = Motion(Skeleton(bones, "parent"), np.zeros((3, len(bones))), 30.0, up="z")
    with pytest.raises(ValueError, match="it is the Unitree G1, and a motion must be a person's"):
        retarget(motion, g1_like, method="limbs")


def test_legs_need_a_root_that_moves_freely():
    legs = robot()
    rail = Bone("rail", None, (0, 0, 0), "slide", axis=(1, 0, 0), dof_name="root_x")
    bones = [rail, *(bone._replace(parent="rail") if bone.parent is None else bone for bone in legs.bones)]
    with pytest.raises(ValueError, match="'rail' is moved by joints of its own, root_x: load_robot"):
        retarget(walk()[0], Skeleton(bones, "parent"), method="limbs", joints=counterparts(legs))
