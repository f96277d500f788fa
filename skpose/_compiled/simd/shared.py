"""A named tuple of arrays that compiled functions hold as one address, of a structure that never changes.

In Python it is the named tuple. A tuple of thirty arrays is some two hundred numbers, which every call would copy and
every function unpack: most of what there is to compile in functions that do little else than call others.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.core.cgutils import int32_t, intp_t, voidptr_t
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    box,
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
    unbox,
)


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


def shared_type(named_tuple: type, fields: list) -> SharedType:
    """Numba's type of a named tuple that is a shared structure, given the types of its fields."""
    return SharedType(types.NamedTuple(fields, named_tuple))


def shared_structure(named_tuple: type) -> type:
    """Let numba see a named tuple of arrays as a shared structure: a decorator of its class."""

    @typeof_impl.register(named_tuple)
    def type_of(value: Any, context: Any) -> SharedType:
        return shared_type(named_tuple, [typeof_impl(field, context) for field in value])

    return named_tuple


# --- memory ---------------------------------------------------------------------------------------------------------


def _layout_of(context: Any, shared_type: Any) -> Any:
    return context.data_model_manager[shared_type.get_data_type()].get_value_type()


def _address_of(context: Any, builder: Any, shared_type: Any, fields: Any, *indices: int) -> Any:
    """The address of a field, or of a part of it, given that of the fields."""
    layout = _layout_of(context, shared_type)
    return builder.gep(fields, [int32_t(i) for i in (0, *indices)], inbounds=True, source_etype=layout)


def _fields_of(context: Any, builder: Any, shared_type: Any, value: Any) -> Any:
    meminfo = cgutils.create_struct_proxy(shared_type)(context, builder, value=value).meminfo
    return context.nrt.meminfo_data(builder, meminfo)


@contextmanager
def _each_field(context: Any, builder: Any, shared_type: Any, fields: Any) -> Iterator[tuple[Any, Any]]:
    """Begin a loop over the fields, which are all arrays; give the index and the address, where a meminfo stands.

    numba would write the same once for each field.
    """
    sizes = [context.get_abi_sizeof(context.get_value_type(kind)) for kind in shared_type.plain.types]
    offsets = ir.Constant(ir.ArrayType(intp_t, len(sizes)), [sum(sizes[:i]) for i in range(len(sizes))])
    table = cgutils.global_constant(builder, "skpose.offsets", offsets)
    with cgutils.for_range(builder, intp_t(len(sizes))) as loop:
        address = builder.gep(table, [intp_t(0), loop.index], inbounds=True, source_etype=offsets.type)
        at = builder.load(address, typ=intp_t)
        yield loop.index, builder.gep(fields, [at], inbounds=True, source_etype=cgutils.int8_t)


def _allocate(context: Any, builder: Any, shared_type: Any) -> tuple[Any, Any]:
    """Allocate a structure; return its meminfo and its size. Its destructor releases the fields."""
    kind = ir.FunctionType(ir.VoidType(), [voidptr_t, intp_t, voidptr_t])
    destructor = cgutils.get_or_insert_function(builder.module, kind, f"skpose.release.{shared_type.name}")
    if destructor.is_declaration:
        destructor.linkage = "linkonce_odr"
        inside = ir.IRBuilder(destructor.append_basic_block())
        with _each_field(context, inside, shared_type, destructor.args[0]) as (_, field):
            context.nrt.decref(inside, types.MemInfoPointer(types.voidptr), inside.load(field, typ=voidptr_t))
        inside.ret_void()
    size = context.get_constant(types.uintp, context.get_abi_sizeof(_layout_of(context, shared_type)))
    return context.nrt.meminfo_alloc_dtor_unchecked(builder, size, destructor), size


def _hide(context: Any, builder: Any, shared_type: Any, meminfo: Any) -> Any:
    """The structure whose fields have just been stored.

    Loads of fields may be moved to where LLVM sees the address. It sees this one after the stores.
    """
    made = cgutils.create_struct_proxy(shared_type)(context, builder)
    kind = meminfo.type
    made.meminfo = builder.asm(ir.FunctionType(kind, [kind]), "", "=r,0", [meminfo], side_effect=True)
    return made._getvalue()


# --- what compiled code does ----------------------------------------------------------------------------------------


@lower_getattr_generic(SharedType)
def _get(context: Any, builder: Any, shared_type: Any, value: Any, attribute: str) -> Any:
    fields = _fields_of(context, builder, shared_type, value)
    i, kind = list(shared_type.field_dict).index(attribute), shared_type.field_dict[attribute]
    layout = context.get_value_type(kind)
    loaded = ir.Constant(layout, ir.Undefined)
    for k, part_type in enumerate(layout.elements):  # LLVM keeps numbers in registers, and not structures
        part = builder.load(_address_of(context, builder, shared_type, fields, i, k), typ=part_type)
        part.set_metadata("invariant.load", builder.module.add_metadata([]))
        loaded = builder.insert_value(loaded, part, k)
    context.nrt.incref(builder, kind, loaded)
    return loaded


@intrinsic(prefer_literal=True)
def replace(typingctx: Any, shared: Any, name: Any, array: Any) -> Any:
    """A shared structure with another array of this name, a literal."""
    i = list(shared.field_dict).index(name.literal_value)

    def codegen(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        meminfo, size = _allocate(context, builder, shared)
        fields = context.nrt.meminfo_data(builder, meminfo)
        cgutils.raw_memcpy(builder, fields, _fields_of(context, builder, shared, args[0]), size, 1)
        target = builder.inttoptr(builder.ptrtoint(fields, intp_t), ir.PointerType())
        builder.store(args[2], _address_of(context, builder, shared, target, i))
        with _each_field(context, builder, shared, fields) as (_, field):
            context.nrt.incref(builder, types.MemInfoPointer(types.voidptr), builder.load(field, typ=voidptr_t))
        return _hide(context, builder, shared, meminfo)

    return shared(shared, name, shared.field_dict[name.literal_value]), codegen


if config.DISABLE_JIT:

    def replace(shared: Any, name: str, array: Any) -> Any:
        return shared._replace(**{name: array})


# --- from Python and back -------------------------------------------------------------------------------------------


@box(SharedType)
def _box(shared_type: Any, value: Any, c: Any) -> Any:
    fields = [_get(c.context, c.builder, shared_type, value, name) for name in shared_type.field_dict]
    c.context.nrt.decref(c.builder, shared_type, value)
    return c.box(shared_type.plain, c.context.make_tuple(c.builder, shared_type.plain, fields))


@unbox(SharedType)
def _unbox(shared_type: Any, value: Any, c: Any) -> Any:
    context, builder = c.context, c.builder
    failed = cgutils.alloca_once_value(builder, cgutils.false_bit)
    meminfo, size = _allocate(context, builder, shared_type)
    item_of = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(c.pyapi.pyobj, [c.pyapi.pyobj, intp_t]), "PyTuple_GetItem"
    )
    fields = context.nrt.meminfo_data(builder, meminfo)
    cgutils.memset(builder, fields, size, 0)
    with _each_field(context, builder, shared_type, fields) as (i, field):
        status = c.pyapi.nrt_adapt_ndarray_from_python(builder.call(item_of, [value, i]), field)
        is_error = builder.or_(builder.load(failed, typ=cgutils.false_bit.type), cgutils.is_not_null(builder, status))
        builder.store(is_error, failed)
    with cgutils.if_unlikely(builder, builder.load(failed, typ=cgutils.false_bit.type)):
        c.pyapi.err_set_string("PyExc_TypeError", "the fields of a shared structure are arrays")
    return NativeValue(
        _hide(context, builder, shared_type, meminfo), is_error=builder.load(failed, typ=cgutils.false_bit.type)
    )
