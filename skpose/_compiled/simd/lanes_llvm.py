"""The functions of `skpose._compiled.simd.lanes` as LLVM instructions.

Pointers are opaque: every load and every address names its type. That takes llvmlite 0.45, which comes with numba 0.62.
"""

import functools
import operator

from llvmlite import ir
from numba import types
from numba.core.cgutils import get_or_insert_function, int32_t, intp_t, raw_memcpy
from numba.extending import lower_builtin, models, register_model, type_callable
from numba.np.arrayobj import populate_array

from skpose._compiled.simd import lanes


class LanesType(types.Type):
    """Numbers of one float type that fill VECTOR_BYTES, or two of them."""

    def __init__(self, dtype, width=None):
        self.dtype = dtype
        self.width = lanes.VECTOR_BYTES * 8 // dtype.bitwidth if width is None else width
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
        super().__init__(dmm, fe_type, intp_t)  # a number, as numba cannot return opaque pointers yet


def _defines(function, result):
    """Let a function of `lanes` return this type, given the types of its arguments, and compile to the decorated code.

    numba's `overload` compiles a function for each call with new types.
    """
    type_callable(function)(lambda context: result)
    return lower_builtin(function, types.VarArg(types.Any))


# --- arithmetic -----------------------------------------------------------------------------------------------------


def _broadcast(context, builder, value, source, target):
    """One number in every lane, where the target has lanes."""
    if isinstance(source, LanesType):
        return value
    if not isinstance(target, LanesType):
        return context.cast(builder, value, source, target)
    scalar = context.cast(builder, value, source, target.dtype)
    vector_type = context.get_value_type(target)
    one = builder.insert_element(ir.Constant(vector_type, ir.Undefined), scalar, ir.Constant(int32_t, 0))
    mask = ir.Constant(ir.VectorType(int32_t, target.width), [0] * target.width)
    return builder.shuffle_vector(one, one, mask)


def _define_operator(symbol, instruction):
    def result(a, b):
        for this, other in ((a, b), (b, a)):
            if isinstance(this, LanesType) and (this == other or isinstance(other, types.Number)):
                return this
        return None

    def lowering(context, builder, sig, args):
        a, b = (
            _broadcast(context, builder, value, source, sig.return_type)
            for value, source in zip(args, sig.args, strict=True)
        )
        return getattr(builder, instruction)(a, b, flags=("contract",))

    type_callable(symbol)(lambda context: result)
    for pair in ((LanesType, LanesType), (LanesType, types.Number), (types.Number, LanesType)):
        lower_builtin(symbol, *pair)(lowering)


_define_operator(operator.add, "fadd")
_define_operator(operator.sub, "fsub")
_define_operator(operator.mul, "fmul")
_define_operator(operator.truediv, "fdiv")


# --- memory ---------------------------------------------------------------------------------------------------------


def _address(context, builder, array_type, array):
    """The address of the first number of an array."""
    return builder.ptrtoint(context.make_array(array_type)(context, builder, array).data, intp_t)


def _row_address(context, builder, rows_type, address, index_type, index):
    """The address of a row, as an opaque pointer."""
    at = context.cast(builder, index, index_type, types.intp)
    start = builder.inttoptr(address, ir.PointerType())
    return builder.gep(start, [at], source_etype=context.get_value_type(rows_type.row))


def _alignment(row):
    """The alignment of a row is the one of a number, as arrays begin anywhere."""
    return (row.dtype if isinstance(row, LanesType) else row).bitwidth // 8


_ROWS = {1: lambda dtype: dtype, 2: LanesType, 3: lambda dtype: LanesType(dtype, lanes.PAIR)}  # by number of axes


@_defines(lanes.rows, lambda array, first: RowsType(_ROWS[array.ndim](array.dtype)))
def _rows(context, builder, sig, args):
    start = _address(context, builder, sig.args[0], args[0])
    first_row = _row_address(context, builder, sig.return_type, start, sig.args[1], args[1])
    return builder.ptrtoint(first_row, intp_t)


@_defines(lanes.flat, lambda array: RowsType(array.dtype))
def _flat(context, builder, sig, args):
    return _address(context, builder, sig.args[0], args[0])


@_defines(lanes.copy_to, lambda target, source: types.none)
def _copy_to(context, builder, sig, args):
    target, source = (context.make_array(kind)(context, builder, one) for kind, one in zip(sig.args, args, strict=True))
    raw_memcpy(builder, target.data, source.data, source.nitems, source.itemsize)
    return context.get_dummy_value()


@type_callable(operator.getitem)
def _type_of_row(context):
    return lambda rows, i: rows.row if isinstance(rows, RowsType) and isinstance(i, types.Integer) else None


@lower_builtin(operator.getitem, RowsType, types.Integer)
def _get_row(context, builder, sig, args):
    row = sig.args[0].row
    address = _row_address(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    return builder.load(address, align=_alignment(row), typ=context.get_value_type(row))


@type_callable(operator.setitem)
def _type_of_setting(context):
    return lambda rows, i, value: types.none if isinstance(rows, RowsType) and isinstance(i, types.Integer) else None


@lower_builtin(operator.setitem, RowsType, types.Integer, types.Any)
def _set_row(context, builder, sig, args):
    row = sig.args[0].row
    address = _row_address(context, builder, sig.args[0], args[0], sig.args[1], args[1])
    builder.store(_broadcast(context, builder, args[2], sig.args[2], row), address, align=_alignment(row))
    return context.get_dummy_value()


@_defines(lanes.full_like, lambda rows, value: rows.row)
def _full_like(context, builder, sig, args):
    return _broadcast(context, builder, args[1], sig.args[1], sig.return_type)


@_defines(lanes.empty_aligned, lambda n_rows, width, dtype: types.Array(dtype.dtype, 2, "C"))
def _empty_aligned(context, builder, sig, args):
    n_rows, width = (context.cast(builder, args[i], sig.args[i], types.intp) for i in (0, 1))
    return _allocate(context, builder, sig.return_type, (n_rows, width))


@_defines(lanes.empty_pairs, lambda n_rows, dtype: types.Array(dtype.dtype, 3, "C"))
def _empty_pairs(context, builder, sig, args):
    n_rows = context.cast(builder, args[0], sig.args[0], types.intp)
    return _allocate(context, builder, sig.return_type, (n_rows, intp_t(1), intp_t(lanes.PAIR)))


@_defines(lanes.empty_rows, lambda array, n_rows: types.Array(array.dtype, array.ndim, "C"))
def _empty_rows(context, builder, sig, args):
    shape = context.make_array(sig.args[0])(context, builder, args[0]).shape
    row = [builder.extract_value(shape, axis) for axis in range(1, sig.args[0].ndim)]
    return _allocate(context, builder, sig.return_type, (context.cast(builder, args[1], sig.args[1], types.intp), *row))


def _allocate(context, builder, array_type, shape):
    """An empty array at the start of a cache line."""
    number = context.get_data_type(array_type.dtype)
    strides = [intp_t(context.get_abi_sizeof(number))]
    for length in reversed(shape):
        strides.insert(0, builder.mul(length, strides[0]))
    memory = context.nrt.meminfo_alloc_aligned(builder, strides[0], lanes.CACHE_LINE)
    array = context.make_array(array_type)(context, builder)
    pointer = context.get_value_type(types.CPointer(array_type.dtype))
    data = builder.bitcast(context.nrt.meminfo_data(builder, memory), pointer)
    populate_array(array, data, shape, strides[1:], strides[-1], memory)
    return array._getvalue()


# --- functions ------------------------------------------------------------------------------------------------------


def _define_unary(function, name):
    """Define a function by an LLVM intrinsic of one argument."""

    @_defines(function, lambda value: value)
    def lowering(context, builder, sig, args):
        width = f"v{sig.args[0].width}" if isinstance(sig.args[0], LanesType) else ""
        bits = (sig.args[0].dtype if width else sig.args[0]).bitwidth
        signature_ = ir.FunctionType(args[0].type, [args[0].type])
        return builder.call(get_or_insert_function(builder.module, signature_, f"llvm.{name}.{width}f{bits}"), args)


_define_unary(lanes.sqrt, "sqrt")
_define_unary(lanes.rint, "rint")


@_defines(lanes.minimum, lambda a, b: a)
def _minimum(context, builder, sig, args):
    if not isinstance(sig.args[0], LanesType):
        args = args[1], args[0]  # as Python's min
    return builder.select(builder.fcmp_ordered("<", *args), *args)


@_defines(lanes.least, lambda value: value.dtype)
def _least(context, builder, sig, args):
    vector_type, value_type = args[0].type, sig.args[0]
    symbol = f"llvm.vector.reduce.fmin.v{value_type.width}f{value_type.dtype.bitwidth}"
    function_type = ir.FunctionType(vector_type.element, [vector_type])
    function = get_or_insert_function(builder.module, function_type, symbol)
    return builder.call(function, args, fastmath=("nnan",))


def _compare_greater(context, builder, sig, args):
    """A flag for each lane: its value is more than the bound."""
    bound = _broadcast(context, builder, args[1], sig.args[1], sig.args[0])
    return builder.fcmp_ordered(">", args[0], bound)


@_defines(lanes.greater, lambda value, bound: value)
def _greater(context, builder, sig, args):
    numbers = context.get_value_type(sig.return_type)
    one, zero = (
        ir.Constant(numbers, [number] * sig.return_type.width if isinstance(sig.return_type, LanesType) else number)
        for number in (1.0, 0.0)
    )
    return builder.select(_compare_greater(context, builder, sig, args), one, zero)


@_defines(lanes.any_greater, lambda value, bound: types.boolean)
def _any_greater(context, builder, sig, args):
    exceeding = _compare_greater(context, builder, sig, args)
    if not isinstance(sig.args[0], LanesType):
        return exceeding
    flags = ir.IntType(sig.args[0].width)
    return builder.icmp_unsigned("!=", builder.bitcast(exceeding, flags), ir.Constant(flags, 0))


@_defines(lanes.next_lane, lambda value: value)
def _next_lane(context, builder, sig, args):
    width = sig.args[0].width
    mask = ir.Constant(ir.VectorType(int32_t, width), [*range(1, width), width - 1])
    return builder.shuffle_vector(args[0], args[0], mask)


@_defines(lanes.sum_of_lanes, lambda value: value.dtype)
def _sum_of_lanes(context, builder, sig, args):
    each = [builder.extract_element(args[0], ir.Constant(int32_t, k)) for k in range(sig.args[0].width)]
    return functools.reduce(builder.fadd, each)
