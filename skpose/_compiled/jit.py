"""How functions are compiled: one set of options, cached on disk where that is possible."""

import functools
import warnings

from numba import njit


def _can_cache() -> bool:
    """Whether numba finds a folder for its compiled functions; it refuses to define a cached one where it does not."""
    try:
        njit(cache=True)(_can_cache)
    except RuntimeError:
        warnings.warn(
            "numba finds no folder that it may write compiled functions to, so every process compiles skpose's afresh; "
            "set the environment variable NUMBA_CACHE_DIR to one",
            stacklevel=2,
        )
        return False
    return True


# Contraction to fused multiply-add is the one liberty taken: it moves no NaN and is the same in every lane.
jit = functools.partial(njit, cache=_can_cache(), nogil=True, fastmath={"contract"})
inlined = functools.partial(jit, forceinline=True)
