"""Motions that are searched: their frames, the filter's coordinates of them, and boxes around some frames at a time."""

import copy
from typing import cast

import numpy as np

from skpose._compiled.pose import loops
from skpose.metrics import Metric
from skpose.motions._inputs import Sequences
from skpose.neighbors._shared import FLOAT32, ChordFilter, PoseIndex
from skpose.skeleton import Skeleton

FRAMES_PER_BOX = 8


class SequenceIndex:
    """Motions to search under a metric.

    The lower bound of a distance between frames is that of the filter's coordinates, see `skpose.neighbors._filter`.
    The bound of a frame and all frames of a *box* is its distance to the smallest box, along the axes of these
    coordinates, that holds them.

    Attributes
    ----------
    filter : ChordFilter or None
        None is brute force: requested, or because nothing bounds the metric.
    box_starts : ndarray of shape (n_motions + 1,)
        The boxes of motion i are box_starts[i]:box_starts[i + 1]. Only with a filter, as the next two.
    boxes : ndarray of shape (n_boxes, 2 n_coordinates)
        Lower and upper corners.
    ends : ndarray of shape (2, n_motions, n_coordinates)
        Coordinates of the first and the last frame of each motion.
    """

    def __init__(self, sequences: Sequences, skeleton: Skeleton | None, metric: Metric, *, brute: bool = False):
        self.sequences, self.skeleton, self.metric = sequences, skeleton, metric
        self.filter: ChordFilter | None = PoseIndex(sequences.poses, skeleton, metric, brute=brute).filter
        if self.filter is not None:
            starts = sequences.starts
            self.ends = np.stack([self.coordinates(starts[:-1]), self.coordinates(starts[1:] - 1)])
            self._make_boxes()

    def under(self, metric: Metric) -> "SequenceIndex":
        """Return the same motions under another metric with the same bound."""
        other = copy.copy(self)
        other.metric = metric
        return other

    def coordinates(self, frames: np.ndarray) -> np.ndarray:
        """Return the filter's coordinates of some frames, (n_frames, n_coordinates), in float32."""
        return cast(ChordFilter, self.filter).coordinates(frames)

    def _make_boxes(self) -> None:
        lengths, starts = self.sequences.lengths, self.sequences.starts
        counts = -(-lengths // FRAMES_PER_BOX)
        self.box_starts = np.concatenate([[0], np.cumsum(counts)])
        first = np.repeat(starts[:-1] - FRAMES_PER_BOX * self.box_starts[:-1], counts)
        first += FRAMES_PER_BOX * np.arange(self.box_starts[-1])  # the first frame of each box
        coordinates = self.coordinates(np.arange(len(self.sequences.poses)))
        low, high = (edge.reduceat(coordinates, first, axis=0) for edge in (np.minimum, np.maximum))
        self.boxes = np.concatenate([low, high], axis=1)

    def box_lanes(self, motions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the boxes of some motions in groups of lanes, and where those of each begin."""
        rows, starts = gather_rows(self.box_starts, motions)
        return loops.in_lanes(self.boxes[rows]), starts

    def frame_lanes(self, motions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates of the frames of some motions in groups of lanes, and where those of each begin."""
        rows, starts = gather_rows(self.sequences.starts, motions)
        return loops.in_lanes(self.coordinates(rows).astype(FLOAT32, copy=False)), starts


def gather_rows(starts: np.ndarray, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of chosen parts, part i being starts[i]:starts[i + 1], and where each begins among them."""
    counts = starts[chosen + 1] - starts[chosen]
    ends = np.cumsum(counts)
    rows = np.arange(ends[-1]) + np.repeat(starts[chosen] - ends + counts, counts)
    return rows, np.concatenate([[0], ends])
