"""K-means clustering of poses."""

from functools import partial
from numbers import Integral, Real
from typing import ClassVar, NamedTuple

import numpy as np
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, ClusterMixin, TransformerMixin
from sklearn.exceptions import ConvergenceWarning
from sklearn.utils import check_random_state
from sklearn.utils.validation import check_is_fitted

from skpose._base import POSE_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.sklearn import Interval, check_sample_weight, fit_context
from skpose._utils.warnings import warn
from skpose.geodesics._mean import WeightedMeans
from skpose.metrics._registry import require_means


class PoseKMeans(PoseEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, ClusterMixin, BaseEstimator):
    r"""K-means clustering of poses with Fréchet means as centres.

    Minimises the *inertia*, the sum of squared distances of samples to their nearest centre,

    .. math:: \min_{\mu} \sum_i w_i \min_k d(\theta_i, \mu_k)^2

    by Lloyd's iteration. Centres are poses, so their bones keep their lengths. Under "angle" an iteration equals that
    of `sklearn.cluster.KMeans`; initialisation and stopping criterion differ.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Required by all metrics except "angle".
    n_clusters : int, default=8
        Number of clusters.
    n_init : int, default=1
        Number of runs from different starts; the run with the least inertia is kept.
    max_iter : int, default=300
        Maximum number of iterations of a run.
    tol : float, default=1e-4
        Relative decrease of the inertia below which a run stops. It also stops if no sample changes its cluster.
    random_state : int, RandomState instance or None, default=None
        Seed of the initialisation. Pass an int for reproducible results.
    metric : str or Metric, default="auto"
        The distance, see `skpose.pose_distances`. "auto" is "position" with a skeleton, else "angle" with a warning.
    n_jobs : int, default=None
        Number of threads, or of workers of a ``joblib.parallel_config`` context for distances. It does not change the
        result.
    verbose : int, default=0
        Whether to show the progress of the distances.

    Attributes
    ----------
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use.
    cluster_centers_ : ndarray of shape (n_clusters, n_dofs)
        The centres: joint angles, rad; float64, also for float32 poses.
    labels_ : ndarray of shape (n_samples,)
        Index of the nearest centre of each sample; the first if tied.
    inertia_ : float
        Weighted sum of the squared distances of the samples to the nearest centre, m², or rad² for "angle".
    n_iter_ : int
        Number of iterations of the best run.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    Warns
    -----
    ConvergenceWarning
        In `fit`, if the best run did not converge within `max_iter`, if the mean of a cluster did not converge, or if
        fewer than `n_clusters` distinct clusters were found.

    See Also
    --------
    MedoidShift : Clusters with samples as centres; their number follows from a bandwidth.
    frechet_mean : The mean of poses.

    Notes
    -----
    The first centres are samples drawn by k-means++ [1]_, the best of 2 + log(n_clusters) candidates each. The inertia
    never rises: a mean replaces a centre only if it is nearer to the cluster, which matters for distances with several
    minima. An empty cluster gets the sample farthest from its centre, as in scikit-learn.

    Equal poses are merged and sorted first, so the result depends neither on the order of the samples nor on whether a
    sample is repeated or has twice the weight.

    An iteration takes n_samples · n_clusters distances and a mean for each changed cluster. Means are fast under
    "position", the default, and much slower under "rotation", "spatial" and "geodesic".

    References
    ----------
    .. [1] D. Arthur, S. Vassilvitskii, "k-means++: the advantages of careful seeding", SODA 2007.
    .. [2] X. Pennec, "Intrinsic statistics on Riemannian manifolds: basic tools for geometric measurements", Journal of
       Mathematical Imaging and Vision 25, 2006, :doi:`10.1007/s10851-006-6228-4`.

    Examples
    --------
    >>> from skpose import Skeleton
    >>> from skpose.cluster import PoseKMeans
    >>> X = [[0.0, 0.0], [0.1, 0.0], [0.2, 0.1], [1.5, 0.0], [1.6, 0.2], [1.7, 0.1]]
    >>> k_means = PoseKMeans(Skeleton.chain(2), n_clusters=2, random_state=0).fit(X)
    >>> k_means.labels_
    array([1, 1, 1, 0, 0, 0])
    >>> k_means.cluster_centers_.round(2)
    array([[1.6 , 0.1 ],
           [0.1 , 0.03]])
    >>> k_means.predict([[1.0, 0.0]])
    array([0])
    """

    _auto_metric = "position"
    _parameter_constraints: ClassVar[dict] = {
        **POSE_CONSTRAINTS,
        "n_clusters": [Interval(Integral, 1, None, closed="left")],
        "n_init": [Interval(Integral, 1, None, closed="left")],
        "max_iter": [Interval(Integral, 1, None, closed="left")],
        "tol": [Interval(Real, 0, None, closed="left")],
        "random_state": ["random_state"],
    }

    def __init__(
        self,
        skeleton=None,
        *,
        n_clusters=8,
        n_init=1,
        max_iter=300,
        tol=1e-4,
        random_state=None,
        metric="auto",
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.n_clusters = n_clusters
        self.n_init = n_init
        self.max_iter = max_iter
        self.tol = tol
        self.random_state = random_state
        self.metric = metric
        self.n_jobs = n_jobs
        self.verbose = verbose

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None, sample_weight=None):
        """Find the centres.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.
        sample_weight : array-like of shape (n_samples,), default=None
            Non-negative weights of the samples, not all zero. None means equal weights. Samples of weight zero get
            labels but have no effect on the clusters.

        Returns
        -------
        PoseKMeans
            The fitted estimator.
        """
        X = self._check_X(X, reset=True).astype(np.float64, copy=False)
        require_means(self.metric_, "PoseKMeans")
        if self.n_clusters > len(X):
            raise ValueError(f"n_clusters={self.n_clusters} is more than the {len(X)} samples")
        weights = check_sample_weight(sample_weight, X)
        rng, counted = check_random_state(self.random_state), weights > 0.0
        poses, pose_of = np.unique(X[counted], axis=0, return_inverse=True)
        masses = np.bincount(pose_of.ravel(), weights[counted])
        means = WeightedMeans(poses, self.skeleton_, self.metric_, self.n_jobs)
        squared = partial(self._squared_distances, poses)
        runs = []
        for _ in range(self.n_init):
            chosen = first_centers(poses, masses, squared, self.n_clusters, rng)
            runs.append(lloyd(poses[chosen], masses, squared, means.means, self.max_iter, self.tol))
        best = min(runs, key=lambda run: run.inertia)
        self.labels_ = self._squared_distances(X, best.centers).argmin(axis=1)
        self.inertia_, self.n_iter_ = best.inertia, best.n_iter
        self.cluster_centers_ = best.centers
        self._warn(best)
        return self

    def predict(self, X):
        """Predict the cluster with the nearest centre.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        ndarray of shape (n_samples,)
            Labels; the first centre if tied.
        """
        check_is_fitted(self, "cluster_centers_")
        return self._squared_distances(self._check_X(X, reset=False), self.cluster_centers_).argmin(axis=1)

    def transform(self, X):
        """Compute the distances to the centres.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        ndarray of shape (n_samples, n_clusters)
            Distances, m, or rad for "angle"; float32 for float32 poses, else float64.
        """
        check_is_fitted(self, "cluster_centers_")
        X = self._check_X(X, reset=False)
        return np.sqrt(self._squared_distances(X, self.cluster_centers_)).astype(X.dtype, copy=False)

    def score(self, X, y=None, sample_weight=None):
        """Compute the negative inertia; higher is better.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.
        sample_weight : array-like of shape (n_samples,), default=None
            Weights of the samples.

        Returns
        -------
        float
            The negative weighted sum of squared distances to the nearest centre.
        """
        check_is_fitted(self, "cluster_centers_")
        X = self._check_X(X, reset=False)
        weights = check_sample_weight(sample_weight, X)
        return -float(weights @ self._squared_distances(X, self.cluster_centers_).min(axis=1))

    def _squared_distances(self, X, centers):
        """Squared distances (n_samples, n_centers), in float64, since close samples differ little."""
        return np.square(self._distances(X.astype(np.float64, copy=False), centers))

    def _warn(self, run):
        n_distinct = len(np.unique(self.labels_))
        if n_distinct < self.n_clusters:
            warn(
                f"only {n_distinct} distinct clusters were found, not n_clusters={self.n_clusters}; lower n_clusters "
                "or raise n_init",
                ConvergenceWarning,
            )
        if not run.converged:
            warn(
                f"k-means did not converge after max_iter={self.max_iter} iterations; raise max_iter or tol",
                ConvergenceWarning,
            )
        if run.n_unconverged:
            warn(
                f"the means of {run.n_unconverged} of {self.n_clusters} clusters did not converge",
                ConvergenceWarning,
            )

    @property
    def _n_features_out(self):
        return len(self.cluster_centers_)

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.transformer_tags.preserves_dtype = ["float64", "float32"]
        return tags


class Clusters(NamedTuple):
    """The result of one run."""

    centers: np.ndarray  # (n_clusters, n_dofs)
    inertia: float  # weighted sum of squared distances to the nearest centre
    n_iter: int
    converged: bool
    n_unconverged: int  # centres whose last mean did not converge


def first_centers(poses, weights, squared, n_clusters, rng):
    """Indices of the first centres by greedy k-means++, as in scikit-learn.

    D. Arthur, S. Vassilvitskii, "k-means++: the advantages of careful seeding", SODA 2007.
    """
    n_trials = 2 + int(np.log(n_clusters))
    chosen = _draw(weights, 1, rng)
    nearest = squared(poses[chosen])[:, 0]
    while len(chosen) < n_clusters:
        candidates = _draw(weights * nearest, n_trials, rng)
        trials = np.minimum(squared(poses[candidates]), nearest[:, np.newaxis])
        best = (weights @ trials).argmin()
        chosen, nearest = np.append(chosen, candidates[best]), trials[:, best]
    return chosen


def _draw(chances, n, rng):
    """Draw rows with probabilities proportional to chances; any rows if all chances are zero."""
    sums = np.cumsum(chances)
    return np.minimum(np.searchsorted(sums, rng.uniform(size=n) * sums[-1], side="right"), len(chances) - 1)


def lloyd(centers, weights, squared, means, max_iter, tol):
    """Lloyd's iterations from some centres, which are changed in place.

    The cost never rises: a mean replaces a centre only if it is nearer to the cluster, which matters for distances with
    several minima. An empty cluster gets the sample farthest from its centre.
    """
    n_clusters = len(centers)
    rows = np.arange(len(weights))
    distances = squared(centers)
    labels = distances.argmin(axis=1)
    inertia = _cost(weights, distances, labels)
    fixed = np.full(len(labels), -1)  # labels for which the centres are means
    unconverged = np.zeros(n_clusters, dtype=bool)
    for iteration in range(1, max_iter + 1):
        labels = _fill_empty(labels, weights * distances[rows, labels], n_clusters)
        changed = labels != fixed
        moving = np.union1d(labels[changed], fixed[changed & (fixed >= 0)])
        moving = moving[np.isin(moving, labels)]
        weightings = (labels == moving[:, np.newaxis]) * weights
        found, converged = means(weightings)
        unconverged[moving] = ~converged
        to_found = squared(found)
        better = (weightings * to_found.T).sum(axis=1) < (weightings * distances[:, moving].T).sum(axis=1)
        centers[moving[better]], distances[:, moving[better]] = found[better], to_found[:, better]
        fixed, labels = labels, distances.argmin(axis=1)
        before, inertia = inertia, _cost(weights, distances, labels)
        if np.array_equal(labels, fixed) or before - inertia <= tol * inertia:
            return Clusters(centers, inertia, iteration, True, int(unconverged.sum()))
    return Clusters(centers, inertia, max_iter, False, int(unconverged.sum()))


def _cost(weights, distances, labels):
    return float(weights @ distances[np.arange(len(labels)), labels])


def _fill_empty(labels, costs, n_clusters):
    """Assign the sample of the largest cost to each empty cluster, unless all costs are zero."""
    labels = labels.copy()
    for empty in np.setdiff1d(np.arange(n_clusters), labels):
        farthest = costs.argmax()
        if costs[farthest] == 0.0:
            break
        labels[farthest], costs[farthest] = empty, 0.0
    return labels
