"""Private parts of numba: the file in which it caches compiled functions."""

from typing import Any

import numba
from numba.core.caching import NullCache

from skpose._warnings import warn


def cache_under(digest: str, compiled: Any) -> None:
    """Cache a compiled function on disk, for sources with this digest only.

    The digest becomes a part of numba's version, which is read before anything else of the file: what was compiled from
    other sources may not even load. Where numba has changed, the function is not cached, with a warning.
    """
    compiled.enable_caching()
    try:
        compiled._cache._cache_file._version += digest
    except AttributeError:
        compiled._cache = NullCache()
        warn(f"numba {numba.__version__} does not cache as skpose expects, so every process compiles anew")
