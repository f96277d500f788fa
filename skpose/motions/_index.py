"""Motions to search, and lower bounds of the distances from a query to them, in order of their cost.

All bounds follow from one bound of the distance between two frames: the distance between the coordinates of a
`ChordFilter` is at most the chord, and ‖F(a) − F(b)‖ ≤ "geodesic" ≤ "spatial". So the least sum of the bounds along a
path is at most the least sum of the distances.

1. *Ends*: every path goes through the first frames of both motions and through the last ones.
2. *Boxes*: dynamic time warping of the query's frames against boxes around FRAMES_PER_BOX frames of the other motion.
3. *Frames*: dynamic time warping of the coordinates, a fifth of the positions and in float32.
4. *Cells*: the same from the end backwards, a bound of the rest of each path from each pair of frames on.
   `skpose._compiled.warping.within` measures the cells that are left.

Rounding: each distance between coordinates may be too long by its *slack*, see `skpose.neighbors._index`. A path of n
rows and m columns has fewer than n + m cells, so n + m slacks are subtracted from its sum.
"""

import copy
from typing import cast

import numpy as np

from skpose._compiled.pose import loops
from skpose._compiled.pose.measure import measure_boxes, measure_euclidean
from skpose._compiled.pose.tree import Steps
from skpose._compiled.warping.paths import Encoded, MotionPairs, Paths, accumulate_from, warp_pairs
from skpose.kinematics._tree import tree_of
from skpose.metrics import Metric
from skpose.motions._inputs import Sequences
from skpose.neighbors._index import FLOAT32, ChordFilter, FilterPoints, PoseIndex
from skpose.skeleton import Skeleton

FRAMES_PER_BOX = 8
CLOSED, OPEN = Paths(1.0, False), Paths(1.0, True)
NO_TREE, NO_WRAP = tree_of(None, FLOAT32), Steps.of(1, wrap=False)


class SequenceIndex:
    """Motions to search under a metric, with boxes around every few frames along the axes of the filter.

    Attributes
    ----------
    filter : ChordFilter or None
        None is brute force: requested, or because the metric has no lower bound.
    box_starts : ndarray of shape (n_motions + 1,)
        The boxes of motion i are box_starts[i]:box_starts[i + 1]. Only with a filter, as the next two.
    boxes : ndarray of shape (n_boxes, 2 n_coordinates)
        Lower and upper corners of the smallest boxes that hold the coordinates of the frames.
    ends : ndarray of shape (2, n_motions, n_coordinates)
        Coordinates of the first and the last frame of each motion.
    """

    def __init__(self, sequences: Sequences, skeleton: Skeleton | None, metric: Metric, *, brute: bool = False):
        self.sequences, self.skeleton, self.metric = sequences, skeleton, metric
        self.filter: ChordFilter | None = PoseIndex(sequences.poses, skeleton, metric, brute=brute).filter
        if self.filter is not None:
            starts = sequences.starts
            self.ends = np.stack([self.coordinates(starts[:-1]), self.coordinates(starts[1:] - 1)])
            counts = -(-sequences.lengths // FRAMES_PER_BOX)
            self.box_starts = np.concatenate([[0], np.cumsum(counts)])
            firsts = np.repeat(starts[:-1] - FRAMES_PER_BOX * self.box_starts[:-1], counts)
            self.box_firsts = firsts + FRAMES_PER_BOX * np.arange(self.box_starts[-1])
            coordinates = self.coordinates(np.arange(len(sequences.poses)))
            low, high = (edge.reduceat(coordinates, self.box_firsts, axis=0) for edge in (np.minimum, np.maximum))
            self.boxes = np.concatenate([low, high], axis=1)

    def under(self, metric: Metric) -> "SequenceIndex":
        """The same motions under another metric with the same bound."""
        other = copy.copy(self)
        other.metric = metric
        return other

    def coordinates(self, frames: np.ndarray) -> np.ndarray:
        """The filter's coordinates of some frames, (n_frames, n_coordinates), in float32."""
        return cast(ChordFilter, self.filter).coordinates(frames)


def gather_rows(starts: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows of chosen parts, part i being starts[i]:starts[i + 1], and where each begins among them."""
    counts = starts[chosen + 1] - starts[chosen]
    ends = np.cumsum(counts)
    rows = np.arange(ends[-1]) + np.repeat(starts[chosen] - ends + counts, counts)
    return rows, np.concatenate([[0], ends])


class Bounds:
    """Lower bounds of the sums of distances along paths from one motion to the motions of an index with a filter."""

    def __init__(self, index: SequenceIndex, query: np.ndarray):
        self.index, self.n = index, len(query)
        chords = cast(ChordFilter, index.filter)
        self.points: FilterPoints = chords.points(query)
        self.scale, self.slack = chords.scale, float(self.points.slack.max())

    def ends(self) -> np.ndarray:
        """Bounds of closed paths to all motions, by their ends."""
        q, (first, last) = self.points.coordinates.astype(np.float64), self.index.ends
        at_first = np.linalg.norm(first - q[0], axis=1)
        at_last = np.linalg.norm(last - q[-1], axis=1)
        one_cell = (self.n == 1) & (self.index.sequences.lengths == 1)
        return self._in_units(np.where(one_cell, at_first, at_first + at_last), 2)

    def boxes(self, motions: np.ndarray) -> np.ndarray:
        """Bounds of closed paths to some motions, by boxes."""
        rows, starts = gather_rows(self.index.box_starts, motions)
        return self._warp(self.index.boxes[rows], starts, measure_boxes, CLOSED)

    def frames(self, motions: np.ndarray, paths: Paths) -> np.ndarray:
        """Bounds of the paths to some motions, by frames."""
        rows, starts = gather_rows(self.index.sequences.starts, motions)
        return self._warp(self.index.coordinates(rows), starts, measure_euclidean, paths)

    def _warp(self, rows: np.ndarray, starts: np.ndarray, measure: object, paths: Paths) -> np.ndarray:
        n_motions = len(starts) - 1
        sums = np.empty((1, n_motions))
        query, pairs = Encoded(self.points.coordinates, np.array([0, self.n])), MotionPairs(0, 1, 0, n_motions, False)
        lanes = loops.in_lanes(rows.astype(FLOAT32, copy=False))
        warp_pairs(query, Encoded(lanes, starts), pairs, paths, measure, NO_TREE, NO_WRAP, sums)
        return self._in_units(sums[0], self.n + np.diff(starts))

    def of_frames(self, start: int, stop: int) -> np.ndarray:
        """Bounds of the distances (n, stop − start) from each frame of the query to some frames."""
        return self._distances(self.index.coordinates(np.arange(start, stop)), measure_euclidean)

    def of_boxes(self, first: int, last: int) -> np.ndarray:
        """Bounds of the distances (n, last − first) from each frame of the query to all frames of some boxes."""
        return self._distances(self.index.boxes[first:last], measure_boxes)

    def _distances(self, rows: np.ndarray, measure: object) -> np.ndarray:
        points, lanes = self.points.coordinates, loops.in_lanes(rows)
        distances = np.empty((self.n, len(rows)), FLOAT32)
        n_groups = -(-len(rows) // lanes.shape[1])
        pairs = loops.PairRange(0, self.n, 0, n_groups, triangle=False)
        loops.pair_distances(points, lanes, pairs, measure, NO_TREE, NO_WRAP, distances)
        bounds = distances.astype(np.float64)
        bounds -= self.points.slack[:, np.newaxis]
        np.maximum(bounds, 0.0, out=bounds)
        bounds *= self.scale
        return bounds

    def _in_units(self, sums: np.ndarray, n_cells: np.ndarray | int) -> np.ndarray:
        return np.maximum(sums - n_cells * self.slack, 0.0) * self.scale


def sums_to_end(bounds: np.ndarray, paths: Paths, behind: np.ndarray | None = None) -> np.ndarray:
    """Least sums (n, m) of the bounds from each cell, itself included, to the end of a path.

    `behind` are the sums of the column after the last one, for open paths.
    """
    reverse = np.ascontiguousarray(bounds[::-1, ::-1])
    edge = np.full(len(bounds), np.inf) if behind is None else np.ascontiguousarray(behind[::-1])
    accumulate_from(reverse, paths, edge)
    return np.ascontiguousarray(reverse[::-1, ::-1])
