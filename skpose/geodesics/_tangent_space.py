"""The tangent space at a pose: logarithms and exponentials of many poses, and whether they lead back."""

from functools import partial
from typing import NamedTuple

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.path.exponential import Logarithms, exponential, logarithms_from
from skpose._compiled.pose.tree import Tree
from skpose._parallel.threads import in_threads
from skpose._warnings import warn
from skpose.kinematics._shared import from_tree_order, to_tree_order, tree_of, weighted_positions, wrap_dofs
from skpose.skeleton import Skeleton

TASK = 8  # poses; some tens of milliseconds
NOT_MET = 1e-6  # error of a chord of an exponential, relative to its length, that is worth a warning
NOTHING = 1e-12  # distance that is rounding, m
# Error of where exp_map(log_map) leads, relative to the length of the logarithm, that is worth a warning: as large as
# the error of that length by n_steps chords.
MISSED = 1e-3
# Largest turn of a joint in one step, rad, up to which the exponential finds the next pose: those that meet the same
# tangential part are farther.
UNIQUE = 0.1


class FoundLogarithms(NamedTuple):
    """Logarithms of poses, and how reliable they are."""

    velocities: np.ndarray  # (n_poses, n) of the tangent space
    n_unconverged: int  # geodesics that did not converge
    n_missed: int  # poses to which `exp_map` does not lead back
    farthest: float  # by how much it misses these at most, by the metric "position", m

    def warn(self, origin: str) -> None:
        """Warn of what is not reliable; the origin says which base it is, if not that of `log_map`."""
        n = len(self.velocities)
        if self.n_unconverged:
            warn(
                f"{self.n_unconverged} of the {n} geodesics{origin} did not converge, so that their logarithms may not "
                "be those of the shortest paths; a larger n_steps may help",
                ConvergenceWarning,
            )
        if self.n_missed:
            warn(
                f"{self.n_missed} of the {n} logarithms{origin} do not lead back: exp_map misses their poses by up to "
                f"{self.farthest:.2g} m, by metric='position'. Their geodesics pass poses from which several geodesics "
                "go on, as near straight limbs; a larger n_steps, or a base nearer to these poses, may help",
                ConvergenceWarning,
            )


class TangentSpace(NamedTuple):
    """The tangent space at a pose: velocities of the positions that count, times the square roots of their weights."""

    skeleton: Skeleton
    pose: np.ndarray  # (n_dofs,) columns of the skeleton
    n_steps: int
    n_jobs: int

    @property
    def tree(self) -> Tree:
        return tree_of(self.skeleton)

    def logarithms(self, poses: np.ndarray) -> FoundLogarithms:
        """Return the logarithms of poses; those that may not lead back are followed."""
        tree = self.tree
        base, n = to_tree_order(tree, self.pose), len(poses)
        ends = wrap_dofs(tree, to_tree_order(tree, poses), base[None])
        found = Logarithms(np.empty((n, 3 * len(tree.offset) - 3)), np.empty(n, dtype=bool), np.empty(n))
        in_threads(
            (
                partial(logarithms_from, tree, base, ends, i, min(i + TASK, n), self.n_steps, found)
                for i in range(0, n, TASK)
            ),
            self.n_jobs,
        )
        uncertain = np.flatnonzero(~(found.turns <= UNIQUE))
        misses = self._misses(poses[uncertain], found.velocities[uncertain]) if len(uncertain) else np.empty(0)
        n_unconverged, n_missed = int((~found.converged).sum()), int((misses > 0.0).sum())
        return FoundLogarithms(found.velocities, n_unconverged, n_missed, float(misses.max(initial=0.0)))

    def _misses(self, poses: np.ndarray, velocities: np.ndarray) -> np.ndarray:
        """Return how far from poses their logarithms lead, m; zero where that is near enough."""
        reached, _ = self.exponentials(velocities)
        between = weighted_positions(reached, self.skeleton) - weighted_positions(poses, self.skeleton)
        misses = np.linalg.norm(between, axis=1)
        return np.where(misses <= MISSED * np.linalg.norm(velocities, axis=1) + NOTHING, 0.0, misses)

    def exponentials(self, velocities: np.ndarray) -> tuple[np.ndarray, int]:
        """Return the poses at velocities, (n_poses, n_dofs), and how many geodesics could not follow them."""
        tree = self.tree
        base = to_tree_order(tree, self.pose)
        dofs, errors = np.empty((len(velocities), len(base))), np.empty(len(velocities))

        def follow(i: int) -> None:
            dofs[i], errors[i] = exponential(tree, base, velocities[i], self.n_steps)

        in_threads((partial(follow, i) for i in range(len(velocities))), self.n_jobs)
        poses = from_tree_order(tree, dofs, np.tile(self.pose, (len(velocities), 1)))
        return poses, int((~(errors <= NOT_MET)).sum())  # NaN too
