"""Functions that are compiled once, for one signature; their callers call them by address.

numba compiles a function into each of its callers again, and these into theirs. So what is many levels below the
function that Python calls is compiled many times, and a large function takes seconds. A function that is called
by address is not compiled into its callers, and nothing of it is inlined: it is for what takes microseconds.

Callers refer to it by a symbol, which LLVM knows once the function has been compiled or loaded. numba's cache does not
know about that: `load_callees` is for everything that is loaded from there.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

from numba import types
from numba.extending import lower_builtin, typeof_impl

from skpose._compiled.simd.private import (
    Dispatcher,
    Signature,
    binding,
    get_or_insert_function,
    if_unlikely,
    impl_ret_new_ref,
    make_concrete_template,
)


class FunctionByAddress:
    """A function that is called by address, to be compiled when it is needed first."""

    def __init__(self, function: Callable, compile: Callable[[], Any]):
        self.py_func, self.__module__ = function, function.__module__
        self._compile = compile

    def __reduce__(self) -> str:
        return self.py_func.__qualname__  # in another process it is the one of this name

    @cached_property
    def numba_type(self) -> types.Function:
        """The type that numba sees instead of the function, which is compiled for that."""
        dispatcher = self._compile()
        (result,) = dispatcher.overloads.values()
        symbol = f"{self.py_func.__module__}.{self.py_func.__qualname__}"
        binding.add_symbol(symbol, result.library.get_pointer_to_function(result.fndesc.llvm_func_name))
        lower_builtin(self, *result.signature.args)(_call_of(symbol))
        return types.Function(make_concrete_template(symbol, self, [result.signature]))


def _call_of(symbol: str) -> Callable:
    def call(context: Any, builder: Any, signature: Signature, arguments: Any) -> Any:
        convention = context.call_conv
        function_type = convention.get_function_type(signature.return_type, signature.args)
        function = get_or_insert_function(builder.module, function_type, symbol)
        status, result = convention.call_function(builder, function, signature.return_type, signature.args, arguments)
        with if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return impl_ret_new_ref(context, builder, signature.return_type, result)

    return call


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
            elif isinstance(callee, Dispatcher) and callee.py_func not in seen:
                seen.add(callee.py_func)
                waiting.append(callee.py_func)
