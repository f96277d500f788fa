"""The geometric median of poses: a centre that far poses do not move."""

from dataclasses import dataclass

import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose._compat.sklearn import validate_params
from skpose._typing import ArrayLike
from skpose._validation.poses import check_poses
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.geodesics._descent import MEDIAN, descend
from skpose.geodesics._weighted_poses import CONSTRAINTS, WeightedPoses, minimise
from skpose.metrics import Metric, Position
from skpose.metrics._shared import require_means, resolve
from skpose.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class GeometricMedianResult:
    """A median of poses, as `geometric_median` finds it.

    Attributes
    ----------
    pose : ndarray of shape (n_dofs,)
        The median: joint angles, rad.
    deviation : float
        Mean of the distances to it, m; rad for "angle".
    gradient_norm : float
        How far it is from being stationary: length of the mean of the unit vectors towards the poses, between 0 and 1;
        where the median is one of the poses, what exceeds that pose's weight.
    n_iter : int
        Iterations.
    converged : bool
        Whether `gradient_norm` came down to `tol`, or no step brought the poses nearer from where it is at most 2 %,
        and for "geodesic" whether all geodesics converged.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.geodesics import geometric_median
    >>> geometric_median([[0.0], [0.1], [2.0]], Skeleton.chain(1)).pose.round(3)
    array([0.1])
    """

    pose: np.ndarray
    deviation: float
    gradient_norm: float
    n_iter: int
    converged: bool

    def __repr__(self) -> str:
        state = "converged" if self.converged else "not converged"
        return f"GeometricMedianResult(deviation={self.deviation:.4g}, {state} in {self.n_iter} iterations)"


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
    r"""Return the pose with the least mean distance to given poses: a robust mean.

    .. math:: \arg\min_\theta \sum_i w_i \, d(\theta, \theta_i)

    A mean follows every outlier, such as frames where tracking failed, in proportion to its distance. The median is
    moved no more by a far pose than by a near one: it stays among the others while less than half of the weight is far
    from them [1]_.

    Parameters
    ----------
    X : array-like of shape (n_poses, n_dofs)
        Joint angles, rad.
    skeleton : Skeleton
        The skeleton of the poses.
    metric : str or Metric, default="position"
        The distance d, see `pose_distances`: one that has means. "auto" is "position".
    sample_weight : array-like of shape (n_poses,), default=None
        Weights of the poses, which are divided by their sum; None is equal ones. Poses of weight zero are left out,
        and cost nothing.
    max_iter : int, default=200
        Iterations at most.
    tol : float, default=1e-3
        Length of the mean of the unit vectors towards the poses at which the median has converged.
    n_jobs : int, default=None
        Threads for distances, as in scikit-learn.

    Returns
    -------
    GeometricMedianResult
        The pose, the mean distance, and how far to trust it.

    Raises
    ------
    ValueError
        For poses of the wrong width, out of order by name or not finite; for weights that are negative or all zero.

    Warns
    -----
    ConvergenceWarning
        If it did not converge, with the reason. It is then still a pose.
    UserWarning
        If the poses look like degrees, see `skpose.pose_distances`.

    See Also
    --------
    frechet_mean : The pose with the least mean squared distance.
    MedoidShift : Medoids, which are given poses, and clusters.

    Notes
    -----
    Weiszfeld's iteration, on manifolds [1]_: each step is that of a mean with weights w/d, and successive steps are
    combined as Anderson does, which takes fewer. A pose that the iterate comes close to is tried itself, and is the
    median if its weight exceeds the pull of the others [2]_. It starts at the extrinsic mean for "position", at the
    arithmetic mean of the columns for "angle", and for other metrics at the median under "position". What is found is a
    local minimum, no worse than the start; see `frechet_mean` for what a local minimum means for each metric, and for
    the cost of an iteration.

    References
    ----------
    .. [1] P. T. Fletcher, S. Venkatasubramanian, S. Joshi, "The geometric median on Riemannian manifolds with
       application to robust atlas estimation", NeuroImage 45(1), 2009, :doi:`10.1016/j.neuroimage.2008.10.052`.
    .. [2] Y. Vardi, C.-H. Zhang, "The multivariate L1-median and associated data depth", PNAS 97(4), 2000,
       :doi:`10.1073/pnas.97.4.1423`.

    Examples
    --------
    An arm that hangs, and three of ten frames where it was tracked wrongly:

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
    weighted, chosen = WeightedPoses.of(X, skeleton, sample_weight), resolve(metric, skeleton, auto="position")
    require_means(chosen, "geometric_median")
    sample = weighted.sample(chosen, n_jobs)
    start, others = sample.start()
    if chosen.needs_skeleton and chosen != Position():
        start = descend(weighted.sample(Position(), n_jobs), start, MEDIAN, max_iter, tol)[0].pose
    spread, n_iter, reason = minimise(chosen, sample, start, MEDIAN, max_iter, tol)
    pose = sample.columns(spread.pose, others)
    median = GeometricMedianResult(pose, spread.value, spread.norm, n_iter, not reason)
    if reason:
        warn(
            f"the median did not converge, its gradient_norm is {median.gradient_norm:.2g}, but it is a pose: {reason}",
            ConvergenceWarning,
        )
    return median
