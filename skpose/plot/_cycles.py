"""Angles of joints over the cycles of a movement, each from 0 to 100 %, and their mean."""

from typing import Any, NamedTuple

import numpy as np

from skpose.biomechanics import GaitEvents, JointAngles
from skpose.motions import Repetitions

PERCENT = np.arange(101.0)  # of the cycle, at which curves are known
LONGEST_GAP = 0.1  # s without frames across which curves are interpolated
SIDES = ("left", "right", "")  # of angles; angles of the trunk have none


class Cycles(NamedTuple):
    """First and last times of the cycles of a movement, and the word for one."""

    spans: dict[str, np.ndarray]  # for each side, "" is the middle: (n_cycles, 2) first and last time, s
    noun: str
    of_middle: str  # the side whose cycles the trunk has; "" if all are the same


def find_cycles(angles: JointAngles, cycles: Any) -> Cycles:
    """The cycles of each side."""
    if isinstance(cycles, GaitEvents):
        return _strides(angles, cycles)
    noun = "cycle"
    if isinstance(cycles, Repetitions):
        if cycles.times is not None:
            _check_times(cycles.times, angles)
        cycles, noun = np.stack([cycles.starts, cycles.stops], axis=1), "repetition"
    frames = np.asarray(cycles)
    if frames.shape[1:] != (2,) or not np.issubdtype(frames.dtype, np.integer):
        raise ValueError("cycles must be GaitEvents, Repetitions, or whole numbers of shape (n_cycles, 2)")
    if not len(frames) or frames.min() < 0 or frames.max() > len(angles) or (np.diff(frames) < 2).any():
        raise ValueError(f"cycles must be parts of at least two of the {len(angles)} frames of angles")
    return Cycles(dict.fromkeys(SIDES, angles.times[frames - [0, 1]]), noun, "")


def _strides(angles: JointAngles, events: GaitEvents) -> Cycles:
    """The strides of each foot, from its contact to its next."""
    if not len(events.strides):
        raise ValueError(f"cycles has no strides: {events.reason}")
    _check_times(events.motion_times, angles)
    feet = events.feet[events.strides[:, 0]]
    times = events.times[events.strides[:, [0, 2]]]
    spans = {side: times[feet == side] for side in SIDES[:2]}
    of_middle = max(spans, key=lambda side: len(spans[side]))  # the left, of equal ones
    return Cycles(spans | {"": spans[of_middle]}, "stride", of_middle)


def _check_times(times: np.ndarray, angles: JointAngles) -> None:
    if len(times) != len(angles) or not np.allclose(times, angles.times, rtol=0.0, atol=1e-6):
        raise ValueError("cycles must be of the recording that angles are of, got another one")


def without_jumps(degrees: np.ndarray) -> np.ndarray:
    """An angle over time without jumps of 360°, such as from 180 to -180."""
    found = degrees.astype(np.float64)
    known = np.isfinite(found)
    found[known] = np.unwrap(found[known], period=360.0)
    return found


def with_gaps(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve over time with a NaN where frames are missing."""
    usual = np.median(np.diff(times)) if len(times) > 1 else 0.0
    after = np.flatnonzero(np.diff(times) > max(LONGEST_GAP, 1.5 * usual)) + 1
    return np.insert(times, after, (times[after - 1] + times[after]) / 2.0), np.insert(values, after, np.nan)


def cycle_curves(times: np.ndarray, degrees: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """An angle at `PERCENT` of each cycle (n_cycles, 101), without whole turns; NaN next to frames that lack it."""
    at = spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * PERCENT / 100.0
    curves = np.ma.masked_invalid(np.interp(at, *with_gaps(times, without_jumps(degrees))))
    centre = np.degrees(np.angle(np.exp(1j * np.radians(curves.compressed())).sum()))
    turns = np.rint((curves.mean(axis=1, keepdims=True) - centre) / 360.0)
    return (curves - 360.0 * turns).filled(np.nan)
