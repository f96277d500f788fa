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
HEADERS = {
    "snake": "{name}_{axis}",
    "dots": "{name}.{axis}",
    "blanks": "{name} {axis}",
    "upper": "{name}_{axis}",
    "colons": "{name}:{axis}",
    "before": "{axis}_{name}",
}


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


@pytest.mark.parametrize("sure", ["visibility", "confidence", "score", "likelihood", "c", None])
@pytest.mark.parametrize("form", HEADERS)
def test_headers(form, sure):
    text = table(HEADERS[form], sure)
    if form == "upper":
        head, rest = text.split("\n", 1)
        text = f"{head.upper()}\n{rest}"
    same(read(text), LAYOUT.keypoints(ARRAY, 30, SURE if sure else None))


@pytest.mark.parametrize(("separator", "end"), [(",", "\r\n"), (";", "\n"), ("\t", "\n"), (",", "\r")])
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


@pytest.mark.parametrize("form", ["{axis}{name}", "{axis}_{name}", "{name}_{axis}", "landmark_{name}_{axis}"])
@pytest.mark.parametrize("first", [0, 1])
def test_numbers_are_the_order_of_the_points(form, first):
    order = [*range(16, -1, -1)]
    names = [first + i for i in order]
    text = table(form, "v" if form.startswith("{axis}") else "score", names, ARRAY[:, order])
    confidences = np.empty_like(SURE)
    confidences[:, order] = SURE
    same(read(text), LAYOUT.keypoints(ARRAY, 30, confidences))
    with pytest.raises(ValueError, match="does not name its points: pass layout=, or names="):
        read(text, layout=None)
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


def test_anipose():
    """Errors, numbers of cameras and a matrix stand next to x, y and z; fnum is the frame."""
    head = "a_x,a_y,a_z,a_error,a_ncams,a_score,M_00,M_01,center_0,fnum"
    found = read(f"{head}\n1,2,3,0.1,2,0.9,1,0,0,0\n1,2,4,0.1,2,0.8,1,0,0,1\n", layout=None)
    same(found, Keypoints([[[1.0, 2, 3]], [[1, 2, 4]]], ["a"], 30, [[0.9], [0.8]]))


def test_rotations_and_velocities_next_to_points_are_left_out():
    names = [*LAYOUT.names, "nose_rot", "HipRotation", "left knee euler", "wrist_vel", "acc"]
    array = np.concatenate([ARRAY, 90 * ARRAY[:, :5]], axis=1)
    text = table(names=names, array=array, sure=None)
    for options in ({}, {"layout": None}):
        with pytest.warns(
            UserWarning, match="'nose_rot', 'HipRotation', 'left knee euler' and others: no positions by"
        ):
            found = read(text, **options)
        np.testing.assert_array_equal(found.positions[:, :17], ARRAY)
    assert found.names == LAYOUT.names


HEAD = "nose_x,nose_y,nose_z"
REFUSED = [
    ("nose_x,nose_y\n1,2\n", "in two dimensions: 'nose' has x and y, and no z. Lengths of bones are not known"),
    ("nose_x,nose_y,nose_score,hip_x,hip_y,hip_score\n1,2,1,1,2,1\n", "line 1: these are keypoints in two dimensions"),
    (f"{HEAD},hip_x,hip_y\n1,2,3,4,5\n", "line 1: the point 'hip' has x and y, and no z"),
    (f"{HEAD},nose_v,a_x,a_y,a_z\n1,2,3,1,1,2,3\n", "line 1: some points have a confidence, and 'a' has none"),
    (f"{HEAD},nose_x\n1,2,3,1\n", "line 1: the header has 'nose_x' 2 times"),
    ("frame,name,x,y,z\n0,nose,1,2,3\n", "line 1: one row for each point, where one for each frame is expected.*pivot"),
    (f"{HEAD}\n1,2\n", "line 2: expected 3 cells, as in the header, found 2"),
    (f"{HEAD}\n\n1,2,3\n1,2,a\n", "line 4: nose_z: expected a number, found 'a'"),
    ("nose_x;nose_y;nose_z\n1,5;2;3\n", "line 2: nose_x: expected a number, found '1,5', which has a decimal comma"),
    (f"{HEAD}\n1,2,1_0\n", "line 2: nose_z: expected a number, found '1_0'"),
    (f"{HEAD}\n", "expected a row for each frame after the header, found none"),
    (f"{HEAD}\n1,2,inf\n", "positions are infinite at frame 0, point 0"),
    (
        f"{HEAD},nose_score\n1,2,3,7\n",
        "confidences must be from 0, not seen, to 1, or COCO's 0, 1 and 2; found 7: divide",
    ),
    (f"{HEAD},nose_score\n1,2,3,1.5\n", "confidences must be from 0, not seen, to 1, or COCO's 0, 1 and 2; found 1.5"),
    (f"{HEAD},nose_w\n1,2,3,1\n", "line 1: expected positions of points, found x, y, z and w of 'nose', as of a rota"),
    ("x0,y0,z0,w0\n1,2,3,1\n", "found x, y, z and w of '0', as of a rotation: if w is how sure each point is, name it"),
    ("noseX,noseY,noseZ,noseW\n1,2,3,1\n", "found x, y, z and w of 'nose'"),
    (
        "hip_rot_x,hip_rot_y,hip_rot_z\n1,2,3\n",
        "expected positions of points, found 'hip_rot', which are none by their",
    ),
    ("acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z\n1,2,3,4,5,6\n", "found 'acc', 'gyro', which are none by their names"),
    (f"frame,{HEAD}\n0.5,1,2,3\n", "numbers of frames: expected whole numbers"),
    (f"frame,{HEAD}\n0,1,2,3\n1e9,1,2,3\n", "numbers of frames go from 0 to 1e\\+09 in 2 frames"),
    ("a,b,c\n1,2,3\n", r"expected keypoints as JSON, CSV with a header, \.npz or \.npy, found 'a,b,c'"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_what_is_refused(text, message):
    with pytest.raises(MocapFormatError):
        read(text, layout=None)
    with pytest.raises(MocapFormatError):
        read(text)
