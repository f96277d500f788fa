"""Tasks in threads."""

from collections.abc import Callable, Generator, Iterable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import TypeVar

T = TypeVar("T")
Item = TypeVar("Item")


def in_threads(tasks: Iterable[Callable[[], T]], n_jobs: int) -> list[T]:
    """Return the results of the tasks, in the order in which they end; each free thread takes the next task.

    Threads, not processes, as the kernels release the GIL and write parts of one array; and not joblib's, which take 15
    ms to start and to end. After a task fails, or on Ctrl-C, no other one starts.
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


def one_behind(function: Callable[[Item], T], items: Iterable[Item]) -> Generator[T, None, None]:
    """Yield the function of each item; another thread computes it while this one makes the next item."""
    previous = None
    with ThreadPoolExecutor(1) as pool:
        for item in items:
            if previous is not None:
                yield previous.result()
            previous = pool.submit(function, item)
        if previous is not None:
            yield previous.result()
