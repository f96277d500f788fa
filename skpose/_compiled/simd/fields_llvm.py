"""Arrays of a shared structure, as the address where they are stored: nothing is loaded but what is read.

An array is some ten numbers. Those of a shared structure never change and live as long as it does, so that a number
of one takes a load of its address, and one of its shape.
"""

import operator
from typing import Any

from numba import types
from numba.extending import infer_getattr, lower_builtin, lower_getattr, models, register_model

from skpose._compiled.simd.private import (
    AbstractTemplate,
    AttributeTemplate,
    impl_ret_borrowed,
    infer_global,
    int32_t,
    intp_t,
    ir,
    signature,
)

_DATA, _SHAPE = 4, 5  # of numba's structure of an array: meminfo, parent, number of items, their size, data, shape, ...


class FieldType(types.Type):
    """The address of an array in a shared structure, and a reference to that."""

    def __init__(self, array: Any):
        if array.layout != "C":
            raise TypeError(f"the arrays of a shared structure are contiguous, got {array}")
        self.array, self.dtype, self.ndim = array, array.dtype, array.ndim
        super().__init__(name=f"Field({array})")


@register_model(FieldType)
class _FieldModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: Any):
        super().__init__(dmm, fe_type, [("meminfo", types.MemInfoPointer(types.voidptr)), ("address", types.intp)])


def field_at(context: Any, builder: Any, field: FieldType, meminfo: Any, address: Any) -> Any:
    """Return a field, given the structure's reference count and the array's address."""
    value = builder.insert_value(ir.Constant(context.get_value_type(field), ir.Undefined), meminfo, 0)
    value = builder.insert_value(value, builder.ptrtoint(address, intp_t), 1)
    return impl_ret_borrowed(context, builder, field, value)


def _load(context: Any, builder: Any, field: FieldType, value: Any, *indices: int) -> Any:
    """Return a part of the array's structure."""
    layout = context.get_value_type(field.array)
    start = builder.inttoptr(builder.extract_value(value, 1), ir.PointerType())
    at = builder.gep(start, [int32_t(i) for i in (0, *indices)], inbounds=True, source_etype=layout)
    kind = layout
    for i in indices:
        kind = kind.elements[i]
    part = builder.load(at, typ=kind)
    part.set_metadata("invariant.load", builder.module.add_metadata([]))
    return part


def load_array(context: Any, builder: Any, field: FieldType, value: Any) -> Any:
    """Return the array: one number after another, as LLVM keeps numbers in registers, and not structures."""
    layout = context.get_value_type(field.array)
    loaded = ir.Constant(layout, ir.Undefined)
    for k in range(len(layout.elements)):
        loaded = builder.insert_value(loaded, _load(context, builder, field, value, k), k)
    return loaded


def data_of(context: Any, builder: Any, field: FieldType, value: Any) -> Any:
    """Return the address of the first number of the array."""
    return _load(context, builder, field, value, _DATA)


def _length(context: Any, builder: Any, field: FieldType, value: Any, axis: int) -> Any:
    return _load(context, builder, field, value, _SHAPE, axis)


@infer_getattr
class _Attributes(AttributeTemplate):
    key = FieldType

    def generic_resolve(self, field: FieldType, attribute: str) -> Any:
        return {"shape": types.UniTuple(types.intp, field.ndim), "size": types.intp}.get(attribute)


@lower_getattr(FieldType, "shape")
def _shape(context: Any, builder: Any, field: FieldType, value: Any) -> Any:
    lengths = [_length(context, builder, field, value, axis) for axis in range(field.ndim)]
    return context.make_tuple(builder, types.UniTuple(types.intp, field.ndim), lengths)


@lower_getattr(FieldType, "size")
def _size(context: Any, builder: Any, field: FieldType, value: Any) -> Any:
    return _load(context, builder, field, value, 2)


# --- items ----------------------------------------------------------------------------------------------------------


def _indices_of(index: Any) -> tuple:
    return tuple(index) if isinstance(index, types.BaseTuple) else (index,)


def _is_number(field: FieldType, index: Any) -> bool:
    """Return whether an index is one of a number, and not of a part of the array."""
    indices = _indices_of(index)
    return len(indices) == field.ndim and all(isinstance(i, types.Integer) for i in indices)


@infer_global(operator.getitem)
class _Getting(AbstractTemplate):
    def generic(self, args: tuple, kws: dict) -> Any:
        field, index = args
        if not isinstance(field, FieldType):
            return None
        if _is_number(field, index):
            return signature(field.dtype, field, index)
        plain = self.context.resolve_function_type(operator.getitem, (field.array, index), {})
        return None if plain is None else signature(plain.return_type, field, plain.args[1])


@infer_global(operator.setitem)
class _Setting(AbstractTemplate):
    def generic(self, args: tuple, kws: dict) -> Any:
        field, index, value = args
        if not isinstance(field, FieldType):
            return None
        if not field.array.mutable:
            return None
        if _is_number(field, index):
            return signature(types.none, field, index, field.dtype)
        plain = self.context.resolve_function_type(operator.setitem, (field.array, index, value), {})
        return None if plain is None else signature(types.none, field, *plain.args[1:])


def _item_address(context: Any, builder: Any, field: FieldType, value: Any, kind: Any, index: Any) -> Any:
    """Return the address of a number; a negative index counts from the end."""
    kinds, at = _indices_of(kind), None
    indices = [builder.extract_value(index, i) for i in range(len(kinds))] if len(kinds) > 1 else [index]
    for axis, (each, number) in enumerate(zip(kinds, indices, strict=True)):
        i = context.cast(builder, number, each, types.intp)
        literal = getattr(each, "literal_value", -1 if each.signed else 0)
        if axis > 0 or literal < 0:
            length = _length(context, builder, field, value, axis)
        if literal < 0:
            i = builder.select(builder.icmp_signed("<", i, intp_t(0)), builder.add(i, length), i)
        at = i if at is None else builder.add(builder.mul(at, length), i)
    data = _load(context, builder, field, value, _DATA)
    return builder.gep(data, [at], inbounds=True, source_etype=context.get_data_type(field.dtype))


@lower_builtin(operator.getitem, FieldType, types.Any)
def _get(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    field, kind = sig.args
    if not _is_number(field, kind):
        plain = signature(sig.return_type, field.array, kind)
        array = load_array(context, builder, field, args[0])
        return context.get_function(operator.getitem, plain)(builder, (array, args[1]))
    at = _item_address(context, builder, field, args[0], kind, args[1])
    model = context.data_model_manager[field.dtype]
    number = model.from_data(builder, builder.load(at, typ=model.get_data_type()))
    return impl_ret_borrowed(context, builder, sig.return_type, number)


@lower_builtin(operator.setitem, FieldType, types.Any, types.Any)
def _set(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    field, kind, number_kind = sig.args
    if not _is_number(field, kind):
        plain = signature(types.none, field.array, kind, number_kind)
        array = load_array(context, builder, field, args[0])
        return context.get_function(operator.setitem, plain)(builder, (array, *args[1:]))
    at = _item_address(context, builder, field, args[0], kind, args[1])
    number = context.cast(builder, args[2], number_kind, field.dtype)
    builder.store(context.data_model_manager[field.dtype].as_data(builder, number), at)
    return context.get_dummy_value()
