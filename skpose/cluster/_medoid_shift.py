"""Medoid shift clustering."""

from numbers import Integral, Real
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, issparse
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.utils import check_symmetric
from sklearn.utils.validation import check_is_fitted

from skpose._base import ESTIMATOR_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.sklearn import Interval, check_sample_weight, fit_context
from skpose._utils.warnings import warn
from skpose.cluster._shift import estimate_bandwidth, find_bandwidth, shift, squared_distances, targets


class MedoidShift(PoseEstimatorMixin, ClusterMixin, BaseEstimator):
    r"""Medoid shift clustering: mode seeking with distances alone.

    Every sample i moves to the sample j that minimises :math:`\sum_k w_{ik} d_{jk}^2`, with Gaussian weights
    :math:`w_{ik} = m_k \exp(-d_{ik}^2 / 2h^2)` and sample weights :math:`m_k`, and on from there until it stops at a
    mode; samples with the same mode form a cluster. The modes are then shifted among themselves until nothing changes.
    As in mean shift, the bandwidth h determines the number of clusters; unlike mean shift, modes are samples, and any
    distance can be used.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Required by all metrics except "angle" and "precomputed".
    bandwidth : float, default=None
        The bandwidth h, in the unit of the distance. None estimates it as in `sklearn.cluster.estimate_bandwidth`: the
        mean, over the samples, of the distance that contains 30 % of the other samples (of its neighbours in a sparse
        graph), without regard to their weights.
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

    Warns
    -----
    UserWarning
        In `fit`, if the default bandwidth puts different samples into a single cluster.
    ConvergenceWarning
        In `fit`, if no bandwidth gives `n_clusters` clusters.

    See Also
    --------
    sklearn.cluster.MeanShift : A similar algorithm for vectors.

    Notes
    -----
    A shift is a matrix product: time O(n³) for dense distances, O(n k²) for a graph of k neighbours. Memory O(n²) or
    O(n k); distances are squared in place and kept for `predict`.

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
    def fit(self, X, y=None, sample_weight=None):
        """Compute the clusters.

        Parameters
        ----------
        X : {array-like, sparse matrix} of shape (n_samples, n_dofs) or (n_samples, n_samples)
            Poses: joint angles, rad; or precomputed distances, which may be sparse.
        y : Ignored
            Not used, present for API consistency by convention.
        sample_weight : array-like of shape (n_samples,), default=None
            Non-negative weights of the samples, not all zero. None means equal weights. Samples of weight zero get
            labels as in `predict` but have no effect on the clusters.

        Returns
        -------
        MedoidShift
            The fitted estimator.
        """
        if self.bandwidth is not None and self.n_clusters is not None:
            raise ValueError("bandwidth and n_clusters are mutually exclusive, got both")
        X = self._check_X(X, reset=True, accept_sparse="csr" if self.metric == "precomputed" else False)
        weights = check_sample_weight(sample_weight, X)
        self._counted = np.flatnonzero(weights)
        self._masses = weights[self._counted]
        if self.n_clusters is not None and self.n_clusters > len(self._counted):
            raise ValueError(f"n_clusters={self.n_clusters} is more than the {len(self._counted)} samples")
        self._poses = None if self.metric_ is None else X[self._counted]
        distances = self._all_distances(X)
        scale = estimate_bandwidth(distances) if self.bandwidth is None else self.bandwidth
        self._squared = squared_distances(distances)
        if self.n_clusters is None:
            result = shift(self._squared, self._masses, scale, self.verbose)
        else:
            result = find_bandwidth(self._squared, self._masses, scale, self.n_clusters, self.verbose)
        self.bandwidth_, self.n_iter_ = result.bandwidth, result.n_iter
        centers, self._labels = np.unique(result.modes, return_inverse=True)
        self.cluster_centers_indices_ = self._counted[centers]
        if self.metric_ is not None:
            self.cluster_centers_ = X[self.cluster_centers_indices_]
        self.labels_ = self._labels if weights.all() else self._shifted(X)
        if self.bandwidth is None and self.n_clusters is None and len(centers) == 1 and self._squared.max() > 0.0:
            warn(f"the default bandwidth {scale:.3g} gives a single cluster; pass n_clusters= or a smaller bandwidth=")
        return self

    def predict(self, X):
        """Predict the clusters of poses by a shift to a sample of `fit`.

        Parameters
        ----------
        X : {array-like, sparse matrix} of shape (n_samples, n_dofs) or (n_samples, n_samples_fit)
            Poses: joint angles, rad; or precomputed distances to all samples of `fit`, after a fit to a graph also a
            graph of neighbours among them.

        Returns
        -------
        ndarray of shape (n_samples,)
            Labels: `labels_` for the samples of `fit` (those of a graph, if it is symmetric).
        """
        check_is_fitted(self, "labels_")
        return self._shifted(self._check_X(X, reset=False, accept_sparse="csr" if issparse(self._squared) else False))

    def _shifted(self, X):
        """Labels of the samples to which the rows of X move."""
        target, _ = targets(self._rows(X), self._squared, self._masses, self.bandwidth_, self.verbose)
        if np.any(target < 0):
            raise ValueError("every row of X must have a neighbor of positive weight")
        return self._labels[target]

    def _rows(self, X):
        """Squared distances from X to the samples of positive weight, as a graph after a fit to a graph."""
        rows = X[:, self._counted] if self.metric_ is None else self._distances(X, self._poses)
        if not issparse(self._squared):
            return np.square(rows, dtype=np.float64)
        if not issparse(rows):  # zeros are distances, too
            m, n = rows.shape
            rows = csr_array((rows.ravel(), np.tile(np.arange(n), m), np.arange(0, m * n + 1, n)), shape=(m, n))
        return csr_array((np.square(rows.data, dtype=np.float64), rows.indices, rows.indptr), shape=rows.shape)

    def _all_distances(self, X):
        """Distances within X, dense or sparse: a copy in float64, since close samples differ little."""
        if self.metric_ is not None:
            return self._distances(self._poses, None).astype(np.float64, copy=False)
        X = X if issparse(X) else check_symmetric(X, raise_exception=True)
        return X[self._counted][:, self._counted].astype(np.float64, copy=False)

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.sparse = self._is_precomputed()
        return tags
