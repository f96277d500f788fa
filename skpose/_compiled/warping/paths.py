"""Dynamic time warping: the least sum of distances along a monotone path from frame to frame of two motions.

A path goes through pairs of frames (i, j), the *cells*, by steps (1, 0), (0, 1) and (1, 1), each of weight one. With
c(i, j) the distance of a cell, the least sum of all paths to it is S(i, j) = c(i, j) + min(S(i − 1, j), S(i, j − 1),
S(i − 1, j − 1)) (H. Sakoe, S. Chiba, 1978, doi:10.1109/TASSP.1978.1163055). A *closed* path goes from the first cell
to the last one. An *open* one takes all rows and begins and ends at any column: the one motion inside the other.

`warp_pairs` has no matrix of distances. The columns are the frames of many motions, one after another in groups of
lanes, so that no lane is left empty between two of them. A block of groups that fits into the cache is taken for one
row after the other: distances by the measure, then the sums, of which only those of the row above and those of the last
column of the block before are kept.

The band
--------
With a window w, a path stays where the times of its cells, as shares of the durations, are no more than w apart:
|i/(n − 1) − j/(m − 1)| ≤ w. So that there is a path for every w, half a frame of the shorter motion is always allowed.
The comparison is one of integers, |i (m − 1) − j (n − 1)| ≤ reach, so that it is the same from both sides.
"""

import math
from typing import NamedTuple

import numpy as np

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.loops import GROUPS_IN_CACHE
from skpose._compiled.pose.signatures import Loop, add_gaps, results_of, skip_outside
from skpose._compiled.simd.jit import inlined, jit
from skpose._compiled.simd.lanes import empty_aligned


class Encoded(NamedTuple):
    """Codes of the frames of motions, one motion after another."""

    codes: np.ndarray  # of all frames: as rows, or as groups of n_codes rows of lanes
    starts: np.ndarray  # (n_motions + 1,) the frames of motion i are starts[i]:starts[i + 1]


class MotionPairs(NamedTuple):
    """A part of all pairs of motions: rows first:last with columns left:right."""

    first: int
    last: int
    left: int
    right: int
    triangle: bool  # rows and columns are the same motions: only columns behind the row's are computed


class Paths(NamedTuple):
    """The paths that are allowed."""

    window: float  # largest distance of two relative times; 1 or more: all
    is_open: bool

    @classmethod
    def of(cls, window: float | None, is_open: bool = False) -> "Paths":
        """The paths of a window, None for all."""
        return cls(1.0 if window is None else float(window), is_open)


@inlined
def reach_of(n, m, window):
    """The reach of the band of n rows and m columns."""
    half_a_frame = (max(n, m) - 1) // 2
    # A share such as 0.7 of 9 × 10 is 62.99999999999999, and 63 is meant.
    return max(half_a_frame, math.floor(min(window, 1.0) * (1.0 + 1e-14) * ((n - 1) * (m - 1))))


@inlined
def band(i, n, m, reach):
    """The first column of row i in the band, and the end."""
    if n == 1 or m == 1:
        return 0, m
    return max(0, -((reach - i * (m - 1)) // (n - 1))), min(m, (i * (m - 1) + reach) // (n - 1) + 1)


@inlined
def _warp_row(costs, first_cost, above, start, stop, diagonal, left):
    """Replace the sums of the row above by those of this row, in the slots start:stop.

    The distance of the first cell stands at costs[first_cost]; `diagonal` and `left` are the sums of its neighbours.
    """
    for k in range(stop - start):
        up = above[start + k]
        left = costs[first_cost + k] + min(min(up, diagonal), left)
        above[start + k] = left
        diagonal = up


@Loop
def warp_pairs(x, y, pairs, paths, measure, tree, steps, sums):
    """Compute the least sums of some MotionPairs.

    Both x and y are Encoded: the motions of the rows, whose codes are rows, and those of the columns, whose codes are
    groups of lanes. Returns how many geodesics did not converge, and the largest of their gaps. A closed path may have
    a window, an open one none.
    """
    X, x_starts, Y, y_starts = x.codes, x.starts, y.codes, y.starts
    width, in_band = Y.shape[1], paths.window < 1.0
    block = GROUPS_IN_CACHE * width
    scratch = empty_aligned(workspace_rows(tree), width, X.dtype)
    results = results_of(GROUPS_IN_CACHE, width, X.dtype)
    costs = results.distances.reshape(-1)
    above = np.empty(block + 1)  # sums of a row: in slot 0 of the column before the block, then of its columns
    edge = np.empty(np.diff(x_starts).max())  # of each row, the sum in the last column of the block before
    n_unconverged, worst = 0, 0.0
    for r in range(pairs.first, pairs.last):
        n, left = x_starts[r + 1] - x_starts[r], max(pairs.left, r + 1) if pairs.triangle else pairs.left
        if left >= pairs.right:
            break
        c_first, begin, end = left, y_starts[left], y_starts[pairs.right]
        sums[r, left : pairs.right] = np.inf
        for block_start in range(begin // width * width, end, block):
            start, stop = max(begin, block_start), min(end, block_start + block)
            while y_starts[c_first + 1] <= start:
                c_first += 1
            group, last_group = block_start // width, (stop + width - 1) // width
            skip_outside(results, group, last_group, start, stop)
            above[:] = 0.0 if paths.is_open else np.inf
            above[0] = np.inf
            for i in range(n):
                frame = X[x_starts[r] + i]
                if not in_band:
                    measure(frame, Y, group, last_group, tree, steps, scratch, results)
                    n_unconverged, worst = add_gaps(results, last_group - group, n_unconverged, worst)
                c = c_first
                while c < pairs.right and y_starts[c] < stop:
                    origin, m = y_starts[c], y_starts[c + 1] - y_starts[c]
                    s, e = max(origin, start), min(origin + m, stop)
                    first_cost, below = s - block_start, s
                    if in_band:
                        reach = reach_of(n, m, paths.window)
                        low, high = band(i, n, m, reach)
                        below = max(s, origin + band(max(i - 1, 0), n, m, reach)[0])
                        s, e = min(max(s, origin + low), e), min(e, origin + high)
                        first_cost = s % width
                        if s < e:
                            some, last = s // width, (e + width - 1) // width
                            skip_outside(results, some, last, s, e)
                            measure(frame, Y, some, last, tree, steps, scratch, results)
                            n_unconverged, worst = add_gaps(results, last - some, n_unconverged, worst)
                    slot = s - block_start + 1
                    if s == origin:
                        before, diagonal = np.inf, 0.0 if i == 0 else np.inf
                    else:
                        before, diagonal = edge[i] if s == block_start else np.inf, above[slot - 1]
                    if in_band:
                        above[below - block_start + 1 : slot] = np.inf  # the band has left these columns
                    _warp_row(costs, first_cost, above, slot, max(slot, e - block_start + 1), diagonal, before)
                    if i == n - 1 and paths.is_open:
                        sums[r, c] = min(sums[r, c], above[slot : e - block_start + 1].min())
                    elif i == n - 1 and origin + m <= stop:
                        sums[r, c] = above[origin + m - block_start]
                    c += 1
                above[0], edge[i] = edge[i], above[stop - block_start]
    return n_unconverged, worst


@jit
def accumulate_from(costs, paths, edge):
    """Replace distances by sums as `accumulate`, with the sums (n,) of the column before the first one.

    Only open paths have one; a closed one begins in the first cell.
    """
    n, m = costs.shape
    reach = reach_of(n, m, paths.window)
    for i in range(n):
        low, high = band(i, n, m, reach)
        costs[i, :low] = np.inf
        costs[i, high:] = np.inf
        left, diagonal = np.inf, np.inf
        if low == 0:
            left, diagonal = edge[i], edge[i - 1] if i > 0 else np.inf
        elif i > 0:
            diagonal = costs[i - 1, low - 1]
        for j in range(low, high):
            up = costs[i - 1, j] if i > 0 else np.inf
            if i == 0 and (paths.is_open or j == 0):
                up = 0.0
            left = costs[i, j] + min(min(up, diagonal), left)
            costs[i, j] = left
            diagonal = up if i > 0 else np.inf


@jit
def accumulate(costs, paths):
    """Replace distances (n, m) by the least sums of the paths to each cell, in place."""
    accumulate_from(costs, paths, np.full(costs.shape[0], np.inf))


@jit
def path_to(sums, is_open, column):
    """The cells (i, j) of the path to a column of the last row, from the first cell on.

    Of equal sums before a cell, the diagonal one is taken, then the one above.
    """
    n, m = sums.shape
    path = np.empty((n + m, 2), np.int64)
    i, j, first = n - 1, column, n + m - 1
    path[first, 0], path[first, 1] = i, j
    while i > 0 or (j > 0 and not is_open):
        up = sums[i - 1, j] if i > 0 else np.inf
        left = sums[i, j - 1] if j > 0 else np.inf
        diagonal = sums[i - 1, j - 1] if i > 0 and j > 0 else np.inf
        if i > 0 and j > 0 and diagonal <= up and diagonal <= left:
            i, j = i - 1, j - 1
        elif i > 0 and (up <= left or j == 0):
            i -= 1
        else:
            j -= 1
        first -= 1
        path[first, 0], path[first, 1] = i, j
    return path[first:]
