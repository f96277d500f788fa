"""BVH files of motions in which another axis than y points up: the world is turned, as programs take y."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import SKELETONS, in_space
from scipy.spatial.transform import Rotation

from skpose import Bone, Motion, Skeleton
from skpose.io import load_bvh, save_bvh

CLOSE = {"rtol": 0, "atol": 1e-6}
# From each axis that points up to y, with a quarter turn.
TURNS = {"x": Rotation.from_euler("z", 90, degrees=True), "z": Rotation.from_euler("x", -90, degrees=True)}


@pytest.fixture
def again(tmp_path):
    """Return what is read of a file in which a motion is written."""

    def again(motion, *, read=None, **options):
        path = tmp_path / f"{len(list(tmp_path.iterdir()))}.bvh"
        save_bvh(path, motion, **options)
        return load_bvh(path, up=read)

    return again


def in_world(motion):
    """Joint positions in space, also of a root without angles."""
    if not motion.root_axes:
        motion = replace(motion, root_axes="Y", root_angles=np.zeros((len(motion), 1)))
    return in_space(motion)


def turned(motion, turn, up):
    """The motion in a world that is turned; the root has three angles."""
    orientations = Rotation.from_euler(motion.root_axes or "Y", motion.root_angles if motion.root_axes else [[0.0]])
    angles = np.broadcast_to((turn * orientations).as_euler("ZYX"), (len(motion), 3))
    places = turn.apply(motion.root_positions)
    return replace(motion, root_positions=places, root_angles=angles, root_axes="ZYX", up=up)


def person(stands="y"):
    """A skeleton that stands along an axis at angle zero, in ball joints."""
    offsets = {"spine": (0, 0.5, 0), "head": (0, 0.3, 0.02), "left_arm": (0.6, 0, 0), "right_arm": (-0.6, 0, 0)}
    parents = {"head": "spine", "left_arm": "spine", "right_arm": "spine"}
    for side, x in (("left", 0.1), ("right", -0.1)):
        offsets |= {f"{side}_leg": (x, -0.9, 0), f"{side}_foot": (0, -0.05, 0.2)}
        parents[f"{side}_foot"] = f"{side}_leg"
    turn = Rotation.identity() if stands == "y" else TURNS[stands].inv()
    bones = [Bone(name, parents.get(name), turn.apply(offset), "rotvec") for name, offset in offsets.items()]
    return Skeleton(bones, "parent")


@pytest.mark.parametrize("up", TURNS)
def test_a_person_who_lies_and_turns_keeps_the_tilt(up, again):
    """The issue's example: seen with y up, a person on the floor who turned on the spot stood on the head."""
    lying = Rotation.from_euler("xz", [3, 5], degrees=True)
    turning = Rotation.from_euler(up, np.linspace(0, 2 * np.pi, 40)[:, None]) * lying
    still = Motion(person(), np.zeros((40, person().n_dofs)), 30)
    motion = replace(still, root_angles=turning.as_euler("ZYX"), root_axes="ZYX", up=up)
    for one in (motion, again(motion)):
        tilts = np.linalg.norm(one.with_root("tilt").angles[:, :3], axis=1)
        assert np.degrees(np.ptp(tilts)) < 1e-3
    assert again(motion).up == "y"


@pytest.mark.parametrize("up", TURNS)
@pytest.mark.parametrize("axes", ["", "zx", "ZYX"])
def test_all_joints_are_where_they_were_in_a_turned_world(axes, up, again):
    """Also where the root has no angles, or fewer than the turned world needs."""
    rng = np.random.default_rng(7)
    skeleton = SKELETONS["mixed joints"]
    root = {
        "root_angles": rng.normal(size=(6, len(axes))),
        "root_axes": axes,
        "root_positions": rng.normal(size=(6, 3)),
    }
    motion = Motion(skeleton, rng.uniform(-1.0, 1.0, (6, skeleton.n_dofs)), 30, up=up, **root)
    back, usual = again(motion, read="y"), again(turned(motion, TURNS[up], "y"), read="y")
    np.testing.assert_allclose(back.root_positions, TURNS[up].apply(motion.root_positions), **CLOSE)
    assert back.skeleton.joint_names == usual.skeleton.joint_names
    np.testing.assert_allclose(in_space(back), in_space(usual), **CLOSE)
    if skeleton.offset_frame == "parent":  # others have the names at other joints
        there = [in_world(motion)[:, skeleton.joint_names.index(joint)] for joint in back.skeleton.joint_names]
        for joint, places in enumerate(there):
            np.testing.assert_allclose(in_space(back)[:, joint], TURNS[up].apply(places), **CLOSE)
    assert len(back.root_axes) == 3
