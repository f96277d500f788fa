"""Compilation by numba: one set of options, cached on disk where that is possible."""

import functools
import hashlib
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from numba import config, njit

from skpose._compiled.simd import lanes_llvm  # noqa: F401  (it defines lanes for numba)
from skpose._compiled.simd.cache import cache_under
from skpose._compiled.simd.fallback import part_compiler, whole_compiler
from skpose._compiled.simd.separate import Separate, load_separates
from skpose._warnings import warn


def sources_digest() -> str:
    """Return a digest of all sources of `skpose._compiled`.

    numba inlines functions of one file into those of another, but its cache watches only the file of the outer one.
    With this digest as a part of the cache's version, an edit in any file is seen everywhere, and nothing that was
    compiled from other sources is loaded.
    """
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


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
DIGEST = sources_digest()


def _reduced(compiled: Any, protocol: Any) -> Any:
    """Pickle a function of a module by its name, as Python does; numba pickles its code, which is compiled anew."""
    name, module = compiled.__qualname__, sys.modules.get(compiled.__module__)
    return name if getattr(module, name, None) is compiled else type(compiled).__reduce_ex__(compiled, protocol)


def _compiled(
    function: Callable | None = None, *, compiler: Callable = whole_compiler, signatures: Sequence = (), **options: Any
) -> Any:
    """Compile a function by numba: at once where signatures are given, else at its first call.

    Contraction to fused multiply-add is the one liberty taken: it moves no NaN and is the same in every lane.
    """
    if function is None:
        return functools.partial(_compiled, compiler=compiler, signatures=signatures, **options)
    compiled = njit(nogil=True, fastmath={"contract"}, pipeline_class=compiler, **options)(function)
    if CACHED and hasattr(compiled, "enable_caching") and compiler is whole_compiler:
        cache_under(DIGEST, compiled, load_separates)
    if hasattr(compiled, "py_func"):
        compiled.__reduce_ex__ = functools.partial(_reduced, compiled)
    if signatures and hasattr(compiled, "compile"):
        for signature in signatures:
            compiled.compile(signature)
        compiled.disable_compile()
    return compiled


# A function is a whole, with an address, or a part of others, see `compiler`. Its entry points take longer
# to compile than most functions here, so it has those that it needs: jit is called from Python, passed is an argument
# of a compiled function, a separate function is _called_apart, and the others are parts. Python crashes when it calls
# one that it has no entry to; tests/test_architecture.py looks for such calls.
jit = functools.partial(_compiled, no_cfunc_wrapper=True)
passed = functools.partial(_compiled, no_cpython_wrapper=True)
_called_apart = functools.partial(_compiled, no_cfunc_wrapper=True, no_cpython_wrapper=True)
internal = functools.partial(_called_apart, compiler=part_compiler)
inlined = functools.partial(internal, forceinline=True)


def separate(signature: Callable[[], Any]) -> Callable[[Callable], Callable]:
    """Compile a function apart from its callers, which are compiled functions, for the signature that is returned."""

    def decorate(function: Callable) -> Callable:
        if config.DISABLE_JIT:
            return function
        return Separate(function, lambda: _called_apart(function, signatures=[signature()]))

    return decorate
