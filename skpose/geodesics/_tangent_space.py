"""The tangent space at a pose: logarithms and exponentials of many poses."""

from functools import partial
from typing import NamedTuple

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.path.exponential import Logarithms, exponential, logarithms_from
from skpose._utils.parallel import in_threads
from skpose._utils.warnings import warn
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import from_tree_order, to_tree_order, tree_of, wrap_dofs
from skpose.skeleton import Skeleton

TASK = 8  # poses per task, tens of milliseconds
NOT_MET = 1e-6  # relative error of a chord of an exponential above which to warn
ROUNDING = 1e-12  # m
MISSED = 1e-3  # relative error of exp_map(log_map) above which to warn; as large as the discretisation error
UNIQUE = 0.1  # turn of a joint in one step, rad, up to which the next pose of an exponential is unique


class FoundLogarithms(NamedTuple):
    """Logarithms of poses and their reliability."""

    velocities: np.ndarray  # (n_poses, n) coordinates of the tangent space
    n_unconverged: int  # geodesics that did not converge
    n_missed: int  # poses that `exp_map` misses
    farthest: float  # largest miss under "position", m

    def warn(self, origin: str) -> None:
        """Warn of unreliable logarithms; the origin names the base in the message."""
        n = len(self.velocities)
        if self.n_unconverged:
            warn(
                f"{self.n_unconverged} of the {n} geodesics{origin} did not converge; a larger n_steps may help",
                ConvergenceWarning,
            )
        if self.n_missed:
            warn(
                f"exp_map misses {self.n_missed} of the {n} poses{origin} by up to {self.farthest:.2g} m; a larger "
                "n_steps or a closer base may help",
                ConvergenceWarning,
            )


class TangentSpace(NamedTuple):
    """The tangent space at a pose: velocities of joint positions, scaled by the square roots of the weights."""

    skeleton: Skeleton
    pose: np.ndarray  # (n_dofs,)
    n_steps: int
    n_jobs: int

    def logarithms(self, poses: np.ndarray) -> FoundLogarithms:
        """Logarithms of poses; doubtful ones are verified with the exponential."""
        tree = tree_of(self.skeleton)
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
        """Distances between poses and the exponentials of their logarithms, m; zero within the tolerance."""
        reached, _ = self.exponentials(velocities)
        between = weighted_positions(reached, self.skeleton) - weighted_positions(poses, self.skeleton)
        misses = np.linalg.norm(between, axis=1)
        return np.where(misses <= MISSED * np.linalg.norm(velocities, axis=1) + ROUNDING, 0.0, misses)

    def exponentials(self, velocities: np.ndarray) -> tuple[np.ndarray, int]:
        """Poses (n_poses, n_dofs), and the number of geodesics that could not follow their velocities."""
        tree = tree_of(self.skeleton)
        base = to_tree_order(tree, self.pose)
        dofs, errors = np.empty((len(velocities), len(base))), np.empty(len(velocities))

        def follow(i: int) -> None:
            dofs[i], errors[i] = exponential(tree, base, velocities[i], self.n_steps)

        in_threads((partial(follow, i) for i in range(len(velocities))), self.n_jobs)
        poses = from_tree_order(tree, dofs, np.tile(self.pose, (len(velocities), 1)))
        return poses, int((~(errors <= NOT_MET)).sum())  # counts NaN
