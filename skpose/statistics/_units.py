"""The two sets of a test as exchangeable units: single poses or whole motions."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from skpose._utils.validation import check_poses, check_same_width
from skpose._utils.warnings import warn
from skpose.metrics import Metric
from skpose.metrics._matrix import DistanceMatrix, Unconverged
from skpose.metrics._motion_metrics import MotionMetric
from skpose.motions._inputs import CheckedMotions, Sequences, check_motions, is_rows
from skpose.preprocessing._distances import repair_kernel, to_kernel
from skpose.skeleton import Skeleton

FRAMES_OF_A_RECORDING = 0.4  # threshold of `_warn_of_frames`, above the ratio of most recordings


class Units(NamedTuple):
    """The units of both sets."""

    X: CheckedMotions  # a pose is a motion of one frame
    Y: CheckedMotions
    skeleton: Skeleton | None
    are_rows: bool  # whether units are single poses

    @property
    def n_x(self) -> int:
        return self.X.sequences.n_motions

    @property
    def n_y(self) -> int:
        return self.Y.sequences.n_motions

    @property
    def name(self) -> str:
        """The plural noun for a unit."""
        return "poses" if self.are_rows else "motions"

    def encode(self, metric: Metric) -> tuple[Sequences, Sequences]:
        """The rows that the metric compares, for X and Y."""
        if self.are_rows and isinstance(metric, MotionMetric):
            raise ValueError(f"the metric {metric.label!r} needs lists of motions, got arrays of poses")
        return self.X.rows(metric, "X"), self.Y.rows(metric, "Y")


def check_units(X: Any, Y: Any, skeleton: Skeleton | None, paired: bool) -> Units:
    """Validate X and Y, and put them on one skeleton."""
    rows = is_rows(X)
    if rows != is_rows(Y):
        kinds = ("poses", "motions") if rows else ("motions", "poses")
        raise ValueError(
            f"X and Y must both be arrays of poses or both lists of motions, got {kinds[0]} and {kinds[1]}"
        )
    if rows:
        a, b = check_poses(X, skeleton, "X"), check_poses(Y, skeleton, "Y")
        check_same_width(a, b)
        one, other = (CheckedMotions(Sequences(p, np.arange(len(p) + 1)), skeleton, None) for p in (a, b))
    else:
        one, other = check_motions({"X": X, "Y": Y}, skeleton)
    units = Units(one, other, one.skeleton, rows)
    if paired and units.n_x != units.n_y:
        raise ValueError(f"paired=True needs as many {units.name} in X as in Y, got {units.n_x} and {units.n_y}")
    if units.n_x == units.n_y == 1:
        raise ValueError(f"X or Y must have at least two {units.name}, got one each")
    if rows:
        _warn_of_frames(X=a, Y=b)
    return units


def _warn_of_frames(**arrays: np.ndarray) -> None:
    """Warn if rows seem to be consecutive frames of a recording.

    Uses half the ratio of J. von Neumann, "Distribution of the ratio of the mean square successive difference to the
    variance", Annals of Mathematical Statistics 12(4), 1941, :doi:`10.1214/aoms/1177731677`: the mean squared step from
    row to row over that between random rows. Its mean over all orders is 1, its standard deviation at most about 1 /
    √n.
    """
    for name, X in arrays.items():
        if len(X) < 2:
            continue
        steps = np.square(np.diff(X, axis=0), dtype=np.float64).sum(axis=1).mean()
        ratio = steps / max(2.0 * np.var(X, axis=0, ddof=1, dtype=np.float64).sum(), np.finfo(np.float64).tiny)
        if steps > 0 and ratio < min(FRAMES_OF_A_RECORDING, 1.0 - 4.0 / np.sqrt(len(X))):
            warn(
                f"rows of {name} look like consecutive frames, so p is too small: pass a list of motions, "
                f"which are permuted as wholes (mean square step {ratio:.2g} of that in random order)"
            )
            return


# --- unit means -------------------------------------------------------------------------------------------------------
# Means of a function of the distance over all pairs of poses of two units, computed tile by tile.
#
# Both statistics are quadratic forms cᵀGc of such a matrix G, with c = 1 / n for units of X and −1 / m for units of
# Y: G has minus the mean distances for the energy statistic, and mean kernels for the squared MMD.


ROUNDING = 100 * np.finfo(np.float64).eps  # relative to the largest entry of G; smaller differences are ties
POSES_FOR_WIDTH = 500  # at least one per unit


class Distances(NamedTuple):
    """Distances between poses under the user's metric."""

    metric: Metric
    skeleton: Skeleton | None
    n_jobs: int | None

    def between(self, X: np.ndarray, Y: np.ndarray | None, out: Any = None) -> tuple[Any, Unconverged]:
        """Distances, written into `out` if given, and how many of them did not converge."""
        distances, unconverged = DistanceMatrix(X, Y, self.metric, self.skeleton).write(out, self.n_jobs)
        return distances, Unconverged.join(unconverged)


# The matrix G of a statistic, how many distances did not converge, σ of the kernel, and the share of its negative
# eigenvalues before its repair.
UnitMeans = tuple[np.ndarray, Unconverged, float | None, float | None]


def negative_distances(sequences: Sequences, distances: Distances) -> UnitMeans:
    """Minus the mean distance between the poses of every two units."""
    means, unconverged = mean_distances(sequences, None, distances)
    return -means, unconverged, None, None


def mean_distances(X: Sequences, Y: Sequences | None, distances: Distances) -> tuple[np.ndarray, Unconverged]:
    """Mean distances between the poses of the units of X and of Y; Y=None is X."""
    return _means(X, Y, distances, lambda d: d)


def mean_kernel(sequences: Sequences, distances: Distances) -> UnitMeans:
    """Mean of exp(−d² / 2σ²) over the pairs of poses of every two units, made positive semidefinite.

    σ is the median distance between different poses of two units. It does not depend on the split, as every unit
    contributes the same number of poses, evenly spread over its frames.
    """
    chosen, unit = _spread(sequences)
    d, unconverged = distances.between(sequences.poses[chosen], None)
    d = d.astype(np.float64, copy=False)
    apart = d[np.triu(unit[:, None] != unit, 1)]
    apart = apart[apart > 0]
    width = float(np.median(apart)) if len(apart) else 1.0  # all poses are equal, any width will do
    kernel = partial(to_kernel, name="rbf", gamma=0.5 / width**2)
    if len(chosen) == len(sequences.poses):
        sums, everything = Sums(sequences, sequences, kernel), slice(0, len(chosen))
        sums[everything, everything] = d
        means = sums.means()
    else:
        means, unconverged = _means(sequences, None, distances, kernel)
    matrix, repair = repair_kernel(means, np.eye(len(means), dtype=bool), "clip")
    return matrix, unconverged, width, repair.negative_share


def _spread(sequences: Sequences) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the poses that determine the width of the kernel, and their units."""
    n_each = np.minimum(max(1, POSES_FOR_WIDTH // sequences.n_motions), sequences.lengths)
    middles = [
        start + ((np.arange(k) + 0.5) * n / k).astype(int)
        for start, n, k in zip(sequences.starts[:-1], sequences.lengths, n_each, strict=True)
    ]
    return np.concatenate(middles), np.repeat(np.arange(sequences.n_motions), n_each)


def _means(
    X: Sequences, Y: Sequences | None, distances: Distances, function: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, Unconverged]:
    """Means of a function of the distance; each pair of poses is computed once."""
    sums = Sums(X, X if Y is None else Y, function)
    _, unconverged = distances.between(X.poses, None if Y is None else Y.poses, sums)
    return sums.means(), unconverged


class Sums:
    """An array to write distances into, of which it keeps sums of a function over the pairs of poses of two units."""

    def __init__(self, X: Sequences, Y: Sequences, function: Callable[[np.ndarray], np.ndarray]):
        self.X, self.Y, self.function = X, Y, function
        self.sums = np.zeros((X.n_motions, Y.n_motions))

    def __setitem__(self, tile: tuple[slice, slice], distances: np.ndarray) -> None:
        rows, columns = tile
        if self.X is self.Y and rows.start > columns.start:
            return  # a mirror image
        values = self.function(distances.astype(np.float64, copy=False))
        (at, starts), (to, others) = _units_in(self.X, rows), _units_in(self.Y, columns)
        sums = np.add.reduceat(np.add.reduceat(values, others, axis=1), starts, axis=0)
        self.sums[at, to] += sums
        if self.X is self.Y and rows.start < columns.start:
            self.sums[to, at] += sums.T

    def means(self) -> np.ndarray:
        """Means over all pairs of poses; exactly symmetric within one set."""
        means: np.ndarray = self.sums / np.outer(self.X.lengths, self.Y.lengths)
        return 0.5 * (means + means.T) if self.X is self.Y else means


def _units_in(sequences: Sequences, frames: slice) -> tuple[slice, np.ndarray]:
    """The units with frames in a range, and where they begin in it."""
    first = np.searchsorted(sequences.starts, frames.start, side="right") - 1
    last = np.searchsorted(sequences.starts, frames.stop, side="left")
    return slice(first, last), np.maximum(sequences.starts[first:last] - frames.start, 0)
