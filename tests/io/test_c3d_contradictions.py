"""C3D files whose header and parameters differ, as public ones do: read where their length says which is right."""

import io
import struct

import c3d_files
import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, load_c3d
from skpose.io._formats import format_of

POSITIONS, NAMES = damaged.positions(), damaged.NAMES
ANALOG = np.random.default_rng(6).normal(size=(20, 4, 2))
with_header = c3d_files.with_header


def load(data, **options):
    return load_c3d(io.BytesIO(data), **options)


def written(**options):
    options = {"axis_up": "+Z"} | options
    return c3d_files.c3d_file(options.pop("positions", POSITIONS), options.pop("labels", NAMES), **options)


@pytest.mark.parametrize("n_points", [1, 10, 266])
def test_any_number_of_points(n_points):
    """The third byte is the number of points: 10 is that of a line end."""
    positions = np.random.default_rng(n_points).uniform(-800, 800, (20, n_points, 3))
    names = [f"m{i}" for i in range(n_points)]
    more = [c3d_files.parameter(1, "LABELS2", names[255:])] if n_points > 255 else []
    data = written(positions=positions, labels=names[:255], more=more)
    assert format_of(io.BytesIO(data)).name == "C3D"
    assert load(data).names == tuple(names)
    np.testing.assert_allclose(load(data).positions, positions / 1000, atol=1e-6)


@pytest.mark.parametrize(
    "data",
    [
        written(USED=4),
        with_header(written(), n_points=5),
        written(FRAMES=32),
        with_header(written(), last=40),
        with_header(written(), scale=0.1),
        with_header(written(analog=ANALOG), analog=0),
    ],
)
def test_the_length_of_the_file_says_which_is_right(data):
    with pytest.warns(UserWarning, match="differ: 20 frames of 3 points"):
        np.testing.assert_array_equal(load(data).positions, load(written()).positions)


def test_what_the_length_does_not_decide_is_refused():
    """Two points and three of 20 frames both leave less than a block."""
    with pytest.raises(MocapFormatError):
        load(written(USED=2))
    with pytest.raises(MocapFormatError):
        load(with_header(written(), n_points=40)[:-512])


def test_a_file_whose_header_says_all():
    """No group POINT at all: the unit must be said, points are numbered."""
    data = written()
    bare = data[:512] + bytes([1, 80, 0, 84]) + bytes(508) + data[1024:]
    with pytest.warns(UserWarning, match="none of its 3 points"):
        markers = load(bare, scale=0.001, up="z")
    np.testing.assert_array_equal(markers.positions, load(data).positions)
    assert (markers.names, markers.frame_rate) == (("1", "2", "3"), 100.0)


def test_all_residuals_negative():
    """Some program writes -1 for a residual that it does not know; where positions are equal, nothing was seen."""
    positions = np.nan_to_num(POSITIONS, nan=700.0)
    data = bytearray(written(positions=positions))
    first = 512 * (struct.unpack("<H", data[16:18])[0] - 1)
    for at in range(first + 12, first + 20 * 3 * 16, 16):
        data[at : at + 4] = struct.pack("<f", -1.0)
    with pytest.warns(UserWarning, match="all residuals are negative"):
        markers = load(bytes(data))
    np.testing.assert_allclose(markers.positions, positions / 1000, rtol=1e-6)
    data[first + 12 : first + 16] = struct.pack("<f", 0.0)  # one is seen: the others are lost
    assert load(bytes(data)).confidences.sum() == 1.0
    assert load(written(positions=np.full((20, 3, 3), np.nan))).confidences.sum() == 0.0


@pytest.mark.parametrize("record", [c3d_files.parameter(1, "UNITS", "m"), c3d_files.parameter(1, "RATE", 50.0)])
def test_parameters_that_are_given_twice_and_differ_are_refused(record):
    with pytest.raises(MocapFormatError):
        load(written(more=[record]))
    same = c3d_files.parameter(1, "UNITS", "mm")
    np.testing.assert_array_equal(load(written(more=[same])).positions, load(written()).positions)


def test_a_rate_and_a_scale_that_differ_from_the_header_are_said():
    with pytest.warns(UserWarning, match="POINT:RATE"):
        assert load(with_header(written(), rate=50.0)).frame_rate == 100.0
    with pytest.warns(UserWarning, match="POINT:SCALE"):
        found = load(with_header(written(step=0.05), scale=0.1))
    np.testing.assert_array_equal(found.positions, load(written(step=0.05)).positions)
    load(with_header(written(), scale=-0.3))  # floats have no scale


def test_a_rate_can_be_stated():
    data = with_header(written(RATE=0.0), rate=0.0)
    with pytest.raises(MocapFormatError, match="frame_rate="):
        load(data)
    assert load(data, frame_rate=120).frame_rate == 120.0
    with pytest.warns(UserWarning, match="frame_rate=50 replaces"):
        assert load(written(), frame_rate=50).frame_rate == 50.0
