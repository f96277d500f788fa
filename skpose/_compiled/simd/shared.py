"""Named tuples of arrays as compiled functions see them: one address, of a structure that is shared and never changes.

In Python they are named tuples. `shared` makes a structure of one in a compiled function.

A tuple of thirty arrays is some two hundred numbers, which every call copies and every function unpacks: most of what
there is to compile in functions that do little else than call others.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba import types
from numba.extending import (
    NativeValue,
    box,
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    models,
    overload,
    register_model,
    typeof_impl,
    unbox,
)

from skpose._compiled.simd.private import (
    AbstractTemplate,
    AttributeTemplate,
    alloca_once,
    alloca_once_value,
    create_struct_proxy,
    false_bit,
    for_range,
    get_or_insert_function,
    global_constant,
    if_unlikely,
    impl_ret_borrowed,
    infer_global,
    int8_t,
    int32_t,
    intp_t,
    ir,
    is_not_null,
    is_null,
    memset,
    signature,
    true_bit,
    voidptr_t,
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


def _layout_of(context: Any, shared_type: Any) -> Any:
    """Return the type of the fields, as they lie in memory."""
    return context.data_model_manager[shared_type.get_data_type()].get_value_type()


def _address_of(context: Any, builder: Any, shared_type: Any, fields: Any, *indices: int) -> Any:
    """Return the address of a field, or of a part of it, given that of the fields."""
    layout = _layout_of(context, shared_type)
    return builder.gep(fields, [int32_t(i) for i in (0, *indices)], inbounds=True, source_etype=layout)


@lower_getattr_generic(SharedType)
def _get(context: Any, builder: Any, shared_type: Any, value: Any, attribute: str) -> Any:
    meminfo = create_struct_proxy(shared_type)(context, builder, value=value).meminfo
    fields = context.nrt.meminfo_data(builder, meminfo)
    i, kind = list(shared_type.field_dict).index(attribute), shared_type.field_dict[attribute]
    layout = context.get_value_type(kind)
    loaded = ir.Constant(layout, ir.Undefined)
    for k, part_type in enumerate(layout.elements):  # one by one: LLVM keeps numbers in registers, and not structures
        part = builder.load(_address_of(context, builder, shared_type, fields, i, k), typ=part_type)
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
    offsets = ir.Constant(ir.ArrayType(intp_t, len(sizes)), [sum(sizes[:i]) for i in range(len(sizes))])
    table = global_constant(builder, "skpose.offsets", offsets)
    with for_range(builder, intp_t(len(sizes))) as loop:
        address = builder.gep(table, [intp_t(0), loop.index], inbounds=True, source_etype=offsets.type)
        at = builder.load(address, typ=intp_t)
        yield loop.index, builder.gep(fields, [at], inbounds=True, source_etype=int8_t)


def _destructor(context: Any, module: Any, shared_type: Any) -> Any:
    """Return what is called when nobody refers to a structure any more: it releases the fields."""
    kind = ir.FunctionType(ir.VoidType(), [voidptr_t, intp_t, voidptr_t])
    function = get_or_insert_function(module, kind, f"skpose.release.{shared_type.name}")
    if function.is_declaration:
        function.linkage = "linkonce_odr"
        builder = ir.IRBuilder(function.append_basic_block())
        meminfo_type = types.MemInfoPointer(types.voidptr)
        with _each_field(context, builder, shared_type, function.args[0]) as (_, field):
            meminfo = builder.load(field, typ=voidptr_t)
            context.nrt.decref(builder, meminfo_type, meminfo)
        builder.ret_void()
    return function


def _allocation(context: Any, builder: Any, shared_type: Any) -> tuple[Any, Any]:
    """Return what allocates a structure: its size, and what is called when nobody refers to it any more."""
    size = context.get_constant(types.uintp, context.get_abi_sizeof(_layout_of(context, shared_type)))
    return size, _destructor(context, builder.module, shared_type)


def _hide(context: Any, builder: Any, shared_type: Any, meminfo: Any) -> Any:
    """Return the structure whose fields have just been stored.

    Loads of fields may be moved to where LLVM sees the address. It sees this one after the stores.
    """
    made = create_struct_proxy(shared_type)(context, builder)
    kind = meminfo.type
    made.meminfo = builder.asm(ir.FunctionType(kind, [kind]), "", "=r,0", [meminfo], side_effect=True)
    return made._getvalue()


def _without_type(builder: Any, pointer: Any) -> Any:
    """Return a pointer to anything, where numba's is one to bytes."""
    return builder.inttoptr(builder.ptrtoint(pointer, intp_t), ir.PointerType())


def _fill(context: Any, builder: Any, shared_type: Any, meminfo: Any, values: Any) -> Any:
    """Return a new structure with the fields of a named tuple."""
    fields = _without_type(builder, context.nrt.meminfo_data(builder, meminfo))
    for i, kind in enumerate(shared_type.plain.types):
        value = builder.extract_value(values, i)
        context.nrt.incref(builder, kind, value)
        builder.store(value, _address_of(context, builder, shared_type, fields, i))
    return _hide(context, builder, shared_type, meminfo)


def shared_type(named_tuple: type, fields: list) -> SharedType:
    """Return numba's type of a named tuple that is a shared structure, given the types of its fields."""
    return SharedType(types.NamedTuple(fields, named_tuple))


def shared_structure(named_tuple: type) -> type:
    """Let numba see a named tuple of arrays as a shared structure: a decorator of its class."""

    @typeof_impl.register(named_tuple)
    def type_of(value: Any, context: Any) -> SharedType:
        return shared_type(named_tuple, [typeof_impl(field, context) for field in value])

    return named_tuple


@unbox(SharedType)
def _unbox(shared_type: Any, value: Any, c: Any) -> Any:
    context, builder = c.context, c.builder
    value_type = context.get_value_type(shared_type)
    made = alloca_once(builder, value_type, zfill=True)
    failed = alloca_once_value(builder, false_bit)
    size, destructor = _allocation(context, builder, shared_type)
    meminfo = context.nrt.meminfo_alloc_dtor_unchecked(builder, size, destructor)
    with builder.if_else(is_null(builder, meminfo), likely=False) as (without_memory, otherwise):
        with without_memory:
            c.pyapi.err_set_string("PyExc_MemoryError", "no memory for a structure")
            builder.store(true_bit, failed)
        with otherwise:
            kind = ir.FunctionType(c.pyapi.pyobj, [c.pyapi.pyobj, intp_t])
            item_of = get_or_insert_function(builder.module, kind, "PyTuple_GetItem")
            fields = context.nrt.meminfo_data(builder, meminfo)
            memset(builder, fields, size, 0)
            with _each_field(context, builder, shared_type, fields) as (i, field):
                status = c.pyapi.nrt_adapt_ndarray_from_python(builder.call(item_of, [value, i]), field)
                is_error = builder.or_(builder.load(failed, typ=false_bit.type), is_not_null(builder, status))
                builder.store(is_error, failed)
            builder.store(_hide(context, builder, shared_type, meminfo), made)
            with if_unlikely(builder, builder.load(failed, typ=false_bit.type)):
                c.pyapi.err_set_string("PyExc_TypeError", "the fields of a shared structure are arrays")
                context.nrt.decref(builder, shared_type, builder.load(made, typ=value_type))
    return NativeValue(builder.load(made, typ=value_type), is_error=builder.load(failed, typ=false_bit.type))


@intrinsic
def _share(typingctx: Any, plain: Any) -> Any:
    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        allocation = _allocation(context, builder, signature.return_type)
        meminfo = context.nrt.meminfo_alloc_dtor(builder, *allocation)
        return _fill(context, builder, signature.return_type, meminfo, args[0])

    return SharedType(plain)(plain), codegen


def shared(plain):
    """Return a named tuple as a shared structure; without compilation, as it is."""
    return plain


@overload(shared)
def _overload_shared(plain):
    return lambda plain: _share(plain)


def replace(shared, name, array):
    """Return a shared structure with another array of this name, a literal."""
    return shared._replace(**{name: array})


@infer_global(replace)
class _Replacing(AbstractTemplate):
    prefer_literal = True

    def generic(self, args: tuple, kws: dict) -> Any:
        shared_type, name, _ = args
        return signature(shared_type, shared_type, name, shared_type.field_dict[name.literal_value])


@lower_builtin(replace, SharedType, types.Any, types.Array)
def _replace(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    shared_type, name, _ = sig.args
    allocation = _allocation(context, builder, shared_type)
    meminfo = context.nrt.meminfo_alloc_dtor(builder, *allocation)
    fields = context.nrt.meminfo_data(builder, meminfo)
    given = create_struct_proxy(shared_type)(context, builder, value=args[0]).meminfo
    kind = ir.FunctionType(ir.VoidType(), [voidptr_t, voidptr_t, intp_t, ir.IntType(1)])
    copy = get_or_insert_function(builder.module, kind, "llvm.memcpy.p0.p0.i64")
    builder.call(copy, [fields, context.nrt.meminfo_data(builder, given), allocation[0], false_bit])
    i = list(shared_type.field_dict).index(name.literal_value)
    builder.store(args[2], _address_of(context, builder, shared_type, _without_type(builder, fields), i))
    with _each_field(context, builder, shared_type, fields) as (_, field):
        context.nrt.incref(builder, types.MemInfoPointer(types.voidptr), builder.load(field, typ=voidptr_t))
    return _hide(context, builder, shared_type, meminfo)
