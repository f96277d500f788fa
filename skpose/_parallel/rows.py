"""Rows of an array as tasks of threads."""

import functools
from collections.abc import Callable
from typing import Any

from skpose._parallel.tasks import LITTLE_WORK, TASKS_PER_JOB, WORK_PER_TASK
from skpose._parallel.threads import in_threads

TASKS_PER_JOB_UNEVEN = 16  # where some rows, such as queries with many candidates, take much longer than others


def over_rows(
    task: Callable[[int, int], Any], n_rows: int, work: float, n_jobs: int, tasks_per_job: int = TASKS_PER_JOB
) -> list:
    """Call ``task(first, last)`` for some rows at a time, in threads if the work is worth it.

    No task is so long that Ctrl-C has to wait for it, nor so short that a thread is not worth its start.
    """
    n_jobs = n_jobs if work > LITTLE_WORK else 1
    n_tasks = max(work / WORK_PER_TASK, min(work / LITTLE_WORK, tasks_per_job * n_jobs) if n_jobs > 1 else 1)
    step = max(1, int(n_rows / n_tasks))
    tasks = (functools.partial(task, first, min(first + step, n_rows)) for first in range(0, n_rows, step))
    return in_threads(tasks, n_jobs)
