"""What is kept of many poses: those nearest to each of some others; and the compiled loops that find them.

What is kept for row i stands in ``values[i]``, ``found[i]`` and ``kept[i]``, the number of them: every value up to
``limits[i]`` while there is room; from then on those that come first by value and then by index, as a heap with the
last of them on top.

The loops tell a measure how near a pose must be to count: behind the rows that it puts out, two for a block, stands one
with the limit and, in its second lane, nought, to which a measure that takes note of it adds the blocks that it did not
measure, as their poses are all further away. What it puts out for these is above the limit.
"""

import functools
from typing import NamedTuple

import numpy as np
from numba import from_dtype, types

from skpose._compiled.forward import workspace_rows
from skpose._compiled.jit import inlined, jit
from skpose._compiled.lanes import any_greater, rows
from skpose._compiled.loops import FLOAT64_LANES, GROUPS_IN_CACHE, array_type, measure_type, shared_types
from skpose._compiled.results import aligned, results_of

ROWS_IN_CACHE = 1024  # rows of lanes, where a group has few of them; with less, the call of the measure shows


class Heaps(NamedTuple):
    """What is kept for each query: every value up to its limit while there is room, then the smallest.

    Of equal values the one of the smaller index comes first. A full row is a heap with the last of its entries on top.
    """

    limits: np.ndarray  # (n_queries,)
    values: np.ndarray  # (n_queries, room)
    indices: np.ndarray  # (n_queries, room)
    counts: np.ndarray  # (n_queries,) how many entries are kept


class Candidates(NamedTuple):
    """Poses of an index that may be among the nearest, for each query."""

    indices: np.ndarray  # (n_queries, n_candidates)
    bounds: np.ndarray  # (n_queries, n_candidates) lower bounds of the distances
    counts: np.ndarray  # (n_queries,) how many candidates a query has


class Span(NamedTuple):
    """Queries first:last with the poses start:stop of an index."""

    first: int
    last: int
    start: int
    stop: int


class Batch(NamedTuple):
    """Queries first:last, so many candidates at once, 8 or less."""

    first: int
    last: int
    at_once: int


class Kept:
    """What has been found so far, for each query."""

    def __init__(self, limits: np.ndarray, room: int, dtype: type = np.float64):
        self.limits = np.ascontiguousarray(limits, dtype)
        self.values = np.empty((len(limits), room), dtype)
        self.found = np.empty((len(limits), room), np.int64)
        self.kept = np.zeros(len(limits), np.int64)

    @property
    def heaps(self) -> Heaps:
        """The arrays as the loops take them."""
        return Heaps(self.limits, self.values, self.found, self.kept)

    @property
    def full(self) -> np.ndarray:
        """Whether a row has no more room."""
        return self.kept == self.values.shape[1]

    @property
    def reach(self) -> np.ndarray:
        """No value above it would be kept now."""
        return np.where(self.full, self.values[:, 0], self.limits)

    def put(self, rows: np.ndarray, other: "Kept") -> None:
        """Replace what is kept in some rows by what another of as much room keeps."""
        self.values[rows], self.found[rows], self.kept[rows] = other.values, other.found, other.kept

    def sorted(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Row, index and value of all, by row, value and index; no row has any room."""
        order = np.lexsort((self.found, self.values), axis=1)
        found, values = (np.take_along_axis(part, order, axis=1).ravel() for part in (self.found, self.values))
        return np.repeat(np.arange(len(self.kept)), self.kept), found, values

    def entries(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Row, index and value of all that is kept."""
        held = np.arange(self.values.shape[1]) < self.kept[:, np.newaxis]
        return np.repeat(np.arange(len(self.kept)), self.kept), self.found[held], self.values[held]


@inlined
def _comes_before(value, j, other, k):
    return value < other or (value == other and j < k)


@inlined
def _sink(values, found, i, at, value, j):
    """Put an entry into the heap, from a free place on down."""
    n = values.shape[1]
    while 2 * at + 1 < n:
        low = 2 * at + 1
        if low + 1 < n and _comes_before(values[i, low], found[i, low], values[i, low + 1], found[i, low + 1]):
            low += 1
        if not _comes_before(value, j, values[i, low], found[i, low]):
            break
        values[i, at], found[i, at] = values[i, low], found[i, low]
        at = low
    values[i, at], found[i, at] = value, j


@inlined
def _limit(heaps, i):
    """Above it no value is kept."""
    return heaps.values[i, 0] if heaps.counts[i] == heaps.values.shape[1] else heaps.limits[i]


@inlined
def _keep(value, j, heaps, i):
    """Keep an entry for query i if it is near enough."""
    values, indices, counts = heaps.values, heaps.indices, heaps.counts
    room = values.shape[1]
    if counts[i] == room:
        if _comes_before(value, j, values[i, 0], indices[i, 0]):
            _sink(values, indices, i, 0, value, j)
    elif value <= heaps.limits[i]:
        values[i, counts[i]], indices[i, counts[i]] = value, j
        counts[i] += 1
        if counts[i] == room:
            for at in range(room // 2 - 1, -1, -1):
                _sink(values, indices, i, at, values[i, at], indices[i, at])


@inlined
def _rounding(tree):
    """How much more than a length a bound of it may come out, m; generously."""
    total = 0.0
    for j in range(tree.offset.shape[0]):
        for i in range(3):
            total += abs(tree.offset[j, i])
    return 1e-9 * total


def _keep_nearest(X, Y, span, excluded, measure, tree, steps, heaps):
    n_codes, width = X.shape[1], Y.shape[1]
    n_groups = (span.stop - span.start + width - 1) // width
    n_together = max(GROUPS_IN_CACHE, ROWS_IN_CACHE // n_codes)
    scratch = aligned(workspace_rows(tree), width, X.dtype)
    results = results_of(n_together, width, X.dtype)
    distances, rounding, n_measured = rows(results.distances, 0), _rounding(tree), 0
    for group in range(0, n_groups, n_together):
        end = min(group + n_together, n_groups)
        n_poses = min(end * width, span.stop - span.start) - group * width
        for i in range(span.first, span.last):
            limit = _limit(heaps, i)
            results.limit[0], results.n_ruled_out[0] = 1.000001 * limit + rounding, 0
            measure(X[i], Y, group, end, tree, steps, scratch, results)
            n_measured += max(0, n_poses - results.n_ruled_out[0] * width)
            for k in range(end - group):
                # A little more than the limit, as what is equal to it may count.
                if limit < np.inf and not any_greater(0.0 - distances[k], -1.000001 * limit - 1e-37):
                    continue
                for w in range(width):
                    j = span.start + (group + k) * width + w
                    if j < span.stop and j != excluded[i]:
                        _keep(results.distances[k, w], j, heaps, i)
                limit = _limit(heaps, i)
    return n_measured


def _keep_nearest_of(X, poses, candidates, batch, encode, measure, tree, steps, heaps):
    n_dofs = poses.shape[1]
    scratch = aligned(workspace_rows(tree), FLOAT64_LANES, X.dtype)
    pose = aligned(n_dofs, FLOAT64_LANES, X.dtype)
    code = aligned(X.shape[1], FLOAT64_LANES, X.dtype)
    results = results_of(1, FLOAT64_LANES, X.dtype)
    taken = np.empty(FLOAT64_LANES, np.int64)
    rounding, n_measured, n_unconverged, worst = _rounding(tree), 0, 0, 0.0
    for i in range(batch.first, batch.last):
        at = 0
        while at < candidates.counts[i]:
            n, limit = 0, _limit(heaps, i)
            while at < candidates.counts[i] and n < batch.at_once:
                if candidates.bounds[i, at] <= limit:
                    taken[n] = candidates.indices[i, at]
                    n += 1
                at += 1
            if n == 0:
                break
            results.limit[0], results.n_ruled_out[0] = 1.000001 * limit + rounding, 0
            for w in range(FLOAT64_LANES):
                results.skip[0, w], results.gap[0, w] = w >= n, 0.0
                for d in range(n_dofs):
                    pose[d, w] = poses[taken[min(w, n - 1)], d]
            encode(pose, tree, steps, scratch, code)
            measure(X[i], code, 0, 1, tree, steps, scratch, results)
            n_measured += n * (1 - results.n_ruled_out[0])
            for w in range(n):
                _keep(results.distances[0, w], taken[w], heaps, i)
                if results.gap[0, w] > 0.0:
                    n_unconverged += 1
                    worst = max(worst, results.gap[0, w])
    return n_measured, n_unconverged, worst


def _heaps_type(real):
    """numba's type of Heaps."""
    whole = types.int64
    kinds = ((real, 1), (real, 2), (whole, 2), (whole, 1))
    return types.NamedTuple([array_type(kind, ndim, readonly=False) for kind, ndim in kinds], Heaps)


# Compiled when first requested, see `skpose._compiled.loops`.


@functools.cache
def keep_nearest_loop(dtype):
    """``loop(X, Y, span, excluded, measure, tree, steps, heaps)``: keep the nearest of an index's poses.

    Keeps, for the rows of a Span of X, encoded poses, what is nearest in Y, the span's poses of an index in groups of
    lanes, but for the pose excluded[i]. Returns how many pairs were measured. For measures that always converge.
    """
    real, at = from_dtype(dtype), types.int64
    tree, steps = shared_types(dtype)
    X, Y = array_type(real, 2, readonly=True), array_type(real, 2, readonly=True)
    span, excluded = types.NamedUniTuple(at, 4, Span), array_type(types.int64, 1, readonly=True)
    signature = types.int64(X, Y, span, excluded, measure_type(dtype), tree, steps, _heaps_type(real))
    return jit(_keep_nearest, signatures=[signature])


@functools.cache
def keep_nearest_of_loop(dtype):
    """``loop(X, poses, candidates, batch, encode, measure, tree, steps, heaps)``: keep the nearest of candidates.

    Keeps, for the rows of a Batch of X, encoded poses, what is nearest of their Candidates among the poses, which are
    of this dtype. Candidates are taken in order, at most so many at once, and those not at all whose bound, which no
    distance is below, is above what would be kept. Returns how many were measured, how many geodesics did not converge
    and the largest of their gaps.
    """
    real, at, float64 = types.float64, types.int64, np.dtype(np.float64)
    tree, steps = shared_types(float64)
    row = array_type(real, 2, readonly=False)
    encode = types.FunctionType(types.void(row, tree, steps, row, row))
    X, poses = array_type(real, 2, readonly=True), array_type(from_dtype(dtype), 2, readonly=True)
    kinds = (types.int64, 2), (real, 2), (types.int64, 1)
    candidates = types.NamedTuple([array_type(*kind, readonly=False) for kind in kinds], Candidates)
    batch = types.NamedUniTuple(at, 3, Batch)
    counts = types.Tuple((types.int64, types.int64, real))
    signature = counts(X, poses, candidates, batch, encode, measure_type(float64), tree, steps, _heaps_type(real))
    return jit(_keep_nearest_of, signatures=[signature])
