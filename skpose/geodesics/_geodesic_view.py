"""Poses as seen along geodesics: what the intrinsic mean and median need."""

from functools import partial
from typing import NamedTuple

import numpy as np

from skpose._compiled.path.geodesic import GRADIENT_NORM
from skpose._compiled.path.kept_paths import MOST_NODES, Geodesics, KeptPaths, Search, follow_geodesics
from skpose._compiled.pose.tree import Tree
from skpose._parallel.threads import in_threads
from skpose.geodesics._charts import jacobian_at, moved
from skpose.geodesics._descent import Spread, View
from skpose.kinematics._shared import wrapped

TASK = 8  # geodesics; some tens of milliseconds
FIRST_TOL = 1e-5  # norm of the gradient of the first paths, m²/rad
SHARE = 0.04  # of the gradient of the mean, which the error of a path may have


def no_paths(tree: Tree, n: int, n_steps: int) -> KeptPaths:
    """Return room for the paths to n poses, none of which is kept yet."""
    return KeptPaths(
        np.empty((n, MOST_NODES * n_steps + 1, len(tree.column))),  # memory that is not written to is not used
        np.empty((n, len(tree.frame_parent), 4)),
        np.zeros(n, dtype=int),
        np.zeros(n, dtype=int),
    )


def no_geodesics(tree: Tree, n: int) -> Geodesics:
    """Return room for what is computed of the geodesics to n poses."""
    return Geodesics(np.empty(n), np.empty(n), np.empty((n, len(tree.column))), np.empty(n, dtype=bool))


class GeodesicPoses(NamedTuple):
    """Poses, in the tree's order, and the geodesics to them from where they were seen last."""

    tree: Tree
    dofs: np.ndarray  # (n_poses, n_dofs)
    weights: np.ndarray  # (n_poses,) of sum 1
    n_steps: int
    wrap: bool
    n_jobs: int
    kept: KeptPaths

    @property
    def is_uneven(self) -> bool:
        """Return whether distances change by jumps."""
        return True

    @classmethod
    def of(
        cls, tree: Tree, dofs: np.ndarray, weights: np.ndarray, n_steps: int, wrap: bool, n_jobs: int
    ) -> "GeodesicPoses":
        """Return the poses without any geodesics."""
        return cls(tree, dofs, weights, n_steps, wrap, n_jobs, no_paths(tree, len(dofs), n_steps))

    def view_from(self, pose: np.ndarray, slope: float) -> View:
        """Compute the geodesics from a pose to all poses, as well as the gradient so far needs them."""
        tree, n = self.tree, len(self.dofs)
        found = no_geodesics(tree, n)
        ends = wrapped(tree, self.dofs, pose[None]) if self.wrap else self.dofs
        tol = max(GRADIENT_NORM, SHARE * slope / self.n_steps) if np.isfinite(slope) else FIRST_TOL
        search = Search(self.n_steps, self.wrap, tol, 0.0)
        in_threads(
            (
                partial(follow_geodesics, tree, pose, ends, i, min(i + TASK, n), search, self.kept, found)
                for i in range(0, n, TASK)
            ),
            self.n_jobs,
        )
        jacobian = jacobian_at(tree, pose, self.wrap)
        return View(
            found.lengths, found.energies, found.gradients, jacobian.T @ jacobian, int((~found.converged).sum())
        )

    def moved(self, pose: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return a pose that is a step of its coordinates away from another one."""
        return moved(self.tree, pose, step, self.wrap)

    def measured_again(self, spread: Spread, power: int) -> Spread:
        """Return the spread with the distances that `pose_distances` finds, for those along paths that are refined.

        A path that was refined at one pose stays so at the next, where a new one may need no refinement. Its length is
        then by some 0.1 % another.
        """
        rows = np.flatnonzero(self.kept.substeps > 1)
        if not len(rows):
            return spread
        anew = GeodesicPoses.of(
            self.tree, self.dofs[rows], self.weights[rows], self.n_steps, self.wrap, self.n_jobs
        ).view_from(spread.pose, 0.0)
        lengths = spread.lengths.copy()
        lengths[rows] = anew.lengths
        return spread._replace(value=float(self.weights @ lengths**power))
