"""The geometric median of poses, which is robust to outliers."""

from dataclasses import dataclass, field

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._utils.sklearn import validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses
from skpose._utils.warnings import warn
from skpose.geodesics._descent import MEDIAN, descend
from skpose.geodesics._weighted_poses import CONSTRAINTS, minimise, positive_weights
from skpose.metrics import Metric, Position
from skpose.metrics._registry import require_means, resolve
from skpose.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class GeometricMedianResult:
    """A median of poses, as returned by `geometric_median`.

    Attributes
    ----------
    pose : ndarray of shape (n_dofs,)
        The median: joint angles, rad.
    deviation : float
        Mean of the distances to the median, m; rad for "angle".
    gradient_norm : float
        Distance from a stationary point: length of the mean of the unit vectors towards the poses, between 0 and 1. If
        the median is one of the poses, the excess over the weight of that pose.
    n_iter : int
        Number of iterations.
    converged : bool
        Whether `gradient_norm` reached `tol`, or is at most 2 % and no step lowered the objective. For "geodesic" all
        geodesics must have converged, too.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.geodesics import geometric_median
    >>> geometric_median([[0.0], [0.1], [2.0]], Skeleton.chain(1)).pose.round(3)
    array([0.1])
    """

    pose: np.ndarray = field(repr=False)
    deviation: float
    gradient_norm: float
    n_iter: int
    converged: bool


@validate_params(CONSTRAINTS, prefer_skip_nested_validation=True)
def geometric_median(
    X: ArrayLike,
    skeleton: Skeleton,
    *,
    metric: str | Metric = "position",
    sample_weight: ArrayLike | None = None,
    max_iter: int = 200,
    tol: float = 1e-3,
    n_jobs: int | None = None,
) -> GeometricMedianResult:
    r"""Compute the pose with the least mean distance to a set of poses: a robust mean.

    .. math:: \arg\min_\theta \sum_i w_i \, d(\theta, \theta_i)

    A mean follows every outlier, such as frames where tracking failed, in proportion to its distance. A distant pose
    affects the median no more than a close one, as long as outliers carry less than half of the weight [1]_.

    Parameters
    ----------
    X : array-like of shape (n_poses, n_dofs)
        Joint angles, rad.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="position"
        The metric d, see `pose_distances`. "auto" is "position".
    sample_weight : array-like of shape (n_poses,), default=None
        Weights of the poses, normalised to sum 1. None means equal weights.
    max_iter : int, default=200
        Maximum number of iterations.
    tol : float, default=1e-3
        Length of the mean of the unit vectors towards the poses at convergence.
    n_jobs : int, default=None
        Number of threads, as in scikit-learn.

    Returns
    -------
    GeometricMedianResult
        The pose, the mean distance and convergence information.

    Raises
    ------
    ValueError
        If poses have the wrong number of columns, their columns are in the wrong order, or they are not finite; if
        weights are negative or all zero.

    Warns
    -----
    ConvergenceWarning
        If the median did not converge. It is still a pose.
    UserWarning
        If the poses seem to be in degrees, see `skpose.pose_distances`.

    See Also
    --------
    frechet_mean : The pose with the least mean squared distance.
    MedoidShift : Clusters around medoids.

    Notes
    -----
    Weiszfeld's iteration on manifolds [1]_: each step is a step of the mean with weights w/d. Anderson acceleration
    combines successive steps. If the iterate comes close to a pose of X, that pose is tried; it is the median if its
    weight exceeds the pull of the others [2]_. The search starts at the extrinsic mean for "position", at the
    arithmetic mean of the columns for "angle", and at the median under "position" for other metrics. The result is a
    local minimum, no worse than the start; `frechet_mean` describes the cost per metric.

    References
    ----------
    .. [1] P. T. Fletcher, S. Venkatasubramanian, S. Joshi, "The geometric median on Riemannian manifolds with
       application to robust atlas estimation", NeuroImage 45(1), 2009, :doi:`10.1016/j.neuroimage.2008.10.052`.
    .. [2] Y. Vardi, C.-H. Zhang, "The multivariate L1-median and associated data depth", PNAS 97(4), 2000,
       :doi:`10.1073/pnas.97.4.1423`.

    Examples
    --------
    A hanging arm, tracked wrongly in three of ten frames:

    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.geodesics import frechet_mean, geometric_median
    >>> X = np.append(np.linspace(-0.1, 0.1, 7), [1.5, 1.6, 1.7])[:, None]
    >>> arm = Skeleton.chain(1)
    >>> median = geometric_median(X, arm)
    >>> float(median.pose[0].round(2)), float(frechet_mean(X, arm).pose[0].round(2))
    (0.03, 0.41)
    """
    X = check_poses(X, skeleton, "X").astype(np.float64)
    warn_of_degrees(None, skeleton, X=X)
    X, weights = positive_weights(X, sample_weight)
    chosen, n_threads = resolve(metric, skeleton, auto="position"), effective_n_jobs(n_jobs)
    require_means(chosen, "geometric_median")
    sample = chosen.sample(X, weights, skeleton, n_threads)
    start, others = sample.start()
    if chosen.needs_skeleton and chosen != Position():
        start = descend(Position().sample(X, weights, skeleton, n_threads), start, MEDIAN, max_iter, tol)[0].pose
    spread, n_iter, converged = minimise(chosen, sample, start, MEDIAN, max_iter, tol)
    pose = sample.columns(spread.pose, others)
    if not converged:
        warn(
            f"the median did not converge in {n_iter} iterations (gradient_norm {spread.norm:.2g}): raise max_iter, or "
            "n_steps of the metric",
            ConvergenceWarning,
        )
    return GeometricMedianResult(pose, spread.value, spread.norm, n_iter, converged)
