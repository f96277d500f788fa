"""The poses that are searched, under a metric."""

import numpy as np

from skpose._compiled.pose.measure import measure_euclidean
from skpose._compiled.simd.lanes import lanes
from skpose.metrics import Metric
from skpose.neighbors._filter import FLOAT32, ChordFilter
from skpose.neighbors._order import order_of_groups
from skpose.skeleton import Skeleton

LANES = lanes(FLOAT32)  # poses of a group


class PoseIndex:
    """Poses to search under a metric, the filter of the search, and the groups in which they are measured.

    Attributes
    ----------
    largest : float
        Largest size of a number in the poses.
    filter : ChordFilter or None
        None is brute force: requested, or because nothing bounds the metric.
    groups : ndarray of shape (n_groups, LANES)
        Indices of the poses in each group of lanes, -1 where there is none; as the poses come, until `sort_groups`.
    """

    def __init__(self, poses: np.ndarray, skeleton: Skeleton | None, metric: Metric, *, brute: bool):
        self.poses, self.skeleton, self.metric = np.ascontiguousarray(poses), skeleton, metric
        self.largest = largest_of(self.poses)
        self.filter = None
        self.groups = _groups(np.arange(len(poses)))
        bound = None if brute else metric.lower_bound()
        is_euclidean = isinstance(bound, Metric) and bound.lower_bound() == bound and bound.measure is measure_euclidean
        if bound is not None and not is_euclidean:
            raise ValueError(
                f"the lower bound of {metric.label!r} must be a Euclidean metric such as Position(), got {bound!r}"
            )
        if bound is not None:
            chords = ChordFilter(self.poses, bound, skeleton)
            self.filter = chords if np.isfinite(chords.norm) else None

    def sort_groups(self) -> None:
        """Put poses that are near each other into one group, for the filter too."""
        if self.filter is not None:
            order = order_of_groups(self.filter.coordinates(np.arange(len(self.poses))), LANES)
            self.groups = _groups(order)
            self.filter.reorder(order)


def largest_of(poses: np.ndarray) -> float:
    """Return the largest size of a number in poses."""
    return max(poses.max(initial=0.0), -poses.min(initial=0.0))


def _groups(order: np.ndarray) -> np.ndarray:
    groups = np.full((-(-len(order) // LANES), LANES), -1)
    groups.flat[: len(order)] = order
    return groups
