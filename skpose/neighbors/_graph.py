"""The common base of the transformers into graphs of neighbours: the index, its searches, and graphs of the results."""

from contextlib import closing
from typing import ClassVar, NamedTuple

import numpy as np
from joblib import effective_n_jobs
from scipy.sparse import csr_array, csr_matrix
from sklearn import get_config
from sklearn.base import BaseEstimator, ClassNamePrefixFeaturesOutMixin, TransformerMixin
from sklearn.utils import gen_batches

from skpose._base import POSE_CONSTRAINTS, PoseEstimatorMixin
from skpose._utils.parallel import TASKS_PER_WORKER, from_workers, in_processes
from skpose._utils.progress import progress
from skpose._utils.sklearn import StrOptions, fit_context
from skpose._utils.validation import check_choice, check_integer
from skpose.metrics._matrix import warn_of_unconverged
from skpose.neighbors._index import Neighbors, PoseIndex
from skpose.neighbors._search import MAX_BOUNDS, QUERIES, GeodesicSearch, Search


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
        # As scikit-learn is configured.
        sparse = csr_array if get_config().get("sparse_interface") == "sparray" else csr_matrix
        return sparse((data, neighbors.indices, indptr), shape=(n_queries, self.n_samples_fit_))

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


# --- queries ----------------------------------------------------------------------------------------------------------
# Requests for the neighbours of many poses, in tasks of some queries: in threads, or as joblib's configuration says.
#
# A transformer (`_kneighbors`, `_radius_neighbors`) makes a request, and `_search` answers each task with the bounds of
# `_index` and the loops of `skpose._compiled.pose.nearest`.


FEWEST_QUERIES = 32  # in a task for another process
SLOW_QUERIES = 256  # in a task of geodesics, which take milliseconds each
MAX_CHORDS = 2**24  # in memory at once in a search for geodesics
WORTH_SENDING = 1e8  # pairs of a query and a pose; geodesics always are


class Request(NamedTuple):
    """Poses, and which of their neighbours in an index to find: the k nearest, or all within a radius."""

    searched: PoseIndex
    poses: np.ndarray
    excluded: np.ndarray  # (n_queries,) index of a pose that is not a neighbour, or -1
    k: int | None = None
    radius: float = np.inf  # m, or rad for "angle"
    measured: bool = True  # else distances may be any upper bounds within the radius


class Found(NamedTuple):
    """The answer to a request."""

    neighbors: Neighbors
    n_measured: int  # pairs; with "geodesic" those whose geodesic was solved
    unconverged: list[tuple[int, float]]


def find(request: Request, n_jobs: int | None, verbose: int) -> Found:
    """Find the neighbours of all queries."""
    n_queries, n_workers = len(request.poses), effective_n_jobs(n_jobs)
    slow, n_poses = request.searched.metric.iterative, len(request.searched.poses)
    remote = (slow or n_queries * n_poses > WORTH_SENDING) and in_processes(n_jobs)
    size = QUERIES
    if request.k is None:
        size = min(QUERIES, MAX_BOUNDS // len(request.searched.groups))
    if slow:
        size = min(SLOW_QUERIES, MAX_CHORDS // n_poses)
    if remote:
        size = min(size, max(FEWEST_QUERIES, n_queries // (TASKS_PER_WORKER * n_workers)))
    tasks = list(gen_batches(n_queries, max(1, size)))
    with progress(f"neighbours of {n_queries:,} poses among {n_poses:,}", len(tasks), verbose) as advance:
        if remote:
            results = from_workers(find_some, request, tasks, n_jobs)
        else:
            results = ((task, find_some(request, task, n_workers)) for task in tasks)
        found = {}
        with closing(results):  # on an error or Ctrl-C, the workers stop too
            for task, result in results:
                found[task.start] = result
                advance()
    parts = [found[task.start] for task in tasks]
    return Found(
        Neighbors.join(part.neighbors for part in parts),
        sum(part.n_measured for part in parts),
        [one for part in parts for one in part.unconverged],
    )


def find_some(request: Request, rows: slice, n_jobs: int = 1) -> Found:
    """Find the neighbours of some queries."""
    search = search_of(request.searched, n_jobs)
    poses, excluded = request.poses[rows], request.excluded[rows]
    if request.k is None:
        near = search.within(poses, excluded, request.radius, measured=request.measured)
    else:
        near = search.nearest(poses, excluded, request.k)
    return Found(near._replace(queries=near.queries + rows.start), search.n_measured, search.unconverged)


def search_of(index: PoseIndex, n_jobs: int) -> Search:
    """Return a new search of an index."""
    metric = index.metric
    has_bounds = metric.lower_bound() is not None and metric.upper_bound() is not None
    return GeodesicSearch(index, n_jobs) if metric.iterative and has_bounds else Search(index, metric, n_jobs)
