"""Frames of a motion by their numbers: some of them, and those at another rate."""

from operator import index

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
