"""Classical multidimensional scaling of pose distances."""

import warnings
from contextlib import nullcontext
from numbers import Integral
from typing import ClassVar

import numpy as np
from joblib import effective_n_jobs
from scipy.linalg import eigh, eigvalsh
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.utils import check_random_state, check_symmetric, gen_batches
from sklearn.utils.validation import check_is_fitted

from skpose._base import ESTIMATOR_CONSTRAINTS, PoseEstimatorMixin
from skpose._compat.sklearn import Interval, StrOptions, fit_context
from skpose._parallel.callbacks import CallbackSupportMixin, FitReport, with_callbacks
from skpose._parallel.progress import progress as shown
from skpose.kinematics import forward_kinematics

WHOLE_SPECTRUM = 2000  # up to this many poses all eigenvalues are computed, beyond it only the leading ones
LANCZOS = 200  # up to this many poses one dense decomposition is the fastest way to a few eigenvectors
BLOCK = 1 << 22  # distances held at once, for each worker, while poses are placed
ROUNDING = 1e-12  # an eigenvalue is nought that is smaller than this share of the largest


class SpatialMDS(
    PoseEstimatorMixin, CallbackSupportMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator
):
    r"""Classical (Torgerson) multidimensional scaling of pose distances.

    Finds the points whose Euclidean distances are nearest, in the sense of their inner products, to the distances of
    the poses: the leading eigenvectors of :math:`B = -\tfrac12 J D^2 J`, with D the distances and J the centring. For
    Euclidean distances ("angle", "position") that is PCA; for others it is what takes its place, sec. 3.2 of [1]_.

    Parameters
    ----------
    n_components : int, default=2
        Dimension of the space.
    skeleton : Skeleton, default=None
        The body that all the poses are put on. Needed by all metrics but "angle" and "precomputed".
    metric : {"auto", "angle", "position", "rotation", "spatial", "precomputed"}, default="auto"
        The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton and "angle" without one. With
        "precomputed", X is a square matrix of distances in `fit`, and in `transform` the distances from the new poses
        to those of `fit`.
    landmarks : int, default=None
        For large n: scale only this many of the poses and place the rest by their distances to these, in memory
        O(n · landmarks). None scales all, in memory O(n²).
    landmark_selection : {"farthest", "random"}, default="farthest"
        How the landmarks are chosen. "farthest": the first at random, then always the pose farthest from all chosen so
        far, by joint positions (by angles without a skeleton, by the given distances if precomputed).
    random_state : int, RandomState instance or None, default=None
        Determines the choice of landmarks. Pass an int for the same result at every call.
    n_steps : int, default=10
        Chords along the curve of "spatial" and "geodesic".
    wrap : bool or "auto", default="auto"
        Whether differences of angles are taken the short way round, see `skpose.pose_distances`.
    n_jobs : int, default=None
        Threads for the distances, or workers of a ``joblib.parallel_config`` context, see `skpose.pose_distances`.
    verbose : int, default=0
        Whether to show how far it is.

    Attributes
    ----------
    embedding_ : ndarray of shape (n_samples, n_components)
        The training poses in the space. Each column's entry of largest magnitude is positive.
    eigenvalues_ : ndarray of shape (n_components,)
        The leading eigenvalues of B, in descending order; without landmarks the squared norms of the columns of
        `embedding_`.
    explained_variance_ratio_ : ndarray of shape (n_components,)
        Eigenvalues over the sum of all positive ones; for Euclidean distances PCA's ratio. Beyond 2,000 scaled poses
        only the leading eigenvalues are computed, and the sum is the trace of B: exact for Euclidean distances, for
        others less than the sum of the positive ones by the sum of the negative ones, so that the ratio is too high.
    negative_share_ : float
        Sum of the magnitudes of the negative eigenvalues over that of all: nought for Euclidean distances. NaN beyond
        2,000 scaled poses.
    landmark_indices_ : ndarray of shape (n_landmarks,)
        Which of the training poses were scaled; all of them without landmarks.
    X_fit_ : ndarray of shape (n_landmarks, n_dofs)
        These poses. Not with "precomputed".
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    sklearn.manifold.ClassicalMDS : The same for scikit-learn's distances, without `transform`.
    sklearn.manifold.Isomap : Takes ``metric="precomputed"`` distances too, and follows the data along its neighbours.

    Notes
    -----
    New poses are placed by Gower's formula [2]_, :math:`y = \tfrac12 \Lambda^{-1} Z^T (\bar d^2 - d^2)`, with d the
    distances to the scaled poses Z and :math:`\bar d^2` the mean squared distances among these; a pose of `fit` comes
    out where `embedding_` has it.

    Distances that are no Euclidean ones give some negative eigenvalues. A component that would belong to one, or to
    nought, is all zeros, with a warning.

    Time O(n²) for the distances and, up to 2,000 poses, O(n³) for all eigenvalues; beyond, O(n²) a Lanczos step.

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
    >>> from skpose import Skeleton, SpatialMDS
    >>> swing = np.linspace([0.0, 0.0], [0.5, 0.1], 9)
    >>> mds = SpatialMDS(n_components=1, skeleton=Skeleton.chain(2))
    >>> mds.fit_transform(swing).shape
    (9, 1)
    >>> mds.explained_variance_ratio_.round(2)
    array([1.])
    """

    _parameter_constraints: ClassVar[dict] = {
        **ESTIMATOR_CONSTRAINTS,
        "n_components": [Interval(Integral, 1, None, closed="left")],
        "landmarks": [Interval(Integral, 2, None, closed="left"), None],
        "landmark_selection": [StrOptions({"farthest", "random"})],
        "random_state": ["random_state"],
    }

    def __init__(
        self,
        n_components=2,
        *,
        skeleton=None,
        metric="auto",
        landmarks=None,
        landmark_selection="farthest",
        random_state=None,
        n_steps=10,
        wrap="auto",
        n_jobs=None,
        verbose=0,
    ):
        self.n_components = n_components
        self.skeleton = skeleton
        self.metric = metric
        self.landmarks = landmarks
        self.landmark_selection = landmark_selection
        self.random_state = random_state
        self.n_steps = n_steps
        self.wrap = wrap
        self.n_jobs = n_jobs
        self.verbose = verbose

    def fit(self, X, y=None):
        """Find the space of the poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples)
            Poses: joint angles, rad; or their distances if precomputed.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        self : SpatialMDS
            The fitted estimator.
        """
        self.fit_transform(X)
        return self

    @with_callbacks
    @fit_context(prefer_skip_nested_validation=True)
    def fit_transform(self, X, y=None):
        """Find the space of the poses and return their places in it.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples)
            Poses: joint angles, rad; or their distances if precomputed.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        ndarray of shape (n_samples, n_components)
            `embedding_`.
        """
        X = self._checked(X, reset=True, ensure_min_samples=2)
        if self.metric == "precomputed":
            X = check_symmetric(X, raise_exception=True)
        n, n_scaled = len(X), min(len(X), self.landmarks or len(X))
        batches = list(self._batches(n, n_scaled))
        progress = FitReport(self, 2 + (len(batches) if n_scaled < n else 0), X)

        with progress.step("distances"):
            chosen = np.arange(n) if n_scaled == n else self._choose_landmarks(X, n_scaled)
            self.landmark_indices_ = chosen
            if self.metric == "precomputed":
                squared = np.square(X[np.ix_(chosen, chosen)], dtype=np.float64)
            else:
                self.X_fit_ = X[chosen]
                squared = np.square(self._distances(self.X_fit_, None), dtype=np.float64)
        with progress.step("eigenvectors"):
            self._mean_squared = squared.mean(axis=0)
            points = self._scale(squared)
        if n_scaled == n:
            self.embedding_ = points
        else:
            self.embedding_ = self._placed(X, batches, progress.step)
        progress.end()
        return self.embedding_

    def transform(self, X):
        """Place poses in the space.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs) or (n_samples, n_samples_fit)
            Poses: joint angles, rad; or their distances to the poses of `fit` if precomputed.

        Returns
        -------
        ndarray of shape (n_samples, n_components)
        """
        check_is_fitted(self)
        X = self._checked(X, reset=False)
        return self._placed(X, list(self._batches(len(X), len(self.landmark_indices_))), nullcontext)

    def _batches(self, n, n_scaled):
        """Poses to place at once, a block of distances for each worker."""
        return gen_batches(n, max(1, BLOCK * effective_n_jobs(self.n_jobs) // n_scaled))

    def _choose_landmarks(self, X, n_scaled):
        rng = check_random_state(self.random_state)
        if self.landmark_selection == "random":
            return np.sort(rng.choice(len(X), n_scaled, replace=False))
        if self.metric == "precomputed":
            return _farthest_points(X.__getitem__, len(X), n_scaled, rng)
        points = X if self.skeleton is None else forward_kinematics(X, self.skeleton).reshape(len(X), -1)
        return _farthest_points(lambda i: np.linalg.norm(points - points[i], axis=1), len(X), n_scaled, rng)

    def _scale(self, squared):
        """Set the eigenvalues and return the points of squared distances, which are overwritten."""
        squared -= self._mean_squared
        squared -= squared.mean(axis=1, keepdims=True)
        squared *= -0.5
        values, vectors, spectrum = _leading(squared, self.n_components)
        magnitude = np.abs(values).max(initial=0.0) if spectrum is None else np.abs(spectrum).max(initial=0.0)
        positive = values > ROUNDING * magnitude
        if not positive.all():
            warnings.warn(
                f"the distances have only {positive.sum()} positive eigenvalues among the leading {self.n_components}; "
                "the components beyond these are zero: ask for fewer",
                stacklevel=4,
            )
        vectors *= np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(vectors.shape[1])])
        roots = np.sqrt(np.where(positive, values, 0.0))
        # Gower's formula needs Λ⁻¹ Zᵀ = Λ^-½ Uᵀ; a component of zeros takes nothing from any pose.
        self._placement = 0.5 * vectors * np.divide(1.0, roots, out=np.zeros_like(roots), where=positive)
        self.eigenvalues_ = values
        if spectrum is None:
            total, self.negative_share_ = np.trace(squared), np.nan
        else:
            total, size = spectrum[spectrum > 0].sum(), np.abs(spectrum).sum()
            self.negative_share_ = float((size - total) / size) if size > 0 else 0.0
        self.explained_variance_ratio_ = np.maximum(values, 0.0) / total if total > 0 else np.zeros(self.n_components)
        return vectors * roots

    def _placed(self, X, batches, step):
        """Places of all poses, batch by batch, each in a context ``step(name)``."""
        places = np.empty((len(X), self.n_components))
        with shown(f"{len(X):,} poses in {self.n_components} dimensions", len(batches), self.verbose) as advance:
            for batch in batches:
                with step("placing"):
                    places[batch] = self._place(X[batch])
                advance()
        return places

    def _place(self, X):
        given = self.metric == "precomputed"
        distances = X[:, self.landmark_indices_] if given else self._distances(X, self.X_fit_, verbose=0)
        return (self._mean_squared - np.square(distances, dtype=np.float64)) @ self._placement

    @property
    def _n_features_out(self):
        return self.n_components


def _leading(B, n_components):
    """The leading eigenvalues of B, padded with noughts, their eigenvectors, and the whole spectrum or None."""
    n = len(B)
    k = min(n_components, n)
    if n <= LANCZOS or k > n // 10:
        spectrum, vectors = eigh(B)
        values, vectors = spectrum[::-1][:k], vectors[:, ::-1][:, :k]
    else:
        from scipy.sparse.linalg import ArpackError, eigsh

        spectrum = eigvalsh(B) if n <= WHOLE_SPECTRUM else None
        try:
            # Not the default start, which is random; nor ones, which the centring sends to nought.
            values, vectors = eigsh(B, k, which="LA", v0=np.random.default_rng(0).standard_normal(n))
        except ArpackError:
            values, vectors = eigh(B, subset_by_index=[n - k, n - 1])
        order = np.argsort(values)[::-1]
        values, vectors = values[order], vectors[:, order]
    missing = n_components - k
    return np.pad(values, (0, missing)), np.pad(vectors, ((0, 0), (0, missing))), spectrum


def _farthest_points(distances_from, n, n_chosen, rng):
    """Indices of points each of which is the farthest from those before it; the first is random."""
    chosen = [int(rng.randint(n))]
    nearest = np.full(n, np.inf)
    while len(chosen) < n_chosen:
        np.minimum(nearest, distances_from(chosen[-1]), out=nearest)
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return np.sort(chosen)
