"""Selection and resampling of frames by their numbers."""

from collections.abc import Sequence
from operator import index
from typing import Any

import numpy as np


def choose_frames(frame_numbers: np.ndarray, frames: int | np.integer | slice) -> tuple[slice, int, np.ndarray]:
    """The rows of a frame or a slice, the step between them, and their new numbers."""
    n, step = len(frame_numbers), 1
    if isinstance(frames, slice):
        step = abs(frames.indices(n)[2])
    else:
        frame = range(n)[index(frames)]
        frames = slice(frame, frame + 1)
    numbers = frame_numbers[frames]
    numbers = np.abs(numbers - numbers[:1])
    if (numbers % step).any():
        raise ValueError(f"frames are missing, so every {step}th is not evenly spaced: use resample")
    return frames, step, numbers // step


def resample_frames(numbers: np.ndarray, old_rate: float, frame_rate: float) -> tuple[np.ndarray, np.ndarray]:
    """The rows, not necessarily whole, of the frames at a new rate, and their numbers."""
    step = old_rate / frame_rate
    # 1e-9 allows for rounding: a rate that divides the old one exactly keeps the last frame.
    first, last = (numbers[0], numbers[-1]) if len(numbers) else (0, -1)
    new = np.arange(int(np.ceil(first / step - 1e-9)), int(np.floor(last / step + 1e-9)) + 1)
    at = new * step  # in numbers of the old frames
    near = np.rint(at)
    at = np.where(np.abs(at - near) < 1e-9, near, at)
    before = np.searchsorted(numbers, at, side="right") - 1
    part = at - numbers[before]
    known = (part == 0.0) | np.isin(numbers[before] + 1, numbers)
    return (before + part)[known], new[known]


def check_seen(seen: Any, shape: tuple[int, int]) -> np.ndarray | None:
    """The joints seen in each frame, an array of this shape; None if poses were not fitted to positions."""
    if seen is None:
        return None
    array = np.asarray(seen)
    if array.dtype != bool or array.shape not in ((), shape):
        raise ValueError(f"seen must be True, None or bool of shape {shape}, got {array.dtype} of shape {array.shape}")
    return np.broadcast_to(array, shape).copy()


def join_seen(parts: Sequence[np.ndarray | None], lengths: Sequence[int]) -> np.ndarray | None:
    """The joints seen in consecutive motions: all in recordings of rotations; None if there are only such."""
    widths = [part.shape[1] for part in parts if part is not None]
    if not widths:
        return None
    shown = (np.ones((n, widths[0]), bool) if part is None else part for part, n in zip(parts, lengths, strict=True))
    return np.concatenate(list(shown))


def seen_between(seen: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The joints seen at rows that need not be whole: in both frames next to each."""
    return seen[np.floor(rows).astype(int)] & seen[np.ceil(rows).astype(int)]


def seen_of(seen: np.ndarray | None, names: Sequence[str], joint_names: Sequence[str]) -> np.ndarray | None:
    """The columns of some joints; joints without a column, such as a root that became a joint, were not seen."""
    if seen is None:
        return None
    columns, nowhere = dict(zip(names, seen.T, strict=True)), np.zeros(len(seen), bool)
    return np.stack([columns.get(name, nowhere) for name in joint_names], axis=1)
