"""Compilation by numba: one set of options, cached on disk where that is possible."""

import functools
import hashlib
import sys
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

from llvmlite import binding
from numba import config, njit, types
from numba.core.cgutils import get_or_insert_function, if_unlikely
from numba.core.typing.templates import make_concrete_template
from numba.extending import is_jitted, lower_builtin, typeof_impl

from skpose._compiled.simd import lanes_llvm  # noqa: F401  (numba needs to know lanes before it compiles)
from skpose._compiled.simd.cache import CACHED, Cache


class FunctionByAddress:
    """A function that is called by address; it is compiled when it is first needed."""

    def __init__(self, function: Callable, compile: Callable[[], Any]):
        self.py_func, self.__module__ = function, function.__module__
        self._compile = compile

    def __reduce__(self) -> str:
        return self.py_func.__qualname__  # another process finds it by its name

    @cached_property
    def numba_type(self) -> types.Function:
        (compiled,) = self._compile().overloads.values()
        symbol = f"{self.py_func.__module__}.{self.py_func.__qualname__}"
        binding.add_symbol(symbol, compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name))

        @lower_builtin(self, *compiled.signature.args)
        def call(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            convention = context.call_conv
            function_type = convention.get_function_type(sig.return_type, sig.args)
            function = get_or_insert_function(builder.module, function_type, symbol)
            status, result = convention.call_function(builder, function, sig.return_type, sig.args, args)
            with if_unlikely(builder, status.is_error):
                convention.return_status_propagate(builder, status)
            return result

        return types.Function(make_concrete_template(symbol, self, [compiled.signature]))


@typeof_impl.register(FunctionByAddress)
def _type_of(function: FunctionByAddress, _: Any) -> types.Function:
    return function.numba_type


def load_callees(function: Callable) -> None:
    """Compile or load all functions that a function, or one compiled into it, calls by address."""
    seen, waiting = {function}, [function]
    while waiting:
        caller = waiting.pop()
        for name in caller.__code__.co_names:
            callee = caller.__globals__.get(name)
            if isinstance(callee, FunctionByAddress):
                _ = callee.numba_type
            elif is_jitted(callee) and callee.py_func not in seen:
                seen.add(callee.py_func)
                waiting.append(callee.py_func)


# --- jit --------------------------------------------------------------------------------------------------------------


# numba inlines functions of one file into another, but its cache watches only the file of the outer one. With a digest
# of all sources as a part of the cache's version, an edit in any file takes effect everywhere.
SOURCES = sorted(Path(__file__).parent.parent.rglob("*.py"))
DIGEST = hashlib.sha256(b"".join(path.read_bytes() for path in SOURCES)).hexdigest()


def _reduce(compiled: Any, protocol: Any) -> Any:
    """Pickle a function of a module by its name, as Python does; numba pickles its code, which is compiled anew."""
    name, module = compiled.__qualname__, sys.modules.get(compiled.__module__)
    return name if getattr(module, name, None) is compiled else type(compiled).__reduce_ex__(compiled, protocol)


def _compile(function: Callable | None = None, *, cache: bool = True, signatures: Sequence = (), **options: Any) -> Any:
    """Compile a function by numba: at once where signatures are given, else at its first call.

    Contraction to fused multiply-add is the one liberty taken: it moves no NaN and is the same in every lane.
    """
    if function is None:
        return functools.partial(_compile, cache=cache, signatures=signatures, **options)
    if config.DISABLE_JIT:
        return function
    compiled = njit(nogil=True, fastmath={"contract"}, **options)(function)
    compiled.__reduce_ex__ = functools.partial(_reduce, compiled)
    if cache and CACHED:
        compiled._cache = Cache(function, DIGEST, load_callees)
    for signature in signatures:
        compiled.compile(signature)
        compiled.disable_compile()
    return compiled


# Entry points take longer to compile than most functions here, so a function has only the necessary ones: jit is
# called from Python, first_class is an argument of a compiled function, by_address is called by compiled functions, and
# internal and inlined are compiled into their callers. Python crashes when it calls one without an entry for it;
# tests/test_architecture.py looks for such calls.
jit = functools.partial(_compile, no_cfunc_wrapper=True)
first_class = functools.partial(_compile, no_cpython_wrapper=True)
_without_entries = functools.partial(_compile, no_cfunc_wrapper=True, no_cpython_wrapper=True)
internal = functools.partial(_without_entries, cache=False)
inlined = functools.partial(internal, forceinline=True)


def by_address(signature: Callable[[], Any]) -> Callable[[Callable], Callable]:
    """Compile a function apart from the compiled functions that call it, for the signature that is returned."""

    def decorate(function: Callable) -> Callable:
        if config.DISABLE_JIT:
            return function
        return FunctionByAddress(function, lambda: _without_entries(function, signatures=[signature()]))

    return decorate


def of_this_process(function: Callable, reduced: tuple) -> Any:
    """Compile a closure that holds an address; it is pickled as the call that makes it."""
    compiled = njit(nogil=True)(function)
    if not config.DISABLE_JIT:
        compiled.__reduce_ex__ = lambda protocol: reduced
    return compiled
