"""Skeletons and motions of ASF and AMC files, compared with an independent reference."""

import io
import pickle
import re
from pathlib import Path

import numpy as np
import pytest
import reference
from conftest import DATA

from skpose import Skeleton, forward_kinematics
from skpose.io import AsfFile, MocapFormatError, load_amc, load_asf, load_motion

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


@pytest.fixture
def built(monkeypatch):
    """The skeletons that are constructed during a test."""
    skeletons = []
    construct = Skeleton.__post_init__
    monkeypatch.setattr(Skeleton, "__post_init__", lambda self: (skeletons.append(self), construct(self))[1])
    return skeletons


THREE_DOFS = ":FULLY-SPECIFIED\n:FORCE-ALL-JOINTS-BE-3DOF\n:DEGREES\n" + "".join(
    f"{frame}\nroot 0 0 0 0 0 0\nupperarm 1 2 3\nlowerarm 4 5 6\ntip 7 8 9\n" for frame in (1, 2)
)


def test_one_skeleton_is_built_for_all_motions_of_an_asf_file(built):
    asf = AsfFile(DATA / "arm.asf")
    motions = [load_amc(DATA / "arm.amc", asf, frame_rate=60), load_motion(DATA / "arm.amc", asf=asf, frame_rate=60)]
    assert len(built) == 1
    assert all(motion.skeleton is asf.skeleton for motion in motions)
    three = [load_amc(io.StringIO(THREE_DOFS), asf, frame_rate=60) for _ in range(2)]
    assert len(built) == 2  # the other is of the motions with three dofs for every bone
    assert three[0].skeleton is three[1].skeleton is not asf.skeleton
    assert three[0].skeleton.n_dofs == 9


def test_one_skeleton_is_built_for_a_motion_and_its_asf_file(built, load):
    load()
    assert len(built) == 1
    built.clear()
    every = re.sub(r"dof (rx rz|ry)\n( *limits.*\n( *\(.*\n)*)?", "dof rx ry rz\n", ASF)
    load(amc=THREE_DOFS, asf=every)  # nothing to add
    assert len(built) == 1


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
    with pytest.raises(MocapFormatError, match=r"biped\.bvh, line 1"):
        AsfFile(DATA / "biped.bvh")


def test_paths_may_be_strings_and_scale_may_be_given():
    metres = load_asf(str(DATA / "arm.asf"), scale=2.0)
    np.testing.assert_allclose(np.linalg.norm(metres.offsets[0]), 11.0)
    assert load_amc(str(DATA / "arm.amc"), str(DATA / "arm.asf"), scale=2.0, frame_rate=60).root_positions[0, 0] == 20


def test_other_orders_of_axes_channels_and_frames(load):
    """Axes extrinsic in the order named; the root's numbers in the order of its channels."""
    asf = ASF.replace("0 30 20 XYZ", "0 30 20 ZXY").replace("order TX TY TZ RX RY RZ", "order RZ RX RY TX TZ TY")
    asf = asf.replace("axis XYZ\n", "axis YZX\n")
    motion = load(asf=asf)
    upper = motion.skeleton.bones[0]
    assert upper.dofs == "zxy"
    np.testing.assert_allclose(np.degrees(motion.angles[0, :3]), [30, 10, -20])
    np.testing.assert_allclose(np.degrees(upper.limits[1]), [-160, 20])
    np.testing.assert_allclose(np.degrees(motion.root_angles[0]), [30, 10, 20])
    assert motion.root_axes == "yzx"
    np.testing.assert_allclose(motion.root_positions[0] / 0.0254 * 0.45, [1, 3, 2])


def test_radians(load):
    degrees, asf = load(), ASF.replace("angle deg", "angle rad")
    motion = load(asf=asf, amc=AMC.replace(":DEGREES", ":RADIANS"))
    np.testing.assert_allclose(motion.angles, np.degrees(degrees.angles))
    with pytest.raises(
        MocapFormatError, match=r"a\.amc, line 3, column 1: angles in degrees, but a\.asf has the other"
    ):
        load(asf=asf)


def test_comments_blank_lines_and_carriage_returns_are_ignored(load):
    untidy = AMC.replace("tip 12\n", "# a comment\n\n  tip   12  # degrees\n").replace("\n", "\r\n")
    np.testing.assert_array_equal(load(amc=untidy, asf=ASF.replace("\n", "\r\n")).angles, load().angles)


def test_frame_numbers_start_anywhere_without_gaps(load):
    later = AMC.replace("\n1\n", "\n7\n").replace("\n2\n", "\n8\n").replace("\n3\n", "\n9\n")
    np.testing.assert_array_equal(load(amc=later).angles, load().angles)
    with pytest.raises(MocapFormatError, match="line 9, column 1: expected frame 2, found frame 8"):
        load(amc=AMC.replace("\n2\n", "\n8\n"))


def test_a_name_among_the_numbers_of_a_bone(load):
    """In a frame that has as many words as the one before."""
    head, first, *_ = re.split(r"\n\d\n", AMC)
    second = first.replace("30 1 2 3\n", "30 1 2\ntail\n")
    with pytest.raises(MocapFormatError, match=r"line 10, column 1: 'root' has 5 numbers, but a\.asf gives it 6"):
        load(amc=f"{head}\n1\n{first}\n2\n{second}\n")


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


@pytest.mark.parametrize("kept", [0.2, 0.5, 0.8, 0.97])
def test_a_motion_file_cut_short(kept, load):
    with pytest.raises(MocapFormatError, match=r"a\.amc, line \d+.*: .*cut short"):
        load(amc=AMC[: int(kept * len(AMC))].rsplit(maxsplit=1)[0])


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
    with pytest.raises(MocapFormatError, match=r"a\.asf") as caught:
        load(asf=ASF.replace(old, new, 1))
    assert re.search(message, f"line {caught.value.line}: {caught.value.message}")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty, not an ASF file"),
        (b"\n \n", "the file is empty, not an ASF file"),
        (b"\0\1\2", "this is a binary file, not an ASF file"),
        (
            b"HIERARCHY\nROOT Hips\n",
            "line 1, column 1: expected a keyword such as :version, found 'HIERARCHY'; not an ASF file",
        ),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "this is a pointer of Git LFS; .* git lfs pull. It is not an ASF",
        ),
        ("angle".encode("utf-16"), "this is UTF-16 text; save it as UTF-8"),
        (b"\n<!DOCTYPE html>\n<html>", "this is a web page or XML, not an ASF file"),
    ],
)
def test_files_that_are_not_asf(content, message, tmp_path):
    path = tmp_path / "no.asf"
    path.write_bytes(content)
    with pytest.raises(MocapFormatError, match=message) as caught:
        load_asf(path)
    assert isinstance(caught.value, ValueError)
    assert caught.value.filename == str(path)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.line) == (str(caught.value), caught.value.line)
    with pytest.raises(FileNotFoundError):
        load_asf(tmp_path / "absent.asf")


def test_nearly_every_cmu_frame_breaks_a_limit_of_its_own_file(cmu):
    """The reason why limits are stored and not enforced."""
    outside = [
        ((motion.angles < lower) | (motion.angles > upper)).any(axis=1)
        for motion in cmu
        for lower, upper in [motion.skeleton.limits.T]
    ]
    assert all(frames.any() for frames in outside)
    assert np.concatenate(outside).mean() > 0.9


def test_a_cmu_motion_against_the_wrong_skeleton(cmu_folder):
    with pytest.raises(MocapFormatError, match=r"02_01\.amc, line 6, column 1: arm\.asf has no bone 'lowerback'"):
        load_amc(cmu_folder / "subjects" / "02" / "02_01.amc", Path(DATA / "arm.asf"))
