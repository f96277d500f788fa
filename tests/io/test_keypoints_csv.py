"""Keypoints of CSV files, compared with the arrays that they were made of; headers of many spellings."""

import csv
import io

import numpy as np
import pytest

from skpose.io import MocapFormatError, load_keypoints
from skpose.keypoints import Keypoints, layouts

N, LAYOUT = 5, layouts["coco17"]
RNG = np.random.default_rng(2)
ARRAY, SURE = RNG.uniform(-0.9, 0.9, (N, 17, 3)), RNG.uniform(0.1, 1, (N, 17))


def text_of(header, columns, separator=",", end="\n"):
    file = io.StringIO()
    writer = csv.writer(file, delimiter=separator, lineterminator=end)
    writer.writerows([header, *columns])
    return file.getvalue()


def table(form="{name}_{axis}", sure="visibility", names=LAYOUT.names, array=ARRAY, **options):
    """Return a CSV file of the arrays, as Python's csv module writes it, with a frame and a time."""
    axes = ["x", "y", "z"] + ([sure] if sure else [])
    header = ["frame", "time", *(form.format(name=name, axis=axis) for name in names for axis in axes)]
    numbers = np.concatenate([array, SURE[:, :, None]], axis=2) if sure else array
    return text_of(header, [[t, t / 30, *row.ravel().tolist()] for t, row in enumerate(numbers)], **options)


def read(text, **options):
    return load_keypoints(io.BytesIO(text.encode()), **({"layout": LAYOUT, "frame_rate": 30} | options))


def same(found, wanted):
    np.testing.assert_array_equal(found.positions, wanted.positions)
    np.testing.assert_array_equal(found.confidences, wanted.confidences)
    assert (found.names, found.frame_rate, found.up) == (wanted.names, wanted.frame_rate, wanted.up)


@pytest.mark.parametrize("form", ["{name}_{axis}", "{name} {axis}", "{axis}_{name}"])
@pytest.mark.parametrize("sure", ["visibility", "c", None])
def test_headers(form, sure):
    same(read(table(form, sure)), LAYOUT.keypoints(ARRAY, 30, SURE if sure else None))


@pytest.mark.parametrize(("separator", "end"), [(",", "\r\n"), (";", "\n"), ("\t", "\n")])
def test_separators_and_ends_of_lines(separator, end):
    same(read(table(separator=separator, end=end)), LAYOUT.keypoints(ARRAY, 30, SURE))


def test_names_and_their_order_are_those_of_the_file():
    order = RNG.permutation(17)
    names = [LAYOUT.names[i].title() for i in order]
    text = table(names=[*names, "hat"], array=np.insert(ARRAY[:, order], 17, 0.9, axis=1), sure=None)
    same(read(text), LAYOUT.keypoints(ARRAY, 30))
    found = read(text, layout=None, up="z")
    assert (found.names, found.up) == ((*names, "hat"), "z")
    np.testing.assert_array_equal(found.positions[:, :17], ARRAY[:, order])
    with pytest.raises(MocapFormatError):
        read(text, layout="mediapipe33")


@pytest.mark.parametrize("form", ["{axis}{name}", "landmark_{name}_{axis}"])
def test_numbers_are_the_order_of_the_points(form):
    order = [*range(16, -1, -1)]
    same(read(table(form, None, order, ARRAY[:, order])), LAYOUT.keypoints(ARRAY, 30))
    with pytest.raises(ValueError, match="layout="):
        read(table(form, None, order, ARRAY[:, order]), layout=None)
    with pytest.raises(MocapFormatError):
        read(table(form, None, [0, *range(2, 18)]))


def test_frames_that_are_left_out_stay_at_their_time():
    lines = table().splitlines()
    found = read("\n".join([lines[0], lines[1], lines[2], lines[5]]))
    whole = LAYOUT.keypoints(ARRAY, 30, SURE)
    assert len(found) == N
    np.testing.assert_array_equal(found.positions[[0, 1, 4]], whole.positions[[0, 1, 4]])
    assert np.isnan(found.positions[2:4]).all()
    with pytest.raises(MocapFormatError):
        read("\n".join([lines[0], lines[1], lines[2], lines[1]]))


def test_images_without_numbers_are_frames_of_one_person():
    names = ["image_id", *"abcde"]
    lines = [",".join([name, line]) for name, line in zip(names, table().splitlines(), strict=True)]
    lines = [line.replace("frame", "row", 1) for line in lines]
    same(read("\n".join(lines)), LAYOUT.keypoints(ARRAY, 30, SURE))
    lines[2] = lines[2].replace("b", "a", 1)
    with pytest.raises(MocapFormatError):
        read("\n".join(lines))


def test_anipose():
    """Errors, numbers of cameras and a matrix stand next to x, y and z; fnum is the frame."""
    head = "a_x,a_y,a_z,a_error,a_ncams,a_score,M_00,M_01,center_0,fnum"
    found = read(f"{head}\n1,2,3,0.1,2,0.9,1,0,0,0\n1,2,4,0.1,2,0.8,1,0,0,1\n", layout=None)
    same(found, Keypoints([[[1.0, 2, 3]], [[1, 2, 4]]], ["a"], 30, [[0.9], [0.8]]))


def test_rotations_and_velocities_next_to_points_are_left_out():
    names = [*LAYOUT.names, "nose_rot", "HipRotation", "left knee euler", "wrist_vel", "acc"]
    array = np.concatenate([ARRAY, 90 * ARRAY[:, :5]], axis=1)
    with pytest.warns(UserWarning, match="nose_rot"):
        found = read(table(names=names, array=array, sure=None), layout=None)
    assert found.names == LAYOUT.names


VECTORS = ("X (g)", "Y (g)", "Z (g)"), ("gyr_x", "gyr_y", "gyr_z"), ("ForceX", "ForceY", "ForceZ")


@pytest.mark.parametrize(
    "form", ["{axis}_hip (mm)", "hip {axis} (mm)", "hip_{axis}_mm", "hip_{axis} [mm]", "hip.{axis}(MM)"]
)
def test_the_unit_of_the_header_is_used(form):
    text = f"Time (s),{','.join(form.format(axis=axis) for axis in 'XYZ')}\n0.0,100,900,0\n0.0333,100,910,0\n"
    found = read(text, layout=None)
    same(found, Keypoints([[[0.1, 0.9, 0.0]], [[0.1, 0.91, 0.0]]], ["hip"], 30))
    same(read(text, layout=None, scale=0.001), found)
    with pytest.warns(UserWarning, match="scale=0.01 replaces"):
        read(text, layout=None, scale=0.01)


def test_two_units_are_refused():
    with pytest.raises(MocapFormatError, match="one unit"):
        read("a_x (mm),a_y (mm),a_z (mm),b_x,b_y,b_z\n1,2,3,4,5,6\n", layout=None)


@pytest.mark.parametrize("header", VECTORS)
def test_other_quantities_are_refused_alone_and_left_out_next_to_positions(header):
    with pytest.raises(MocapFormatError, match="positions of points"):
        read(f"time,{','.join(header)}\n0.0,1,2,3\n0.1,1,2,4\n", layout=None)
    with pytest.warns(UserWarning, match="left out"):
        found = read(f"hip_x,hip_y,hip_z,acc_{',acc_'.join(header)}\n1,2,3,4,5,6\n", layout=None)
    assert found.names == ("hip",)


@pytest.mark.parametrize(("column", "cells"), [("sensor", "abab"), ("sensor", "aabb"), ("sample", "0101")])
def test_rows_of_several_sensors_are_refused(column, cells):
    rows = "".join(f"{cell},{i},0,1\n" for i, cell in enumerate(cells))
    with pytest.raises(MocapFormatError, match=column):
        read(f"{column},pos_x,pos_y,pos_z\n{rows}", layout=None)


def test_a_label_of_each_frame_is_no_second_sensor():
    lines = table(sure=None).splitlines()
    labelled = [f"{label},{line}" for label, line in zip(["action", *"aaabbbccca"], lines, strict=False)]
    same(read("\n".join(labelled)), LAYOUT.keypoints(ARRAY[: len(labelled) - 1], 30))


HEAD = "nose_x,nose_y,nose_z"


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("nose_x,nose_y\n1,2\n", 1),
        (f"{HEAD},hip_x,hip_y\n1,2,3,4,5\n", 1),
        (f"{HEAD},nose_v,a_x,a_y,a_z\n1,2,3,1,1,2,3\n", 1),
        (f"{HEAD},nose_x\n1,2,3,1\n", 1),
        ("frame,name,x,y,z\n0,nose,1,2,3\n", 1),
        (f"{HEAD}\n1,2\n", 2),
        (f"{HEAD}\n\n1,2,3\n1,2,a\n", 4),
        (f"{HEAD}\n", None),
        (f"{HEAD},nose_score\n1,2,3,7\n", None),
        (f"{HEAD},nose_w\n1,2,3,1\n", 1),
        (f"frame,{HEAD}\n0,1,2,3\n1e9,1,2,3\n", None),
    ],
)
def test_what_is_refused(text, line):
    with pytest.raises(MocapFormatError) as caught:
        read(text, layout=None)
    assert caught.value.line == line
