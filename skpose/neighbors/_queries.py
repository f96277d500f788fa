"""Requests for the neighbours of many poses, in tasks of some queries: in threads, or as joblib's configuration says.

The path of a request is one file after another: a transformer (`_kneighbors`, `_radius_neighbors`) makes it, `_graph`
checks the poses, this file splits them, `_search` answers each task with the bounds of `_index`
and the loops of `skpose._compiled.pose.nearest`.
"""

from contextlib import closing
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import gen_batches

from skpose._utils.parallel import TASKS_PER_WORKER, from_workers, in_processes
from skpose._utils.progress import progress
from skpose.neighbors._index import Neighbors, PoseIndex
from skpose.neighbors._search import MAX_BOUNDS, QUERIES, GeodesicSearch, Search

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


def search_of(index: PoseIndex, n_jobs: int) -> Search | GeodesicSearch:
    """Return a new search of an index."""
    metric = index.metric
    has_bounds = metric.lower_bound() is not None and metric.upper_bound() is not None
    return GeodesicSearch(index, n_jobs) if metric.iterative and has_bounds else Search(index, metric, n_jobs)
