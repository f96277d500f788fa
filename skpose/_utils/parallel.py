"""Tasks in threads: how much work one has, and how they are run."""

import collections
import contextlib
import functools
import itertools
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import Any, TypeVar

import joblib
from joblib.parallel import get_active_backend

from skpose._utils.progress import progress

WORK_PER_TASK = 1e9  # maximum, some 0.2 s: Ctrl-C takes effect between two tasks
LITTLE_WORK = 1e7  # minimum for a thread
TASKS_PER_JOB = 8  # so that no thread waits long for the last; each costs 0.25 ms
TASKS_PER_WORKER = 4  # so that no worker waits long for the last


T = TypeVar("T")


def in_threads(tasks: Iterable[Callable[[], T]], n_jobs: int) -> list[T]:
    """Results of the tasks in their order; each free thread takes the next task.

    Threads, not processes, since the kernels release the GIL and write parts of one array; and not joblib's, which take
    15 ms to start and to end. After a task fails, or on Ctrl-C, no other task starts.
    """
    stopped = Event()

    def run(task: Callable[[], T]) -> Any:
        try:
            return None if stopped.is_set() else task()
        except BaseException:
            stopped.set()
            raise

    if n_jobs == 1:
        return [task() for task in tasks]
    with ThreadPoolExecutor(n_jobs) as pool:
        try:
            return list(pool.map(run, tasks))
        finally:
            stopped.set()


TASKS_PER_JOB_UNEVEN = 16  # if some rows take much longer than others, such as queries with many candidates


def over_rows(
    task: Callable[[int, int], Any], n_rows: int, work: float, n_jobs: int, tasks_per_job: int = TASKS_PER_JOB
) -> list:
    """Call ``task(first, last)`` for ranges of rows, in threads if there is enough work.

    Tasks are short enough for Ctrl-C, and long enough to be worth a thread.
    """
    n_jobs = n_jobs if work > LITTLE_WORK else 1
    n_tasks = max(work / WORK_PER_TASK, min(work / LITTLE_WORK, tasks_per_job * n_jobs) if n_jobs > 1 else 1)
    step = max(1, int(n_rows / n_tasks))
    tasks = (functools.partial(task, first, min(first + step, n_rows)) for first in range(0, n_rows, step))
    return in_threads(tasks, n_jobs)


# --- backends ---------------------------------------------------------------------------------------------------------
# Tasks in processes or on a cluster, if the user's joblib configuration says so.
#
# With dask, joblib (1.6) waits forever for a task that dask gives up, such as one that killed its workers or could
# not be loaded. Such tasks are therefore submitted to the client of joblib's configuration, without joblib.


Task = TypeVar("Task")
UNFINISHED = 4  # maximum number of tasks per worker that are computed or wait to be taken


def in_processes(n_jobs: int | None) -> bool:
    """Whether joblib's configuration sends tasks to more than one other process."""
    return not getattr(_backend(), "supports_sharedmem", False) and joblib.effective_n_jobs(n_jobs) > 1


def results_of(
    function: Callable[[Any, Task], T],
    shared: Any,
    tasks: Sequence[Task],
    n_jobs: int | None,
    remote: bool,
    what: str,
    verbose: int,
) -> list[T]:
    """``function(shared, task)`` of all tasks, in their order: from workers if `remote`, and otherwise in threads."""
    with progress(what, len(tasks), verbose) as advance:

        def here(task: Task) -> T:
            result = function(shared, task)
            advance()
            return result

        if not remote:
            return in_threads((functools.partial(here, task) for task in tasks), joblib.effective_n_jobs(n_jobs))
        found = {}
        with contextlib.closing(from_workers(function, shared, tasks, n_jobs)) as results:
            for task, result in results:
                found[task] = result
                advance()
        return [found[task] for task in tasks]


def from_workers(
    function: Callable, shared: Any, tasks: Sequence[Task], n_jobs: int | None
) -> Generator[tuple[Task, Any], None, None]:
    """Yield each task with ``function(shared, task)``, in the order in which they come back.

    At most `UNFINISHED` tasks per worker are unfinished at any time, however slowly the results are taken. Errors of
    tasks and of joblib or dask, such as those about dead workers, are raised.
    """
    backend = _backend()
    if type(backend).__name__ == "DaskDistributedBackend":
        yield from _from_dask(backend, function, shared, tasks, n_jobs)
        return
    if type(backend).__name__ == "RayBackend":
        import ray

        function, shared = functools.partial(_get_from_ray, function), ray.put(shared)
    yield from _from_joblib(backend, function, shared, tasks, n_jobs)


def _backend() -> Any:
    """The backend of the user's ``joblib.parallel_config``; threads by default."""
    return get_active_backend(prefer="threads")[0]


def _from_joblib(
    backend: Any, function: Callable, shared: Any, tasks: Sequence[Task], n_jobs: int | None
) -> Generator[tuple[Task, Any], None, None]:
    limit = UNFINISHED * joblib.effective_n_jobs(n_jobs)
    waiting, n_sent, n_taken = collections.deque(tasks), 0, 0

    # joblib takes calls in another thread, and stops while that waits: so this generator ends and is started again.
    def calls() -> Iterator:
        nonlocal n_sent
        while waiting and n_sent - n_taken < limit:
            n_sent += 1
            yield joblib.delayed(_run)(function, shared, waiting.popleft())

    one_by_one = getattr(backend, "supports_return_generator", False)  # not with multiprocessing or ray
    with joblib.Parallel(
        n_jobs=n_jobs,
        prefer="threads",  # where nothing is configured
        return_as="generator_unordered" if one_by_one else "list",
        batch_size=1,
        mmap_mode="c",  # large arrays are mapped; read-only ones would be compiled for anew
    ) as parallel:
        while waiting:
            results = parallel(calls())
            try:
                for result in results:
                    n_taken += 1
                    yield result
            finally:
                if one_by_one:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")  # about cancelled tasks, which are intended
                        results.close()


def _from_dask(
    backend: Any, function: Callable, shared: Any, tasks: Sequence[Task], n_jobs: int | None
) -> Generator[tuple[Task, Any], None, None]:
    from dask.distributed import as_completed

    client, options = backend.client, {"pure": False} | backend.submit_kwargs
    waiting, unfinished = iter(tasks), set()
    (content,) = client.scatter([shared], broadcast=True, hash=False)

    def send(n_tasks: int) -> list:
        some = itertools.islice(waiting, n_tasks)
        futures = [client.submit(_run, function, content, task, **options) for task in some]
        unfinished.update(futures)
        return futures

    try:
        with backend.retrieval_context():  # a dask worker that waits here gives its slot to others
            completed = as_completed(send(UNFINISHED * joblib.effective_n_jobs(n_jobs)))
            for future in completed:
                yield future.result()
                unfinished.remove(future)
                completed.update(send(1))
    finally:
        if unfinished:
            client.cancel(list(unfinished))


def _run(function: Callable, shared: Any, task: Task) -> tuple[Task, Any]:
    """Run a task on a worker."""
    return task, function(shared, task)


def _get_from_ray(function: Callable, reference: Any, task: Any) -> Any:
    import ray

    return function(ray.get(reference), task)
