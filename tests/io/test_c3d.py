"""C3D files: formats of numbers, units and axes; what is refused. ezc3d, another reader, is a second opinion."""

import gzip
import io
import struct

import c3d_files
import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_c3d

POSITIONS, NAMES = damaged.positions(), damaged.NAMES


with_header = c3d_files.with_header


def load(data, **options):
    return load_c3d(io.BytesIO(data), **options)


def written(**options):
    options = {"axis_up": "+Z"} | options
    return c3d_files.c3d_file(options.pop("positions", POSITIONS), options.pop("labels", NAMES), **options)


def refused(data, match, **options):
    with pytest.raises(MocapFormatError, match=match):
        load(data, **options)


@pytest.mark.parametrize("samples", [0, 4], ids=["points", "with analog data"])
@pytest.mark.parametrize("step", [None, 0.05], ids=["floats", "integers"])
@pytest.mark.parametrize("processor", [c3d_files.INTEL, c3d_files.DEC, c3d_files.MIPS], ids=["Intel", "DEC", "MIPS"])
def test_formats_of_numbers(processor, step, samples):
    analog = np.random.default_rng(0).normal(size=(20, samples, 2))
    markers = load(written(processor=processor, step=step, analog=analog))
    rounding = 1e-4 if step is None else step / 2 * 1.001
    np.testing.assert_allclose(markers.positions, POSITIONS / 1000, rtol=0, atol=rounding / 1000)
    np.testing.assert_array_equal(np.isnan(markers.positions), np.isnan(POSITIONS))
    assert (markers.names, markers.frame_rate, markers.up) == (tuple(NAMES), 100.0, "z")


def test_a_file_that_ezc3d_has_written(tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [120.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = tuple(NAMES)
    file["parameters"]["POINT"]["UNITS"]["value"] = ("mm",)
    file["parameters"]["ANALOG"]["RATE"]["value"] = [240.0]
    file["parameters"]["ANALOG"]["LABELS"]["value"] = ("force",)
    file["data"]["points"] = np.concatenate([POSITIONS.transpose(2, 1, 0), np.ones((1, 3, 20))])
    file["data"]["analogs"] = np.zeros((1, 1, 40))
    file.write(str(tmp_path / "a.c3d"))
    with pytest.warns(UserWarning, match=r"a\.c3d: it does not say which axis points up .* z is taken"):
        markers = load_c3d(tmp_path / "a.c3d")
    np.testing.assert_allclose(markers.positions, POSITIONS / 1000, rtol=0, atol=1e-7)
    assert (markers.names, markers.frame_rate, markers.up) == (tuple(NAMES), 120.0, "z")


def test_sources(tmp_path):
    data = written()
    (tmp_path / "größe.c3d").write_bytes(data)
    (tmp_path / "a.c3d.gz").write_bytes(gzip.compress(data))
    for file in (tmp_path / "größe.c3d", str(tmp_path / "a.c3d.gz"), io.BytesIO(gzip.compress(data))):
        np.testing.assert_array_equal(load_c3d(file).positions, load(data).positions)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.c3d.gz", "größe.c3d"]
    with pytest.raises(FileNotFoundError):
        load_c3d(tmp_path / "none.c3d")


def test_a_negative_residual_alone_is_a_lost_marker():
    data = bytearray(written(positions=np.full((1, 3, 3), 700.0)))
    at = len(data) - 512
    data[at : at + 12] = struct.pack("<3f", 0.0, 0.0, 0.0)  # seen at the origin
    data[at + 28 : at + 32] = struct.pack("<f", -1.0)  # not seen, at (700, 700, 700)
    markers = load(bytes(data), zeros="seen")
    np.testing.assert_array_equal(markers.confidences, [[1.0, 0.0, 1.0]])
    np.testing.assert_array_equal(markers.positions[0, 0], 0.0)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 0.001), ("cm", 0.01), ("m ", 1.0), ("IN", 0.0254)])
@pytest.mark.filterwarnings("ignore:.* m from end to end in the median frame:UserWarning")
def test_units_are_the_files_own_word(unit, metres):
    np.testing.assert_allclose(load(written(units=unit)).positions, POSITIONS * metres, rtol=1e-6)


@pytest.mark.parametrize("unit", [None, "", "parsec"])
def test_an_unknown_unit_is_refused_unless_scale_says_what_it_is(unit):
    refused(written(units=unit), "POINT:UNITS: expected a unit of length such as mm, .* scale=")
    np.testing.assert_allclose(load(written(units=unit), scale=0.001).positions, POSITIONS / 1000, rtol=1e-6)


def test_the_axis_that_points_up():
    for axis in "XYZ":
        assert load(written(axis_up=f"+{axis}")).up == load(written(axis_up=axis)).up == axis.lower()
    assert load(written(), up="y").up == "y"
    refused(written(axis_up="+W"), r"POINT:Y_SCREEN: expected \+X, .* or -Z, found '\+W'; up= chooses the axis")
    assert load(written(axis_up="+W"), up="z").up == "z"
    with pytest.raises(ValueError, match="up must be 'x' or 'y' or 'z' or '-x' or '-y' or '-z', got 'up'"):
        load(written(), up="up")


@pytest.mark.parametrize(
    ("up", "turned"), [("-x", [-1.0, 1.0, -1.0]), ("-y", [1.0, -1.0, -1.0]), ("-z", [1.0, -1.0, -1.0])]
)
def test_an_axis_that_points_down(up, turned):
    """Half a turn, by the file's own word or by the option: what pointed down points up, and nothing is mirrored."""
    expected = load(written()).positions * turned
    for markers in (load(written(), up=up), load(written(axis_up=up.upper()))):
        assert markers.up == up[1]
        np.testing.assert_array_equal(markers.positions, expected)
    assert np.linalg.det(np.diag(turned)) == 1.0


def test_labels_in_several_parameters():
    positions = np.random.default_rng(1).uniform(-800, 800, (2, 300, 3))
    names = [f"marker{i}" for i in range(300)]
    more = [c3d_files.parameter(1, "LABELS2", names[255:])]
    markers = load(written(positions=positions, labels=names[:255], more=more))
    assert markers.names == tuple(names)
    np.testing.assert_allclose(markers.positions, positions / 1000, rtol=1e-6)


def test_points_without_a_label_and_labels_without_a_point():
    for labels in (["hip", "", "ankle"], ["hip", "   ", "ankle", "toe"]):
        with pytest.warns(UserWarning, match="1 of 3 points have no label and are left out"):
            markers = load(written(labels=labels))
        assert markers.names == ("hip", "ankle")
        np.testing.assert_allclose(markers.positions, POSITIONS[:, [0, 2]] / 1000, rtol=1e-6)
    with pytest.warns(UserWarning, match=r"none of its 3 points has a name .* they are called '1' to '3' here"):
        markers = load(written(labels=["", "", ""]))
    assert markers.names == ("1", "2", "3")
    np.testing.assert_array_equal(markers.positions, load(written()).positions)


def test_labels_that_are_given_twice_are_numbered():
    with pytest.warns(UserWarning, match="several points are named 'hip'; the next one is 'hip_3' here$"):
        markers = load(written(labels=["hip", "hip_2", "hip"]))
    assert markers.names == ("hip", "hip_2", "hip_3")
    np.testing.assert_array_equal(markers.positions, load(written()).positions)
    with pytest.warns(UserWarning, match="the next one is 'hip_2' here, and 1 more likewise"):
        assert load(written(labels=["hip"] * 3)).names == ("hip", "hip_2", "hip_3")


def test_the_number_of_frames():
    positions = np.ones((65535, 1, 3))
    assert len(load(written(positions=positions[:40000], labels=["a"]))) == 40000  # -25536 as a signed integer
    assert len(load(written(positions=positions, labels=["a"]))) == 65535
    more = {"positions": np.ones((70000, 1, 3)), "labels": ["a"], "FRAMES": -1}
    refused(written(**more), "more than the 65535 frames that it states")
    assert len(load(written(**more, LONG_FRAMES=70000.0))) == 70000
    more = {"positions": positions, "labels": ["a"], "FRAMES": -1}
    refused(written(**more, LONG_FRAMES=70000.0), "it states 70000 frames of 1 points, and holds 655")
    assert len(load(written(FRAMES=None))) == 20  # the header states it too
    with pytest.warns(UserWarning, match=r"differ \(frames: 12 or 20\): 12 frames of 3 points fit the length"):
        assert len(load(written(FRAMES=12))) == 12  # the points are certain, and so many are stated twice


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (written(USED=0), "it holds no points: is it a file of analog channels"),
        (written(USED=-1), "it states 20 frames of -1 points"),
        (
            with_header(written(USED=30000), n_points=30000),
            "it states 20 frames of 30000 points, and holds 0; is it cut",
        ),
        (
            with_header(written(FRAMES=21, positions=np.ones((20, 32, 3)), labels=["a"]), last=21),
            "states 21 frames of 32 points, and holds 20",
        ),
        (with_header(written(USED=0, FRAMES=0), last=0), "it holds no points"),
        (with_header(written(FRAMES=0), last=0), "it states 0 frames of 3 points: expected at least one"),
        (written(USED=np.zeros(0, int)), "POINT:USED: expected a number, found nothing"),
        (
            written(USED=2),
            r"differ \(points: 2 or 3\), and the length of the file fits more than one: which are the po",
        ),
        (
            with_header(written(USED=50), n_points=40),
            r"but .* differ \(points: 50 or 40\), and the length of the file, \d+ bytes, fits neither",
        ),
        (with_header(written(USED=None), n_points=40), "only the header says how many points .* fits neither"),
        (written(USED="three"), "POINT:USED: expected a number, found text"),
        (written(SCALE=np.nan), "POINT:SCALE: expected one finite number, found nan"),
        (written(SCALE=np.array([-1.0, 1.0])), "POINT:SCALE: expected one finite number, found -1, 1"),
        (written(SCALE=0.0), "POINT:SCALE: expected a number that is not zero, found 0"),
        (written(RATE=-5.0), "POINT:RATE: expected a positive number, found -5"),
        (with_header(written(DATA_START=1), start=1), "begin at block 1 by the header, which cannot be: is the"),
        (with_header(written(DATA_START=999), start=999), "begin at block 999 by the header, which cannot be: is the"),
        (written(LABELS=3), "POINT:LABELS: expected text, found numbers"),
        (written(RATE=np.zeros(0)), "POINT:RATE: expected a number, found nothing"),
        (written(more=[c3d_files.parameter(1, "USED", 2)]), "it has two parameters POINT:USED, which differ"),
        (written(more=[c3d_files.parameter(2, "USED", -1)]), "ANALOG:USED"),
        (b"\x02P\0", "expected a header and parameters, found 3 bytes; is the file cut short"),
        (b"hello", "expected a C3D file|C3D"),
        (b"", "the file is empty, not a C3D file"),
    ],
)
def test_what_is_refused(data, message):
    refused(data, message)


def test_what_points_do_not_need_cannot_refuse_a_file():
    """Rotations, descriptions of any length, a last record that goes too far, values that their record has not."""
    described = struct.pack("2b", 4, 2) + b"NOTE" + struct.pack("<HbbB", 206, 1, 0, 200) + b"x" * 201
    more = [
        struct.pack("2b", 8, -3) + b"ROTATION\x03\0\0",
        c3d_files.parameter(3, "USED", 2),
        struct.pack("2b", 5, -4) + b"POINT\x03\0\0",  # another group of this name
        described,
        c3d_files.parameter(2, "NOTES", np.zeros(3, int), shape=(255, 255)),
        struct.pack("2b", 4, 2) + b"LAST" + struct.pack("<H", 60000),
    ]
    np.testing.assert_array_equal(load(written(more=more)).positions, load(written()).positions)
    refused(written(LABELS=None, more=[c3d_files.parameter(1, "LABELS", 3, shape=(255, 255))]), "is it damaged")


def test_what_only_the_header_states():
    """The first block of the frames, the scale, the frame rate."""
    markers = load(written(SCALE=None, RATE=None, DATA_START=0, step=0.05))
    np.testing.assert_array_equal(markers.positions, load(written(step=0.05)).positions)
    assert markers.frame_rate == 100


def test_analog_channels_that_only_the_header_states():
    data = written(analog=np.ones((20, 4, 2))).replace(b"\x04\x02USED", b"\x04\x02LOST")
    np.testing.assert_array_equal(load(data).positions, load(written()).positions)


def test_every_shorter_file_is_refused():
    """ezc3d takes most of these for whole files, with fewer frames."""
    data = written()
    whole = len(data.rstrip(b"\0"))
    for n in [*range(0, 512, 7), *range(512, whole - 40, 3)]:
        refused(data[:n], r"cut short|ends|parameters|damaged|empty|is none")


def test_damage_to_single_bytes():
    """Bytes of the header and the parameters are zero, one, their largest values: ezc3d crashes."""
    outcomes = [
        damaged.outcome("C3D", data[:at] + bytes([value]) + data[at + 1 :])
        for data in damaged.c3d_kinds()[1:2]
        for at in [*range(24), *range(512, 512 + 420, 2)]
        for value in (0, 1, 127, 255)
    ]
    assert {"read", "refused"} == set(outcomes)


@pytest.mark.parametrize("data", damaged.c3d_kinds())
def test_positions_are_those_of_ezc3d(data, tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    (tmp_path / "a.c3d").write_bytes(data)
    points = ezc3d.c3d(str(tmp_path / "a.c3d"))["data"]["points"][:3].transpose(2, 1, 0)
    np.testing.assert_array_equal(load(data).positions, np.ascontiguousarray(points) * 0.001)
