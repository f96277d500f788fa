"""Private parts of numba: the file in which it caches compiled functions."""

from collections.abc import Callable
from typing import Any

import numba

from skpose._warnings import warn


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
