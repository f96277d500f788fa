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
        """Return the line and the message of the error of a file."""
        with pytest.raises(MocapFormatError) as caught:
            load(text, **options)
        return caught.value.line, caught.value.message

    return refused


def same(one, other):
    """Check that two motions are equal."""
    assert one.skeleton == other.skeleton
    assert (one.frame_rate, one.root_axes) == (other.frame_rate, other.root_axes)
    for name in ("angles", "root_positions", "root_angles"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


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
    line, message = refused(stretched)
    assert line == 6
    assert "stretch='mean'" in message
    np.testing.assert_array_equal(load(stretched, stretch="mean").skeleton.offsets[0], [0, 11.5, 0])


def test_fewer_channels(load):
    """Each channel is a degree of freedom."""
    text = changed(
        ("3 Zrotation Yrotation Xrotation", "2 Xrotation Zrotation"), (" 40 50 60", " 40 50"), (" 51 61", " 51")
    )
    assert load(text).skeleton.dof_names == ("Chest_rx", "Chest_rz")
    np.testing.assert_allclose(np.degrees(load(text).angles[0]), [40, 50])


# Ends of chains


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


@pytest.mark.parametrize("stated", [1, 3])
def test_another_number_of_frames_than_stated(stated, load, refused):
    text = changed(("Frames: 2", f"Frames: {stated}"))
    line, message = refused(text)
    assert line == 17
    assert "trust='rows'" in message
    same(load(text, trust="rows"), load(BVH))


def rows(n_frames, i, line):
    """Return a file with equal lines 1 2 3 … of frames, one of them changed."""
    lines = [f"{i} 2 3 10 20 30 40 50 {i}" for i in range(n_frames)]
    lines[i] = line
    return BVH[: BVH.index("Frames:")] + f"Frames: {n_frames}\nFrame Time: 0.04\n" + "\n".join(lines) + "\n"


@pytest.mark.parametrize("line", ["5 2 3 10", "5 2 3 10 20 30 40 50 5 6"])
def test_a_line_of_another_length_does_not_shift_those_after_it(line, load):
    with pytest.warns(UserWarning, match="are left out"):
        motion = load(rows(20, 5, line), trust="rows")
    kept = [i for i in range(20) if i != 5]
    np.testing.assert_array_equal(motion.root_positions[:, 0], kept)
    np.testing.assert_allclose(np.degrees(motion.angles[:, 2]), kept)
    np.testing.assert_allclose(motion.times, np.array(kept) * 0.04)


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


@pytest.mark.parametrize("written", ["4.0e+001", "+40", "40."])
def test_notations_of_a_number(written, load):
    same(load(changed((" 40 ", f" {written} "))), load(BVH))


@pytest.mark.parametrize("word", ["0.0-7.509", "40,5", "nan", "1e999", "4_0", "-1.#IND", "４０", "4\x1c"])
def test_words_that_are_not_numbers(word, refused):
    line, message = refused(changed((" 40 ", f" {word} ")))
    assert line == 19
    assert repr(word) in message


def test_frames_with_nan_may_be_left_out(load):
    with pytest.warns(UserWarning, match="1 of 2 frames"):
        kept = load(changed((" 50 ", " NaN ")), on_nan="drop")
    np.testing.assert_array_equal(kept.angles, load(BVH).angles[1:])
    np.testing.assert_array_equal(kept.times, [0.04])


# Names


@pytest.mark.parametrize("name", ["Bip01 L Foot", "mixamorig:Hips", "Brücke", "MOTION"])
def test_names_are_the_rest_of_the_line(name, load):
    assert load(changed(("JOINT Chest", f"JOINT {name} "))).skeleton.joint_names == (name, f"{name}_end")
    assert load(changed(("JOINT Chest\n  {", f"JOINT {name} {{"))).skeleton.joint_names[0] == name


# Files that are not BVH, or hold several skeletons


@pytest.mark.parametrize(
    "content",
    ["", "version https://git-lfs.github.com/spec/v1\noid 4d\n", "<!DOCTYPE html>", b"FBX \0", BVH.encode("utf-16")],
)
def test_files_that_are_not_bvh(content, refused):
    assert refused(content)[0] is None


# Units


def test_zeros_after_an_offset_have_no_meaning(load, refused):
    same = load(changed(("OFFSET 0 10 0", "OFFSET 0 10 0 0 0.0 -0")))
    np.testing.assert_array_equal(same.skeleton.offsets, load(changed()).skeleton.offsets)
    assert refused(changed(("OFFSET 0 10 0", "OFFSET 0 10 0 0 90 0")))[0] == 8
