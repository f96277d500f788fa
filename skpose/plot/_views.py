"""The side from which poses are drawn."""

import numpy as np

from skpose.skeleton import Motion
from skpose.view._scene import vertical_of


def find_vertical(motion: Motion) -> int:
    """The axis of the root that is nearest to the vertical of the world."""
    return int(np.abs(vertical_of(motion)).argmax())


def choose_projection(positions: np.ndarray, vertical: int) -> str:
    """The two axes that show poses (n_poses, n_joints, 3) from the side on which they differ more, upright.

    A single pose is shown from the side on which it is wider.
    """
    low, high = (axis for axis in range(3) if axis != vertical)
    known = positions[:, np.isfinite(positions).all(axis=(0, 2))]
    spread = known.var(axis=0).sum(axis=0)
    if not spread[[low, high]].any():
        spread = known.max(axis=(0, 1), initial=0.0) - known.min(axis=(0, 1), initial=0.0)
    return "xyz"[high if spread[high] > spread[low] * (1.0 + 1e-9) else low] + "xyz"[vertical]
