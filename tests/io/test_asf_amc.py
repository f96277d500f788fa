"""Skeletons and motions of ASF and AMC files, compared with an independent reference."""

import pickle
import re

import numpy as np
import pytest
import reference
from conftest import DATA

from skpose import forward_kinematics
from skpose.io import AsfFile, MocapFormatError, load_amc, load_asf

ASF, AMC = (DATA / "arm.asf").read_text(), (DATA / "arm.amc").read_text()


@pytest.fixture
def load(tmp_path):
    """Load an AMC file and its ASF file from texts, by default those of the hand-written arm."""

    def load(amc=AMC, asf=ASF, **parameters):
        (tmp_path / "a.asf").write_text(asf)
        (tmp_path / "a.amc").write_text(amc)
        return load_amc(tmp_path / "a.amc", tmp_path / "a.asf", **{"frame_rate": 120} | parameters)

    return load


def test_skeleton():
    skeleton = load_asf(DATA / "arm.asf")
    assert skeleton.joint_names == ("upperarm", "lowerarm", "tail", "tip")
    assert skeleton.dof_names == (
        "upperarm_rx", "upperarm_ry", "upperarm_rz", "lowerarm_rx", "lowerarm_rz", "tip_ry",
    )  # fmt: skip
    np.testing.assert_array_equal(skeleton.parents, [-1, 0, -1, 2])
    metres = np.array([5.5, 4.0, 2.25, 1.0]) / 0.45 * 0.0254
    np.testing.assert_allclose(np.linalg.norm(skeleton.offsets, axis=1), metres)
    np.testing.assert_allclose(np.degrees(skeleton.limits[3:5]), [[-10, 170], [-70, 20]])
    np.testing.assert_array_equal(skeleton.limits[2], [-np.inf, np.inf])


def test_motion():
    motion = load_amc(DATA / "arm.amc", DATA / "arm.asf", frame_rate=60)
    assert (motion.frame_rate, motion.skeleton) == (60, load_asf(DATA / "arm.asf"))
    np.testing.assert_allclose(np.degrees(motion.angles[0]), [10, -20, 30, 45, -0.75, 12])
    np.testing.assert_allclose(np.degrees(motion.angles[1]), [12, -22, 33, 50, 5, -12.5])
    np.testing.assert_allclose(np.degrees(motion.root_angles), [[1, 2, 3], [1, 2, 4], [1, 2, 5]])
    np.testing.assert_allclose(motion.root_positions[0], np.array([10, 20, 30]) / 0.45 * 0.0254)


def test_positions_agree_with_the_reference():
    motion = load_amc(DATA / "arm.amc", DATA / "arm.asf", frame_rate=60)
    expected, names = reference.asf_amc_positions(DATA / "arm.asf", DATA / "arm.amc")
    order = [names.index(name) for name in motion.skeleton.joint_names]
    np.testing.assert_allclose(forward_kinematics(motion.angles, motion.skeleton), expected[:, order], atol=1e-14)


def test_an_asf_file_read_once_is_that_file(load):
    asf = AsfFile(DATA / "arm.asf")
    assert (asf.name, asf.skeleton) == ("arm.asf", load_asf(DATA / "arm.asf"))
    assert repr(asf) == "AsfFile('arm.asf', Skeleton(n_joints=4, n_dofs=6))"
    np.testing.assert_allclose(asf.scale, 0.0254 / 0.45)
    read = load_amc(DATA / "arm.amc", pickle.loads(pickle.dumps(asf)), scale=asf.scale, frame_rate=60)
    np.testing.assert_array_equal(read.angles, load().angles)
    np.testing.assert_array_equal(read.root_positions, load().root_positions)
    metres = AsfFile(DATA / "arm.asf", scale=2.0)
    assert load_amc(DATA / "arm.amc", metres, frame_rate=60).root_positions[0, 0] == 20
    with pytest.raises(ValueError, match=r"scale must be that of AsfFile\('arm\.asf', .*\), 2\.0, or None, got 1"):
        load_amc(DATA / "arm.amc", metres, scale=1)
    with pytest.raises(MocapFormatError):
        AsfFile(DATA / "biped.bvh")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("tip 12\n", "", "line 7: frame 1 ends without tip; is the file cut short?"),
        ("tip 12\n", "tip 12 13\n", "line 8: 'tip' has 2 numbers, but a.asf gives it 1 .ry.; is the line cut short"),
        ("tip 12\n", "toe 12\n", "line 8: a.asf has no bone 'toe'; is it the right skeleton?"),
        (
            "tip 12\n",
            "tip 12\ntail 12\n",
            "line 9: frame 1: expected 0, found '12', as a.asf gives 'tail' no degrees of freedom; is it the",
        ),
        ("tip 12\n", "tip 12\ntip 12\n", "line 9: 'tip' appears twice in frame 1"),
        ("tip 12\n", "tip twelve\n", "line 8: frame 1: expected a number, found 'twelve'"),
        ("tip 12\n", "tip nan\n", "line 8: frame 1: expected a finite number, found 'nan'"),
        ("tip 12\n", "tip 1,5\n", "line 8: frame 1: expected a number, found '1,5'"),
        ("1\nroot", "root", "line 4: expected a frame number, found 'root 10 20 30 1 2 3'; not an AMC file"),
    ],
)
def test_faults_of_a_motion_file_are_named_with_their_line(old, new, message, load):
    assert old in AMC
    with pytest.raises(MocapFormatError) as caught:
        load(amc=AMC.replace(old, new, 1))
    assert re.search(message, f"line {caught.value.line}: {caught.value.message}")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("  length 0.45", "", "no length under :units; pass scale="),
        ("  length 0.45", "  length zero", "line 6: length: expected a number, found 'zero'"),
        ("  length 0.45", "  length -1", "line 6: length: expected a positive number"),
        ("  angle deg", "  angle grad", "line 7: angle: expected deg or rad, found 'grad'"),
        (":hierarchy", "", "the file ends without a :hierarchy section; not ASF, or cut short"),
        (
            "upperarm lowerarm",
            "upperarm2 lowerarm",
            "bone 'lowerarm' is a child of 'upperarm2', which the file does not define",
        ),
        ("upperarm lowerarm", "upperarm hand", "bone 'hand' is a child of 'upperarm', but the file does not define it"),
        ("upperarm lowerarm", "", "line 17: bone 'lowerarm' does not appear under :hierarchy"),
        ("root upperarm tail", "lowerarm upperarm\nroot tail", "is a child of itself, through"),
        ("tail tip", "tail tip\ntip tip", "bone 'tip' is a child of 'tail' already"),
        ("direction 0 1 0", "direction 0 1", "direction of bone 'upperarm': expected 3 numbers, found 2"),
        ("direction 0 1 0", "direction 0 0 0", "bone 'upperarm' has a length but no direction"),
        ("     length 5.5\n", "", "bone 'upperarm', which begins in line 27, has no length"),
        ("length 5.5", "length nan", "length of bone 'upperarm': expected a finite number, found 'nan'"),
        ("dof ry", "dof ry tx", "dof of bone 'tip': expected some of rx ry rz, each once, found 'tx'"),
        (
            "    limits (-30.0 30.0)",
            "    limits (-30.0 30.0)\n (0 1)",
            "bone 'tip': expected a pair of limits for each of its 1 dofs, found 4 numbers",
        ),
        ("0 30 20 XYZ", "0 30 20 XYX", "axis of bone 'upperarm': expected an order such as XYZ at the end"),
        ("0 30 20 XYZ", "30 20 XYZ", "axis of bone 'upperarm': expected 3 numbers, found 2"),
        (
            "order TX TY TZ",
            "order TX TX TZ",
            "order of the root: expected some of tx ty tz rx ry rz, each once, found 'TX'",
        ),
        ("name lowerarm", "name root", "line 17: a bone is named 'root', which is the name of the root"),
        ("name lowerarm", "name upperarm", "bone 'upperarm' is defined twice"),
    ],
)
def test_faults_of_a_skeleton_file_are_named(old, new, message, load):
    assert old in ASF
    with pytest.raises(MocapFormatError) as caught:
        load(asf=ASF.replace(old, new, 1))
    assert re.search(message, f"line {caught.value.line}: {caught.value.message}")
