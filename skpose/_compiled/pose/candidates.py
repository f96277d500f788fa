"""The compiled loops that find the candidates of each query, the poses with the least lower bounds, and measure them.

Bounds are distances between points. Groups of lanes of them are in boxes, each along the axes of the coordinates, and
so are groups of lanes of these boxes, the *nodes*; the distance from a query to a box is no more than that to any point
in it. A query takes the nodes in order, the nearest first, until the next one is out of reach.

Candidates are gathered into lanes from rows of codes.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.pose.forward import size_of, workspace_rows
from skpose._compiled.pose.measure import to_boxes, to_points
from skpose._compiled.pose.nearest import (
    ROUNDING,
    comes_before,
    current_limit,
    keep,
    make_heap,
    sift_down,
)
from skpose._compiled.pose.signatures import Loop, add_gaps, results_of
from skpose._compiled.simd.jit import inlined, jit
from skpose._compiled.simd.lanes import VECTOR_BYTES, empty_aligned, flat, least, rows

# The distance to a box may exceed by rounding that to a point in it: each of some twenty squares and sums by 2⁻²⁴.
ROUNDING_OF_BOXES = 1e-5


class Boxes(NamedTuple):
    """Points in groups of lanes, and boxes around them; a box is its lower corner, then the upper one."""

    codes: np.ndarray  # (n_groups * n_codes, lanes)
    indices: np.ndarray  # (n_groups * lanes,) of the poses, in the index; -1 in empty lanes
    groups: np.ndarray  # (n_nodes * 2 n_codes, lanes) boxes of groups
    nodes: np.ndarray  # (n_groups_of_nodes * 2 n_codes, lanes) boxes of nodes


class Known(NamedTuple):
    """Poses that a query does not keep: itself, and poses up to an entry."""

    excluded: np.ndarray  # (n_queries,) index of a pose, or -1
    values: np.ndarray  # (n_queries,) of the entry, float32
    indices: np.ndarray  # (n_queries,)


class Candidates(NamedTuple):
    """Poses of an index that may be among the nearest of each query; a query's loop takes them in order."""

    indices: np.ndarray  # (n_queries, n_candidates)
    rows: np.ndarray  # (n_queries, n_candidates) of the poses that are measured
    bounds: np.ndarray  # (n_queries, n_candidates) lower bounds of the distances
    counts: np.ndarray  # (n_queries,) number of candidates


@inlined
def _sort(heaps, i):
    """Sort row i by value and then by index; it is then no heap."""
    values, indices, n = heaps.values, heaps.indices, heaps.counts[i]
    if n < values.shape[1]:
        make_heap(values, indices, i, n)
    for end in range(n - 1, 0, -1):
        value, j = values[i, end], indices[i, end]
        values[i, end], indices[i, end] = values[i, 0], indices[i, 0]
        sift_down(values, indices, i, 0, end, value, j)


@jit
def nearest_of_boxes(queries, boxes, first, last, known, heaps):
    """Keep the nearest points, in float32.

    `queries` holds points as rows. What queries first:last keep of the Boxes is sorted by value, then by index.
    """
    n, width = queries.shape[1], boxes.codes.shape[1]
    n_groups, n_nodes, n_tops = (
        len(boxes.indices) // width,
        boxes.groups.shape[0] // (2 * n),
        boxes.nodes.shape[0] // (2 * n),
    )
    # Bounds of nodes, of the groups in one of them, and of the poses in one of these; then the nodes within reach, the
    # nearest first: a heap of negative bounds.
    of_nodes = empty_aligned(n_tops, width, queries.dtype)
    of_groups, of_poses = empty_aligned(1, width, queries.dtype), empty_aligned(1, width, queries.dtype)
    order, nodes = empty_aligned(1, n_nodes, queries.dtype), empty_aligned(1, n_nodes, np.int64)
    indices = flat(boxes.indices)
    for i in range(first, last):
        query, limit = flat(queries[i]), current_limit(heaps, i)
        reach = (1.0 + ROUNDING_OF_BOXES) * limit
        for top in range(n_tops):
            low, high = rows(boxes.nodes, 2 * n * top), rows(boxes.nodes, 2 * n * top + n)
            rows(of_nodes, top)[0] = to_boxes(query, low, high, n)
        n_left = 0
        for node in range(n_nodes):
            bound = flat(of_nodes)[node]
            if bound <= reach:
                order[0, n_left], nodes[0, n_left] = -bound, node
                n_left += 1
        make_heap(order, nodes, 0, n_left)
        while n_left > 0 and -order[0, 0] <= reach:
            node, n_left = nodes[0, 0], n_left - 1
            sift_down(order, nodes, 0, 0, n_left, order[0, n_left], nodes[0, n_left])
            low, high = rows(boxes.groups, 2 * n * node), rows(boxes.groups, 2 * n * node + n)
            rows(of_groups, 0)[0] = to_boxes(query, low, high, n)
            for group in range(node * width, min((node + 1) * width, n_groups)):
                if flat(of_groups)[group - node * width] > reach:
                    continue
                bounds = to_points(query, rows(boxes.codes, n * group), n)
                if least(bounds) > limit:
                    continue
                rows(of_poses, 0)[0] = bounds
                for w in range(width):
                    value, j = flat(of_poses)[w], indices[group * width + w]
                    is_known = j < 0 or j == known.excluded[i]
                    if value <= limit and not is_known and comes_before(known.values[i], known.indices[i], value, j):
                        keep(value, j, heaps, i)
                limit = current_limit(heaps, i)
                reach = (1.0 + ROUNDING_OF_BOXES) * limit
        _sort(heaps, i)


@Loop
def nearest_of_candidates(queries, codes, candidates, first, last, at_once, measure, tree, steps, heaps):
    """Keep the nearest candidates.

    `queries` and `codes` hold codes as rows. The Candidates of the queries first:last are measured in order, some at
    once, except those whose bound is above the largest distance that the query would still keep. Returns the numbers of
    pairs measured and of geodesics that did not converge, and the largest of their gaps.
    """
    n_codes, width = codes.shape[1], VECTOR_BYTES // queries.itemsize
    scratch = empty_aligned(workspace_rows(tree), width, queries.dtype)
    code = empty_aligned(n_codes, width, queries.dtype)
    lanes_of_code, numbers = flat(code), flat(codes)
    results = results_of(1, width, queries.dtype)
    taken, taken_rows = np.empty(width, np.int64), np.empty(width, np.int64)
    rounding, n_measured, n_unconverged, worst = ROUNDING * size_of(tree), 0, 0, 0.0
    for i in range(first, last):
        c = 0  # the next candidate
        while c < candidates.counts[i]:
            n, limit = 0, current_limit(heaps, i)
            while c < candidates.counts[i] and n < at_once:
                if candidates.bounds[i, c] <= limit:
                    taken[n], taken_rows[n] = candidates.indices[i, c], candidates.rows[i, c]
                    n += 1
                c += 1
            if n == 0:
                break
            results.limit[0], results.n_ruled_out[0] = 1.000001 * limit + rounding, 0
            for w in range(width):
                results.skip[0, w] = w >= n
                row = taken_rows[min(w, n - 1)] * n_codes
                for k in range(n_codes):
                    lanes_of_code[k * width + w] = numbers[row + k]
            measure(queries[i], code, 0, 1, tree, steps, scratch, results)
            n_measured += n * (1 - results.n_ruled_out[0])
            for w in range(n):
                keep(results.distances[0, w], taken[w], heaps, i)
            n_unconverged, worst = add_gaps(results, 1, n_unconverged, worst)
    return n_measured, n_unconverged, worst
