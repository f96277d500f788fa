"""Events and repetitions are refused with angles of another recording, though times are equal."""

from dataclasses import replace

import numpy as np
import pytest
from walkers import walk

from skpose.biomechanics import gait_events, joint_angles
from skpose.motions import Repetitions
from skpose.plot import JointAnglesDisplay

pytestmark = pytest.mark.usefixtures("agg")

WALK = walk(cadence=97.0)
ONE, OTHER = WALK[100:450], WALK[130:480]  # whose frames are both numbered from 0
STARTS, STOPS = np.array([0, 120]), np.array([100, 240])


def repetitions_of(motion):
    repeated = [motion[start:stop] for start, stop in zip(STARTS, STOPS, strict=True)]
    return Repetitions(STARTS, STOPS, np.zeros(2), 0, 0.5, 0.01, repeated, motion.skeleton, motion.times)


@pytest.mark.parametrize(
    "cycles",
    [gait_events(ONE), gait_events(ONE.with_root("tilt")), repetitions_of(ONE), repetitions_of(ONE.to_euler("xyz"))],
    ids=["events", "with root", "repetitions", "Euler angles"],
)
def test_cycles_of_another_recording_are_refused(cycles):
    """How rotations are written and where the person is make no other recording."""
    for same in (ONE, replace(ONE, root_positions=None), ONE.with_root("tilt")):
        JointAnglesDisplay.from_angles(joint_angles(same), cycles)
    with pytest.raises(ValueError, match="got another one"):
        JointAnglesDisplay.from_angles(joint_angles(OTHER), cycles)
