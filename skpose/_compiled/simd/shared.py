"""A Tree as compiled functions see it: one address, of a structure that is shared and never changes.

In Python it is a named tuple. `shared` makes a structure of one in a compiled function.

A Tree of arrays is some two hundred numbers, which every call copies and every function unpacks: most of what there is
to compile in functions that do little else than call others.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.imputils import impl_ret_borrowed
from numba.core.typing.templates import AttributeTemplate
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

from skpose._compiled.pose.tree import Tree


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


@contextmanager
def _each_field(context: Any, builder: Any, shared_type: Any, fields: Any) -> Iterator[tuple[Any, Any]]:
    """Begin a loop over the fields; return its index and the address of a field, which is where its meminfo stands.

    All fields are arrays, so one loop does for all of them what numba would write once for each.
    """
    sizes = [context.get_abi_sizeof(context.get_value_type(kind)) for kind in shared_type.plain.types]
    offsets = ir.Constant(ir.ArrayType(cgutils.intp_t, len(sizes)), [sum(sizes[:i]) for i in range(len(sizes))])
    table = cgutils.global_constant(builder, "skpose.offsets", offsets)
    with cgutils.for_range(builder, cgutils.intp_t(len(sizes))) as loop:
        at = builder.load(cgutils.gep_inbounds(builder, table, 0, loop.index))
        yield loop.index, cgutils.pointer_add(builder, fields, at, cgutils.voidptr_t)


def _destructor(context: Any, module: Any, shared_type: Any) -> Any:
    """Return what is called when nobody refers to a structure any more: it releases the fields."""
    kind = ir.FunctionType(ir.VoidType(), [cgutils.voidptr_t, cgutils.intp_t, cgutils.voidptr_t])
    function = cgutils.get_or_insert_function(module, kind, f"skpose.release.{shared_type.name}")
    if function.is_declaration:
        function.linkage = "linkonce_odr"
        builder = ir.IRBuilder(function.append_basic_block())
        meminfo_type = types.MemInfoPointer(types.voidptr)
        with _each_field(context, builder, shared_type, function.args[0]) as (_, field):
            meminfo = builder.load(builder.bitcast(field, cgutils.voidptr_t.as_pointer()))
            context.nrt.decref(builder, meminfo_type, meminfo)
        builder.ret_void()
    return function


def _allocation(context: Any, builder: Any, shared_type: Any) -> tuple[Any, Any]:
    """Return what allocates a structure: its size, and what is called when nobody refers to it any more."""
    layout = context.data_model_manager[shared_type.get_data_type()].get_value_type()
    size = context.get_constant(types.uintp, context.get_abi_sizeof(layout))
    return size, _destructor(context, builder.module, shared_type)


def _hidden(context: Any, builder: Any, shared_type: Any, meminfo: Any) -> Any:
    """Return the structure whose fields have just been stored.

    Loads of fields may be moved to any place where LLVM sees the address. It sees this one after the stores.
    """
    made = cgutils.create_struct_proxy(shared_type)(context, builder)
    kind = meminfo.type
    made.meminfo = builder.asm(ir.FunctionType(kind, [kind]), "", "=r,0", [meminfo], side_effect=True)
    return made._getvalue()


def _filled(context: Any, builder: Any, shared_type: Any, meminfo: Any, values: Any) -> Any:
    """Return a new structure with the fields of a named tuple."""
    fields = _fields_of(context, builder, shared_type, meminfo)
    for i, kind in enumerate(shared_type.plain.types):
        value = builder.extract_value(values, i)
        context.nrt.incref(builder, kind, value)
        builder.store(value, cgutils.gep_inbounds(builder, fields, 0, i))
    return _hidden(context, builder, shared_type, meminfo)


@typeof_impl.register(Tree)
def _type_of(tree: Any, context: Any) -> Any:
    return SharedType(types.NamedTuple([typeof_impl(field, context) for field in tree], Tree))


@unbox(SharedType)
def _unbox(shared_type: Any, value: Any, c: Any) -> Any:
    context, builder = c.context, c.builder
    made = cgutils.alloca_once(builder, context.get_value_type(shared_type), zfill=True)
    failed = cgutils.alloca_once_value(builder, cgutils.false_bit)
    size, destructor = _allocation(context, builder, shared_type)
    meminfo = context.nrt.meminfo_alloc_dtor_unchecked(builder, size, destructor)
    with builder.if_else(cgutils.is_null(builder, meminfo), likely=False) as (without_memory, otherwise):
        with without_memory:
            c.pyapi.err_set_string("PyExc_MemoryError", "no memory for a skeleton")
            builder.store(cgutils.true_bit, failed)
        with otherwise:
            kind = ir.FunctionType(c.pyapi.pyobj, [c.pyapi.pyobj, cgutils.intp_t])
            item_of = cgutils.get_or_insert_function(builder.module, kind, "PyTuple_GetItem")
            fields = context.nrt.meminfo_data(builder, meminfo)
            cgutils.memset(builder, fields, size, 0)
            with _each_field(context, builder, shared_type, fields) as (i, field):
                status = c.pyapi.nrt_adapt_ndarray_from_python(builder.call(item_of, [value, i]), field)
                is_error = builder.or_(builder.load(failed), cgutils.is_not_null(builder, status))
                builder.store(is_error, failed)
            builder.store(_hidden(context, builder, shared_type, meminfo), made)
            with cgutils.if_unlikely(builder, builder.load(failed)):
                c.pyapi.err_set_string("PyExc_TypeError", "the fields of a skeleton are arrays")
                context.nrt.decref(builder, shared_type, builder.load(made))
    return NativeValue(builder.load(made), is_error=builder.load(failed))


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
