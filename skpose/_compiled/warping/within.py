"""Dynamic time warping up to a limit: only the cells that a path within the limit can go through are measured.

A cell (i, j) has a lower bound of what is left: the least sum, under a lower bound of the distance, of the paths from
it to the end, itself included. A path whose sum so far, added to that, is above the limit cannot end within the limit.
Cells that no other path reaches are left out, and the groups of lanes in which all are left out are not measured. A sum
that is within the limit is, to the last bit, the one that `skpose._compiled.warping.paths` finds.
"""

from typing import NamedTuple

import numpy as np

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.signatures import Loop, add_gaps, results_of
from skpose._compiled.simd.lanes import empty_aligned
from skpose._compiled.warping.paths import band, reach_of


class Within(NamedTuple):
    """The largest sum that is of interest, and lower bounds of what is left of a path."""

    limit: float
    left_over: np.ndarray  # (n, n_columns) from each cell, itself included, to the end; (0, 0) for no bounds


class Ends(NamedTuple):
    """The paths that end in the last row, by their last column."""

    sums: np.ndarray  # (n_columns,) the least sum; infinity where it is above the limit
    starts: np.ndarray  # (n_columns,) the column at which that path begins


@Loop
def warp_within(X, Y, paths, within, measure, tree, steps, ends):
    """Find the Ends of the paths of one pair within a limit.

    X holds the codes of the rows, Y those of the columns in groups of lanes. Returns the numbers of cells measured and
    of geodesics that did not converge, and the largest of their gaps.
    """
    limit, left_over, sums, starts = within.limit, within.left_over, ends.sums, ends.starts
    n, n_columns, width, n_codes = X.shape[0], sums.shape[0], Y.shape[1], X.shape[1]
    n_groups, reach = Y.shape[0] // n_codes, reach_of(n, n_columns, paths.window)
    scratch = empty_aligned(workspace_rows(tree), width, X.dtype)
    results = results_of(1, width, X.dtype)
    above, origins = np.full(n_groups * width, np.inf), np.zeros(n_groups * width, np.int64)
    first, stop = 0, n_columns if paths.is_open else 0  # reached cells of the row above, the last one not included
    n_measured, n_unconverged, worst = 0, 0, 0.0
    for i in range(n):
        low, high = band(i, n, n_columns, reach)
        group = max(first, low) // width
        diagonal, diagonal_start = np.inf, 0
        if group > 0:
            diagonal, diagonal_start = above[group * width - 1], origins[group * width - 1]
        above[first : group * width] = np.inf  # the band has left these columns
        left, left_start = np.inf, 0
        new_first, new_stop = n_columns, 0
        while group < n_groups and group * width < high and (group * width <= stop or left < np.inf):
            n_requested, entry = 0, min(left, diagonal)
            for w in range(width):
                j = group * width + w
                entry = 0.0 if i == 0 and (paths.is_open or j == 0) else min(entry, above[j])  # the sum is no less
                requested = low <= j < high and entry < np.inf
                if requested and left_over.shape[0] > 0:
                    requested = entry + left_over[i, j] <= limit
                results.skip[0, w] = not requested
                n_requested += requested
            if n_requested > 0:
                measure(X[i], Y, group, group + 1, tree, steps, scratch, results)
                n_unconverged, worst = add_gaps(results, 1, n_unconverged, worst)
                n_measured += min(width, n_columns - group * width)
            for w in range(width):
                j = group * width + w
                up, up_start = above[j], origins[j]
                value, start = np.inf, j
                if not results.skip[0, w]:
                    if i == 0 and (paths.is_open or j == 0):
                        entry = 0.0
                    elif diagonal <= up and diagonal <= left:
                        entry, start = diagonal, diagonal_start
                    elif up <= left:
                        entry, start = up, up_start
                    else:
                        entry, start = left, left_start
                    value = results.distances[0, w] + entry
                    if left_over.shape[0] > 0 and entry + left_over[i, j] > limit:
                        value = np.inf
                    if value > limit:
                        value = np.inf
                    if value < np.inf:
                        new_first, new_stop = min(new_first, j), j + 1
                above[j], origins[j] = value, start
                left, left_start, diagonal, diagonal_start = value, start, up, up_start
            group += 1
        first, stop = new_first, new_stop
        if stop == 0:
            break
    for j in range(n_columns):
        sums[j], starts[j] = above[j], origins[j]
    return n_measured, n_unconverged, worst
