import numpy as np
import pytest

from skpose import (
    Bone,
    Motion,
    Skeleton,
)
from skpose.kinematics import retarget

ARM = Skeleton.chain(2)


def test_defaults_and_repr():
    motion = Motion(ARM, [[0, 1], [2, 3]], 2)
    np.testing.assert_array_equal(motion.root_positions, np.zeros((2, 3)))
    np.testing.assert_array_equal(motion.root_angles, np.zeros((2, 3)))
    assert len(motion) == 2
    assert repr(motion) == "Motion(2 frames at 2 Hz, 1.0 s, y up, Skeleton(n_joints=2, n_dofs=2))"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"angles": np.zeros((3, 5))}, r"angles must have shape \(3, 2\), got \(3, 5\)"),
        ({"angles": [[0, 1], [np.nan, 0]]}, "angles must be finite, but frame 1"),
        ({"root_positions": np.zeros((2, 3))}, "root_positions must have shape"),
        ({"root_angles": np.zeros((3, 2))}, "root_angles must have shape"),
        ({"frame_rate": 0}, "frame_rate"),
        ({"frame_rate": "30"}, "frame_rate"),
        ({"root_axes": "xX"}, "root_axes"),
        ({"frame_numbers": [0, 2, 2]}, "frame_numbers"),
    ],
)
def test_error_for_arguments_that_do_not_fit(arguments, message):
    with pytest.raises(ValueError, match=message):
        Motion(**({"skeleton": ARM, "angles": np.zeros((3, 2)), "frame_rate": 10.0} | arguments))


@pytest.mark.filterwarnings("ignore:values of angles reach:UserWarning")
def test_frames_may_be_missing():
    """Frames keep their numbers and times; resampling makes none up between two that do not follow each other."""
    angles = np.arange(40.0).reshape(20, 2)
    whole, kept = Motion(ARM, angles, 10), np.array([2, 3, 4, 5, 9, 12, 13, 14, 15, 19])
    motion = Motion(ARM, angles[kept], 10, whole.root_positions[kept], frame_numbers=kept)
    np.testing.assert_array_equal(motion.times, kept / 10)
    np.testing.assert_array_equal(whole.times, np.arange(20) / 10)
    for change in (motion.unwrap(), retarget(motion, ARM)):
        np.testing.assert_array_equal(change.frame_numbers, kept)
    for rate in (5, 10, 20, 7, 3):
        expected, found = whole.resample(rate), motion.resample(rate)
        known = np.isin(np.floor(found.times * 10 + 1e-9), kept)
        assert known.all()
        np.testing.assert_allclose(found.angles, expected.angles[found.frame_numbers], rtol=1e-12)
        at = expected.times * 10
        both = np.isin(np.floor(at + 1e-9), kept) & np.isin(np.ceil(at - 1e-9), kept)
        np.testing.assert_array_equal(found.frame_numbers, expected.frame_numbers[both])
    assert motion.resample(10).frame_numbers.tolist() == kept.tolist()


@pytest.mark.filterwarnings("ignore:values of angles reach:UserWarning")
def test_resampling_by_a_whole_factor_takes_frames_as_they_are():
    angles = np.random.default_rng(0).normal(size=(101, 2)) * 10
    motion = Motion(ARM, angles, 120, root_positions=np.ones((101, 3)), root_angles=np.ones((101, 1)), root_axes="z")
    down = motion.resample(12)
    np.testing.assert_array_equal(down.angles, angles[::10])
    assert (down.frame_rate, down.root_axes) == (12, "z")
    np.testing.assert_array_equal(motion.resample(120).angles, angles)
    np.testing.assert_array_equal(motion.resample(240).angles[::2], angles)


def hinges_of(limits):
    """One hinge with limits, and one without."""
    return Skeleton([Bone("a", None, (1, 0, 0), "z", limits=(limits,)), Bone("b", "a", (1, 0, 0), "z")])


def test_resampling_keeps_hinges_out_of_the_gap_of_their_limits():
    """From −170° to 160° the wrapped difference is −30°, which is closed to the first hinge; it rotates by 330°."""
    start, end = np.radians([-170.0, 160.0])
    motion = Motion(hinges_of((-3.0, 2.8)), [[start, start], [end, end]], 1).resample(10)
    np.testing.assert_allclose(motion.angles[:, 0], np.linspace(start, end, 11), atol=1e-12)
    np.testing.assert_allclose(motion.angles[:10, 1], np.linspace(start, end - 2 * np.pi, 11)[:10], atol=1e-12)
    assert motion.angles[-1, 1] == end


def test_unwrapping_removes_jumps_by_whole_turns():
    angles = np.cumsum(np.random.default_rng(0).uniform(-1, 1, size=(50, 2)), axis=0)
    jumped = (angles + np.pi) % (2 * np.pi) - np.pi
    motion = Motion(ARM, jumped, 10, root_positions=np.ones((50, 3)), root_angles=jumped[:, :1], root_axes="z").unwrap()
    np.testing.assert_allclose(motion.angles - motion.angles[0], angles - angles[0], atol=1e-12)
    np.testing.assert_allclose(motion.root_angles - motion.root_angles[0], (angles - angles[0])[:, :1], atol=1e-12)
    np.testing.assert_array_equal(motion.root_positions, np.ones((50, 3)))
    assert (motion.frame_rate, motion.root_axes) == (10, "z")


def test_data_frame_of_the_angles():
    frame = Motion(ARM, [[0, 1], [2, 3]], 4).to_pandas()
    assert list(frame.columns) == ["joint_1_rz", "joint_2_rz"]
    assert (list(frame.index), frame.index.name) == ([0, 0.25], "time")
    np.testing.assert_array_equal(frame, [[0, 1], [2, 3]])


def test_a_motion_checks_the_columns_of_a_data_frame():
    """As estimators do: the order is that of the skeleton, by name; other names are taken by position."""
    frame = Motion(ARM, [[0, 1], [2, 3]], 4).to_pandas()
    np.testing.assert_array_equal(Motion(ARM, frame, 4).angles, [[0, 1], [2, 3]])
    for wrong in (frame[frame.columns[::-1]], frame[["joint_1_rz"]].reset_index()):
        with pytest.raises(ValueError, match="columns of angles"):
            Motion(ARM, wrong, 4)
    np.testing.assert_array_equal(Motion(ARM, frame.set_axis(["a", "b"], axis=1), 4).angles, [[0, 1], [2, 3]])
