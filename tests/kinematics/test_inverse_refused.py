"""Arguments of inverse kinematics that are refused, in words that say what to do."""

import re

import numpy as np
import pytest
from placed import FIGURE, at_random

from skpose import Motion, Skeleton, inverse_kinematics
from skpose.keypoints import Keypoints

N, J, D = 3, FIGURE.n_joints, FIGURE.n_dofs
POSITIONS = np.random.default_rng(0).normal(size=(N, J, 3))
MOTION = Motion(FIGURE, np.zeros((N, D)), 30.0)
INFINITE = POSITIONS.copy()
INFINITE[1, 2, 0] = np.inf
STRANGERS = Keypoints(POSITIONS, [f"point {i}" for i in range(J)], 30.0)


@pytest.mark.parametrize(
    ("positions", "message"),
    [
        (POSITIONS[:, :, :2], "positions have two coordinates for each point, shape (3, 8, 2), but three are needed"),
        (POSITIONS[:, :5], "positions must have shape (n_frames, 8, 3), got (3, 5, 3)"),
        (POSITIONS[0], "positions must have shape (n_frames, 8, 3), got (8, 3)"),
        (POSITIONS.reshape(N, -1), "positions must have shape (n_frames, 8, 3), got (3, 24)"),
        (None, "positions must have shape (n_frames, 8, 3), got ()"),
        (INFINITE, "positions are infinite at frame 1, point 2: use NaN for a point that is not seen"),
        (STRANGERS, "no keypoint has the name of a joint of the skeleton: the keypoints are point 0, point 1"),
    ],
)
def test_positions_that_do_not_fit(positions, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        inverse_kinematics(positions, FIGURE)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"weights": np.ones(3)}, "weights must have shape (8,) or (3, 8), (n_joints,) or one a position, got (3,)"),
        ({"weights": np.ones((N, J, 1))}, "weights must have shape (8,) or (3, 8)"),
        ({"weights": -np.ones(J)}, "weights must be finite and nowhere negative"),
        ({"weights": np.full(J, np.nan)}, "weights must be finite and nowhere negative"),
        ({"weights": np.full((N, J), np.inf)}, "weights must be finite and nowhere negative"),
        ({"initial": np.zeros(3)}, f"initial has 3 columns, but the skeleton has {D} degrees of freedom"),
        ({"initial": np.zeros((2, D))}, "initial must be one pose, or one for each of the 3 frames, got 2"),
        ({"initial": np.full(D, np.nan)}, "Input initial contains NaN"),
        ({"initial": np.zeros((N, D, 1))}, "initial must have shape"),
        ({"lengths": [1, 1]}, "lengths must be whole numbers of frames, 1 or more, whose sum is the number of frames"),
        ({"lengths": [0, 3]}, "number of frames, 3, got [0, 3]"),
        ({"lengths": [1.5, 1.5]}, "number of frames, 3, got [1.5, 1.5]"),
        ({"lengths": [[1, 2]]}, "number of frames, 3, got [[1, 2]]"),
        ({"lengths": np.ones(40, int)}, "number of frames, 3, got 40 of sum 40"),
        ({"lengths": 3}, "'lengths' parameter"),
        ({"joint_limits": "clip"}, "'joint_limits' parameter"),
        ({"regularization": -1.0}, "'regularization' parameter"),
        ({"regularization": np.nan}, "'regularization' parameter"),
        ({"n_jobs": 0}, "n_jobs == 0"),
    ],
)
def test_options_that_do_not_fit(options, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        inverse_kinematics(POSITIONS, FIGURE, **options)


def test_limits_that_no_bone_has():
    with pytest.raises(ValueError, match='joint_limits="enforce" needs a skeleton with limits, and none of its bones'):
        inverse_kinematics(np.zeros((1, 2, 3)), Skeleton.chain(2), joint_limits="enforce")


def test_what_is_no_skeleton():
    with pytest.raises(ValueError, match=r"skeleton must be a skpose\.Skeleton, got Motion: pass its skeleton"):
        inverse_kinematics(POSITIONS, MOTION)
    with pytest.raises(TypeError, match="a Motion is no array"):
        inverse_kinematics(MOTION, FIGURE)
    with pytest.raises(TypeError, match="a Motion is no array"):
        inverse_kinematics(POSITIONS, FIGURE, initial=MOTION)


@pytest.mark.parametrize("scale", [1e3, 1e-3])
@pytest.mark.filterwarnings("ignore:.*did not converge")
def test_other_units_are_warned_of(scale):
    with pytest.warns(UserWarning, match="likely in another unit than metres; convert it"):
        inverse_kinematics(scale * at_random(FIGURE, 3)[1], FIGURE)
