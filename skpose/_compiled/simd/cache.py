"""numba's cache of compiled functions on disk: whether there is one, and what makes it safe for ours.

It rests on private parts of numba.
"""

import hashlib
import pickle
from collections.abc import Callable
from pathlib import Path
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


class CodeFiles(IndexDataCacheFile):
    """The files of a function's cache: one for each version and key.

    numba's own files share an index, which processes that compile for other types at a time overwrite.
    """

    def load(self, key: Any) -> Any:
        """The data, None if there are none."""
        path = self._path(key)
        return pickle.loads(path.read_bytes()) if path.exists() else None

    def save(self, key: Any, data: Any) -> None:
        """Write the data in place of older ones."""
        with self._open_for_write(self._path(key)) as file:
            file.write(self._dump(data))

    def _path(self, key: Any) -> Path:
        own = hashlib.sha256(repr((self._version, self._source_stamp, key)).encode()).hexdigest()[:32]
        return Path(self._cache_path, f"{self._index_name}.{own}.nbc")


class Cache(FunctionCache):
    """The cache of a function on disk, for sources with this digest only; prepare(function) comes before loading it.

    The digest becomes a part of numba's version, which is a part of the files' names.
    """

    def __init__(self, function: Callable, digest: str, prepare: Callable[[Callable], None]):
        super().__init__(function)
        self._prepare, stamp = prepare, self._impl.locator.get_source_stamp()
        self._cache_file = CodeFiles(self.cache_path, self._impl.filename_base, stamp)
        self._cache_file._version += digest

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        self._prepare(self._py_func)
        return super().load_overload(sig, target_context)
