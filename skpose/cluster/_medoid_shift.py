"""Medoid shift clustering."""

from numbers import Integral, Real
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, issparse
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.utils import check_symmetric
from sklearn.utils.validation import check_is_fitted

from skpose._base import ESTIMATOR_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.sklearn import Interval, fit_context
from skpose.cluster._shift import estimate_bandwidth, find_bandwidth, shift, squared_distances


class MedoidShift(PoseEstimatorMixin, ClusterMixin, BaseEstimator):
    r"""Medoid shift clustering: mode seeking with distances alone.

    Every sample i moves to the sample j that minimises :math:`\sum_k w_{ik} d_{jk}^2`, with Gaussian weights
    :math:`w_{ik} = \exp(-d_{ik}^2 / 2h^2)`, and on from there until it stops at a mode; samples with the same mode form
    a cluster. The modes are then shifted among themselves until nothing changes. As in mean shift, the bandwidth h
    determines the number of clusters; unlike mean shift, modes are samples, and any distance can be used.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Required by all metrics except "angle" and "precomputed".
    bandwidth : float, default=None
        The bandwidth h, in the unit of the distance. None estimates it as in `sklearn.cluster.estimate_bandwidth`: the
        mean, over the samples, of the distance that contains 30 % of the other samples (of its neighbours in a sparse
        graph).
    n_clusters : int, default=None
        Search for a bandwidth with this number of clusters instead, by bisection and then on a grid of 32 bandwidths.
        If none is found, a `ConvergenceWarning` is issued, and the closest smaller number of clusters is used.
    metric : str, Metric or "precomputed", default="auto"
        The distance, see `skpose.pose_distances`. "auto" is "spatial" with a skeleton, else "angle" with a warning.
        With "precomputed", X is a square matrix of distances, or a sparse graph of neighbours as returned by
        `sklearn.neighbors.KNeighborsTransformer`. Samples of a graph move among their neighbours, and missing distances
        are replaced as if the two directions were at right angles.
    n_jobs : int, default=None
        Number of threads for distances, or of workers of a ``joblib.parallel_config`` context.
    verbose : int, default=0
        Whether to show progress.

    Attributes
    ----------
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use; None with "precomputed".
    labels_ : ndarray of shape (n_samples,)
        Cluster of each sample, in the order of `cluster_centers_indices_`.
    cluster_centers_indices_ : ndarray of shape (n_clusters,)
        Sorted indices of the modes among the samples.
    cluster_centers_ : ndarray of shape (n_clusters, n_dofs)
        The modes, in the dtype of X. Undefined with "precomputed".
    bandwidth_ : float
        The bandwidth in use.
    n_iter_ : int
        Number of shifts of samples or modes.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    sklearn.cluster.MeanShift : A similar algorithm for vectors.

    Notes
    -----
    A shift is a matrix product: time O(n³) for dense distances, O(n k²) for a graph of k neighbours. Memory O(n²) or
    O(n k); distances are squared in place.

    With a small bandwidth every sample is a mode, with a large one only the medoid. The number of modes need not
    decrease monotonically.

    References
    ----------
    .. [1] Y. A. Sheikh, E. A. Khan, T. Kanade, "Mode-seeking by medoidshifts", ICCV 2007,
       :doi:`10.1109/ICCV.2007.4408978`.
    .. [2] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 3.4, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.cluster import MedoidShift
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

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None):
        """Compute the clusters.

        Parameters
        ----------
        X : {array-like, sparse matrix} of shape (n_samples, n_dofs) or (n_samples, n_samples)
            Poses: joint angles, rad; or precomputed distances, which may be sparse.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        MedoidShift
            The fitted estimator.
        """
        if self.bandwidth is not None and self.n_clusters is not None:
            raise ValueError("bandwidth and n_clusters are mutually exclusive, got both")
        X = self._check_X(X, reset=True, accept_sparse="csr" if self.metric == "precomputed" else False)
        if self.n_clusters is not None and self.n_clusters > X.shape[0]:
            raise ValueError(f"n_clusters={self.n_clusters} is more than the {X.shape[0]} samples")
        distances = self._all_distances(X)
        scale = estimate_bandwidth(distances) if self.bandwidth is None else self.bandwidth
        squared = squared_distances(distances)
        if self.n_clusters is None:
            result = shift(squared, scale, self.verbose)
        else:
            result = find_bandwidth(squared, scale, self.n_clusters, self.verbose)
        self.bandwidth_, self.n_iter_ = result.bandwidth, result.n_iter
        self.cluster_centers_indices_, self.labels_ = np.unique(result.modes, return_inverse=True)
        if self.metric_ is not None:
            self.cluster_centers_ = X[self.cluster_centers_indices_]
        return self

    def predict(self, X):
        """Predict the cluster with the nearest mode.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples_fit)
            Poses: joint angles, rad; or precomputed distances to all samples of `fit`.

        Returns
        -------
        ndarray of shape (n_samples,)
            Labels. For samples of `fit` they may differ from `labels_`.
        """
        check_is_fitted(self, "labels_")
        X = self._check_X(X, reset=False)
        if self.metric_ is None:
            return X[:, self.cluster_centers_indices_].argmin(axis=1)
        return self._distances(X, self.cluster_centers_).argmin(axis=1)

    def _all_distances(self, X):
        """Distances within X, dense or sparse: a copy in float64, since close samples differ little."""
        if self.metric_ is not None:
            return self._distances(X, None).astype(np.float64, copy=False)
        if issparse(X):
            return csr_array(X, dtype=np.float64, copy=True)
        return np.array(check_symmetric(X, raise_exception=True), dtype=np.float64)

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.sparse = self._is_precomputed()
        return tags
