"""Private parts of numba: the file in which it caches compiled functions."""

from collections.abc import Callable
from typing import Any

import numba
from numba.core.caching import FunctionCache

from skpose._warnings import warn


class _Cache(FunctionCache):
    """Numba's cache of one function, which prepares for what it loads."""

    prepare: Callable[[Callable], None]

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        self.prepare(self._py_func)
        return super().load_overload(sig, target_context)


def cache_under(digest: str, compiled: Any, prepare: Callable[[Callable], None]) -> None:
    """Cache a compiled function on disk, for sources with this digest only; prepare(function) comes before loading it.

    The digest becomes a part of numba's version, which is read before anything else of the file: what was compiled from
    other sources may not even load. Where numba has changed, the function is not cached, with a warning.
    """
    cache = _Cache(compiled.py_func)
    cache.prepare = prepare
    try:
        cache._cache_file._version += digest
    except AttributeError:
        warn(f"numba {numba.__version__} does not cache as skpose expects, so every process compiles anew")
    else:
        compiled._cache = cache
