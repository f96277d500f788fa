"""Joint angles over the cycles of a movement as a table, of one recording and of many."""

from dataclasses import replace

import numpy as np
import pytest
from walkers import walk

from skpose.biomechanics import gait_events, joint_angles
from skpose.datasets import MotionDataset
from skpose.motions import Repetitions

WALK = walk()
ANGLES, EVENTS = joint_angles(WALK), gait_events(WALK)


def test_a_row_for_each_angle_cycle_and_per_cent():
    table = ANGLES.cycles(EVENTS)
    assert list(table.columns) == ["angle", "side", "cycle", "start [s]", "phase [%]", "value [deg]"]
    knee = table[(table["angle"] == "knee_flexion") & (table["side"] == "right")]
    strides = EVENTS.times[EVENTS.strides[EVENTS.feet[EVENTS.strides[:, 0]] == "right"]]
    assert len(knee) == 101 * len(strides)
    for number, (first, _, last) in enumerate(strides):
        one = knee[knee["cycle"] == number]
        np.testing.assert_array_equal(one["phase [%]"], np.arange(101))
        at = np.linspace(first, last, 101)
        np.testing.assert_allclose(one["value [deg]"], np.interp(at, WALK.times, ANGLES["knee_flexion_right"]))
        assert (one["start [s]"] == first).all()


def test_repetitions_and_frames_are_cycles_of_both_sides():
    starts, stops = np.array([20, 130, 300]), np.array([110, 290, 420])
    repetitions = Repetitions(starts, stops, np.zeros(3), 0, 0.5, 0.01, [], None, WALK.times)
    table = ANGLES.cycles(repetitions)
    assert table.equals(ANGLES.cycles(np.stack([starts, stops], axis=1)))
    assert table.groupby(["angle", "side"])["cycle"].nunique().unique().tolist() == [3]
    with pytest.raises(ValueError, match="of the recording"):
        ANGLES.cycles(replace(repetitions, times=WALK.times + 1.0))


@pytest.mark.parametrize("up", ["x", "y", "z"])
@pytest.mark.parametrize("heading", [0.7, 3.0])
def test_the_pelvis_is_rotated_relative_to_the_direction_of_the_stride(up, heading):
    """A person who faces the path by 0.2 rad to the left; the recording is along any direction of the world."""
    motion = walk(up=up, heading=heading, facing=0.2)
    table = joint_angles(motion).cycles(gait_events(motion))
    values = table["value [deg]"][table["angle"] == "pelvis_rotation"]
    np.testing.assert_allclose(values, np.degrees(0.2), atol=0.5)


def test_many_recordings_give_one_table():
    walks = [WALK, walk(step=0.5, heading=1.0, duration=2.5)]
    table = joint_angles(MotionDataset(walks, subjects=["anna", "ben"], trials=["1", "2"], rotations="file"))
    assert table.groupby("subject")["trial"].unique().map(list).to_dict() == {"anna": ["1"], "ben": ["2"]}
    first = ANGLES.cycles(EVENTS)
    assert table[table["subject"] == "anna"][first.columns].equals(first)
    still = replace(walks[1], root_positions=walks[1].root_positions * 0.01)
    with pytest.warns(UserWarning, match="1 of 2 recordings"):
        assert set(joint_angles([walks[1], still])["trial"]) == {0}
    with pytest.raises(TypeError, match="motion must be a Motion"):
        joint_angles([WALK.angles])
