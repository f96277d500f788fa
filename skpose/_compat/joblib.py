"""Private parts of joblib: which backend is active, and what it can do."""

from typing import Any

from joblib.parallel import get_active_backend

__all__ = ["active_backend", "is_dask", "is_ray", "returns_one_by_one", "shares_memory"]


def active_backend() -> Any:
    """Return the backend of the user's ``joblib.parallel_config``, threads where there is none."""
    return get_active_backend(prefer="threads")[0]


def shares_memory(backend: Any) -> bool:
    """Whether the backend's workers are threads of this process."""
    return getattr(backend, "supports_sharedmem", False)


def returns_one_by_one(backend: Any) -> bool:
    """Whether results can be taken before all tasks are done; not with multiprocessing, nor with ray."""
    return getattr(backend, "supports_return_generator", False)


def is_dask(backend: Any) -> bool:
    """Whether the backend sends tasks to a dask cluster; it then has a `client`."""
    return type(backend).__name__ == "DaskDistributedBackend"


def is_ray(backend: Any) -> bool:
    """Whether the backend sends tasks to a ray cluster."""
    return type(backend).__name__ == "RayBackend"
