"""Weighted poses under one metric, for the search for their mean or median.

At its current pose, the search needs the distances to all poses of the sample, their gradients, a metric tensor and a
way to take a step. A metric with means returns its own kind of sample from `Metric.sample`.
"""

from typing import NamedTuple

import numpy as np

from skpose.kinematics._chart import retract
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of
from skpose.metrics._direct_means import ExtrinsicMeans
from skpose.skeleton import Skeleton


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

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """The pose where a search starts, in the coordinates of the search and in the columns of the skeleton."""
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

    def __init__(self, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton):
        super().__init__(X, weights)
        self.skeleton, self.tree = skeleton, tree_of(skeleton)
        self.dofs = to_tree_order(self.tree, X)

    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """The extrinsic mean."""
        mean = ExtrinsicMeans(self.X, self.skeleton).mean(self.weights)
        return mean.dofs, mean.pose

    def retract(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """The pose that is a step of the coordinates away."""
        return retract(self.tree, pose, step, self.frees_angles)

    def columns(self, pose: np.ndarray, others: np.ndarray) -> np.ndarray:
        """A pose of the search in the columns of the skeleton; columns that move no joint are copied from `others`."""
        return from_tree_order(self.tree, pose, others)
