"""Repetitions against each other: how far each joint is from where the others have it, phase by phase.

Tempo has no part in it. All repetitions are brought to one time base, that of their common course: each is resampled
to `STEPS` equal steps of its own duration, and aligned by dynamic time warping to the median of all, which begins with
the repetition that is nearest to the others. The *phase* of a step is the median of the times, as shares of the
duration, at which the repetitions are there.

At each phase a repetition is then compared with the median of the *other* ones, so that a wrong one neither hides in
its own reference nor moves that of the rest. The spread of a joint is the median of the distances of the other
repetitions from this reference, averaged over neighbouring phases. A spread of a few repetitions is by chance small
now and then; so the ratio of both has the typical spread, that of the median joint and phase, added to the denominator
(V. G. Tusher, R. Tibshirani, G. Chu, 2001, doi:10.1073/pnas.091062498).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import cdist

from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose.kinematics import forward_kinematics
from skpose.skeleton import Skeleton

STEPS = 200  # of a repetition
ROUNDS = 2  # of alignment: to the first repetition, and to the median of the aligned ones
LEAST = 4  # repetitions that have a spread: the median of three others is safe from one that is wrong
RESOLUTION = 1e-6  # m, below what any recording shows: equal repetitions have no spread to be divided by


class Deviations(NamedTuple):
    """Deviations of K repetitions from the others, at P phases, of J joints."""

    phases: np.ndarray  # (P,) middle of each phase, as a share of the cycle
    frames: np.ndarray  # (K, P) frame of each repetition at each phase
    positions: np.ndarray  # (K, P, J, 3) mean positions of the joints in each phase, m
    vectors: np.ndarray  # (K, P, J, 3) to these from the reference, m
    spread: np.ndarray  # (K, P, J) median distance of the others from the reference, m; NaN where there are too few
    typical_spread: float  # of the median joint and phase, m

    @property
    def distances(self) -> np.ndarray:
        """Deviations (K, P, J), m."""
        return np.linalg.norm(self.vectors, axis=3)

    @property
    def ratios(self) -> np.ndarray:
        """Deviations (K, P, J) in units of what is usual."""
        return self.distances / np.maximum(self.spread + self.typical_spread, RESOLUTION)


def deviations_of(poses: Sequence[np.ndarray], skeleton: Skeleton, n_phases: int) -> Deviations:
    """Return how much repetitions, arrays (n_frames, n_dofs), deviate from each other; there are at least two."""
    steps = [_resample(forward_kinematics(one.astype(np.float64), skeleton)) for one in poses]
    weights = np.sqrt(skeleton.weights)[:, None]  # as in every metric
    courses, times = _align(np.stack(steps), weights)
    fine = -(-STEPS // n_phases)  # points of a phase
    at = (np.arange(n_phases * fine) + 0.5) / (n_phases * fine)
    phase = np.maximum.accumulate(np.median(times, axis=0))
    found = np.stack([_means(_interpolate(at, phase, course), n_phases) for course in courses])
    lasts = np.array([len(one) - 1 for one in poses])
    frames = np.stack([_means(_interpolate(at, phase, time), n_phases) for time in times]) * lasts[:, None]
    vectors, spread = _leave_one_out(found)
    if len(poses) < LEAST:
        spread[:] = np.nan
    phases = (np.arange(n_phases) + 0.5) / n_phases
    return Deviations(phases, frames, found, vectors, spread, float(np.median(spread)))


def _resample(positions: np.ndarray) -> np.ndarray:
    """Return positions (n_frames, ...) at equal steps from the first frame to the last one."""
    at = np.linspace(0.0, len(positions) - 1.0, STEPS + 1)
    return _interpolate(at, np.arange(len(positions), dtype=float), positions)


def _interpolate(at: np.ndarray, x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return values (n, ...), known at ascending x, at other places; beyond the ends they stay as they are.

    Where several x are equal, as where most repetitions wait for some, the values there are passed at once.
    """
    right = np.searchsorted(x, at, side="right").clip(1, max(len(x) - 1, 1))
    left, right = right - 1, np.minimum(right, len(x) - 1)
    gap = x[right] - x[left]
    share = np.divide(at - x[left], gap, out=np.zeros(len(at)), where=gap > 0.0).clip(0.0, 1.0)
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    return (1.0 - share) * values[left] + share * values[right]


def _means(values: np.ndarray, n_phases: int) -> np.ndarray:
    """Return the mean over the points of each phase."""
    return values.reshape(n_phases, -1, *values.shape[1:]).mean(axis=1)


def _align(steps: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return repetitions (K, n, J, 3) on one time base, and their times there (K, n), as shares of their durations."""
    moving = np.flatnonzero(weights[:, 0] * np.ptp(steps, axis=(0, 1)).max(axis=1))  # the others cost nothing
    weighted = (weights * steps)[:, :, moving]
    apart = [np.median([np.linalg.norm(a - b, axis=2).mean() for b in weighted]) for a in weighted]
    reference, courses, times = weighted[int(np.argmin(apart))], steps, np.zeros(steps.shape[:2])
    for _ in range(ROUNDS):
        paths = [_path(reference, one) for one in weighted]
        courses = np.stack([_mean_of_pairs(path, one) for path, one in zip(paths, steps, strict=True)])
        shares = np.linspace(0.0, 1.0, steps.shape[1])
        times = np.stack([_mean_of_pairs(path, shares) for path in paths])
        reference = np.median((weights * courses)[:, :, moving], axis=0)
    return courses, times


def _path(reference: np.ndarray, one: np.ndarray) -> np.ndarray:
    """Return the pairs of steps (n_pairs, 2) by dynamic time warping, under the sum of the joints' distances.

    Sums of squares would let the one limb that is off choose the time for all others.
    """
    sums = np.zeros((len(reference), len(one)))
    for a, b in zip(reference.swapaxes(0, 1), one.swapaxes(0, 1), strict=True):
        sums += cdist(a, b)
    accumulate(sums, Paths.of(None))
    return path_to(sums, False, len(one) - 1)


def _mean_of_pairs(path: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return for each step of the reference the mean of the values (n, ...) that are aligned to it."""
    first = np.flatnonzero(np.diff(path[:, 0], prepend=-1))  # none is left out
    counts = np.diff(first, append=len(path)).reshape(-1, *[1] * (values.ndim - 1))
    return np.add.reduceat(values[path[:, 1]], first, axis=0) / counts


def _leave_one_out(found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the differences of repetitions (K, P, J, 3) from the median of the others, and the spread (K, P, J)."""
    vectors, spread = np.empty(found.shape), np.empty(found.shape[:3])
    for k in range(len(found)):
        others = np.delete(found, k, axis=0)
        reference = np.median(others, axis=0)
        vectors[k] = found[k] - reference
        spread[k] = _smooth(np.median(np.linalg.norm(others - reference, axis=3), axis=0))
    return vectors, spread


def _smooth(values: np.ndarray) -> np.ndarray:
    """Return the means of each phase and its two neighbours (P, J), at the ends of two."""
    ones = np.ones(len(values))
    padded, counts = np.pad(values, [(1, 1), (0, 0)]), np.pad(ones, 1)
    sums = padded[:-2] + padded[1:-1] + padded[2:]
    return sums / (counts[:-2] + counts[1:-1] + counts[2:])[:, None]
