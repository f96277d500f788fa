"""Compilers with fewer passes than numba's, made of its private parts; without these `fallback` takes numba's own.

numba treats every function as one that Python may call. It optimises it, translates it into machine code and writes it
to its cache, and does all of this again with each function that calls it. Here a function is either *internal* to its
callers, so that nothing of it is kept but its code for LLVM, or *external*, with an address: it is optimised once, with
all internal functions that it calls. (These are LLVM's words for what a module keeps to itself, and what others may
call.) Passes that are for closures, array expressions, generators and the like are left out.
"""

from collections.abc import Callable
from types import BuiltinFunctionType, FunctionType
from typing import Any, ClassVar

from numba import types
from numba.core import typed_passes, untyped_passes
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase
from numba.core.environment import lookup_environment
from numba.core.typing.context import BaseContext
from numba.extending import models, register_model

from skpose._compiled.simd.private import Signature


def _overrides(base: type) -> Callable[[type], type]:
    """Refuse, as a decorator, a class with a method that this class of numba's has not: nobody would call it."""

    def check(cls: type) -> type:
        for name, member in vars(cls).items():
            if isinstance(member, FunctionType) and not name.startswith("__") and not hasattr(base, name):
                raise AttributeError(f"{base.__name__} has no {name}")
        return cls

    return check


@_overrides(JITCodeLibrary)
class _ExternalLibrary(JITCodeLibrary):
    """The code of a function that is called by address, with that of all internal functions that it calls."""

    _codegen: Any

    def add_ir_module(self, ir_module: Any) -> None:
        """Do as numba, and take llvmlite's objects apart: they refer to one another, and would wait to be collected."""
        super().add_ir_module(ir_module)
        for function in ir_module.functions:
            for block in function.blocks:
                for instruction in block.instructions:
                    instruction.operands = []
                block.instructions.clear()

    def _optimize_functions(self, ll_module: Any) -> None:
        """Do as numba, but not for the functions that are only declared, which are most."""
        ll_module.data_layout = self._codegen._data_layout
        passes, builder = self._codegen._function_pass_manager()
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)

    def _finalize_specific(self) -> None:
        """Do as numba, and let internal functions find their environments: constants that become Python objects."""
        super()._finalize_specific()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name)
            if environment is not None:
                self._codegen.set_env(variable.name, environment)


@_overrides(JITCodeLibrary)
class _InternalLibrary(_ExternalLibrary):
    """The code of a function that is internal to others: not optimised, and without an address."""

    class codegen:
        @staticmethod
        def set_env(name: str, env: Any) -> None:
            """Do nothing: the external function that calls this one does it."""

    def finalize(self) -> None:
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0


@_overrides(types.Function)
class _Operator(types.Function):
    """numba's type of an operator, or of a builtin function such as `min`, with a memory of what that returns.

    numba asks some twenty rules, up to four times for each operator that it compiles. The type of an operator becomes
    another one when rules are added to it, so that what is remembered stays right. One thread at a time compiles.
    """

    def __init__(self, plain: types.Function):
        super().__init__(plain.templates)
        self._found: dict[tuple, Signature] = {}

    def get_call_type(self, context: Any, args: tuple, kws: dict) -> Signature:
        if kws:
            return super().get_call_type(context, args, kws)
        found = self._found.get(args)
        if found is None:  # errors are not kept, as numba adds lines to them
            found = self._found[args] = super().get_call_type(context, args, kws)
        return found


register_model(_Operator)(models.OpaqueModel)


@_overrides(BaseContext)
class _Remembering:
    """numba's typing context, in which operators have a memory."""

    operators: ClassVar[dict[types.Function, _Operator]] = {}  # by the types that numba has for them

    def __init__(self, context: BaseContext):
        self._context = context

    def __getattr__(self, name: str) -> Any:
        return getattr(self._context, name)

    def resolve_value_type(self, value: Any) -> Any:
        found = self._context.resolve_value_type(value)
        if type(found) is not types.Function or not isinstance(found.typing_key, BuiltinFunctionType):
            return found
        operator = self.operators.get(found)
        if operator is None:
            operator = self.operators[found] = _Operator(found)
        return operator


@_overrides(BaseContext)
class _Typing(_Remembering):
    """The typing context of functions that are compiled once for all numbers.

    By itself numba compiles a function for each literal number that it is called with.
    """

    resolve_setitem = BaseContext.resolve_setitem

    def resolve_function_type(self, function: Any, args: tuple, kws: dict) -> Signature | None:
        of_numbers = all(isinstance(kind, types.Number) for kind in args)
        if isinstance(function, types.Dispatcher) or of_numbers:
            args = tuple(types.unliteral(kind) for kind in args)
        if isinstance(function, BuiltinFunctionType):
            function = self.resolve_value_type(function)
        return self._context.resolve_function_type(function, args, kws)


class _Passes:
    """The passes that a function needs, instead of numba's PassManager: nothing is analysed between them."""

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


@_overrides(CompilerBase)
class _Compiler(CompilerBase):
    library: type[_ExternalLibrary]

    def __init__(self, typingctx: Any, *args: Any):
        super().__init__(typingctx, *args)
        self.state.typingctx = _Typing(typingctx)
        self.state.targetctx = self.state.targetctx.subtarget(typing_context=_Remembering(typingctx))

    def define_pipelines(self) -> list[_Passes]:
        state = self.state
        state.library = self.library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.type_annotation = None
        return [_Passes()]


class ExternalCompiler(_Compiler):
    """Compiles functions that are called by address."""

    library = _ExternalLibrary


class InternalCompiler(_Compiler):
    """Compiles functions that are called in compiled functions only."""

    library = _InternalLibrary
