"""The root of in-betweens: closed forms of its path and of its rotation, and what is kept."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from skpose import Motion, Skeleton
from skpose.geodesics import interpolate

ARM = Skeleton.chain(2)
TIMES = np.array([0.0, 0.5, 0.8, 1.4])
METHODS = ["geodesic", "spline"]


def keys_of(n=4, axes="ZXY", seed=0, size=0.6):
    rng = np.random.default_rng(seed)
    root = size * rng.normal(size=(n, len(axes)))
    angles = 0.4 * rng.normal(size=(n, 2))
    return Motion(ARM, angles, 2.0, rng.normal(size=(n, 3)), root, axes, up="z", root_name="Hips")


def orientations(motion):
    return Rotation.from_euler(motion.root_axes, motion.root_angles)


@pytest.mark.parametrize("method", METHODS)
def test_keys_on_frames_are_met_and_what_they_say_is_kept(method):
    keys = keys_of()
    motion = interpolate(keys, TIMES, frame_rate=10, method=method)
    on_key = [0, 5, 8, 14]
    np.testing.assert_array_equal(motion.root_positions[on_key], keys.root_positions)
    np.testing.assert_allclose((orientations(motion)[on_key] * orientations(keys).inv()).magnitude(), 0, atol=1e-12)
    assert (motion.up, motion.root_name, motion.root_axes) == ("z", "Hips", "ZXY")
    assert motion.skeleton is keys.skeleton
    assert np.abs(np.diff(motion.root_angles, axis=0)).max() < 1.0
    np.testing.assert_array_equal(
        motion.angles, interpolate(keys.angles, TIMES, ARM, frame_rate=10, method=method).angles
    )


def test_geodesic_goes_straight_and_rotates_by_slerp():
    keys = keys_of()
    motion = interpolate(keys, TIMES, frame_rate=20, method="geodesic")
    R = orientations(keys)
    for t, place, rotation in zip(motion.times, motion.root_positions, orientations(motion), strict=True):
        i = min(int(np.searchsorted(TIMES, t + 1e-9, side="right")) - 1, 2)
        s = (t - TIMES[i]) / (TIMES[i + 1] - TIMES[i])
        np.testing.assert_allclose(place, (1 - s) * keys.root_positions[i] + s * keys.root_positions[i + 1], atol=1e-9)
        expected = R[i] * Rotation.from_rotvec(s * (R[i].inv() * R[i + 1]).as_rotvec())
        assert (rotation * expected.inv()).magnitude() < 1e-9


@pytest.mark.slow
def test_spline_is_the_natural_cubic_one_and_rotates_smoothly():
    keys = keys_of()
    motion = interpolate(keys, TIMES, frame_rate=2000)
    expected = CubicSpline(TIMES, keys.root_positions, bc_type="natural")(motion.times)
    np.testing.assert_allclose(motion.root_positions, expected, atol=1e-9)

    def jump(method):
        """The largest change of the angular velocity from frame to frame, rad/s."""
        root = orientations(interpolate(keys, TIMES, frame_rate=2000, method=method))
        rates = 2000 * (root[1:] * root[:-1].inv()).as_rotvec()
        return np.linalg.norm(np.diff(rates, axis=0), axis=1).max()

    assert jump("spline") < 0.1
    assert jump("geodesic") > 1.0
