"""The k nearest motions as a sparse graph."""

from typing import ClassVar

import numpy as np

from skpose._utils.sklearn import fit_context
from skpose.metrics._matrix import warn_of_unconverged
from skpose.metrics._registry import OF_MOTIONS
from skpose.motions._distances import ALIGNMENT_CONSTRAINTS
from skpose.motions._inputs import MotionEstimatorMixin
from skpose.motions._search import Request, SequenceIndex, find
from skpose.neighbors import PoseKNeighborsTransformer


class MotionKNeighborsTransformer(MotionEstimatorMixin, PoseKNeighborsTransformer):
    """Transform motions into the sparse graph of their exact k nearest training motions.

    The counterpart of scikit-learn's ``KNeighborsTransformer`` under dynamic time warping with a distance of poses.
    Any estimator that takes a sparse precomputed graph can use it::

        make_pipeline(MotionKNeighborsTransformer(skeleton), KNeighborsClassifier(metric="precomputed"))

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all motions. None takes it from the `Motion` objects; arrays need it except for "angle".
    mode : {"distance", "connectivity"}, default="distance"
        Whether the graph holds distances or ones.
    n_neighbors : int, default=5
        Neighbours of each motion in the graph; with ``mode="distance"`` one more, as in scikit-learn, because each
        training motion is its own neighbour.
    algorithm : {"auto", "brute"}, default="auto"
        "auto" skips motions that lower bounds rule out, "brute" aligns every pair. The result is the same.
    metric : str or Metric, default="auto"
        The distance between frames, see `skpose.motion_distances`; "auto" is "spatial" with a skeleton, else "angle"
        with a warning. "rotation" and ``Angle(wrap=True)`` have no bound and are searched by brute force.
    window : float between 0 and 1, default=None
        Sakoe–Chiba band, see `skpose.motion_distances`; None sets no limit.
    n_jobs : int, default=None
        Threads, or workers of the backend of a ``joblib.parallel_config`` context; -1 uses all processors. The result
        does not depend on it.
    verbose : int, default=0
        Whether to show progress.

    Attributes
    ----------
    metric_ : Metric
        The distance between poses in use, a copy of the parameter.
    window_ : float or None
        The band of the paths in use.
    skeleton_ : Skeleton or None
        The skeleton in use.
    frame_rate_ : float or None
        Frame rate of the training motions, Hz; None for arrays.
    n_samples_fit_ : int
        Number of training motions.
    n_features_in_ : int
        Number of degrees of freedom seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` is a data frame of motions of one frame.

    Warns
    -----
    ConvergenceWarning
        If geodesics did not converge.

    See Also
    --------
    MotionDistanceTransformer : All distances.
    motion_distances : All distances, as a function.
    find_motion : The best matches in long recordings.
    PoseKNeighborsTransformer : The nearest poses.

    Notes
    -----
    The search is *filter and refine* with dynamic time warping [1]_. For every pair of frames the chord is never longer
    than the curve, ‖F(a) − F(b)‖ ≤ "geodesic" ≤ "spatial", so the same holds for the least sum along a path. Bounds are
    taken in order of their cost: the first and the last frames; the query's frames against boxes around eight frames
    along the principal axes of the joint positions; dynamic time warping of the components along these axes [2]_. The
    remaining motions are aligned under the metric in order of their bounds, until no bound is within the k-th distance.
    An alignment measures only those pairs of frames that a path within that distance can go through [3]_.

    Distances are computed in float64, also for float32 poses. Indices and distances are bit for bit as from
    ``motion_distances(X, X_fit)`` in float64, sorted by distance and then by index.

    A search takes some milliseconds per query. If all alignments take less, or k is more than a fifth of the training
    motions, all are computed. Memory O(frames of the training motions): the poses and 90 bytes per frame.

    References
    ----------
    .. [1] H. Sakoe, S. Chiba, "Dynamic programming algorithm optimization for spoken word recognition", IEEE
       Transactions on Acoustics, Speech, and Signal Processing 26(1), 1978, :doi:`10.1109/TASSP.1978.1163055`.
    .. [2] E. Keogh, C. A. Ratanamahatana, "Exact indexing of dynamic time warping", Knowledge and Information Systems
       7, 2005, :doi:`10.1007/s10115-004-0154-9`.
    .. [3] M. Herrmann, G. I. Webb, "Early abandoning and pruning for elastic distances including dynamic time warping",
       Data Mining and Knowledge Discovery 35, 2021, :doi:`10.1007/s10618-021-00782-4`.

    Examples
    --------
    Two swings of an arm that go far, and two that do not:

    >>> import numpy as np
    >>> from sklearn.neighbors import KNeighborsClassifier
    >>> from sklearn.pipeline import make_pipeline
    >>> from skpose import Skeleton
    >>> from skpose.motions import MotionKNeighborsTransformer
    >>> X = [np.linspace([0.0, 0.0], [reach, 0.0], n) for reach, n in ((1.0, 12), (1.1, 15), (2.0, 12), (2.1, 9))]
    >>> neighbors = MotionKNeighborsTransformer(Skeleton.chain(2), n_neighbors=1).fit(X)
    >>> neighbors.transform(X).toarray().round(3)
    array([[0.   , 0.035, 0.   , 0.   ],
           [0.035, 0.   , 0.   , 0.   ],
           [0.   , 0.   , 0.   , 0.082],
           [0.   , 0.   , 0.082, 0.   ]])
    >>> knn = make_pipeline(neighbors, KNeighborsClassifier(1, metric="precomputed"))
    >>> knn.fit(X, ["near", "near", "far", "far"]).predict([np.linspace([0.0, 0.0], [1.9, 0.1], 20)])
    array(['far'], dtype='<U4')
    """

    _index: SequenceIndex  # type: ignore[assignment]  # of motions

    _parameter_constraints: ClassVar[dict] = {
        **PoseKNeighborsTransformer._parameter_constraints,
        "metric": OF_MOTIONS,
        "window": ALIGNMENT_CONSTRAINTS["window"],
    }

    def __init__(
        self,
        skeleton=None,
        *,
        mode="distance",
        n_neighbors=5,
        algorithm="auto",
        metric="auto",
        window=None,
        n_jobs=None,
        verbose=0,
    ):
        super().__init__(
            skeleton,
            mode=mode,
            n_neighbors=n_neighbors,
            algorithm=algorithm,
            metric=metric,
            n_jobs=n_jobs,
            verbose=verbose,
        )
        self.window = window

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None):
        """Index the training motions.

        Parameters
        ----------
        X : list of array-like of shape (n_frames, n_dofs), list of Motion, MotionDataset, or array of three dimensions
            Motions, see `skpose.motion_distances`. Each row of an array of two dimensions is a motion of one frame.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        MotionKNeighborsTransformer
            The fitted transformer.
        """
        X = self._check_X(X, reset=True)
        self._index = SequenceIndex(X, self.skeleton_, self.metric_, brute=self.algorithm == "brute")
        self.n_samples_fit_ = X.n_motions
        return self

    def _find(self, X, **criterion):
        k = criterion["k"]
        if X is None:
            queries, excluded = self._index.sequences, np.arange(self.n_samples_fit_)
        else:
            queries = self._check_X(X, reset=False)
            excluded = np.full(queries.n_motions, -1)
        found = find(Request(self._index, queries, excluded, k, self.window_), self.n_jobs, self.verbose)
        warn_of_unconverged(found.unconverged, found.n_measured)
        return found.neighbors, queries.n_motions
