"""Cycles: closing and repeating motions."""

from dataclasses import replace

import numpy as np
import pytest
import reference
from conftest import MIXED, random_tree
from scipy.spatial.transform import Rotation

from skpose import Motion

AXIS = {"x": 0, "y": 1, "z": 2}
TREES = {frame: random_tree(4, kinds=MIXED, offset_frame=frame) for frame in ("own", "parent")}
TURN, PERIOD = 0.7, 40
FAR_OFF = pytest.mark.filterwarnings("ignore:the cycle ends")  # these movements have frames that are far apart


def up_vector(up):
    return np.eye(3)[AXIS[up]]


def world(motion):
    """Positions of the root and of the joints, by the reference."""
    turned = Rotation.from_euler(motion.root_axes, motion.root_angles).as_matrix()
    joints = reference.forward_kinematics(motion.angles, motion.skeleton)
    joints = np.einsum("nab,njb->nja", turned, joints) + motion.root_positions[:, None]
    return np.concatenate([motion.root_positions[:, None], joints], axis=1)


def orientations(motion):
    return Rotation.from_euler(motion.root_axes, motion.root_angles)


def turned(turn, up, points):
    return Rotation.from_rotvec(turn * up_vector(up)).apply(points)


def periodic(skeleton, up="y", n=PERIOD + 1, turn=TURN, seed=0, size=0.25):
    """A movement that repeats after 40 frames in a curve on the floor, to rounding, from its first frame on."""
    rng = np.random.default_rng(seed)
    phase = 2 * np.pi * np.arange(n) / PERIOD
    a, b = size * rng.normal(size=(2, skeleton.n_dofs))
    angles = np.sin(phase[:, None] + a) * b
    tilt = Rotation.from_rotvec(0.3 * np.stack([np.sin(phase), np.cos(phase), np.sin(2 * phase)], axis=1))
    heading = turn * np.arange(n) / PERIOD
    root = Rotation.from_rotvec(heading[:, None] * up_vector(up)) * tilt
    # Once around a point in 2π / turn cycles, each time with the same sway as seen from the heading.
    centre, sway = np.zeros(3), 0.1 * np.stack([np.sin(phase), np.sin(phase + 1), np.cos(phase)], axis=1)
    centre[(AXIS[up] + 1) % 3] = 2.0
    places = Rotation.from_rotvec(heading[:, None] * up_vector(up)).apply(sway + centre)
    return Motion(skeleton, angles, 30, places, root.as_euler("ZXY"), "ZXY", up=up, root_name="Hips")


def test_a_root_that_turns_about_one_axis_keeps_it():
    motion = periodic(TREES["own"])
    flat = replace(motion, root_angles=np.linspace(0.0, TURN, len(motion))[:, None], root_axes="y")
    for cycle in (flat.to_cycle(endpoint=True), flat.to_cycle(endpoint=True).repeat(2)):
        assert cycle.root_axes == "y"
        np.testing.assert_allclose(cycle.root_angles[: len(flat)], flat.root_angles, atol=1e-9)


@pytest.mark.parametrize("frame", TREES)
@pytest.mark.parametrize("up", AXIS)
def test_a_cycle_repeated_is_the_movement_that_goes_on(frame, up):
    """Repetitions of one period are the frames that follow it, all joints in the world."""
    cycle, expected = periodic(TREES[frame], up), periodic(TREES[frame], up, 3 * PERIOD + 1)
    found = cycle.repeat(3)
    np.testing.assert_allclose(world(found), world(expected), atol=1e-9)
    np.testing.assert_array_equal(found.frame_numbers, expected.frame_numbers)
    assert (found.up, found.root_axes, found.root_name, found.frame_rate) == (up, "ZXY", "Hips", 30)
    assert np.abs(np.diff(found.angles, axis=0)).max() < 0.5
    assert np.abs(np.diff(found.root_angles, axis=0)).max() < 2.0  # near gimbal lock where x is up; no jumps by 2π
    # Closing what is closed changes nothing, and the frame that a slice lacks is found again.
    np.testing.assert_allclose(world(cycle.to_cycle(endpoint=True)), world(cycle), atol=1e-9)
    np.testing.assert_allclose(world(cycle[:-1].to_cycle()), world(cycle), atol=0.03)


@FAR_OFF
@pytest.mark.parametrize("up", AXIS)
@pytest.mark.parametrize("frame", TREES)
def test_closing_distributes_the_gap_and_keeps_travel(frame, up):
    rng = np.random.default_rng(1)
    motion = periodic(TREES[frame], up)
    drift = np.linspace(0, 1, len(motion))[:, None]
    angles = motion.angles + drift * 0.1 * rng.normal(size=motion.skeleton.n_dofs)
    places = motion.root_positions + 0.2 * drift * up_vector(up)
    tilted = orientations(motion) * Rotation.from_rotvec(drift * [0.1, -0.05, 0.07])
    motion = replace(motion, angles=angles, root_positions=places, root_angles=tilted.as_euler("ZXY"))
    cycle = motion.to_cycle(endpoint=True)
    # The last frame is the first one, rotated about the vertical and moved along the floor.
    first, last = world(cycle)[[0, -1]]
    turn = 2 * np.arctan2(*(orientations(cycle)[-1] * orientations(cycle)[0].inv()).as_quat()[[AXIS[up], 3]])
    np.testing.assert_allclose(last - last[0], turned(turn, up, first - first[0]), atol=1e-12)
    assert last[0, AXIS[up]] == pytest.approx(first[0, AXIS[up]], abs=1e-12)
    # Place and heading: those of the motion.
    before = 2 * np.arctan2(*(tilted[-1] * tilted[0].inv()).as_quat()[[AXIS[up], 3]])
    assert turn == pytest.approx(before, abs=0.02)
    floor = np.delete(np.arange(3), AXIS[up])
    np.testing.assert_allclose(cycle.root_positions[:, floor], places[:, floor], atol=1e-12)
    # Heights change linearly, and no frame by more than half of what was left.
    np.testing.assert_allclose(
        cycle.root_positions[:, AXIS[up]] - places[:, AXIS[up]], 0.1 - 0.2 * drift[:, 0], atol=1e-12
    )
    changes = (orientations(motion).inv() * orientations(cycle)).magnitude()
    left = (orientations(motion)[-1].inv() * Rotation.from_rotvec(turn * up_vector(up)) * tilted[0]).magnitude()
    np.testing.assert_allclose(changes, np.abs(drift[:, 0] - 0.5) * left, atol=1e-9)
    assert left > 0.05


def test_only_cycles_are_repeated():
    cycle = periodic(TREES["own"], size=0.3)
    column = cycle.angles.copy()
    column[:, 0] += np.linspace(0, 0.1, len(cycle))
    name = cycle.skeleton.dof_names[0]
    with pytest.raises(ValueError, match=f"{name} differs by 0.1 rad"):
        replace(cycle, angles=column).repeat(2)
    higher = cycle.root_positions + np.linspace(0, 1, len(cycle))[:, None] * [0, 0.1, 0]
    with pytest.raises(ValueError, match="height of the root"):
        replace(cycle, root_positions=higher).repeat(2)
    with pytest.raises(ValueError, match="repeat needs a cycle"):
        cycle[:-1].repeat(2)  # ends a frame before
    with pytest.raises(ValueError, match="3 frames"):
        cycle[:2].to_cycle()


def test_incomplete_cycles_warn():
    cycle = periodic(TREES["own"], n=2 * PERIOD + 1)
    with pytest.warns(UserWarning, match="the last pose is the first one again.*pass endpoint=True") as caught:
        cycle[: PERIOD + 1].to_cycle()
    assert len(caught) == 1
    assert caught[0].filename == __file__
    for stop in (PERIOD - 8, PERIOD + 8):
        with pytest.warns(UserWarning, match="not one whole cycle"):
            cycle[:stop].to_cycle()
