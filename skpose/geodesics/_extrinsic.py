"""The extrinsic mean: the pose nearest to the mean of the positions of the joints."""

from typing import NamedTuple

import numpy as np

from skpose._compiled.path.mean import place_all, project
from skpose._compiled.pose.tree import Tree
from skpose.kinematics._shared import from_tree_order, to_tree_order, tree_of
from skpose.skeleton import Skeleton

TOL = 1e-9  # norm of the gradient at which the mean has converged, m²/rad
MAX_ITER = 200


class ExtrinsicMean(NamedTuple):
    """The pose with the least weighted sum of squared distances under "position"."""

    pose: np.ndarray  # (n_dofs,) columns of the skeleton, rad; those that move no joint are the nearest pose's
    dofs: np.ndarray  # (n_tree_dofs,) the same in the tree's order
    nearest: int  # the row of the given pose that is nearest to the mean of the positions
    variance: float  # weighted mean of the squared distances to it, m²
    gradient_norm: float  # of the variance, m²/rad
    n_iter: int
    converged: bool


class ExtrinsicMeans(NamedTuple):
    """Poses whose positions are computed once, for the means of many weightings of them.

    >>> from skpose import Skeleton
    >>> means = ExtrinsicMeans.of(np.array([[0.0], [0.2], [0.6]]), Skeleton.chain(1))
    >>> [means.mean(np.array(weights)).pose.round(3).tolist() for weights in ([1, 1, 0], [0, 1, 1])]
    [[0.1], [0.4]]
    """

    tree: Tree
    X: np.ndarray  # (n_poses, n_dofs) columns of the skeleton, rad
    dofs: np.ndarray  # (n_poses, n_tree_dofs) in the tree's order
    positions: np.ndarray  # (n_poses, 3 n_joints + 3) of the joints in the tree's order, the root first, m
    scale: np.ndarray  # (3 n_joints + 3,) square roots of the weights of the joints

    @classmethod
    def of(cls, X: np.ndarray, skeleton: Skeleton) -> "ExtrinsicMeans":
        """Place the joints of float64 poses, which are checked already."""
        tree = tree_of(skeleton)
        dofs = to_tree_order(tree, X)
        return cls(tree, X, dofs, positions_of(tree, dofs), np.repeat(tree.scale, 3))

    def mean(self, weights: np.ndarray, max_iter: int = MAX_ITER, tol: float = TOL) -> ExtrinsicMean:
        """Return the mean under weights (n_poses,) that are not negative and not all zero.

        Newton's method starts at the nearest of the poses with weight. Those without cost nothing.
        """
        rows = np.flatnonzero(weights)
        positions = self.positions if len(rows) == len(weights) else self.positions[rows]
        shares = weights[rows] / weights[rows].sum()
        target = shares @ positions
        squares = self._squares(positions, target)
        nearest = int(rows[squares.argmin()])
        dofs, outcome = project(self.tree, target, self.dofs[nearest].copy(), max_iter, tol)
        at = positions_of(self.tree, dofs[None])[0]
        return ExtrinsicMean(
            from_tree_order(self.tree, dofs, self.X[nearest]),
            dofs,
            nearest,
            float(shares @ self._squares(positions, at)),
            float(outcome.gradient_norm),
            int(outcome.n_iter),
            bool(outcome.converged),
        )

    def distances(self, dofs: np.ndarray) -> np.ndarray:
        """Return the distances (n_poses,) from a pose in the tree's order to all poses, m."""
        return np.sqrt(self._squares(self.positions, positions_of(self.tree, dofs[None])[0]))

    def _squares(self, positions: np.ndarray, point: np.ndarray) -> np.ndarray:
        return (((positions - point) * self.scale) ** 2).sum(axis=1)


def positions_of(tree: Tree, dofs: np.ndarray) -> np.ndarray:
    """Return the positions of the joints of poses, both in the tree's order."""
    positions = np.empty((len(dofs), 3 * len(tree.offset)))
    place_all(tree, dofs, positions)
    return positions
