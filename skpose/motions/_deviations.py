"""Repetitions against each other: how far each joint is from where the others have it, phase by phase.

Tempo has no part in it. All repetitions are brought to one time base, that of their common course: each is resampled
to `STEPS` equal steps of its own duration, and aligned by dynamic time warping to the median of all, which begins with
the repetition that is nearest to the others. The *phase* of a step is the median of the times, as shares of the
duration, at which the repetitions are there.

The ends are open. A repetition may be cut early or late, as one that began before the recording, and then it lacks
phases of the others, or has steps that no other has. At each end one of the two may be left out of the path, at a price
for each step that is twice the usual distance from the median. As it cannot be both, a repetition that is wrong at an
end is aligned there nevertheless.

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
ROUNDS = 3  # of alignment: to the repetition in the middle, and twice to the median of the aligned ones
PRICE = 2.0  # of a step that is left out at an end, in units of the usual distance
MOST = 1 / 3  # of the steps that are left out at an end: what is odd all along is compared nevertheless
LEAST = 4  # repetitions that have a spread: the median of three others is safe from one that is wrong
RESOLUTION = 1e-6  # m, below what any recording shows: equal repetitions have no spread to be divided by


class Deviations(NamedTuple):
    """Deviations of K repetitions from the others, at P phases, of J joints; NaN at phases that a repetition lacks."""

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
    phase = _median(times)
    known = ~np.isnan(phase)  # by any repetition
    phase, courses, times = np.maximum.accumulate(phase[known]), courses[:, known], times[:, known]
    found = np.stack([_means(_interpolate(at, phase, course), n_phases) for course in courses])
    lasts = np.array([len(one) - 1 for one in poses])
    frames = np.stack([_means(_interpolate(at, phase, time), n_phases) for time in times]) * lasts[:, None]
    vectors, spread = _leave_one_out(found)
    spreads = spread[~np.isnan(spread)]
    phases = (np.arange(n_phases) + 0.5) / n_phases
    return Deviations(phases, frames, found, vectors, spread, float(np.median(spreads)) if len(spreads) else np.nan)


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
    """Return the mean over the points of each phase; NaN where more than half of them are missing."""
    values = values.reshape(n_phases, -1, *values.shape[1:])
    missing = np.isnan(values)
    counts = (~missing).sum(axis=1)
    sums = np.where(missing, 0.0, values).sum(axis=1)
    return np.divide(sums, counts, out=np.full(sums.shape, np.nan), where=2 * counts >= values.shape[1])


def _align(steps: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return repetitions (K, n, J, 3) on one time base, and their times there (K, n), as shares of their durations.

    Both are NaN where a repetition lacks a step of the others.
    """
    moving = np.flatnonzero(weights[:, 0] * np.ptp(steps, axis=(0, 1)).max(axis=1))  # the others cost nothing
    weighted = (weights * steps)[:, :, moving]
    apart = [np.median([np.linalg.norm(a - b, axis=2).sum(axis=1).mean() for b in weighted]) for a in weighted]
    first = int(np.argmin(apart))
    reference, usual = weighted[first], float(apart[first])
    shares = np.linspace(0.0, 1.0, steps.shape[1])
    courses, times = steps, np.zeros(steps.shape[:2])
    for _ in range(ROUNDS):
        paths = [_path(reference, one, PRICE * usual) for one in weighted]
        courses = np.stack([_mean_of_pairs(path, one) for path, one in zip(paths, steps, strict=True)])
        times = np.stack([_mean_of_pairs(path, shares) for path in paths])
        aligned = (weights * courses)[:, :, moving]
        middle = _median(aligned)
        reference = np.where(np.isnan(middle), reference, middle)
        usual = float(np.nanmedian(np.linalg.norm(aligned - reference, axis=3).sum(axis=2)))
    return courses, times


def _path(reference: np.ndarray, one: np.ndarray, price: float) -> np.ndarray:
    """Return the pairs of steps (n_pairs, 2) by dynamic time warping, under the sum of the joints' distances.

    Sums of squares would let the one limb that is off choose the time for all others. The first and the last row and
    column of the matrix stand for steps that are left out.
    """
    costs = np.full((len(reference) + 2, len(one) + 2), np.inf)
    for edge in (costs[0], costs[:, 0], costs[-1, ::-1], costs[::-1, -1]):
        edge[: int(MOST * len(edge))] = price
    inside = costs[1:-1, 1:-1]
    inside[:] = 0.0
    for a, b in zip(reference.swapaxes(0, 1), one.swapaxes(0, 1), strict=True):
        inside += cdist(a, b)
    accumulate(costs, Paths.of(None))
    path = path_to(costs, False, costs.shape[1] - 1) - 1
    is_pair = (path >= 0).all(axis=1) & (path < [len(reference), len(one)]).all(axis=1)
    return path[is_pair]


def _mean_of_pairs(path: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return for each step of the reference the mean of the values (n, ...) that are aligned to it, or NaN."""
    first = np.flatnonzero(np.diff(path[:, 0], prepend=-1))  # none between is left out
    counts = np.diff(first, append=len(path)).reshape(-1, *[1] * (values.ndim - 1))
    means = np.full(values.shape, np.nan)
    means[path[first, 0]] = np.add.reduceat(values[path[:, 1]], first, axis=0) / counts
    return means


def _leave_one_out(found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the differences of repetitions (K, P, J, 3) from the median of the others, and the spread (K, P, J).

    The spread is NaN where fewer than three others have the phase, and both where no other has it.
    """
    vectors, spread = np.empty(found.shape), np.empty(found.shape[:3])
    for k in range(len(found)):
        others = np.delete(found, k, axis=0)
        n_others = (~np.isnan(others[..., 0])).sum(axis=0)
        reference = _median(others)
        vectors[k] = found[k] - reference
        far = _median(np.linalg.norm(others - reference, axis=3))
        spread[k] = _smooth(np.where(n_others + 1 < LEAST, np.nan, far))
    return vectors, spread


def _median(values: np.ndarray) -> np.ndarray:
    """Return the median of the first axis without NaN; NaN where there is nothing else, without a warning."""
    ordered = np.sort(values, axis=0)  # NaN is last
    n = (~np.isnan(values)).sum(axis=0)[None]
    low, high = (np.take_along_axis(ordered, i.clip(min=0), axis=0)[0] for i in ((n - 1) // 2, n // 2 - (n == 0)))
    return (low + high) / 2.0


def _smooth(values: np.ndarray) -> np.ndarray:
    """Return the means of each phase and its two neighbours (P, J), of those that are known; NaN stays."""
    padded = np.pad(values, [(1, 1), (0, 0)], constant_values=np.nan)
    three = np.stack([padded[:-2], padded[1:-1], padded[2:]])
    known = ~np.isnan(three)
    means = np.where(known, three, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    return np.where(np.isnan(values), np.nan, means)
