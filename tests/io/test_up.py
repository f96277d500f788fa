"""The axis that points up: the one that is stated, else the usual one, with a warning where people stand otherwise."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import in_space
from scipy.spatial.transform import Rotation

from skpose import Motion
from skpose.datasets import humanoid, make_gait
from skpose.io import load_bvh, save_bvh

GAIT = make_gait(1, 1, frame_rate=12, duration=2, random_state=0).motions[0]
# What takes y to each direction, without a reflection.
TURNS = {
    "x": Rotation.from_euler("z", -90, degrees=True),
    "y": Rotation.identity(),
    "z": Rotation.from_euler("x", 90, degrees=True),
    "-x": Rotation.from_euler("z", 90, degrees=True),
    "-y": Rotation.from_euler("z", 180, degrees=True),
    "-z": Rotation.from_euler("x", -90, degrees=True),
}


def turned(motion, turn):
    """The motion in a world that is turned."""
    root = turn * Rotation.from_euler(motion.root_axes, motion.root_angles)
    positions = turn.apply(motion.root_positions)
    return replace(motion, root_positions=positions, root_angles=root.as_euler("ZYX"), root_axes="ZYX")


@pytest.fixture
def write(tmp_path):
    def write(motion):
        path = tmp_path / "a.bvh"
        path.unlink(missing_ok=True)
        save_bvh(path, motion)
        return path

    return write


@pytest.mark.parametrize("up", ["x", "z", "-y"])
def test_another_axis_is_named_by_a_warning(up, write):
    path = write(turned(GAIT, TURNS[up]))
    with pytest.warns(UserWarning, match=f"up='{up}'"):
        load_bvh(path)
    assert load_bvh(path, up=up).up == up[-1]


def test_nothing_is_said_of_people_who_stand_or_hold_their_arms_out(write):
    skeleton = humanoid()
    arms = np.zeros((3, skeleton.n_dofs))
    assert load_bvh(write(GAIT)).up == "y"
    assert load_bvh(write(Motion(skeleton, arms, 30))).up == "y"


@pytest.mark.parametrize("up", TURNS)
def test_the_world_is_the_same_however_it_is_turned(up, write):
    """Heights and tilts of a motion do not depend on the axes of its file."""
    usual, motion = load_bvh(write(GAIT)), load_bvh(write(turned(GAIT, TURNS[up])), up=up)
    heights = [in_space(one)[..., "xyz".index(one.up)] for one in (motion, usual)]
    np.testing.assert_allclose(heights[0], heights[1], atol=1e-6)
    if up.startswith("-"):  # the world is turned; where it is not, the file's axes of the root are other ones
        tilts = [
            one.with_root("tilt").angles[:, :3]
            for one in (motion, load_bvh(write(turned(GAIT, TURNS[up[-1]])), up=up[-1]))
        ]
        np.testing.assert_allclose(np.linalg.norm(tilts[0], axis=1), np.linalg.norm(tilts[1], axis=1), atol=1e-6)
