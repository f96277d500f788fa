"""Oddities of BVH files from many programs, one a test: read correctly, or refused with position and remedy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.io import MocapFormatError, load_bvh

BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Chest
  {
    OFFSET 0 10 0
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0 5 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.04
1 2 3 10 20 30 40 50 60
4 5 6 11 21 31 41 51 61
"""


def changed(*changes, text=BVH):
    """Return the text with each (old, new) replaced once; all must be there."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text


@pytest.fixture
def load(tmp_path):
    def load(text, **options):
        path = tmp_path / "a.bvh"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_bvh(path, **options)

    return load


@pytest.fixture
def refused(load):
    def refused(text, **options):
        """Return the error of a file, as (line, column, message)."""
        with pytest.raises(MocapFormatError) as caught:
            load(text, **options)
        return caught.value.line, caught.value.column, caught.value.message

    return refused


def same(one, other):
    """Check that two motions are equal."""
    assert one.skeleton == other.skeleton
    assert (one.frame_rate, one.root_axes) == (other.frame_rate, other.root_axes)
    for name in ("angles", "root_positions", "root_angles"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_the_file_itself(load):
    motion = load(BVH)
    assert motion.skeleton.joint_names == ("Chest", "Chest_end")
    assert motion.skeleton.dof_names == ("Chest_rz", "Chest_ry", "Chest_rx")
    np.testing.assert_allclose(np.degrees(motion.angles), [[40, 50, 60], [41, 51, 61]])
    np.testing.assert_allclose(np.degrees(motion.root_angles), [[10, 20, 30], [11, 21, 31]])
    np.testing.assert_array_equal(motion.root_positions, [[1, 2, 3], [4, 5, 6]])
    assert (motion.root_axes, motion.frame_rate) == ("ZXY", 25)


# Channels


def test_orders_of_channels_differ_between_joints(load):
    """ZXY here and ZYX there, as in the converted CMU files; intrinsic, in the order of the list."""
    motion = load(BVH)
    end = forward_kinematics(motion.angles, motion.skeleton)[0, 1] - [0, 10, 0]
    np.testing.assert_allclose(end, Rotation.from_euler("ZYX", [40, 50, 60], degrees=True).apply([0, 5, 0]))
    other = load(changed(("3 Zrotation Yrotation Xrotation", "3 Yrotation Zrotation Xrotation")))
    end = forward_kinematics(other.angles, other.skeleton)[0, 1] - [0, 10, 0]
    np.testing.assert_allclose(end, Rotation.from_euler("YZX", [40, 50, 60], degrees=True).apply([0, 5, 0]))


SIX = changed(
    ("CHANNELS 3 Zrotation", "CHANNELS 6 Xposition Yposition Zposition Zrotation"),
    ("40 50 60", "0 10 0 40 50 60"),
    ("41 51 61", "0 10 0 41 51 61"),
)


def test_positions_of_every_joint(load):
    """As Blender, MotionBuilder and Mixamo write them: they replace the OFFSET."""
    same(load(SIX), load(BVH))
    absent = changed(("OFFSET 0 10 0", "OFFSET 0 0 0"), text=SIX)  # OFFSETs left at zero
    same(load(absent), load(BVH))
    unused = SIX.replace("0 10 0 4", "0 0 0 4")  # the channels left at zero
    same(load(unused), load(BVH))
    nearly = SIX.replace("0 10 0 40", "0.009 -0.009 0 40").replace("0 10 0 41", "0 0.009 0 41")  # and vary
    same(load(nearly), load(BVH))
    rounded = SIX.replace("0 10 0 41", "0 10.0001 0 41")
    np.testing.assert_allclose(load(rounded).skeleton.offsets[0], [0, 10.00005, 0])


def test_positions_that_vary(load, refused):
    stretched = changed(("0 10 0 41", "0 13 0 41"), text=SIX)
    line, column, message = refused(stretched)
    assert (line, column) == (6, 3)
    assert message.startswith("position channels move 'Chest' by up to 3 units against 'Hips', but bones have const")
    assert "stretch='mean'" in message
    np.testing.assert_array_equal(load(stretched, stretch="mean").skeleton.offsets[0], [0, 11.5, 0])


@pytest.mark.parametrize(
    ("channels", "names", "kept"),
    [
        ("1 Yrotation", ("Chest_ry",), 1),
        ("2 Xrotation Zrotation", ("Chest_rx", "Chest_rz"), 2),
        ("0", ("Chest_end_ry",), 1),
    ],
)
def test_fewer_channels(channels, names, kept, load):
    """Each channel is a degree of freedom; an End Site may even have one."""
    text = BVH.replace("CHANNELS 3 Zrotation Yrotation Xrotation", f"CHANNELS {channels}")
    text = text.replace(" 40 50 60", " 40 50 60"[: 3 * kept]).replace(" 41 51 61", " 41 51 61"[: 3 * kept])
    if channels == "0":
        text = changed(("OFFSET 0 5 0", "OFFSET 0 5 0\nCHANNELS 1 Yrotation"), text=text)
    motion = load(text)
    assert motion.skeleton.dof_names == names
    np.testing.assert_allclose(np.degrees(motion.angles[0]), [40, 50][:kept])


# Ends of chains


def test_several_end_sites(load):
    text = changed(("OFFSET 0 5 0\n    }", "OFFSET 0 5 0\n    }\n    End Site\n    {\n      OFFSET 1 5 0\n    }"))
    motion = load(text)
    assert motion.skeleton.joint_names == ("Chest", "Chest_end", "Chest_end_2")
    np.testing.assert_array_equal(motion.skeleton.offsets[2], [1, 5, 0])


def test_position_channels_of_the_root_replace_its_offset(load):
    """As programs that write both mean it: with the OFFSET added, people would float above the floor."""
    text = changed(("OFFSET 0 0 0", "OFFSET 100 0 -1"))
    motion = load(text)
    np.testing.assert_array_equal(motion.root_positions, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(forward_kinematics(motion.angles, motion.skeleton)[0, 0], [0, 10, 0])
    added = load(text, root_offset="add")
    np.testing.assert_array_equal(added.root_positions, [[101, 2, 2], [104, 5, 5]])
    with pytest.raises(ValueError, match="root_offset must be"):
        load(text, root_offset="keep")


# The number of frames


def test_fewer_frames_than_stated(load, refused):
    text = changed(("Frames: 2", "Frames: 3"))
    line, column, message = refused(text)
    assert (line, column) == (17, 9)
    assert message.startswith("expected 3 frames of 9 numbers, found 2 frames of 9 numbers; is the file cut short?")
    assert "trust='rows'" in message
    same(load(text, trust="rows"), load(BVH))


def test_more_frames_than_stated(load, refused):
    text = changed(("Frames: 2", "Frames: 1"))
    line, column, message = refused(text)
    assert (line, column) == (20, 1)
    assert message == (
        "expected the end of the file after 1 frame of 9 numbers, found '4': there are 2 frames of 9 numbers; "
        "trust='rows' reads the whole frames that there are"
    )
    same(load(text, trust="rows"), load(BVH))


def rows(n_frames, *changes):
    """Return a file with equal lines 1 2 3 … of frames, some of them changed: (index, line)."""
    lines = [f"{i} 2 3 10 20 30 40 50 {i}" for i in range(n_frames)]
    for i, line in changes:
        lines[i] = line
    return BVH[: BVH.index("Frames:")] + f"Frames: {n_frames}\nFrame Time: 0.04\n" + "\n".join(lines) + "\n"


@pytest.mark.parametrize("short", ["5 2 3 10", "5 2 3 10 20 30 40 50 5 6", "5 2 3\n10 20"])
def test_a_line_of_another_length_does_not_shift_those_after_it(short, load, refused):
    text, n_lines = rows(20, (5, short)), 1 + short.count("\n")
    count = len(short.split("\n")[0].split())
    message = f"{n_lines} of {19 + n_lines} lines of numbers are left out, .*: line 24 has {count} numbers, not 9"
    with pytest.warns(UserWarning, match=rf"a\.bvh: {message}"):
        motion = load(text, trust="rows")
    kept = [i for i in range(20) if i != 5]
    np.testing.assert_array_equal(motion.root_positions[:, 0], kept)
    np.testing.assert_allclose(np.degrees(motion.angles[:, 2]), kept)
    if n_lines == 1:  # each line is a frame, so that the others keep their times
        np.testing.assert_allclose(motion.times, np.array(kept) * 0.04)
    assert "20 frames of 9 numbers" in refused(text)[2]
    assert "19 frames of 9 numbers" in refused(text)[2] or count == 10


# Layout


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: text.replace("\n", "\r"),
        lambda text: text.replace("\n", " \t\n"),
        lambda text: text.replace("\n", "\n\n"),
        lambda text: text.replace("  ", "\t").replace(" ", "\t"),
        lambda text: text.replace("Frames: ", "Frames:\t").replace("Frame Time: ", "Frame Time:\t"),
        lambda text: text.replace("Frames: ", "Frames:").replace("Frame Time: ", "Frame Time :"),
        lambda text: text.rstrip(),
        lambda text: text.replace("\n  {", " {").replace("\n    {", " {").replace("\n{", " {"),
        lambda text: text.replace("Site\n    {\n", "Site {").replace("5 0\n    }", "5 0}"),
        lambda text: text.replace("\n", " "),
        lambda text: text.replace("HIERARCHY", "Hierarchy").replace("End Site", "End site").replace("ROOT", "root"),
        lambda text: text.replace("Xposition", "xposition").replace("Zrotation", "ZROTATION").replace("Frame", "frame"),
        lambda text: text.replace("MOTION", "Motion").replace("OFFSET", "Offset").replace("CHANNELS", "Channels"),
        lambda text: text.replace("30 40", "30\n40"),
        lambda text: text.replace("60\n4", "60 4"),
        lambda text: text.replace("OFFSET 0 10 0", "OFFSET\n 0\n 10 0"),
        lambda text: "﻿" + text,
        lambda text: "\n\n" + text,
    ],
    ids=[
        "CRLF", "CR", "trailing blanks", "blank lines", "tabs", "tabs in the head", "no blanks in the head",
        "no newline", "braces on the line", "braces closed on the line", "one line", "case of keywords",
        "case of channels",
        "more case", "a frame on several lines", "frames on one line", "an offset on several lines",
        "byte order mark", "blank lines first",
    ],
)  # fmt: skip
def test_layout_does_not_matter(change, load):
    same(load(change(BVH)), load(BVH))


@pytest.mark.parametrize("written", ["4.0e+001", "4E+1", "+40", "40.", "400e-1", "0040"])
def test_notations_of_a_number(written, load):
    same(load(changed((" 40 ", f" {written} "))), load(BVH))


@pytest.mark.parametrize(
    ("written", "message"),
    [
        ("0.0-7.509", "found '0.0-7.509': numbers without a blank between them"),
        ("40,5", "found '40,5', which has a decimal comma: write it with a point"),
        ("nan", "expected a finite number, found 'nan'; on_nan='drop' leaves such frames out"),
        ("-inf", "expected a finite number, found '-inf'; on_nan='drop' leaves such frames out"),
        ("1e999", "expected a finite number, found '1e999'"),
        ("4_0", "expected a number, found '4_0'"),
        ("0x28", "expected a number, found '0x28'"),
        ("-1.#IND", "expected a number, found '-1.#IND'"),
        ("４０", "expected a number, found '４０'"),
        ("\0", r"expected a number, found '\x00'"),
        ("4\x1c", r"expected a number, found '4\x1c'"),  # a blank to numpy
        ("}", "expected a number, found '}'"),
    ],
)
@pytest.mark.parametrize("ragged", [False, True])
def test_words_that_are_not_numbers(written, message, ragged, refused):
    text = changed((" 40 ", f" {written} "))
    if ragged:  # for the other of numpy's two parsers
        text = changed((" 61\n", "\n61\n"), text=text)
    line, column, found = refused(" " * 9000 + text)  # a zero byte near the start would make it a binary file
    assert (line, column) == (19, 16)
    assert message in found


def test_frames_with_nan_may_be_left_out(load):
    with pytest.warns(
        UserWarning, match=r"a\.bvh: 1 of 2 frames have a number that is NaN or infinite and are left out"
    ):
        kept = load(changed((" 50 ", " NaN ")), on_nan="drop")
    np.testing.assert_array_equal(kept.angles, load(BVH).angles[1:])
    np.testing.assert_array_equal(kept.times, [0.04])
    same(load(BVH, on_nan="drop"), load(BVH))
    with pytest.warns(UserWarning, match="2 of 2 frames"):
        assert len(load(changed((" 50 ", " NaN "), (" 51 ", " inf ")), on_nan="drop")) == 0


# Names


@pytest.mark.parametrize(
    "name", ["Bip01 L Foot", "mixamorig:Hips", "arm.L", "left-arm", "Brücke", "a  b", "MOTION", "1"]
)
def test_names_are_the_rest_of_the_line(name, load):
    assert load(changed(("JOINT Chest", f"JOINT {name} "))).skeleton.joint_names == (name, f"{name}_end")
    assert load(changed(("JOINT Chest\n  {", f"JOINT {name} {{"))).skeleton.joint_names[0] == name


def test_two_joints_of_one_name(load):
    joint = "\n  {\n OFFSET 1 0 0\n CHANNELS 1 Xrotation\n }\n  JOINT "
    text = changed(
        ("JOINT Chest", f"JOINT Arm{joint}Arm{joint}Arm_2{joint}Chest"),
        ("30 40", "30 7 8 9 40"),
        ("31 41", "31 7 8 9 41"),
    )
    with pytest.warns(UserWarning, match=r"joints in lines 6 and 11 are both named 'Arm'; the second is 'Arm_3' here"):
        motion = load(text)
    assert motion.skeleton.joint_names == ("Arm", "Arm_3", "Arm_2", "Chest", "Chest_end")
    np.testing.assert_allclose(np.degrees(motion.angles[0, :3]), [7, 8, 9])


# Files that are not BVH, or hold several skeletons


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "the file is empty, not a BVH file"),
        (" \n", "the file is empty, not a BVH file"),
        ("version https://git-lfs.github.com/spec/v1\noid 4d\n", "this is a pointer of Git LFS; get the file itself"),
        ("<!DOCTYPE html>", "this is a web page or XML, not a BVH file"),
        (b"Kaydara FBX Binary  \0\x1a", "this is a binary file, not a BVH file"),
        (BVH.encode("utf-16"), "this is UTF-16 text; save it as UTF-8. It is not a BVH file"),
        ("HIERARCHY\n", "the file ends and there is no MOTION; not BVH, or cut short"),
        ("HIERARCHY\nMOTION\n", "expected ROOT, found 'MOTION'"),
        (changed(("CHANNELS 3 Zrotation Yrotation Xrotation", "")), "expected the end of the file"),
        (changed((" 40 50 60", ""), (" 41 51 61", ""), ("3 Zrotation Yrotation Xrotation", "0")), "degree of freedom"),
    ],
)  # fmt: skip
def test_files_that_are_not_bvh(content, message, refused):
    assert message in refused(content)[2]


# Units
