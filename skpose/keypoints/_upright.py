"""The axis of the world along which points stand, by names of heads and feet."""

from collections.abc import Sequence

import numpy as np

from skpose.skeleton._shared import HIGH, LOW

N_FRAMES = 32  # checked, evenly spaced
NEARLY_ALL = 0.9  # of these
FLAT = 0.8  # height over the largest extent below which a person does not stand along an axis
# Names of the pelvis, the start of the trunk: it is upright in a person who sits on the floor.
MIDDLE = "hip", "pelvis", "asi", "psi", "sacr"
TRUNK = 0.25  # length of the trunk over the extent below which it is not used


def find_up(positions: np.ndarray, names: Sequence[str], usual: str) -> str:
    """The direction from feet to head in nearly all frames; the usual one if there is none."""
    lower = [name.lower() for name in names]
    frames = positions[:: max(1, len(positions) // N_FRAMES)]
    top, middle, bottom = (
        _mean_of_seen(frames[:, [i for i, name in enumerate(lower) if any(part in name for part in parts)]])
        for parts in (HIGH, MIDDLE, LOW)
    )
    heights, trunks = top - bottom, top - middle
    is_seen = ~np.isnan(heights).any(axis=1)
    heights, trunks = heights[is_seen], trunks[is_seen]
    extent = np.abs(heights).max(axis=1, initial=0.0)
    length = np.abs(trunks).max(axis=1, initial=0.0)
    no_trunk = ~(length > TRUNK * extent)
    if not extent.any():
        return usual
    level = heights[:, "xyz".index(usual[-1])] * (-1.0 if usual.startswith("-") else 1.0) < FLAT * extent
    for i, axis in enumerate("xyz"):
        for sign, direction in ((1.0, axis), (-1.0, f"-{axis}")):
            stands = (sign * heights[:, i] == extent) & (extent > 0.0) & level
            stands &= no_trunk | (sign * trunks[:, i] == length)
            if direction != usual and stands.mean() >= NEARLY_ALL:
                return direction
    return usual


def complaint_of_up(found: str, usual: str, why: str, points: str, remedy: str) -> str:
    """The warning about points that stand along another axis than the one taken as up, and why it is."""
    stand = f"{points} stand along {found[-1]}{', head down' if len(found) > 1 else ''}"
    return f"{usual} is taken as the axis that points up, {why}, but {stand} in nearly all frames: pass {remedy}"


def _mean_of_seen(positions: np.ndarray) -> np.ndarray:
    """The mean position (n_frames, 3) of the seen points, NaN if none is seen."""
    seen = ~np.isnan(positions).any(axis=2)
    sums = np.where(seen[:, :, None], positions, 0.0).sum(axis=1)
    n_seen = seen.sum(axis=1)[:, None]
    return np.where(n_seen, sums / np.maximum(n_seen, 1), np.nan)
