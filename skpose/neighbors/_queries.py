"""Searches for many poses, block by block of queries, in threads or wherever the user's joblib configuration says."""

from contextlib import closing
from typing import Any, NamedTuple

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import gen_batches

from skpose._parallel.backends import from_workers, in_processes
from skpose._parallel.progress import progress
from skpose._parallel.tasks import BLOCKS_PER_WORKER
from skpose.neighbors._geodesic_search import search_of
from skpose.neighbors._search import QUERIES, Evaluations, Neighbors, PoseIndex

FEWEST_QUERIES = 32
SLOW_QUERIES = 256  # where each takes milliseconds
MAX_CHORDS = 2**24  # held at once by a search for geodesics
WORTH_SHIPPING = 1e8  # pairs of a query and a pose; geodesics always are


class Request(NamedTuple):
    """What to search for in an index: ``method(poses, own, **arguments)`` of a search."""

    index: PoseIndex
    method: str
    poses: np.ndarray
    own: np.ndarray  # (n_queries,) index of a pose that does not count, or -1
    arguments: dict[str, Any]


class Found(NamedTuple):
    """What was found, and what that cost."""

    neighbors: Neighbors
    evaluations: Evaluations
    unconverged: list[tuple[int, float]]


def find(request: Request, n_jobs: int | None, verbose: int) -> Found:
    """The neighbours of all queries."""
    n_queries, n_workers = len(request.poses), effective_n_jobs(n_jobs)
    slow = request.index.metric == "geodesic"
    remote = (slow or n_queries * len(request.index.poses) > WORTH_SHIPPING) and in_processes(n_jobs)
    size = min(SLOW_QUERIES, MAX_CHORDS // len(request.index.poses)) if slow else QUERIES
    if remote:
        size = min(size, max(FEWEST_QUERIES, n_queries // (BLOCKS_PER_WORKER * n_workers)))
    blocks = [(rows.start, rows.stop) for rows in gen_batches(n_queries, max(1, size))]
    what = f"neighbours of {n_queries:,} poses among {len(request.index.poses):,}"
    with progress(what, len(blocks), verbose) as advance:
        if remote:
            results = from_workers(find_block, request, blocks, n_jobs)
        else:
            results = ((block, find_block(request, block, n_workers)) for block in blocks)
        found = {}
        with closing(results):  # whatever ends this ends what workers do for it
            for block, result in results:
                found[block] = result
                advance()
    parts = [found[block] for block in blocks]
    return Found(
        Neighbors.joined(part.neighbors for part in parts),
        Evaluations(*map(sum, zip(*(part.evaluations for part in parts), strict=True))),
        [one for part in parts for one in part.unconverged],
    )


def find_block(request: Request, block: tuple[int, int], n_jobs: int = 1) -> Found:
    """The neighbours of the queries from the first of the block to before the last."""
    first, last = block
    search = search_of(request.index, n_jobs)
    near = getattr(search, request.method)(request.poses[first:last], request.own[first:last], **request.arguments)
    return Found(near._replace(queries=near.queries + first), search.evaluations, search.unconverged)
