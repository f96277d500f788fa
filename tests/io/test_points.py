"""What the readers of TRC and C3D share: markers at the origin, and the axis along which people stand."""

import io
import warnings

import c3d_files
import damaged
import numpy as np
import pytest

from skpose.io import load_c3d, load_trc

NAMES = ["head", "LASI", "L.Heel"]
# One who walks along the first axis, 1.7 m tall along the last.
BODY = np.array([[0.0, 0.0, 1700.0], [100.0, 120.0, 1000.0], [-200.0, 150.0, 50.0]])
WALK = BODY + np.arange(20)[:, None, None] * [60.0, 0.0, 0.0]
ORDERS = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}  # of the axes, so that this one is up


def c3d(positions, names=NAMES, up=None):
    return io.BytesIO(c3d_files.c3d_file(positions, names, axis_up=up))


def trc(positions, names=NAMES):
    return io.BytesIO(damaged.trc_file(points=positions, names=names))


def standing(axis, sign=1.0):
    return sign * WALK[:, :, ORDERS[axis]]


def messages(read, *arguments, **options):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read(*arguments, **options)
    return [str(one.message) for one in caught]


@pytest.mark.parametrize(("axis", "sign"), [("x", -1), ("y", -1), ("z", 1)])
def test_people_that_stand_along_another_axis_than_y(axis, sign):
    positions, up = standing(axis, sign), axis if sign > 0 else f"-{axis}"
    (message,) = messages(load_trc, trc(positions))
    assert f"up='{up}'" in message
    assert messages(load_trc, trc(positions), up="y") == []
    markers = load_trc(trc(positions), up=up)
    assert markers.up == axis
    heights = markers.positions[:, :, "xyz".index(axis)]
    assert (np.diff(heights, axis=1) < 0.0).all()


def test_a_c3d_file_says_which_axis_is_up_and_the_markers_another():
    (message,) = messages(load_c3d, c3d(standing("y"), up="+Z"))
    assert "POINT:Y_SCREEN" in message
    assert messages(load_c3d, c3d(standing("y"), up="+Y")) == []
    (first, second) = messages(load_c3d, c3d(standing("y")))
    assert "which axis points up" in first
    assert "pass up='y'" in second
    assert messages(load_c3d, c3d(standing("y")), up="y") == []
    assert messages(load_c3d, c3d(standing("z", -1.0), up="-Z")) == []


@pytest.mark.parametrize(("read", "write", "up"), [(load_c3d, c3d, {"up": "z"}), (load_trc, trc, {"up": "z"})])
def test_positions_of_zero(read, write, up):
    positions = WALK.copy()
    positions[3:6, 1] = 0.0
    positions[3, 2] = np.nan
    positions[4, 0] = 0.0, 0.0, 1700.0  # two zeros are a position
    (message,) = messages(read, write(positions), **up)
    assert "zeros='missing'" in message
    assert messages(read, write(positions), zeros="seen", **up) == []
    assert messages(read, write(positions), zeros="missing", **up) == []
    seen = read(write(positions), zeros="seen", **up)
    np.testing.assert_array_equal(seen.positions[3:6, 1], 0.0)
    assert seen.confidences.sum() == 59
    missing = read(write(positions), zeros="missing", **up)
    lost = np.zeros((20, 3), bool)
    lost[3:6, 1] = lost[3, 2] = True
    np.testing.assert_array_equal(missing.confidences == 0.0, lost)
    np.testing.assert_array_equal(missing.positions[~lost], seen.positions[~lost])


@pytest.mark.parametrize(("up", "turn"), [("-x", [-1, 1, -1]), ("-y", [1, -1, -1]), ("-z", [1, -1, -1])])
def test_an_axis_that_points_down_in_trc(up, turn):
    markers = load_trc(trc(WALK), up=up)
    assert markers.up == up[1]
    np.testing.assert_allclose(markers.positions, WALK / 1000 * turn, atol=1e-8)
