"""Requests for the nearest motions of many: in tasks of some queries, in threads or as joblib's configuration says."""

from contextlib import closing
from typing import NamedTuple

import numpy as np
from joblib import effective_n_jobs
from sklearn.utils import gen_batches

from skpose._parallel.backends import from_workers, in_processes
from skpose._parallel.progress import progress
from skpose._parallel.tasks import TASKS_PER_WORKER
from skpose._parallel.threads import in_threads
from skpose.motions._index import SequenceIndex
from skpose.motions._inputs import Sequences
from skpose.motions._matrix import MotionMatrix, share_of_band, work_per_cell
from skpose.motions._results import MotionEvaluations
from skpose.motions._search import MotionSearch

FEWEST_QUERIES = 4  # in a task
MOST_DISTANCES = 2**22  # of brute force, in memory at once
WORTH_FILTERING = 2e7  # work of brute force for a query, 4 ms: a search takes some milliseconds in any case
FEWEST_PER_NEIGHBOR = 5  # motions: with fewer, most have to be aligned, and that is faster all at once
WORTH_SENDING = 1e8  # pairs of frames; geodesics always are


class Request(NamedTuple):
    """Motions, and how many of the nearest of an index to find."""

    index: SequenceIndex  # type: ignore[assignment]  # which is a method of tuples too
    queries: Sequences
    excluded: np.ndarray  # (n_queries,) index of a motion that is not a neighbour, or -1
    k: int
    window: float | None


class Nearest(NamedTuple):
    """The nearest motions of each query, by distance and then by index, and what the search cost."""

    distances: np.ndarray  # (n_queries, k)
    indices: np.ndarray  # (n_queries, k)
    evaluations: MotionEvaluations
    unconverged: list[tuple[int, float]]


def find(request: Request, n_jobs: int | None, verbose: int) -> Nearest:
    """Find the nearest motions of all queries."""
    n_queries, n_workers = request.queries.n_motions, effective_n_jobs(n_jobs)
    n_cells = len(request.queries.poses) * len(request.index.sequences.poses)
    remote = (request.index.metric.iterative or n_cells > WORTH_SENDING) and in_processes(n_jobs)
    size = max(FEWEST_QUERIES, n_queries // (TASKS_PER_WORKER * n_workers))
    tasks = [(rows.start, rows.stop) for rows in gen_batches(n_queries, size)]
    found: dict[tuple[int, int], Nearest] = {}
    title = f"neighbours of {n_queries:,} motions among {request.index.sequences.n_motions:,}"
    with progress(title, len(tasks), verbose) as advance:
        if remote:
            with closing(from_workers(find_some, request, tasks, n_jobs)) as results:
                for task, result in results:
                    found[task] = result
                    advance()
        else:

            def find_here(task: tuple[int, int]) -> None:
                found[task] = find_some(request, task)
                advance()

            in_threads([lambda task=task: find_here(task) for task in tasks], n_workers)  # type: ignore[misc]
    parts = [found[task] for task in tasks]
    return Nearest(
        np.concatenate([part.distances for part in parts]),
        np.concatenate([part.indices for part in parts]),
        MotionEvaluations(*map(sum, zip(*(part.evaluations for part in parts), strict=True))),
        [one for part in parts for one in part.unconverged],
    )


def find_some(request: Request, rows: tuple[int, int]) -> Nearest:
    """Find the nearest motions of the queries first:last."""
    queries, excluded = request.queries.slice(*rows), request.excluded[slice(*rows)]
    index = request.index
    work = work_per_cell(index.metric, index.skeleton, index.sequences) * share_of_band(request.window)
    work *= len(queries.poses) * len(index.sequences.poses)
    # A pair of frames that is solved takes so long that to leave out a few is worth it.
    many = not index.metric.iterative and request.k * FEWEST_PER_NEIGHBOR > index.sequences.n_motions
    if index.filter is None or work < WORTH_FILTERING * queries.n_motions or many:
        return _by_brute_force(request, queries, excluded)
    search = MotionSearch(index, request.window)
    found = [search.nearest(queries.motion(i), excluded[i], request.k) for i in range(queries.n_motions)]
    distances, indices = (np.stack(part) for part in zip(*found, strict=True))
    return Nearest(distances, indices, search.evaluations, search.unconverged)


def _by_brute_force(request: Request, queries: Sequences, excluded: np.ndarray) -> Nearest:
    index, motions = request.index, request.index.sequences.in_float64()
    n_motions, n_frames = motions.n_motions, len(motions.poses)
    parts, unconverged = [], []
    for rows in gen_batches(queries.n_motions, max(1, MOST_DISTANCES // n_motions)):
        some = queries.slice(rows.start, rows.stop).in_float64()
        matrix = MotionMatrix(some, motions, index.metric, index.skeleton, window=request.window)
        distances, counts = matrix.write(None, 1)
        left_out = np.flatnonzero(excluded[rows] >= 0)
        distances[left_out, excluded[rows][left_out]] = np.inf
        order = distances.argsort(axis=1, kind="stable")[:, : request.k]
        parts.append((np.take_along_axis(distances, order, axis=1), order))
        unconverged += [(one.count, one.gap) for one in counts]
    nearest, indices = (np.concatenate(part) for part in zip(*parts, strict=True))
    evaluations = MotionEvaluations(queries.n_motions * n_motions, len(queries.poses) * n_frames)
    return Nearest(nearest, indices, evaluations, unconverged)
