"""Medoid shift: clusters as the basins of the modes of a density that only distances are needed for."""

import warnings
from itertools import pairwise
from numbers import Integral, Real
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.sparse import csr_array, issparse
from scipy.sparse.csgraph import connected_components
from sklearn.base import BaseEstimator, ClusterMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils import check_symmetric, gen_batches
from sklearn.utils.validation import check_is_fitted

from skpose._base import ESTIMATOR_CONSTRAINTS, PoseEstimatorMixin
from skpose._compat.sklearn import Interval, fit_context
from skpose._compiled import graph_shift
from skpose._parallel.callbacks import CallbackSupportMixin, FitReport, with_callbacks
from skpose._parallel.progress import progress as shown

QUANTILE = 0.3  # of the other samples, within the estimated bandwidth of a sample
BLOCK = 1 << 21  # weights held at once
TIE = 1e-12  # relative difference of weighted sums that may be rounding
HALVINGS = 24  # of an interval of bandwidths in the search for one that gives n_clusters
GRID = 32  # bandwidths tried where halving found none


class MedoidShift(PoseEstimatorMixin, CallbackSupportMixin, ClusterMixin, BaseEstimator):
    r"""Medoid shift clustering: mode seeking with distances alone.

    Every sample i moves to the sample that minimises the weighted sum of squared distances
    :math:`\sum_k w_{ik} d_{jk}^2` over j, with the Gaussian weights :math:`w_{ik} = \exp(-d_{ik}^2 / 2h^2)`, and on
    from there until it stays; samples that come to rest on the same mode are a cluster. The modes then shift among
    themselves in the same way, until nothing changes. As in mean shift the number of clusters follows from the
    bandwidth h; unlike in mean shift the modes are samples, and any distance will do.

    Parameters
    ----------
    bandwidth : float, default=None
        The h of the weights, in the unit of the distance. None estimates it: the mean, over the samples, of the
        distance within which 30 % of the other samples lie (the rule of `sklearn.cluster.estimate_bandwidth`); in a
        sparse graph, 30 % of its neighbours.
    n_clusters : int, default=None
        Look for a bandwidth that gives this number of clusters instead, by halving an interval, then on a grid of 32
        and in the gaps of this. There need not be one; then a `ConvergenceWarning` says so, and the largest number of
        clusters below is taken.
    skeleton : Skeleton, default=None
        The body that all the poses are put on. Needed by all metrics but "angle" and "precomputed".
    metric : {"auto", "angle", "position", "rotation", "spatial", "precomputed"}, default="auto"
        The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton and "angle" without one. With
        "precomputed", X is a square matrix of distances, or a sparse graph of those between neighbours as
        `sklearn.neighbors.KNeighborsTransformer` gives it: a sample then moves among its neighbours, and two of them
        whose distance is not in the graph count as if they lay at right angles, seen from the sample.
    n_steps : int, default=10
        Chords along the curve of "spatial" and "geodesic".
    wrap : bool or "auto", default="auto"
        Whether differences of angles are taken the short way round, see `skpose.pose_distances`.
    n_jobs : int, default=None
        Threads for the distances, or workers of a ``joblib.parallel_config`` context, see `skpose.pose_distances`.
    verbose : int, default=0
        Whether to show how far it is: the distances, and each shift of many samples.

    Attributes
    ----------
    labels_ : ndarray of shape (n_samples,)
        Cluster of each sample, numbered in the order of `cluster_centers_indices_`.
    cluster_centers_indices_ : ndarray of shape (n_clusters,)
        The modes' places among the samples, ascending.
    cluster_centers_ : ndarray of shape (n_clusters, n_dofs)
        The modes. Not with "precomputed".
    bandwidth_ : float
        The bandwidth in use.
    n_iter_ : int
        How many times the samples, then the modes, were shifted.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    sklearn.cluster.MeanShift : The same idea in a vector space.

    Notes
    -----
    One matrix product a shift: time O(n³) for dense distances, and for a graph of k neighbours O(n k²). Beside the
    distances, which become squared in place, only a block of weights is held; memory O(n²), or O(n k).

    With a small bandwidth every sample is its own mode, with a large one the samples' medoid is the only one; in
    between the number of modes need not fall steadily.

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
    >>> MedoidShift(bandwidth=0.5, skeleton=Skeleton.chain(2)).fit_predict(X)
    array([0, 0, 0, 1, 1, 1])
    """

    _parameter_constraints: ClassVar[dict] = {
        **ESTIMATOR_CONSTRAINTS,
        "bandwidth": [Interval(Real, 0, None, closed="neither"), None],
        "n_clusters": [Interval(Integral, 1, None, closed="left"), None],
    }

    def __init__(
        self,
        bandwidth=None,
        *,
        n_clusters=None,
        skeleton=None,
        metric="auto",
        n_steps=10,
        wrap="auto",
        n_jobs=None,
        verbose=0,
    ):
        self.bandwidth = bandwidth
        self.n_clusters = n_clusters
        self.skeleton = skeleton
        self.metric = metric
        self.n_steps = n_steps
        self.wrap = wrap
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
        self : MedoidShift
            The fitted estimator.
        """
        if self.bandwidth is not None and self.n_clusters is not None:
            raise ValueError("bandwidth and n_clusters are both given; n_clusters looks for a bandwidth of its own")
        X = self._checked(X, reset=True, accept_sparse="csr" if self.metric == "precomputed" else False)
        if self.n_clusters is not None and self.n_clusters > X.shape[0]:
            raise ValueError(f"n_clusters={self.n_clusters} is more than the {X.shape[0]} samples")
        progress = FitReport(self, None, X)
        with progress.step("distances"):
            distances = self._all_distances(X)
            scale = _estimated_bandwidth(distances) if self.bandwidth is None else self.bandwidth
            squared = _squared(distances)
        if self.n_clusters is None:
            result = _shifted(squared, scale, progress)
        else:
            result = _search(squared, scale, self.n_clusters, progress)
        self.bandwidth_, self.n_iter_ = result.bandwidth, result.n_iter
        self.cluster_centers_indices_, self.labels_ = np.unique(result.modes, return_inverse=True)
        if self.metric != "precomputed":
            self.cluster_centers_ = X[self.cluster_centers_indices_]
        progress.end()
        return self

    def predict(self, X):
        """The cluster whose mode is nearest.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples_fit)
            Poses: joint angles, rad; or their distances to the samples of `fit` if precomputed, all of them.

        Returns
        -------
        ndarray of shape (n_samples,)
            Labels. A sample of `fit` need not be nearest to the mode of its own cluster.
        """
        check_is_fitted(self)
        X = self._checked(X, reset=False)
        if self.metric == "precomputed":
            return X[:, self.cluster_centers_indices_].argmin(axis=1)
        return self._distances(X, self.cluster_centers_).argmin(axis=1)

    def _all_distances(self, X):
        """Distances of our own among the samples, dense or sparse, in float64: close samples differ by little."""
        if self.metric != "precomputed":
            return self._distances(X, None).astype(np.float64, copy=False)
        if issparse(X):
            return csr_array(X, dtype=np.float64, copy=True)
        return np.array(check_symmetric(X, raise_exception=True), dtype=np.float64)

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.input_tags.sparse = self.metric == "precomputed"
        return tags


class _Modes(NamedTuple):
    """Outcome of the shifts at one bandwidth."""

    bandwidth: float
    modes: np.ndarray  # (n_samples,) the mode at which each sample came to rest
    n_iter: int

    @property
    def count(self):
        return len(np.unique(self.modes))


def _squared(distances):
    """Squared distances, overwriting them; of a graph as its symmetric CSR form with noughts on the diagonal.

    A graph of nearest neighbours need not be symmetric; what either of two samples knows, both know.
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


def _estimated_bandwidth(distances):
    """Mean over the samples of the distance within which QUANTILE of the others lie; of a graph, of its neighbours."""
    if issparse(distances):
        rows = [row for row in np.split(distances.data, distances.indptr[1:-1]) if len(row)]
        reach = [np.quantile(row, QUANTILE) for row in rows] if rows else [0.0]
    else:
        k = max(1, int(QUANTILE * (len(distances) - 1))) if len(distances) > 1 else 0
        reach = [np.partition(row, k)[k] for row in distances]
    return float(np.mean(reach)) or 1.0  # samples all alike: any bandwidth will do


def _next(squared, bandwidth, verbose):
    """Where each sample moves to, the j with the least Σ_k w_ik d_jk², and what staying costs it.

    Of several that are equal but for rounding, the first: equal samples move as one.
    """
    n = squared.shape[0]
    target, staying = np.empty(n, dtype=np.intp), np.empty(n)
    factor = -1.0 / (2.0 * bandwidth * bandwidth)
    if issparse(squared):
        graph_shift.shift_in_graph(squared.indptr, squared.indices, squared.data, factor, TIE, target, staying)
        return target, staying
    batches = list(gen_batches(n, max(1, BLOCK // n)))
    with shown(f"shift of {n:,} samples", len(batches), verbose and len(batches) > 1) as advance:
        for batch in batches:
            weights = squared[batch] * factor
            costs = np.exp(weights, out=weights) @ squared
            target[batch] = (costs <= costs.min(axis=1, keepdims=True) * (1.0 + TIE)).argmax(axis=1)
            staying[batch] = costs.diagonal(batch.start)
            advance()
    return target, staying


def _settled(target, staying):
    """Where samples come to rest that move from i to target[i]: at a fixed point or, of a cycle, at its best member."""
    n = len(target)
    resting = target.copy()
    for _ in range(int(np.ceil(np.log2(n))) + 1 if n > 1 else 1):
        resting = resting[resting]  # each round doubles the moves, n of which lead into a cycle for certain
    on_cycle = np.unique(resting)
    _, component = connected_components(
        csr_array((np.ones(n), (np.arange(n), target)), shape=(n, n)), directed=True, connection="weak"
    )
    order = on_cycle[np.lexsort((on_cycle, staying[on_cycle]))][::-1]
    mode = np.empty(component.max() + 1, dtype=np.intp)
    mode[component[order]] = order  # the last one written, the best, stays
    return mode[component]


def _shifted(squared, bandwidth, progress):
    """Shift the samples, then their modes among themselves, until nothing changes."""
    modes = np.arange(squared.shape[0])
    n_iter = 0
    while True:
        alive = np.unique(modes)
        with progress.step("shift"):
            among = squared if len(alive) == squared.shape[0] else squared[alive][:, alive]
            rest = alive[_settled(*_next(among, bandwidth, progress.verbose))]
        n_iter += 1
        if np.array_equal(rest, alive):
            return _Modes(float(bandwidth), modes, n_iter)
        modes = rest[np.searchsorted(alive, modes)]


def _search(squared, scale, n_clusters, progress):
    """A bandwidth that gives n_clusters; failing that the largest number below, with a warning."""
    tried = {}

    def count(bandwidth):
        if bandwidth not in tried:
            tried[bandwidth] = _shifted(squared, bandwidth, progress)
        return tried[bandwidth].count

    def halve(low, high):
        """Close in on where the number falls past n_clusters, count(low) > n_clusters > count(high)."""
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
    if not found:  # the number need not fall steadily: look in between
        grid = np.geomspace(low, high, GRID)
        found = any(count(bandwidth) == n_clusters for bandwidth in grid) or any(
            count(a) > n_clusters > count(b) and halve(a, b) for a, b in pairwise(grid)
        )
    below = [result for result in tried.values() if result.count <= n_clusters]
    best = max(below, key=lambda r: r.count) if below else min(tried.values(), key=lambda r: r.count)
    if not found:
        warnings.warn(
            f"no bandwidth was found that gives {n_clusters} clusters, among {len(tried)} from {min(tried):.3g} to "
            f"{max(tried):.3g}; bandwidth {best.bandwidth:.3g}, which is taken, gives {best.count}",
            ConvergenceWarning,
            stacklevel=4,
        )
    return best
