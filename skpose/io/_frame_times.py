"""Times of frames next to keypoints, which say the frame rate, and whether frames are left out."""

import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

# Keys and headers of times, such as time, timestamp_ms and Time (s).
TIME = re.compile(
    r"\s*(?:times?|time_?stamps?|ts?)(?:[\s_.\-(\[]*(s|secs?|seconds?|ms|msecs?|millis|milliseconds?|us|microseconds?"
    r"|ns|nanoseconds?)[)\]]?)?\s*",
    re.IGNORECASE,
)
SECONDS = {"s": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9}  # of a unit, by its first letter, but for microseconds
CLOSE, DRIFT = 0.02, 0.4  # relative difference of rates, and what it is at the end, in frames: less may be jitter
LEAST = 1e-12  # step of time in any unit
LONG = 1.5  # steps of time over the usual one, from which a frame is left out


class Times(NamedTuple):
    """The times of the frames that are stored, in a unit that is known or not, and the numbers of these frames."""

    key: str
    values: np.ndarray  # (n_stored,)
    numbers: np.ndarray | None  # (n_stored,)

    @property
    def steps(self) -> np.ndarray:
        """Frames from each one to the next, by their numbers."""
        return np.ones(len(self.values) - 1) if self.numbers is None else np.diff(self.numbers)

    @property
    def interval(self) -> float:
        """Time from one frame to the next, in the unit of the values, where none is left out; NaN if not known.

        Steps of 1 are counts of frames, in no unit.
        """
        if len(self.values) < 2 or not np.isfinite(self.values).all():
            return np.nan
        with np.errstate(over="ignore", invalid="ignore"):
            each = np.diff(self.values) / self.steps
            outer = len(each) // 10  # steps at each end of their order, which may be gaps
            usual = np.sort(each)[outer : len(each) - outer].mean()
            near = np.abs(each - usual) < (LONG - 1.0) * usual
        if not (LEAST < usual < 1.0 / LEAST and np.isfinite(each).all()) or not near.any() or (each == 1.0).all():
            return np.nan
        return float(each[near].mean())

    def rate(self, near: float | None = None) -> float:
        """Return the frame rate, Hz, with the unit that the key states, or the one that is nearest to a rate."""
        if np.isnan(self.interval):
            return np.nan
        match = TIME.fullmatch(self.key)
        unit = match[1].lower() if match and match[1] else ""
        if unit:
            return 1.0 / (self.interval * (1e-6 if unit.startswith("micro") else SECONDS[unit[0]]))
        rates = [1.0 / (self.interval * seconds) for seconds in SECONDS.values()]
        return min(rates, key=lambda rate: abs(np.log(rate / (near or 50.0))))


def time_key(keys: Iterable[str]) -> str | None:
    """Return the key of these, if any, that is the time of a frame."""
    return next((key for key in keys if len(key) < 100 and TIME.fullmatch(key)), None)


def complaint_of_times(times: Times, frame_rate: float) -> str:
    """Return the warning on times that contradict a frame rate, or leave out frames that have no number."""
    if np.isnan(times.interval):
        return ""
    rate = times.rate(frame_rate)
    apart = abs(frame_rate / rate - 1.0)
    if apart > CLOSE and apart * times.steps.sum() > DRIFT:
        return (
            f"frames are at {rate:.4g} Hz by {times.key!r}, but {frame_rate:g} Hz is taken: pass frame_rate={rate:.4g} "
            "if these times are right"
        )
    late = np.diff(times.values) > LONG * times.interval * times.steps
    early = np.diff(times.values) <= 0.0
    if (late | early).any():
        at = int(np.argmax(late | early))
        after = np.diff(times.values)[at] / times.interval
        return (
            f"entry {at + 2} is {after:.3g} frames after the one before by {times.key!r}, and is taken as "
            f"{times.steps[at]:g} after it: number the frames, as 'frame', so that each keeps its time"
        )
    return ""
