"""C3D files whose header and parameters differ, as public ones do: read where their length says which is right."""

import io
import struct

import c3d_files
import damaged
import numpy as np
import pytest

from skpose.io import MocapFormatError, file_format, load_c3d

POSITIONS, NAMES = damaged.positions(), damaged.NAMES
ANALOG = np.random.default_rng(6).normal(size=(20, 4, 2))
with_header = c3d_files.with_header


def load(data, **options):
    return load_c3d(io.BytesIO(data), **options)


def written(**options):
    options = {"axis_up": "+Z"} | options
    return c3d_files.c3d_file(options.pop("positions", POSITIONS), options.pop("labels", NAMES), **options)


def refused(data, match, **options):
    with pytest.raises(MocapFormatError):
        load(data, **options)


def moved(n_blocks):
    """Return a file with blocks between the header and the parameters."""
    data = written()
    start = struct.unpack("<H", data[16:18])[0] + n_blocks
    data = written(DATA_START=start)
    data = bytes([2 + n_blocks]) + data[1:512] + bytes(512 * n_blocks) + data[512:]
    return with_header(data, start=start)


@pytest.mark.parametrize("step", [None, 0.05], ids=["floats", "integers"])
@pytest.mark.parametrize("n_points", [1, 9, 10, 11, 13, 32, 266])
def test_any_number_of_points(n_points, step, tmp_path):
    """The third byte is the number of points: 10 is that of a line end."""
    positions = np.random.default_rng(n_points).uniform(-800, 800, (20, n_points, 3))
    names = [f"m{i}" for i in range(n_points)]
    more = [c3d_files.parameter(1, "LABELS2", names[255:])] if n_points > 255 else []
    data = written(positions=positions, labels=names[:255], step=step, more=more)
    (tmp_path / "a.c3d").write_bytes(data)
    for markers in (load(data), load_c3d(tmp_path / "a.c3d")):
        assert markers.names == tuple(names)
        np.testing.assert_allclose(markers.positions, positions / 1000, atol=(step or 1e-3) / 2000 * 1.001)
    assert file_format(tmp_path / "a.c3d") == "C3D"


@pytest.mark.parametrize("n_blocks", [3, 7, 8, 30, 78])
def test_parameters_that_begin_in_another_block(n_blocks):
    """Their block is the first byte, which may be that of a tab, a line end or a letter."""
    np.testing.assert_array_equal(load(moved(n_blocks)).positions, load(written()).positions)


@pytest.mark.parametrize(
    ("data", "differ"),
    [
        (written(USED=4), "points: 4 or 3"),
        (with_header(written(), n_points=5), "points: 3 or 5"),
        (written(USED=None), "only the header says how many points there are"),
        (written(FRAMES=32), "frames: 32 or 20"),
        (with_header(written(), last=40), "frames: 20 or 40"),
        (with_header(written(), scale=0.1), "numbers are floats: True or False"),
        (with_header(written(analog=ANALOG), samples=3), "analog samples a frame: 6 or 8"),
        (with_header(written(analog=ANALOG), analog=0), "analog samples a frame: 8 or 0"),
        (with_header(written(analog=ANALOG), analog=0, samples=0), "analog samples a frame: 0 or 8"),
    ],
)
def test_the_length_of_the_file_says_which_is_right(data, differ):
    expected = load(written()).positions
    with pytest.warns(UserWarning, match=rf"{differ}.*: 20 frames of 3 points fit the length of the file"):
        np.testing.assert_array_equal(load(data).positions, expected)


def test_what_the_length_does_not_decide_is_refused():
    """Two points and three of 20 frames both leave less than a block."""
    refused(written(USED=2), "points: 2 or 3.*the length of the file fits more than one: which are the points")
    data = with_header(written(), n_points=40)
    refused(data[: len(data) - 512], "states 20 frames of 3 points, but .*fits neither")


def test_a_file_whose_header_says_all():
    """No group POINT at all: the unit must be said, points are numbered."""
    data = written()
    bare = data[:512] + bytes([1, 80, 0, 84]) + bytes(508) + data[1024:]
    with pytest.warns(UserWarning, match="only the header says|none of its 3 points") as caught:
        markers = load(bare, scale=0.001, up="z")
    assert [str(one.message).partition(": ")[2][:32] for one in caught] == [
        "only the header says how many po",
        "none of its 3 points has a name ",
    ]
    np.testing.assert_array_equal(markers.positions, load(data).positions)
    assert (markers.names, markers.frame_rate) == (("1", "2", "3"), 100.0)


def test_all_residuals_negative():
    """Some program writes -1 for a residual that it does not know; where positions are equal, nothing was seen."""
    positions = np.nan_to_num(POSITIONS, nan=700.0)
    data = bytearray(written(positions=positions))
    first = 512 * (struct.unpack("<H", data[16:18])[0] - 1)
    for at in range(first + 12, first + 20 * 3 * 16, 16):
        data[at : at + 4] = struct.pack("<f", -1.0)
    with pytest.warns(UserWarning, match="all residuals are negative, .* all markers are read as seen"):
        markers = load(bytes(data))
    np.testing.assert_allclose(markers.positions, positions / 1000, rtol=1e-6)
    data[first + 12 : first + 16] = struct.pack("<f", 0.0)  # one is seen: the others are lost
    assert load(bytes(data)).confidences.sum() == 1.0
    assert load(written(positions=np.full((20, 3, 3), np.nan))).confidences.sum() == 0.0
