"""Private parts of numba: the file in which it caches compiled functions, and what it does to compile one.

numba treats every function as one that Python may call. It optimises it, translates it into machine code and writes it
to its cache, and does all of this again with each function that it is a part of. Here a function is either a *part* of
others, of which nothing is kept but its code for LLVM, or a *whole*, which has an address: it is optimised with all its
parts, once. Passes that are for closures, array expressions, generators and the like are left out.
"""

import operator
from collections.abc import Callable
from types import BuiltinFunctionType
from typing import Any, ClassVar

import numba
from numba import types
from numba.core import typed_passes, untyped_passes
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.typing.context import BaseContext
from numba.core.typing.templates import Signature

from skpose._warnings import warn


class _Cache(FunctionCache):
    """Numba's cache of one function, which prepares for what it loads."""

    prepare: Callable[[Callable], None]

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        self.prepare(self._py_func)
        return super().load_overload(sig, target_context)


def cache_under(digest: str, compiled: Any, prepare: Callable[[Callable], None]) -> None:
    """Cache a compiled function on disk, for sources with this digest only; prepare(function) comes before loading it.

    The digest becomes a part of numba's version, which is read before anything else of the file: what was compiled from
    other sources may not even load. Where numba has changed, the function is not cached, with a warning.
    """
    cache = _Cache(compiled.py_func)
    cache.prepare = prepare
    try:
        cache._cache_file._version += digest
    except AttributeError:
        warn(f"numba {numba.__version__} does not cache as skpose expects, so every process compiles anew")
    else:
        compiled._cache = cache


class _Whole(JITCodeLibrary):
    """The code of a function that is called by address, with that of all its parts."""

    def _optimize_functions(self, ll_module: Any) -> None:
        """Do as numba, but not for the functions that are only declared, which are most."""
        ll_module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class _Part(_Whole):
    """The code of a function that is only a part of others: not optimised, and without an address."""

    class codegen:
        @staticmethod
        def set_env(name: str, env: Any) -> None:
            """Do nothing: no environment is read, as nothing here makes Python objects."""

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0


class _Typing:
    """numba's typing context, for functions that are compiled once for all numbers, with a memory of operators.

    By itself numba compiles a function for each literal number that it is called with, and asks some twenty rules what
    an operator returns, each time.
    """

    _known: ClassVar[dict[tuple, Signature]] = {}
    resolve_setitem = BaseContext.resolve_setitem

    def __init__(self, context: BaseContext):
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_function_type(self, function: Any, args: tuple, kws: dict) -> Signature | None:
        of_numbers = function is not operator.pow and all(isinstance(kind, types.Number) for kind in args)
        if isinstance(function, types.Dispatcher) or of_numbers:
            args = tuple(types.unliteral(kind) for kind in args)
        if not isinstance(function, BuiltinFunctionType):
            return self._context.resolve_function_type(function, args, kws)
        found = self._known.get((function, args))
        if found is None:
            found = self._context.resolve_function_type(function, args, kws)
            if found is not None:
                self._known[function, args] = found
        return found


class _Passes:
    """The passes that a function needs, in the place of numba's PassManager: nothing is analysed between them."""

    pipeline_name = "skpose"
    passes = tuple(
        one()
        for one in (
            untyped_passes.TranslateByteCode,
            untyped_passes.FixupArgs,
            untyped_passes.IRProcessing,
            untyped_passes.GenericRewrites,
            untyped_passes.InlineInlinables,
            untyped_passes.ReconstructSSA,
            typed_passes.NopythonTypeInference,
            typed_passes.PreLowerStripPhis,
            typed_passes.IRLegalization,
            typed_passes.NativeLowering,
            typed_passes.NoPythonBackend,
        )
    )

    def __init__(self) -> None:
        self.exec_times: dict[str, float] = {}

    def run(self, state: Any) -> None:
        for one in self.passes:
            one.run_pass(state)


class _Compiler(CompilerBase):
    library: type[_Whole]

    def __init__(self, typingctx: Any, *args: Any):
        super().__init__(typingctx, *args)
        self.state.typingctx = _Typing(typingctx)

    def define_pipelines(self) -> list[_Passes]:
        state = self.state
        state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.type_annotation = None
        return [_Passes()]


class WholeCompiler(_Compiler):
    """Compiles functions that are called by address."""

    library = _Whole


class PartCompiler(_Compiler):
    """Compiles functions that are called in compiled functions only."""

    library = _Part
