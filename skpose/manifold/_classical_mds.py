"""Classical multidimensional scaling of pose distances."""

from numbers import Integral
from typing import ClassVar

import numpy as np
from joblib import effective_n_jobs
from scipy.linalg import eigh
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.utils import check_random_state, check_symmetric, gen_batches
from sklearn.utils.validation import check_is_fitted

from skpose._base import ESTIMATOR_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.progress import progress
from skpose._utils.sklearn import Interval, fit_context
from skpose._utils.warnings import warn
from skpose.kinematics._forward import weighted_positions

BATCH = 1 << 22  # distances in memory per worker while placing poses


class SpatialMDS(PoseEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator):
    r"""Classical (Torgerson) multidimensional scaling of pose distances.

    Finds points whose inner products best match those implied by the distances: the leading eigenvectors of
    :math:`B = -\tfrac{1}{2} J D^2 J`, with D the distances and J the centring matrix. For Euclidean distances ("angle",
    "position") this is PCA; for others it generalises PCA, sec. 3.2 of [1]_.

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Required by all metrics except "angle" and "precomputed".
    n_components : int, default=2
        Number of dimensions.
    metric : str, Metric or "precomputed", default="auto"
        The distance, see `skpose.pose_distances`. "auto" is "spatial" with a skeleton, else "angle" with a warning.
        With "precomputed", X is a square matrix of distances in `fit`, and the distances from new poses to the poses of
        `fit` in `transform`.
    landmarks : int, default=None
        Number of poses to scale; the rest is placed by distances to these, in memory O(n · landmarks). None scales all
        poses, in memory O(n²).
    random_state : int, RandomState instance or None, default=None
        Seed of the choice of landmarks: the first is random, and then the pose farthest from all chosen ones is added
        repeatedly, by weighted joint positions (by angles without a skeleton, by the distances if precomputed). Pass an
        int for reproducible results.
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
    embedding_ : ndarray of shape (n_samples, n_components)
        Coordinates of the training poses; float64, also for float32 poses. The entry of largest magnitude of each
        column is positive.
    eigenvalues_ : ndarray of shape (n_components,)
        The leading eigenvalues of B in descending order. Without landmarks, the squared norms of the columns of
        `embedding_`.
    explained_variance_ratio_ : ndarray of shape (n_components,)
        Eigenvalues divided by the sum of all positive eigenvalues; for Euclidean distances as in PCA.
    negative_share_ : float
        Share of negative eigenvalues, by magnitude; zero for Euclidean distances.
    landmark_indices_ : ndarray of shape (n_landmarks,)
        Indices of the scaled training poses; all without landmarks.
    X_fit_ : ndarray of shape (n_landmarks, n_dofs)
        The scaled training poses. Undefined with "precomputed".
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    sklearn.manifold.ClassicalMDS : Classical scaling without `transform`.
    sklearn.manifold.Isomap : Scaling of distances along a graph of neighbours.

    Notes
    -----
    New poses are placed by Gower's formula [2]_, :math:`y = \tfrac{1}{2} \Lambda^{-1} Z^T (\bar d^2 - d^2)`, with d the
    distances to the scaled poses Z and :math:`\bar d^2` the mean squared distances among them. A pose of `fit` gets its
    row of `embedding_`.

    Distances that are not Euclidean have negative eigenvalues. Components without a positive eigenvalue are zero, with
    a warning.

    Time O(n²) for the distances and O(n³) for all eigenvalues, as needed by `explained_variance_ratio_`: 2.3 s
    for 2,567 poses in one thread. Memory for three n × n matrices. For many poses use `landmarks`.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, sec. 3.2, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] J. C. Gower, "Adding a point to vector diagrams in multivariate analysis", Biometrika 55, 1968,
       :doi:`10.1093/biomet/55.3.582`.
    .. [3] V. de Silva, J. B. Tenenbaum, "Sparse multidimensional scaling using landmark points", technical report,
       Stanford University, 2004.

    Examples
    --------
    >>> import numpy as np
    >>> from skpose import Skeleton
    >>> from skpose.manifold import SpatialMDS
    >>> swing = np.linspace([0.0, 0.0], [0.5, 0.1], 9)
    >>> mds = SpatialMDS(Skeleton.chain(2), n_components=1)
    >>> mds.fit_transform(swing).shape
    (9, 1)
    >>> mds.explained_variance_ratio_.round(2)
    array([1.])
    """

    _parameter_constraints: ClassVar[dict] = {
        **ESTIMATOR_CONSTRAINTS,
        "n_components": [Interval(Integral, 1, None, closed="left")],
        "landmarks": [Interval(Integral, 2, None, closed="left"), None],
        "random_state": ["random_state"],
    }

    def __init__(
        self,
        skeleton=None,
        *,
        n_components=2,
        metric="auto",
        landmarks=None,
        random_state=None,
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.n_components = n_components
        self.metric = metric
        self.landmarks = landmarks
        self.random_state = random_state
        self.n_jobs = n_jobs
        self.verbose = verbose

    def fit(self, X, y=None):
        """Fit the embedding.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples)
            Poses: joint angles, rad; or precomputed distances.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        SpatialMDS
            The fitted estimator.
        """
        self.fit_transform(X)
        return self

    @fit_context(prefer_skip_nested_validation=True)
    def fit_transform(self, X, y=None):
        """Fit the embedding and return the coordinates of the poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples)
            Poses: joint angles, rad; or precomputed distances.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        ndarray of shape (n_samples, n_components)
            The `embedding_`; float64, also for float32 poses.
        """
        X = self._check_X(X, reset=True, ensure_min_samples=2)
        if self.metric_ is None:
            X = check_symmetric(X, raise_exception=True)
        n, n_scaled = len(X), min(len(X), self.landmarks or len(X))
        chosen = self.landmark_indices_ = np.arange(n) if n_scaled == n else self._choose_landmarks(X, n_scaled)
        if self.metric_ is None:
            squared = np.square(X[np.ix_(chosen, chosen)], dtype=np.float64)
        else:
            self.X_fit_ = X[chosen]
            squared = np.square(self._distances(self.X_fit_, None), dtype=np.float64)
        points = self._scale(squared)
        self.embedding_ = points if n_scaled == n else self._embed(X)
        return self.embedding_

    def transform(self, X):
        """Embed new poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples_fit)
            Poses: joint angles, rad; or precomputed distances to the poses of `fit`.

        Returns
        -------
        ndarray of shape (n_samples, n_components)
            Coordinates of the poses; float64, also for float32 poses.
        """
        check_is_fitted(self, "embedding_")
        return self._embed(self._check_X(X, reset=False))

    def _choose_landmarks(self, X, n_scaled):
        rng = check_random_state(self.random_state)
        if self.metric_ is None:
            return farthest_points(X.__getitem__, len(X), n_scaled, rng)
        points = X if self.skeleton_ is None else weighted_positions(X, self.skeleton_)
        return farthest_points(lambda i: np.linalg.norm(points - points[i], axis=1), len(X), n_scaled, rng)

    def _scale(self, squared):
        """Learn from squared distances, which are overwritten; return the coordinates."""
        self._mean_squared = squared.mean(axis=0)
        squared -= self._mean_squared
        squared -= squared.mean(axis=1, keepdims=True)
        squared *= -0.5
        values, vectors, spectrum = _leading_eigenpairs(squared, self.n_components)
        positive = values > ROUNDING * np.abs(spectrum).max()
        if not positive.all():
            warn(
                f"only {positive.sum()} of the leading {self.n_components} eigenvalues are positive; other components "
                "are zero"
            )
        vectors *= np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(vectors.shape[1])])
        sqrt = np.sqrt(np.where(positive, values, 0.0))
        # ½ (Λ⁻¹ Zᵀ)ᵀ = ½ U Λ^-½ of Gower's formula, zero for components without positive eigenvalue.
        self._projection = 0.5 * vectors * np.divide(1.0, sqrt, out=np.zeros_like(sqrt), where=positive)
        total, size = spectrum[spectrum > 0].sum(), np.abs(spectrum).sum()
        self.eigenvalues_ = values
        self.explained_variance_ratio_ = np.maximum(values, 0.0) / total if total > 0 else np.zeros(len(values))
        self.negative_share_ = float((size - total) / size) if size > 0 else 0.0
        return vectors * sqrt

    def _embed(self, X):
        """Coordinates of all poses, batch by batch, by Gower's formula."""
        n_components = len(self.eigenvalues_)
        points = np.empty((len(X), n_components))
        size = max(1, BATCH * effective_n_jobs(self.n_jobs) // len(self.landmark_indices_))
        batches = list(gen_batches(len(X), size))
        with progress(f"{len(X):,} poses in {n_components} dimensions", len(batches), self.verbose) as advance:
            for batch in batches:
                if self.metric_ is None:
                    distances = X[batch][:, self.landmark_indices_]
                else:
                    distances = self._distances(X[batch], self.X_fit_, verbose=0)
                points[batch] = (self._mean_squared - np.square(distances, dtype=np.float64)) @ self._projection
                advance()
        return points

    @property
    def _n_features_out(self):
        return len(self.eigenvalues_)


LANCZOS = 200  # up to this many poses a dense decomposition is fastest
ROUNDING = 1e-12  # eigenvalues below this share of the largest count as zero


def _leading_eigenpairs(B, n_components):
    """Leading eigenvalues padded with zeros, their eigenvectors, and the whole spectrum; B is overwritten."""
    n = len(B)
    k = min(n_components, n)
    if n <= LANCZOS or k > n // 10:
        spectrum, vectors = eigh(B)
        values, vectors = spectrum[::-1][:k], vectors[:, ::-1][:, :k]
    else:
        from scipy.sparse.linalg import ArpackError, eigsh

        try:
            # A fixed start, as the default is random. A vector of ones is in the kernel of the centred B.
            values, vectors = eigsh(B, k, which="LA", v0=np.random.default_rng(0).standard_normal(n))
        except ArpackError:
            values, vectors = eigh(B, subset_by_index=[n - k, n - 1])
        order = np.argsort(values)[::-1]
        values, vectors = values[order], vectors[:, order]
        spectrum = np.linalg.eigvalsh(B)  # scipy's holds the GIL
    missing = n_components - k
    return np.pad(values, (0, missing)), np.pad(vectors, ((0, 0), (0, missing))), spectrum


def farthest_points(distances_from, n, n_chosen, rng):
    """Sorted indices of a random point and, repeatedly, the point farthest from all chosen ones."""
    chosen = [int(rng.randint(n))]
    nearest = np.full(n, np.inf)
    while len(chosen) < n_chosen:
        np.minimum(nearest, distances_from(chosen[-1]), out=nearest)
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return np.sort(chosen)
