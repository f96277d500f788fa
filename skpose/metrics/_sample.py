"""Weighted poses under one metric: what the search for their mean or median asks of the metric.

The search stands at one pose. There it needs the distances to all poses of the sample, their gradients, and a metric
tensor that says how long a step is; and it needs to step. A metric that has means returns such a sample of its own from
`Metric.sample`.
"""

from typing import NamedTuple

import numpy as np

from skpose.kinematics._shared import from_tree_order, retract, to_tree_order, tree_of
from skpose.metrics._direct_means import ExtrinsicMeans
from skpose.skeleton import Skeleton


class Linearization(NamedTuple):
    """The distances from one pose to the poses of a sample, to first order."""

    lengths: np.ndarray  # (n_poses,) distances
    energies: np.ndarray  # (n_poses,) their squares, or squares of other lengths that they approach
    gradients: np.ndarray  # (n_poses, n) of half the energies by the coordinates of the one pose
    tensor: np.ndarray  # (n, n) the metric tensor there
    n_unconverged: int = 0  # distances that are not to be trusted


class Sample:
    """Poses of weight, in float64, under one metric.

    Attributes
    ----------
    X : ndarray of shape (n_poses, n_dofs)
        The poses, in the columns of the skeleton.
    dofs : ndarray of shape (n_poses, n)
        The same in the coordinates of the search.
    weights : ndarray of shape (n_poses,)
        Of sum 1.
    is_uneven : bool
        Whether distances change by jumps, as where a path is refined at one pose and not at the next.
    """

    is_uneven = False

    def __init__(self, X: np.ndarray, weights: np.ndarray):
        self.X, self.weights = X, weights
        self.dofs = X

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the pose where a search starts, and the same in the columns of the skeleton."""
        raise NotImplementedError

    def linearize(self, pose: np.ndarray, slope: float) -> Linearization:
        """Return the distances to first order; a slope is the norm of the gradient that was found before it, or inf."""
        raise NotImplementedError

    def retract(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a pose that is a step of its coordinates away from another one."""
        return pose + step

    def columns(self, pose: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return a pose of the search in the columns of the skeleton; what moves no joint is as in the others."""
        return pose

    def remeasure(self, pose: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return the distances from the last pose of a search as `pose_distances` has them."""
        return lengths

    def sum_along(self, x: np.ndarray, pose: np.ndarray, steps: np.ndarray, power: int) -> tuple[float, np.ndarray]:
        """Return the sum of powers of distances, and its gradient, at a pose plus steps (n, k) times x (k,).

        For metrics without gradients, as `best_pose`.
        """
        raise NotImplementedError

    def best_pose(self, power: int) -> tuple[np.ndarray, float]:
        """Return the pose with the least sum to all, of some of the given ones, and that sum."""
        raise NotImplementedError


class JointSample(Sample):
    """Poses whose joints are placed by a skeleton, in the tree's order.

    `frees_angles` is whether joints of three angles are moved as rotations, and not by their angles.
    """

    frees_angles = True

    def __init__(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton):
        super().__init__(X, weights)
        self.skeleton, self.tree = skeleton, tree_of(skeleton)
        self.dofs = to_tree_order(self.tree, X)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the extrinsic mean."""
        mean = ExtrinsicMeans(self.X, self.skeleton).mean(self.weights)
        return mean.dofs, mean.pose

    def retract(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a pose that is a step of its coordinates away from another one."""
        return retract(self.tree, pose, step, self.frees_angles)

    def columns(self, pose: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Return a pose of the search in the columns of the skeleton; what moves no joint is as in the others."""
        return from_tree_order(self.tree, pose, others)
