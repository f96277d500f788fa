"""Private parts of numba: the file in which it caches compiled functions."""

import warnings
from typing import Any

import numba
from numba.core.caching import NullCache


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
        warnings.warn(
            f"numba {numba.__version__} does not cache as skpose expects, so every process compiles anew",
            stacklevel=2,
        )
