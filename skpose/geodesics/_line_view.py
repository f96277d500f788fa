"""Poses as seen along straight lines, for means and medians under "spatial"; gradients are taken by differences."""

from typing import NamedTuple

import numpy as np

from skpose._compiled.pose.tree import Steps
from skpose.geodesics._charts import STEP, columns_around, jacobian_at, moved
from skpose.geodesics._descent import View
from skpose.kinematics._shared import to_tree_order, tree_of
from skpose.metrics._shared import DistanceMatrix
from skpose.skeleton import Skeleton

TWIST = 1e-2  # of the mean of the metric tensor's diagonal, for dofs that move no joint
SOME = 100  # poses whose metric tensors are averaged, and at which a search may start


class LinePoses(NamedTuple):
    """Poses under "spatial", in the tree's order.

    Joints with three angles are moved by these angles, since they are what the line is straight in.
    """

    dofs: np.ndarray  # (n_poses, n_tree_dofs)
    weights: np.ndarray  # (n_poses,) of sum 1
    X: np.ndarray  # (n_poses, n_dofs) the same in the columns of the skeleton
    skeleton: Skeleton
    steps: Steps
    n_jobs: int
    mean_tensor: np.ndarray  # (n_tree_dofs, n_tree_dofs) mean of JᵀJ at the poses

    @property
    def is_uneven(self) -> bool:
        """Return whether distances change by jumps."""
        return False

    @classmethod
    def of(cls, X: np.ndarray, weights: np.ndarray, skeleton: Skeleton, steps: Steps, n_jobs: int) -> "LinePoses":
        """Return poses of the skeleton's columns."""
        tree = tree_of(skeleton)
        dofs = to_tree_order(tree, X)
        tensor, rows = np.zeros((dofs.shape[1], dofs.shape[1])), _some(X)
        for row in rows:
            jacobian = jacobian_at(tree, dofs[row], False)
            tensor += jacobian.T @ jacobian / len(rows)
        return cls(dofs, weights, X, skeleton, steps, n_jobs, tensor)

    def view_from(self, pose: np.ndarray, slope: float) -> View:
        """Measure the distances from the pose, and from those a little more and less along each coordinate."""
        n = len(pose)
        energies = self._distances_around(pose, np.zeros(n), STEP * np.eye(n)) ** 2
        gradients = (energies[1 : n + 1] - energies[n + 1 :]).T / (4.0 * STEP)
        return View(np.sqrt(energies[0]), energies[0], gradients, self._tensor(pose), 0)

    def sum_along(self, x: np.ndarray, pose: np.ndarray, steps: np.ndarray, power: int) -> tuple[float, np.ndarray]:
        """Return the sum of powers of distances, and its gradient, at a pose plus steps (n_dofs, n) times x (n,)."""
        n = len(x)
        sums = self._distances_around(pose, steps @ x, STEP * steps.T) ** power @ self.weights
        return float(sums[0]) / power, (sums[1 : n + 1] - sums[n + 1 :]) / (2.0 * power * STEP)

    def best_pose(self, power: int) -> tuple[np.ndarray, float]:
        """Return the pose with the least sum to all, of some of the given ones, and that sum."""
        rows = _some(self.X)
        sums = self._distances(self.X[rows]) ** power @ self.weights
        return self.dofs[rows[sums.argmin()]], float(sums.min())

    def _distances_around(self, pose: np.ndarray, step: np.ndarray, shifts: np.ndarray) -> np.ndarray:
        """Return the distances from the pose that is a step away, and from those a shift more and less."""
        return self._distances(columns_around(tree_of(self.skeleton), pose, step, shifts, self.X[0], False))

    def _distances(self, columns: np.ndarray) -> np.ndarray:
        matrix = DistanceMatrix(columns, self.X, "spatial", self.skeleton, self.steps)
        return matrix.written(None, self.n_jobs)[0]

    def _tensor(self, pose: np.ndarray) -> np.ndarray:
        """Return the metric tensor of short steps, as it is at the pose and at the given ones."""
        jacobian = jacobian_at(tree_of(self.skeleton), pose, False)
        tensor = 0.5 * (jacobian.T @ jacobian + self.mean_tensor)
        # A twist that moves no joint moves the lines to other poses.
        return tensor + TWIST * np.trace(tensor) / len(pose) * np.eye(len(pose))

    def moved(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a pose that is a step of its coordinates away from another one."""
        return moved(tree_of(self.skeleton), pose, step, False)


def _some(X: np.ndarray) -> np.ndarray:
    """Return the rows of some of the poses, the same poses in any order of the rows."""
    shares = np.linspace(0, len(X) - 1, min(len(X), SOME))
    return np.lexsort(X.T)[np.unique(shares.astype(int))]
