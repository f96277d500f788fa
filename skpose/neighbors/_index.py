"""The poses that are searched, under a metric."""

import numpy as np

from skpose._compiled.lanes import lanes
from skpose._compiled.tree import Steps
from skpose.metrics._registry import METRICS
from skpose.neighbors._filter import FLOAT32, ChordFilter
from skpose.skeleton import Skeleton


class PoseIndex:
    """Poses to search under a metric, and the filter of the search.

    Attributes
    ----------
    filter : ChordFilter or None
        None is brute force: requested, or because nothing bounds the metric.
    """

    def __init__(self, poses: np.ndarray, skeleton: Skeleton | None, metric: str, steps: Steps, *, brute: bool):
        self.poses, self.skeleton, self.metric, self.steps = np.ascontiguousarray(poses), skeleton, metric, steps
        self.filter = None
        chosen = METRICS[metric]
        # The bound of a metric that does not wrap by default takes differences that are not wrapped.
        bound_is_false = chosen.wraps is False and steps.half_turn < np.inf
        if not (brute or bound_is_false or chosen.bound is None):
            chords = ChordFilter(self.poses, chosen.bound, skeleton, steps)
            self.filter = chords if np.isfinite(chords.norm) else None

    def lanes_of(self, groups: np.ndarray) -> np.ndarray:
        """Return the indices of the poses in some groups of lanes, -1 where there is none."""
        indices = (lanes(FLOAT32) * groups[:, np.newaxis] + np.arange(lanes(FLOAT32))).ravel()
        return np.where(indices < len(self.poses), indices, -1)
