import numpy as np
import pytest

from skpose import Bone, Motion, Skeleton

ARM = Skeleton.chain(2)


def test_defaults_and_repr():
    motion = Motion(ARM, [[0, 1], [2, 3]], 2)
    np.testing.assert_array_equal(motion.root_positions, np.zeros((2, 3)))
    np.testing.assert_array_equal(motion.root_angles, np.zeros((2, 3)))
    assert len(motion) == 2
    assert repr(motion) == "Motion(2 frames at 2 Hz, 1.0 s, Skeleton(n_joints=2, n_dofs=2))"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"angles": np.zeros((3, 5))}, r"angles must have shape \(3, 2\), got \(3, 5\)"),
        ({"angles": [[0, 1], [np.nan, 0]]}, "angles holds nan at frame 1, column 0"),
        ({"angles": 0.0}, "angles must have shape"),
        ({"root_positions": np.zeros((2, 3))}, r"root_positions must have shape \(3, 3\), got \(2, 3\)"),
        ({"root_angles": np.zeros((3, 2))}, r"root_angles must have shape \(3, 3\), got \(3, 2\)"),
        ({"root_angles": np.full((3, 3), np.inf)}, "root_angles holds inf at frame 0, column 0"),
        ({"frame_rate": 0}, "frame_rate must be a positive number of Hz, got 0"),
        ({"frame_rate": np.nan}, "frame_rate must be a positive number of Hz, got nan"),
    ],
)
def test_refuses_what_does_not_fit(arguments, message):
    with pytest.raises(ValueError, match=message):
        Motion(**({"skeleton": ARM, "angles": np.zeros((3, 2)), "frame_rate": 10.0} | arguments))


def test_resampling_by_a_whole_factor_takes_frames_as_they_are():
    angles = np.random.default_rng(0).normal(size=(101, 2)) * 10
    motion = Motion(ARM, angles, 120, root_positions=np.ones((101, 3)), root_angles=np.ones((101, 1)), root_axes="z")
    down = motion.resample(12)
    np.testing.assert_array_equal(down.angles, angles[::10])
    assert (down.frame_rate, down.root_axes) == (12, "z")
    np.testing.assert_array_equal(motion.resample(120).angles, angles)
    np.testing.assert_array_equal(motion.resample(240).angles[::2], angles)


def test_resampling_between_frames_is_linear():
    motion = Motion(ARM, np.linspace([0, 1], [3, -1], 31), 30)
    up = motion.resample(12)
    times = np.arange(len(up)) / 12
    assert len(up) == 13
    np.testing.assert_allclose(up.angles, np.stack([3 * times, 1 - 2 * times], axis=1), atol=1e-12)


def test_resampling_goes_the_short_way_round():
    """A file's jump by 360° between two frames is no spin."""
    degrees = np.array([[179.0, 0], [-179, 0], [-177, 0]])
    between = np.degrees(Motion(ARM, np.radians(degrees), 10).resample(20).angles[:, 0])
    np.testing.assert_allclose(between, [179, 180, -179, -178, -177])


def test_resampling_short_motions():
    assert len(Motion(ARM, np.zeros((0, 2)), 10).resample(3)) == 0
    assert len(Motion(ARM, np.zeros((1, 2)), 10).resample(3)) == 1
    with pytest.raises(ValueError, match="frame_rate must be a positive"):
        Motion(ARM, np.zeros((1, 2)), 10).resample(-1)


def test_retargeting_matches_columns_by_name():
    body = Skeleton([Bone("a", None, (1, 0, 0), "xy"), Bone("b", "a", (1, 0, 0), "z"), Bone("c", None, (1, 0, 0), "x")])
    taller = Skeleton(
        [Bone("c", None, (2, 0, 0), "x"), Bone("a", None, (2, 0, 0), "xy"), Bone("b", "a", (2, 0, 0), "z")]
    )
    motion = Motion(body, [[1, 2, 3, 4]], 10, root_positions=[[5, 6, 7]])
    moved = motion.retarget(taller)
    np.testing.assert_array_equal(moved.angles, [[4, 1, 2, 3]])
    np.testing.assert_array_equal(moved.root_positions, [[5, 6, 7]])
    assert moved.skeleton is taller
    np.testing.assert_array_equal(moved.retarget(body).angles, motion.angles)
    with pytest.raises(ValueError, match="do not carry over to this skeleton: only one of them has a joint 'a'"):
        motion.retarget(ARM)
