"""Means of poses that are poses: bones keep their lengths."""

from dataclasses import dataclass

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose._compat.sklearn import validate_params
from skpose._typing import ArrayLike
from skpose._validation.poses import check_poses
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.geodesics._descent import MEAN
from skpose.geodesics._weighted_poses import CONSTRAINTS, WeightedPoses, minimise
from skpose.metrics import Metric
from skpose.metrics._shared import require_means, resolve
from skpose.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class FrechetMeanResult:
    """A mean of poses, as `frechet_mean` finds it.

    Attributes
    ----------
    pose : ndarray of shape (n_dofs,)
        The mean: joint angles, rad.
    variance : float
        Mean of the squared distances to it, m²; rad² for "angle".
    gradient_norm : float
        How far it is from being stationary. For "position" the norm of the gradient of the variance, m²/rad. For other
        metrics the length of the mean logarithm of the poses, m, rad for "angle": half that gradient, measured in the
        metric tensor.
    n_iter : int
        Iterations.
    converged : bool
        Whether `gradient_norm` came down to what `tol` asks, or to what is possible: to what float64 can show, and for
        "geodesic" and "spatial" to 2 % of the standard deviation, as new paths at the next pose leave the variance
        uneven. And whether all geodesics converged.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.geodesics import frechet_mean
    >>> frechet_mean([[0.0], [1.0]], Skeleton.chain(1)).pose.round(3)
    array([0.5])
    """

    pose: np.ndarray
    variance: float
    gradient_norm: float
    n_iter: int
    converged: bool

    def __repr__(self) -> str:
        state = "converged" if self.converged else "not converged"
        return f"FrechetMeanResult(variance={self.variance:.4g}, {state} in {self.n_iter} iterations)"


@validate_params(CONSTRAINTS, prefer_skip_nested_validation=True)
def frechet_mean(
    X: ArrayLike,
    skeleton: Skeleton,
    *,
    metric: str | Metric = "position",
    sample_weight: ArrayLike | None = None,
    max_iter: int = 200,
    tol: float = 1e-3,
    n_jobs: int | None = None,
) -> FrechetMeanResult:
    r"""Return the pose with the least mean squared distance to given poses.

    The mean of the joint *positions* is no pose: its limbs are too short (figure 1 (b) of the paper). This one is a
    pose, since only poses are considered: :math:`\arg\min_\theta \sum_i w_i \, d(\theta, \theta_i)^2` with d

    - "position": the *extrinsic* mean, the pose nearest to the mean of the positions, as
      :math:`\arg\min_\theta \sum_i w_i \|F(\theta) - F(\theta_i)\|^2` equals
      :math:`\arg\min_\theta \|F(\theta) - \sum_i w_i F(\theta_i)\|^2`.
    - "geodesic": the *intrinsic* (Karcher) mean, d the geodesic distance, eq. 3.
    - "rotation": the mean of the world orientations of the bones.
    - "spatial": d the length of the straight line.
    - "angle": the arithmetic mean of the columns, as other tools have it.

    Parameters
    ----------
    X : array-like of shape (n_poses, n_dofs)
        Joint angles, rad.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="position"
        The distance, see `pose_distances`: one that has means. "auto" is "position". Under ``Angle(wrap=True)`` the
        mean is one of directions.
    sample_weight : array-like of shape (n_poses,), default=None
        Weights of the poses, which are divided by their sum; None is equal ones. Poses of weight zero are left out,
        and cost nothing.
    max_iter : int, default=200
        Iterations at most.
    tol : float, default=1e-3
        Length of the mean logarithm of the poses at which the mean has converged, relative to the standard deviation.
        The extrinsic mean goes to a gradient of 1e-9 m²/rad.
    n_jobs : int, default=None
        Threads for distances and geodesics, as in scikit-learn.

    Returns
    -------
    FrechetMeanResult
        The pose, the variance, and how far to trust it.

    Raises
    ------
    ValueError
        For poses of the wrong width, out of order by name or not finite; for weights that are negative or all zero; for
        a metric that has no means.

    Warns
    -----
    ConvergenceWarning
        If it did not converge, with the reason. It is then still a pose, and for "position" no farther than the nearest
        given pose.
    UserWarning
        If the poses look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    geometric_median : The pose with the least mean distance, which is robust to outliers.
    geodesic : The shortest path from pose to pose.
    Skeleton.mean : The mean of several skeletons.

    Notes
    -----
    All but the mean of the columns are local minima. The extrinsic mean starts at the given pose that is nearest to the
    mean of the positions, and the others start at the extrinsic mean. Angles that move no joint stay as they are at
    the start, so poses are not unique where positions are; limits are not enforced.

    *"position"* takes Newton's method in a trust region: well under a millisecond an iteration, for any number of
    poses.

    *"geodesic"* takes a geodesic to each pose in each of some ten iterations. The step is the mean of the logarithms,
    as for every Karcher mean, damped, combined with those before as D. G. Anderson does [4]_, and halved while it
    brings the poses no nearer. Each path is kept, and is minimised from where it was when the mean moves: one or a
    few milliseconds a pose and iteration, and more where a path has to be refined. The first search takes a few
    milliseconds, some tens where poses are far apart. The logarithms are those of geodesics of n_steps chords, which
    makes an error of some 0.1 % of their length.

    *"rotation"* takes the same steps, along the mean of the rotations from each bone to those of the poses.

    *"spatial"* is not smooth everywhere. Where a difference of angles is half a turn, the line jumps to another one,
    and its length with it. So scipy's BFGS with a line search finds the mean, from the extrinsic one or from one of a
    hundred given poses where that is better, and never one that is worse than these. Poses within half a turn of each
    other have no such jumps. Where they have, expect a ConvergenceWarning.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 2 and figure 1 (b), :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] H. Karcher, "Riemannian center of mass and mollifier smoothing", Communications on Pure and Applied
       Mathematics 30(5), 1977, :doi:`10.1002/cpa.3160300502`.
    .. [3] R. Bhattacharya, V. Patrangenaru, "Large sample theory of intrinsic and extrinsic sample means on
       manifolds", Annals of Statistics 31(1), 2003, :doi:`10.1214/aos/1046294456`.
    .. [4] H. F. Walker, P. Ni, "Anderson acceleration for fixed-point iterations", SIAM Journal on Numerical Analysis
       49(4), 2011, :doi:`10.1137/10078356X`.

    Examples
    --------
    An arm that swings up and down: the mean of its positions would be 0.84 m long.

    >>> import numpy as np
    >>> from skpose import Skeleton, forward_kinematics
    >>> from skpose.geodesics import frechet_mean
    >>> arm = Skeleton.chain(1)
    >>> X = np.linspace(-1, 1, 101)[:, None]
    >>> float(np.linalg.norm(forward_kinematics(X, arm).mean(axis=0)).round(2))
    0.84
    >>> mean = frechet_mean(X, arm)
    >>> (mean.pose.round(6) + 0.0).tolist(), round(mean.variance, 3)
    ([0.0], 0.323)
    >>> round(frechet_mean(X, arm, metric="geodesic").variance, 3)  # that of the angle, for a bone of 1 m
    0.34
    """
    X = check_poses(X, skeleton, "X").astype(np.float64)
    warn_of_degrees(None, skeleton, X=X)
    weighted, chosen = WeightedPoses.of(X, skeleton, sample_weight), resolve(metric, skeleton, auto="position")
    require_means(chosen, "frechet_mean")
    direct = chosen.direct_means(weighted.X, skeleton)
    if direct is not None:
        found = direct.mean(weighted.weights, max_iter)
        reason = "" if found.converged else _reason(found.n_iter, max_iter)
        mean = FrechetMeanResult(found.pose, found.variance, found.gradient_norm, found.n_iter, not reason)
    else:
        sample = weighted.sample(chosen, n_jobs)
        start, others = sample.start()
        spread, n_iter, reason = minimise(chosen, sample, start, MEAN, max_iter, tol)
        pose = sample.columns(spread.pose, others)
        mean = FrechetMeanResult(pose, spread.value, spread.norm, n_iter, not reason)
    if reason:
        warn(
            f"the mean did not converge, its gradient_norm is {mean.gradient_norm:.2g}, but it is a pose: {reason}",
            ConvergenceWarning,
        )
    return mean


def _reason(n_iter: int, max_iter: int) -> str:
    """Return why the extrinsic mean did not converge, and the remedy."""
    if n_iter >= max_iter:
        return f"it was still moving after max_iter={max_iter} iterations; raise max_iter"
    return f"after {n_iter} iterations no step brought it nearer; a larger max_iter does not help"
