"""The output of a measure, which the loops over pairs read: named arrays."""

from typing import NamedTuple

import numpy as np

from skpose._compiled.simd.jit import inlined
from skpose._compiled.simd.lanes import empty_aligned


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
