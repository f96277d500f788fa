"""The output of a measure, which the loops over pairs read: named arrays."""

from typing import NamedTuple

import numpy as np

from skpose._compiled.simd.jit import inlined
from skpose._compiled.simd.lanes import any_greater, empty_aligned, rows


class Results(NamedTuple):
    """Distances from one encoded pose to groups of lanes of others, and what goes with them.

    Of one pose to one other, in scalars, the arrays have one axis of length one.
    """

    distances: np.ndarray  # (n_groups, lanes)
    skip: np.ndarray  # (n_groups, lanes) bool: not requested; a measure may compute them
    gap: np.ndarray  # (n_groups, lanes) discretisation error of an unconverged geodesic; zero elsewhere
    limit: np.ndarray  # (1,) of a distance above it only a lower bound above it is needed
    n_ruled_out: np.ndarray  # (1,) how many groups the limit has ruled out


@inlined
def results_of(n_groups, width, dtype):
    """Results of so many groups: none skipped, no gaps, no limit."""
    distances, gap = empty_aligned(n_groups, width, dtype), empty_aligned(n_groups, width, dtype)
    skip = empty_aligned(n_groups, width, np.bool_)
    # np.empty, np.zeros and slices are more functions to compile.
    limit, n_ruled_out = empty_aligned(1, 1, dtype)[0], empty_aligned(1, 1, np.int64)[0]
    limit[0], n_ruled_out[0] = np.inf, 0
    for k in range(n_groups):
        for w in range(width):
            gap[k, w], skip[k, w] = 0.0, False
    return Results(distances, skip, gap, limit, n_ruled_out)


@inlined
def skip_outside(results, group, end, start, stop):
    """Request the frames start:stop, and no others, of the groups group:end."""
    width = results.skip.shape[1]
    for k in range(group, end):
        if k == group or k == end - 1:
            for w in range(width):
                results.skip[k - group, w] = not start <= k * width + w < stop
        else:
            for w in range(width):
                results.skip[k - group, w] = False


@inlined
def add_gaps(results, n_groups, count, worst):
    """Add the requested geodesics of the groups that did not converge; clear their gaps."""
    gaps = rows(results.gap, 0)
    for k in range(n_groups):
        if any_greater(gaps[k], 0.0):
            for w in range(results.gap.shape[1]):
                if results.gap[k, w] > 0.0 and not results.skip[k, w]:
                    count += 1
                    worst = max(worst, results.gap[k, w])
                results.gap[k, w] = 0.0
    return count, worst
