"""A Tree as compiled functions see it: one address, of a structure that is shared and never changes.

In Python it is a named tuple. `shared` makes a structure of one in a compiled function.

A Tree of arrays is some two hundred numbers, which every call copies and every function unpacks: most of what there is
to compile in functions that do little else than call others.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
from numba.experimental.jitclass.base import imp_dtor
from numba.extending import (
    NativeValue,
    box,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    overload,
    register_model,
    typeof_impl,
    unbox,
)

from skpose._compiled.tree import Tree


class SharedType(types.StructRef):
    """numba's type of a shared structure with the fields of a named tuple."""

    def __init__(self, plain: Any):
        self.plain = plain
        super().__init__(list(zip(plain.fields, plain.types, strict=True)))


register_model(SharedType)(models.StructRefModel)


@infer_getattr
class _Attributes(AttributeTemplate):
    key = SharedType

    def generic_resolve(self, shared: Any, attribute: str) -> Any:
        return shared.field_dict.get(attribute)


def _fields_of(context: Any, builder: Any, shared_type: Any, meminfo: Any) -> Any:
    """Return the address of the fields."""
    layout = context.data_model_manager[shared_type.get_data_type()].get_value_type()
    return builder.bitcast(context.nrt.meminfo_data(builder, meminfo), layout.as_pointer())


@lower_getattr_generic(SharedType)
def _get(context: Any, builder: Any, shared_type: Any, value: Any, attribute: str) -> Any:
    meminfo = cgutils.create_struct_proxy(shared_type)(context, builder, value=value).meminfo
    fields = _fields_of(context, builder, shared_type, meminfo)
    i, kind = list(shared_type.field_dict).index(attribute), shared_type.field_dict[attribute]
    layout = context.get_value_type(kind)
    loaded = ir.Constant(layout, ir.Undefined)
    for k in range(len(layout.elements)):  # one by one: LLVM keeps numbers in registers, and not structures
        address = cgutils.gep_inbounds(builder, fields, 0, i, k)
        part = builder.load(address)
        part.set_metadata("invariant.load", builder.module.add_metadata([]))
        loaded = builder.insert_value(loaded, part, k)
    return impl_ret_borrowed(context, builder, kind, loaded)


@box(SharedType)
def _box(shared_type: Any, value: Any, c: Any) -> Any:
    """In Python it is the named tuple."""
    fields = [_get(c.context, c.builder, shared_type, value, name) for name in shared_type.field_dict]
    c.context.nrt.decref(c.builder, shared_type, value)
    return c.box(shared_type.plain, c.context.make_tuple(c.builder, shared_type.plain, fields))


def _allocation(context: Any, builder: Any, shared_type: Any) -> tuple[Any, Any]:
    """Return what allocates a structure: its size, and what is called when nobody refers to it any more."""
    layout = context.data_model_manager[shared_type.get_data_type()].get_value_type()
    size = context.get_constant(types.uintp, context.get_abi_sizeof(layout))
    return size, imp_dtor(context, builder.module, shared_type)


def _filled(context: Any, builder: Any, shared_type: Any, meminfo: Any, values: Any) -> Any:
    """Return a new structure with the fields of a named tuple."""
    made = cgutils.create_struct_proxy(shared_type)(context, builder)
    made.meminfo = meminfo
    fields = _fields_of(context, builder, shared_type, meminfo)
    for i, kind in enumerate(shared_type.plain.types):
        value = builder.extract_value(values, i)
        context.nrt.incref(builder, kind, value)
        builder.store(value, cgutils.gep_inbounds(builder, fields, 0, i))
    # Loads of fields may be moved to any place where LLVM sees the address. It sees this one after the stores.
    kind = meminfo.type
    made.meminfo = builder.asm(ir.FunctionType(kind, [kind]), "", "=r,0", [meminfo], side_effect=True)
    return made._getvalue()


@typeof_impl.register(Tree)
def _type_of(tree: Any, context: Any) -> Any:
    return SharedType(types.NamedTuple([typeof_impl(field, context) for field in tree], Tree))


@unbox(SharedType)
def _unbox(shared_type: Any, value: Any, c: Any) -> Any:
    context, builder = c.context, c.builder
    plain = c.unbox(shared_type.plain, value)
    made = cgutils.alloca_once(builder, context.get_value_type(shared_type), zfill=True)
    failed = cgutils.alloca_once_value(builder, plain.is_error)
    with cgutils.if_likely(builder, builder.not_(plain.is_error)):
        meminfo = context.nrt.meminfo_alloc_dtor_unchecked(builder, *_allocation(context, builder, shared_type))
        with builder.if_else(cgutils.is_null(builder, meminfo), likely=False) as (without_memory, otherwise):
            with without_memory:
                c.pyapi.err_set_string("PyExc_MemoryError", "no memory for a skeleton")
                builder.store(cgutils.true_bit, failed)
            with otherwise:
                builder.store(_filled(context, builder, shared_type, meminfo, plain.value), made)
        context.nrt.decref(builder, shared_type.plain, plain.value)
    return NativeValue(builder.load(made), is_error=builder.load(failed), cleanup=plain.cleanup)


@intrinsic
def _share(typingctx: Any, plain: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        allocation = _allocation(context, builder, signature.return_type)
        meminfo = context.nrt.meminfo_alloc_dtor(builder, *allocation)
        return _filled(context, builder, signature.return_type, meminfo, args[0])

    return SharedType(plain)(plain), codegen


def shared(plain):
    """Return a named tuple as a shared structure; without compilation, as it is."""
    return plain


@overload(shared)
def _overload_shared(plain):
    return lambda plain: _share(plain)
