"""Logarithms and exponentials: poses as vectors whose lengths are distances, and back."""

from numbers import Integral

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._compat.sklearn import validate_params
from skpose._typing import ArrayLike
from skpose._validation.numbers import as_numbers
from skpose._validation.poses import check_is_array, check_pose, check_poses
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.geodesics._tangent_space import TangentSpace
from skpose.kinematics._shared import counted_joints
from skpose.metrics import Geodesic, Metric
from skpose.metrics._shared import MEAN_CONSTRAINTS, require, require_geodesic, why_no_paths
from skpose.skeleton import Skeleton

LARGEST = 1e100  # velocity whose square is finite, m


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
    r"""Return the first velocities of the geodesics from a pose to others: their logarithms at the pose.

    The logarithm is the vector that points from the base to a pose along the geodesic and is as long as their distance.
    So means, principal components and regressions of vectors become those of poses. It is a velocity of the joints,
    :math:`J_\theta \dot\theta`: what the geodesic does at its first moment, with which it arrives after one unit of
    time.

    Parameters
    ----------
    base : array-like of shape (n_dofs,)
        The pose at which the geodesics begin: joint angles, rad.
    poses : array-like of shape (n_poses, n_dofs)
        The poses at which they end.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="geodesic"
        "geodesic", or a ``skpose.metrics.Geodesic`` with its number of chords, at least two. Both maps must have the
        same.
    n_jobs : int, default=None
        Threads, as in scikit-learn.

    Returns
    -------
    ndarray of shape (n_poses, n_joints, 3)
        Velocities of the joints in the order of ``skeleton.joint_names``, m; zero where a joint has no weight. With
        weights w the length of a logarithm is the square root of Σ w_j ‖v_j‖².

    Raises
    ------
    ValueError
        For poses of the wrong width, out of order by name or not finite.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge: their logarithms are of paths that may not be the shortest. If `exp_map` misses
        poses by more than 0.1 % of the length of their logarithms, with their number and the largest miss, m.
    UserWarning
        If the poses look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    exp_map : The inverse.
    geodesic : The path itself.
    position_jacobian : Velocities of the joints from those of the angles.

    Notes
    -----
    A geodesic is a path of n_steps chords whose second differences are normal to the manifold (eq. 13), found as by
    `geodesic` [1]_ and, where that had to refine it, once more with n_steps chords from there. With P the projection
    onto the tangent space at the base, the logarithm has the direction of P(F(θ₁) − F(θ₀)) and n_steps times the
    length of the first chord [2]_. It is as long as ``pose_distances(..., metric="geodesic")`` says up to the
    discretisation, which more steps make smaller: for ten steps mostly some 0.1 %, and several per cent between very
    different poses, where `geodesic` has to refine the path.

    *Twists.* Where the Jacobian is singular, the angles are no function of the positions: twists of last bones, and
    of straight limbs. So velocities are those of positions, in which a geodesic through a straight knee is smooth.
    At a straight knee the Jacobian knows one plane in which it bends; a twist of the leg moves no joint, and turns that
    plane. So the tangent space is spanned by the velocities of the Jacobian, and by those after such turns.

    *Convergence.* The path of n_steps chords is minimised to where float64 shows no more, so that `exp_map` leads back
    for any n_steps. Where a joint turns by more than 0.1 rad in a step, `exp_map` is followed to see whether it does:
    near straight limbs several geodesics may go on from a pose.

    Some milliseconds a pose, some tens where a geodesic has to be refined, and twice as many where it is followed.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 2.1 and appendix A, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] M. Rumpf, B. Wirth, "Variational time discretization of geodesic calculus", IMA Journal of Numerical Analysis
       35(3), 2015, :doi:`10.1093/imanum/dru027`.

    Examples
    --------
    The hand of an arm of 1 m that rises by 1 rad leaves upwards, with a velocity of 1 m:

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
    r"""Follow geodesics from a pose with given first velocities; return the poses where they are after a unit of time.

    The inverse of `log_map`, by shooting: each pose of the path follows from the two before it.

    Parameters
    ----------
    base : array-like of shape (n_dofs,)
        The pose at which the geodesics begin: joint angles, rad.
    velocities : array-like of shape (n_poses, n_joints, 3)
        Velocities of the joints as `log_map` returns them, m. What the bones do not allow is left out: a velocity is
        projected onto the tangent space.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="geodesic"
        "geodesic", or a ``skpose.metrics.Geodesic`` with its number of chords, at least two. Both maps must have the
        same.
    n_jobs : int, default=None
        Threads, as in scikit-learn.

    Returns
    -------
    ndarray of shape (n_poses, n_dofs)
        Joint angles, rad; near those of the base as numbers of one rotation go. Angles that move no joint keep the
        numbers of the base.

    Raises
    ------
    ValueError
        For a base of the wrong width, out of order by name or not finite; for velocities of the wrong shape or not
        finite.

    Warns
    -----
    ConvergenceWarning
        If the joints cannot follow: they miss a step by more than a millionth of it, as with a velocity too large for
        so few steps.
    UserWarning
        If the base looks like degrees, see `skpose.pose_distances`.

    See Also
    --------
    log_map : The inverse.

    Notes
    -----
    The chord to the next pose and the last one have the same tangential part at the pose between, and the first chord
    is as long as the velocity divided by n_steps [1]_. So ``exp_map(base, log_map(base, X, skeleton), skeleton)`` has
    the joints where X has them, up to some 1e-7 of the distance, for any n_steps. Near straight limbs, where several
    geodesics go on from a pose, it may follow another one; `log_map` warns where that is so. ``benchmarks/tangent.py``
    measures the errors. Angles that move no joint are not those of X.

    Some milliseconds a pose: each chord takes some evaluations of the positions, their Jacobian and eigenvalues of a
    matrix of n_dofs.

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
    check_is_array(velocities, "velocities")
    given = as_numbers(velocities, "velocities")
    expected = (skeleton.n_joints, 3)
    if given.ndim != 3 or given.shape[1:] != expected:
        raise ValueError(f"velocities must have shape (n_poses, {expected[0]}, 3) for this skeleton, got {given.shape}")
    if not (np.abs(given) <= LARGEST).all():  # NaN too
        raise ValueError(f"velocities must be finite numbers below {LARGEST:g} m, got NaN, infinity or a larger one")
    n_steps = require_logarithms(metric, skeleton, "exp_map").n_steps
    space = TangentSpace(skeleton, first, n_steps, effective_n_jobs(n_jobs))
    poses, n_missed = space.exponentials(from_joints(skeleton, given))
    if n_missed:
        warn(
            f"{n_missed} of the {len(poses)} geodesics could not follow their velocities; a larger n_steps than "
            f"{n_steps}, in log_map too, may help",
            ConvergenceWarning,
        )
    return poses


def require_logarithms(metric: str | Metric, skeleton: Skeleton, user: str) -> Geodesic:
    """Return the metric whose geodesics have logarithms: those of angles that are wrapped."""
    chosen = require_geodesic(metric, skeleton, user)
    require(chosen, user, "logarithms of poses", why_no_logarithms)
    return chosen


def why_no_logarithms(metric: Metric) -> str:
    """Return why poses have no logarithms under a metric; empty where they have."""
    if isinstance(metric, Geodesic) and not metric.wrap:
        return "they are those of poses whose differences are wrapped, not of wrap=False"
    return why_no_paths(metric)


def to_joints(skeleton: Skeleton, scaled: np.ndarray) -> np.ndarray:
    """Return velocities of all joints, (..., n_joints, 3), from those of the tangent space, (..., n)."""
    counted = counted_joints(skeleton)
    weights = np.asarray(skeleton.weights)[counted]
    roots = np.where(weights > 0.0, np.sqrt(weights), 1.0)
    out = np.zeros((*scaled.shape[:-1], skeleton.n_joints, 3))
    out[..., counted, :] = scaled.reshape(*scaled.shape[:-1], len(counted), 3) / roots[:, None]
    return out


def from_joints(skeleton: Skeleton, velocities: np.ndarray) -> np.ndarray:
    """Invert `to_joints`."""
    counted = counted_joints(skeleton)
    roots = np.sqrt(np.asarray(skeleton.weights)[counted])
    return (velocities[..., counted, :] * roots[:, None]).reshape(*velocities.shape[:-2], 3 * len(counted))
