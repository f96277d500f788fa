"""Logarithms and exponentials: poses as tangent vectors whose lengths are distances, and back."""

from functools import partial
from numbers import Integral
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._compiled.path.exponential import Logarithms, exponential, logarithms_from
from skpose._utils.parallel import in_threads
from skpose._utils.sklearn import validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import as_numbers, check_pose, check_poses
from skpose._utils.warnings import warn
from skpose.kinematics._forward import weighted_positions
from skpose.kinematics._tree import counted_joints, from_tree_order, to_tree_order, tree_of, wrap_dofs
from skpose.metrics import Geodesic, Metric
from skpose.metrics._registry import MEAN_CONSTRAINTS, require, require_geodesic
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
        velocities = found.velocities[uncertain]
        reached, _ = self.exponentials(velocities)
        between = weighted_positions(reached, self.skeleton) - weighted_positions(poses[uncertain], self.skeleton)
        misses = np.linalg.norm(between, axis=1)
        missed = misses > MISSED * np.linalg.norm(velocities, axis=1) + ROUNDING
        n_unconverged, n_missed = int((~found.converged).sum()), int(missed.sum())
        return FoundLogarithms(found.velocities, n_unconverged, n_missed, float(misses[missed].max(initial=0.0)))

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


@validate_params(
    MEAN_CONSTRAINTS | {"n_jobs": [None, Integral]},
    prefer_skip_nested_validation=True,
)
def log_map(
    base: ArrayLike,
    poses: ArrayLike,
    skeleton: Skeleton,
    *,
    metric: str | Metric = "geodesic",
    n_jobs: int | None = None,
) -> np.ndarray:
    r"""Map poses to tangent vectors at a base pose.

    The logarithm of a pose is the initial velocity of the geodesic from the base that reaches the pose after one unit
    of time. It is as long as their distance, so means, principal components and regressions of these vectors apply to
    poses. It is expressed as the velocity of the joints, :math:`J_\theta \dot\theta`.

    Parameters
    ----------
    base : array-like of shape (n_dofs,)
        Base pose: joint angles, rad.
    poses : array-like of shape (n_poses, n_dofs)
        Poses: joint angles, rad.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="geodesic"
        "geodesic" or a ``skpose.metrics.Geodesic`` object with at least two steps. `log_map` and `exp_map` must use the
        same metric.
    n_jobs : int, default=None
        Number of threads, as in scikit-learn.

    Returns
    -------
    ndarray of shape (n_poses, n_joints, 3)
        Velocities of the joints in the order of ``skeleton.joint_names``, m; zero for joints without weight. With
        weights w the length of a logarithm is √(Σ w_j ‖v_j‖²).

    Raises
    ------
    ValueError
        If poses have the wrong number of columns, their columns are in the wrong order, or they are not finite.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge, so that their paths may not be the shortest, or if `exp_map` misses poses by more
        than 0.1 % of the length of their logarithms.
    UserWarning
        If the poses seem to be in degrees, see `skpose.pose_distances`.

    See Also
    --------
    exp_map : The inverse.
    geodesic : The path itself.
    position_jacobian : Joint velocities from rates of the angles.

    Notes
    -----
    A discrete geodesic is a path of n_steps chords whose second differences are normal to the manifold (eq. 13). It is
    found as in `geodesic` [1]_; if that refined the path, it is minimised once more with n_steps chords. With P the
    projection onto the tangent space at the base, the logarithm has the direction of P(F(θ₁) − F(θ₀)) and n_steps
    times the length of the first chord [2]_. Its length equals the geodesic distance up to the discretisation error,
    which decreases with n_steps: for ten steps typically 0.1 %, and several per cent between very different poses.

    *Twists.* Where the Jacobian is singular, angles are not a function of the positions: twists of end bones and of
    straight limbs. So velocities of positions are used, in which a geodesic through a straight knee is smooth. At a
    straight knee the Jacobian contains one plane of bending, but a twist of the leg, which moves no joint, rotates that
    plane. So the tangent space is spanned by the columns of the Jacobian and those after such twists.

    *Convergence.* The path of n_steps chords is minimised to the precision of float64, so that `exp_map` inverts it for
    any n_steps. If a joint turns by more than 0.1 rad in a step, this is verified with `exp_map`, since several
    geodesics may continue a path near straight limbs.

    A pose takes a few milliseconds, tens of milliseconds if its geodesic is refined, and twice as long if it is
    verified.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 2.1 and appendix A, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] M. Rumpf, B. Wirth, "Variational time discretization of geodesic calculus", IMA Journal of Numerical Analysis
       35(3), 2015, :doi:`10.1093/imanum/dru027`.

    Examples
    --------
    The hand of an arm of 1 m that rises by 1 rad starts upwards, with a velocity of 1 m:

    >>> from skpose import Skeleton
    >>> from skpose.geodesics import exp_map, log_map
    >>> arm = Skeleton.chain(1)
    >>> velocity = log_map([0.0], [[1.0]], arm)
    >>> velocity.round(2) + 0.0
    array([[[0., 1., 0.]]])
    >>> exp_map([0.0], velocity, arm).round(6)
    array([[1.]])
    >>> exp_map([0.0], 0.5 * velocity, arm).round(2)  # half-way
    array([[0.5]])
    """
    first = check_pose(base, skeleton, "base")
    X = check_poses(poses, skeleton, "poses").astype(np.float64)
    warn_of_degrees(None, skeleton, base=first[None], poses=X)
    n_steps = require_logarithms(metric, skeleton, "log_map").n_steps
    space = TangentSpace(skeleton, first, n_steps, effective_n_jobs(n_jobs))
    found = space.logarithms(X)
    found.warn("")
    return to_joints(skeleton, found.velocities)


@validate_params(
    MEAN_CONSTRAINTS | {"n_jobs": [None, Integral]},
    prefer_skip_nested_validation=True,
)
def exp_map(
    base: ArrayLike,
    velocities: ArrayLike,
    skeleton: Skeleton,
    *,
    metric: str | Metric = "geodesic",
    n_jobs: int | None = None,
) -> np.ndarray:
    r"""Map tangent vectors at a base pose to poses.

    The exponential follows the geodesic with a given initial velocity for one unit of time. It is the inverse of
    `log_map`, by shooting: each pose of the path follows from the previous two.

    Parameters
    ----------
    base : array-like of shape (n_dofs,)
        Base pose: joint angles, rad.
    velocities : array-like of shape (n_poses, n_joints, 3)
        Velocities of the joints as returned by `log_map`, m. They are projected onto the tangent space.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="geodesic"
        "geodesic" or a ``skpose.metrics.Geodesic`` object with at least two steps. `log_map` and `exp_map` must use the
        same metric.
    n_jobs : int, default=None
        Number of threads, as in scikit-learn.

    Returns
    -------
    ndarray of shape (n_poses, n_dofs)
        Joint angles, rad, in the representation closest to the base. Angles that move no joint keep the values of the
        base.

    Raises
    ------
    ValueError
        If the base has the wrong length, its columns are in the wrong order, or it is not finite; if velocities have
        the wrong shape or are not finite.

    Warns
    -----
    ConvergenceWarning
        If the joints miss a step by more than a millionth of its length, for example because a velocity is too large
        for the number of steps.
    UserWarning
        If the base seems to be in degrees, see `skpose.pose_distances`.

    See Also
    --------
    log_map : The inverse.

    Notes
    -----
    At every pose of the path, the previous and the next chord have the same tangential part, and the first chord is as
    long as the velocity divided by n_steps [1]_. So ``exp_map(base, log_map(base, X, skeleton), skeleton)`` restores
    the joint positions of X up to about 1e-7 of the distance, for any n_steps. Near straight limbs, where several
    geodesics may continue a path, it may follow a different one; `log_map` warns in this case. Angles that move no
    joint are not restored.

    A pose takes a few milliseconds: each chord needs a few evaluations of positions, Jacobian and eigenvalues.

    References
    ----------
    .. [1] M. Rumpf, B. Wirth, "Variational time discretization of geodesic calculus", IMA Journal of Numerical Analysis
       35(3), 2015, :doi:`10.1093/imanum/dru027`.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.geodesics import exp_map
    >>> arm = Skeleton.chain(2)  # bones of 1 m
    >>> rising = np.array([[[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]]])  # both joints, m
    >>> exp_map([0.0, 0.0], rising, arm).round(2) + 0.0
    array([[1., 0.]])
    """
    first = check_pose(base, skeleton, "base")
    warn_of_degrees(None, skeleton, base=first[None])
    given = as_numbers(velocities, "velocities")
    expected = (skeleton.n_joints, 3)
    if given.ndim != 3 or given.shape[1:] != expected:
        raise ValueError(f"velocities must have shape (n_poses, {expected[0]}, 3), got {given.shape}")
    if not np.isfinite(given).all():
        raise ValueError("velocities must be finite, got NaN or infinity")
    n_steps = require_logarithms(metric, skeleton, "exp_map").n_steps
    space = TangentSpace(skeleton, first, n_steps, effective_n_jobs(n_jobs))
    poses, n_missed = space.exponentials(from_joints(skeleton, given))
    if n_missed:
        warn(
            f"{n_missed} of the {len(poses)} geodesics could not follow their velocities; a larger n_steps than "
            f"{n_steps}, also in log_map, may help",
            ConvergenceWarning,
        )
    return poses


def require_logarithms(metric: str | Metric, skeleton: Skeleton, user: str) -> Geodesic:
    """Check that geodesics under a metric have logarithms."""
    chosen = require_geodesic(metric, skeleton, user)
    require(chosen, user, "wrap=True", chosen.wrap)
    return chosen


def to_joints(skeleton: Skeleton, scaled: np.ndarray) -> np.ndarray:
    """Velocities of all joints, (..., n_joints, 3), from coordinates of the tangent space, (..., n)."""
    counted = counted_joints(skeleton)
    weights = np.asarray(skeleton.weights)[counted]
    roots = np.where(weights > 0.0, np.sqrt(weights), 1.0)
    out = np.zeros((*scaled.shape[:-1], skeleton.n_joints, 3))
    out[..., counted, :] = scaled.reshape(*scaled.shape[:-1], len(counted), 3) / roots[:, None]
    return out


def from_joints(skeleton: Skeleton, velocities: np.ndarray) -> np.ndarray:
    """Inverse of `to_joints`."""
    counted = counted_joints(skeleton)
    roots = np.sqrt(np.asarray(skeleton.weights)[counted])
    return (velocities[..., counted, :] * roots[:, None]).reshape(*velocities.shape[:-2], 3 * len(counted))
