"""Lower bounds of the distances from a motion to others, in order of their cost.

They all follow from one bound of the distance between two frames: that of the filter's coordinates, which is never more
than the chord, ‖F(a) − F(b)‖ ≤ "geodesic" ≤ "spatial". So the least sum of the bounds along a path is never more than
the least sum of the distances, cell by cell.

1. *Ends*: every path goes through the first frames of both and through the last ones.
2. *Boxes*: dynamic time warping of the query's frames against boxes around FRAMES_PER_BOX frames of the other motion.
   A path that goes through a frame of a box goes at least as far as the box; each pair of a frame and a box that it
   touches counts once.
3. *Frames*: dynamic time warping under the filter's bound, a fifth of the coordinates and in float32.
4. *Cells*: the same from the end backwards, which states for each pair of frames what is left of the sum of a path
   through it. `skpose._compiled.warping.within` measures the cells that are left.

Rounding: every distance of the filter may be too long by its *slack*, see `skpose.neighbors._filter`. A path of n rows
and m columns has fewer than n + m cells, so that n + m slacks are subtracted from its sum.
"""

from typing import cast

import numpy as np

from skpose._compiled.pose import loops
from skpose._compiled.pose.measure import measure_boxes, measure_euclidean
from skpose._compiled.pose.tree import Steps
from skpose._compiled.warping.paths import Encoded, MotionPairs, Paths, accumulate_from, warp_loop
from skpose.kinematics._shared import tree_of
from skpose.motions._index import SequenceIndex
from skpose.neighbors._shared import FLOAT32, ChordFilter, FilterPoints

CLOSED, OPEN = Paths(1.0, False), Paths(1.0, True)
NO_TREE, NO_WRAP = tree_of(None, FLOAT32), Steps.of(1, wrap=False)


class Bounds:
    """Lower bounds of the sums of distances along paths from one motion to those of an index that has a filter."""

    def __init__(self, index: SequenceIndex, query: np.ndarray):
        self.index, self.n = index, len(query)
        chords = cast(ChordFilter, index.filter)
        self.points: FilterPoints = chords.points(query)
        self.scale, self.slack = chords.scale, float(self.points.slack.max())

    def ends(self) -> np.ndarray:
        """Return bounds of closed paths to all motions, by their ends."""
        q, (first, last) = self.points.coordinates.astype(np.float64), self.index.ends
        at_first = np.linalg.norm(first - q[0], axis=1)
        at_last = np.linalg.norm(last - q[-1], axis=1)
        one_cell = (self.n == 1) & (self.index.sequences.lengths == 1)
        return self._in_units(np.where(one_cell, at_first, at_first + at_last), 2)

    def boxes(self, motions: np.ndarray) -> np.ndarray:
        """Return bounds of closed paths to some motions, by boxes."""
        lanes, starts = self.index.box_lanes(motions)
        return self._warp(lanes, starts, measure_boxes, CLOSED)

    def frames(self, motions: np.ndarray, paths: Paths) -> np.ndarray:
        """Return bounds of the paths to some motions, by frames."""
        lanes, starts = self.index.frame_lanes(motions)
        return self._warp(lanes, starts, measure_euclidean, paths)

    def _warp(self, lanes: np.ndarray, starts: np.ndarray, measure: object, paths: Paths) -> np.ndarray:
        n_motions = len(starts) - 1
        sums = np.empty((1, n_motions))
        query, pairs = Encoded(self.points.coordinates, np.array([0, self.n])), MotionPairs(0, 1, 0, n_motions, False)
        warp_loop(FLOAT32)(query, Encoded(lanes, starts), pairs, paths, measure, NO_TREE, NO_WRAP, sums)
        return self._in_units(sums[0], self.n + np.diff(starts))

    def of_frames(self, start: int, stop: int) -> np.ndarray:
        """Return bounds of the distances (n, stop − start) from each frame to some frames of all."""
        lanes = loops.in_lanes(self.index.coordinates(np.arange(start, stop)))
        return self._distances(lanes, stop - start, measure_euclidean)

    def of_boxes(self, first: int, last: int) -> np.ndarray:
        """Return bounds of the distances (n, last − first) from each frame to all frames of some boxes."""
        return self._distances(loops.in_lanes(self.index.boxes[first:last]), last - first, measure_boxes)

    def _distances(self, lanes: np.ndarray, n_columns: int, measure: object) -> np.ndarray:
        points = self.points.coordinates
        distances = np.empty((self.n, n_columns), FLOAT32)
        n_groups = -(-n_columns // lanes.shape[1])
        pairs = loops.PairRange(0, self.n, 0, n_groups, triangle=False)
        loops.pair_distances_loop(FLOAT32)(points, lanes, pairs, measure, NO_TREE, NO_WRAP, distances)
        bounds = distances.astype(np.float64)
        bounds -= self.points.slack[:, np.newaxis]
        np.maximum(bounds, 0.0, out=bounds)
        bounds *= self.scale
        return bounds

    def _in_units(self, sums: np.ndarray, n_cells: np.ndarray | int) -> np.ndarray:
        return np.maximum(sums - n_cells * self.slack, 0.0) * self.scale


def sums_to_end(bounds: np.ndarray, paths: Paths, behind: np.ndarray | None = None) -> np.ndarray:
    """Return the least sums (n, m) of the bounds from each cell, itself included, to the end of a path.

    `behind` are those of the column behind the last one, of open paths.
    """
    reverse = np.ascontiguousarray(bounds[::-1, ::-1])
    edge = np.full(len(bounds), np.inf) if behind is None else np.ascontiguousarray(behind[::-1])
    accumulate_from(reverse, paths, edge)
    return np.ascontiguousarray(reverse[::-1, ::-1])
