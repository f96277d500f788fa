"""Skeletons and motions of ASF and AMC files, compared with an independent reference."""

import pickle

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
    read = load_amc(DATA / "arm.amc", pickle.loads(pickle.dumps(asf)), scale=asf.scale, frame_rate=60)
    np.testing.assert_array_equal(read.angles, load().angles)
    with pytest.raises(ValueError, match="scale"):
        load_amc(DATA / "arm.amc", asf, scale=1)


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("tip 12\n", "", 7),
        ("tip 12\n", "tip 12 13\n", 8),
        ("tip 12\n", "toe 12\n", 8),
        ("tip 12\n", "tip 12\ntail 12\n", 4),
        ("tip 12\n", "tip 1,5\n", 8),
        ("1\nroot", "root", 4),
    ],
)
def test_faults_of_a_motion_file_are_named_with_their_line(old, new, line, load):
    with pytest.raises(MocapFormatError) as caught:
        load(amc=AMC.replace(old, new, 1))
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("  length 0.45", "", None),
        ("  length 0.45", "  length -1", 6),
        ("upperarm lowerarm", "upperarm hand", 57),
        ("upperarm lowerarm", "", None),
        ("root upperarm tail", "lowerarm upperarm\nroot tail", None),
        ("direction 0 1 0", "direction 0 1", 30),
        ("     length 5.5\n", "", 36),
        ("dof ry", "dof ry tx", 51),
        ("0 30 20 XYZ", "0 30 20 XYX", 32),
        ("name lowerarm", "name upperarm", 37),
    ],
)
def test_faults_of_a_skeleton_file_are_named(old, new, line, load):
    assert old in ASF
    with pytest.raises(MocapFormatError) as caught:
        load(asf=ASF.replace(old, new, 1))
    assert caught.value.line == line
