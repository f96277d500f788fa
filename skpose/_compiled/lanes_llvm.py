"""The functions of `skpose._compiled.lanes` as LLVM instructions. All that is taken from llvmlite stands here.

Pointers are opaque: every load and every address names its type. That takes llvmlite 0.45, which comes with numba 0.62.
"""

import functools
import math
import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, lower_builtin, models, overload, register_model, type_callable

from skpose._compiled import lanes

_INLINED = {"forceinline": True, "nogil": True}


class LanesType(types.Type):
    """Numbers of one float type that fill VECTOR_BYTES."""

    def __init__(self, dtype):
        self.dtype = dtype
        self.width = lanes.VECTOR_BYTES * 8 // dtype.bitwidth
        super().__init__(name=f"Lanes({dtype}, {self.width})")


class RowsType(types.Type):
    """An address in memory from which rows of one type lie one after another, each a number or lanes."""

    def __init__(self, row):
        self.row = row
        super().__init__(name=f"Rows({row})")


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(dmm.lookup(fe_type.dtype).get_value_type(), fe_type.width))


@register_model(RowsType)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, cgutils.intp_t)  # a number, as numba cannot return opaque pointers yet


# --- arithmetic -----------------------------------------------------------------------------------------------------


def _broadcast(context, builder, value, source, target):
    """Return one number in every lane, where the target has lanes."""
    if isinstance(source, LanesType):
        return value
    if not isinstance(target, LanesType):
        return context.cast(builder, value, source, target)
    scalar = context.cast(builder, value, source, target.dtype)
    vector_type = context.get_value_type(target)
    one = builder.insert_element(ir.Constant(vector_type, ir.Undefined), scalar, ir.Constant(ir.IntType(32), 0))
    mask = ir.Constant(ir.VectorType(ir.IntType(32), target.width), [0] * target.width)
    return builder.shuffle_vector(one, one, mask)


def _define_operator(symbol, instruction):
    @type_callable(symbol)
    def typing(context):
        def typer(a, b):
            for this, other in ((a, b), (b, a)):
                if isinstance(this, LanesType) and (this == other or isinstance(other, types.Number)):
                    return this
            return None

        return typer

    def lowering(context, builder, sig, args):
        a, b = (
            _broadcast(context, builder, value, source, sig.return_type)
            for value, source in zip(args, sig.args, strict=True)
        )
        return getattr(builder, instruction)(a, b, flags=("contract",))

    for pair in ((LanesType, LanesType), (LanesType, types.Number), (types.Number, LanesType)):
        lower_builtin(symbol, *pair)(lowering)


_define_operator(operator.add, "fadd")
_define_operator(operator.sub, "fsub")
_define_operator(operator.mul, "fmul")
_define_operator(operator.truediv, "fdiv")


# --- memory ---------------------------------------------------------------------------------------------------------


def _address(context, builder, array_type, array):
    """Return the address of the first number of an array."""
    return builder.ptrtoint(context.make_array(array_type)(context, builder, array).data, cgutils.intp_t)


def _row_address(context, builder, rows_type, address, index_type, index):
    """Return the address of a row, as an opaque pointer."""
    at = context.cast(builder, index, index_type, types.intp)
    start = builder.inttoptr(address, ir.PointerType())
    return builder.gep(start, [at], source_etype=context.get_value_type(rows_type.row))


def _alignment(row):
    """Return the alignment of a row: that of one number, as arrays begin anywhere."""
    return (row.dtype if isinstance(row, LanesType) else row).bitwidth // 8


@intrinsic
def _rows(typingctx, array, first):
    row = LanesType(array.dtype) if array.ndim == 2 else array.dtype

    def codegen(context, builder, sig, args):
        start = _address(context, builder, sig.args[0], args[0])
        first_row = _row_address(context, builder, sig.return_type, start, sig.args[1], args[1])
        return builder.ptrtoint(first_row, cgutils.intp_t)

    return RowsType(row)(array, first), codegen


@intrinsic
def _flat(typingctx, array):
    def codegen(context, builder, sig, args):
        return _address(context, builder, sig.args[0], args[0])

    return RowsType(array.dtype)(array), codegen


@type_callable(operator.getitem)
def _type_of_row(context):
    def typer(rows, i):
        return rows.row if isinstance(rows, RowsType) and isinstance(i, types.Integer) else None

    return typer


@lower_builtin(operator.getitem, RowsType, types.Integer)
def _get_row(context, builder, sig, args):
    row = sig.args[0].row
    address = _row_address(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    return builder.load(address, align=_alignment(row), typ=context.get_value_type(row))


@type_callable(operator.setitem)
def _type_of_setting(context):
    def typer(rows, i, value):
        return types.none if isinstance(rows, RowsType) and isinstance(i, types.Integer) else None

    return typer


@lower_builtin(operator.setitem, RowsType, types.Integer, types.Any)
def _set_row(context, builder, sig, args):
    row = sig.args[0].row
    address = _row_address(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    builder.store(_broadcast(context, builder, args[2], sig.args[2], row), address, align=_alignment(row))
    return context.get_dummy_value()


@intrinsic
def _full_like(typingctx, rows, value):
    def codegen(context, builder, sig, args):
        return _broadcast(context, builder, args[1], sig.args[1], sig.return_type)

    return rows.row(rows, value), codegen


@overload(lanes.rows, jit_options=_INLINED)
def _overload_rows(array, first):
    return lambda array, first: _rows(array, first)


@overload(lanes.flat, jit_options=_INLINED)
def _overload_flat(array):
    return lambda array: _flat(array)


@overload(lanes.full_like, jit_options=_INLINED)
def _overload_full_like(rows, value):
    return lambda rows, value: _full_like(rows, value)


# --- functions ------------------------------------------------------------------------------------------------------


def _define_unary(name, on_one):
    """An LLVM intrinsic of one argument on all lanes, and the same for one number."""

    @intrinsic
    def on_lanes(typingctx, value):
        def codegen(context, builder, sig, args):
            vector_type = args[0].type
            symbol = f"llvm.{name}.v{value.width}f{value.dtype.bitwidth}"
            signature = ir.FunctionType(vector_type, [vector_type])
            return builder.call(cgutils.get_or_insert_function(builder.module, signature, symbol), args)

        return value(value), codegen

    def either(value):
        return (lambda value: on_lanes(value)) if isinstance(value, LanesType) else on_one

    return either


overload(lanes.sqrt, jit_options=_INLINED)(_define_unary("sqrt", lambda value: math.sqrt(value)))
overload(lanes.rint, jit_options=_INLINED)(_define_unary("rint", lambda value: np.rint(value)))


@intrinsic
def _minimum_of_lanes(typingctx, a, b):
    def codegen(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered("<", *args), *args)

    return a(a, b), codegen


@overload(lanes.minimum, jit_options=_INLINED)
def _overload_minimum(a, b):
    if isinstance(a, LanesType):
        return lambda a, b: _minimum_of_lanes(a, b)
    return lambda a, b: min(a, b)


@intrinsic
def _least_of_lanes(typingctx, value):
    def codegen(context, builder, sig, args):
        vector_type, value_type = args[0].type, sig.args[0]
        symbol = f"llvm.vector.reduce.fmin.v{value_type.width}f{value_type.dtype.bitwidth}"
        signature = ir.FunctionType(vector_type.element, [vector_type])
        return builder.call(cgutils.get_or_insert_function(builder.module, signature, symbol), args, fastmath=("nnan",))

    return value.dtype(value), codegen


@overload(lanes.least, jit_options=_INLINED)
def _overload_least(value):
    return lambda value: _least_of_lanes(value)


def _exceeding(context, builder, sig, args):
    """Return a flag for each lane: its value is more than the bound."""
    bound = _broadcast(context, builder, args[1], sig.args[1], sig.args[0])
    return builder.fcmp_ordered(">", args[0], bound)


@intrinsic
def _greater_lanes(typingctx, value, bound):
    def codegen(context, builder, sig, args):
        vector_type = context.get_value_type(value)
        one, zero = (ir.Constant(vector_type, [number] * value.width) for number in (1.0, 0.0))
        return builder.select(_exceeding(context, builder, sig, args), one, zero)

    return value(value, bound), codegen


@overload(lanes.greater, jit_options=_INLINED)
def _overload_greater(value, bound):
    if isinstance(value, LanesType):
        return lambda value, bound: _greater_lanes(value, bound)
    return lambda value, bound: 1.0 if value > bound else 0.0


@intrinsic
def _any_greater_lane(typingctx, value, bound):
    def codegen(context, builder, sig, args):
        flags = ir.IntType(value.width)
        exceeding = builder.bitcast(_exceeding(context, builder, sig, args), flags)
        return builder.icmp_unsigned("!=", exceeding, ir.Constant(flags, 0))

    return types.boolean(value, bound), codegen


@overload(lanes.any_greater, jit_options=_INLINED)
def _overload_any_greater(value, bound):
    if isinstance(value, LanesType):
        return lambda value, bound: _any_greater_lane(value, bound)
    return lambda value, bound: value > bound


@intrinsic
def _next_lane(typingctx, value):
    def codegen(context, builder, sig, args):
        source = [*range(1, value.width), value.width - 1]
        mask = ir.Constant(ir.VectorType(ir.IntType(32), value.width), source)
        return builder.shuffle_vector(args[0], args[0], mask)

    return value(value), codegen


@overload(lanes.next_lane, jit_options=_INLINED)
def _overload_next_lane(value):
    return lambda value: _next_lane(value)


@intrinsic
def _sum_of_lanes(typingctx, value):
    def codegen(context, builder, sig, args):
        each = [builder.extract_element(args[0], ir.Constant(ir.IntType(32), lane)) for lane in range(value.width)]
        return functools.reduce(builder.fadd, each)

    return value.dtype(value), codegen


@overload(lanes.sum_of_lanes, jit_options=_INLINED)
def _overload_sum_of_lanes(value):
    return lambda value: _sum_of_lanes(value)
