"""Path families: the segments of a motion that repeat one segment of it, the template, from a matrix of similarities.

A path goes through cells (i, k), frame i of the motion with frame k of the template, by steps (1, 1), (1, 2) and (2,
1), so that the tempo differs by a factor of two at most. It takes the whole template. A family is a set of paths whose
segments of the motion do not overlap. The best one has the largest score, the sum of the similarities of all its cells
(M. Müller, N. Jiang, P. Grosche, 2013, doi:10.1109/TASL.2012.2227732). The template's own path does not belong to it:
the frames before the template and those behind it have families of their own.

The *fitness* of a template is the harmonic mean of the mean similarity of all cells, where the template's own frames
are added as cells of similarity zero, and of the share of all frames that are in the segments.

Still frames are left out of the matrix; `pauses` has their number before each of its frames. No path goes on across a
pause longer than `longest`.

It follows row by row. Between two paths a family *waits*, in a state next to the cells: there it goes on without a
cell, or begins a path, and there a path arrives that has taken the last frame of the template.
"""

import numpy as np

from skpose._compiled.simd.jit import internal, jit


@internal
def _step_to(score, row, k):
    """The best score before cell k of a row, and its row and column."""
    best, before, column = score[row - 1, k - 1], row - 1, k - 1
    if score[row - 2, k - 1] > best:
        best, before = score[row - 2, k - 1], row - 2
    if k > 1 and score[row - 1, k - 2] > best:
        best, before, column = score[row - 1, k - 2], row - 1, k - 2
    return best, before, column


@internal
def _family_of(similarities, first, last, start, stop):
    """The best family in frames first:last of a template, frames start:stop, without pauses.

    Returns its score and, of each path, the segment (first frame, and the one behind the last), the number of cells
    and the sum of the similarities.
    """
    n, m = last - first, stop - start
    score = np.full((n + 2, m), -np.inf)  # two rows without a path, then the frames
    waiting, arrives = np.zeros(n + 1), np.zeros(n + 1, np.bool_)  # before each frame, and whether by a path's end
    for i in range(n + 1):
        if i > 0:
            arrives[i] = score[i + 1, m - 1] > waiting[i - 1]
            waiting[i] = score[i + 1, m - 1] if arrives[i] else waiting[i - 1]
        if i == n:
            break
        here, two, one, row = similarities[first + i, start:stop], score[i], score[i + 1], score[i + 2]
        row[0] = waiting[i] + here[0]
        if m > 1:
            row[1] = max(one[0], two[0]) + here[1]
        for k in range(2, m):  # no cell needs another of its row
            row[k] = max(max(one[k - 1], two[k - 1]), one[k - 2]) + here[k]
    segments, n_cells, sums, at = np.empty((n, 2), np.int64), np.ones(n, np.int64), np.empty(n), n
    i = n
    while i > 0:
        if not arrives[i]:
            i -= 1
            continue
        end, row, k, at = i, i + 1, m - 1, at - 1
        while k > 0:
            _, row, k = _step_to(score, row, k)
            n_cells[at] += 1
        i = row - 2
        segments[at, 0], segments[at, 1] = first + i, first + end
        sums[at] = waiting[end] - waiting[i]
    return waiting[n], segments[at:], n_cells[at:], sums[at:]


@jit
def segments_of(similarities, first, last, start, stop):
    """The segments of that family (n_paths, 2), and the mean similarity along each path."""
    _, segments, n_cells, sums = _family_of(similarities, first, last, start, stop)
    return segments, sums / n_cells


@jit
def fitness_of(similarities, pauses, longest, start, stop, row):
    """The fitness of a template, columns start:stop and as many rows from `row` on; zero without a family."""
    n, score, n_cells, n_covered = similarities.shape[0], 0.0, stop - start, 0
    for first, end in ((0, row), (row + stop - start, n)):
        while first < end:
            last = first + 1
            while last < end and pauses[last] <= longest:
                last += 1
            own, segments, cells, _ = _family_of(similarities, first, last, start, stop)
            score += own
            n_cells += cells.sum()
            n_covered += (segments[:, 1] - segments[:, 0]).sum()
            first = last
    if score <= 0.0:
        return 0.0
    mean_score, coverage = score / n_cells, n_covered / n
    return 2.0 * mean_score * coverage / (mean_score + coverage)


@jit
def first_far(is_far):
    """Find, for each first frame, the last one that a segment needs so that two of its frames are far apart."""
    n = is_far.shape[0]
    last, reach = n, np.empty(n, np.int64)
    for i in range(n - 1, -1, -1):
        j = i + 1
        while j < last and not is_far[i, j]:
            j += 1
        last = min(last, j)
        reach[i] = last
    return reach


@jit
def comes_back(similarities, start, stop, share):
    """Whether a template's last frame, or the next, is within a share of the largest distance from its first.

    One less the similarity is the distance, in some unit.
    """
    n, farthest, back = similarities.shape[0], 0.0, 1.0 - similarities[start, stop - 1]
    for j in range(start, stop):
        farthest = max(farthest, 1.0 - similarities[start, j])
    if stop < n:
        back = min(back, 1.0 - similarities[start, stop])
    return back <= share * farthest


@jit
def fitness_by_length(similarities, is_far, lengths, starts_per_length, share):
    """The fitness of the fittest template of each length, without pauses.

    Templates start a part of their length apart, have two frames that are far apart, and come back, see `comes_back`.
    """
    n, reach = similarities.shape[0], first_far(is_far)
    best, pauses = np.zeros(lengths.shape[0]), np.zeros(n, np.int64)
    for k in range(lengths.shape[0]):
        length = lengths[k]
        for start in range(0, n - length + 1, max(1, length // starts_per_length)):
            if reach[start] < start + length and comes_back(similarities, start, start + length, share):
                best[k] = max(best[k], fitness_of(similarities, pauses, 0, start, start + length, start))
    return best
