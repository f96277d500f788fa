"""An order of points in which those that are near each other stand together, in groups of one size.

A bound of a group rules out all of its poses at once, and its poses are measured at once, so a group should hold
similar poses. Frames of a recording are, as they come; after a shuffle, or with many frames left out, they are not.
"""

import numpy as np

TOGETHER = 0.05  # share of the variance within groups, up to which the points stand together as they come


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
