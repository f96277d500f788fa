"""Skeletons and motions of BVH files, compared with positions by hand."""

import numpy as np
import pytest
from conftest import DATA
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.io import MocapFormatError, load_bvh

BVH = (DATA / "biped.bvh").read_text()


@pytest.fixture
def load(tmp_path):
    def load(text=BVH, **parameters):
        path = tmp_path / "a.bvh"
        path.write_text(text)
        return load_bvh(path, **parameters)

    return load


def test_skeleton_and_motion():
    motion = load_bvh(DATA / "biped.bvh", scale=0.01)
    skeleton = motion.skeleton
    assert skeleton.joint_names == (
        "Left Leg", "LeftFoot", "LeftFoot_end", "Chest", "Head", "Head_end", "Arm", "Arm_end",
    )  # fmt: skip
    assert skeleton.dof_names[:4] == ("Left Leg_rz", "Left Leg_rx", "Left Leg_ry", "LeftFoot_rx")
    np.testing.assert_allclose(skeleton.offsets[2], [0, -0.05, 0.12])
    np.testing.assert_allclose(motion.frame_rate, 120, rtol=1e-4)
    np.testing.assert_allclose(np.degrees(motion.angles[0]), [11, 12, 13, 14, 5, 6, 7, 8, 9, 21, 22, 23])
    np.testing.assert_allclose(np.degrees(motion.angles[1, 0]), -10)
    assert motion.root_axes == "ZYX"
    np.testing.assert_allclose(np.degrees(motion.root_angles[0]), [10, 20, 30])
    np.testing.assert_allclose(motion.root_positions, [[0.01, 0.02, 0.03], [0, 0, 0]])


def test_positions_by_hand():
    """Intrinsic rotations in the order of each joint's channels, which rotate the joint's children."""
    motion = load_bvh(DATA / "biped.bvh")
    P = dict(zip(motion.skeleton.joint_names, forward_kinematics(motion.angles, motion.skeleton)[0], strict=True))
    leg, chest = (Rotation.from_euler(*a, degrees=True) for a in (("ZXY", [11, 12, 13]), ("XYZ", [5, 6, 7])))
    foot, arm = Rotation.from_euler("X", 14, degrees=True), Rotation.from_euler("YZX", [21, 22, 23], degrees=True)
    np.testing.assert_allclose(P["Left Leg"], [9, 0, 0])
    np.testing.assert_allclose(P["LeftFoot"], P["Left Leg"] + leg.apply([0, -45, 1]), atol=1e-12)
    np.testing.assert_allclose(P["LeftFoot_end"], P["LeftFoot"] + (leg * foot).apply([0, -5, 12]), atol=1e-12)
    np.testing.assert_allclose(P["Arm"], P["Chest"] + chest.apply([18, 20, 0]), atol=1e-12)
    np.testing.assert_allclose(P["Arm_end"], P["Arm"] + (chest * arm).apply([55, 0, 0]), atol=1e-12)


def test_a_file_without_frames_is_a_skeleton(load):
    head = BVH[: BVH.index("Frames:")]
    motion = load(head + "Frames: 0\nFrame Time: 0.1\n")
    assert len(motion) == 0
    assert motion.skeleton == load().skeleton


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("HIERARCHY", "hello", 1),
        ("MOTION", "", 44),
        ("OFFSET 9.0 0.0 0.0", "OFFSET 9.0 x 0.0", 8),
        ("    OFFSET 9.0 0.0 0.0\n", "", 18),
        ("CHANNELS 1 Xrotation", "CHANNELS 2 Xrotation", 13),
        ("CHANNELS 1 Xrotation", "CHANNELS 1 Xrotation\nOFFSET 0 0 0", 14),
        ("    }\n  }\n}\nMOTION", "    }\n  }\nMOTION", 42),
        ("}\nMOTION", "}\nROOT B\n{\nOFFSET 0 0 0\n}\nMOTION", 43),
        ("Frames: 2", "Frames: 9999999999", 44),
        ("Frame Time: 0.0083333", "Frame Time: 0", 45),
        (" 45.5", "", 44),
    ],
)
def test_faults_are_named_with_their_line(old, new, line, load):
    assert old in BVH
    with pytest.raises(MocapFormatError) as caught:
        load(BVH.replace(old, new, 1))
    assert caught.value.line == line
