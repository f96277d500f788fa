"""Tasks in threads."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import TypeVar

T = TypeVar("T")


def in_threads(tasks: Iterable[Callable[[], T]], n_jobs: int) -> list[T]:
    """Results of the tasks, in the order in which they end; each free thread takes the next task.

    Threads, not processes, since the kernels release the GIL and write parts of one array; and not joblib's, which take
    15 ms to start and to end. After a task fails, or on Ctrl-C, no other task starts.
    """
    waiting = iter(tasks)
    taking = Lock()
    results: list[T] = []

    def work() -> None:
        nonlocal waiting
        try:
            while True:
                with taking:
                    task = next(waiting, None)
                if task is None:
                    return
                results.append(task())
        except BaseException:
            waiting = iter(())
            raise

    if n_jobs == 1:
        work()
        return results
    with ThreadPoolExecutor(n_jobs) as pool:
        try:
            for worker in [pool.submit(work) for _ in range(n_jobs)]:
                worker.result()
        except BaseException:
            waiting = iter(())
            raise
    return results
