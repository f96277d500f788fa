"""From where a person is seen: which axis of the root is upright, and the side in words."""

import numpy as np

from skpose.skeleton import Motion
from skpose.skeleton._shared import root_orientations, sides


def find_vertical(motions: list[Motion]) -> int:
    """Return the axis of the root that is nearest to the vertical of the world; y for arrays."""
    if not motions:
        return 1
    shares = np.zeros(3)
    for motion in motions:
        orientations = root_orientations(motion.root_angles, motion.root_axes)
        shares += orientations.inv().apply(np.eye(3)["xyz".index(motion.up)]).sum(axis=0)
    return int(np.abs(shares).argmax())


def name_view(positions: np.ndarray, names: tuple[str, ...], plane: list[int]) -> str:
    """Return in words from where a person is seen, by the joints of both sides; empty where that is not clear."""
    side = np.array(sides(names))
    if not ((side == "left").any() and (side == "right").any()):
        return ""
    of_left, of_right = (positions[:, side == one].mean(axis=(0, 1)) for one in ("left", "right"))
    left = of_left - of_right
    up = np.eye(3)[plane[1]]
    viewer = np.cross(np.eye(3)[plane[0]], up)
    directions = {"the left": left, "the front": np.cross(left, up)}
    length = np.linalg.norm(left)
    for name, direction in directions.items():
        share = viewer @ direction / length if length else 0.0
        if abs(share) > 0.7:
            return f"; seen from {name if share > 0 else {'the left': 'the right', 'the front': 'behind'}[name]}"
    return ""


def choose_projection(positions: np.ndarray, vertical: int, is_deep: bool = False) -> str:
    """Return the two axes that show poses (n_poses, n_joints, 3) from the side on which they differ more.

    The second axis is the vertical one. A single pose is shown from the side on which it is wider; axes of three
    dimensions show all three axes, the vertical one last.
    """
    first, second = (vertical + 1) % 3, (vertical + 2) % 3
    if is_deep:
        return "".join("xyz"[axis] for axis in (first, second, vertical))
    known = positions[:, np.isfinite(positions).all(axis=(0, 2))]
    spread = known.var(axis=0).sum(axis=0)
    if not spread[[first, second]].any():
        spread = known.max(axis=(0, 1), initial=0.0) - known.min(axis=(0, 1), initial=0.0)
    low, high = sorted((first, second))
    return "xyz"[high if spread[high] > spread[low] * (1.0 + 1e-9) else low] + "xyz"[vertical]
