"""The graph of the k nearest neighbours."""

from numbers import Integral
from typing import ClassVar

from sklearn.utils.validation import check_is_fitted

from skpose._utils.sklearn import Interval
from skpose.neighbors._graph import GraphTransformer, check_k


class PoseKNeighborsTransformer(GraphTransformer):
    """Transform poses into the sparse graph of their exact k nearest training poses.

    The counterpart of scikit-learn's ``KNeighborsTransformer`` under the distances of poses. Every estimator that takes
    a sparse precomputed graph can use it::

        make_pipeline(PoseKNeighborsTransformer(skeleton), KNeighborsClassifier(metric="precomputed"))
        make_pipeline(PoseKNeighborsTransformer(skeleton, n_neighbors=91), TSNE(metric="precomputed", init="random"))

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Needed by all metrics but "angle".
    mode : {"distance", "connectivity"}, default="distance"
        Whether the graph holds distances or ones.
    n_neighbors : int, default=5
        Neighbours of each pose in the graph. As each training pose counts as its own neighbour, there is one more with
        ``mode="distance"``, as in scikit-learn.
    algorithm : {"auto", "brute"}, default="auto"
        "auto" measures only what a lower bound does not rule out, "brute" every pair. The result is the same.
    metric : str or Metric, default="auto"
        The distance, see `skpose.pose_distances`; "auto" is "spatial" with a skeleton, else "angle" and a warning.
        "rotation" and ``Angle(wrap=True)`` have no bound and are searched by brute force.
    n_jobs : int, default=None
        Threads; None is 1 unless in a ``joblib.parallel_config`` context, -1 all processors. Where that context names
        a backend of processes or a cluster, the search runs there. The result does not depend on it.
    verbose : int, default=0
        Whether to show the progress of a search.

    Attributes
    ----------
    metric_ : Metric
        The metric in use, a copy of the parameter.
    skeleton_ : Skeleton or None
        The skeleton in use.
    n_samples_fit_ : int
        Number of training poses.
    n_features_in_ : int
        Number of features seen during `fit`.
    feature_names_in_ : ndarray of shape (`n_features_in_`,)
        Names of features seen during `fit`. Defined only when `X` has feature names that are all strings.

    Warns
    -----
    ConvergenceWarning
        From a search, if geodesics did not converge.

    See Also
    --------
    PoseRadiusNeighborsTransformer : The same within a radius.
    pose_distances : All distances, as a matrix.

    Notes
    -----
    The search is *filter and refine*: a cheap lower bound of the distance rules out most poses, and only the rest, the
    candidates, are measured. A chord is never longer than a curve, ‖F(a) − F(b)‖ ≤ "geodesic" ≤ "spatial". So no pose
    whose chord exceeds the k-th shortest length found so far can be among the k nearest, although "spatial" obeys no
    triangle inequality and a ball tree cannot be used. The chords themselves are bounded by their components along the
    principal axes of the joint positions, in float32 and with an allowance for its rounding. The length of a straight
    line is no less than that of its first steps and one chord from there; where these are too long already, it is not
    measured. A geodesic is solved only if its interval, from the chord to the length of the
    straight line, can change the answer.

    `fit` puts poses that are near each other into groups of sixteen, with a box around the chords' components of each
    group, and a box around sixteen of these; the frames of recordings stay in their order. A search visits the boxes in
    the order of their distances, until the next one is out of reach.

    Every distance is computed in float64, also for float32 poses: indices and distances are equal to those from
    ``pose_distances(X, X_fit)`` in float64, sorted by distance and then by index. Where the bounds rule out little, all
    poses are measured; a search never costs much more than brute force.

    Time O(n_samples · n_neighbors · n_dofs · n_steps) for the lengths if the poses are dense; more where queries are of
    another person. Among 100,000 to a million poses it grows like the 0.7th power of n_samples_fit. Memory
    O(n_samples_fit), with the poses some 0.8 GB for a million of 56 columns. Of the parameters of scikit-learn's
    transformer `leaf_size`, `p` and `metric_params` are missing: there are no leaves, no Minkowski distance, and a
    metric has its own parameters.

    References
    ----------
    S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding", AMDO
    2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from sklearn.neighbors import KNeighborsClassifier
    >>> from sklearn.pipeline import make_pipeline
    >>> from skpose import PoseKNeighborsTransformer, Skeleton
    >>> X = [[0.0, 0.0], [0.1, 0.0], [1.5, 0.0], [1.6, 0.2]]
    >>> neighbors = PoseKNeighborsTransformer(Skeleton.chain(2), n_neighbors=1).fit(X)
    >>> distances, indices = neighbors.kneighbors([[1.2, 0.1]])
    >>> indices
    array([[2]])
    >>> neighbors.transform(X).toarray().round(2)
    array([[0.  , 0.22, 0.  , 0.  ],
           [0.22, 0.  , 0.  , 0.  ],
           [0.  , 0.  , 0.  , 0.41],
           [0.  , 0.  , 0.41, 0.  ]])
    >>> knn = make_pipeline(neighbors, KNeighborsClassifier(1, metric="precomputed"))
    >>> knn.fit(X, ["out", "out", "up", "up"]).predict([[1.2, 0.1]])
    array(['up'], dtype='<U3')
    """

    _parameter_constraints: ClassVar[dict] = {
        **GraphTransformer._parameter_constraints,
        "n_neighbors": [Interval(Integral, 1, None, closed="left")],
    }

    def __init__(
        self,
        skeleton=None,
        *,
        mode="distance",
        n_neighbors=5,
        algorithm="auto",
        metric="auto",
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.mode = mode
        self.n_neighbors = n_neighbors
        self.algorithm = algorithm
        self.metric = metric
        self.n_jobs = n_jobs
        self.verbose = verbose

    def transform(self, X):
        """Compute the graph of the nearest training poses.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        sparse matrix of shape (n_samples, n_samples_fit)
            In CSR format, each row by distance; zero distances are stored explicitly.
        """
        return self.kneighbors_graph(X, self.n_neighbors + (self.mode == "distance"), self.mode)

    def kneighbors(self, X=None, n_neighbors=None, return_distance=True):
        """Find the k nearest training poses.

        Parameters
        ----------
        X : array-like of shape (n_queries, n_dofs), default=None
            Poses: joint angles, rad. None is the training poses; a pose is then not its own neighbour.
        n_neighbors : int, default=None
            Number of neighbours; None takes the constructor's.
        return_distance : bool, default=True
            Whether to return the distances too.

        Returns
        -------
        distances : ndarray of shape (n_queries, n_neighbors)
            In m, or rad for "angle"; float64, also for float32 poses. Only if requested.
        indices : ndarray of shape (n_queries, n_neighbors)
            By distance, those equally far away by index.

        Raises
        ------
        ValueError
            For more neighbours than there are training poses.
        """
        near, n_queries = self._find(X, k=self._k(X, n_neighbors))
        distances, indices = (part.reshape(n_queries, -1) for part in (near.distances, near.indices))
        return (distances, indices) if return_distance else indices

    def kneighbors_graph(self, X=None, n_neighbors=None, mode="connectivity"):
        """Compute the graph of the k nearest training poses.

        Parameters
        ----------
        X : array-like of shape (n_queries, n_dofs), default=None
            Poses, as for `kneighbors`.
        n_neighbors : int, default=None
            Number of neighbours; None takes the constructor's.
        mode : {"connectivity", "distance"}, default="connectivity"
            Whether the graph holds ones or distances.

        Returns
        -------
        sparse matrix of shape (n_queries, n_samples_fit)
            In CSR format, each row by distance.
        """
        return self._graph(X, mode, k=self._k(X, n_neighbors))

    def _k(self, X, n_neighbors):
        check_is_fitted(self, "n_samples_fit_")
        return check_k(self.n_neighbors if n_neighbors is None else n_neighbors, X is None, self.n_samples_fit_)
