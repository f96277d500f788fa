"""The common base of the transformers into graphs of neighbours: the index, its searches, and graphs of the results."""

from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array, csr_matrix
from sklearn import get_config
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin

from skpose._base import POSE_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.sklearn import StrOptions, fit_context
from skpose._utils.validation import check_choice, check_integer
from skpose.metrics._matrix import warn_of_unconverged
from skpose.neighbors._index import PoseIndex
from skpose.neighbors._queries import Request, find


class GraphTransformer(PoseEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator):
    """A transformer of poses into the sparse graph of their neighbours among the training poses."""

    _parameter_constraints: ClassVar[dict] = {
        **POSE_CONSTRAINTS,
        "mode": [StrOptions(["distance", "connectivity"])],
        "algorithm": [StrOptions(["auto", "brute"])],
    }

    @fit_context(prefer_skip_nested_validation=True)
    def fit(self, X, y=None):
        """Index the training poses.

        Parameters
        ----------
        X : array-like of shape (n_samples_fit, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        PoseKNeighborsTransformer or PoseRadiusNeighborsTransformer
            The fitted transformer.
        """
        X = self._check_X(X, reset=True, copy=True)
        self._index = PoseIndex(X, self.skeleton_, self.metric_, brute=self.algorithm == "brute")
        self._index.sort_groups()
        self.n_samples_fit_ = len(X)
        return self

    def _find(self, X, **criterion):
        """Return the neighbours of X, as in `kneighbors`, and the number of queries; `criterion` as for `Request`."""
        if X is None:
            X, excluded = self._index.poses, np.arange(self.n_samples_fit_)
        else:
            X = self._check_X(X, reset=False)
            excluded = np.full(len(X), -1)
        found = find(Request(self._index, X, excluded, **criterion), self.n_jobs, self.verbose)
        warn_of_unconverged(found.unconverged, found.n_measured)
        return found.neighbors, len(X)

    def _graph(self, X, mode, **criterion):
        """Return the graph of the neighbours of X."""
        check_choice("mode", mode, ("connectivity", "distance"))
        neighbors, n_queries = self._find(X, **criterion)
        data = neighbors.distances if mode == "distance" else np.ones(len(neighbors.indices))
        indptr = np.searchsorted(neighbors.queries, np.arange(n_queries + 1))
        return sparse_graph(data, neighbors.indices, indptr, (n_queries, self.n_samples_fit_))

    @property
    def _n_features_out(self):
        return self.n_samples_fit_


def check_k(n_neighbors, excludes_itself, n_samples_fit):
    """Return a number of neighbours, as an int, that the training data have."""
    check_integer(n_neighbors, 1, "n_neighbors")
    if n_neighbors > n_samples_fit - excludes_itself:
        raise ValueError(
            f"Expected n_neighbors {'<' if excludes_itself else '<='} n_samples_fit, but n_neighbors = {n_neighbors}, "
            f"n_samples_fit = {n_samples_fit}"
        )
    return int(n_neighbors)


def sparse_graph(data, indices, indptr, shape):
    """Return a graph in CSR format, as the array or the matrix that scikit-learn is configured for."""
    sparse = csr_array if get_config().get("sparse_interface") == "sparray" else csr_matrix
    return sparse((data, indices, indptr), shape=shape)
