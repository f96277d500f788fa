"""Poses as seen under the metrics whose distances have a formula: what their means and medians need."""

from typing import NamedTuple

import numpy as np

from skpose._compiled.pose.tree import TWO_PI, Steps
from skpose.geodesics._charts import STEP, columns_around, jacobian_at, moved
from skpose.geodesics._descent import View
from skpose.kinematics._shared import from_tree_order, to_tree_order, tree_of, weighted_positions
from skpose.metrics._shared import METRICS
from skpose.skeleton import Skeleton

NO_STEPS = Steps.of(1, False)  # positions and orientations have no line


class AnglePoses(NamedTuple):
    """Poses under "angle": points whose coordinates are the columns; wrapped ones are points of a torus."""

    dofs: np.ndarray  # (n_poses, n_dofs)
    weights: np.ndarray  # (n_poses,) of sum 1
    wrap: bool

    @property
    def is_uneven(self) -> bool:
        """Return whether distances change by jumps."""
        return False

    def start(self) -> np.ndarray:
        """Return the weighted arithmetic mean of the columns, of wrapped ones the mean direction."""
        if self.wrap:
            return np.arctan2(self.weights @ np.sin(self.dofs), self.weights @ np.cos(self.dofs))
        return self.weights @ self.dofs

    def view_from(self, pose: np.ndarray, slope: float) -> View:
        """Return distances and gradients, both exact."""
        gaps = pose - self.dofs
        if self.wrap:
            gaps -= TWO_PI * np.rint(gaps / TWO_PI)
        energies = (gaps**2).sum(axis=1)
        return View(np.sqrt(energies), energies, gaps, np.eye(len(pose)), 0)

    def moved(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return the sum."""
        return pose + step


class PositionPoses(NamedTuple):
    """Poses under "position", in the tree's order."""

    dofs: np.ndarray  # (n_poses, n_tree_dofs)
    weights: np.ndarray  # (n_poses,) of sum 1
    X: np.ndarray  # (n_poses, n_dofs) the same in the columns of the skeleton
    positions: np.ndarray  # (n_poses, 3 n_joints) of the joints, scaled, m
    skeleton: Skeleton

    @property
    def is_uneven(self) -> bool:
        """Return whether distances change by jumps."""
        return False

    @classmethod
    def of(cls, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton) -> "PositionPoses":
        """Place the joints of the poses."""
        return cls(to_tree_order(tree_of(skeleton), X), weights, X, weighted_positions(X, skeleton), skeleton)

    def view_from(self, pose: np.ndarray, slope: float) -> View:
        """Return distances and gradients, both exact."""
        tree = tree_of(self.skeleton)
        at = weighted_positions(from_tree_order(tree, pose, self.X[0])[None], self.skeleton)
        gaps, jacobian = at - self.positions, jacobian_at(tree, pose, True)
        energies = (gaps**2).sum(axis=1)
        return View(np.sqrt(energies), energies, gaps @ jacobian, jacobian.T @ jacobian, 0)

    def moved(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a pose that is a step of its coordinates away from another one."""
        return moved(tree_of(self.skeleton), pose, step, True)


class RotationPoses(NamedTuple):
    """Poses under "rotation", in the tree's order."""

    dofs: np.ndarray  # (n_poses, n_tree_dofs)
    weights: np.ndarray  # (n_poses,) of sum 1
    X: np.ndarray  # (n_poses, n_dofs) the same in the columns of the skeleton
    orientations: np.ndarray  # (n_poses, n_frames, 4) unit quaternions, scalar first
    skeleton: Skeleton

    @property
    def is_uneven(self) -> bool:
        """Return whether distances change by jumps."""
        return False

    @classmethod
    def of(cls, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton) -> "RotationPoses":
        """Orient the bones of the poses."""
        return cls(to_tree_order(tree_of(skeleton), X), weights, X, _orientations(X, skeleton), skeleton)

    def view_from(self, pose: np.ndarray, slope: float) -> View:
        """Return distances, and gradients by the angular velocities of the bones, exact to some 1e-10."""
        n = len(pose)
        columns = columns_around(
            tree_of(self.skeleton), pose, np.zeros(n), STEP * np.eye(n), self.X[0], frees_angles=True
        )
        at, plus, minus = np.split(_orientations(columns, self.skeleton), [1, 1 + n])
        turns = turns_between(at, self.orientations)
        speeds = turns_between(minus, plus) / (2.0 * STEP)
        scale = tree_of(self.skeleton).weight[1:, None]
        energies = (scale * turns**2).sum(axis=(1, 2))
        gradients = -np.tensordot(turns, scale * speeds, axes=([1, 2], [1, 2]))
        tensor = np.tensordot(speeds, scale * speeds, axes=([1, 2], [1, 2]))
        return View(np.sqrt(energies), energies, gradients, tensor, 0)

    def moved(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a pose that is a step of its coordinates away from another one."""
        return moved(tree_of(self.skeleton), pose, step, True)


def _orientations(X: np.ndarray, skeleton: Skeleton) -> np.ndarray:
    """Return the world orientations of the bones, (n_poses, n_frames, 4), quaternions."""
    return METRICS["rotation"].encoded(X, skeleton, NO_STEPS).reshape(len(X), -1, 4)


def turns_between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the rotation vectors (..., 3) from quaternions to others, at most π long, in the axes of the first."""
    real = (first * second).sum(axis=-1, keepdims=True)
    vector = first[..., :1] * second[..., 1:] - second[..., :1] * first[..., 1:]
    vector -= np.cross(first[..., 1:], second[..., 1:])
    size = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(size, np.abs(real))
    # q and −q are one rotation; of a tiny turn the vector is half of it.
    return np.copysign(1.0, real) * vector * np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 0.0)
