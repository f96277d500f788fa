"""Functions that are compiled once, for one signature, and called by their address.

numba compiles a function into each of its callers, and these into theirs, so a large function several levels down takes
seconds again and again. A function called by address is compiled apart and never inlined: it suits functions that run
for microseconds.

Callers refer to it by a symbol, which LLVM finds once the function has been compiled or loaded from numba's cache.
`load_callees` does this before a caller is loaded from there.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

from llvmlite import binding
from numba import types
from numba.core.cgutils import get_or_insert_function, if_unlikely
from numba.core.typing.templates import make_concrete_template
from numba.extending import is_jitted, lower_builtin, typeof_impl


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
