"""Keypoints as a file states them, before a layout or names are given: numbers, and the frames that they are of."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from skpose.io._source import Source

MOST = 100  # frames for each that is stored: a larger number of a frame is damage, and would need the memory
# The first columns of the tables that `save_csv` writes, of positions and of angles.
POINTS_HEAD = "frame", "time", "frame_rate", "up"
ANGLES_HEAD = (*POINTS_HEAD, "root_axes")
FRAME = "frame", "frame_id", "frame_index", "frame_idx", "frame_number", "frame_num", "frame_no", "fnum"


class Stored(NamedTuple):
    """Positions with what the file says of them; None for what it does not say."""

    positions: np.ndarray  # (n_frames, n_points, 3), NaN where not seen
    confidences: np.ndarray | None  # (n_frames, n_points)
    names: list[str] | None
    frame_rate: float | None = None
    up: str | None = None  # x, y or z


def at_frames(source: Source, stored: Stored, numbers: Sequence[float] | None) -> Stored:
    """Return positions with each frame where its number says; frames without one are not seen."""
    if numbers is None or not len(numbers):
        return stored
    given = np.asarray(numbers, dtype=np.float64)
    if not (np.isfinite(given).all() and (given % 1.0 == 0.0).all() and np.abs(given).max() < 2**53):
        raise source.error("numbers of frames: expected whole numbers")
    steps = np.diff(given)
    if (steps < 1.0).any():
        at = int(np.argmax(steps < 1.0))
        raise source.error(
            f"numbers of frames: {given[at + 1]:g} follows {given[at]:g}; expected each once, in order: one row or "
            "entry a frame, of one person"
        )
    n = given[-1] - given[0] + 1.0
    if n > MOST * len(given):
        raise source.error(f"numbers of frames go from {given[0]:g} to {given[-1]:g} in {len(given)} frames")
    if n == len(given):
        return stored
    at = (given - given[0]).astype(np.int64)
    positions = np.full((int(n), *stored.positions.shape[1:]), np.nan)
    positions[at] = stored.positions
    confidences = stored.confidences
    if confidences is not None:
        confidences = np.zeros(positions.shape[:2])
        confidences[at] = stored.confidences
    return stored._replace(positions=positions, confidences=confidences)
