"""What is of another recording is refused where times are equal: events and repetitions with angles of another one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt
from walkers import walk

from skpose import Motion
from skpose.biomechanics import gait_events, joint_angles
from skpose.motions import Repetitions
from skpose.plot import JointAnglesDisplay

pytestmark = pytest.mark.usefixtures("agg")

WALK = walk(cadence=97.0)
ONE, OTHER = WALK[100:450], WALK[130:480]  # whose frames are both numbered from 0
SPANS = np.array([[0, 100], [120, 240]])
MESSAGE = "cycles are of another recording than angles: times are equal, but the legs are bent otherwise"


def repetitions_of(motion):
    repeated, starts_and_stops = [motion[start:stop] for start, stop in SPANS.tolist()], SPANS.T
    nothing = np.zeros(2)
    return Repetitions(*starts_and_stops, nothing, 0, 0.5, 0.01, repeated, motion.skeleton, motion.times)


def filtered(motion):
    sections = butter(2, 10.0, fs=motion.frame_rate, output="sos")
    return replace(motion, angles=sosfiltfilt(sections, motion.angles, axis=0))


@pytest.mark.parametrize(
    "cycles",
    [gait_events(ONE), gait_events(ONE.with_root("tilt")), repetitions_of(ONE), repetitions_of(ONE.to_euler("xyz"))],
    ids=["events", "with root", "repetitions", "Euler angles"],
)
def test_cycles_of_another_recording_are_refused(cycles):
    """How rotations are written, where the person is, as on a treadmill, and a low-pass filter make no other one."""
    for same in (ONE, replace(ONE, root_positions=None), ONE.with_root("tilt"), filtered(ONE)):
        JointAnglesDisplay.from_angles(joint_angles(same), cycles)
    other = joint_angles(OTHER)
    np.testing.assert_array_equal(other.times, ONE.times)
    with pytest.raises(ValueError, match=MESSAGE):
        JointAnglesDisplay.from_angles(other, cycles)


def test_lengths_of_legs_are_those_of_hips_and_ankles():
    """A straight leg of 0.9 m, and one that is bent by 60° at the knee; joints may be given."""
    motion = Motion(WALK.skeleton, np.zeros((2, 18)), 100)
    assert motion.skeleton.dof_names[3] == "left_ankle_rotvec_x"
    motion.angles[1, 3] = np.pi / 3
    for joints in (None, {"left_hip": "left_hip", "left_ankle": "left_ankle"}):
        lengths = joint_angles(motion, joints=joints).leg_lengths
        np.testing.assert_allclose(lengths, [[0.9, 0.9], [0.9 * np.cos(np.pi / 6), 0.9]], atol=1e-12)


def test_what_stores_no_lengths_is_compared_by_times():
    angles = replace(joint_angles(OTHER), leg_lengths=None)
    JointAnglesDisplay.from_angles(angles, gait_events(ONE))
    JointAnglesDisplay.from_angles(joint_angles(OTHER), replace(gait_events(ONE), leg_lengths=None))
    JointAnglesDisplay.from_angles(joint_angles(OTHER), replace(repetitions_of(ONE), motions=[]))
