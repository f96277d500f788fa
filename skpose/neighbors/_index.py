"""The poses that are searched, under a metric, in groups.

A bound of a group rules out all of its poses at once, and its poses are measured at once, so a group should hold
similar poses. Frames of a recording are, as they come; after a shuffle, or with many frames left out, they are not.
"""

import numpy as np

from skpose._compiled.pose.measure import measure_euclidean
from skpose._compiled.simd.lanes import lanes
from skpose.metrics import Metric
from skpose.neighbors._filter import FLOAT32, ChordFilter
from skpose.skeleton import Skeleton

LANES = lanes(FLOAT32)  # poses of a group
TOGETHER = 0.05  # share of the variance within groups, up to which the points stand together as they come


class PoseIndex:
    """Poses to search under a metric, the filter of the search, and the groups in which they are measured.

    Attributes
    ----------
    filter : ChordFilter or None
        None is brute force: requested, or because nothing bounds the metric.
    groups : ndarray of shape (n_groups, LANES)
        Indices of the poses in each group of lanes, -1 where there is none; as the poses come, until `sort_groups`.
    """

    def __init__(self, poses: np.ndarray, skeleton: Skeleton | None, metric: Metric, *, brute: bool):
        self.poses, self.skeleton, self.metric = np.ascontiguousarray(poses), skeleton, metric
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


def _groups(order: np.ndarray) -> np.ndarray:
    groups = np.full((-(-len(order) // LANES), LANES), -1)
    groups.flat[: len(order)] = order
    return groups


def order_of_groups(points: np.ndarray, size: int) -> np.ndarray:
    """Return an order (n_points,) of points (n_points, n_coordinates): each group is `size` points one after another.

    Unless they stand together as they come, points are halved at the median along the axis of their largest extent,
    again and again, until one group is left.
    """
    order = np.arange(len(points))
    if _variance_within(points, size) <= TOGETHER * points.var(axis=0).sum():
        return order
    parts = [(order, points.copy())]  # views of the order and of the points in it, to be halved
    while parts:
        part, some = parts.pop()
        if len(part) > size:
            middle = size * -(-len(part) // (2 * size))
            halves = np.argpartition(some[:, np.ptp(some, axis=0).argmax()], middle)
            part[:], some[:] = part[halves], some[halves]
            parts += [(part[:middle], some[:middle]), (part[middle:], some[middle:])]
    return order


def _variance_within(points: np.ndarray, size: int) -> float:
    """Return the mean over groups of the variance within, as they come; the last group counts if it is full."""
    groups = points[: len(points) // size * size].reshape(-1, size, points.shape[1])
    return float(groups.var(axis=1).sum(axis=1).mean()) if len(groups) else 0.0
