"""What is kept of many poses: those nearest to each of some others; and the compiled loops that find them.

What is kept for row i stands in ``values[i]``, ``found[i]`` and ``kept[i]``, the number of them: every value up to
``limits[i]`` while there is room; from then on those that come first by value and then by index, as a heap with the
last of them on top.

The loops tell a measure how near a pose must be to count: behind the rows that it puts out, two for a block, stands one
with the limit and, in its second lane, nought, to which a measure that takes note of it adds the blocks that it did not
measure, as their poses are all further away. What it puts out for these is above the limit.
"""

import functools

import numpy as np
from numba import from_dtype, types

from skpose._compiled.forward import workspace_rows
from skpose._compiled.jit import inlined, jit
from skpose._compiled.lanes import anywhere, rows
from skpose._compiled.loops import BLOCKS_IN_CACHE, FLOAT64_LANES, aligned, array_type, shared_types

ROWS_IN_CACHE = 1024  # rows of lanes, where a block has few of them; with less, the call of the measure shows


class Kept:
    """What has been found so far, for each query."""

    def __init__(self, limits: np.ndarray, room: int, dtype: type = np.float64):
        self.limits = np.ascontiguousarray(limits, dtype)
        self.values = np.empty((len(limits), room), dtype)
        self.found = np.empty((len(limits), room), np.int64)
        self.kept = np.zeros(len(limits), np.int64)

    @property
    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """As the loops take them."""
        return self.limits, self.values, self.found, self.kept

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
def _limit(limits, values, kept, i):
    """No value above it is kept."""
    return values[i, 0] if kept[i] == values.shape[1] else limits[i]


@inlined
def _keep(value, j, limits, values, found, kept, i):
    room = values.shape[1]
    if kept[i] == room:
        if _comes_before(value, j, values[i, 0], found[i, 0]):
            _sink(values, found, i, 0, value, j)
    elif value <= limits[i]:
        values[i, kept[i]], found[i, kept[i]] = value, j
        kept[i] += 1
        if kept[i] == room:
            for at in range(room // 2 - 1, -1, -1):
                _sink(values, found, i, at, values[i, at], found[i, at])


@inlined
def _rounding(tree):
    """How much more than a length a bound of it may come out, m; generously."""
    total = 0.0
    for j in range(tree.offset.shape[0]):
        for i in range(3):
            total += abs(tree.offset[j, i])
    return 1e-9 * total


def _keep_nearest(X, Y, first, last, start, stop, own, measure, tree, steps, limits, values, found, kept):
    n_codes, width = X.shape[1], Y.shape[1]
    n_blocks = (stop - start + width - 1) // width
    n_together = max(BLOCKS_IN_CACHE, ROWS_IN_CACHE // n_codes)
    scratch = aligned(workspace_rows(tree), width, X.dtype)
    out = aligned(2 * n_together + 1, width, X.dtype)
    results, rounding, n_measured = rows(out, 0), _rounding(tree), 0
    for group in range(0, n_blocks, n_together):
        end = min(group + n_together, n_blocks)
        behind, n_poses = 2 * (end - group), min(end * width, stop - start) - group * width
        for i in range(first, last):
            limit = _limit(limits, values, kept, i)
            out[behind, 0], out[behind, 1] = 1.000001 * limit + rounding, 0.0
            measure(X[i], Y, group, end, tree, steps, scratch, out)
            n_measured += max(0, n_poses - int(out[behind, 1]) * width)
            for k in range(end - group):
                # A little more than the limit, as what is equal to it may count.
                if limit < np.inf and not anywhere(0.0 - results[2 * k], -1.000001 * limit - 1e-37):
                    continue
                for w in range(width):
                    j = start + (group + k) * width + w
                    if j < stop and j != own[i]:
                        _keep(out[2 * k, w], j, limits, values, found, kept, i)
                limit = _limit(limits, values, kept, i)
    return n_measured


def _keep_nearest_of(
    X,
    poses,
    candidates,
    bounds,
    n_candidates,
    first,
    last,
    at_once,
    encode,
    measure,
    tree,
    steps,
    limits,
    values,
    found,
    kept,
):
    n_dofs = poses.shape[1]
    scratch = aligned(workspace_rows(tree), FLOAT64_LANES, X.dtype)
    pose = aligned(n_dofs, FLOAT64_LANES, X.dtype)
    code = aligned(X.shape[1], FLOAT64_LANES, X.dtype)
    out = aligned(3, FLOAT64_LANES, X.dtype)
    taken = np.empty(FLOAT64_LANES, np.int64)
    rounding, n_measured, n_doubtful, worst = _rounding(tree), 0, 0, 0.0
    for i in range(first, last):
        at = 0
        while at < n_candidates[i]:
            n, limit = 0, _limit(limits, values, kept, i)
            while at < n_candidates[i] and n < at_once:
                if bounds[i, at] <= limit:
                    taken[n] = candidates[i, at]
                    n += 1
                at += 1
            if n == 0:
                break
            out[2, 0], out[2, 1] = 1.000001 * limit + rounding, 0.0
            for w in range(FLOAT64_LANES):
                out[1, w] = 0.0 if w < n else -1.0
                for d in range(n_dofs):
                    pose[d, w] = poses[taken[min(w, n - 1)], d]
            encode(pose, tree, steps, scratch, code)
            measure(X[i], code, 0, 1, tree, steps, scratch, out)
            n_measured += n * (1 - int(out[2, 1]))
            for w in range(n):
                _keep(out[0, w], taken[w], limits, values, found, kept, i)
                if out[1, w] > 0.0:
                    n_doubtful += 1
                    worst = max(worst, out[1, w])
    return n_measured, n_doubtful, worst


def _heap_types(real):
    """numba's types of limits, values, found and kept."""
    whole = types.int64
    kinds = ((real, 1), (real, 2), (whole, 2), (whole, 1))
    return [array_type(kind, ndim, readonly=False) for kind, ndim in kinds]


# Compiled when first asked for, see `skpose._compiled.loops`.


@functools.cache
def keep_nearest_loop(dtype):
    """``loop(X, Y, first, last, start, stop, own, measure, tree, steps, limits, values, found, kept)``.

    Keeps, for the rows first:last of X, encoded poses, what is nearest of Y, the poses start:stop of an index in blocks
    of lanes, but for the pose own[i]. Returns how many pairs were measured. For measures that
    are never in doubt.
    """
    real, at = from_dtype(dtype), types.intp
    tree, steps = shared_types(dtype)
    x, Y = array_type(real, 1, readonly=True), array_type(real, 2, readonly=True)
    scratch = array_type(real, 2, readonly=False)
    measure = types.FunctionType(types.void(x, Y, at, at, tree, steps, scratch, scratch))
    X, own = array_type(real, 2, readonly=True), array_type(types.int64, 1, readonly=True)
    signature = types.int64(X, Y, at, at, at, at, own, measure, tree, steps, *_heap_types(real))
    return jit(_keep_nearest, signatures=[signature])


@functools.cache
def keep_nearest_of_loop(dtype):
    """``loop(X, poses, candidates, bounds, n_candidates, first, last, at_once, encode, measure, tree, steps, …)``.

    Keeps, for the rows first:last of X, encoded poses, what is nearest of the candidates[i, :n_candidates[i]] among
    the poses, which are of this dtype; … is limits, values, found, kept. They are taken in order, at most so many at
    once, 8 or less, and those not at all whose bound, which no distance is below, says that they would not be kept.
    Returns how many were measured, how many of the distances are in doubt and by how much at most.
    """
    real, at = types.float64, types.intp
    tree, steps = shared_types(np.dtype(np.float64))
    x, row = array_type(real, 1, readonly=True), array_type(real, 2, readonly=False)
    encode = types.FunctionType(types.void(row, tree, steps, row, row))
    Y = array_type(real, 2, readonly=True)
    measure = types.FunctionType(types.void(x, Y, at, at, tree, steps, row, row))
    X, poses = array_type(real, 2, readonly=True), array_type(from_dtype(dtype), 2, readonly=True)
    candidates, bounds = (array_type(kind, 2, readonly=True) for kind in (types.int64, real))
    n_candidates = array_type(types.int64, 1, readonly=True)
    counts = types.Tuple((types.int64, types.int64, real))
    signature = counts(
        X,
        poses,
        candidates,
        bounds,
        n_candidates,
        at,
        at,
        at,
        encode,
        measure,
        tree,
        steps,
        *_heap_types(real),
    )
    return jit(_keep_nearest_of, signatures=[signature])
