"""Joints seen in the positions to which poses were fitted."""

from dataclasses import replace

import numpy as np
import pytest

from skpose import Motion, forward_kinematics, inverse_kinematics
from skpose.datasets import humanoid, make_gait

SKELETON = humanoid()
NAMES = list(SKELETON.joint_names)
N = 12


@pytest.fixture
def seen():
    """A third of the joints, at random in each frame, is not seen."""
    return np.random.default_rng(0).random((N, len(NAMES))) < 0.67


@pytest.fixture
def motion(seen):
    return replace(make_gait(1, 1, frame_rate=10, rotations="file", random_state=0)[0][:N], seen=seen)


def test_fitted_poses_know_what_they_were_fitted_to(seen):
    walk = make_gait(1, 1, frame_rate=10, rotations="file", random_state=0)[0][:N]
    positions = forward_kinematics(walk.angles, SKELETON)
    positions[~seen] = np.nan
    fitted = inverse_kinematics(positions, SKELETON)
    np.testing.assert_array_equal(fitted.to_motion(10).seen, seen)
    assert fitted.to_motion(10).fitted
    assert not walk.fitted
    assert walk.seen is None


def test_frames(motion, seen):
    np.testing.assert_array_equal(motion[2:7].seen, seen[2:7])
    np.testing.assert_array_equal(motion[::-1].seen, seen[::-1])
    np.testing.assert_array_equal(motion[3].seen, seen[3:4])
    recorded = replace(motion, seen=None)
    both = Motion.concatenate([motion, recorded])
    np.testing.assert_array_equal(both.seen, np.concatenate([seen, np.ones_like(seen)]))
    assert Motion.concatenate([recorded, recorded]).seen is None
    finer = motion.resample(20)
    np.testing.assert_array_equal(finer.seen[::2], seen)
    np.testing.assert_array_equal(finer.seen[1::2], seen[:-1] & seen[1:])
