"""Fréchet means of poses, which are poses: bones keep their lengths."""

from dataclasses import dataclass, field

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._utils.sklearn import validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses
from skpose._utils.warnings import warn
from skpose.geodesics._descent import MEAN
from skpose.geodesics._weighted_poses import CONSTRAINTS, minimise, positive_weights
from skpose.metrics import Metric
from skpose.metrics._registry import require_means, resolve
from skpose.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class FrechetMeanResult:
    """A mean of poses, as returned by `frechet_mean`.

    Attributes
    ----------
    pose : ndarray of shape (n_dofs,)
        The mean: joint angles, rad.
    variance : float
        Mean of the squared distances to the mean, m²; rad² for "angle".
    gradient_norm : float
        Distance from a stationary point. For "position" the norm of the gradient of the variance, m²/rad. For other
        metrics the length of the mean logarithm of the poses, m (rad for "angle"): half the norm of the gradient in the
        metric tensor.
    n_iter : int
        Number of iterations.
    converged : bool
        Whether `gradient_norm` reached `tol` or the precision of float64, and all geodesics converged. For "geodesic"
        and "spatial", whose variance is uneven, 2 % of the standard deviation is enough.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.geodesics import frechet_mean
    >>> frechet_mean([[0.0], [1.0]], Skeleton.chain(1)).pose.round(3)
    array([0.5])
    """

    pose: np.ndarray = field(repr=False)
    variance: float
    gradient_norm: float
    n_iter: int
    converged: bool


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
    r"""Compute the pose with the least mean squared distance to a set of poses.

    The mean of joint *positions* is not a pose: its limbs are too short (figure 1 (b) of the paper). The Fréchet mean
    is the pose :math:`\arg\min_\theta \sum_i w_i \, d(\theta, \theta_i)^2`, where d depends on the metric:

    - "position": the *extrinsic* mean, the pose nearest to the mean of the positions, since
      :math:`\arg\min_\theta \sum_i w_i \|F(\theta) - F(\theta_i)\|^2` equals
      :math:`\arg\min_\theta \|F(\theta) - \sum_i w_i F(\theta_i)\|^2`.
    - "geodesic": the *intrinsic* (Karcher) mean under the geodesic distance, eq. 3.
    - "rotation": the mean of the world orientations of the bones.
    - "spatial": the mean under the length of the straight line.
    - "angle": the arithmetic mean of the columns.

    Parameters
    ----------
    X : array-like of shape (n_poses, n_dofs)
        Joint angles, rad.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="position"
        A metric of poses, see `pose_distances`. "auto" is "position". ``Angle(wrap=True)`` gives the mean of
        directions.
    sample_weight : array-like of shape (n_poses,), default=None
        Weights of the poses, normalised to sum 1. None means equal weights.
    max_iter : int, default=200
        Maximum number of iterations.
    tol : float, default=1e-3
        Length of the mean logarithm at convergence, relative to the standard deviation. The extrinsic mean instead
        stops at a gradient of 1e-9 m²/rad.
    n_jobs : int, default=None
        Number of threads, as in scikit-learn.

    Returns
    -------
    FrechetMeanResult
        The pose, the variance and convergence information.

    Raises
    ------
    ValueError
        If poses have the wrong number of columns, their columns are in the wrong order, or they are not finite; if
        weights are negative or all zero; if the metric has no means.

    Warns
    -----
    ConvergenceWarning
        If the mean did not converge. It is still a pose, and for "position" at least as near as the nearest pose of X.
    UserWarning
        If the poses seem to be in degrees, see `skpose.pose_distances`.

    See Also
    --------
    geometric_median : The pose with the least mean distance, robust to outliers.
    geodesic : The shortest path between two poses.
    Skeleton.mean : The mean of several skeletons.

    Notes
    -----
    All means except the mean of the columns are local minima. The extrinsic mean starts at the pose of X nearest to the
    mean of the positions, all others at the extrinsic mean. Angles that move no joint keep the values of the start.
    Limits are not enforced.

    *"position"* uses Newton's method with a trust region: less than a millisecond per iteration for any number of
    poses.

    *"geodesic"* takes about ten iterations with a geodesic to each pose. Each step is the mean logarithm, damped,
    combined with earlier steps by Anderson acceleration [4]_, and halved until it brings the poses nearer. Paths are
    kept and updated when the mean moves: a pose takes one to a few milliseconds per iteration, more if its path is
    refined. Logarithms come from geodesics of n_steps chords, with an error of about 0.1 % of their length.

    *"rotation"* uses the same steps, with the mean of the rotations between corresponding bones.

    *"spatial"* is not smooth: the line, and its length, jumps if a difference of angles passes half a turn. So scipy's
    BFGS with a line search is used, from the extrinsic mean or the best of up to a hundred poses of X, and never
    returns anything worse than these. Poses within half a turn of each other have no jumps; for others expect a
    ConvergenceWarning.

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
    An arm of 1 m swings up and down. The mean of its positions would be 0.84 m long:

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
    >>> round(frechet_mean(X, arm, metric="geodesic").variance, 3)  # the variance of the angle
    0.34
    """
    X = check_poses(X, skeleton, "X").astype(np.float64)
    warn_of_degrees(None, skeleton, X=X)
    X, weights = positive_weights(X, sample_weight)
    chosen = resolve(metric, skeleton, auto="position")
    require_means(chosen, "frechet_mean")
    direct = chosen.direct_means(X, skeleton)
    if direct is not None:
        found = direct.mean(weights, max_iter)
        mean = FrechetMeanResult(found.pose, found.variance, found.gradient_norm, found.n_iter, found.converged)
    else:
        sample = chosen.sample(X, weights, skeleton, effective_n_jobs(n_jobs))
        start, others = sample.start()
        spread, n_iter, converged = minimise(chosen, sample, start, MEAN, max_iter, tol)
        pose = sample.columns(spread.pose, others)
        mean = FrechetMeanResult(pose, spread.value, spread.norm, n_iter, converged)
    if not mean.converged:
        warn(
            f"the mean did not converge in {mean.n_iter} iterations (gradient_norm {mean.gradient_norm:.2g}): raise "
            "max_iter, or n_steps of the metric",
            ConvergenceWarning,
        )
    return mean
