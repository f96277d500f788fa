"""The common base of the transformers into graphs of neighbours: the index, its searches, and graphs of the results."""

from numbers import Integral
from typing import Any, ClassVar

import numpy as np
from scipy.sparse import csr_array, csr_matrix
from sklearn import get_config
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin

from skpose._base import PoseEstimatorMixin
from skpose._compat.sklearn import StrOptions, fit_context
from skpose.metrics._convergence import warn_of_unconverged
from skpose.metrics._registry import METRIC_CONSTRAINTS, effective_name, resolve
from skpose.neighbors._index import PoseIndex
from skpose.neighbors._queries import Request, find


class GraphTransformer(PoseEstimatorMixin, ClassNamePrefixFeaturesOutMixin, TransformerMixin, BaseEstimator):
    """A transformer of poses into the sparse graph of their neighbours among the training poses."""

    _parameter_constraints: ClassVar[dict] = {
        **METRIC_CONSTRAINTS,
        "mode": [StrOptions({"distance", "connectivity"})],
        "algorithm": [StrOptions({"auto", "brute"})],
        "n_jobs": [None, Integral],
        "verbose": ["verbose"],
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
        self : object
            The fitted transformer.
        """
        X = self._checked(X, reset=True)
        self._index = self._index_of(X)
        self.n_samples_fit_ = len(X)
        return self

    def fit_transform(self, X, y=None):
        """Index the training poses and compute the graph of neighbours among them.

        Parameters
        ----------
        X : array-like of shape (n_samples_fit, n_dofs)
            Poses: joint angles, rad.
        y : Ignored
            Not used, present for API consistency by convention.

        Returns
        -------
        sparse matrix of shape (n_samples_fit, n_samples_fit)
            As from `transform`: every pose is among its own neighbours.
        """
        return self.fit(X).transform(X)

    @property
    def n_evaluations_(self):
        """Numbers of distances that the last search evaluated, `skpose.neighbors.Evaluations`."""
        return self._index.evaluations

    def _index_of(self, X):
        chosen, steps = resolve(self.metric, self.skeleton, self.n_steps, self.wrap)
        self.effective_metric_ = effective_name(self.metric, self.skeleton)
        self.effective_metric_params_: dict[str, Any] = {}
        if chosen.wraps is not None:
            self.effective_metric_params_["wrap"] = steps.half_turn < np.inf
        if chosen.wraps:
            self.effective_metric_params_["n_steps"] = self.n_steps
        return PoseIndex(X, self.skeleton, self.effective_metric_, steps, brute=self.algorithm == "brute")

    def _find(self, X, criterion, stacklevel=3):
        """Return the neighbours of X, as in `kneighbors`, and the number of queries; `criterion` as for `Request`."""
        if X is None:
            X, excluded = self._index.poses, np.arange(self.n_samples_fit_)
        else:
            X = self._checked(X, reset=False)
            excluded = np.full(len(X), -1)
        found = find(Request(criterion, self._index, X, excluded), self.n_jobs, self.verbose)
        self._index.evaluations = found.evaluations
        warn_of_unconverged(found.unconverged, found.evaluations.geodesics, stacklevel)
        return found.neighbors, len(X)

    def _graph(self, X, criterion, mode):
        """Return the graph of the neighbours of X."""
        if mode not in ("connectivity", "distance"):
            raise ValueError(f'mode must be "connectivity" or "distance", got {mode!r}')
        found, n_queries = self._find(X, criterion, stacklevel=4)
        data = found.distances if mode == "distance" else np.ones(len(found.indices))
        indptr = np.searchsorted(found.queries, np.arange(n_queries + 1))
        shape = n_queries, self.n_samples_fit_
        sparse = csr_array if get_config().get("sparse_interface") == "sparray" else csr_matrix
        return sparse((data, found.indices, indptr), shape=shape)

    @property
    def _n_features_out(self):
        return self.n_samples_fit_
