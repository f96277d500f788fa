"""Fréchet means and geometric medians of poses, which are poses: bones keep their lengths."""

from dataclasses import dataclass, field
from functools import partial
from numbers import Integral, Real

import numpy as np
from joblib import effective_n_jobs
from sklearn.exceptions import ConvergenceWarning

from skpose._utils.parallel import in_threads
from skpose._utils.sklearn import Interval, check_sample_weight, validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses
from skpose._utils.warnings import warn
from skpose.geodesics._descent import MEAN, MEDIAN, Spread, descend, minimise_sum
from skpose.metrics import Metric, Position
from skpose.metrics._means import TOL as TOL_EXTRINSIC, FrechetMeanResult, Sample, some_of
from skpose.metrics._registry import MEAN_CONSTRAINTS, require_means, resolve
from skpose.skeleton import Skeleton

CONSTRAINTS = MEAN_CONSTRAINTS | {
    "sample_weight": ["array-like", None],
    "max_iter": [Interval(Integral, 1, None, closed="left")],
    "tol": [Interval(Real, 0, None, closed="left")],
    "n_jobs": [None, Integral],
}

FEW, TRIAL_ITER = 64, 10  # poses whose mean is searched from each start, and iterations
LOWER = 1e-3  # relative difference of variances for which a later start is taken
MAX_ITER, TOL = 200, 1e-3  # as in `frechet_mean`
TOL_DIRECT = 1e-6  # norm of the gradient where no search from pose to pose is needed, m²/rad


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
    All means except the mean of the columns are local minima. The search for the extrinsic mean starts at the pose of X
    nearest to the mean of the positions, whose values angles that move no joint keep. No pose has a lower variance than
    the positions have about their mean. If the extrinsic mean exceeds that by 5 %, as for poses far apart, it is
    searched from the mean step from that pose and from three poses of X, too. Other metrics start at the extrinsic
    mean. For poses far apart, and always under "rotation", there are several starts: the extrinsic mean and all of
    those. Ten iterations from each, on up to 64 poses of X, which `n_iter` and `max_iter` do not count, find the best
    one; a `max_iter` of ten or less leaves them out. Small bones, such as those of hands, may fold where that brings
    their ends nearer. Limits are not enforced.

    *"position"* uses Newton's method with a trust region: less than a millisecond per iteration for any number of
    poses.

    *"geodesic"* takes about ten iterations with a geodesic to each pose. Each step is the mean logarithm, damped,
    combined with earlier steps by Anderson acceleration [4]_, and halved until it brings the poses nearer. Paths are
    kept and updated when the mean moves: a pose takes one to a few milliseconds per iteration, more if its path is
    refined. Logarithms come from geodesics of n_steps chords, with an error of about 0.1 % of their length.

    *"rotation"* uses the same steps, with the mean of the rotations between corresponding bones.

    *"spatial"* is not smooth: the line, and its length, jumps if a difference of angles passes half a turn. So scipy's
    BFGS with a line search is used, which never returns anything worse than its start or the best of up to a hundred
    poses of X. Poses within half a turn of each other have no jumps; for others expect a ConvergenceWarning.

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
    X, weights, chosen = _check(X, skeleton, metric, sample_weight, "frechet_mean")
    mean = WeightedMeans(X, skeleton, chosen, n_jobs).mean(weights, max_iter, tol, TOL_EXTRINSIC)
    if not mean.converged:
        warn(
            f"the mean did not converge in {mean.n_iter} iterations (gradient_norm {mean.gradient_norm:.2g}): raise "
            "max_iter, or n_steps of the metric",
            ConvergenceWarning,
        )
    return mean


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
    X, weights, chosen = _check(X, skeleton, metric, sample_weight, "geometric_median")
    n_threads = effective_n_jobs(n_jobs)
    sample = chosen.sample(X, weights, skeleton, n_threads)
    (start, *_), others = sample.starts()
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


def _check(
    X: ArrayLike, skeleton: Skeleton, metric: str | Metric, sample_weight: ArrayLike | None, user: str
) -> tuple[np.ndarray, np.ndarray, Metric]:
    """Poses of positive weight, their weights, which sum to 1, and the metric."""
    X = check_poses(X, skeleton, "X").astype(np.float64)
    warn_of_degrees(None, skeleton, X=X)
    weights = check_sample_weight(sample_weight, X)
    weights = weights / weights.max()  # avoids overflow of the sum
    weights = weights / weights.sum()
    counted = weights > 0.0
    chosen = resolve(metric, skeleton, auto="position")
    require_means(chosen, user)
    return X[counted], weights[counted], chosen


def minimise(
    metric: Metric, sample: Sample, start: np.ndarray, power: int, max_iter: int, tol: float
) -> tuple[Spread, int, bool]:
    """The mean or median from a start, the number of iterations, and whether it converged."""
    search = descend if metric.has_gradients else minimise_sum
    spread, n_iter, converged = search(sample, start, power, max_iter, tol)
    lengths = sample.remeasure(spread.pose, spread.lengths)
    return spread._replace(value=float(sample.weights @ lengths**power)), n_iter, bool(converged)


class WeightedMeans:
    """Poses and their Fréchet means under any weighting.

    Parameters
    ----------
    poses : ndarray of shape (n_poses, n_dofs)
        Validated poses, rad.
    skeleton : Skeleton or None
        The skeleton of the poses; None for a metric that needs none.
    metric : Metric
        The metric.
    n_jobs : int or None
        Number of threads.
    """

    def __init__(self, poses: np.ndarray, skeleton: Skeleton | None, metric: Metric, n_jobs: int | None):
        self.poses = poses.astype(np.float64, copy=False)
        self.skeleton, self.metric, self.n_jobs = skeleton, metric, n_jobs
        self._direct = metric.direct_means(self.poses, skeleton)

    def mean(
        self, weights: np.ndarray, max_iter: int = MAX_ITER, tol: float = TOL, tol_direct: float = TOL_DIRECT
    ) -> FrechetMeanResult:
        """The mean under non-negative weights (n_poses,)."""
        if self._direct is not None:
            return self._direct.mean(weights, max_iter, tol_direct)
        counted = weights > 0.0
        shares, n_threads = weights[counted] / weights.sum(), effective_n_jobs(self.n_jobs)
        sample = self.metric.sample(self.poses[counted], shares, self.skeleton, n_threads)
        starts, others = sample.starts()
        start = starts[0]
        if len(starts) > 1 and max_iter > TRIAL_ITER:
            trial = self.metric.sample(*some_of(sample.X, shares, FEW), self.skeleton, n_threads)
            ends = [minimise(self.metric, trial, one, MEAN, TRIAL_ITER, tol)[0] for one in starts]
            least = min(end.value for end in ends)
            start = next(end.pose for end in ends if end.value <= least * (1.0 + LOWER))
        spread, n_iter, converged = minimise(self.metric, sample, start, MEAN, max_iter, tol)
        return FrechetMeanResult(sample.columns(spread.pose, others), spread.value, spread.norm, n_iter, converged)

    def means(self, weightings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means (n_means, n_dofs) under non-negative weightings (n_means, n_poses), and which converged."""
        means = np.empty((len(weightings), self.poses.shape[1]))
        converged = np.ones(len(weightings), dtype=bool)

        def find(i: int) -> None:
            counted = np.flatnonzero(weightings[i])
            if len(counted) == 1:
                means[i] = self.poses[counted[0]]
            else:
                found = self.mean(weightings[i])
                means[i], converged[i] = found.pose, found.converged

        # Iterative means run one after the other, each on all threads.
        n_threads = 1 if self._direct is None else effective_n_jobs(self.n_jobs)
        in_threads((partial(find, i) for i in range(len(weightings))), n_threads)
        return means, converged
