"""Regression with poses as targets: weighted Fréchet means of the training poses around a query."""

from numbers import Integral, Real
from typing import ClassVar

import numpy as np
from joblib import effective_n_jobs
from scipy.spatial.distance import cdist
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.exceptions import ConvergenceWarning, UndefinedMetricWarning
from sklearn.utils import gen_batches
from sklearn.utils.validation import check_consistent_length, check_is_fitted, validate_data

from skpose._base import POSE_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.progress import progress
from skpose._utils.sklearn import Interval, StrOptions, check_sample_weight, fit_context
from skpose._utils.units import warn_of_degrees
from skpose._utils.validation import check_poses
from skpose._utils.warnings import warn
from skpose.geodesics._mean import WeightedMeans
from skpose.metrics._matrix import paired_distances
from skpose.metrics._registry import require_means, warn_of_no_skeleton

EQUAL = 1e-9  # rounding error of predicted angles, rad
WEIGHTS = 1 << 21  # weights in memory at once
NEGLIGIBLE = 1e-6  # weight, relative to the largest, that counts as zero


class PoseKernelRegressor(PoseEstimatorMixin, RegressorMixin, BaseEstimator):
    r"""Kernel regression with poses as targets.

    The prediction at x is the Fréchet mean of the training poses with Gaussian weights: the Nadaraya–Watson estimator
    for targets on a manifold [1]_ [2]_,

    .. math:: \hat y(x) = \arg\min_\theta \sum_i w_i \, e^{-\gamma \|x - x_i\|^2} \, d(\theta, y_i)^2

    Predictions are poses, so bones keep their lengths, and they do not depend on the Euler order of a file (except
    under "angle").

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of the target poses. Required by all metrics except "angle".
    gamma : "scott" or float, default="scott"
        The γ of the kernel, as in `sklearn.kernel_ridge.KernelRidge`, in the inverse squared unit of X. The larger, the
        fewer training poses count; zero weights all equally. "scott" uses Scott's rule [3]_, :math:`1 / 2h^2` with
        :math:`h^2 = \sigma^2 n^{-2/(p + 4)}` for n distinct rows of p columns with mean variance σ². Scale columns of
        different units with `sklearn.preprocessing.StandardScaler`.
    n_neighbors : int, default=None
        Number of nearest training rows to use, including ties. None uses all rows.
    metric : str or Metric, default="auto"
        The distance d between poses, see `skpose.pose_distances`. "auto" is "position" with a skeleton, else "angle"
        (the mean of the columns) with a warning.
    n_jobs : int, default=None
        Number of threads, as in scikit-learn. It does not change predictions.
    verbose : int, default=0
        Whether to show progress during prediction.

    Attributes
    ----------
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use.
    y_fit_ : ndarray of shape (n_samples_fit, n_dofs)
        The training poses with positive weight.
    gamma_ : float
        The γ in use.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    frechet_mean : The mean of poses.
    sklearn.neighbors.KNeighborsRegressor : A similar regressor for vectors.

    Notes
    -----
    Features may be any numbers: phase or time, positions of some joints, sensors, coordinates from `SpatialMDS`. Tune
    the parameters with `sklearn.model_selection.GridSearchCV`; `score` is the explained share of variance under the
    metric.

    A query far from all training rows gets the pose of the nearest row, since weights are computed relative to the
    largest. Weights below a millionth of the largest count as zero. Predictions do not extrapolate.

    Under "position" a prediction takes O(n_samples_fit · n_joints) and a few Newton iterations. Under "rotation",
    "spatial" and "geodesic" every iteration measures distances to all training poses with positive weight, which is
    much slower: choose a small `n_neighbors`. Memory O(n_samples_fit) plus 16 MB for weights.

    References
    ----------
    .. [1] B. C. Davis, P. T. Fletcher, E. Bullitt, S. Joshi, "Population shape regression from random design data",
       International Journal of Computer Vision 90, 2010, :doi:`10.1007/s11263-010-0367-1`.
    .. [2] B. Pelletier, "Non-parametric regression estimation on closed Riemannian manifolds", Journal of
       Nonparametric Statistics 18(1), 2006, :doi:`10.1080/10485250500504828`.
    .. [3] D. W. Scott, "Multivariate density estimation", Wiley 1992, :doi:`10.1002/9780470316849`.

    Examples
    --------
    Poses of a generated walk as a function of time:

    >>> import numpy as np
    >>> from skpose.statistics import PoseKernelRegressor
    >>> from skpose.datasets import make_gait
    >>> walk = make_gait(1, 1, activities=["walk"], duration=4, frame_rate=30, random_state=0)[0]
    >>> time = np.arange(len(walk.angles))[:, None] / walk.frame_rate
    >>> model = PoseKernelRegressor(walk.skeleton, gamma=200.0).fit(time[::4], walk.angles[::4])
    >>> model.predict([[1.01]]).shape
    (1, 48)
    >>> round(model.score(time, walk.angles), 2)
    0.98
    """

    _auto_metric = "position"
    _parameter_constraints: ClassVar[dict] = {
        **POSE_CONSTRAINTS,
        "gamma": [StrOptions(["scott"]), Interval(Real, 0, None, closed="left")],
        "n_neighbors": [Interval(Integral, 1, None, closed="left"), None],
    }

    def __init__(
        self,
        skeleton=None,
        *,
        gamma="scott",
        n_neighbors=None,
        metric="auto",
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.gamma = gamma
        self.n_neighbors = n_neighbors
        self.metric = metric
        self.n_jobs = n_jobs
        self.verbose = verbose

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y, sample_weight=None):
        """Store the training poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Features.
        y : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad; (n_samples,) for one dof.
        sample_weight : array-like of shape (n_samples,), default=None
            Non-negative weights of the samples, not all zero. None means equal weights. A weight of two is equivalent
            to repeating the sample.

        Returns
        -------
        PoseKernelRegressor
            The fitted regressor.
        """
        self._forget()
        self._learn_metric(self.skeleton)
        require_means(self.metric_, "PoseKernelRegressor")
        X, targets = validate_data(self, X, y, dtype=np.float64, multi_output=True, y_numeric=True)
        poses = self._check_y(y)
        warn_of_no_skeleton(self.metric, self.skeleton)
        weights = check_sample_weight(sample_weight, X)
        counted = weights > 0.0
        self.y_fit_, self._is_column = poses[counted], targets.ndim == 1
        self._kernel = KernelWeights(X[counted], weights[counted], self.gamma)
        self.gamma_ = self._kernel.gamma
        return self

    def predict(self, X):
        """Predict poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Features.

        Returns
        -------
        ndarray of shape (n_samples, n_dofs)
            Poses: joint angles, rad, in the dtype and number of dimensions of the training poses.

        Warns
        -----
        ConvergenceWarning
            If means did not converge. They are still poses.
        """
        check_is_fitted(self, "gamma_")
        X = validate_data(self, X, dtype=np.float64, reset=False)
        means, n_unconverged = self._means_of(self.y_fit_), 0
        poses = np.empty((len(X), self.y_fit_.shape[1]))
        batches = list(gen_batches(len(X), max(1, WEIGHTS // len(self.y_fit_))))
        with progress(f"{len(X):,} poses", len(batches), self.verbose) as advance:
            for batch in batches:
                poses[batch], converged = means.means(self._kernel.of(X[batch], self.n_neighbors))
                n_unconverged += int((~converged).sum())
                advance()
        if n_unconverged:
            warn(
                f"{n_unconverged} of the {len(X)} predicted means did not converge; a larger gamma or fewer neighbours "
                "may help",
                ConvergenceWarning,
            )
        poses = poses.astype(self.y_fit_.dtype, copy=False)
        return poses[:, 0] if self._is_column else poses

    def score(self, X, y, sample_weight=None):
        r"""Compute the explained share of variance under the metric.

        :math:`1 - \sum_i w_i \, d(y_i, \hat y_i)^2 / \sum_i w_i \, d(y_i, \bar y)^2` with :math:`\bar y` the Fréchet
        mean of y: at best 1, 0 for a constant prediction of the mean, negative for worse. Under "angle" this is
        `sklearn.metrics.r2_score` with ``multioutput="variance_weighted"``.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Features.
        y : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.
        sample_weight : array-like of shape (n_samples,), default=None
            Weights of the samples.

        Returns
        -------
        float
            The explained share. If all poses of y are equal, 1.0 for equal predictions, else 0.0.

        Warns
        -----
        ConvergenceWarning
            If predicted means, or the mean of y, did not converge.
        """
        check_is_fitted(self, "gamma_")
        predicted = self.predict(X)
        y = self._check_y(y)
        check_consistent_length(predicted, y)
        if len(y) < 2:
            warn("the explained share of variance is undefined for fewer than two poses", UndefinedMetricWarning)
            return float("nan")
        weights = check_sample_weight(sample_weight, y)
        mean, converged = self._means_of(y).means(weights[np.newaxis])
        if not converged.all():
            warn(
                f"the mean of the {len(y)} poses of y did not converge, so the score may be too high",
                ConvergenceWarning,
            )
        unexplained = weights @ self._squares(y, predicted.reshape(y.shape))
        total = weights @ self._squares(y, np.broadcast_to(mean, y.shape))
        if total == 0.0 or (y == y[:1]).all():  # the total may be a rounding error
            return float(np.allclose(predicted.reshape(y.shape), y, rtol=0.0, atol=EQUAL))
        return float(1.0 - unexplained / total)

    def _check_y(self, y):
        """Targets as poses (n_samples, n_dofs)."""
        y = check_poses(np.asarray(y)[:, np.newaxis] if np.asarray(y).ndim == 1 else y, self.skeleton_, "y")
        if self.skeleton_ is not None:
            warn_of_degrees(None, self.skeleton_, y=y, in_estimator=True)
        return y

    def _means_of(self, poses):
        return WeightedMeans(poses, self.skeleton_, self.metric_, self.n_jobs)

    def _squares(self, poses, others):
        return paired_distances(poses, others, self.skeleton_, self.metric_, effective_n_jobs(self.n_jobs)) ** 2

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags


class KernelWeights:
    """Training rows and their weights around any query.

    Equal rows count once, with the sum of their weights.

    Parameters
    ----------
    X : ndarray of shape (n_samples, n_features)
        Training rows, float64.
    sample_weight : ndarray of shape (n_samples,)
        Positive weights.
    gamma : "scott" or float
        The γ of the kernel.
    """

    def __init__(self, X, sample_weight, gamma):
        self.rows, row_of = np.unique(X, axis=0, return_inverse=True)
        self.row_of = row_of.ravel()  # a column in numpy 2.0
        shares = sample_weight / sample_weight.max()
        sums = np.bincount(self.row_of, shares)
        self.share_of_row = shares / sums[self.row_of]
        self.log_weights = np.log(sums)
        self.gamma = self._scott(X, shares) if gamma == "scott" else float(gamma)

    def _scott(self, X, shares):
        """The γ of Scott's rule, from the mean variance of the columns and the number of distinct rows."""
        mean = np.average(X, axis=0, weights=shares)
        variance = np.average((X - mean) ** 2, axis=0, weights=shares).mean()
        squared_width = variance * len(self.rows) ** (-2.0 / (X.shape[1] + 4))
        return float(0.5 / squared_width) if squared_width > 0.0 else 1.0

    def of(self, queries, n_neighbors):
        """Weights (n_queries, n_samples) around queries; the largest distinct row of each query has weight 1."""
        distances = cdist(queries, self.rows)
        nearest = distances.min(axis=1, keepdims=True)
        # d² − d₀², with d₀ the distance of the nearest row, so that its kernel is 1 and never underflows.
        logarithms = self.log_weights - (self.gamma * (distances - nearest)) * (distances + nearest)
        if n_neighbors is not None and n_neighbors < len(self.rows):
            last = np.partition(distances, n_neighbors - 1, axis=1)[:, n_neighbors - 1, np.newaxis]
            logarithms[distances > last] = -np.inf
        weights = np.exp(logarithms - logarithms.max(axis=1, keepdims=True))
        weights[weights < NEGLIGIBLE] = 0.0
        return weights[:, self.row_of] * self.share_of_row
