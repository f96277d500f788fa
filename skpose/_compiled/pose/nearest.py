"""The compiled loops that find, for each query, the nearest poses of an index.

What is found is kept in `Heaps`, one row for each query. Equal values are ordered by index, so what is kept depends
neither on the order in which poses come nor on the number of threads.

Poses are measured in groups of lanes, and only groups whose lower bound (`bounds_of_groups`) is within the limit of the
query.

The loops that keep pass a limit to the measure, in ``results.limit``: a distance above it is not needed. A measure that
uses the limit writes any lower bound above it instead, for a whole group of lanes at once, and adds the number of such
groups to ``results.n_ruled_out``. These poses are then not kept.
"""

from typing import Any, NamedTuple

import numpy as np

from skpose._compiled.pose.forward import size_of, workspace_rows
from skpose._compiled.pose.loops import GROUPS_IN_CACHE
from skpose._compiled.pose.measure import to_points
from skpose._compiled.pose.signatures import Loop, results_of
from skpose._compiled.simd.jit import inlined, jit
from skpose._compiled.simd.lanes import any_greater, empty_aligned, flat, least, rows

ROUNDING = 1e-9  # by which a lower bound of a length may exceed it, in sizes of the skeleton; a generous estimate
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

    @classmethod
    def of(cls, limits: np.ndarray, capacity: int, dtype: Any = np.float64) -> "Heaps":
        """Heaps without entries: for each query at most `capacity`, none beyond its limit."""
        n = len(limits)
        values, indices = np.empty((n, capacity), dtype), np.empty((n, capacity), np.int64)
        return cls(np.ascontiguousarray(limits, dtype), values, indices, np.zeros(n, np.int64))

    @property
    def current_limits(self) -> np.ndarray:
        """The largest value that each query would still keep."""
        return np.where(self.counts == self.values.shape[1], self.values[:, 0], self.limits)

    def take(self, rows: np.ndarray) -> "Heaps":
        """Return a copy of some rows."""
        return Heaps(*(part[rows] for part in self))

    def put(self, rows: np.ndarray, other: "Heaps") -> None:
        """Replace the entries of some rows by those of another of the same capacity."""
        for own, part in zip(self[1:], other[1:], strict=True):
            own[rows] = part

    def sorted_entries(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return row, index and value of all entries, by row, value and index; every row must be full."""
        order = np.lexsort((self.indices, self.values), axis=1)
        indices, values = (np.take_along_axis(part, order, axis=1).ravel() for part in (self.indices, self.values))
        return np.repeat(np.arange(len(order)), order.shape[1]), indices, values

    def entries(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return row, index and value of all entries, by row."""
        kept = np.arange(self.values.shape[1]) < self.counts[:, np.newaxis]
        return np.nonzero(kept)[0], self.indices[kept], self.values[kept]


class Groups(NamedTuple):
    """Poses in groups of lanes, and which of them to measure: those whose bound is within the query's limit.

    A bound may be of several groups, one after another, as a group is of fewer poses in float64.
    """

    codes: np.ndarray  # (n_groups * n_codes, lanes)
    indices: np.ndarray  # (n_groups * lanes,) of the poses, in the index; -1 in empty lanes
    bounds: np.ndarray  # (n_queries, n_bounds), float32


@inlined
def comes_before(value, j, other_value, other_j):
    return value < other_value or (value == other_value and j < other_j)


@inlined
def sift_down(values, indices, i, node, n, value, j):
    """Put an entry into the first n of row i, a heap except at this free node: children that come after it move up."""
    while 2 * node + 1 < n:
        child = 2 * node + 1
        if child + 1 < n and comes_before(
            values[i, child], indices[i, child], values[i, child + 1], indices[i, child + 1]
        ):
            child += 1
        if not comes_before(value, j, values[i, child], indices[i, child]):
            break
        values[i, node], indices[i, node] = values[i, child], indices[i, child]
        node = child
    values[i, node], indices[i, node] = value, j


@inlined
def make_heap(values, indices, i, n):
    """Make the first n entries of row i a heap."""
    for node in range(n // 2 - 1, -1, -1):
        sift_down(values, indices, i, node, n, values[i, node], indices[i, node])


@inlined
def current_limit(heaps, i):
    """The largest value that query i would still keep."""
    return heaps.values[i, 0] if heaps.counts[i] == heaps.values.shape[1] else heaps.limits[i]


@inlined
def keep(value, j, heaps, i):
    """Keep pose j for query i if it is near enough."""
    values, indices, counts = heaps.values, heaps.indices, heaps.counts
    capacity = values.shape[1]
    if counts[i] == capacity:
        if comes_before(value, j, values[i, 0], indices[i, 0]):
            sift_down(values, indices, i, 0, capacity, value, j)
    elif value <= heaps.limits[i]:
        values[i, counts[i]], indices[i, counts[i]] = value, j
        counts[i] += 1
        if counts[i] == capacity:
            make_heap(values, indices, i, capacity)


@inlined
def _run(bounds, i, limit, group, end, per_bound):
    """The first range of groups, from this one on and before the end, whose bounds are within the limit."""
    while group < end and bounds[i, group // per_bound] > limit:
        group += 1
    stop = group
    while stop < end and bounds[i, stop // per_bound] <= limit:
        stop += 1
    return group, stop


@inlined
def _n_together(n_codes):
    """How many groups are measured for one query after another, as they fit into the cache."""
    return max(GROUPS_IN_CACHE, ROWS_IN_CACHE // n_codes)


@jit
def bounds_of_groups(queries, points, first, last, bounds):
    """Compute the least distance (n_queries, n_groups) of queries first:last to the points of each group, in float32.

    `queries` holds points as rows, `points` groups of lanes.
    """
    n, n_groups = queries.shape[1], bounds.shape[1]
    for group in range(0, n_groups, _n_together(n)):
        for i in range(first, last):
            query = flat(queries[i])
            for k in range(group, min(group + _n_together(n), n_groups)):
                bounds[i, k] = least(to_points(query, rows(points, n * k), n))


@Loop
def nearest_of_groups(queries, groups, first, last, excluded, measure, tree, steps, heaps):
    """Keep the nearest poses of groups.

    `queries` holds codes as rows. Only Groups within reach of a query first:last are measured. Query i does not keep
    pose excluded[i]. Returns the number of pairs measured. For measures that always converge.
    """
    n_codes, width = queries.shape[1], groups.codes.shape[1]
    n_groups, n_together = len(groups.indices) // width, _n_together(n_codes)
    per_bound = n_groups // max(1, groups.bounds.shape[1])
    scratch = empty_aligned(workspace_rows(tree), width, queries.dtype)
    results = results_of(n_together, width, queries.dtype)
    distances, rounding, n_measured = rows(results.distances, 0), ROUNDING * size_of(tree), 0
    for group in range(0, n_groups, n_together):
        end = min(group + n_together, n_groups)
        for i in range(first, last):
            limit = current_limit(heaps, i)
            start, stop = _run(groups.bounds, i, limit, group, end, per_bound)
            while start < stop:
                results.limit[0], results.n_ruled_out[0] = 1.000001 * limit + rounding, 0
                measure(queries[i], groups.codes, start, stop, tree, steps, scratch, results)
                n_poses = 0
                for at in range(start * width, stop * width):
                    n_poses += groups.indices[at] >= 0
                n_measured += max(0, n_poses - results.n_ruled_out[0] * width)
                for k in range(stop - start):
                    at = (start + k) * width
                    # A little more than the limit, as a distance equal to it may be kept.
                    if limit < np.inf and not any_greater(0.0 - distances[k], -1.000001 * limit - 1e-37):
                        continue
                    for w in range(width):
                        j = groups.indices[at + w]
                        if j >= 0 and j != excluded[i]:
                            keep(results.distances[k, w], j, heaps, i)
                    limit = current_limit(heaps, i)
                start, stop = _run(groups.bounds, i, limit, stop, end, per_bound)
    return n_measured
