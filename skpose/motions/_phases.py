"""Curves over the phases of cycles, from 0 to 100 %."""

import numpy as np

PHASES = np.arange(101.0)  # % of the cycle, at which curves are known
LONGEST_GAP = 0.1  # s without frames across which curves are interpolated


def without_jumps(angles: np.ndarray, period: float = 360.0) -> np.ndarray:
    """An angle over time without jumps of a whole turn, such as from 180 to -180; NaN stays."""
    found = angles.astype(np.float64)
    known = np.isfinite(found)
    found[known] = np.unwrap(found[known], period=period)
    return found


def with_gaps(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve over time with a NaN where frames are missing."""
    usual = np.median(np.diff(times)) if len(times) > 1 else 0.0
    after = np.flatnonzero(np.diff(times) > max(LONGEST_GAP, 1.5 * usual)) + 1
    return np.insert(times, after, (times[after - 1] + times[after]) / 2.0), np.insert(values, after, np.nan)


def over_phases(times: np.ndarray, degrees: np.ndarray, spans: np.ndarray, zeros: np.ndarray) -> np.ndarray:
    """An angle at `PHASES` of each cycle (n_cycles, 101), relative to a zero (n_cycles,) of each.

    It is NaN next to frames that lack it. Cycles that differ by whole turns are shifted onto each other.
    """
    at = spans[:, :1] + (spans[:, 1:] - spans[:, :1]) * PHASES / 100.0
    curves = np.interp(at, *with_gaps(times, without_jumps(degrees))) - zeros[:, None]
    known = np.ma.masked_invalid(curves)
    centre = np.degrees(np.angle(np.exp(1j * np.radians(known.compressed())).sum()))
    turns = np.rint((known.mean(axis=1, keepdims=True) - centre) / 360.0)
    return np.asarray((known - 360.0 * turns).filled(np.nan))
