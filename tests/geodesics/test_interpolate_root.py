"""The root of in-betweens: closed forms of its path and of its rotation, and what is kept."""

import numpy as np
import pytest
from conftest import SKELETONS
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from skpose import Motion, Skeleton
from skpose.geodesics import interpolate
from skpose.io import load_bvh, save_bvh
from skpose.kinematics import retarget

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


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("axes", ["", "z", "y", "zx", "xyz"])
def test_axes_stay_where_they_can(axes, method):
    motion = interpolate(keys_of(axes=axes), TIMES, frame_rate=10, method=method)
    assert motion.root_axes == ("xyz" if axes == "zx" else axes)
    if len(axes) == 1 and method == "geodesic":
        expected = np.interp(motion.times, TIMES, keys_of(axes=axes).root_angles[:, 0])
        np.testing.assert_allclose(motion.root_angles[:, 0], expected, atol=1e-9)


def test_times_and_skeleton_are_those_of_the_motion():
    motion = Motion(ARM, np.sin(np.linspace(0, 3, 61))[:, None] * [1, 1], 60, np.linspace([0, 0, 0], [0, 0, 2], 61))
    for keys in (motion[::10], motion[10:][::10], motion.resample(6)):
        found = interpolate(keys, frame_rate=60)
        assert len(found) == 10 * (len(keys) - 1) + 1
        np.testing.assert_allclose(np.diff(found.root_positions[:, 2]), 2 / 60, atol=1e-12)
    assert len(interpolate(motion[::20], [1.0, 2.0, 2.5, 3.0], ARM, frame_rate=10)) == 21


def test_two_keys():
    keys = keys_of(2)
    one, other = (interpolate(keys, [0.0, 1.0], frame_rate=8, method=method) for method in METHODS)
    np.testing.assert_allclose(one.root_positions, other.root_positions, atol=1e-12)
    np.testing.assert_allclose((orientations(one) * orientations(other).inv()).magnitude(), 0.0, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_in_betweens_are_written_standing(tmp_path, method):
    """Hips whose x axis runs along the spine: with the root's angles at zero the person would lie."""
    spine = Skeleton([("spine", None, (0.5, 0, 0), "xyz"), ("head", "spine", (0.3, 0, 0), "z")], "parent")
    upright = np.tile([[np.pi / 2, 0.0, 0.3]], (3, 1))
    keys = Motion(spine, 0.1 * np.eye(3, 4), 1, [[0, 0.9, 0], [0, 0.9, 1], [0, 0.9, 3]], upright, "ZYX")
    save_bvh(tmp_path / "motion.bvh", interpolate(keys, frame_rate=10, method=method))
    read = load_bvh(tmp_path / "motion.bvh")
    np.testing.assert_allclose(orientations(read).apply([1.0, 0.0, 0.0])[:, 1], 1.0, atol=1e-6)
    np.testing.assert_allclose(read.root_positions[[0, 10, 20]], keys.root_positions, atol=1e-6)


def test_of_arrays_nothing_is_known_of_the_root():
    keys = keys_of()
    motion = interpolate(keys.angles, TIMES, ARM, frame_rate=10)
    assert not motion.root_positions.any()
    assert not motion.root_angles.any()
    assert (motion.up, motion.root_name) == ("y", "root")


def test_errors():
    keys = keys_of()
    with pytest.raises(ValueError, match="poses are a Motion of another skeleton than the one given: leave"):
        interpolate(keys, TIMES, SKELETONS["humanoid"], frame_rate=10)
    with pytest.raises(ValueError, match="interpolate needs times= for key poses that are no Motion"):
        interpolate(keys.angles, skeleton=ARM, frame_rate=10)
    with pytest.raises(ValueError, match="interpolate needs skeleton= for key poses that are no Motion"):
        interpolate(keys.angles, TIMES, frame_rate=10)
    with pytest.raises(ValueError, match=r"times must have shape \(4,\)"):
        interpolate(keys, TIMES[:3], frame_rate=10)
    with pytest.raises(ValueError, match="at least two key poses, got 1"):
        interpolate(keys[:1], frame_rate=10)
    same = Skeleton(list(ARM.bones))  # equal, and another object
    assert len(interpolate(retarget(keys, same), TIMES, ARM, frame_rate=10)) == 15
