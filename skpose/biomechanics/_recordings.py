"""Recognition of results that are of one recording, by how far hips and ankles are from each other in each frame.

The distances do not depend on where the person is and faces, as on a treadmill, nor on how rotations are written, and
they change little where a motion is filtered.
"""

from collections.abc import Mapping

import numpy as np

from skpose.kinematics import forward_kinematics
from skpose.skeleton import Motion

# Root mean square of the difference of relative distances. Of CMU's walks and runs a low-pass filter of 6 Hz changes
# them by 0.008 at most, and those of two walks of one person that begin in the same phase differ by 0.0136 or more.
SAME = 0.01
ENDS = [(f"{side}_hip", f"{side}_ankle") for side in ("left", "right")]


def leg_lengths(motion: Motion, joints: Mapping[str, int]) -> np.ndarray:
    """Return the distances (n, 2) from hip to ankle, left and right, m; joints by landmark."""
    if not len(motion):
        return np.empty((0, 2))
    positions = forward_kinematics(motion.angles, motion.skeleton)
    lengths = [np.linalg.norm(positions[:, joints[a]] - positions[:, joints[b]], axis=1) for a, b in ENDS]
    return np.stack(lengths, axis=1)


def are_of_one_recording(lengths: np.ndarray | None, others: np.ndarray | None) -> bool:
    """Return whether lengths of legs (n, 2) in the same frames can be those of one recording, or are not known."""
    if lengths is None or others is None:
        return True
    relative = [one / np.maximum(one.max(axis=0, initial=0.0), 1e-12) for one in (lengths, others)]
    return bool(np.square(relative[0] - relative[1]).mean() <= SAME**2)
