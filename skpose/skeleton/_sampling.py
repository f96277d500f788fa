"""Frames of a motion by their numbers: some of them, and those at another rate."""

from collections.abc import Sequence
from operator import index
from typing import Any

import numpy as np


def choose_frames(frame_numbers: np.ndarray, frames: int | np.integer | slice) -> tuple[slice, int, np.ndarray]:
    """Return the rows of a frame or of a slice, how many frames they are apart, and their new numbers."""
    n = len(frame_numbers)
    step = 1
    if isinstance(frames, slice):
        step = abs(frames.indices(n)[2])
    else:
        try:
            frame = index("" if isinstance(frames, bool) else frames)  # type: ignore[arg-type]
        except TypeError:
            raise TypeError(
                "a motion is indexed by a frame or by a slice, such as motion[10:50]: frames of a mask or an array "
                "are not evenly spaced in time; motion.angles[...] selects poses"
            ) from None
        if not -n <= frame < n:
            raise IndexError(f"the motion has {n} frames, and no frame {frame}")
        frame %= n
        frames = slice(frame, frame + 1)
    numbers = frame_numbers[frames]
    numbers = np.abs(numbers - numbers[:1])
    if (numbers % step).any():
        raise ValueError(
            f"every frame out of {step} is no motion, as frames are missing between them: use resample, or slices "
            "of the frames that follow each other, see frame_numbers"
        )
    return frames, step, numbers // step


def resample_frames(numbers: np.ndarray, old_rate: float, frame_rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows, which need not be whole, of the frames at a new rate, and their numbers."""
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
    """Return which joints were seen in which frame, an array of this shape; None where poses were not fitted."""
    if seen is None:
        return None
    array = np.asarray(seen)
    if array.dtype != bool or array.shape not in ((), shape):
        raise ValueError(
            f"seen must be True, None or an array of bool of shape {shape}, frames and joints, got {array.dtype} of "
            f"shape {array.shape}"
        )
    return np.broadcast_to(array, shape).copy()


def join_seen(parts: Sequence[np.ndarray | None], lengths: Sequence[int]) -> np.ndarray | None:
    """Return what was seen in motions one after another; None where none was fitted, and else a recording shows all."""
    widths = [part.shape[1] for part in parts if part is not None]
    if not widths:
        return None
    shown = (np.ones((n, widths[0]), bool) if part is None else part for part, n in zip(parts, lengths, strict=True))
    return np.concatenate(list(shown))


def seen_between(seen: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return which joints are seen at rows that need not be whole: those that are in both frames next to each."""
    return seen[np.floor(rows).astype(int)] & seen[np.ceil(rows).astype(int)]


def seen_of(seen: np.ndarray | None, names: Sequence[str], joint_names: Sequence[str]) -> np.ndarray | None:
    """Return the columns of some joints; what has no column, such as a root that has become a joint, was not seen."""
    if seen is None:
        return None
    columns, nowhere = dict(zip(names, seen.T, strict=True)), np.zeros(len(seen), bool)
    return np.stack([columns.get(name, nowhere) for name in joint_names], axis=1)
