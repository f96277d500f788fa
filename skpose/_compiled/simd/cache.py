"""numba's cache of compiled functions on disk: whether there is one, and what makes it safe for ours.

It rests on private parts of numba.
"""

import hashlib
from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache, IndexDataCacheFile

from skpose._utils.warnings import warn


def _can_cache() -> bool:
    """Whether numba finds a folder for its cache; without one it refuses to define cached functions."""
    try:
        njit(cache=True)(_can_cache)
    except RuntimeError:
        warn("numba finds no writable folder for its cache, so every process compiles skpose anew: set NUMBA_CACHE_DIR")
        return False
    return True


CACHED = _can_cache()


class KeyedFile(IndexDataCacheFile):
    """The files of a function's cache, where the data of each version and key have a name of their own.

    numba writes an index and then the data that it names, and chooses names by the index that it has read. So another
    process that compiles for other types may choose the same name, or find data of older sources under a new index.
    """

    def save(self, key: Any, data: Any) -> None:
        own = hashlib.sha256(repr((self._version, key)).encode()).hexdigest()[:16]
        self._data_name_pattern = f"{self._index_name}.{own}.{{number}}.nbc"
        super().save(key, data)


class Cache(FunctionCache):
    """The cache of a function on disk, for sources with this digest only; prepare(function) comes before loading it.

    The digest becomes a part of numba's version, which is read before anything else of the file.
    """

    def __init__(self, function: Callable, digest: str, prepare: Callable[[Callable], None]):
        super().__init__(function)
        self._prepare, stamp = prepare, self._impl.locator.get_source_stamp()
        self._cache_file = KeyedFile(self.cache_path, self._impl.filename_base, stamp)
        self._cache_file._version += digest

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        self._prepare(self._py_func)
        return super().load_overload(sig, target_context)
