"""Dynamic time warping of a stream: open paths of many motions, with one column kept, the one of the last frame.

The *templates* are rows, one template after another, and the frames of the stream columns. The sums of a column need
those of the column before and nothing else, so that memory does not grow with the stream. They are, cell by cell, those
of an open path of `skpose._compiled.warping.paths`, and begin where `within` says.

The windows of a template
-------------------------
Each frame ends one window of each template, [start, stop) with the sum of its path. By the rule of
`skpose.motions._windows` the best window is a match, and rules out those that overlap it by more than half of the
shorter one, then the best of the others, and so on. Which windows are matches is known before the stream ends:

- A window that comes later continues one of the paths of the last column, or begins later and overlaps nothing. Its sum
  is no less than that path's sum now, and it is no shorter than that path with the next frame.
- So a window is a match for good where no better undecided window overlaps it, and no path of a smaller sum could. It
  rules out those that overlap it for good.
- Of two matches, c before d, the later one rules out what the earlier one would. A window to come that contains d
  overlaps it. Another one begins inside d, x frames before the end of c, where 2 x is less than the frames of d, as c
  and d overlap by no more than half; so it is longer than 2 x, and overlaps c by no more than half.

So the windows that are undecided are kept, and the last match.
"""

import functools
from typing import NamedTuple

import numpy as np
from numba import from_dtype, types

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.loops import GROUPS_IN_CACHE, measure_type
from skpose._compiled.pose.results import results_of
from skpose._compiled.pose.signatures import shared_types
from skpose._compiled.simd.jit import inlined, jit
from skpose._compiled.simd.lanes import empty_aligned
from skpose._compiled.simd.signatures import array_type, tuple_type
from skpose._compiled.warping.paths import add_gaps, skip_outside

TEMPO = 2  # times as slow, or as fast, as the template: what is going on


class Column(NamedTuple):
    """The paths that end at the last frame, by their last row."""

    sums: np.ndarray  # (n_rows,) the least sum
    starts: np.ndarray  # (n_rows,) the frame at which that path begins


class Windows(NamedTuple):
    """Windows of one template; there may be room for more than there are."""

    sums: np.ndarray
    starts: np.ndarray
    stops: np.ndarray


def _advance(code, Y, row_starts, frame, measure, tree, steps, column):
    sums, starts = column.sums, column.starts
    n_rows, width, n_codes = sums.shape[0], Y.shape[1], code.shape[0]
    n_groups = Y.shape[0] // n_codes
    scratch = empty_aligned(workspace_rows(tree), width, code.dtype)
    results = results_of(GROUPS_IN_CACHE, width, code.dtype)
    costs = np.empty(n_groups * width)
    n_unconverged, worst = 0, 0.0
    for group in range(0, n_groups, GROUPS_IN_CACHE):
        end = min(group + GROUPS_IN_CACHE, n_groups)
        skip_outside(results, group, end, 0, n_rows)
        measure(code, Y, group, end, tree, steps, scratch, results)
        n_unconverged, worst = add_gaps(results, end - group, n_unconverged, worst)
        for k in range(end - group):
            for w in range(width):
                costs[(group + k) * width + w] = results.distances[k, w]
    for template in range(row_starts.shape[0] - 1):
        up, up_start, diagonal, diagonal_start = 0.0, frame, np.inf, frame
        for i in range(row_starts[template], row_starts[template + 1]):
            left, left_start = sums[i], starts[i]
            if i == row_starts[template]:
                entry, start = 0.0, frame
            elif diagonal <= up and diagonal <= left:
                entry, start = diagonal, diagonal_start
            elif up <= left:
                entry, start = up, up_start
            else:
                entry, start = left, left_start
            sums[i], starts[i] = costs[i] + entry, start
            up, up_start, diagonal, diagonal_start = sums[i], start, left, left_start
    return n_unconverged, worst


@functools.cache
def advance_loop(dtype):
    """``loop(code, Y, row_starts, frame, measure, tree, steps, column)``: replace a Column by that of the next frame.

    Y holds the codes of the templates in groups of lanes; the rows of template i are row_starts[i]:row_starts[i + 1].
    Before the first frame all sums are infinite. Returns how many geodesics did not converge, and the largest of their
    gaps.
    """
    real, integer = from_dtype(dtype), types.int64
    tree, steps = shared_types(dtype)
    code, Y = array_type(real, 1, readonly=True), array_type(real, 2, readonly=True)
    row_starts = array_type(integer, 1, readonly=True)
    column = tuple_type(Column, array_type(types.float64, 1, readonly=False), array_type(integer, 1, readonly=False))
    unconverged = types.Tuple((integer, types.float64))
    signature = unconverged(code, Y, row_starts, integer, measure_type(dtype), tree, steps, column)
    return jit(_advance, signatures=[signature])


@inlined
def _overlap(start, stop, other_start, other_stop):
    """Return whether more than half of the shorter of two windows lies in the other one."""
    common = min(stop, other_stop) - max(start, other_start)
    return 2 * common > min(stop - start, other_stop - other_start)


@jit
def best_prefixes(column, row_starts, limits, last, frame, ratios, prefixes):
    """Write, for each template, the least ratio of a sum and its limit, and how many rows that prefix has.

    A row whose limit is zero does not count, nor does a path that is more than twice as long as the prefix, or less
    than half, or that overlaps the `last` match of its template, an array (n_templates, 2) of starts and stops: it is
    what is left of that match.
    """
    for template in range(row_starts.shape[0] - 1):
        first = row_starts[template]
        ratios[template], prefixes[template] = np.inf, 0
        for i in range(first, row_starts[template + 1]):
            if limits[i] > 0.0 and column.sums[i] < ratios[template] * limits[i]:
                n, start, stop = i + 1 - first, column.starts[i], frame + 1
                is_in_tempo = n <= TEMPO * (stop - start) and stop - start <= TEMPO * n
                if is_in_tempo and not _overlap(start, stop, last[template, 0], last[template, 1]):
                    ratios[template], prefixes[template] = column.sums[i] / limits[i], n


@jit
def insert_window(pending, n_pending, total, start, stop, last_start, last_stop):
    """Insert a window among the undecided ones, in order of sum and stop, unless the last match rules it out.

    Return how many there are then.
    """
    if _overlap(start, stop, last_start, last_stop):
        return n_pending
    k = n_pending
    while k > 0 and pending.sums[k - 1] > total:
        pending.sums[k] = pending.sums[k - 1]
        pending.starts[k], pending.stops[k] = pending.starts[k - 1], pending.stops[k - 1]
        k -= 1
    pending.sums[k], pending.starts[k], pending.stops[k] = total, start, stop
    return n_pending + 1


@jit
def decide(pending, n_pending, matches, column, first, end, frame):
    """Move the matches for good of a template, whose rows are first:end, and remove the windows that they rule out.

    Return how many are undecided, and how many matches there are.
    """
    n_left, n_matches = 0, 0
    for k in range(n_pending):
        total, start, stop = pending.sums[k], pending.starts[k], pending.stops[k]
        ruled_out, undecided = False, False
        for other in range(n_matches):
            ruled_out = ruled_out or _overlap(start, stop, matches.starts[other], matches.stops[other])
        if ruled_out:
            continue
        for other in range(n_left):
            if _overlap(start, stop, pending.starts[other], pending.stops[other]):
                undecided = True
                break
        if not undecided:
            for i in range(first, end):
                if column.sums[i] < total and _overlap(start, stop, column.starts[i], frame + 2):
                    undecided = True
                    break
        if undecided:
            pending.sums[n_left], pending.starts[n_left], pending.stops[n_left] = total, start, stop
            n_left += 1
        else:
            matches.sums[n_matches], matches.starts[n_matches], matches.stops[n_matches] = total, start, stop
            n_matches += 1
    return n_left, n_matches
