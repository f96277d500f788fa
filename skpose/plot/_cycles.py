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
    if isinstance(cycles, Repetitions):
        if not len(cycles):
            raise ValueError("cycles must have repetitions, got none")
        if cycles.times is not None:
            _check_times(cycles.times, angles)
        frames, noun = np.stack([cycles.starts, cycles.stops], axis=1), "repetition"
    else:
        frames, noun = np.asarray(cycles), "cycle"
        if frames.ndim != 2 or frames.shape[1] != 2 or not np.issubdtype(frames.dtype, np.integer):
            raise ValueError("cycles must be GaitEvents, Repetitions, or whole numbers of shape (n_cycles, 2)")
        if not len(frames) or frames.min() < 0 or (np.diff(frames) < 2).any():
            raise ValueError("cycles must have at least two frames each, start and stop of angles[start:stop]")
    if frames.max() > len(angles):
        raise ValueError(f"cycles must end by frame {len(angles)}, the last one of angles, got {frames.max()}")
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


def cycle_curves(times: np.ndarray, degrees: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """An angle at `PERCENT` of each cycle (n_cycles, 101); NaN next to frames that lack it."""
    at = spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * PERCENT / 100.0
    curves = _interpolate(at.clip(times[0], times[-1]), times, without_jumps(degrees))
    return curves - _turns(curves)


def _interpolate(at: np.ndarray, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values at other times, by linear interpolation between neighbouring frames."""
    right = np.searchsorted(times, at, side="left")
    left = np.where(times[right] > at, right - 1, right)  # equal at a frame
    gap = times[right] - times[left]
    share = np.divide(at - times[left], gap, out=np.zeros(at.shape), where=gap > 0.0)
    found = values[left] + share * (values[right] - values[left])
    return np.where(gap > _longest_gap(times), np.nan, found)


def _longest_gap(times: np.ndarray) -> float:
    """The time without frames, s, across which a curve is drawn."""
    return max(LONGEST_GAP, 1.5 * float(np.median(np.diff(times)))) if len(times) > 1 else LONGEST_GAP


def with_gaps(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve over time with a NaN where frames are missing."""
    after = np.flatnonzero(np.diff(times) > _longest_gap(times)) + 1
    return np.insert(times, after, (times[after - 1] + times[after]) / 2.0), np.insert(values, after, np.nan)


def _turns(curves: np.ndarray) -> np.ndarray:
    """Multiples of 360° (n, 1) between curves and the mean direction of all."""
    known = np.isfinite(curves)
    counts = known.sum(axis=1, keepdims=True)
    means = np.where(known, curves, 0.0).sum(axis=1, keepdims=True) / np.maximum(counts, 1)
    directions = np.exp(1j * np.radians(curves[known]))
    centre = np.degrees(np.angle(directions.sum()))
    return 360.0 * np.rint((means - centre) / 360.0)


class MeanCurve(NamedTuple):
    """The mean of an angle over the cycles in which it is known."""

    mean: np.ndarray  # (101,) degrees; NaN if no cycle has it
    std: np.ndarray  # (101,) degrees, with n - 1; NaN for fewer than two cycles
    counts: np.ndarray  # (101,) cycles in which it is known


def mean_curve(curves: np.ndarray) -> MeanCurve:
    """Mean and standard deviation of curves (n_cycles, 101)."""
    known = np.isfinite(curves)
    counts = known.sum(axis=0)
    mean = np.divide(
        np.where(known, curves, 0.0).sum(axis=0), counts, out=np.full(len(counts), np.nan), where=counts > 0
    )
    squares = np.where(known, (curves - mean) ** 2, 0.0).sum(axis=0)
    variance = np.divide(squares, counts - 1, out=np.full(len(counts), np.nan), where=counts > 1)
    return MeanCurve(mean, np.sqrt(variance), counts)
