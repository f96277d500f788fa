"""Tasks in processes or on a cluster, if the user's joblib configuration says so.

The payload, which all tasks need, is sent to each worker once. Tasks that do not come back, because a worker died for
example, are sent again as long as some come back in between.

With dask, joblib (1.6) waits forever for a task that dask gives up, such as one that killed its workers or could not be
loaded. Such tasks are therefore submitted to the client of joblib's configuration, without joblib.
"""

import collections
import itertools
import pickle
import threading
import uuid
import warnings
from collections.abc import Callable, Generator, Hashable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple, TypeVar

import joblib
import numpy as np

from skpose._utils.joblib import (
    active_backend,
    dask_client,
    is_dask,
    is_ray,
    returns_one_by_one,
    shares_memory,
    while_waiting,
)

Task = TypeVar("Task", bound=Hashable)
ATTEMPTS = 3  # in a row without any result
UNFINISHED = 4  # maximum number of tasks per worker that are computed or wait to be taken
UNPACKED_AT_ONCE = 2
SMALL = 2**26  # bytes that a worker copies: joblib waits a second for mapped arrays to be freed


class BackendError(RuntimeError):
    """The backend of joblib's configuration failed several times in a row."""


def in_processes(n_jobs: int | None) -> bool:
    """Whether joblib's configuration sends tasks to more than one other process."""
    return not shares_memory(active_backend()) and joblib.effective_n_jobs(n_jobs) > 1


def from_workers(
    function: Callable, shared: Any, tasks: Iterable[Task], n_jobs: int | None
) -> Generator[tuple[Task, Any], None, None]:
    """Yield each task with ``function(shared, task)``, in the order in which they come back.

    At most `UNFINISHED` tasks per worker are unfinished at any time, however slowly the results are taken.
    """
    payload = _Payload(shared)
    left = dict.fromkeys(tasks)
    failed = 0
    while left:
        n_left = len(left)
        try:
            backend = active_backend()
            returned = _from_dask if is_dask(backend) else _from_joblib
            for task, result in returned(backend, function, payload, list(left), n_jobs):
                if isinstance(result, _Failure):
                    break
                del left[task]
                yield task, result
            else:
                continue
        except Exception as error:
            failed = failed + 1 if len(left) == n_left else 1
            if failed >= ATTEMPTS:
                raise BackendError(
                    f"joblib's workers failed {failed} times: {type(error).__name__}: {error}"
                ) from error
            continue
        raise result.error


def _from_joblib(
    backend: Any, function: Callable, payload: "_Payload", tasks: list[Task], n_jobs: int | None
) -> Generator[tuple[Task, Any], None, None]:
    """Yield tasks and their results or failures."""
    parts = payload.for_ray() if is_ray(backend) else payload.parts
    limit = UNFINISHED * joblib.effective_n_jobs(n_jobs)
    waiting, n_sent, n_taken = collections.deque(tasks), 0, 0

    # joblib takes calls in another thread, and stops while that waits: so this generator ends and is started again.
    def calls() -> Iterator:
        nonlocal n_sent
        while waiting and n_sent - n_taken < limit:
            n_sent += 1
            yield joblib.delayed(_run)(function, payload.token, waiting.popleft(), *parts)

    one_by_one = returns_one_by_one(backend)
    with joblib.Parallel(
        n_jobs=n_jobs,
        prefer="threads",  # where nothing is configured
        return_as="generator_unordered" if one_by_one else "list",
        batch_size=1,
        max_nbytes=1000,  # larger arrays are not sent to processes of this machine, but mapped
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
    backend: Any, function: Callable, payload: "_Payload", tasks: list[Task], n_jobs: int | None
) -> Generator[tuple[Task, Any], None, None]:
    """Yield tasks and their results or failures; a task that dask gives up is an error."""
    from dask.distributed import as_completed

    client, submit_options = dask_client(backend)
    options = {"pure": False} | submit_options
    waiting, unfinished = iter(tasks), set()
    parts = client.scatter(payload.parts, broadcast=True, hash=False)

    def send(n_tasks: int) -> list:
        some = itertools.islice(waiting, n_tasks)
        futures = [client.submit(_run, function, payload.token, task, *parts, **options) for task in some]
        unfinished.update(futures)
        return futures

    try:
        with while_waiting(backend):
            completed = as_completed(send(UNFINISHED * joblib.effective_n_jobs(n_jobs)))
            for future in completed:
                yield future.result()
                unfinished.remove(future)
                completed.update(send(1))
    finally:
        if unfinished:
            client.cancel(list(unfinished))


class _Failure(NamedTuple):
    """An error of the task itself, not of the backend."""

    error: Exception


def _run(function: Callable, token: str, task: Task, *parts: Any) -> tuple[Task, Any]:
    """Run a task on a worker."""
    try:
        return task, function(_unpack(token, parts), task)
    except Exception as error:
        return task, _Failure(error)


class _Payload:
    """What all tasks share, as arrays of bytes, without a copy of its arrays."""

    def __init__(self, content: Any):
        buffers: list[pickle.PickleBuffer] = []
        stream = pickle.dumps(content, protocol=5, buffer_callback=buffers.append)
        raw: list[bytes | memoryview] = [stream, *(buffer.raw() for buffer in buffers)]
        self.parts = [np.frombuffer(part, np.uint8) for part in raw]
        self.token = uuid.uuid4().hex

    def for_ray(self) -> list:
        """References to the parts; loky maps arrays by itself."""
        import ray

        return [ray.put(part) for part in self.parts]


_contents: dict[str, Any] = {}
_unpacking = threading.Lock()


def _unpack(token: str, parts: Sequence[Any]) -> Any:
    """Content of a payload, which is kept for the next task."""
    with _unpacking:
        if token not in _contents:
            if not all(isinstance(part, np.ndarray) for part in parts):
                import ray

                parts = [ray.get(part) for part in parts]
            while len(_contents) >= UNPACKED_AT_ONCE:
                del _contents[next(iter(_contents))]
            if sum(part.nbytes for part in parts) < SMALL:
                parts = [part.copy() for part in parts]
            _contents[token] = pickle.loads(parts[0], buffers=parts[1:])
        return _contents[token]
