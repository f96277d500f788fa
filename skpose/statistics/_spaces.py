"""Spaces of vectors at a base pose, in which principal components are found: one for each metric of `PoseTangentPCA`.

`SPACES` has the metrics under which poses have vectors. A space has `vectors` of poses, whose Euclidean lengths are
distances from the base; `steps`, directions in the space as what `move` takes; and `motions`, the same as velocities of
the joints. Its base is the `mean` that belongs to it.
"""

from typing import Any, NamedTuple, Protocol

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._warnings import warn
from skpose.geodesics import frechet_mean
from skpose.geodesics._shared import TangentSpace, to_joints, why_no_logarithms
from skpose.kinematics._shared import jacobians_of, tree_of_all_joints
from skpose.metrics import Angle, Geodesic, Metric, Position
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import mean_of_joints, move, skeleton_at, steps_from


class Space(Protocol):
    """Vectors at a base pose."""

    @staticmethod
    def why_not(metric: Any) -> str:
        """Return why poses have no such vectors under a metric with these parameters; empty where they have."""

    @staticmethod
    def mean(X: np.ndarray, skeleton: Any, metric: Any, n_jobs: int | None) -> np.ndarray:
        """Return the mean of poses, at which their vectors are short."""

    @classmethod
    def at(cls, pose: np.ndarray, skeleton: Any, metric: Any, n_jobs: int | None) -> "Space":
        """Return the space at a base pose."""

    def vectors(self, X: np.ndarray) -> np.ndarray:
        """Return the vectors (n_poses, n) of poses."""

    def steps(self, X: np.ndarray, mixing: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return directions (k, n) as steps; they are the vectors of X in the proportions `mixing`, (n_poses, k)."""

    def motions(self, steps: np.ndarray) -> np.ndarray:
        """Return steps as velocities of the joints, (k, 3 n_joints), or of the columns without a skeleton."""

    def move(self, steps: np.ndarray) -> np.ndarray:
        """Return the poses at steps from the base."""


class Columns(NamedTuple):
    """Numbers as they are: the space of scikit-learn's PCA."""

    pose: np.ndarray

    @staticmethod
    def why_not(metric: Angle) -> str:
        return "angles that are wrapped are points of a torus" if metric.wrap else ""

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton | None, metric: Angle, n_jobs: int | None) -> np.ndarray:
        return X.mean(axis=0)

    @classmethod
    def at(cls, pose: np.ndarray, skeleton: Skeleton | None, metric: Angle, n_jobs: int | None) -> "Columns":
        return cls(pose)

    def vectors(self, X: np.ndarray) -> np.ndarray:
        return X - self.pose

    def steps(self, X: np.ndarray, mixing: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return directions

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return steps

    def move(self, steps: np.ndarray) -> np.ndarray:
        return self.pose + steps


class Lines(NamedTuple):
    """Positions along straight lines from the base, to first order: F ≈ F₀ + J δ.

    Steps δ have twists, which J does not show. A component has those that its poses have on average.
    """

    skeleton: Skeleton
    pose: np.ndarray

    @staticmethod
    def why_not(metric: Position) -> str:
        return ""

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton, metric: Position, n_jobs: int | None) -> np.ndarray:
        """Return the joint-wise mean of poses."""
        mean, converged = mean_of_joints(skeleton.bones, X)
        if not converged:
            warn(
                "the joint-wise mean of the poses did not converge, as the rotations of a joint spread over half a "
                "turn or more; it is a pose, but the components are about another one than the mean",
                ConvergenceWarning,
            )
        return mean

    @classmethod
    def at(cls, pose: np.ndarray, skeleton: Skeleton, metric: Position, n_jobs: int | None) -> "Lines":
        return cls(skeleton, pose)

    def jacobian(self) -> np.ndarray:
        """Return the velocities of all joints, (3 n_joints, n_dofs), by the numbers of steps."""
        skeleton, pose = skeleton_at(self.skeleton, self.pose)
        return jacobians_of(pose[None], tree_of_all_joints(skeleton))[0]

    def vectors(self, X: np.ndarray) -> np.ndarray:
        roots = np.repeat(np.sqrt(self.skeleton.weights), 3)
        return steps_from(self.skeleton.bones, self.pose, X) @ (roots[:, None] * self.jacobian()).T

    def steps(self, X: np.ndarray, mixing: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return mixing.T @ steps_from(self.skeleton.bones, self.pose, X)

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return steps @ self.jacobian().T

    def move(self, steps: np.ndarray) -> np.ndarray:
        return move(self.skeleton.bones, self.pose, steps)


class Geodesics(NamedTuple):
    """Logarithms: the first velocities of geodesics."""

    space: TangentSpace

    @staticmethod
    def why_not(metric: Geodesic) -> str:
        return why_no_logarithms(metric)

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton, metric: Geodesic, n_jobs: int | None) -> np.ndarray:
        return frechet_mean(X, skeleton, metric=metric, n_jobs=n_jobs).pose

    @classmethod
    def at(cls, pose: np.ndarray, skeleton: Skeleton, metric: Geodesic, n_jobs: int | None) -> "Geodesics":
        return cls(TangentSpace(skeleton, pose, metric.n_steps, effective_n_jobs(n_jobs)))

    def vectors(self, X: np.ndarray) -> np.ndarray:
        found = self.space.logarithms(X)
        found.warn(" from the mean")
        return found.velocities

    def steps(self, X: np.ndarray, mixing: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return directions

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return to_joints(self.space.skeleton, steps).reshape(len(steps), -1)

    def move(self, steps: np.ndarray) -> np.ndarray:
        poses, n_missed = self.space.exponentials(steps)
        if n_missed:
            warn(
                f"{n_missed} of the {len(steps)} poses are too far from the mean for n_steps={self.space.n_steps}: the "
                "joints cannot reach where a step would lead them; raise n_steps, and fit again",
                ConvergenceWarning,
            )
        return poses


SPACES: dict[type[Metric], type[Space]] = {Angle: Columns, Position: Lines, Geodesic: Geodesics}


def why_no_vectors(metric: Metric) -> str:
    """Return why poses have no vectors under a metric; empty where they have."""
    space = SPACES.get(type(metric))
    return "no vectors are known whose lengths are its distances" if space is None else space.why_not(metric)
