"""numba's cache of compiled functions on disk: whether there is one, and what makes it safe for ours.

It rests on private parts of numba. Where these have changed, nothing is cached, with a warning.
"""

import hashlib
import pickle
from collections.abc import Callable
from typing import Any

import numba
from numba import njit

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


class CheckedFile:
    """The files of a function's cache, whose data carry their version and key: `file` is numba's own.

    numba writes an index and then the data that it names, and chooses names by the index that it has read. So another
    process that compiles for other types may choose the same name, or find data of older sources under a new index.
    Here each key has a name of its own, and data are used only if their version and key are those looked for.
    """

    def __init__(self, file: Any):
        self._file, self._names = file, file._data_name_pattern
        self.flush, self._save, self._load, self._dump = file.flush, file.save, file.load, file._dump

    def save(self, key: Any, data: Any) -> None:
        dumped = self._dump(key), self._dump(data)
        digest = hashlib.sha256(repr(key).encode()).hexdigest()[:16]
        self._file._data_name_pattern = self._names.replace("{", f"{digest}.{{", 1)
        self._save(key, (self._file._version, *dumped))

    def load(self, key: Any) -> Any:
        version, dumped_key, dumped = self._load(key) or ("", b"", b"")
        # Data of another version may not even load.
        return pickle.loads(dumped) if version == self._file._version and pickle.loads(dumped_key) == key else None


def cache_under(digest: str, compiled: Any, prepare: Callable[[Callable], None]) -> None:
    """Cache a compiled function on disk, for sources with this digest only; prepare(function) comes before loading it.

    The digest becomes a part of numba's version, which is read before anything else of the file.
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
        cache._cache_file = CheckedFile(cache._cache_file)
    except (ImportError, AttributeError):
        warn(f"numba {numba.__version__} does not cache as skpose expects, so every process compiles anew")
    else:
        compiled._cache = cache
