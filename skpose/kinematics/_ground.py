"""Points that stand still, and the height of the ground below a motion: where its lowest points stand."""

import numpy as np

WINDOW = 0.025  # s before and after a frame over which speed is measured
SLOW = 0.15  # sizes a second; slower points stand still, a swinging toe is ten times as fast
SHORT = 0.1  # s; at the top of a jump one is as slow for less
LEVEL = 0.04  # sizes; heights that differ less are one floor, steps of stairs are higher
LOW = 5.0  # %, the percentile of the heights that counts as the lowest: a toe that dips into the floor does not


def find_ground(points: np.ndarray, times: np.ndarray, size: float) -> tuple[float, int]:
    """The height of the ground below points (n_frames, n_points, 3), y up, m, and in how many frames they stand still.

    Points that are missing are NaN. If none ever stands still, the ground is at the lowest point of all.

    Times (n_frames,) are in s, the size of the figure in m. The lowest point of a frame stands on something if it is
    slow. The ground is the median of its heights there, among those near the lowest ones, so that one dip of a toe does
    not lift the figure.
    """
    heights = np.where(np.isnan(points[..., 1]), np.inf, points[..., 1])
    frames, lowest = np.arange(len(points)), heights.argmin(axis=1)
    heights = heights[frames, lowest]
    before, after = around(times, WINDOW)
    moved = np.linalg.norm(points[after, lowest] - points[before, lowest], axis=1)
    stands = np.isfinite(heights) & (moved < SLOW * size * (times[after] - times[before]))
    step = float(np.median(np.diff(times))) if len(times) > 1 else np.inf
    for first, end in runs(stands):
        stands[first:end] &= (end - first) * step >= SHORT
    if not stands.any():
        return float(heights.min()), 0
    standing = heights[stands]
    near = standing <= np.percentile(standing, LOW) + LEVEL * size
    return float(np.median(standing[near])), int(stands.sum())


def around(times: np.ndarray, window: float) -> tuple[np.ndarray, np.ndarray]:
    """The frames a time, s, before and after each frame, at least one apart, within the recording."""
    n = len(times)
    k = max(1, round(min(window / float(np.median(np.diff(times))), n))) if n > 1 else 1
    return np.maximum(np.arange(n) - k, 0), np.minimum(np.arange(n) + k, n - 1)


def speeds_of(points: np.ndarray, times: np.ndarray, window: float) -> np.ndarray:
    """Speeds (n_frames, ...) of points (n_frames, ..., d), m/s, over a time, s, before and after each frame."""
    before, after = around(times, window)
    seconds = np.maximum(times[after] - times[before], 1e-12).reshape(-1, *[1] * (points.ndim - 2))
    return np.linalg.norm(points[after] - points[before], axis=-1) / seconds


def runs(chosen: np.ndarray) -> list[tuple[int, int]]:
    """The first index and the one after the last of each run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]])))
    return [(first, end) for first, end in edges.reshape(-1, 2).tolist()]
