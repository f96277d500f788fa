"""Distances to the training motions as a step of a scikit-learn pipeline."""

from typing import ClassVar

from skpose.metrics._matrix import warn_of_unconverged
from skpose.motions._distances import MOTION_CONSTRAINTS, MotionMatrix, check_alignment
from skpose.motions._inputs import MotionEstimatorMixin
from skpose.preprocessing._distances import KERNEL_CONSTRAINTS, PoseDistanceTransformer


class MotionDistanceTransformer(MotionEstimatorMixin, PoseDistanceTransformer):
    r"""Transform motions to their distances from the training motions, or to a kernel of these distances.

    Any estimator that takes precomputed distances or a precomputed kernel then works on motions of different lengths::

        make_pipeline(MotionDistanceTransformer(skeleton, kernel="rbf"), SVC(kernel="precomputed"))
        make_pipeline(MotionDistanceTransformer(skeleton), SpatialMDS(metric="precomputed"))

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all motions. None takes it from the `Motion` objects of `fit`, or their mean; arrays need it
        except for "angle".
    metric : str or Metric, default="auto"
        The distance between frames, see `motion_distances`; "auto" is "spatial" with a skeleton, else "angle" with a
        warning.
    alignment : {"dtw", "subsequence", "frames"}, default="dtw"
        "dtw" warps both motions as a whole, "subsequence" finds the motion of X inside the training motion, "frames"
        compares the frames i of motions of equal length, see `motion_distances`.
    window : float between 0 and 1, default=None
        Sakoe–Chiba band of "dtw", as a share of the durations; None sets no limit.
    kernel : {"rbf", "laplacian"} or None, default=None
        None gives distances d, "rbf" gives :math:`\exp(-\gamma d^2)` and "laplacian" :math:`\exp(-\gamma d)`. Kernels
        of dynamic time warping need not be positive semidefinite, see `psd`.
    gamma : "scale" or float, default="scale"
        The γ of the kernel. "scale" is 2 / m and √(2 / m), with m the mean squared distance between at most 500
        training motions, evenly spread.
    psd : {"ignore", "clip", "shift"}, default="ignore"
        Treatment of negative eigenvalues of the kernel, see `PoseDistanceTransformer`. Only with a kernel.
    n_jobs : int, default=None
        Threads, or workers of a ``joblib.parallel_config`` context, see `motion_distances`.
    verbose : int, default=0
        Whether to show progress.

    Attributes
    ----------
    metric_ : Metric
        The distance between poses in use, a copy of the parameter.
    alignment_ : str
        How motions are aligned.
    window_ : float or None
        The Sakoe–Chiba band in use.
    skeleton_ : Skeleton or None
        The skeleton in use.
    frame_rate_ : float or None
        Frame rate of the training motions, Hz; None for arrays.
    gamma_ : float
        The γ in use. Only with a kernel.
    negative_share_ : float
        Magnitudes of the negative eigenvalues of the training motions' kernel, as a share of all, before they are
        removed. Only with `psd` "clip" and "shift".
    n_samples_fit_ : int
        Number of training motions.
    n_features_in_ : int
        Number of features seen during `fit`: the degrees of freedom of a frame.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has two dimensions, and feature names that are all
        strings.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.
    UserWarning
        If the poses look like degrees, see `pose_distances`.

    See Also
    --------
    motion_distances : The distances as a function.
    MotionKNeighborsTransformer : The nearest motions, without computing most distances.
    PoseDistanceTransformer : The same for poses.

    Notes
    -----
    X is a list of motions, arrays (n_frames, n_dofs) or `Motion`, whose lengths may differ; a `MotionDataset`; or an
    array (n_motions, n_frames, n_dofs). Each row of a two-dimensional array is a motion of one frame. `transform` takes
    Motions if `fit` got Motions, and arrays if `fit` got arrays. Cross-validation can split lists, collections and
    arrays.

    Time O(frames of X · frames of the training motions) distances between poses, memory O(n_samples · n_samples_fit);
    all training motions are stored. If only the nearest motions are needed, `MotionKNeighborsTransformer` is faster.

    Each fold of a cross-validation computes its distances anew. To compute them once, pass the matrix of
    `motion_distances` with a given `skeleton` to an estimator with ``metric="precomputed"``: scikit-learn splits its
    rows and columns. ``Pipeline(memory=)`` helps a grid search over later steps.

    Dynamic time warping does not obey the triangle inequality: use ``algorithm="brute"`` or ``metric="precomputed"`` in
    the steps that follow.

    Examples
    --------
    The arm goes up once or twice, at any speed; the first frames alone do not show which:

    >>> import numpy as np
    >>> from sklearn.pipeline import make_pipeline
    >>> from sklearn.svm import SVC
    >>> from skpose import Skeleton
    >>> from skpose.motions import MotionDistanceTransformer
    >>> def swings(times, n_frames):
    ...     return np.sin(np.linspace(0, times * np.pi, n_frames))[:, np.newaxis] ** 2
    >>> X = [swings(1, 20), swings(1, 33), swings(2, 20), swings(2, 41)]
    >>> kernel = MotionDistanceTransformer(Skeleton.chain(1), kernel="rbf")
    >>> svc = make_pipeline(kernel, SVC(kernel="precomputed"))
    >>> svc.fit(X, ["once", "once", "twice", "twice"]).predict([swings(1, 50), swings(2, 30)])
    array(['once', 'twice'], dtype='<U5')
    """

    _parameter_constraints: ClassVar[dict] = {**MOTION_CONSTRAINTS, **KERNEL_CONSTRAINTS}

    def __init__(
        self,
        skeleton=None,
        *,
        metric="auto",
        alignment="dtw",
        window=None,
        kernel=None,
        gamma="scale",
        psd="ignore",
        n_jobs=None,
        verbose=0,
    ):
        super().__init__(skeleton, metric=metric, kernel=kernel, gamma=gamma, psd=psd, n_jobs=n_jobs, verbose=verbose)
        self.alignment = alignment
        self.window = window

    def _learn(self, X):
        """Learn from the training motions; return their kernel if that computes it, else None."""
        self._X = self._check_X(X, reset=True)
        check_alignment(self.alignment, self.window, self.metric_, X=self._X)
        if self.kernel is not None and self.alignment == "subsequence":
            raise ValueError('alignment="subsequence" is not symmetric and has no kernel: use kernel=None')

        def among(rows):
            return self._distances(self._X if rows is None else self._X.take(rows), None)

        kernel = self._learn_kernel(self._X.n_motions, among)
        self.n_samples_fit_ = self._X.n_motions
        return kernel

    def _distances(self, X, Y, verbose=None):
        if Y is not None:
            check_alignment(self.alignment_, self.window_, self.metric_, X=X, X_fit=Y)
        matrix = MotionMatrix(X, Y, self.metric_, self.skeleton_, alignment=self.alignment_, window=self.window_)
        distances, unconverged = matrix.write(None, self.n_jobs, self.verbose if verbose is None else verbose)
        warn_of_unconverged(unconverged, matrix.n_cells)
        return distances
