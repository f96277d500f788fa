"""Whether results are of one recording, by the distances between hips and ankles in each frame.

The distances do not depend on the place and heading of the person or on how rotations are written.
"""

from collections.abc import Mapping

import numpy as np

from skpose.kinematics import forward_kinematics
from skpose.skeleton import Motion

# Root mean square of the difference of relative distances. In walks and runs of CMU a low-pass filter of 6 Hz changes
# them by at most 0.008; two walks of one person that begin in the same phase differ by at least 0.0136.
SAME = 0.01
ENDS = ("left_hip", "left_ankle", "right_hip", "right_ankle")  # of legs


def leg_lengths(motion: Motion, joints: Mapping[str, int]) -> np.ndarray:
    """Distances (n, 2) from hip to ankle, left and right, m; joints by landmark."""
    ends = forward_kinematics(motion.angles, motion.skeleton)[:, [joints[end] for end in ENDS]]
    return np.linalg.norm(ends[:, ::2] - ends[:, 1::2], axis=2)


def are_of_one_recording(lengths: np.ndarray | None, others: np.ndarray | None) -> bool:
    """Whether lengths of legs (n, 2) in the same frames can be of one recording; True if they are unknown."""
    if lengths is None or others is None:
        return True
    relative = [one / np.maximum(one.max(axis=0), 1e-12) for one in (lengths, others)]
    return bool(np.square(relative[0] - relative[1]).mean() <= SAME**2)
