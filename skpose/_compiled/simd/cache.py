"""The files in which numba caches compiled functions: whether there are any, and private parts of numba for ours."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba import njit

from skpose._compiled.simd.private import binding
from skpose._warnings import warn


def _can_cache() -> bool:
    """Return whether numba finds a folder for its cache; without one it refuses to define cached functions."""
    try:
        njit(cache=True)(_can_cache)
    except RuntimeError:
        warn(
            "numba finds no folder that it may write compiled functions to, so every process compiles skpose's afresh; "
            "set the environment variable NUMBA_CACHE_DIR to one"
        )
        return False
    return True


CACHED = _can_cache()
_folders: set[Path] = set()


def cache_folders() -> list[Path]:
    """Return the folders where numba stores the functions of skpose that are cached."""
    return sorted(_folders)


def processor() -> str:
    """Return the name of the kind of processor that functions are compiled for, as LLVM has it."""
    return numba.config.CPU_NAME or binding.get_host_cpu_name()


def cache_under(digest: str, compiled: Any, prepare: Callable[[Callable], None]) -> None:
    """Cache a compiled function on disk, for sources with this digest only; prepare(function) comes before loading it.

    The digest becomes a part of numba's version, which is read before anything else of the file: what was compiled from
    other sources may not even load. Where numba has changed, the function is not cached, with a warning.
    """
    try:
        from numba.core.caching import FunctionCache

        # What numba no longer had would be a method that it never calls, and an attribute that it never reads.
        _ = FunctionCache.load_overload, compiled._cache

        class Cache(FunctionCache):
            def load_overload(self, sig: Any, target_context: Any) -> Any:
                prepare(self._py_func)
                return super().load_overload(sig, target_context)

        cache = Cache(compiled.py_func)
        _ = cache._py_func
        cache._cache_file._version += digest
    except (ImportError, AttributeError):
        warn(f"numba {numba.__version__} does not cache as skpose expects, so every process compiles anew")
    else:
        compiled._cache = cache
        _folders.add(Path(cache.cache_path))
