"""Medoid shift clustering."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from numbers import Integral, Real
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, issparse
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils import check_symmetric, gen_batches
from sklearn.utils.validation import check_is_fitted

from skpose._base import ESTIMATOR_CONSTRAINTS, PoseEstimatorMixin
from skpose._compiled import graph_shift
from skpose._utils.progress import progress
from skpose._utils.sklearn import Interval, check_sample_weight, fit_context
from skpose._utils.warnings import warn


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


QUANTILE = 0.3  # share of the other samples within the estimated bandwidth
WEIGHTS = 1 << 21  # weights in memory at once
TIE = 1e-12  # relative difference of costs that counts as a tie
HALVINGS = 24  # bisection steps of the bandwidth
GRID = 32  # bandwidths tried if bisection fails


@dataclass(frozen=True, eq=False)
class Modes:
    """Result of the shifts at one bandwidth."""

    bandwidth: float
    modes: np.ndarray  # (n_samples,) index of the mode of each sample
    n_iter: int

    @cached_property
    def count(self):
        return len(np.unique(self.modes))


def squared_distances(distances):
    """Square distances in place; a graph becomes symmetric CSR with zeros on the diagonal.

    A distance in one direction is used for both, as a graph of nearest neighbours need not be symmetric.
    """
    if not issparse(distances):
        return np.square(distances, out=distances)
    n = distances.shape[0]
    rows, columns = np.repeat(np.arange(n), np.diff(distances.indptr)), distances.indices.astype(np.intp)
    squared, diagonal = np.square(distances.data), np.arange(n)
    entries = np.concatenate([diagonal * n + diagonal, rows * n + columns, columns * n + rows])
    entries, first = np.unique(entries, return_index=True)
    values = np.concatenate([np.zeros(n), squared, squared])[first]
    starts = np.searchsorted(entries, np.arange(n + 1) * n)
    return csr_array((values, entries % n, starts), shape=(n, n))


def estimate_bandwidth(distances):
    """Mean distance that contains QUANTILE of the other samples, or of the neighbours in a graph."""
    if issparse(distances):
        rows = [row for row in np.split(distances.data, distances.indptr[1:-1]) if len(row)]
        reach = [np.quantile(row, QUANTILE) for row in rows] if rows else [0.0]
    else:
        k = max(1, int(QUANTILE * (len(distances) - 1))) if len(distances) > 1 else 0
        reach = [np.partition(row, k)[k] for row in distances]
    return float(np.mean(reach)) or 1.0  # all samples are equal, any bandwidth will do


def shift(squared, masses, bandwidth, verbose):
    """Shift the samples, then their modes among themselves, until nothing changes."""
    modes = np.arange(squared.shape[0])
    n_iter = 0
    while True:
        moving = np.unique(modes)
        among = squared if len(moving) == squared.shape[0] else squared[moving][:, moving]
        # Samples have their masses; modes count equally, as equal samples have one mode.
        of_moving = masses if n_iter == 0 else np.ones(len(moving))
        stops = moving[_stops(*targets(among, among, of_moving, bandwidth, verbose))]
        n_iter += 1
        if np.array_equal(stops, moving):
            return Modes(float(bandwidth), modes, n_iter)
        modes = stops[np.searchsorted(moving, modes)]


def targets(rows, squared, masses, bandwidth, verbose):
    """The sample j with the least Σ_k w_ik d_jk², w_ik = m_k exp(−d_ik²/2h²), for each row i, and the cost of staying.

    `rows` are squared distances to the samples, `squared` those among the samples; both dense or both graphs. Weights
    are relative to that of the nearest sample, so they cannot all underflow. Ties go to the first sample, so equal
    samples move together. A row of a graph without neighbours has the target −1.
    """
    m, n = rows.shape
    target, moments = np.full(m, -1), np.empty(m)
    # Finite for any bandwidth, so that a distance of zero has weight one.
    factor = -0.5 / max(float(bandwidth) * float(bandwidth), np.finfo(np.float64).tiny)
    if issparse(squared):
        graphs = [(graph.indptr, graph.indices, graph.data) for graph in (rows, squared)]
        graph_shift.shift_in_graph(*graphs, masses, factor, TIE, target, moments)
        return target, moments
    batches = list(gen_batches(m, max(1, WEIGHTS // n)))
    with progress(f"shift of {m:,} samples", len(batches), verbose and len(batches) > 1) as advance:
        for batch in batches:
            weights = rows[batch] - rows[batch].min(axis=1, keepdims=True)
            with np.errstate(over="ignore"):  # exp(−∞) is zero
                weights *= factor
            np.exp(weights, out=weights)
            weights *= masses
            costs = weights @ squared
            target[batch] = (costs <= costs.min(axis=1, keepdims=True) * (1.0 + TIE)).argmax(axis=1)
            moments[batch] = np.einsum("ij,ij->i", weights, rows[batch])
            advance()
    return target, moments


def _stops(target, staying):
    """The sample at which each sample stops: a fixed point or the best member of a cycle."""
    n = len(target)
    order = np.lexsort((np.arange(n), staying))
    best, reached = np.argsort(order), target  # the rank of the best sample among the next moves, and where they end
    for _ in range(n.bit_length()):  # twice as many moves each time; n moves always end in a cycle
        best, reached = np.minimum(best, best[reached]), reached[reached]
    return order[best[reached]]


def find_bandwidth(squared, masses, scale, n_clusters, verbose):
    """Modes with n_clusters clusters, else with the closest smaller number and a warning."""
    tried = {}

    def count(bandwidth):
        if bandwidth not in tried:
            tried[bandwidth] = shift(squared, masses, bandwidth, verbose)
        return tried[bandwidth].count

    def halve(low, high):
        """Bisect from count(low) > n_clusters > count(high); True if n_clusters is found."""
        for _ in range(HALVINGS):
            middle = np.sqrt(low * high)
            if count(middle) == n_clusters:
                return True
            low, high = (middle, high) if count(middle) > n_clusters else (low, middle)
        return False

    low = high = scale
    while count(low) < n_clusters and low > scale * 1e-6:
        low /= 2.0
    while count(high) > n_clusters and high < scale * 1e6:
        high *= 2.0
    found = n_clusters in (count(low), count(high)) or halve(low, high)
    if not found:  # the number of clusters need not be monotonic
        grid = np.geomspace(low, high, GRID)
        found = any(count(bandwidth) == n_clusters for bandwidth in grid) or any(
            count(a) > n_clusters > count(b) and halve(a, b) for a, b in pairwise(grid)
        )
    below = [result for result in tried.values() if result.count <= n_clusters]
    best = max(below, key=lambda r: r.count) if below else min(tried.values(), key=lambda r: r.count)
    if not found:
        warn(
            f"no bandwidth from {min(tried):.3g} to {max(tried):.3g} gives {n_clusters} clusters; bandwidth "
            f"{best.bandwidth:.3g} gives {best.count}",
            ConvergenceWarning,
        )
    return best
