"""Skeletons and motions of BVH files, compared with positions by hand."""

import re

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
    ("old", "new", "message"),
    [
        ("HIERARCHY", "hello", "line 1: expected HIERARCHY, found 'hello'; not a BVH file?"),
        ("MOTION", "", "line 44: expected MOTION, found 'Frames:'"),
        ("OFFSET 9.0 0.0 0.0", "OFFSET 9.0 0.0", "line 9: OFFSET of 'Left Leg': expected a number, found 'CHANNELS'"),
        ("OFFSET 9.0 0.0 0.0", "OFFSET 9.0 x 0.0", "line 8: OFFSET of 'Left Leg': expected a number, found 'x'"),
        ("    OFFSET 9.0 0.0 0.0\n", "", "line 18: 'Left Leg', which begins in line 6, has no OFFSET"),
        (
            "CHANNELS 1 Xrotation",
            "CHANNELS 2 Xrotation",
            "CHANNELS of 'LeftFoot': expected 2 of Xposition … Zrotation, each once, found 'End'",
        ),
        (
            "CHANNELS 1 Xrotation",
            "CHANNELS 1 Wrotation",
            "CHANNELS of 'LeftFoot': expected 1 of Xposition … Zrotation, each once, found 'Wrotation'",
        ),
        ("CHANNELS 1 Xrotation", "CHANNELS one Xrotation", "expected how many there are, found 'one'"),
        ("CHANNELS 1 Xrotation", "CHANNELS 1 Xrotation\nOFFSET 0 0 0", "line 14: 'LeftFoot' has OFFSET twice"),
        ("JOINT Chest {", "JOINT Chest", "line 21: expected { after 'Chest', found 'OFFSET'"),
        (
            "    }\n  }\n}\nMOTION",
            "    }\n  }\nMOTION",
            "line 42: expected OFFSET, CHANNELS, JOINT, End Site or } in 'Hips', found 'MOTION'",
        ),
        ("}\nMOTION", "}\nROOT B\n{\nOFFSET 0 0 0\n}\nMOTION", "found a second ROOT"),
        ("Frames: 2", "Frames: two", "Frames: expected a whole number, found 'two'"),
        (
            "Frames: 2",
            "Frames: 3",
            "line 44: expected 3 frames of 18 numbers, found 2 frames of 18 numbers; is the file cut short",
        ),
        (
            "Frames: 2",
            "Frames: 9999999999",
            "line 44: expected 9999999999 frames of 18 numbers, found 2 frames of 18 numbers",
        ),
        (
            "Frame Time: 0.0083333",
            "Frame Time: 0",
            "Frame Time: expected a positive number, found '0'; frame_rate= chooses the rate",
        ),
        ("Frame Time: 0.0083333\n", "", "expected Frame Time: after MOTION"),
        (
            " 45.5",
            "",
            "line 44: expected 2 frames of 18 numbers, found 1 frame of 18 numbers and 17 numbers more; is the file",
        ),
        (
            " 45.5",
            " 45.5 46",
            "line 47: expected the end of the file after 2 frames of 18 numbers, found '46': there are 2 frames of 18 "
            "numbers and 1 number more",
        ),
    ],
)
def test_faults_are_named_with_their_line(old, new, message, load):
    assert old in BVH
    with pytest.raises(MocapFormatError) as caught:
        load(BVH.replace(old, new, 1))
    assert re.search(message, f"line {caught.value.line}: {caught.value.message}")
