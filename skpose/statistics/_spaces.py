"""Vector spaces at a base pose for `PoseTangentPCA`, one for each metric in `SPACES`.

The methods of a space:

- `mean`: the base, a mean of poses.
- `vectors`: vectors (n_poses, n) of poses, as long as the distances from the base.
- `steps`: directions (k, n) as steps for `move`. Directions are combinations `mixing` (n_poses, k) of the vectors of X.
- `motions`: steps as velocities of the joints (k, 3 n_joints), or of the columns without a skeleton.
- `move`: the poses at steps from the base.
"""

from typing import Any

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._utils.warnings import warn
from skpose.geodesics import frechet_mean
from skpose.geodesics._logarithm import TangentSpace, to_joints
from skpose.kinematics._forward import jacobians_of
from skpose.kinematics._tree import tree_of_all_joints
from skpose.metrics import Angle, Geodesic, Metric, Position
from skpose.skeleton import Skeleton
from skpose.skeleton._chart import mean_of_joints, move, skeleton_at, steps_from


class Space:
    """A vector space at a base pose."""

    def __init__(self, pose: np.ndarray, skeleton: Skeleton | None, metric: Any, n_jobs: int | None):
        self.pose, self.skeleton, self.metric, self.n_jobs = pose, skeleton, metric, n_jobs

    def steps(self, X: np.ndarray, mixing: np.ndarray, directions: np.ndarray) -> np.ndarray:
        return directions

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return steps


class Columns(Space):
    """Columns as they are, as in scikit-learn's PCA."""

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton | None, metric: Angle, n_jobs: int | None) -> np.ndarray:
        return X.mean(axis=0)

    def vectors(self, X: np.ndarray) -> np.ndarray:
        return X - self.pose

    def move(self, steps: np.ndarray) -> np.ndarray:
        return self.pose + steps


class Lines(Space):
    """Positions to first order along straight lines from the base, F ≈ F₀ + J δ.

    Steps δ include twists that move no joint; components get the average twists of their poses.
    """

    skeleton: Skeleton

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton, metric: Position, n_jobs: int | None) -> np.ndarray:
        mean, converged = mean_of_joints(skeleton.bones, X)
        if not converged:
            warn(
                "the joint-wise mean did not converge, as rotations of a joint spread over half a turn or more",
                ConvergenceWarning,
            )
        return mean

    def jacobian(self) -> np.ndarray:
        """Jacobian (3 n_joints, n_dofs) of the positions with respect to steps."""
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


class Geodesics(Space):
    """Logarithms at the base."""

    skeleton: Skeleton

    @staticmethod
    def mean(X: np.ndarray, skeleton: Skeleton, metric: Geodesic, n_jobs: int | None) -> np.ndarray:
        return frechet_mean(X, skeleton, metric=metric, n_jobs=n_jobs).pose

    @property
    def tangent_space(self) -> TangentSpace:
        return TangentSpace(self.skeleton, self.pose, self.metric.n_steps, effective_n_jobs(self.n_jobs))

    def vectors(self, X: np.ndarray) -> np.ndarray:
        found = self.tangent_space.logarithms(X)
        found.warn(" from the mean")
        return found.velocities

    def motions(self, steps: np.ndarray) -> np.ndarray:
        return to_joints(self.skeleton, steps).reshape(len(steps), -1)

    def move(self, steps: np.ndarray) -> np.ndarray:
        poses, n_missed = self.tangent_space.exponentials(steps)
        if n_missed:
            warn(
                f"{n_missed} of the {len(steps)} poses are too far from the mean for n_steps={self.metric.n_steps}: "
                "fit with a larger n_steps",
                ConvergenceWarning,
            )
        return poses


SPACES: dict[type[Metric], Any] = {Angle: Columns, Position: Lines, Geodesic: Geodesics}


def has_vectors(metric: Metric) -> bool:
    """Whether distances under a metric are lengths of vectors; wrapped angles are points of a torus."""
    if type(metric) is Geodesic:
        return metric.has_means and metric.wrap
    return type(metric) in SPACES and metric.lower_bound() == metric
