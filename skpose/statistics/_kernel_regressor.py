"""Regression with poses as targets: the weighted Fréchet mean of the training poses around a query."""

from numbers import Integral, Real
from typing import ClassVar

import numpy as np
from joblib import effective_n_jobs
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.exceptions import ConvergenceWarning, UndefinedMetricWarning
from sklearn.utils import check_array, gen_batches
from sklearn.utils.validation import check_consistent_length, check_is_fitted, validate_data

from skpose._base import POSE_CONSTRAINTS, PoseEstimatorMixin
from skpose._compat.sklearn import Interval, StrOptions, check_sample_weight, fit_context
from skpose._parallel.progress import progress
from skpose._validation.columns import check_column_names, check_dimensions, check_width
from skpose._validation.poses import check_is_array
from skpose._validation.units import warn_of_degrees
from skpose._warnings import warn
from skpose.geodesics._shared import WeightedMeans
from skpose.metrics._shared import paired_distances, require_means, warn_of_no_skeleton
from skpose.statistics._kernel_weights import KernelWeights

EQUAL = 1e-9  # difference of predicted angles that is rounding, rad
WEIGHTS = 1 << 21  # weights in memory at once


class PoseKernelRegressor(PoseEstimatorMixin, RegressorMixin, BaseEstimator):
    r"""Predict poses from any features, by kernel smoothing on the manifold of poses.

    The prediction at x is the Fréchet mean of the training poses with Gaussian weights, the Nadaraya–Watson estimator
    of targets on a manifold [1]_ [2]_:

    .. math:: \hat y(x) = \arg\min_\theta \sum_i w_i \, e^{-\gamma \|x - x_i\|^2} \, d(\theta, y_i)^2

    It is a pose, whose bones have their lengths, where a mean of positions has shorter ones, and it does not depend on
    the order of Euler angles in a file (but for "angle").

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all target poses. Needed by all metrics but "angle".
    gamma : "scott" or float, default="scott"
        The γ of the kernel, in the inverse square of the unit of X, as in `sklearn.kernel_ridge.KernelRidge`: the
        larger, the fewer training poses count. Zero weighs all of them equally. "scott" is the γ of Scott's rule,
        :math:`1 / 2h^2` with :math:`h^2 = \sigma^2 n^{-2/(p + 4)}`, of n different rows of p columns whose mean
        variance is σ²; search for a better one. Columns of different units need a
        `sklearn.preprocessing.StandardScaler` before.
    n_neighbors : int, default=None
        Number of nearest training rows that count; of equally far ones all. None is all rows.
    metric : str or Metric, default="auto"
        The distance d between poses, see `skpose.pose_distances`. "auto" is "position", as in
        `skpose.geodesics.frechet_mean`, with a skeleton, else "angle" and a warning: the mean of the columns.
    n_jobs : int, default=None
        Threads, as in scikit-learn. Predictions do not depend on it.
    verbose : int, default=0
        Whether to show the progress of predictions.

    Attributes
    ----------
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use.
    y_fit_ : ndarray of shape (n_samples_fit, n_dofs)
        The training poses, those of positive weight.
    gamma_ : float
        The γ in use.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    frechet_mean : The mean of poses.
    sklearn.neighbors.KNeighborsRegressor : The same idea in a vector space.

    Notes
    -----
    Features may be anything that has numbers: phase or time, positions of some joints, sensors, coordinates from
    `SpatialMDS`. Parameters can be searched for by `sklearn.model_selection.GridSearchCV`; `score` is the share of
    variance explained under the metric.

    A query that is far from all training rows gets the pose of the nearest one (of equally near ones their mean): the
    kernel is computed relative to the largest, so that it never underflows. Rows whose weight is less than a
    millionth of the largest count as zero. Predictions beyond the training rows do not extrapolate.

    Under "position" a prediction takes the mean of the positions, O(n_samples_fit · n_joints), and some iterations of
    Newton's method. Under "rotation", "spatial" and "geodesic" every iteration takes distances to all poses that count,
    and so far longer, the longest under the last two: choose a small `n_neighbors`.
    Memory O(n_samples_fit) and 16 MB for weights.

    References
    ----------
    .. [1] B. C. Davis, P. T. Fletcher, E. Bullitt, S. Joshi, "Population shape regression from random design data",
       International Journal of Computer Vision 90, 2010, :doi:`10.1007/s11263-010-0367-1`.
    .. [2] B. Pelletier, "Non-parametric regression estimation on closed Riemannian manifolds", Journal of
       Nonparametric Statistics 18(1), 2006, :doi:`10.1080/10485250500504828`.
    .. [3] D. W. Scott, "Multivariate density estimation", Wiley 1992, :doi:`10.1002/9780470316849`.

    Examples
    --------
    A pose for each phase of a generated walk:

    >>> import numpy as np
    >>> from skpose.statistics import PoseKernelRegressor
    >>> from skpose.datasets import make_gait
    >>> walk = make_gait(1, 1, activities=["walk"], duration=4, frame_rate=30, random_state=0)[0]
    >>> time = np.arange(len(walk.angles))[:, None] / walk.frame_rate
    >>> model = PoseKernelRegressor(walk.skeleton, gamma=200.0).fit(time[::4], walk.angles[::4])
    >>> model.predict([[1.01]]).shape
    (1, 42)
    >>> round(model.score(time, walk.angles), 2)
    0.98
    """

    _auto_metric = "position"
    _is_experimental = True
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
            Weights of the samples, not negative, and somewhere positive. None is equal ones; a weight of two is a
            sample twice.

        Returns
        -------
        PoseKernelRegressor
            The fitted regressor.
        """
        self._forget()
        self._learn_metric(self.skeleton)
        require_means(self.metric_, "PoseKernelRegressor")
        _check_has_names(y, self.skeleton_)
        X, y = validate_data(self, X, y, dtype=np.float64, multi_output=True, y_numeric=True)
        poses = self._check_y(y)
        warn_of_no_skeleton(self.metric, self.skeleton)
        weights = check_sample_weight(sample_weight, X)
        counted = weights > 0.0
        self.y_fit_, self._is_column = poses[counted], y.ndim == 1  # a copy
        self._kernel = KernelWeights(X[counted], weights[counted], self.gamma)
        self.gamma_ = self._kernel.gamma
        return self

    def predict(self, X):
        """Return the pose at each row of features.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_features)
            Features.

        Returns
        -------
        ndarray of shape (n_samples, n_dofs)
            Poses: joint angles, rad, in the dtype of the training poses; (n_samples,) where those were.

        Warns
        -----
        ConvergenceWarning
            If means did not converge; they are poses nevertheless.
        """
        check_is_fitted(self, "gamma_")
        self._check_how_to_answer()
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
                f"{n_unconverged} of the {len(X)} predicted means did not converge; they are poses, and may not be "
                "those of the least variance. A larger gamma or fewer neighbours make them easier",
                ConvergenceWarning,
            )
        poses = poses.astype(self.y_fit_.dtype, copy=False)
        return poses[:, 0] if self._is_column else poses

    def score(self, X, y, sample_weight=None):
        r"""Return the share of variance explained, under the metric.

        :math:`1 - \sum_i w_i \, d(y_i, \hat y_i)^2 / \sum_i w_i \, d(y_i, \bar y)^2` with the Fréchet mean
        :math:`\bar y` of the given poses: 1 at best, 0 for a constant mean, and negative for worse. Under "angle" it is
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
            The share; of poses that are all equal 1.0 if the predictions are equal to them, else 0.0.

        Warns
        -----
        ConvergenceWarning
            If predicted means did not converge, or the mean of the given poses.
        """
        check_is_fitted(self, "gamma_")
        predicted = self.predict(X)
        _check_has_names(y, self.skeleton_)
        y = self._check_y(check_array(y, dtype=[np.float64, np.float32], ensure_2d=False, input_name="y"))
        check_consistent_length(predicted, y)
        if len(y) < 2:
            warn("the share of variance of less than two poses is not defined", UndefinedMetricWarning)
            return float("nan")
        weights = check_sample_weight(sample_weight, y)
        mean, converged = self._means_of(y).means(weights[np.newaxis])
        if not converged.all():
            warn(
                f"the mean of the {len(y)} given poses did not converge, so that their variance, and with it the share "
                "explained, may be too large; compare it with scores of the same poses only",
                ConvergenceWarning,
            )
        unexplained = weights @ self._squares(y, predicted.reshape(y.shape))
        total = weights @ self._squares(y, np.broadcast_to(mean, y.shape))
        if total == 0.0 or (y == y[:1]).all():  # rounding may be left of the total
            return float(np.allclose(predicted.reshape(y.shape), y, rtol=0.0, atol=EQUAL))
        return float(1.0 - unexplained / total)

    def _check_y(self, y):
        """Return targets as poses (n_samples, n_dofs) that fit the skeleton: float32 if they were, else float64."""
        y = check_array(y, dtype=[np.float64, np.float32], ensure_2d=False, input_name="y")
        y = y.reshape(len(y), -1)
        if self.skeleton_ is not None:
            check_width(y, self.skeleton_, "y")
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


def _check_has_names(y, skeleton):
    """Refuse targets that are no array of poses, or whose columns have the names of others."""
    if y is None:
        return  # scikit-learn has an error for it
    check_is_array(y, "y")
    if skeleton is not None:
        check_column_names(y, skeleton, "y")
        check_dimensions(y, skeleton, "y")
