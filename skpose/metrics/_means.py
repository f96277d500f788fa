"""Means of poses: under any weights by a formula or by Newton's method on one pose, and samples for other searches.

At its current pose, a search needs the distances to all poses of the sample, their gradients, a metric tensor and a way
to take a step. A metric with means returns its own kind of sample from `Metric.sample`.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.geodesic import project
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import from_tree_order, retract, to_tree_order, tree_of
from skpose.skeleton import Skeleton
from skpose.skeleton._interpolation import move, steps_from

TOL = 1e-9  # norm of the gradient at which an extrinsic mean has converged, m²/rad
MAX_ITER = 200
GAP = 0.05  # excess over the lower bound of the variance, as a share of it, beyond which several starts are tried
STARTS = 3  # poses of the sample that are tried then
TINY = 1e-15  # m²
EQUAL = 1e-6  # relative difference of variances that are equal


@dataclass(frozen=True, eq=False)
class FrechetMeanResult:
    """A mean of poses, as returned by `frechet_mean`.

    Attributes
    ----------
    pose : ndarray of shape (n_dofs,)
        The mean: joint angles, rad.
    variance : float
        Mean of the squared distances to the mean, m²; rad² for "angle".
    gradient_norm : float
        Distance from a stationary point. For "position" the norm of the gradient of the variance, m²/rad. For other
        metrics the length of the mean logarithm of the poses, m (rad for "angle"): half the norm of the gradient in the
        metric tensor.
    n_iter : int
        Number of iterations.
    converged : bool
        Whether `gradient_norm` reached `tol` or the precision of float64, and all geodesics converged. For "geodesic"
        and "spatial", whose variance is uneven, 2 % of the standard deviation is enough.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.geodesics import frechet_mean
    >>> frechet_mean([[0.0], [1.0]], Skeleton.chain(1)).pose.round(3)
    array([0.5])
    """

    pose: np.ndarray = field(repr=False)
    variance: float
    gradient_norm: float
    n_iter: int
    converged: bool


class ArithmeticMeans:
    """Means of the columns under any weights."""

    def __init__(self, X: np.ndarray):
        self.X = X

    def mean(self, weights: np.ndarray, max_iter: int = 1, tol: float = 0.0) -> FrechetMeanResult:
        """The weighted mean of the columns."""
        pose = weights @ self.X / weights.sum()
        gaps = pose - self.X
        variance = weights @ (gaps**2).sum(axis=1) / weights.sum()
        gradient_norm = np.linalg.norm(weights @ gaps) / weights.sum()  # zero up to rounding
        return FrechetMeanResult(pose, float(variance), float(gradient_norm), 0, True)


class ExtrinsicMeans:
    """Poses whose positions are computed once, for their means under any weights.

    Parameters
    ----------
    X : ndarray of shape (n_poses, n_dofs)
        Poses, float64, rad.
    skeleton : Skeleton
        Their skeleton.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> means = ExtrinsicMeans(np.array([[0.0], [0.2], [0.6]]), Skeleton.chain(1))
    >>> [means.mean(np.array(weights)).pose.round(3).tolist() for weights in ([1, 1, 0], [0, 1, 1])]
    [[0.1], [0.4]]
    """

    def __init__(self, X: np.ndarray, skeleton: Skeleton):
        self.X, self.skeleton, self.tree = X, skeleton, tree_of(skeleton)
        self.positions = weighted_positions(X, skeleton)

    def mean(self, weights: np.ndarray, max_iter: int = MAX_ITER, tol: float = TOL) -> FrechetMeanResult:
        """The mean under weights (n_poses,) that are not negative and not all zero."""
        return self.search(weights, max_iter, tol)[0]

    def search(
        self, weights: np.ndarray, max_iter: int = MAX_ITER, tol: float = TOL, gap: float = GAP
    ) -> tuple[FrechetMeanResult, list[np.ndarray]]:
        """The mean, and the poses (n_dofs,) from which it was searched.

        Newton's method starts at the nearest pose of positive weight. No mean has a lower variance than the positions
        have about their mean; if the one found exceeds that by more than a share, the mean step from the nearest pose
        and some poses are starts, too, and the best is returned, of equal ones the first. Columns that move no joint
        keep the values of the start.
        """
        rows = np.flatnonzero(weights)
        X, positions = (self.X, self.positions) if len(rows) == len(weights) else (self.X[rows], self.positions[rows])
        shares = weights[rows] / weights[rows].sum()
        target = shares @ positions
        squares = ((positions - target) ** 2).sum(axis=1)
        least, nearest = shares @ squares, X[squares.argmin()]

        def from_start(start: np.ndarray) -> FrechetMeanResult:
            dofs, outcome = project(self.tree, target, to_tree_order(self.tree, start), max_iter, tol)
            pose = from_tree_order(self.tree, dofs, start)
            variance = float(shares @ ((positions - weighted_positions(pose[None], self.skeleton)) ** 2).sum(axis=1))
            norm, n_iter, converged = float(outcome.gradient_norm), int(outcome.n_iter), bool(outcome.converged)
            return FrechetMeanResult(pose, variance, norm, n_iter, converged)

        starts, bones = [nearest], self.skeleton.bones
        best = from_start(nearest)
        if best.variance > max(least * (1.0 + gap), TINY):
            step = shares @ steps_from(bones, nearest, X)
            starts += [*move(bones, nearest, step[None]), *some_of(X, shares, STARTS)[0]]
            for start in starts[1:]:
                other = from_start(start)
                if other.variance < best.variance * (1.0 - EQUAL):
                    best = other
        return best, starts


def some_of(X: np.ndarray, shares: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Up to n different poses, and their weights, which sum to 1; neither depends on the order of rows or on copies."""
    poses, copies = np.unique(X, axis=0, return_inverse=True)
    some = np.unique(np.linspace(0, len(poses) - 1, n).astype(int))
    weights = np.bincount(copies.ravel(), shares)[some]
    return poses[some], weights / weights.sum()


class Linearization(NamedTuple):
    """The distances from one pose to the poses of a sample, to first order."""

    lengths: np.ndarray  # (n_poses,) distances
    energies: np.ndarray  # (n_poses,) their squares, or squares of lengths that approach them
    gradients: np.ndarray  # (n_poses, n) of half the energies by the coordinates of the one pose
    tensor: np.ndarray  # (n, n) the metric tensor there
    n_unconverged: int = 0  # distances that may be wrong


class Sample:
    """Weighted poses, in float64, under one metric.

    Attributes
    ----------
    X : ndarray of shape (n_poses, n_dofs)
        The poses, in the columns of the skeleton.
    dofs : ndarray of shape (n_poses, n)
        The same in the coordinates of the search.
    weights : ndarray of shape (n_poses,)
        Their weights, which sum to 1.
    is_uneven : bool
        Whether distances may jump, as when a path is refined at one pose and not at the next.
    """

    is_uneven = False

    def __init__(self, X: np.ndarray, weights: np.ndarray):
        self.X, self.weights = X, weights
        self.dofs = X

    def starts(self) -> tuple[list[np.ndarray], np.ndarray]:
        """Poses where a search starts, in its coordinates, and the first in the columns of the skeleton."""
        raise NotImplementedError

    def linearize(self, pose: np.ndarray, slope: float) -> Linearization:
        """The distances to first order; `slope` is the norm of the previous gradient, or inf."""
        raise NotImplementedError

    def retract(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The pose that is a step of the coordinates away."""
        return pose + step

    def columns(self, pose: np.ndarray, others: np.ndarray) -> np.ndarray:
        """A pose of the search in the columns of the skeleton; columns that move no joint are copied from `others`."""
        return pose

    def remeasure(self, pose: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """The distances from the last pose of a search, as `pose_distances` computes them."""
        return lengths


class JointSample(Sample):
    """Poses with a skeleton, in the order of the tree.

    `frees_angles` is whether joints of three angles are moved as rotations instead of by their angles.
    """

    frees_angles = True
    gap = GAP  # see `ExtrinsicMeans.search`

    def __init__(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton):
        super().__init__(X, weights)
        self.skeleton, self.tree = skeleton, tree_of(skeleton)
        self.dofs = to_tree_order(self.tree, X)

    def starts(self) -> tuple[list[np.ndarray], np.ndarray]:
        """The extrinsic mean and, if it was searched from several poses, these."""
        mean, others = ExtrinsicMeans(self.X, self.skeleton).search(self.weights, gap=self.gap)
        starts = [mean.pose, *(others if len(others) > 1 else ())]
        return [to_tree_order(self.tree, start) for start in starts], mean.pose

    def retract(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The pose that is a step of the coordinates away."""
        return retract(self.tree, pose, step, self.frees_angles)

    def columns(self, pose: np.ndarray, others: np.ndarray) -> np.ndarray:
        """A pose of the search in the columns of the skeleton; columns that move no joint are copied from `others`."""
        return from_tree_order(self.tree, pose, others)
