"""Rows of an array as tasks of threads."""

import functools
from collections.abc import Callable
from typing import Any

from skpose._parallel.tasks import LITTLE_WORK, TASKS_PER_JOB, WORK_PER_TASK
from skpose._parallel.threads import in_threads

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
