"""The compilers of `skpose._compiled.simd.compiler` or, where numba has changed, numba's own: slower, and nothing else.

Those rest on private parts of numba. When a process compiles first, a kernel shows whether they still fit. A process
that loads all its functions from numba's cache compiles nothing, and tries nothing.
"""

import functools
from collections.abc import Callable
from typing import Any

import numba
import numpy as np

from skpose._compiled.simd.private import FITTING, Compiler
from skpose._warnings import warn


def external_compiler(*args: Any) -> Any:
    """Return a compiler of one function that is called by address."""
    return _compilers()[0](*args)


def internal_compiler(*args: Any) -> Any:
    """Return a compiler of one function that is called in compiled functions only."""
    return _compilers()[1](*args)


@functools.cache
def _compilers() -> tuple[Callable, Callable]:
    try:
        from skpose._compiled.simd.compiler import ExternalCompiler, InternalCompiler

        _try(ExternalCompiler, InternalCompiler)
    except Exception as error:  # a part of numba that has changed may raise any
        reason = f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"
        warn(
            f"numba {numba.__version__} does not compile as skpose expects ({reason}), so its own compiler is "
            f"used: results are the same, first calls take longer; install a newer skpose, or numba{FITTING}"
        )
        return Compiler, Compiler
    return ExternalCompiler, InternalCompiler


def _factorise(matrix: Any, damping: float, factor: Any) -> tuple[int, float]:
    """Factorise a symmetric matrix A + λ = U D Uᵀ in the array of the factor; λ grows until the pivots are positive.

    Returns how often it has grown, and λ. The function is made of what all kernels here are made of: arrays, loops in
    loops, branches, variables that change in them and one whose type changes, and a tuple.
    """
    n, n_failures, succeeds = matrix.shape[0], 0, False
    while not succeeds:
        succeeds = True
        for i in range(n):
            for j in range(n):
                factor[i, j] = matrix[i, j] + damping if i == j else matrix[i, j]
        for k in range(n - 1, -1, -1):
            pivot = factor[k]
            pivot = pivot[k]
            if pivot <= 0.0:
                succeeds, damping = False, 2.0 * damping
                n_failures += 1
                break
            for i in range(k):
                share = factor[i, k] / pivot
                for j in range(i + 1):
                    factor[i, j] -= share * factor[j, k]
    return n_failures, damping


def _try(external: Callable, internal: Callable) -> None:
    """Compile a kernel that is internal to another function, and compare what it returns with plain Python."""
    njit: Any = functools.partial(numba.njit, no_cfunc_wrapper=True)
    factorise = njit(pipeline_class=internal, no_cpython_wrapper=True)(_factorise)

    @njit(pipeline_class=external)
    def factorise_damped(matrix: Any, factor: Any) -> float:
        failures = factorise(matrix, 0.25, factor)
        return failures[0] + failures[1]

    for matrix in (np.ones((3, 3)), np.ones((3, 3)) - np.eye(3)):  # the second one is indefinite
        factor, expected = np.zeros((3, 3)), np.zeros((3, 3))
        found, wanted = factorise_damped(matrix, factor), sum(_factorise(matrix, 0.25, expected))
        if found != wanted or not np.allclose(factor, expected, rtol=1e-12, atol=0.0):
            raise ValueError(f"{found} and {factor} are not {wanted} and {expected}")
