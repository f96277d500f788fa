"""The compiled loops that find, for each query, the nearest poses of an index.

What is found is kept in `Heaps`, one row for each query. Equal values are ordered by index, so what is kept depends
neither on the order in which poses come nor on the number of threads.

Both loops pass a limit to the measure, in ``results.limit``: a distance above it is not needed. A measure that uses the
limit writes any lower bound above it instead, for a whole group of lanes at once, and adds the number of such groups to
``results.n_ruled_out``. These poses are then not kept.
"""

import functools
from typing import NamedTuple

import numpy as np
from numba import from_dtype, types

from skpose._compiled.forward import workspace_rows
from skpose._compiled.jit import inlined, jit
from skpose._compiled.lanes import any_greater, rows
from skpose._compiled.loops import FLOAT64_LANES, GROUPS_IN_CACHE, encode_type, measure_type
from skpose._compiled.results import aligned, results_of
from skpose._compiled.signatures import array_type, named, shared_types

ROWS_IN_CACHE = 1024  # rows of lanes, where a group has few of them; with less, the call of the measure shows


class Heaps(NamedTuple):
    """The nearest poses found so far for each query, by distance or by a lower bound of it.

    While there is space, every value up to the limit is kept. A row that is full is a max-heap: its last entry, by
    value and then by index, is the first of the row, and entries that come before it replace it.
    """

    limits: np.ndarray  # (n_queries,) largest value that is kept
    values: np.ndarray  # (n_queries, capacity) distances or bounds
    indices: np.ndarray  # (n_queries, capacity) of the poses, in the index
    counts: np.ndarray  # (n_queries,) number of entries


class Candidates(NamedTuple):
    """Poses of an index that may be among the nearest of each query; a query's loop takes them in order."""

    indices: np.ndarray  # (n_queries, n_candidates)
    bounds: np.ndarray  # (n_queries, n_candidates) lower bounds of the distances
    counts: np.ndarray  # (n_queries,) number of candidates


class Span(NamedTuple):
    """A tile: the queries first:last and the poses start:stop of an index."""

    first: int
    last: int
    start: int
    stop: int


class Batch(NamedTuple):
    """The queries first:last, and how many of a query's candidates are measured at once, FLOAT64_LANES at most."""

    first: int
    last: int
    at_once: int


@inlined
def _comes_before(value, j, other_value, other_j):
    return value < other_value or (value == other_value and j < other_j)


@inlined
def _sift_down(values, indices, i, node, value, j):
    """Put an entry into row i, a heap but for this free node: children that come after the entry move up."""
    n = values.shape[1]
    while 2 * node + 1 < n:
        child = 2 * node + 1
        if child + 1 < n and _comes_before(
            values[i, child], indices[i, child], values[i, child + 1], indices[i, child + 1]
        ):
            child += 1
        if not _comes_before(value, j, values[i, child], indices[i, child]):
            break
        values[i, node], indices[i, node] = values[i, child], indices[i, child]
        node = child
    values[i, node], indices[i, node] = value, j


@inlined
def _limit(heaps, i):
    """Return the largest value that query i would still keep."""
    return heaps.values[i, 0] if heaps.counts[i] == heaps.values.shape[1] else heaps.limits[i]


@inlined
def _keep(value, j, heaps, i):
    """Keep pose j for query i if it is near enough."""
    values, indices, counts = heaps.values, heaps.indices, heaps.counts
    capacity = values.shape[1]
    if counts[i] == capacity:
        if _comes_before(value, j, values[i, 0], indices[i, 0]):
            _sift_down(values, indices, i, 0, value, j)
    elif value <= heaps.limits[i]:
        values[i, counts[i]], indices[i, counts[i]] = value, j
        counts[i] += 1
        if counts[i] == capacity:
            for node in range(capacity // 2 - 1, -1, -1):
                _sift_down(values, indices, i, node, values[i, node], indices[i, node])


@inlined
def _rounding(tree):
    """Return how far above a length its lower bound may lie by rounding, m; a generous estimate."""
    total = 0.0
    for j in range(tree.offset.shape[0]):
        for i in range(3):
            total += abs(tree.offset[j, i])
    return 1e-9 * total * tree.scale.max()


def _nearest_of_tile(queries, Y, span, excluded, measure, tree, steps, heaps):
    n_codes, width = queries.shape[1], Y.shape[1]
    n_groups = (span.stop - span.start + width - 1) // width
    n_together = max(GROUPS_IN_CACHE, ROWS_IN_CACHE // n_codes)
    scratch = aligned(workspace_rows(tree), width, queries.dtype)
    results = results_of(n_together, width, queries.dtype)
    distances, rounding, n_measured = rows(results.distances, 0), _rounding(tree), 0
    for group in range(0, n_groups, n_together):
        end = min(group + n_together, n_groups)
        n_poses = min(end * width, span.stop - span.start) - group * width
        for i in range(span.first, span.last):
            limit = _limit(heaps, i)
            results.limit[0], results.n_ruled_out[0] = 1.000001 * limit + rounding, 0
            measure(queries[i], Y, group, end, tree, steps, scratch, results)
            n_measured += max(0, n_poses - results.n_ruled_out[0] * width)
            for k in range(end - group):
                # A little more than the limit, as a distance equal to it may be kept.
                if limit < np.inf and not any_greater(0.0 - distances[k], -1.000001 * limit - 1e-37):
                    continue
                for w in range(width):
                    j = span.start + (group + k) * width + w
                    if j < span.stop and j != excluded[i]:
                        _keep(results.distances[k, w], j, heaps, i)
                limit = _limit(heaps, i)
    return n_measured


def _nearest_of_candidates(queries, poses, candidates, batch, encode, measure, tree, steps, heaps):
    n_dofs = poses.shape[1]
    scratch = aligned(workspace_rows(tree), FLOAT64_LANES, queries.dtype)
    pose = aligned(n_dofs, FLOAT64_LANES, queries.dtype)
    code = aligned(queries.shape[1], FLOAT64_LANES, queries.dtype)
    results = results_of(1, FLOAT64_LANES, queries.dtype)
    taken = np.empty(FLOAT64_LANES, np.int64)
    rounding, n_measured, n_unconverged, worst = _rounding(tree), 0, 0, 0.0
    for i in range(batch.first, batch.last):
        c = 0  # the next candidate
        while c < candidates.counts[i]:
            n, limit = 0, _limit(heaps, i)
            while c < candidates.counts[i] and n < batch.at_once:
                if candidates.bounds[i, c] <= limit:
                    taken[n] = candidates.indices[i, c]
                    n += 1
                c += 1
            if n == 0:
                break
            results.limit[0], results.n_ruled_out[0] = 1.000001 * limit + rounding, 0
            for w in range(FLOAT64_LANES):
                results.skip[0, w], results.gap[0, w] = w >= n, 0.0
                for d in range(n_dofs):
                    pose[d, w] = poses[taken[min(w, n - 1)], d]
            encode(pose, tree, steps, scratch, code)
            measure(queries[i], code, 0, 1, tree, steps, scratch, results)
            n_measured += n * (1 - results.n_ruled_out[0])
            for w in range(n):
                _keep(results.distances[0, w], taken[w], heaps, i)
                if results.gap[0, w] > 0.0:
                    n_unconverged += 1
                    worst = max(worst, results.gap[0, w])
    return n_measured, n_unconverged, worst


def _heaps_type(real):
    """Return numba's type of Heaps."""
    whole = types.int64
    kinds = ((real, 1), (real, 2), (whole, 2), (whole, 1))
    return named(Heaps, *(array_type(kind, ndim, readonly=False) for kind, ndim in kinds))


# Compiled when first requested, see `skpose._compiled.loops`.


@functools.cache
def nearest_of_tile_loop(dtype):
    """``loop(queries, Y, span, excluded, measure, tree, steps, heaps)``: keep the nearest poses of a tile.

    `queries` holds codes as rows; Y the span's poses of the index, encoded, in groups of lanes. Query i does not keep
    pose excluded[i]. Returns the number of pairs measured. For measures that always converge.
    """
    real, whole = from_dtype(dtype), types.int64
    tree, steps = shared_types(dtype)
    queries, Y = array_type(real, 2, readonly=True), array_type(real, 2, readonly=True)
    span, excluded = named(Span, *4 * [whole]), array_type(whole, 1, readonly=True)
    signature = whole(queries, Y, span, excluded, measure_type(dtype), tree, steps, _heaps_type(real))
    return jit(_nearest_of_tile, signatures=[signature])


@functools.cache
def nearest_of_candidates_loop(dtype):
    """``loop(queries, poses, candidates, batch, encode, measure, tree, steps, heaps)``: keep the nearest candidates.

    `queries` holds codes as rows, `poses` all poses of the index, of this dtype. The Candidates of each query of the
    Batch are measured in order, but for those whose bound is above the largest distance that the query would still
    keep. Returns the number of pairs measured, the number of geodesics that did not converge and the largest of their
    gaps.
    """
    real, whole, float64 = types.float64, types.int64, np.dtype(np.float64)
    tree, steps = shared_types(float64)
    queries, poses = array_type(real, 2, readonly=True), array_type(from_dtype(dtype), 2, readonly=True)
    kinds = (whole, 2), (real, 2), (whole, 1)
    candidates = named(Candidates, *(array_type(*kind, readonly=False) for kind in kinds))
    batch = named(Batch, *3 * [whole])
    counts = types.Tuple((whole, whole, real))
    signature = counts(
        queries, poses, candidates, batch, encode_type(), measure_type(float64), tree, steps, _heaps_type(real)
    )
    return jit(_nearest_of_candidates, signatures=[signature])
