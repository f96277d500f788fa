"""Gait events and parameters of synthetic walkers, other movements and recordings."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from walkers import SKELETON, rotation_about, walk

from skpose import Motion, Skeleton
from skpose.biomechanics import gait_events, gait_parameters
from skpose.io import C3DQuantity

OFF_BY = 0.012  # s, at 100 Hz: a foot that stops at once is slow that much before it stands, after the filter


def mean_of(parameters, quantity, foot="both"):
    values = parameters.values[quantity]
    return np.nanmean(values if foot == "both" else values[parameters.feet == foot])


def errors(events, kind, foot, stride, share):
    """Times (s) by which events of a foot are off the nearest time k + share, in strides."""
    times = events.times[(events.feet == foot) & (events.kinds == kind)] / stride - share
    return (times - np.rint(times)) * stride


@pytest.mark.parametrize(
    "known",
    [
        {},
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


def test_tables_are_of_the_strides():
    found = gait_parameters(walk(phase=0.45))
    table = found.to_pandas()
    assert len(table) == len(found) == len(found.events.strides)
    assert list(table["foot"]) == list(found.feet)
    for name in table.columns[2:]:
        np.testing.assert_array_equal(table[name], found.values[name.split()[0]])
    events = found.events.to_pandas()
    assert list(events.columns) == ["foot", "event", "frame", "time [s]"]
    assert len(events) == len(found.events)
    assert repr(found).startswith("GaitParameters(")
    assert "steps/min" in repr(found)
    assert "100 Hz, y up" in repr(found)


@pytest.mark.parametrize("up", ["x", "y", "z"])
@pytest.mark.parametrize("heading", [0.0, 2.5])
def test_figures_are_the_same_in_every_direction_of_every_world(up, heading):
    expected = gait_parameters(walk(phase=0.46)).to_pandas()
    found = gait_parameters(walk(phase=0.46, up=up, heading=heading)).to_pandas()
    assert (found["foot"] == expected["foot"]).all()
    numbers = expected.columns[1:]
    np.testing.assert_allclose(found[numbers], expected[numbers], atol=1e-6)


def jump_of(motion, frame, metres=0.0, degrees=0.0):
    """The motion, in which from a frame on the person is elsewhere, or faces elsewhere."""
    after = np.arange(len(motion)) >= frame
    place, turned = motion.root_positions[frame], rotation_about([0.0, 1.0, 0.0], np.radians(degrees) * after)
    root = turned * Rotation.from_euler(motion.root_axes, motion.root_angles)
    moved = place + turned.apply(motion.root_positions - place) + np.outer(metres * after, [0.6, 0.0, 0.8])
    return replace(motion, root_positions=moved, root_angles=root.as_euler("xzy"), root_axes="xzy")


@pytest.mark.parametrize("rate", [50.0, 250.0])
@pytest.mark.parametrize("frame", [1, 100])
def test_a_jump_of_the_pelvis_is_refused(rate, frame):
    """Nobody moves by more than 12 m/s, or turns by more than 2,200°/s."""
    motion = walk(duration=3.0, rate=rate)
    for jump in ({"metres": 12.0 / rate + 0.06}, {"degrees": 2200.0 / rate + 20.0}):
        with pytest.raises(ValueError, match=rf"motion\[:{frame + 1}\]"):
            gait_events(jump_of(motion, frame + 1, **jump))
        gait_events(jump_of(motion, frame + 1, **{name: 0.5 * size for name, size in jump.items()}))


@pytest.mark.parametrize(
    ("known", "rate", "words"),
    [
        ({}, 230.0, "253 steps/min"),
        ({"step": 0.9, "cadence": 165.0, "stance": 0.35}, 200.0, "steps/min"),
        ({"step": 0.9, "cadence": 165.0, "stance": 0.35}, 170.0, None),
        ({}, 50.0, "half the true one"),
        ({}, 198.0, "twice the true one"),
        ({}, 120.0, None),
    ],
)
def test_impossible_cadence_warns(known, rate, words):
    """Of a walk at 100 Hz that is said to have another frame rate."""
    other = replace(walk(**known), frame_rate=rate)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gait_parameters(other)
    assert len(caught) == (words is not None)
    if words is not None:
        assert re.search(words, str(caught[0].message))


OF_FEET = [(f"{side}_{part}", f"{other}_{name}") for side, other in (("left", "right"), ("right", "left"))
           for part, name in (("ankle", "ankle"), ("toe", "foot"))]  # fmt: skip


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (dict(OF_FEET), "joints"),
        (
            {f"{side}_ankle": f"{other}_ankle" for side, other in (("left", "right"), ("right", "left"))},
            "ankle",
        ),
        ({"left_toe": "left_hand"}, "'left_hand' does not come after 'left_ankle'"),
    ],
    ids=["sides", "ankles", "hand"],
)
def test_impossible_joints_are_refused(joints, message):
    """Left for right changes the foot of each event, and a hand for a toe when it leaves the floor: without a word."""
    motion = walk()
    skeleton = motion.skeleton
    if "left_hand" in joints.values() and "left_hand" not in skeleton.joint_names:
        hand = skeleton.bones[0]._replace(name="left_hand", parent=None, offset=(0.3, 0.2, 0.0), dofs="")
        motion = replace(motion, skeleton=Skeleton([*skeleton.bones, hand]))
    with pytest.raises(ValueError, match=message):
        gait_events(motion, joints=joints)


def test_unsuitable_recordings_are_refused():
    motion = walk()
    with pytest.raises(ValueError, match="25 Hz"):
        gait_events(motion[::5])
    with pytest.raises(ValueError, match="root_positions"):
        gait_events(replace(motion, root_positions=None))
    with pytest.raises(ValueError, match=r"motion.up is 'z'"):
        gait_events(replace(motion, up="z"))
    with pytest.raises(ValueError, match="1 frames"):
        gait_events(motion[:1])
    with pytest.raises(TypeError, match="motion must be a Motion"):
        gait_events(motion.angles)


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
    "smooth noise": smooth_noise(0),
    "backwards": walk(facing=np.pi),
    "sideways": walk(facing=np.pi / 2, step=0.4),
    "too short": walk(duration=1.0),
}


@pytest.mark.parametrize("name", CONTROLS)
def test_other_movements_have_no_events(name):
    events = gait_events(CONTROLS[name])
    assert len(events) == len(events.strides) == 0
    assert events.reason
    assert len(events.to_pandas()) == 0
    with pytest.raises(ValueError, match="at least one stride"):
        gait_parameters(events)


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


def known_events(stride=120 / 110, stance=0.62, duration=6.0):
    """The events of `walk`, s."""
    numbers = np.arange(1, int(duration / stride) - 1)
    return {
        f"{foot} foot {kind}": (numbers + lag + share) * stride
        for foot, lag in (("left", 0.0), ("right", 0.5))
        for kind, share in (("contact", 0.0), ("off", stance))
    }


@pytest.mark.parametrize("form", ["times", "frames", "of a C3D file"])
def test_known_events_are_taken_as_they_are(form):
    motion, known = walk(), known_events()
    expected = np.sort(np.concatenate([*known.values()]))
    if form == "frames":
        known = {name: np.rint(times * 100).astype(int) for name, times in known.items()}
        expected = np.rint(expected * 100) / 100
    elif form == "of a C3D file":
        names = {"contact": "Strike", "off": "Off"}
        known = {
            " ".join([foot.title(), "Foot", names[kind]]): C3DQuantity("events", "s", times)
            for (foot, _, kind), times in ((name.split(), times) for name, times in known.items())
        }
        known["LKneeAngles"] = C3DQuantity("angles", "deg", np.zeros((len(motion), 3)))
    events = gait_events(motion, events=known)
    np.testing.assert_allclose(events.times, expected, atol=1e-9)
    found = gait_parameters(events)
    assert len(found) == 4
    assert mean_of(found, "stance") == pytest.approx(62.0, abs=0.01 if form != "frames" else 1.0)
    assert mean_of(found, "step_length") == pytest.approx(0.6, abs=2e-3)


@pytest.mark.filterwarnings("ignore:step length over cadence:UserWarning")
def test_known_events_of_short_strides():
    """Strides as short as these are not detected, as they could be steps on the spot."""
    motion = walk(step=0.1)
    assert not len(gait_events(motion).strides)
    found = gait_parameters(gait_events(motion, events=known_events()))
    assert mean_of(found, "step_length") == pytest.approx(0.1, abs=2e-3)


def test_known_events_of_one_foot_and_names():
    events = gait_events(walk(), events={"RHS": [1.0, 2.0], "RTO": [1.6]})
    assert events.to_pandas()["event"].tolist() == ["foot contact", "foot off", "foot contact"]
    assert not len(events.strides)
    with pytest.raises(ValueError, match="left foot contact"):
        gait_events(walk(), events={"heel": [1.0]})
    contacts = gait_events(walk(), events={"Left Touchdown": [1.0, 2.0, 99.0], "Right Toe Strike": [1.5], "LTO": [1.7]})
    assert contacts.kinds[contacts.times == 1.5].tolist() == ["foot contact"]
    assert contacts.times.max() == 2.0  # 99 s is after the end


def test_a_foot_that_is_not_seen_lacks_its_events():
    motion = walk()
    seen = np.ones((len(motion), motion.skeleton.n_joints), bool)
    seen[200:290, motion.skeleton.joint_names.index("left_foot")] = False
    seen[400:405] = False  # a short gap is interpolated
    whole, part = gait_events(motion), gait_events(replace(motion, seen=seen))
    lost = (whole.feet == "left") & (whole.times > 2.0) & (whole.times < 2.9)
    assert lost.sum() == 2
    np.testing.assert_allclose(part.times, whole.times[~lost], atol=2e-3)
    assert 3 < len(part.strides) < len(whole.strides)


def test_a_short_walk_has_the_events_of_a_step():
    events = gait_events(walk(duration=1.3))
    assert np.count_nonzero(events.kinds == "foot contact") == 2
    assert not len(events.strides)
    assert "three contacts" in events.reason
