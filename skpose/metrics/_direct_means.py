"""Means of poses by a formula, or by Newton's method on one pose."""

from typing import NamedTuple

import numpy as np

from skpose._compiled.path.mean import place_all, project
from skpose._compiled.pose.tree import Tree
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of
from skpose.skeleton import Skeleton

TOL = 1e-9  # norm of the gradient at which an extrinsic mean has converged, m²/rad
MAX_ITER = 200


class DirectMean(NamedTuple):
    """A mean, and how it was found."""

    pose: np.ndarray  # (n_dofs,) columns of the skeleton, rad
    dofs: np.ndarray  # (n,) the same in the tree's order, or the columns
    variance: float  # weighted mean of the squared distances to it
    gradient_norm: float  # of the variance
    n_iter: int
    converged: bool


class ArithmeticMeans:
    """Means of the columns under any weights."""

    def __init__(self, X: np.ndarray):
        self.X = X

    def mean(self, weights: np.ndarray, max_iter: int = 1, tol: float = 0.0) -> DirectMean:
        """The weighted mean of the columns."""
        pose = weights @ self.X / weights.sum()
        gaps = pose - self.X
        variance = weights @ (gaps**2).sum(axis=1) / weights.sum()
        gradient_norm = np.linalg.norm(weights @ gaps) / weights.sum()  # zero up to rounding
        return DirectMean(pose, pose, float(variance), float(gradient_norm), 0, True)


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
        self.X, self.tree = X, tree_of(skeleton)
        self.dofs = to_tree_order(self.tree, X)
        self.positions = positions_of(self.tree, self.dofs)  # (n_poses, 3 n_joints + 3) the root first, not scaled, m
        self.scale = np.repeat(self.tree.scale, 3)  # square roots of the weights of the joints

    def mean(self, weights: np.ndarray, max_iter: int = MAX_ITER, tol: float = TOL) -> DirectMean:
        """The mean under weights (n_poses,) that are not negative and not all zero.

        Newton's method starts at the nearest pose of positive weight; columns that move no joint keep its values.
        """
        rows = np.flatnonzero(weights)
        positions = self.positions if len(rows) == len(weights) else self.positions[rows]
        shares = weights[rows] / weights[rows].sum()
        target = shares @ positions
        nearest = int(rows[self._squares(positions, target).argmin()])
        dofs, outcome = project(self.tree, target, self.dofs[nearest].copy(), max_iter, tol)
        at = positions_of(self.tree, dofs[None])[0]
        return DirectMean(
            from_tree_order(self.tree, dofs, self.X[nearest]),
            dofs,
            float(shares @ self._squares(positions, at)),
            float(outcome.gradient_norm),
            int(outcome.n_iter),
            bool(outcome.converged),
        )

    def _squares(self, positions: np.ndarray, point: np.ndarray) -> np.ndarray:
        return (((positions - point) * self.scale) ** 2).sum(axis=1)


def positions_of(tree: Tree, dofs: np.ndarray) -> np.ndarray:
    """Positions of the joints of poses, both in the order of the tree."""
    positions = np.empty((len(dofs), 3 * len(tree.offset)))
    place_all(tree, dofs, positions)
    return positions
