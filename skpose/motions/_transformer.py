"""Distances to the training motions as a step of a scikit-learn pipeline."""

import os
from typing import ClassVar

from joblib import Memory
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from skpose._compat.sklearn import fit_context
from skpose.motions._base import MotionEstimatorMixin
from skpose.motions._distances import MOTION_CONSTRAINTS, check_alignment
from skpose.motions._memory import folder_of
from skpose.preprocessing._shared import KERNEL_CONSTRAINTS, KernelMixin


class MotionDistanceTransformer(
    KernelMixin, MotionEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator
):
    r"""Transform whole motions to their distances from the training motions, or to a kernel of these distances.

    The result is what scikit-learn calls precomputed, so that every estimator that takes a matrix of distances or a
    kernel works on motions of different lengths::

        make_pipeline(MotionDistanceTransformer(skeleton, kernel="rbf"), SVC(kernel="precomputed"))
        make_pipeline(MotionDistanceTransformer(skeleton), SpatialMDS(metric="precomputed"))

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all motions. None is that of the `Motion` objects of `fit`, where they differ their mean; arrays
        need it, but for "angle".
    metric : str or Metric, default="auto"
        The distance between frames, see `motion_distances`; "auto" is "spatial" with a skeleton, else "angle" and a
        warning.
    alignment : {"dtw", "subsequence", "frames"}, default="dtw"
        "dtw" warps the whole of both motions, "subsequence" looks for the motion of X inside the training motion, and
        "frames" takes the pairs (i, i) of motions of equal length, see `motion_distances`.
    window : float between 0 and 1, default=None
        Sakoe–Chiba band of "dtw", as a share of the durations; None is no limit.
    kernel : {"rbf", "laplacian"} or None, default=None
        None gives distances d, "rbf" gives :math:`\exp(-\gamma d^2)` and "laplacian" :math:`\exp(-\gamma d)`. Under
        dynamic time warping neither need be positive semidefinite, see `psd`.
    gamma : "scale" or float, default="scale"
        The γ of the kernel. "scale", which is chosen in `fit`, is 2 / m and √(2 / m) with m the mean squared distance
        between training motions (of at most 500, evenly spread over them).
    psd : {"ignore", "clip", "shift"}, default="ignore"
        Treatment of negative eigenvalues of the kernel, see `PoseDistanceTransformer`. Only with a kernel.
    memory : str, path-like or joblib.Memory, default=None
        A folder for the distances, as of a scikit-learn ``Pipeline``: those that are there are taken, others are
        computed and added. None keeps none. The result does not depend on it.
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
        Frame rate of the training motions, Hz; None for arrays, which have none.
    gamma_ : float
        The γ in use. Only with a kernel.
    negative_share_ : float
        Sum of the magnitudes of the negative eigenvalues of the training motions' kernel, before its repair, over that
        of all. Only with `psd` "clip" and "shift".
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
    MotionKNeighborsTransformer : The nearest motions without most of the distances: for nearest-neighbour classifiers.
    PoseDistanceTransformer : The same for single poses.

    Notes
    -----
    X is a list of motions, arrays (n_frames, n_dofs) or `Motion`, whose lengths may differ; a `MotionDataset`; or an
    array (n_motions, n_frames, n_dofs). Each row of an array of two dimensions is a motion of one frame. What follows
    `fit` must be of the same kind: Motions have a frame rate and a skeleton, by whose names their columns are
    recognised, and arrays do not. Cross-validation can split lists, collections and arrays.

    Where only the nearest motions are asked for, `MotionKNeighborsTransformer` finds the same ones: of 188 motions of
    HDM05 at 12 Hz under "spatial" in 1.9 s of the processor, where all distances take 11.6 s. Under "position" all
    distances take 0.2 s.

    All frames of the training motions are stored. Time O(frames of X · frames of the training motions) distances
    between poses, memory O(n_samples · n_samples_fit).

    With `memory` the folds of a cross-validation compute each distance once, and so do the candidates of a grid search
    that differ in later steps alone, other processes and later runs. Pass `skeleton` then: the mean skeleton of the
    training motions is another one in each fold, and with it all distances. A distance is found by the content of both
    motions, the metric with its parameters, the skeleton, `alignment`, `window` and the version of skpose, never by
    index; of a metric of one's own also by the code of its functions and of those that they call by name. The distance
    from a to b and the one from b to a, which may differ in the last bit, are two. Files are written whole, after some
    ten seconds of work each: a run that was interrupted continues there. Processes that miss distances of one kind
    compute them one after the other; so give threads to the transformer rather than processes to the search. On disk a
    file holds a matrix of 8 bytes a number, 4 for float32 motions, blank where nothing was missing: 13 to 40 bytes a
    distance in all. Nothing is removed until the folder is deleted. In memory there is one file at a time, none larger
    than the result of the call that wrote it. On other kinds of processors the last bits may differ.

    Dynamic time warping obeys no triangle inequality: keep ``algorithm="brute"`` or ``metric="precomputed"`` in the
    steps that follow.

    Examples
    --------
    The arm goes up once or twice, at any speed; the first frames alone do not show which:

    >>> import numpy as np
    >>> from sklearn.pipeline import make_pipeline
    >>> from sklearn.svm import SVC
    >>> from skpose import MotionDistanceTransformer, Skeleton
    >>> def swings(times, n_frames):
    ...     return np.sin(np.linspace(0, times * np.pi, n_frames))[:, np.newaxis] ** 2
    >>> X = [swings(1, 20), swings(1, 33), swings(2, 20), swings(2, 41)]
    >>> kernel = MotionDistanceTransformer(Skeleton.chain(1), kernel="rbf")
    >>> svc = make_pipeline(kernel, SVC(kernel="precomputed"))
    >>> svc.fit(X, ["once", "once", "twice", "twice"]).predict([swings(1, 50), swings(2, 30)])
    array(['once', 'twice'], dtype='<U5')
    """

    _parameter_constraints: ClassVar[dict] = {
        **MOTION_CONSTRAINTS,
        **KERNEL_CONSTRAINTS,
        "memory": [str, os.PathLike, Memory, None],
    }

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
        memory=None,
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.metric = metric
        self.alignment = alignment
        self.window = window
        self.kernel = kernel
        self.gamma = gamma
        self.psd = psd
        self.memory = memory
        self.n_jobs = n_jobs
        self.verbose = verbose

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None):
        """Store the training motions.

        Parameters
        ----------
        X : list of array-like of shape (n_frames, n_dofs), list of Motion, MotionDataset, or array
            Motions: joint angles, and rotation vectors of ball joints, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        MotionDistanceTransformer
            The fitted transformer.
        """
        self._learn(X)
        return self

    @fit_context(prefer_skip_nested_validation=True)
    def fit_transform(self, X, y=None):
        """Return distances among the training motions, or their kernel; each pair is computed once.

        Parameters
        ----------
        X : list of array-like of shape (n_frames, n_dofs), list of Motion, MotionDataset, or array
            Motions: joint angles, and rotation vectors of ball joints, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        ndarray of shape (n_samples_fit, n_samples_fit)
            Exactly symmetric with a zero diagonal, but for "subsequence"; float32 for float32 motions where
            poses are compared, else float64.
        """
        kernel = self._learn(X)
        return self._similarity(self._distances(self._motions, None)) if kernel is None else kernel

    def transform(self, X):
        """Return distances from motions to the training motions, or their kernel.

        Parameters
        ----------
        X : list of array-like of shape (n_frames, n_dofs), list of Motion, MotionDataset, or array
            Motions, of the kind and the frame rate of those in `fit`.

        Returns
        -------
        ndarray of shape (n_samples, n_samples_fit)
            In m, rad for "angle", or m/s for "velocity"; as `fit_transform` float32 where both X and the training
            motions are.
        """
        check_is_fitted(self, "n_samples_fit_")
        motions = self._check_X(X, reset=False)
        check_alignment(self.alignment_, self.window_, self.metric_, X=motions, X_fit=self._motions)
        return self._similarity(self._distances(motions, self._motions))

    def _learn(self, X):
        """Learn from the training motions; return their kernel where it is needed for that, else None."""
        self._check_kernel()
        folder_of(self.memory)  # refuses a file before anything is computed
        self._motions = self._check_X(X, reset=True)
        check_alignment(self.alignment, self.window, self.metric_, X=self._motions)
        if self.kernel is not None and self.alignment == "subsequence":
            raise ValueError(
                'a kernel is symmetric, and alignment="subsequence" is not: take alignment="dtw" or "frames", or '
                "kernel=None"
            )

        def among(rows):
            return self._distances(self._motions if rows is None else self._motions.take(rows), None)

        kernel = self._learn_kernel(self._motions.n_motions, among)
        self.n_samples_fit_ = self._motions.n_motions
        return kernel

    @property
    def _n_features_out(self):
        return self.n_samples_fit_

    def __sklearn_tags__(self):
        tags = super().__sklearn_tags__()
        tags.transformer_tags.preserves_dtype = ["float64", "float32"]
        return tags
