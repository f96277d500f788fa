"""The poses that are searched, under a metric, in groups.

A bound of a group rules out all of its poses at once, and its poses are measured at once, so a group holds similar
poses.

The filter of a search: lower bounds of distances, at a thousandth of their cost.

A chord is never longer than a curve, so ‖F(a) − F(b)‖ bounds "spatial" and "geodesic" from below, without any triangle
inequality, and it is tight. Orthonormal axes V split it without loss: with F = Vz + rest,
‖F(a) − F(b)‖² = ‖z(a) − z(b)‖² + ‖rest(a) − rest(b)‖² ≥ ‖z(a) − z(b)‖² + (‖rest(a)‖ − ‖rest(b)‖)².
Along the first principal axes of the joint positions the first term is nearly all of it. A `ChordFilter` holds z and
‖rest‖ of every pose in float32, in groups of lanes, boxes around groups and boxes around boxes: the nearest poses are
found without most of them (`skpose._compiled.pose.candidates`).

Rounding: coordinates of norm r and q are rounded by a relative 2⁻²⁴ at most, which changes their distance by no more
than 2⁻²⁴ (r + q); the distance itself, no more than r + q, is computed with a relative error below 16 · 2⁻²⁴. What
float64 adds, in ‖rest‖² = ‖F‖² − ‖z‖² above all, is a few more 2⁻²⁴ (r + q). So no bound is too high after its
*slack*, about three times the sum of these, is subtracted.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from skpose._compiled.pose import loops
from skpose._compiled.pose.candidates import Boxes, Known, nearest_of_boxes
from skpose._compiled.pose.measure import measure_euclidean
from skpose._compiled.pose.nearest import Heaps, bounds_of_groups
from skpose._compiled.simd.lanes import empty_aligned, lanes
from skpose._utils.parallel import over_rows
from skpose.metrics import Metric
from skpose.metrics._matrix import ENCODED_AT_ONCE
from skpose.skeleton import Skeleton


class Neighbors(NamedTuple):
    """Neighbours of several queries, sorted by query, then by distance, then by index."""

    queries: np.ndarray
    indices: np.ndarray
    distances: np.ndarray

    @classmethod
    def join(cls, parts: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> "Neighbors":
        """Concatenate parts that are sorted already."""
        return cls(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    @classmethod
    def sort(cls, parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> "Neighbors":
        """Concatenate and sort parts that are in any order."""
        queries, indices, distances = cls.join(parts)
        order = queries.argsort(kind="stable")
        for row in np.split(order, np.flatnonzero(np.diff(queries[order])) + 1):
            row[:] = row[np.lexsort((indices[row], distances[row]))]
        return cls(queries[order], indices[order], distances[order])


# --- index ------------------------------------------------------------------------------------------------------------


N_AXES = 17  # and the rest: a multiple of three, as `to_points` takes three at a time
SAMPLE = 4096  # poses from which the axes are computed
GROUPS_PER_SAMPLE = 512  # from which it is estimated what the filter leaves
ROUNDING = 64 * 2.0**-24
IN_RANGE = 1e15  # largest coordinate, in units of the filter; float32 cannot sum the squares of much larger ones
FILTER_WORK = 6  # per pair of a query and a pose. Measured: 1.1 ns
FLOAT32 = np.dtype(np.float32)


class FilterPoints(NamedTuple):
    """Queries as the filter sees them."""

    coordinates: np.ndarray  # (n_queries, n_coordinates)
    slack: np.ndarray  # (n_queries,) rounding of the bounds, in units of the filter; infinite where out of range

    def take(self, rows: np.ndarray) -> "FilterPoints":
        return FilterPoints(self.coordinates[rows], self.slack[rows])


class ChordFilter:
    """Lower bounds of the distances from any pose to those of an index.

    Parameters
    ----------
    poses : ndarray of shape (n_poses, n_dofs)
    bound : Metric
        The Euclidean distance of its codes. The distances between the filter's points are lower bounds of it, and so of
        every metric that is never less.
    skeleton
        As for `Metric.encode_poses`.

    Attributes
    ----------
    scale : float
        Unit of the coordinates; m, or rad for "angle".
    groups : ndarray of shape (n_groups * n_coordinates, lanes)
        Coordinates of all poses, in groups of lanes.
    boxes : tuple of two ndarrays
        Boxes around groups, and around groups of lanes of these boxes, see `skpose._compiled.pose.candidates.Boxes`.
    norm : float
        Largest norm of a pose's coordinates; infinite where the filter cannot be used, as poses are beyond the range of
        float32.
    """

    def __init__(self, poses: np.ndarray, bound: Metric, skeleton: Skeleton | None):
        self.bound, self.skeleton = bound, skeleton
        sample = np.linspace(0, len(poses) - 1, min(SAMPLE, len(poses))).astype(int)
        codes = bound.encode_poses(poses[sample], skeleton)
        self.scale = np.abs(codes).max() or 1.0
        codes /= self.scale
        self.mean = codes.mean(axis=0)
        codes -= self.mean
        self.axes = np.ascontiguousarray(np.linalg.eigh(codes.T @ codes)[1].T[: -N_AXES - 1 : -1])
        width = lanes(FLOAT32)
        self.n_coordinates = len(self.axes) + 1
        self.groups = empty_aligned(-(-len(poses) // width) * self.n_coordinates, width, FLOAT32)
        self.norm = 0.0
        for start in range(0, len(poses), ENCODED_AT_ONCE):
            coordinates, norms = self._coordinates(poses[start : start + ENCODED_AT_ONCE])
            first, last = start // width, -(-(start + len(coordinates)) // width)
            self.groups[first * self.n_coordinates : last * self.n_coordinates] = loops.in_lanes(coordinates)
            self.norm = max(self.norm, norms.max())
        self.boxes = self._enclose()

    def coordinates(self, poses: np.ndarray) -> np.ndarray:
        """Return the coordinates of some poses (n_poses, n_coordinates), given by their places in the groups."""
        width = self.groups.shape[1]
        return self.groups.reshape(-1, self.n_coordinates, width)[poses // width, :, poses % width]

    def reorder(self, order: np.ndarray) -> None:
        """Put the poses into the groups in this order."""
        self.groups = loops.in_lanes(self.coordinates(order))
        self.boxes = self._enclose()

    def points(self, poses: np.ndarray) -> FilterPoints:
        """Return queries as points of the filter."""
        coordinates, norms = self._coordinates(poses)
        return FilterPoints(coordinates, ROUNDING * (norms + self.norm))

    def bounds(self, points: FilterPoints, n_jobs: int, groups: np.ndarray | None = None) -> np.ndarray:
        """Return the least lower bound (n_queries, n_groups) of each group of poses, in units of the filter.

        They may be too high by the slack; `limits` are what to compare them with.
        """
        groups = self.groups if groups is None else groups
        n_queries, n_groups = len(points.slack), len(groups) // self.n_coordinates
        bounds = np.empty((n_queries, n_groups), FLOAT32)
        over_rows(
            lambda first, last: bounds_of_groups(points.coordinates, groups, first, last, bounds),
            n_queries,
            FILTER_WORK * n_queries * groups.size / self.n_coordinates,
            n_jobs,
        )
        return bounds

    def share_within(self, points: FilterPoints, limits: np.ndarray, n_jobs: int) -> float:
        """Estimate from a sample the share of all pairs whose group has its least bound within the query's limit."""
        groups = self.groups.reshape(-1, self.n_coordinates, self.groups.shape[1])
        sample = groups[np.linspace(0, len(groups) - 1, min(GROUPS_PER_SAMPLE, len(groups))).astype(int)]
        bounds = self.bounds(points, n_jobs, np.ascontiguousarray(sample).reshape(-1, self.groups.shape[1]))
        return float((bounds <= limits[:, np.newaxis]).mean()) if len(bounds) else 0.0

    def limits(self, points: FilterPoints, limits: np.ndarray) -> np.ndarray:
        """Return the largest bounds of poses that may be within limits of their distances."""
        with np.errstate(over="ignore"):
            return np.minimum(limits / self.scale + points.slack, np.finfo(FLOAT32).max)

    def nearest(
        self,
        points: FilterPoints,
        indices: np.ndarray,
        known: Known,
        limits: np.ndarray,
        n: int,
        n_jobs: int,
    ) -> Heaps:
        """Return the n poses with the least lower bounds within limits, in order, given the poses in groups."""
        near = Heaps.of(limits, n, FLOAT32)
        boxes = Boxes(self.groups, indices, *self.boxes)
        over_rows(
            lambda first, last: nearest_of_boxes(points.coordinates, boxes, first, last, known, near),
            len(limits),
            FILTER_WORK * len(limits) * (256 * n),
            n_jobs,
        )
        return near

    def lowest(self, points: FilterPoints, bounds: np.ndarray) -> np.ndarray:
        """Return lower bounds of distances, given bounds (n_queries, n) in units of the filter."""
        with np.errstate(invalid="ignore", over="ignore"):
            return (bounds.astype(np.float64) - points.slack[:, np.newaxis]) * self.scale

    def _enclose(self) -> tuple[np.ndarray, np.ndarray]:
        """Return boxes around groups, and around groups of lanes of these boxes, in lanes."""
        points, levels = self.groups.reshape(-1, self.n_coordinates, self.groups.shape[1]), []
        low, high = points.min(axis=2), points.max(axis=2)
        for _ in range(2):
            levels.append(loops.in_lanes(np.hstack([low, high])))
            starts = np.arange(0, len(low), self.groups.shape[1])
            low, high = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
        return levels[0], levels[1]

    def _coordinates(self, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return coordinates and their norms; zero and infinity where they are out of range."""
        with np.errstate(over="ignore"):
            codes = self.bound.encode_poses(poses, self.skeleton) / self.scale - self.mean
        out = np.abs(codes).max(axis=1) > IN_RANGE
        codes[out] = 0.0
        # Not by BLAS: its threads stay busy for a while and take the processors from the search's threads.
        z = np.einsum("nc,ac->na", codes, self.axes)
        square = np.einsum("nc,nc->n", codes, codes)
        rest = np.sqrt(np.maximum(square - np.einsum("na,na->n", z, z), 0.0))
        return np.column_stack([z, rest]).astype(FLOAT32), np.where(out, np.inf, np.sqrt(square))


LANES = lanes(FLOAT32)  # poses of a group


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

    Points are halved at the median along the axis of their largest extent, again and again, until one group is left.
    """
    order = np.arange(len(points))
    parts = [(order, points.copy())]  # views of the order and of the points in it, to be halved
    while parts:
        part, some = parts.pop()
        if len(part) > size:
            middle = size * -(-len(part) // (2 * size))
            halves = np.argpartition(some[:, np.ptp(some, axis=0).argmax()], middle)
            part[:], some[:] = part[halves], some[halves]
            parts += [(part[:middle], some[:middle]), (part[middle:], some[middle:])]
    return order
