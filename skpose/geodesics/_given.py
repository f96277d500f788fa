"""The poses of a mean or a median as they are given, checked, under one of the metrics."""

from numbers import Integral, Real
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs

from skpose._compat.sklearn import Interval, StrOptions
from skpose._typing import ArrayLike
from skpose._validation.numbers import check_numbers
from skpose._validation.skeletons import IS_SKELETON
from skpose.geodesics._descent import Spread, Viewed, descend
from skpose.geodesics._extrinsic import MAX_ITER, ExtrinsicMean, ExtrinsicMeans
from skpose.geodesics._geodesic_view import GeodesicPoses
from skpose.geodesics._line_view import LinePoses
from skpose.geodesics._quasi_newton import minimise_sum
from skpose.geodesics._views import AnglePoses, PositionPoses, RotationPoses
from skpose.kinematics._shared import from_tree_order, to_tree_order, tree_of
from skpose.metrics._shared import METRICS, resolve
from skpose.skeleton import Skeleton

CONSTRAINTS = {
    "skeleton": [IS_SKELETON],
    "metric": [StrOptions(set(METRICS))],
    "sample_weight": ["array-like", None],
    "n_steps": [Interval(Integral, 2, None, closed="left")],
    "wrap": ["boolean", StrOptions({"auto"})],
    "max_iter": [Interval(Integral, 1, None, closed="left")],
    "tol": [Interval(Real, 0, None, closed="left")],
    "n_jobs": [None, Integral],
}


class Given(NamedTuple):
    """Poses of weight, in float64, and their weights of sum 1."""

    X: np.ndarray  # (n_poses, n_dofs)
    weights: np.ndarray  # (n_poses,)
    skeleton: Skeleton

    @classmethod
    def of(cls, poses: np.ndarray, skeleton: Skeleton, sample_weight: ArrayLike | None) -> "Given":
        """Check the weights of poses, which are checked already, and leave out those of weight zero."""
        weights = _weights(sample_weight, len(poses))
        counted = weights > 0.0
        return cls(poses[counted], weights[counted], skeleton)

    def extrinsic_mean(self, max_iter: int = MAX_ITER) -> ExtrinsicMean:
        """Return the pose nearest to the mean of the positions."""
        return ExtrinsicMeans.of(self.X, self.skeleton).mean(self.weights, max_iter)

    def viewed(
        self, metric: str, n_steps: int, wrap: bool | str, n_jobs: int | None
    ) -> tuple[Viewed, np.ndarray, np.ndarray]:
        """Return the poses under a metric, where to start, and a pose whose columns fill those that move no joint."""
        name, _, steps = resolve(metric, self.skeleton, n_steps, wrap)
        wraps, threads = bool(np.isfinite(steps.half_turn)), effective_n_jobs(n_jobs)
        if name == "angle":
            poses = AnglePoses(self.X, self.weights, wraps)
            return poses, poses.start(), self.X[0]
        start = self.extrinsic_mean()
        viewed: Viewed
        if name == "position":
            viewed = PositionPoses.of(self.X, self.weights, self.skeleton)
        elif name == "geodesic":
            tree = tree_of(self.skeleton)
            viewed = GeodesicPoses.of(tree, to_tree_order(tree, self.X), self.weights, n_steps, wraps, threads)
        elif name == "rotation":
            viewed = RotationPoses.of(self.X, self.weights, self.skeleton)
        else:
            viewed = LinePoses.of(self.X, self.weights, self.skeleton, steps, threads)
        return viewed, start.dofs, start.pose

    def minimised(
        self, poses: Viewed, start: np.ndarray, power: int, max_iter: int, tol: float
    ) -> tuple[Spread, int, str]:
        """Return the mean or median from a start, the iterations, and why it did not converge: empty if it did."""
        if isinstance(poses, LinePoses):
            return minimise_sum(poses, start, power, max_iter, tol)
        spread, n_iter, reason = descend(poses, start, power, max_iter, tol)
        if isinstance(poses, GeodesicPoses):
            spread = poses.measured_again(spread, power)
        return spread, n_iter, reason

    def columns_of(self, metric: str, pose: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return a pose that was found in the columns of the skeleton; what moves no joint is as in the others."""
        return pose if metric == "angle" else from_tree_order(tree_of(self.skeleton), pose, others)


def _weights(sample_weight: ArrayLike | None, n_poses: int) -> np.ndarray:
    """Return weights whose sum is one."""
    if sample_weight is None:
        return np.full(n_poses, 1.0 / n_poses)
    weights = check_numbers(sample_weight, "sample_weight")
    if weights.shape != (n_poses,):
        raise ValueError(f"sample_weight must have shape ({n_poses},), one for each pose, got {weights.shape}")
    if not (np.isfinite(weights).all() and (weights >= 0).all() and weights.any()):
        raise ValueError("sample_weight must be finite, nowhere negative, and somewhere positive")
    weights = weights / weights.max()  # whose sum is finite
    return weights / weights.sum()
