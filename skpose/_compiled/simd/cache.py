"""numba's cache of compiled functions on disk: whether there is one, and what makes it safe for ours.

It rests on private parts of numba.
"""

import glob
import hashlib
import logging
import multiprocessing
import pickle
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import event
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
DIGEST_SIZE = hashlib.sha256().digest_size  # bytes


class CodeFiles(IndexDataCacheFile):
    """The files of a function's cache: one for each version and key, which begins with a digest of the rest.

    numba's own files share an index, which processes that compile for other types at a time overwrite, and what a crash
    or a full disk has left of them stops every later process.
    """

    def load(self, key: Any) -> Any:
        """The data, None if there are none or they are damaged."""
        try:
            content = self._path(key).read_bytes()
        except OSError:
            return None
        stored, data = content[:DIGEST_SIZE], content[DIGEST_SIZE:]
        return pickle.loads(data) if hashlib.sha256(data).digest() == stored else None

    def save(self, key: Any, data: Any) -> None:
        """Write the data in place of older ones, or leave those as they are."""
        dumped = self._dump(data)
        with self._open_for_write(self._path(key)) as file:
            file.write(hashlib.sha256(dumped).digest() + dumped)

    def flush(self) -> None:
        """Delete the data of all versions and keys."""
        for path in Path(self._cache_path).glob(f"{glob.escape(self._index_name)}.*.nbc"):
            path.unlink(missing_ok=True)

    def _path(self, key: Any) -> Path:
        own = hashlib.sha256(repr((self._version, self._source_stamp, key)).encode()).hexdigest()[:32]
        return Path(self._cache_path, f"{self._index_name}.{own}.nbc")


class Cache(FunctionCache):
    """The cache of a function on disk, for sources with this digest only; prepare(function) comes before loading it.

    The digest becomes a part of numba's version, which is read before anything else of the file.
    """

    def __init__(self, function: Callable, digest: str, prepare: Callable[[Callable], None]):
        super().__init__(function)
        self._prepare, stamp = prepare, self._impl.locator.get_source_stamp()
        self._cache_file = CodeFiles(self.cache_path, self._impl.filename_base, stamp)
        self._cache_file._version += digest

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        self._prepare(self._py_func)
        return super().load_overload(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            super().save_overload(sig, data)
        except OSError as error:
            warn(f"the compile cache cannot be written ({error.strerror}), so every process compiles skpose anew")


# --- announce ---------------------------------------------------------------------------------------------------------
# A message where calls compile for long, by the logger "skpose": on stderr, unless the user configures logging.
#
# It appears once, and not in worker processes, which compile what the process that started them compiles.


PATIENCE = 2.0  # seconds of compilation without a message

logger = logging.getLogger("skpose")


class Announcer(event.Listener):
    """Times what numba compiles of skpose; one thread at a time compiles."""

    def __init__(self) -> None:
        self.depth, self.began, self.spent, self.announced = 0, 0.0, 0.0, False

    def on_start(self, event: Any) -> None:
        if self.depth == 0:
            self.began = time.monotonic()
        self.depth += 1

    def on_end(self, event: Any) -> None:
        self.depth -= 1
        if not (event.data["dispatcher"].py_func.__module__ or "").startswith("skpose."):
            return
        spent = self.spent + time.monotonic() - self.began
        if self.depth == 0:
            self.spent = spent
        if spent > PATIENCE and not self.announced and multiprocessing.parent_process() is None:
            self.announced = True
            often = "once" if CACHED else "in every process"
            logger.warning("skpose compiles for this machine, %s: 5 s to a minute", often)


event.register("numba:compile", Announcer())
