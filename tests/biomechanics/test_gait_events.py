"""Gait events and parameters: of walkers whose steps are known, of controls that do not walk, of recordings."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from walkers import SKELETON, rotation_about, walk

from skpose import Motion, Skeleton
from skpose.biomechanics import gait_events, gait_parameters
from skpose.datasets import humanoid

OFF_BY = 0.012  # s, at 100 Hz: a foot that stops at once is slow that much before it stands, after the filter


def mean_of(parameters, quantity, foot="both"):
    (found,) = [one for one in parameters.summary() if (one.quantity, one.foot) == (quantity, foot)]
    return found.mean


def errors(events, kind, foot, stride, share):
    """Times (s) by which events of a foot are off the nearest time k + share, in strides."""
    times = events.times[(events.feet == foot) & (events.kinds == kind)] / stride - share
    return (times - np.rint(times)) * stride


@pytest.mark.parametrize(
    "known",
    [
        {},
        {"step": 0.4, "cadence": 80.0, "stance": 0.68},
        {"step": 0.9, "cadence": 165.0, "stance": 0.35},
        {"phase": 0.44, "width": 0.2},
        {"up": "z", "heading": 2.0},
    ],
)
def test_events_are_those_of_the_walker(known):
    stride, stance = 120.0 / known.get("cadence", 110.0), known.get("stance", 0.62)
    events = gait_events(walk(**known))
    n_strides = 6.0 / stride
    for foot, lag in (("left", 0.0), ("right", known.get("phase", 0.5))):
        contacts = errors(events, "foot contact", foot, stride, lag)
        offs = errors(events, "foot off", foot, stride, lag + stance)
        assert len(contacts) >= n_strides - 2
        assert len(offs) >= n_strides - 2
        assert np.abs(contacts).max() < 1.5 * OFF_BY
        assert np.abs(offs).max() < 1.5 * OFF_BY
    assert (np.diff(events.times) > 0).all()
    assert (np.abs(events.frames / 100.0 - events.times) <= 0.5001 / 100.0).all()


def test_parameters_are_those_of_the_walker():
    found = gait_parameters(walk(step=0.6, cadence=110.0, stance=0.62, width=0.12, phase=0.45))
    for foot in ("left", "right"):
        assert mean_of(found, "cadence", foot) == pytest.approx(110.0, abs=0.1)
        assert mean_of(found, "stride_length", foot) == pytest.approx(1.2, abs=1e-3)
        assert mean_of(found, "speed", foot) == pytest.approx(1.1, abs=2e-3)
        assert mean_of(found, "stride_time", foot) == pytest.approx(120 / 110, abs=1e-3)
        assert mean_of(found, "step_width", foot) == pytest.approx(0.12, abs=1e-3)
        assert mean_of(found, "stance", foot) == pytest.approx(62.0, abs=2.5)
        assert mean_of(found, "double_support", foot) == pytest.approx(24.0, abs=5.0)
    # The right foot comes down 45 % of the stride after the left one, and the pelvis is as far then.
    assert mean_of(found, "step_time", "right") == pytest.approx(0.45 * 120 / 110, abs=2e-3)
    assert mean_of(found, "step_length", "right") == pytest.approx(0.45 * 1.2, abs=1e-3)
    assert mean_of(found, "step_length", "left") == pytest.approx(0.55 * 1.2, abs=1e-3)


def test_the_feet_of_a_runner_are_in_the_air_between_stances():
    found = gait_parameters(walk(step=0.9, cadence=165.0, stance=0.35))
    assert mean_of(found, "double_support") == 0.0
    assert mean_of(found, "stance") == pytest.approx(35.0, abs=1.0)


def test_summary_and_table_are_of_the_strides():
    found = gait_parameters(walk(phase=0.45))
    table = found.to_pandas()
    assert len(table) == len(found) == len(found.events.strides)
    for one in found.summary():
        values = table[f"{one.quantity} [{one.unit}]"][(table["foot"] == one.foot) | (one.foot == "both")].dropna()
        assert one.n_strides == len(values)
        assert one.mean == pytest.approx(values.mean())
        assert one.std == pytest.approx(values.std())
    events = found.events.to_pandas()
    assert list(events.columns) == ["foot", "event", "frame", "time [s]"]
    assert len(events) == len(found.events)
    assert repr(found).startswith("GaitParameters(")
    assert "steps/min" in repr(found)
    assert "100 Hz, y up" in repr(found)
    assert "left_foot" in repr(found.events)


@pytest.mark.parametrize("up", ["x", "y", "z"])
@pytest.mark.parametrize("heading", [0.0, 2.5])
def test_figures_are_the_same_in_every_direction_of_every_world(up, heading):
    expected = gait_parameters(walk(phase=0.46)).to_pandas()
    found = gait_parameters(walk(phase=0.46, up=up, heading=heading)).to_pandas()
    assert (found["foot"] == expected["foot"]).all()
    numbers = expected.columns[1:]
    np.testing.assert_allclose(found[numbers], expected[numbers], atol=1e-6)


def test_mirrored_walks_have_the_sides_exchanged():
    motion = walk(phase=0.46, turn=0.2)
    events, other = gait_events(motion), gait_events(motion.mirrored())
    assert [{"left": "right", "right": "left"}[foot] for foot in events.feet] == other.feet.tolist()
    np.testing.assert_allclose(events.times, other.times, atol=1e-9)
    one, two = gait_parameters(events), gait_parameters(other)
    np.testing.assert_allclose(one.step_length, two.step_length, atol=1e-9)
    np.testing.assert_allclose(one.step_width, two.step_width, atol=1e-9)


@pytest.mark.parametrize("turn", [0.5, -0.8])
def test_turns_are_followed(turn):
    """On a circle of radius r the feet are on circles of r ∓ half the width, of which strides are chords."""
    found = gait_parameters(walk(turn=turn, width=0.14))
    assert len(found) >= 8
    stride = 120.0 / 110.0
    radius = 1.1 / abs(turn)
    for foot, sign in (("left", 1.0), ("right", -1.0)):
        own = radius - sign * np.sign(turn) * 0.07
        chord = 2.0 * own * np.sin(abs(turn) * stride / 2.0)
        assert mean_of(found, "stride_length", foot) == pytest.approx(chord, rel=0.01)
    assert mean_of(found, "cadence") == pytest.approx(110.0, abs=0.2)


def test_missing_frames_are_filled_if_they_are_few():
    motion = walk()
    thin = replace_frames(motion, np.delete(np.arange(len(motion)), [100, 250, 251, 400]))
    expected, found = gait_events(motion), gait_events(thin)
    assert found.kinds.tolist() == expected.kinds.tolist()
    np.testing.assert_allclose(found.times, expected.times, atol=0.005)
    assert (np.abs(thin.times[found.frames] - found.times) <= 0.02).all()
    with pytest.raises(ValueError, match=r"are missing after frame 99: cut the motion there, motion\[:100\]"):
        gait_events(replace_frames(motion, np.delete(np.arange(len(motion)), np.arange(100, 130))))


def test_feet_that_are_not_seen_are_filled_for_a_moment_and_else_refused():
    motion = walk()
    names, seen = list(motion.skeleton.joint_names), np.ones((len(motion), motion.skeleton.n_joints), bool)
    expected = gait_events(motion)
    seen[205:212, names.index("left_ankle")] = False
    angles = motion.angles.copy()
    angles[205:212] = angles[204]  # as inverse kinematics leaves them
    found = gait_events(replace(motion, angles=angles, seen=seen))
    np.testing.assert_array_equal(found.kinds, expected.kinds)
    np.testing.assert_allclose(found.times, expected.times, atol=0.02)
    seen[205:230, names.index("left_ankle")] = False
    with pytest.raises(
        ValueError, match=r"are not seen for 0\.25 s, from frame 205 to 229: cut the motion there, moti"
    ):
        gait_events(replace(motion, seen=seen))
    seen[:, names.index("head")] = False  # has no part in it
    assert len(gait_events(replace(motion, seen=seen)[240:])) > 3
    seen[-40:] = False
    with pytest.raises(ValueError, match=r"but only from frame 10 to 340 of 381 .*: pass motion\[10:341\]"):
        gait_events(replace(motion, seen=seen)[220:])


def jump_of(motion, frame, metres=0.0, degrees=0.0):
    """The motion, in which from a frame on the person is elsewhere, or faces elsewhere."""
    after = np.arange(len(motion)) >= frame
    place, turned = motion.root_positions[frame], rotation_about([0.0, 1.0, 0.0], np.radians(degrees) * after)
    root = turned * Rotation.from_euler(motion.root_axes, motion.root_angles)
    moved = place + turned.apply(motion.root_positions - place) + np.outer(metres * after, [0.6, 0.0, 0.8])
    return replace(motion, root_positions=moved, root_angles=root.as_euler("xzy"), root_axes="xzy")


@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
@pytest.mark.parametrize("frame", [1, 7, 100])
def test_a_jump_of_the_pelvis_is_refused(rate, frame):
    """Nobody moves by more than 12 m/s, or turns by more than 2,200°/s."""
    motion = walk(duration=3.0, rate=rate)
    for jump, words in (
        ({"metres": 12.0 / rate + 0.06}, r"the pelvis moves by .* m from frame {} to the next.*at most 12 m/s"),
        ({"degrees": 2200.0 / rate + 20.0}, r"the pelvis turns by .*° from frame {} to the next.*at most 2,200°/s"),
    ):
        words += r".*Cut the motion there, motion\[:{}\] and motion\[{}:\]"
        with pytest.raises(ValueError, match=words.format(frame, frame + 1, frame + 1)):
            gait_events(jump_of(motion, frame + 1, **jump))
        gait_events(jump_of(motion, frame + 1, **{name: 0.5 * size for name, size in jump.items()}))


def test_two_recordings_in_one_are_refused():
    """Each begins where it does, so that the root goes back; frames that were left out without their numbers, too."""
    motion = walk(duration=3.0)
    with pytest.raises(ValueError, match=r"moves by 3\.28 m from frame 300 to the next, in 0\.01 s, which nobody does"):
        gait_parameters(Motion.concatenate([motion, motion]))
    thin = np.delete(np.arange(len(motion)), np.arange(100, 130))
    with pytest.raises(ValueError, match=r"frames are missing.*motion\[:100\] and motion\[100:\]"):
        gait_events(replace_frames(motion, thin, np.arange(len(thin))))


@pytest.mark.parametrize(
    ("known", "rate", "words"),
    [
        ({}, 230.0, r"253 steps/min with a stance of 5\d %, and nobody walks with more than 220: .*230 Hz"),
        ({"step": 0.9, "cadence": 165.0, "stance": 0.35}, 200.0, r"nobody runs with more than 300"),
        ({"step": 0.9, "cadence": 165.0, "stance": 0.35}, 170.0, None),
        ({}, 190.0, None),
    ],
)
def test_a_cadence_that_nobody_has_is_a_warning(known, rate, words):
    """Of a walk at 100 Hz that is said to have another frame rate."""
    other = replace(walk(**known), frame_rate=rate)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gait_parameters(other)
    assert len(caught) == (words is not None)
    if words is not None:
        assert re.search(words, str(caught[0].message))


def replace_frames(motion, rows, numbers=None):
    return replace(
        motion,
        angles=motion.angles[rows],
        root_positions=motion.root_positions[rows],
        root_angles=motion.root_angles[rows],
        frame_numbers=motion.frame_numbers[rows] if numbers is None else numbers,
    )


def test_a_part_of_a_recording_has_the_events_of_the_whole():
    motion = walk()
    expected, found = gait_events(motion), gait_events(motion[150:])
    within = found.times[2:-2] + 1.5  # the numbers of its frames begin at 0
    assert np.abs(expected.times - within[:, None]).min(axis=1).max() < 0.002


def with_spike(motion, frames, size, dof):
    """The motion with the front of a foot, or all of the person, too high by a size (m) in some frames."""
    if dof is None:
        root = motion.root_positions.copy()
        root[frames, "xyz".index(motion.up)] += size
        return replace(motion, root_positions=root)
    skeleton = motion.skeleton
    joint = next(name for name in skeleton.joint_names if dof.startswith(name))
    length = np.linalg.norm(skeleton.offsets[skeleton.joint_names.index(joint)])
    angles = motion.angles.copy()
    angles[frames, skeleton.dof_names.index(dof)] -= np.arcsin(size / length)
    return replace(motion, angles=angles)


def assert_moves_little(motion, frames, size, dof):
    """No event moves by more than a frame, or comes, or goes, where a part is too high in some frames."""
    expected, found = gait_events(motion), gait_events(with_spike(motion, frames, size, dof))
    assert found.kinds.tolist() == expected.kinds.tolist(), (frames, dof)
    assert found.feet.tolist() == expected.feet.tolist(), (frames, dof)
    assert np.abs(found.times - expected.times).max() * motion.frame_rate < 1.0, (frames, dof)


def some_frames(motion, every):
    last = len(motion) - 1
    return sorted({*range(0, last, every), 1, 2, last - 2, last - 1, last})


@pytest.mark.parametrize("size", [-0.1, -0.02, 0.02, 0.1])
def test_a_spike_in_one_frame_moves_no_event_by_more_than_a_frame(size):
    motion = walk(duration=3.0)
    for frame in some_frames(motion, 11):
        for dof in ("left_foot_rotvec_x", None):
            assert_moves_little(motion, frame, size, dof)


@pytest.mark.slow
@pytest.mark.parametrize("size", [-0.06, -0.02, 0.02])
@pytest.mark.parametrize("trial", ["07_05", "35_01", "35_30"])
def test_a_spike_in_a_recording_moves_no_event_by_more_than_a_frame(cmu, trial, size):
    motion = recording(cmu, trial)
    for frame in some_frames(motion, 7):
        for dof in ("lfoot_rx", "rfoot_rx", None):
            assert_moves_little(motion, frame, size, dof)


def recording(cmu, trial):
    (i,) = np.flatnonzero((cmu.subjects == trial[:2]) & (cmu.trials == trial[3:]))
    return cmu[int(i)]


@pytest.mark.slow
@pytest.mark.parametrize("trial", ["02_01", "02_03", "07_05", "09_06"])
def test_the_height_of_the_floor_is_that_of_most_frames(cmu, trial):
    """A toe that is too low for 40 ms in the middle of a stance does not lift the foot off, which is on its way up."""
    motion = recording(cmu, trial)
    events = gait_events(motion)
    for side in ("left", "right"):
        of_side = events.feet == side
        contacts, offs = (events.frames[of_side & (events.kinds == kind)] for kind in ("foot contact", "foot off"))
        for contact in contacts:
            if (offs > contact).any():
                middle = (contact + offs[offs > contact][0]) // 2
                assert_moves_little(motion, np.arange(middle - 2, middle + 3), -0.03, f"{side[0]}foot_rx")


def test_times_are_those_of_the_motion():
    motion = walk()
    late = replace(motion, frame_numbers=motion.frame_numbers + 500)
    expected, found = gait_events(motion), gait_events(late)
    np.testing.assert_allclose(found.times, expected.times + 5.0, atol=1e-9)
    np.testing.assert_array_equal(found.frames, expected.frames)


def test_names_of_joints_may_be_given():
    motion = walk()
    names = {name: f"b{i}" for i, name in enumerate(SKELETON.joint_names)}
    bones = [
        bone._replace(name=names[bone.name], parent=None if bone.parent is None else names[bone.parent])
        for bone in SKELETON.bones
    ]
    unknown = replace(motion, skeleton=Skeleton(bones))
    with pytest.raises(ValueError, match=r"of no rig that is known and shows no left_hip, .*pass joints="):
        gait_events(unknown)
    marks = {f"{side}_{part}": names[f"{side}_{part}"] for side in ("left", "right") for part in ("hip", "ankle")}
    marks |= {f"{side}_toe": names[f"{side}_foot"] for side in ("left", "right")}
    expected, found = gait_events(motion), gait_events(unknown, joints=marks)
    np.testing.assert_array_equal(found.times, expected.times)
    assert found.joints == marks
    with pytest.raises(ValueError, match=r"joints must have keys among 'left_hip'.*got 'heel'"):
        gait_events(motion, joints={"heel": "left_foot"})
    with pytest.raises(ValueError, match=r"joints has 'left_fot' as 'left_toe', which is no joint.*'left_foot'"):
        gait_events(motion, joints={"left_toe": "left_fot"})
    with pytest.raises(ValueError, match="must be different joints, but left_ankle and left_toe are 'left_foot'"):
        gait_events(motion, joints={"left_ankle": "left_foot"})
    with pytest.raises(ValueError, match="joints= is for a Motion"):
        gait_parameters(expected, joints=marks)


OF_FEET = [(f"{side}_{part}", f"{other}_{name}") for side, other in (("left", "right"), ("right", "left"))
           for part, name in (("ankle", "ankle"), ("toe", "foot"))]  # fmt: skip


@pytest.mark.parametrize("measure", [gait_events, gait_parameters])
@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (dict(OF_FEET), "left_toe is 'right_foot' and right_ball is 'right_foot' by its name: expected two joints"),
        (
            {f"{side}_ankle": f"{other}_ankle" for side, other in (("left", "right"), ("right", "left"))},
            "expected the ankle below the ",
        ),
        ({"left_toe": "left_hand"}, "expected the toe below the ankle of its side"),
    ],
    ids=["sides", "ankles", "hand"],
)
def test_joints_that_are_no_persons_are_refused(measure, joints, message):
    """Left for right changes the foot of each event, and a hand for a toe when it leaves the floor: without a word."""
    motion = walk()
    skeleton = motion.skeleton
    if "left_hand" in joints.values() and "left_hand" not in skeleton.joint_names:
        hand = skeleton.bones[0]._replace(name="left_hand", parent=None, offset=(0.3, 0.2, 0.0), dofs="")
        motion = replace(motion, skeleton=Skeleton([*skeleton.bones, hand]))
    with pytest.raises(ValueError, match=message):
        measure(motion, joints=joints)


@pytest.mark.parametrize("scale", [0.1, 60.0])
def test_legs_that_are_no_persons_are_a_warning(scale):
    motion = walk()
    bones = [bone._replace(offset=tuple(scale * np.array(bone.offset))) for bone in motion.skeleton.bones]
    other = replace(motion, skeleton=Skeleton(bones), root_positions=scale * motion.root_positions)
    with pytest.warns(UserWarning, match=r"legs of .* m from hip to ankle are no person's, .*another scale="):
        gait_events(other)


def test_what_shows_no_gait_is_refused():
    motion = walk()
    with pytest.raises(ValueError, match=r"at least 25 Hz.*the motion has 20 Hz"):
        gait_events(motion[::5])
    with pytest.raises(ValueError, match=r"all root_positions of the motion are one.*treadmill.*belt_velocity"):
        gait_events(replace(motion, root_positions=None))
    with pytest.raises(ValueError, match=r"motion.up is 'z', but in nearly all frames .* along y\..*dataclasses"):
        gait_events(replace(motion, up="z"))
    with pytest.raises(ValueError, match="got a motion of 1 frames"):
        gait_events(motion[:1])
    with pytest.raises(TypeError, match=r"motion must be a skpose\.Motion, got ndarray"):
        gait_events(motion.angles)


def test_a_treadmill_is_refused_until_the_belt_is_added():
    """The pelvis sways a little where it is."""
    motion = walk()
    belt = np.array([0.0, 0.0, 1.1])
    sway = 0.02 * np.sin(motion.times)[:, None] * [1.0, 0.0, 0.0]
    treadmill = replace(motion, root_positions=motion.root_positions - np.outer(motion.times, belt) + sway)
    events = gait_events(treadmill)
    assert len(events) == 0
    assert "On a treadmill add what the belt moves" in repr(events)
    with pytest.raises(ValueError, match="at least one stride of walking or running, got none: the pelvis moves"):
        gait_parameters(treadmill)
    restored = replace(treadmill, root_positions=treadmill.root_positions + np.outer(treadmill.times, belt))
    assert mean_of(gait_parameters(restored), "cadence") == pytest.approx(110.0, abs=0.3)


def feet_together(duration=6.0, rate=100.0, travel=1.0):
    """Hops on both legs, at 1 m/s: the legs fold and stretch, the feet swing forward in the air."""
    motion = walk(duration=duration, rate=rate)
    angles = motion.angles.copy()
    angles[:, 9:] = angles[:, :9]  # the right leg does what the left one does
    return replace(motion, angles=angles, root_positions=travel * motion.root_positions)


def still(n=300):
    return Motion(SKELETON, np.zeros((n, SKELETON.n_dofs)), 100, np.linspace([0, 0.9, 0], [0, 0.9, 0.3], n))


def squats():
    n = 600
    depth = np.sin(np.arange(n) / 100 * np.pi) ** 2
    angles = np.zeros((n, 18))
    for first in (0, 9):
        angles[:, first], angles[:, first + 3], angles[:, first + 6] = -1.2 * depth, 2.2 * depth, -1.0 * depth
    drop = 0.9 * (1 - np.cos(1.1 * depth))
    return Motion(SKELETON, angles, 100, np.stack([0 * depth, 0.9 - drop, 0.1 * depth], axis=1))


def noise(seed, wander):
    rng = np.random.default_rng(seed)
    angles = rng.normal(scale=0.3, size=(600, 18))
    root = np.cumsum(rng.normal(scale=wander, size=(600, 3)), axis=0) * [1, 0, 1]
    return Motion(SKELETON, angles, 100, root)


def smooth_noise(seed):
    """Legs that swing slowly and at random while the pelvis glides."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(scale=0.5, size=(8, 18)) / np.arange(1, 9)[:, None]
    phases = rng.uniform(0, 2 * np.pi, size=(8, 18))
    t = np.arange(600)[:, None, None] / 600
    angles = (waves * np.sin(2 * np.pi * np.arange(1, 9)[:, None] * t + phases)).sum(axis=1)
    return Motion(SKELETON, angles, 100, np.linspace([0, 0.9, 0], [0, 0.9, 6], 600))


CONTROLS = {
    "standing": still(),
    "squats": squats(),
    "hops": feet_together(),
    "steps on the spot": replace(walk(), root_positions=0.1 * walk().root_positions),
    "noise": noise(0, 0.0001),
    "noise that wanders": noise(1, 0.02),
    **{f"smooth noise {seed}": smooth_noise(seed) for seed in range(12)},
    "backwards": walk(facing=np.pi),
    "sideways": walk(facing=np.pi / 2, step=0.4),
    "too short": walk(duration=1.0),
}


def test_small_turns_of_the_pelvis_are_gait():
    assert mean_of(gait_parameters(walk(facing=0.5, step=0.5)), "cadence") == pytest.approx(110.0, abs=0.2)


@pytest.mark.parametrize("facing", [np.pi, np.pi / 2])
def test_the_reason_names_the_direction(facing):
    reason = gait_events(walk(facing=facing, step=0.4)).reason
    assert reason == f"the feet move in a direction {np.degrees(facing):.0f}° away from that in which the pelvis faces"


@pytest.mark.parametrize("name", CONTROLS)
def test_what_is_no_gait_has_no_events(name):
    events = gait_events(CONTROLS[name])
    assert len(events) == len(events.strides) == 0
    assert events.reason
    assert len(events.to_pandas()) == 0
    with pytest.raises(ValueError, match="at least one stride"):
        gait_parameters(events)


def test_walking_between_standing_is_found_alone():
    motion = walk(duration=4.0)
    rows = np.concatenate([np.zeros(200, int), np.arange(len(motion)), np.full(200, len(motion) - 1)])
    stops = replace_frames(motion, rows, np.arange(len(rows)))
    found = gait_parameters(stops)
    assert found.events.times[0] >= 2.0
    assert found.events.times[-1] <= 6.1
    middle = found.starts[(found.starts > 3.0) & (found.starts < 4.5)]
    assert len(middle) >= 2
    assert found.cadence[np.isin(found.starts, middle)] == pytest.approx(110.0, abs=0.5)


def test_other_rigs_are_known():
    names = gait_events(Motion(humanoid(), np.zeros((60, 42)), 60, np.linspace([0, 0, 0], [0, 0, 1], 60))).joints
    assert names["left_ankle"] == "left_shank"
    assert names["left_toe"] == "left_foot"  # where the toes begin, not their end


@pytest.mark.slow
def test_recordings_of_walks_and_runs(cmu):
    for motion, action in zip(cmu, cmu.actions, strict=True):
        if action not in ("walk", "run/jog"):
            continue
        found = gait_parameters(motion)
        stance, cadence = mean_of(found, "stance"), mean_of(found, "cadence")
        if action == "walk":
            assert 57.0 < stance < 65.0
            assert 75.0 < cadence < 125.0
            assert 0.6 < mean_of(found, "step_length") < 0.85
            assert mean_of(found, "double_support") > 10.0
        elif action == "run/jog":
            assert 30.0 < stance < 40.0
            assert 145.0 < cadence < 175.0
            assert mean_of(found, "double_support") == 0.0


@pytest.mark.slow
def test_recordings_of_other_actions_have_no_gait(cmu, hdm05):
    for dataset, actions in ((cmu, {"walk", "run/jog", "run", "walk on uneven terrain"}), (hdm05, {"jog in a circle"})):
        for k, (motion, action) in enumerate(zip(dataset, dataset.actions, strict=True)):
            if dataset is cmu and (cmu.subjects[k], cmu.trials[k]) == ("03", "02"):  # is still, and jumps by 11 cm
                with pytest.raises(ValueError, match=r"Cut the motion there, motion\[:24\] and motion\[24:\]"):
                    gait_events(motion)
                motion = motion[24:]
            assert (len(gait_events(motion).strides) > 0) == (action in actions), action
