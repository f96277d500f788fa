"""The loops over poses and over pairs; the metric comes in as two functions, encode and measure."""

import functools
from typing import NamedTuple

import numpy as np
from numba import from_dtype, types

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.results import Results, results_of
from skpose._compiled.pose.signatures import shared_types
from skpose._compiled.simd.jit import jit
from skpose._compiled.simd.lanes import any_greater, empty_aligned, lanes, rows
from skpose._compiled.simd.signatures import array_type, tuple_type

GROUPS_IN_CACHE = 16  # groups of lanes that are used on one row after the other
FLOAT64 = np.dtype(np.float64)
FLOAT64_LANES = lanes(FLOAT64)


class PairRange(NamedTuple):
    """A part of all pairs: rows first:last of X with the groups of lanes first_group:last_group of Y."""

    first: int
    last: int
    first_group: int
    last_group: int
    triangle: bool  # X and Y are the same poses: only columns from the diagonal's group on are written


def _encode_poses(poses, encode, tree, steps, codes):
    n_poses, n_dofs = poses.shape
    scratch = empty_aligned(workspace_rows(tree), FLOAT64_LANES, poses.dtype)
    pose = empty_aligned(n_dofs, FLOAT64_LANES, poses.dtype)
    code = empty_aligned(codes.shape[1], FLOAT64_LANES, poses.dtype)
    for start in range(0, n_poses, FLOAT64_LANES):
        for w in range(FLOAT64_LANES):
            i = min(start + w, n_poses - 1)
            for d in range(n_dofs):
                pose[d, w] = poses[i, d]
        encode(pose, tree, steps, scratch, code)
        for w in range(min(FLOAT64_LANES, n_poses - start)):
            for k in range(codes.shape[1]):
                codes[start + w, k] = code[k, w]


def _pair_distances(X, Y, pairs, measure, tree, steps, distances):
    width = Y.shape[1]
    scratch = empty_aligned(workspace_rows(tree), width, X.dtype)
    results = results_of(GROUPS_IN_CACHE, width, X.dtype)
    gaps = rows(results.gap, 0)
    n_unconverged, worst = 0, 0.0
    for group in range(pairs.first_group, pairs.last_group, GROUPS_IN_CACHE):
        end = min(group + GROUPS_IN_CACHE, pairs.last_group)
        for i in range(pairs.first, min(pairs.last, end * width) if pairs.triangle else pairs.last):
            start = max(group, i // width) if pairs.triangle else group
            first_requested = i + 1 - start * width if pairs.triangle else 0
            n_columns = min(end * width, distances.shape[1]) - start * width
            for k in range(end - start):
                gaps[k] = 0.0
                if k * width < first_requested or n_columns < (k + 1) * width:
                    for w in range(width):
                        results.skip[k, w] = not first_requested <= k * width + w < n_columns
            measure(X[i], Y, start, end, tree, steps, scratch, results)
            for k in range(end - start):
                for w in range(min(width, n_columns - k * width)):
                    distances[i, (start + k) * width + w] = results.distances[k, w]
                if k * width < first_requested or n_columns < (k + 1) * width:
                    for w in range(width):
                        results.skip[k, w] = False  # for the next row, which may request all
                if any_greater(gaps[k], 0.0):
                    for w in range(width):
                        if results.gap[k, w] > 0.0:
                            n_unconverged += 1
                            worst = max(worst, results.gap[k, w])
    return n_unconverged, worst


def results_type(dtype):
    """Numba's type of Results."""
    real = from_dtype(dtype)
    kinds = (real, 2), (types.boolean, 2), (real, 2), (real, 1), (types.int64, 1)
    return tuple_type(Results, *(array_type(*kind, readonly=False) for kind in kinds))


def encode_type(dtype=FLOAT64):
    """Numba's type of a function that encodes lanes."""
    tree, steps = shared_types(dtype)
    rows_of_lanes = array_type(from_dtype(dtype), 2, readonly=False)
    return types.FunctionType(types.void(rows_of_lanes, tree, steps, rows_of_lanes, rows_of_lanes))


def measure_type(dtype):
    """Numba's type of a measure on lanes."""
    real = from_dtype(dtype)
    tree, steps = shared_types(dtype)
    x, Y = array_type(real, 1, readonly=True), array_type(real, 2, readonly=True)
    scratch = array_type(real, 2, readonly=False)
    return types.FunctionType(types.void(x, Y, types.intp, types.intp, tree, steps, scratch, results_type(dtype)))


# A function passed to a compiled function keeps it from numba's disk cache unless its type is spelled out, and what is
# spelled out is compiled at once; so the loops below are compiled at their first use.


@functools.cache
def _encode_poses_loop():
    tree, steps = shared_types(np.dtype(np.float64))
    poses, codes = (array_type(types.float64, 2, readonly=readonly) for readonly in (True, False))
    return jit(_encode_poses, signatures=[types.void(poses, encode_type(), tree, steps, codes)])


def encode_poses(poses, encode, tree, steps, codes):
    """Write the codes (n_poses, n_codes) of poses (n_poses, n_dofs), in float64."""
    _encode_poses_loop()(np.ascontiguousarray(poses, dtype=np.float64), encode, tree, steps, codes)


@functools.cache
def pair_distances_loop(dtype):
    """``loop(X, Y, pairs, measure, tree, steps, distances)``: the distances of a PairRange.

    X holds codes as rows, Y groups of n_codes rows of lanes, one after another. Returns how many geodesics did not
    converge, and the largest of their gaps.
    """
    real, at = from_dtype(dtype), types.int64
    tree, steps = shared_types(dtype)
    X, Y = array_type(real, 2, readonly=True), array_type(real, 2, readonly=True)
    pairs = tuple_type(PairRange, at, at, at, at, types.boolean)
    distances = array_type(real, 2, readonly=False, layout="A")
    unconverged = types.Tuple((types.int64, types.float64))
    signature = unconverged(X, Y, pairs, measure_type(dtype), tree, steps, distances)
    return jit(_pair_distances, signatures=[signature])


def in_lanes(codes):
    """Codes (n, n_codes) as groups of n_codes rows of lanes, the last group filled up with copies."""
    width = lanes(codes.dtype)
    n_groups, n_codes = -(-len(codes) // width), codes.shape[1]
    rows_of_lanes = empty_aligned(n_groups * n_codes, width, codes.dtype)
    groups = rows_of_lanes.reshape(n_groups, n_codes, width)
    n_full = len(codes) // width
    groups[:n_full] = codes[: n_full * width].reshape(n_full, width, n_codes).transpose(0, 2, 1)
    if n_full < n_groups:
        groups[-1] = codes[np.minimum(np.arange(n_full * width, n_groups * width), len(codes) - 1)].T
    return rows_of_lanes
