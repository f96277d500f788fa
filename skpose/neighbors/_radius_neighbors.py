"""The graph of all neighbours within a radius."""

from numbers import Real
from typing import ClassVar

import numpy as np
from sklearn.utils.validation import check_is_fitted

from skpose._utils.sklearn import Interval
from skpose.neighbors._graph import GraphTransformer


class PoseRadiusNeighborsTransformer(GraphTransformer):
    """Transform poses into the sparse graph of all training poses within a radius.

    The counterpart of scikit-learn's ``RadiusNeighborsTransformer`` under the distances of poses::

        make_pipeline(PoseRadiusNeighborsTransformer(skeleton, radius=0.5), DBSCAN(eps=0.3, metric="precomputed"))

    Parameters
    ----------
    skeleton : Skeleton, default=None
        The skeleton of all poses. Needed by all metrics but "angle".
    mode : {"distance", "connectivity"}, default="distance"
        Whether the graph holds distances or ones.
    radius : float, default=1.0
        Neighbours are no further away than this; m, or rad for "angle".
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
    PoseKNeighborsTransformer : The k nearest; its notes describe the search.

    Notes
    -----
    Poses whose lower bound exceeds the radius are not measured. Where distances are not requested, no geodesic is
    solved whose straight line is within the radius already.

    Time and memory as of `PoseKNeighborsTransformer`, with the poses whose bound is within the radius instead of the
    neighbours; sorting the result takes about five times its memory.

    References
    ----------
    S. Hauberg, K. S. Pedersen, "Spatial measures between human poses for classification and understanding", AMDO
    2012, :doi:`10.1007/978-3-642-31567-1_3`.

    Examples
    --------
    >>> from sklearn.cluster import DBSCAN
    >>> from sklearn.pipeline import make_pipeline
    >>> from skpose import Skeleton
    >>> from skpose.neighbors import PoseRadiusNeighborsTransformer
    >>> X = [[0.0, 0.0], [0.1, 0.0], [1.5, 0.0], [1.6, 0.2]]
    >>> neighbors = PoseRadiusNeighborsTransformer(Skeleton.chain(2), radius=0.5)
    >>> neighbors.fit_transform(X).toarray().round(2)
    array([[0.  , 0.22, 0.  , 0.  ],
           [0.22, 0.  , 0.  , 0.  ],
           [0.  , 0.  , 0.  , 0.41],
           [0.  , 0.  , 0.41, 0.  ]])
    >>> make_pipeline(neighbors, DBSCAN(eps=0.45, min_samples=2, metric="precomputed")).fit_predict(X)
    array([0, 0, 1, 1])
    """

    _parameter_constraints: ClassVar[dict] = {
        **GraphTransformer._parameter_constraints,
        "radius": [Interval(Real, 0, None, closed="both")],
    }

    def __init__(
        self,
        skeleton=None,
        *,
        mode="distance",
        radius=1.0,
        algorithm="auto",
        metric="auto",
        n_jobs=None,
        verbose=0,
    ):
        self.skeleton = skeleton
        self.mode = mode
        self.radius = radius
        self.algorithm = algorithm
        self.metric = metric
        self.n_jobs = n_jobs
        self.verbose = verbose

    def transform(self, X):
        """Compute the graph of the training poses within the radius.

        Parameters
        ----------
        X : array-like of shape (n_samples, n_dofs)
            Poses: joint angles, rad.

        Returns
        -------
        sparse matrix of shape (n_samples, n_samples_fit)
            In CSR format, each row by distance; zero distances are stored explicitly.
        """
        return self.radius_neighbors_graph(X, mode=self.mode)

    def radius_neighbors(self, X=None, radius=None, return_distance=True):
        """Find all training poses within a radius.

        Parameters
        ----------
        X : array-like of shape (n_queries, n_dofs), default=None
            Poses: joint angles, rad. None is the training poses; a pose is then not its own neighbour.
        radius : float, default=None
            Neighbours are no further away than this; m, or rad for "angle". None takes the constructor's.
        return_distance : bool, default=True
            Whether to return the distances too.

        Returns
        -------
        distances : ndarray of shape (n_queries,) of ndarrays
            In m, or rad for "angle"; float64, also for float32 poses. Only if requested.
        indices : ndarray of shape (n_queries,) of ndarrays
            The neighbours, by distance and then by index; without distances, by index.

        Raises
        ------
        TypeError
            For a radius that is not one number, such as an array with one for each pose.
        ValueError
            For a negative radius.
        """
        near, n_queries = self._find(X, radius=self._radius(radius), measured=return_distance)
        starts = np.searchsorted(near.queries, np.arange(1, n_queries))
        order = slice(None) if return_distance else np.lexsort((near.indices, near.queries))
        distances, indices = (_object_array(np.split(part, starts)) for part in (near.distances, near.indices[order]))
        return (distances, indices) if return_distance else indices

    def radius_neighbors_graph(self, X=None, radius=None, mode="connectivity"):
        """Compute the graph of all training poses within a radius.

        Parameters
        ----------
        X : array-like of shape (n_queries, n_dofs), default=None
            Poses, as for `radius_neighbors`.
        radius : float, default=None
            As for `radius_neighbors`.
        mode : {"connectivity", "distance"}, default="connectivity"
            Whether the graph holds ones or distances.

        Returns
        -------
        sparse matrix of shape (n_queries, n_samples_fit)
            In CSR format; rows of distances are sorted.
        """
        return self._graph(X, mode, radius=self._radius(radius), measured=mode == "distance")

    def _radius(self, radius):
        check_is_fitted(self, "n_samples_fit_")
        radius = self.radius if radius is None else radius
        if not isinstance(radius, Real):
            raise TypeError(f"radius must be one number for all poses, got {radius!r}: call once for each radius")
        radius = float(radius)
        if not radius >= 0:
            raise ValueError(f"radius must be zero or more, got {radius}")
        return radius


def _object_array(parts):
    """Return an array of arrays, also where all are of one length."""
    ragged = np.empty(len(parts), dtype=object)
    ragged[:] = parts
    return ragged
