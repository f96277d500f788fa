"""The loops over poses and over pairs; the metric comes in as two functions, encode and measure."""

from typing import NamedTuple

import numpy as np

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.signatures import Loop, add_gaps, results_of, skip_outside
from skpose._compiled.simd.lanes import empty_aligned, lanes

GROUPS_IN_CACHE = 16  # groups of lanes that are used on one row after the other
FLOAT64_LANES = lanes(np.dtype(np.float64))


class PairRange(NamedTuple):
    """A part of all pairs: rows first:last of X with the groups of lanes first_group:last_group of Y."""

    first: int
    last: int
    first_group: int
    last_group: int
    triangle: bool  # X and Y are the same poses: only columns from the diagonal's group on are written


@Loop
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


@Loop
def pair_distances(X, Y, pairs, measure, tree, steps, distances):
    """Compute the distances of a PairRange.

    X holds codes as rows, Y groups of n_codes rows of lanes, one after another. Returns how many geodesics did not
    converge, and the largest of their gaps.
    """
    width = Y.shape[1]
    scratch = empty_aligned(workspace_rows(tree), width, X.dtype)
    results = results_of(GROUPS_IN_CACHE, width, X.dtype)
    n_unconverged, worst = 0, 0.0
    for group in range(pairs.first_group, pairs.last_group, GROUPS_IN_CACHE):
        end = min(group + GROUPS_IN_CACHE, pairs.last_group)
        stop = min(end * width, distances.shape[1])
        for i in range(pairs.first, min(pairs.last, end * width) if pairs.triangle else pairs.last):
            start = max(group, i // width) if pairs.triangle else group
            skip_outside(results, start, end, i + 1 if pairs.triangle else 0, stop)
            measure(X[i], Y, start, end, tree, steps, scratch, results)
            for k in range(end - start):
                for w in range(min(width, stop - (start + k) * width)):
                    distances[i, (start + k) * width + w] = results.distances[k, w]
            n_unconverged, worst = add_gaps(results, end - start, n_unconverged, worst)
    return n_unconverged, worst


def encode_poses(poses, encode, tree, steps, codes):
    """Write the codes (n_poses, n_codes) of poses (n_poses, n_dofs), in float64."""
    _encode_poses(np.ascontiguousarray(poses, dtype=np.float64), encode, tree, steps, codes)


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
