"""Distances to the training poses as a step of a scikit-learn pipeline."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from numbers import Real
from typing import ClassVar

import numpy as np
from scipy.linalg import eigh, eigvalsh
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from skpose._base import POSE_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.sklearn import Interval, StrOptions, fit_context

SCALE_SAMPLES = 500  # training samples from which gamma="scale" takes the mean squared distance
KERNEL_CONSTRAINTS: dict[str, list] = {
    "kernel": [StrOptions(["rbf", "laplacian"]), None],
    "gamma": [StrOptions(["scale"]), Interval(Real, 0, None, closed="left")],
    "psd": [StrOptions(["ignore", "clip", "shift"])],
}


def to_kernel(distances, name, gamma):
    """Turn distances into the kernel of a name, in place."""
    if name == "rbf":
        np.square(distances, out=distances)
    distances *= -gamma
    return np.exp(distances, out=distances)


@dataclass(frozen=True, eq=False)
class Repair:
    """The repair of a training kernel, and of rows of the same kernel.

    Attributes
    ----------
    vectors : ndarray of shape (n, n_negative)
        The eigenvectors that "clip" removes; none with "shift".
    shift : float
        The λ of "shift"; zero with "clip".
    negative_share : float
        Share of the negative eigenvalues in the sum of all magnitudes.
    """

    vectors: np.ndarray
    shift: float
    negative_share: float

    def rows(self, kernel, equal):
        """Repair rows of the kernel in place; `equal` is True for two equal poses."""
        if self.vectors.shape[1]:
            kernel -= (kernel @ self.vectors) @ self.vectors.T
        if self.shift:
            kernel[equal] += self.shift
        return kernel


def repair_kernel(kernel, equal, psd):
    """Repair a symmetric kernel in place; also its `Repair`.

    The diagonal of a kernel of distances is one, so rounding changes an eigenvalue by no more than some n times the
    precision of its numbers. Negative eigenvalues of that size count as zero.
    """
    n = len(kernel)
    in_float64 = kernel.astype(np.float64)  # a copy, which is overwritten
    options = {"overwrite_a": True, "check_finite": False}
    if psd == "clip":
        values, vectors = eigh(in_float64, **options)
    else:
        values, vectors = eigvalsh(in_float64, **options), np.empty((n, 0))
    negative = values < -n * np.finfo(kernel.dtype).eps
    below = np.abs(values[negative]).sum()
    share = float(below / (below + values[~negative].clip(0).sum()))
    if psd == "shift":
        repair = Repair(vectors, float(np.abs(values[negative]).max(initial=0.0)), share)
        return repair.rows(kernel, equal), repair
    removed = vectors[:, negative]
    scaled = removed * np.sqrt(-values[negative])
    kernel += scaled @ scaled.T  # exactly symmetric, as the product of a matrix with its own transpose is
    return kernel, Repair(removed, 0.0, share)


class KernelMixin:
    """Mixin for transformers whose distances may become a kernel: with the parameters `kernel`, `gamma` and `psd`.

    Attributes
    ----------
    gamma_ : float
        The γ in use. Only with a kernel.
    negative_share_ : float
        Share of the negative eigenvalues in the sum of all magnitudes before the repair. Only with a repair.
    """

    kernel: str | None
    gamma: str | float
    psd: str

    def _learn_kernel(self, n: int, among: Callable[[np.ndarray | None], np.ndarray]) -> np.ndarray | None:
        """Learn γ and the repair from n training samples; the result is their kernel if it was computed, else None.

        `among` computes the distances among some of the training samples, or all if None.
        """
        self._kernel = self._repair = distances = None
        if self.kernel is None:
            if self.psd != "ignore":
                raise ValueError(f'psd="{self.psd}" repairs a kernel, got kernel=None: choose "rbf" or "laplacian"')
            return None
        if self.gamma == "scale":
            chosen = np.unique(np.linspace(0, n - 1, SCALE_SAMPLES).astype(int))
            some = among(None if len(chosen) == n else chosen)
            distances = some if len(chosen) == n else None
        self.gamma_ = self._scale_of(some) if self.gamma == "scale" else float(self.gamma)
        self._kernel = partial(to_kernel, name=self.kernel, gamma=self.gamma_)
        if self.psd == "ignore":
            return None if distances is None else self._kernel(distances)
        distances = among(None) if distances is None else distances
        equal = distances == 0
        kernel, self._repair = repair_kernel(self._kernel(distances), equal, self.psd)
        self.negative_share_ = self._repair.negative_share
        return kernel

    def _scale_of(self, distances: np.ndarray) -> float:
        """The γ of gamma="scale", from distances among training samples."""
        squared = np.square(distances, dtype=np.float64).mean()
        if squared == 0:  # all samples are equal: every scale gives the same
            return 1.0
        return float(2.0 / squared if self.kernel == "rbf" else np.sqrt(2.0 / squared))

    def _similarity(self, distances: np.ndarray) -> np.ndarray:
        """Turn distances into the kernel in place, if there is one."""
        if self._kernel is None:
            return distances
        if self._repair is None:
            return self._kernel(distances)
        equal = distances == 0
        return self._repair.rows(self._kernel(distances), equal)


# --- distances --------------------------------------------------------------------------------------------------------


class PoseDistanceTransformer(
    KernelMixin, PoseEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator
):
    r"""Transform poses to their distances from the training poses, or to a kernel of these distances.

    Every estimator of scikit-learn that takes a precomputed matrix then works on poses::

        make_pipeline(PoseDistanceTransformer(skeleton), KNeighborsClassifier(metric="precomputed"))
        make_pipeline(PoseDistanceTransformer(skeleton, kernel="rbf"), SVC(kernel="precomputed"))

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Needed by all metrics except "angle".
    metric : str or Metric, default="auto"
        The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning.
    kernel : {"rbf", "laplacian"} or None, default=None
        None gives distances d, "rbf" gives :math:`\exp(-\gamma d^2)` and "laplacian" :math:`\exp(-\gamma d)`. Both are
        positive semidefinite for "angle" and "position", which are Euclidean distances; for the others
        they need not be, see `psd`.
    gamma : "scale" or float, default="scale"
        The γ of the kernel, in the inverse unit of d² ("rbf") or of d ("laplacian"). "scale" is 2 / m and √(2 / m)
        with m the mean squared distance between at most 500 training poses, evenly spread. For Euclidean distances
        of standardised features it equals SVC's "scale".
    psd : {"ignore", "clip", "shift"}, default="ignore"
        Treatment of negative eigenvalues of the kernel, which may keep an SVM from the optimum.
        "ignore" gives the kernel by its formula. "clip" sets them to zero in the kernel of the training poses, which
        gives the nearest positive semidefinite matrix, and projects the kernel of other poses on the eigenvectors that
        remain. "shift" adds the magnitude of the least eigenvalue to the kernel of a pose with itself, and changes no
        kernel of two different poses. Only with a kernel.
    n_jobs : int, default=None
        Threads, or workers of a ``joblib.parallel_config`` context, see `skpose.pose_distances`.
    verbose : int, default=0
        Whether to show progress.

    Attributes
    ----------
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use.
    X_fit_ : ndarray of shape (n_samples_fit, n_dofs)
        The training poses.
    gamma_ : float
        The γ in use. Only with a kernel.
    negative_share_ : float
        Sum of the magnitudes of the negative eigenvalues of the training poses' kernel before its repair, divided by
        the sum over all eigenvalues: zero for Euclidean distances. Only with `psd` "clip" and "shift".
    n_samples_fit_ : int
        Number of training poses.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    See Also
    --------
    pose_distances : The distances as a function.
    pose_metric : One distance as a compiled function of two poses.

    Notes
    -----
    Time O(n_samples · n_samples_fit · n_dofs), memory O(n_samples · n_samples_fit). Keep ``algorithm="brute"`` or
    ``metric="precomputed"`` in the steps that follow: "spatial" need not obey the triangle inequality.

    Rows of other poses are repaired consistently [2]_: `transform` of the training poses gives what `fit_transform`
    gave, up to rounding. "clip" changes the kernel of any two poses, so that it is no longer one on the diagonal.
    "shift" regularises an SVM, as a smaller C does. The default leaves the kernel alone, since SVMs usually work with a
    few negative eigenvalues. For a repair, `fit` computes the kernel of all training poses and its eigenvalues, in time
    O(n_samples_fit³) and memory for four such matrices in float64, or two for "shift". "clip" keeps the eigenvectors of
    the negative eigenvalues and multiplies each row by them twice in `transform`.

    References
    ----------
    .. [1] S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding",
       AMDO 2012, :doi:`10.1007/978-3-642-31567-1_3`.
    .. [2] Y. Chen, E. K. Garcia, M. R. Gupta, A. Rahimi, L. Cazzanti, "Similarity-based classification: concepts and
       algorithms", Journal of Machine Learning Research 10, 2009, sec. 4.

    Examples
    --------
    >>> from sklearn.neighbors import KNeighborsClassifier
    >>> from sklearn.pipeline import make_pipeline
    >>> from skpose import Skeleton
    >>> from skpose.preprocessing import PoseDistanceTransformer
    >>> X = [[0.0, 0.0], [0.1, 0.0], [1.5, 0.0], [1.6, 0.2]]
    >>> knn = make_pipeline(PoseDistanceTransformer(Skeleton.chain(2)), KNeighborsClassifier(1, metric="precomputed"))
    >>> knn.fit(X, ["out", "out", "up", "up"]).predict([[1.2, 0.1]])
    array(['up'], dtype='<U3')
    """

    _parameter_constraints: ClassVar[dict] = {
        **POSE_CONSTRAINTS,
        **KERNEL_CONSTRAINTS,
    }

    def __init__(
        self,
        skeleton=None,
        *,
        metric="auto",
        kernel=None,
        gamma="scale",
        psd="ignore",
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.metric = metric
        self.kernel = kernel
        self.gamma = gamma
        self.psd = psd
        self.n_jobs = n_jobs
        self.verbose = verbose

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None):
        """Store the training poses.

        Parameters
        ----------
        X : array-like of shape (n_samples_fit, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        PoseDistanceTransformer
            The fitted transformer.
        """
        self._learn(X)
        return self

    @fit_context(prefer_skip_nested_validation=True)
    def fit_transform(self, X, y=None):
        """Distances among the training poses, or their kernel; each pair is computed once.

        Parameters
        ----------
        X : array-like of shape (n_samples_fit, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        ndarray of shape (n_samples_fit, n_samples_fit)
            Exactly symmetric; distances have an exactly zero diagonal. float32 for float32 poses, else float64.
        """
        kernel = self._learn(X)
        return self._similarity(self._distances(self._X, None)) if kernel is None else kernel

    def transform(self, X):
        """Distances from poses to the training poses, or their kernel.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        ndarray of shape (n_samples, n_samples_fit)
            Distances; float32 where both X and the training poses are, else float64.
        """
        check_is_fitted(self, "n_samples_fit_")
        return self._similarity(self._distances(self._check_X(X, reset=False), self._X))

    def _learn(self, X):
        """Learn from the training poses; the result is their kernel if it had to be computed, else None."""
        self.X_fit_ = self._X = self._check_X(X, reset=True, copy=True)

        def among(rows):
            return self._distances(self.X_fit_ if rows is None else self.X_fit_[rows], None)

        kernel = self._learn_kernel(len(self.X_fit_), among)
        self.n_samples_fit_ = len(self.X_fit_)
        return kernel

    @property
    def _n_features_out(self):
        return self.n_samples_fit_

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.transformer_tags.preserves_dtype = ["float64", "float32"]
        return tags
