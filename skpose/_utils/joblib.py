"""Private parts of joblib: the active backend, its abilities, and the dask client that it holds."""

from contextlib import AbstractContextManager
from typing import Any

from joblib.parallel import get_active_backend

__all__ = ["active_backend", "dask_client", "is_dask", "is_ray", "returns_one_by_one", "shares_memory", "while_waiting"]


def active_backend() -> Any:
    """The backend of the user's ``joblib.parallel_config``; threads by default."""
    return get_active_backend(prefer="threads")[0]


def shares_memory(backend: Any) -> bool:
    """Whether the backend's workers are threads of this process."""
    return getattr(backend, "supports_sharedmem", False)


def returns_one_by_one(backend: Any) -> bool:
    """Whether results can be taken before all tasks are done; not with multiprocessing or ray."""
    return getattr(backend, "supports_return_generator", False)


def is_dask(backend: Any) -> bool:
    """Whether the backend sends tasks to a dask cluster."""
    return type(backend).__name__ == "DaskDistributedBackend"


def is_ray(backend: Any) -> bool:
    """Whether the backend sends tasks to a ray cluster."""
    return type(backend).__name__ == "RayBackend"


def dask_client(backend: Any) -> tuple[Any, dict[str, Any]]:
    """The client of a dask backend, and the user's options for what it submits."""
    return backend.client, backend.submit_kwargs


def while_waiting(backend: Any) -> AbstractContextManager:
    """A context for waiting on results of a dask backend: a dask worker gives its slot to others there."""
    return backend.retrieval_context()
