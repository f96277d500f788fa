"""Tasks in threads: how much work one has, and how they are run."""

import functools
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import Any, TypeVar

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
    waiting = enumerate(tasks)
    taking = Lock()
    results: dict[int, T] = {}

    def work() -> None:
        nonlocal waiting
        try:
            while True:
                with taking:
                    i, task = next(waiting, (-1, None))
                if task is None:
                    return
                results[i] = task()
        except BaseException:
            waiting = enumerate(())
            raise

    if n_jobs == 1:
        work()
        return list(results.values())
    with ThreadPoolExecutor(n_jobs) as pool:
        try:
            for worker in [pool.submit(work) for _ in range(n_jobs)]:
                worker.result()
        except BaseException:
            waiting = enumerate(())
            raise
    return [results[i] for i in range(len(results))]


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
