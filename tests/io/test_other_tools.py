"""Files of other tools: markers and segments that are read, and formats that are named with the way out."""

import io
import json
import struct
import zipfile

import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_keypoints, load_motion

POSITIONS = damaged.positions() / 1000
FILES = {
    "MVNX": (damaged.mvnx_file(), "z", np.nan_to_num(POSITIONS)),
    "Motive": (damaged.motive_file(), "y", POSITIONS),
    "Qualisys": (damaged.qualisys_file(), "z", POSITIONS),
    "Qualisys without frames and times": (damaged.qualisys_file(columns=False), "z", POSITIONS),
}


@pytest.mark.parametrize("kind", FILES)
def test_names_positions_rate_and_up(kind):
    data, up, positions = FILES[kind]
    found = load_keypoints(io.BytesIO(data), zeros="seen")
    np.testing.assert_allclose(found.positions, positions, atol=1e-6)
    assert (found.names, found.frame_rate, found.up) == (tuple(damaged.NAMES), 100.0, up)
    with pytest.warns(UserWarning, match="50 Hz is taken|replaces the 100 Hz"):
        assert load_keypoints(io.BytesIO(data), zeros="seen", up="x", frame_rate=50).up == "x"


@pytest.mark.parametrize(
    ("kind", "old", "new"),
    [
        ("MVNX", b'label="hip"', b'label="hip"/><segment label="toe"'),
        ("MVNX", b"</mvnx>", b""),
        ("Motive", b"Millimeters", b"Parsecs"),
        ("Motive", b"Position", b"Velocity"),
        ("Qualisys", b"MARKER_NAMES\thip", b"MARKER_NAMES\ttoe\thip"),
        ("Qualisys", b"MARKER_NAMES", b"BODY_NAMES"),
        ("Qualisys", b"FREQUENCY\t100", b"FREQUENCY\t-"),
    ],
)
def test_what_is_missing_is_refused(kind, old, new):
    data = FILES[kind][0]
    with pytest.raises(MocapFormatError):
        load_keypoints(io.BytesIO(data.replace(old, new)))


def test_older_files_of_motive_and_a_marker_that_is_lost_first():
    data = FILES["Motive"][0]
    for old, new in ((b",Type,", b",,"), (b",Name,", b",,"), (b",ID,", b",,"), (b"Export Frame Rate", b"Other")):
        data = data.replace(old, new)
    found = load_keypoints(io.BytesIO(data))
    assert (found.names, found.frame_rate) == (tuple(damaged.NAMES), 200.0)  # as captured
    lines = FILES["Qualisys without frames and times"][0].decode().splitlines()
    lines[7] = "\t".join(["NULL"] * 3 + lines[7].split("\t")[3:])
    lost = load_keypoints(io.StringIO("\n".join(lines)), zeros="seen")
    assert lost.positions.shape == POSITIONS.shape
    assert np.isnan(lost.positions[0, 0]).all()


def test_deeplabcut_in_three_dimensions():
    text = "scorer,net,net,net\nbodyparts,nose,nose,nose\ncoords,x,y,z\n0,0.1,0.2,0.3\n1,0.1,0.2,0.4\n"
    found = load_keypoints(io.StringIO(text), frame_rate=30)
    np.testing.assert_array_equal(found.positions, [[[0.1, 0.2, 0.3]], [[0.1, 0.2, 0.4]]])
    assert found.names == ("nose",)


def archive(name):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as zipped:
        zipped.writestr(name, "content")
    return file.getvalue()


NUMBERS = [round(0.01 * i, 2) for i in range(72)]


@pytest.mark.parametrize(
    ("data", "advice"),
    [
        (b"glTF" + struct.pack("<II", 2, 20), "Blender"),
        (b"Kaydara FBX Binary  \0", "Blender"),
        (b"\x89HDF\r\n\x1a\n" + bytes(64), "movement"),
        (struct.pack("<fHHH", 0.2, 1280, 720, 0), "body.data"),
        (archive("[Content_Types].xml"), "CSV"),
        (archive("model/data.pkl"), "numpy.savez"),
        (b"scorer,net,net,net\nbodyparts,nose,nose,nose\ncoords,x,y,likelihood\n0,1,2,0.9\n", "Anipose"),
        (json.dumps({"Loop": "wrap", "Frames": [NUMBERS]}).encode(), "own characters"),
        (json.dumps({"tracking": [{"data": {"player": {"NOSE": [1, 2, 5.5]}}}]}).encode(), "0.3048"),
        (b"0.0,0.0,0.8,1.0,0,0,0,0.1\n0.0,0.0,0.8,1.0,0,0,0,0.1\n", "motion_from_qpos"),
        (b"1\n2\n3\n", "numpy.loadtxt"),
    ],
)
def test_known_formats_are_named_with_the_way_out_by_all_readers(data, advice):
    for load in (load_motion, load_keypoints):
        with pytest.raises(MocapFormatError, match=advice):
            load(io.BytesIO(data))


@pytest.mark.parametrize(
    "document", [{"frames": [[[1, 2, i] for i in range(6)]]}, [{"Rh": [0, 9, 1], "Th": [0, 1, 1]}]]
)
def test_json_of_points_is_not_taken_for_these(document):
    options = {"names": "abcdef"} if isinstance(document, dict) else {}
    assert load_keypoints(io.StringIO(json.dumps(document)), frame_rate=30, zeros="seen", scale=0.1, **options)
