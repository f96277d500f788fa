"""The root of a mean motion: where it is known, what it does not depend on, and which motions have none."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import random_tree
from scipy.spatial.transform import Rotation

from skpose import Motion
from skpose.motions import mean_motion

AXIS = {"x": 0, "y": 1, "z": 2}
TREE = random_tree(3, kinds=["xyz", "z"])


def rotation_about(up, angle):
    return Rotation.from_rotvec(np.multiply.outer(angle, np.eye(3)[AXIS[up]]))


def orientations(motion):
    return Rotation.from_euler(motion.root_axes, motion.root_angles)


def walk(up="y", n=21, seed=0, lying=False, axes="ZXY"):
    """A motion in a curve on the floor, that tilts; with bones along the floor at angle zero if it is lying."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, n)
    angles = np.sin(3 * t[:, None] + rng.normal(size=TREE.n_dofs))
    tilt = Rotation.from_rotvec(0.3 * np.stack([np.sin(5 * t), np.cos(4 * t), np.sin(3 * t)], axis=1))
    rest = Rotation.from_euler("z", np.pi if lying else 0.0)  # upside down: there is no heading
    root = rotation_about(up, 0.8 * t) * tilt * rest
    places = np.stack([np.sin(t), t**2, np.cos(2 * t)], axis=1)
    return Motion(TREE, angles, 30, places, root.as_euler(axes), axes, up=up, root_name="Hips")


def moved(motion, turn, shift):
    """The motion elsewhere on the floor, headed elsewhere."""
    turned = rotation_about(motion.up, turn)
    shift = np.where(np.arange(3) == AXIS[motion.up], 0.0, shift)
    root = (turned * orientations(motion)).as_euler(motion.root_axes)
    return replace(motion, root_positions=turned.apply(motion.root_positions) + shift, root_angles=root)


def heading_of(rotation, up):
    return 2 * np.arctan2(*rotation.as_quat()[[AXIS[up], 3]])


@pytest.mark.parametrize(("up", "lying"), [("y", False), ("z", False), ("y", True)])
def test_the_mean_of_one_walk_in_many_places_is_that_walk(up, lying):
    """Places and headings of the recordings do not matter; heights and tilts are those of the walk."""
    motion = walk(up, lying=lying)
    rng = np.random.default_rng(0)
    copies = [moved(motion, turn, rng.normal(scale=9, size=3)) for turn in (0.0, 1.0, 2.5, -2.9)]
    mean = mean_motion(copies)
    found = mean.to_motion()
    assert (found.up, found.root_axes, found.root_name) == (mean.up, mean.root_axes, "Hips") == (up, "ZXY", "Hips")
    # It is the walk, moved along the floor and rotated about the vertical, to above the origin.
    turn = heading_of(orientations(found)[0] * orientations(motion)[0].inv(), up)
    expected = moved(motion, turn, np.zeros(3))
    np.testing.assert_allclose((orientations(found) * orientations(expected).inv()).magnitude(), 0.0, atol=1e-7)
    from_start = expected.root_positions - expected.root_positions[0]
    np.testing.assert_allclose(found.root_positions - found.root_positions[0], from_start, atol=1e-9)
    floor = np.delete(np.arange(3), AXIS[up])
    np.testing.assert_allclose(found.root_positions[0, floor], 0.0, atol=1e-12)
    np.testing.assert_allclose(found.root_positions[:, AXIS[up]], motion.root_positions[:, AXIS[up]], atol=1e-12)
    np.testing.assert_array_equal(found.root_positions, mean.root_positions)
    np.testing.assert_array_equal(found.root_angles, mean.root_angles)


def test_a_mean_that_travels_goes_straight_ahead_and_others_begin_with_heading_zero():
    """The pelvis rotates by 10° to both sides of the direction of travel, and begins on one side."""
    t = np.linspace(0, 1, 21)
    root = rotation_about("y", 0.7 + np.radians(10) * np.cos(2 * np.pi * t)).as_euler("ZXY")
    ahead = Rotation.from_euler("y", 0.7).apply([0.0, 0.0, 1.0])
    stride = Motion(TREE, walk().angles, 30, t[:, None] * ahead, root, "ZXY")
    for length, direction, begins in ((1.4, 0.0, 10.0), (0.3, -10.0, 0.0)):
        motion = replace(stride, root_positions=length * stride.root_positions)
        found = mean_motion([motion, moved(motion, 2.0, np.ones(3))]).to_motion()
        x, _, z = found.root_positions[-1] - found.root_positions[0]
        assert np.degrees(np.arctan2(x, z)) == pytest.approx(direction, abs=1e-6)
        assert np.degrees(heading_of(orientations(found)[0], "y")) == pytest.approx(begins, abs=1e-6)


def test_each_motion_counts_the_same_in_each_frame():
    """One of two walks pauses: its frames of the pause are one place, not eight of nine."""
    slow, fast = walk(), walk()
    rows = np.r_[np.arange(10), np.full(8, 10), np.arange(10, len(slow))]
    far = 2 * slow.root_positions
    slow = replace(
        slow,
        angles=slow.angles[rows],
        root_positions=far[rows],
        root_angles=slow.root_angles[rows],
        frame_numbers=None,
    )
    found = mean_motion([fast, fast, slow]).to_motion()
    assert len(found) == len(fast)
    turn = heading_of(orientations(found)[0] * orientations(fast)[0].inv(), "y")
    expected = 4 / 3 * moved(fast, turn, np.zeros(3)).root_positions
    np.testing.assert_allclose(np.diff(found.root_positions, axis=0), np.diff(expected, axis=0), atol=1e-6)


def test_worlds_that_differ_are_refused():
    with pytest.raises(ValueError, match="up"):
        mean_motion([walk(), walk("z")])
    one, other = walk().with_root("tilt"), walk().with_root("whole")
    with pytest.raises(ValueError, match="root axes"):
        mean_motion([one, one, other])
    for part in ("tilt", "whole"):
        motions = [walk().with_root(part), moved(walk(), 1.0, np.ones(3)).with_root(part)]
        mean_motion(motions if part == "tilt" else motions[:1] * 2)
    mixed = [walk(), replace(walk(), root_axes="y", root_angles=walk().root_angles[:, :1])]
    mean_motion(mixed)  # nothing of the root is in the poses


def test_of_arrays_nothing_is_known_of_the_root():
    mean = mean_motion([walk().angles] * 2, skeleton=TREE)
    assert (mean.root_positions, mean.root_angles, mean.up) == (None, None, None)
    assert repr(mean).startswith("MeanMotion(21 frames, root unknown, ")
    motion = mean.to_motion(30)
    assert not motion.root_positions.any()
    assert not motion.root_angles.any()
    assert (motion.up, motion.root_name) == ("y", "root")
    assert repr(mean_motion([walk("z")] * 2)).startswith("MeanMotion(21 frames, z up, ")
