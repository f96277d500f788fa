"""Medoid shift clustering as an estimator."""

from numbers import Integral, Real
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, issparse
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.utils import check_symmetric
from sklearn.utils.validation import check_is_fitted

from skpose._base import ESTIMATOR_CONSTRAINTS, PoseEstimatorMixin
from skpose._compat.sklearn import Interval, fit_context
from skpose._parallel.callbacks import CallbackSupportMixin, FitReport, with_callbacks
from skpose.cluster._shift import estimate_bandwidth, find_bandwidth, shift, squared_distances


class MedoidShift(PoseEstimatorMixin, CallbackSupportMixin, ClusterMixin, BaseEstimator):
    r"""Medoid shift clustering: mode seeking with distances alone.

    Every sample i moves to the sample that minimises the weighted sum of squared distances
    :math:`\sum_k w_{ik} d_{jk}^2` over j, with the Gaussian weights :math:`w_{ik} = \exp(-d_{ik}^2 / 2h^2)`, and on
    from there until it stays; samples that stop at the same mode are a cluster. The modes then shift likewise among
    themselves, until nothing changes. As in mean shift the number of clusters follows from the bandwidth h; unlike in
    mean shift the modes are samples, and any distance can be used.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Needed by all metrics but "angle" and "precomputed".
    bandwidth : float, default=None
        The h of the weights, in the unit of the distance. None estimates it: the mean, over the samples, of the
        distance within which 30 % of the other samples lie (the rule of `sklearn.cluster.estimate_bandwidth`); in a
        sparse graph, 30 % of its neighbours.
    n_clusters : int, default=None
        Search for a bandwidth that gives this number of clusters instead, by halving an interval, then on a grid of 32
        and in its gaps. If none is found, a `ConvergenceWarning` is given, and the largest number of clusters below
        is taken.
    metric : str, Metric or "precomputed", default="auto"
        The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning. With
        "precomputed", X is a square matrix of distances, or a sparse graph of those between neighbours as
        `sklearn.neighbors.KNeighborsTransformer` gives it: a sample then moves among its neighbours, and two of them
        whose distance is not in the graph count as if their directions from the sample were at right angles.
    n_jobs : int, default=None
        Threads for the distances, or workers of a ``joblib.parallel_config`` context, see `skpose.pose_distances`.
    verbose : int, default=0
        Whether to show progress: of the distances, and of each shift of many samples.

    Attributes
    ----------
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use; None with "precomputed".
    labels_ : ndarray of shape (n_samples,)
        Cluster of each sample, numbered in the order of `cluster_centers_indices_`.
    cluster_centers_indices_ : ndarray of shape (n_clusters,)
        Indices of the modes among the samples, ascending.
    cluster_centers_ : ndarray of shape (n_clusters, n_dofs)
        The modes, in the dtype of the samples. Not with "precomputed".
    bandwidth_ : float
        The bandwidth in use.
    n_iter_ : int
        Number of shifts, of the samples and then of the modes.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    sklearn.cluster.MeanShift : The same idea in a vector space.

    Notes
    -----
    One matrix product a shift: time O(n³) for dense distances, and for a graph of k neighbours O(n k²). Memory O(n²),
    or O(n k): the distances are squared in place, and weights are computed for some samples at once.

    With a small bandwidth every sample is its own mode, with a large one the samples' medoid is the only one; in
    between the number of modes need not fall monotonically.

    References
    ----------
    .. [1] Y. A. Sheikh, E. A. Khan, T. Kanade, "Mode-seeking by medoidshifts", ICCV 2007,
       :doi:`10.1109/ICCV.2007.4408978`.
    .. [2] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 3.4, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import MedoidShift, Skeleton
    >>> X = [[0.0, 0.0], [0.1, 0.0], [0.2, 0.1], [1.5, 0.0], [1.6, 0.2], [1.7, 0.1]]
    >>> MedoidShift(Skeleton.chain(2), bandwidth=0.5).fit_predict(X)
    array([0, 0, 0, 1, 1, 1])
    """

    _parameter_constraints: ClassVar[dict] = {
        **ESTIMATOR_CONSTRAINTS,
        "bandwidth": [Interval(Real, 0, None, closed="neither"), None],
        "n_clusters": [Interval(Integral, 1, None, closed="left"), None],
    }

    def __init__(
        self,
        skeleton=None,
        *,
        bandwidth=None,
        n_clusters=None,
        metric="auto",
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.bandwidth = bandwidth
        self.n_clusters = n_clusters
        self.metric = metric
        self.n_jobs = n_jobs
        self.verbose = verbose

    @with_callbacks
    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None):
        """Find the modes.

        Parameters
        ----------
        X : {array-like, sparse matrix} of shape (n_samples, n_dofs) or (n_samples, n_samples)
            Poses: joint angles, rad; or distances if precomputed, which alone may be sparse.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        MedoidShift
            The fitted estimator.
        """
        if self.bandwidth is not None and self.n_clusters is not None:
            raise ValueError("bandwidth and n_clusters are both given; n_clusters searches for its own bandwidth")
        X = self._check_X(X, reset=True, accept_sparse="csr" if self.metric == "precomputed" else False)
        if self.n_clusters is not None and self.n_clusters > X.shape[0]:
            raise ValueError(f"n_clusters={self.n_clusters} is more than the {X.shape[0]} samples")
        fit_progress = FitReport(self, None, X)
        with fit_progress.step("distances"):
            distances = self._all_distances(X)
            scale = estimate_bandwidth(distances) if self.bandwidth is None else self.bandwidth
            squared = squared_distances(distances)
        if self.n_clusters is None:
            result = shift(squared, scale, fit_progress)
        else:
            result = find_bandwidth(squared, scale, self.n_clusters, fit_progress)
        self.bandwidth_, self.n_iter_ = result.bandwidth, result.n_iter
        self.cluster_centers_indices_, self.labels_ = np.unique(result.modes, return_inverse=True)
        if self.metric_ is not None:
            self.cluster_centers_ = X[self.cluster_centers_indices_]
        fit_progress.end()
        return self

    def predict(self, X):
        """Return the cluster whose mode is nearest to each pose.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples_fit)
            Poses: joint angles, rad; or their distances to the samples of `fit` if precomputed, all of them.

        Returns
        -------
        ndarray of shape (n_samples,)
            Labels. A sample of `fit` need not be nearest to the mode of its own cluster.
        """
        check_is_fitted(self, "labels_")
        X = self._check_X(X, reset=False)
        if self.metric_ is None:
            return X[:, self.cluster_centers_indices_].argmin(axis=1)
        return self._distances(X, self.cluster_centers_).argmin(axis=1)

    def _all_distances(self, X):
        """Distances among the samples, dense or sparse: a copy, and in float64, as close samples differ by little."""
        if self.metric_ is not None:
            return self._distances(X, None).astype(np.float64, copy=False)
        if issparse(X):
            return csr_array(X, dtype=np.float64, copy=True)
        return np.array(check_symmetric(X, raise_exception=True), dtype=np.float64)

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.sparse = self._is_precomputed()
        return tags
