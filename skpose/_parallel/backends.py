"""Blocks of work in processes or on a cluster, where the user's joblib configuration asks for that.

What all blocks need is shipped once to each worker and opened there once. Blocks that are lost, as with a worker that
dies, are sent again, as long as something comes back in between.

The blocks are tasks of joblib's, but for dask: there joblib (1.6) waits forever for a task that dask gives up, such as
one that killed its workers or could not be loaded, so these tasks are given to the client of joblib's configuration.
"""

import collections
import itertools
import pickle
import threading
import uuid
import warnings
from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any, TypeVar

import joblib
import numpy as np

from skpose._compat.joblib import active_backend, is_dask, is_ray, returns_one_by_one, shares_memory

Block = TypeVar("Block", bound=Hashable)
ATTEMPTS = 3  # in a row from which nothing comes back
UNDER_WAY = 4  # blocks per worker that are computed or wait to be taken, at most
OPENED_AT_ONCE = 2
SMALL = 2**26  # bytes, to be copied by a worker of joblib's, which waits for a second for mapped ones to be let go


class EngineError(RuntimeError):
    """The engine of joblib's configuration failed, again and again."""


def in_processes(n_jobs: int | None) -> bool:
    """Whether the user's joblib configuration sends tasks to other processes, and to more than one."""
    return not shares_memory(active_backend()) and joblib.effective_n_jobs(n_jobs) > 1


def from_workers(
    function: Callable, shared: Any, blocks: Iterable[Block], n_jobs: int | None
) -> Iterator[tuple[Block, Any]]:
    """Each block with ``function(shared, block)``, as they come back.

    No more than a few blocks per worker are under way at any time, however slowly they are taken.
    """
    parcel = _Parcel(shared)
    left = dict.fromkeys(blocks)
    failed = 0
    while left:
        n_left = len(left)
        try:
            backend = active_backend()
            returned = _from_dask if is_dask(backend) else _from_joblib
            for block, result in returned(backend, function, parcel, list(left), n_jobs):
                if isinstance(result, _Failure):
                    break
                del left[block]
                yield block, result
            else:
                continue
        except Exception as error:
            failed = failed + 1 if len(left) == n_left else 1
            if failed >= ATTEMPTS:
                raise EngineError(
                    f"{len(left)} blocks did not come back from joblib's workers in {failed} attempts; the last one "
                    f"ended with {type(error).__name__}: {error}"
                ) from error
            continue
        raise result.error


def _from_joblib(
    backend: Any, function: Callable, parcel: "_Parcel", blocks: list[Block], n_jobs: int | None
) -> Iterator[tuple[Block, Any]]:
    """Blocks and what came of them."""
    parts = parcel.for_ray() if is_ray(backend) else parcel.parts
    limit = UNDER_WAY * joblib.effective_n_jobs(n_jobs)
    waiting, n_sent, n_taken = collections.deque(blocks), 0, 0

    def tasks():  # asked for in another thread, where waiting would stop the engine; hence it ends, and begins anew
        nonlocal n_sent
        while waiting and n_sent - n_taken < limit:
            n_sent += 1
            yield joblib.delayed(_work)(function, parcel.token, waiting.popleft(), *parts)

    one_by_one = returns_one_by_one(backend)
    with joblib.Parallel(
        n_jobs=n_jobs,
        prefer="threads",  # where nothing is configured
        return_as="generator_unordered" if one_by_one else "list",
        batch_size=1,
        max_nbytes=1000,  # larger arrays are not sent to processes of this machine, but mapped
    ) as parallel:
        while waiting:
            results = parallel(tasks())
            try:
                for result in results:
                    n_taken += 1
                    yield result
            finally:
                if one_by_one:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")  # that tasks are cancelled, which is meant
                        results.close()


def _from_dask(
    backend: Any, function: Callable, parcel: "_Parcel", blocks: list[Block], n_jobs: int | None
) -> Iterator[tuple[Block, Any]]:
    """Blocks and what came of them; the first that dask gives up is an error."""
    from dask.distributed import as_completed

    client, waiting, under_way = backend.client, iter(blocks), set()
    parts = client.scatter(parcel.parts, broadcast=True, hash=False)
    options = {"pure": False} | backend.submit_kwargs

    def send(n_blocks: int) -> list:
        some = itertools.islice(waiting, n_blocks)
        futures = [client.submit(_work, function, parcel.token, block, *parts, **options) for block in some]
        under_way.update(futures)
        return futures

    try:
        with backend.retrieval_context():  # for the case that this is a dask worker itself
            completed = as_completed(send(UNDER_WAY * joblib.effective_n_jobs(n_jobs)))
            for future in completed:
                yield future.result()
                under_way.remove(future)
                completed.update(send(1))
    finally:
        if under_way:
            client.cancel(list(under_way))


class _Failure:
    """An error of the work itself, not of the engine."""

    def __init__(self, error: Exception):
        self.error = error


def _work(function: Callable, token: str, block: Block, *parts) -> tuple[Block, Any]:
    """What runs on a worker."""
    try:
        return block, function(_opened(token, parts), block)
    except Exception as error:
        return block, _Failure(error)


class _Parcel:
    """What all blocks need, as arrays of bytes, without a copy of its arrays."""

    def __init__(self, content: Any):
        buffers: list[pickle.PickleBuffer] = []
        stream = pickle.dumps(content, protocol=5, buffer_callback=buffers.append)
        self.parts = [np.frombuffer(part, np.uint8) for part in (stream, *(buffer.raw() for buffer in buffers))]
        self.token = uuid.uuid4().hex

    def for_ray(self) -> list:
        """References to the parts; loky maps arrays by itself."""
        import ray

        return [ray.put(part) for part in self.parts]


_open: dict[str, Any] = {}
_opening = threading.Lock()


def _opened(token: str, parts: tuple) -> Any:
    """The content of a parcel, kept for the next block."""
    with _opening:
        if token not in _open:
            if not all(isinstance(part, np.ndarray) for part in parts):
                import ray

                parts = [ray.get(part) for part in parts]
            while len(_open) >= OPENED_AT_ONCE:
                del _open[next(iter(_open))]
            if sum(part.nbytes for part in parts) < SMALL:
                parts = [part.copy() for part in parts]
            _open[token] = pickle.loads(parts[0], buffers=parts[1:])
        return _open[token]
