"""The compiled loops that find the candidates of each query, the poses with the least lower bounds, and measure them.

Bounds are distances between points. Groups of lanes of them are in boxes, each along the axes of the coordinates, and
so are groups of lanes of these boxes, the *nodes*; the distance from a query to a box is no more than that to any point
in it. A query takes the nodes in order, the nearest first, until the next one is out of reach.

Candidates are gathered into lanes one by one, from rows of poses or of codes.
"""

import functools
from typing import NamedTuple

import numpy as np
from numba import from_dtype, types

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.loops import encode_type, measure_type
from skpose._compiled.pose.nearest import (
    comes_before,
    current_limit,
    heaps_type,
    keep,
    make_heap,
    rounding_of,
    sift_down,
)
from skpose._compiled.pose.results import results_of
from skpose._compiled.pose.signatures import shared_types
from skpose._compiled.simd.jit import first_class, inlined, jit
from skpose._compiled.simd.lanes import VECTOR_BYTES, empty_aligned, flat, least, rows
from skpose._compiled.simd.signatures import array_type, tuple_type

FLOAT32, FLOAT64 = np.dtype(np.float32), np.dtype(np.float64)
# The distance to a box may exceed by rounding that to a point in it: each of some twenty squares and sums by 2⁻²⁴.
ROUNDING_OF_BOXES = 1e-5


class Boxes(NamedTuple):
    """Points in groups of lanes, and boxes around them; a box is its lower corner, then the upper one."""

    codes: np.ndarray  # (n_groups * n_codes, lanes)
    indices: np.ndarray  # (n_groups * lanes,) of the poses, in the index; -1 where there is none
    groups: np.ndarray  # (n_nodes * 2 n_codes, lanes) boxes of groups
    nodes: np.ndarray  # (n_groups_of_nodes * 2 n_codes, lanes) boxes of nodes


class Known(NamedTuple):
    """Poses that a query does not keep: itself, and those that do not come after an entry."""

    excluded: np.ndarray  # (n_queries,) index of a pose, or -1
    values: np.ndarray  # (n_queries,) of the entry, float32
    indices: np.ndarray  # (n_queries,)


class Candidates(NamedTuple):
    """Poses of an index that may be among the nearest of each query; a query's loop takes them in order."""

    indices: np.ndarray  # (n_queries, n_candidates)
    rows: np.ndarray  # (n_queries, n_candidates) where they stand in what is measured
    bounds: np.ndarray  # (n_queries, n_candidates) lower bounds of the distances
    counts: np.ndarray  # (n_queries,) number of candidates


class Batch(NamedTuple):
    """The queries first:last, and how their candidates are measured."""

    first: int
    last: int
    at_once: int  # candidates of a query, a register's lanes at most
    sort: bool  # what a query keeps by value and then by index; it is then no heap


@first_class
def copy_code(code, tree, steps, scratch, copy):
    """Encode what is a code already."""
    before, put = rows(code, 0), rows(copy, 0)
    for k in range(code.shape[0]):
        put[k] = before[k]


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


def _nearest_of_boxes(queries, boxes, first, last, known, measure, measure_boxes, tree, steps, heaps):
    n_codes, width = queries.shape[1], boxes.codes.shape[1]
    n_groups, n_nodes = len(boxes.indices) // width, boxes.groups.shape[0] // (2 * n_codes)
    n_tops = boxes.nodes.shape[0] // (2 * n_codes)
    scratch = empty_aligned(workspace_rows(tree), width, queries.dtype)
    of_nodes, of_groups = results_of(n_tops, width, queries.dtype), results_of(1, width, queries.dtype)
    of_poses = results_of(1, width, queries.dtype)
    order, numbers = empty_aligned(1, n_nodes, queries.dtype), empty_aligned(1, n_nodes, np.int64)
    distances = rows(of_poses.distances, 0)
    for i in range(first, last):
        query, limit = queries[i], current_limit(heaps, i)
        reach = (1.0 + ROUNDING_OF_BOXES) * limit
        measure_boxes(query, boxes.nodes, 0, n_tops, tree, steps, scratch, of_nodes)
        n = 0  # nodes within reach, as a heap with the nearest first: its values are negative
        for node in range(n_nodes):
            if of_nodes.distances[node // width, node % width] <= reach:
                order[0, n], numbers[0, n] = -of_nodes.distances[node // width, node % width], node
                n += 1
        make_heap(order, numbers, 0, n)
        while n > 0 and -order[0, 0] <= reach:
            node = numbers[0, 0]
            n -= 1
            sift_down(order, numbers, 0, 0, n, order[0, n], numbers[0, n])
            measure_boxes(query, boxes.groups, node, node + 1, tree, steps, scratch, of_groups)
            for group in range(node * width, min((node + 1) * width, n_groups)):
                if of_groups.distances[0, group - node * width] > reach:
                    continue
                measure(query, boxes.codes, group, group + 1, tree, steps, scratch, of_poses)
                if least(distances[0]) > limit:
                    continue
                for w in range(width):
                    value, j = of_poses.distances[0, w], boxes.indices[group * width + w]
                    is_known = j < 0 or j == known.excluded[i]
                    if value <= limit and not is_known and comes_before(known.values[i], known.indices[i], value, j):
                        keep(value, j, heaps, i)
                limit = current_limit(heaps, i)
                reach = (1.0 + ROUNDING_OF_BOXES) * limit
        _sort(heaps, i)


def _nearest_of_candidates(queries, poses, candidates, batch, encode, measure, tree, steps, heaps):
    n_dofs, width = poses.shape[1], VECTOR_BYTES // queries.itemsize
    scratch = empty_aligned(workspace_rows(tree), width, queries.dtype)
    pose = empty_aligned(n_dofs, width, queries.dtype)
    code = empty_aligned(queries.shape[1], width, queries.dtype)
    lanes_of_pose, numbers = flat(pose), flat(poses)
    results = results_of(1, width, queries.dtype)
    taken, places = np.empty(width, np.int64), np.empty(width, np.int64)
    rounding, n_measured, n_unconverged, worst = rounding_of(tree), 0, 0, 0.0
    for i in range(batch.first, batch.last):
        c = 0  # the next candidate
        while c < candidates.counts[i]:
            n, limit = 0, current_limit(heaps, i)
            while c < candidates.counts[i] and n < batch.at_once:
                if candidates.bounds[i, c] <= limit:
                    taken[n], places[n] = candidates.indices[i, c], candidates.rows[i, c]
                    n += 1
                c += 1
            if n == 0:
                break
            results.limit[0], results.n_ruled_out[0] = 1.000001 * limit + rounding, 0
            for w in range(width):
                results.skip[0, w], results.gap[0, w] = w >= n, 0.0
                row = places[min(w, n - 1)] * n_dofs
                for d in range(n_dofs):
                    lanes_of_pose[d * width + w] = numbers[row + d]
            encode(pose, tree, steps, scratch, code)
            measure(queries[i], code, 0, 1, tree, steps, scratch, results)
            n_measured += n * (1 - results.n_ruled_out[0])
            for w in range(n):
                keep(results.distances[0, w], taken[w], heaps, i)
                if results.gap[0, w] > 0.0:
                    n_unconverged += 1
                    worst = max(worst, results.gap[0, w])
        if batch.sort:
            _sort(heaps, i)
    return n_measured, n_unconverged, worst


# Compiled when first requested, see `skpose._compiled.pose.loops`.


@functools.cache
def nearest_of_boxes_loop():
    """``loop(queries, boxes, first, last, known, measure, measure_boxes, tree, steps, heaps)``: the nearest points.

    `queries` holds points as rows. What queries first:last keep of the Boxes is sorted by value, then by index. In
    float32.
    """
    real, integer = types.float32, types.int64
    tree, steps = shared_types(FLOAT32)
    queries = array_type(real, 2, readonly=True)
    boxes = tuple_type(
        Boxes, *(array_type(*kind, readonly=False) for kind in ((real, 2), (integer, 1), (real, 2), (real, 2)))
    )
    known = tuple_type(Known, *(array_type(kind, 1, readonly=False) for kind in (integer, real, integer)))
    measure = measure_type(FLOAT32)
    signature = types.void(queries, boxes, integer, integer, known, measure, measure, tree, steps, heaps_type(real))
    return jit(_nearest_of_boxes, signatures=[signature])


@functools.cache
def nearest_of_candidates_loop(poses_dtype, dtype=FLOAT64):
    """``loop(queries, poses, candidates, batch, encode, measure, tree, steps, heaps)``: keep the nearest candidates.

    `queries` holds codes as rows, of dtype, `poses` rows of what encode takes, of poses_dtype. The Candidates of each
    query of the Batch are measured in order, but for those whose bound is above the largest distance that the query
    would still keep. Returns the number of pairs measured, the number of geodesics that did not converge and the
    largest of their gaps.
    """
    real, integer, float64 = from_dtype(dtype), types.int64, types.float64
    tree, steps = shared_types(dtype)
    queries, poses = array_type(real, 2, readonly=True), array_type(from_dtype(poses_dtype), 2, readonly=True)
    kinds = (integer, 2), (integer, 2), (float64, 2), (integer, 1)
    candidates = tuple_type(Candidates, *(array_type(*kind, readonly=False) for kind in kinds))
    batch = tuple_type(Batch, integer, integer, integer, types.boolean)
    counts = types.Tuple((integer, integer, float64))
    signature = counts(
        queries, poses, candidates, batch, encode_type(dtype), measure_type(dtype), tree, steps, heaps_type(real)
    )
    return jit(_nearest_of_candidates, signatures=[signature])
