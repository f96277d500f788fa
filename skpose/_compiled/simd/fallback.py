"""The compilers of `skpose._compiled.simd.compiler` or, where numba has changed, numba's own: slower, and nothing else.

Those rest on private parts of numba. When a process compiles first, a small function shows whether they still fit. A
process that loads all its functions from numba's cache compiles nothing, and tries nothing.
"""

import functools
from collections.abc import Callable
from typing import Any

import numba
from numba.core.compiler import Compiler

from skpose._warnings import warn


def whole_compiler(*args: Any) -> Any:
    """Return a compiler of one function that is called by address."""
    return _compilers()[0](*args)


def part_compiler(*args: Any) -> Any:
    """Return a compiler of one function that is called in compiled functions only."""
    return _compilers()[1](*args)


@functools.cache
def _compilers() -> tuple[Callable, Callable]:
    try:
        from skpose._compiled.simd.compiler import PartCompiler, WholeCompiler

        _try(WholeCompiler, PartCompiler)
    except Exception as error:  # a part of numba that has changed may raise any
        warn(
            f"numba {numba.__version__} does not compile as skpose expects ({type(error).__name__}: {error}), so its "
            "own compiler is used: results are the same, first calls take longer; install a newer skpose, or the numba "
            "that was current when this one was released"
        )
        return Compiler, Compiler
    return WholeCompiler, PartCompiler


def _try(whole: Callable, part: Callable) -> None:
    """Compile a function with a part, and call it."""
    njit: Any = functools.partial(numba.njit, no_cfunc_wrapper=True)

    @njit(pipeline_class=part, no_cpython_wrapper=True)
    def plus(a: float, b: int) -> float:
        return a + b

    @njit(pipeline_class=whole)
    def plus_two(a: float) -> float:
        return plus(a, 2)

    if plus_two(1.0) != 3.0:
        raise ValueError("1 + 2 is not 3")
