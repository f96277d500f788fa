"""C3D files: formats of numbers, units and axes; what is refused. ezc3d, another reader, is a second opinion."""

import io
import struct

import c3d_files
import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_c3d

POSITIONS, NAMES = damaged.positions(), damaged.NAMES


def load(data, **options):
    return load_c3d(io.BytesIO(data), **options)


def written(**options):
    options = {"axis_up": "+Z"} | options
    return c3d_files.c3d_file(options.pop("positions", POSITIONS), options.pop("labels", NAMES), **options)


def refused(data, **options):
    with pytest.raises(MocapFormatError):
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


@pytest.mark.parametrize(("unit", "metres"), [("cm", 0.01), ("IN", 0.0254), ("mete", 1.0)])
@pytest.mark.filterwarnings("ignore:.* m from end to end in the median frame:UserWarning")
def test_units_are_the_files_own_word(unit, metres):
    np.testing.assert_allclose(load(written(units=unit)).positions, POSITIONS * metres, rtol=1e-6)


@pytest.mark.filterwarnings("ignore:.* m from end to end in the median frame:UserWarning")
def test_a_scale_that_contradicts_the_unit_of_the_file_is_said():
    with pytest.warns(UserWarning, match="scale=0.5"):
        np.testing.assert_allclose(load(written(units="cm"), scale=0.5).positions, POSITIONS / 2, rtol=1e-6)
    load(written(units="cm"), scale=0.01)


@pytest.mark.parametrize("unit", [None, "parsec"])
def test_an_unknown_unit_is_refused_unless_scale_says_what_it_is(unit):
    refused(written(units=unit))
    np.testing.assert_allclose(load(written(units=unit), scale=0.001).positions, POSITIONS / 1000, rtol=1e-6)


def test_the_axis_that_points_up():
    for axis in "XYZ":
        assert load(written(axis_up=f"+{axis}")).up == load(written(axis_up=axis)).up == axis.lower()
    assert load(written(), up="y").up == "y"
    refused(written(axis_up="+W"))
    assert load(written(axis_up="+W"), up="z").up == "z"


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
    with pytest.warns(UserWarning, match="none of its 3 points has a name"):
        markers = load(written(labels=["", "", ""]))
    assert markers.names == ("1", "2", "3")
    np.testing.assert_array_equal(markers.positions, load(written()).positions)


def test_labels_that_are_given_twice_are_numbered():
    with pytest.warns(UserWarning, match="several points are named 'hip'; the next one is 'hip_3' here$"):
        markers = load(written(labels=["hip", "hip_2", "hip"]))
    assert markers.names == ("hip", "hip_2", "hip_3")
    np.testing.assert_array_equal(markers.positions, load(written()).positions)


def test_the_number_of_frames():
    positions = np.ones((65535, 1, 3))
    assert len(load(written(positions=positions[:40000], labels=["a"]))) == 40000  # -25536 as a signed integer
    assert len(load(written(positions=positions, labels=["a"]))) == 65535
    many = written(positions=np.ones((100000, 1, 3)), labels=["a"], FRAMES=100000.0)
    assert len(load(many)) == 100000  # as a float
    more = {"positions": np.ones((70000, 1, 3)), "labels": ["a"], "FRAMES": -1}
    refused(written(**more))
    assert len(load(written(**more, LONG_FRAMES=70000.0))) == 70000
    more = {"positions": positions, "labels": ["a"], "FRAMES": -1}
    refused(written(**more, LONG_FRAMES=70000.0))
    assert len(load(written(FRAMES=None))) == 20  # the header states it too
    with pytest.warns(UserWarning, match="differ: 12 frames"):
        assert len(load(written(FRAMES=12))) == 12  # the points are certain, and so many are stated twice


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
    refused(written(LABELS=None, more=[c3d_files.parameter(1, "LABELS", 3, shape=(255, 255))]))


@pytest.mark.parametrize("data", damaged.c3d_kinds())
def test_positions_are_those_of_ezc3d(data, tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    (tmp_path / "a.c3d").write_bytes(data)
    points = ezc3d.c3d(str(tmp_path / "a.c3d"))["data"]["points"][:3].transpose(2, 1, 0)
    np.testing.assert_array_equal(load(data).positions, np.ascontiguousarray(points) * 0.001)
