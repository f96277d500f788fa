"""Several numbers in one vector register, as a numba type.

LLVM vectorises a loop over lanes only where it can prove that no store touches a later load, which it cannot do for
parts of one scratch buffer. Here the lanes are a value instead. ``rows(A, first)`` is where the rows of an array begin:
of a two-dimensional one, `rows(A, 0)[i]` is row i as one LLVM vector; ``+ - *`` and `root` work on all its lanes, and
``rows(A, 0)[i] = v`` puts it back. Of a one-dimensional array the same reads and writes one number, so a kernel written
with `rows` compiles to either: many poses at once, or one. Rows check no bounds and count no references: the array must
outlive them, as a function's argument does. (Counting them in an inner loop halves its speed.)

numba's disk cache watches the file of the function that it compiled and does not see edits here: after one, touch the
files that import this one.
"""

import math
import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, lower_builtin, models, overload, register_model, type_callable

VECTOR_BYTES = 64  # one register of the widest common kind, two of the next
_INLINED = {"forceinline": True, "nogil": True}


def lanes(dtype) -> int:
    """How many numbers of this dtype are worked on at once."""
    return VECTOR_BYTES // dtype.itemsize


class Lanes(types.Type):
    """As many numbers of one float type as fill VECTOR_BYTES."""

    def __init__(self, dtype):
        self.dtype = dtype
        self.width = VECTOR_BYTES * 8 // dtype.bitwidth
        super().__init__(name=f"Lanes({dtype}, {self.width})")


class Rows(types.Type):
    """Where in memory rows of one type begin, each a number or Lanes."""

    def __init__(self, row):
        self.row = row
        super().__init__(name=f"Rows({row})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(dmm.lookup(fe_type.dtype).get_value_type(), fe_type.width))


@register_model(Rows)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, dmm.lookup(fe_type.row).get_value_type().as_pointer())


# --- arithmetic -----------------------------------------------------------------------------------------------------


def _splat(context, builder, value, source, target):
    """One number in every lane, where the target has lanes."""
    if isinstance(source, Lanes):
        return value
    if not isinstance(target, Lanes):
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
                if isinstance(this, Lanes) and (this == other or isinstance(other, types.Number)):
                    return this
            return None

        return typer

    def lowering(context, builder, sig, args):
        a, b = (
            _splat(context, builder, value, source, sig.return_type)
            for value, source in zip(args, sig.args, strict=True)
        )
        return getattr(builder, instruction)(a, b, flags=("contract",))

    for pair in ((Lanes, Lanes), (Lanes, types.Number), (types.Number, Lanes)):
        lower_builtin(symbol, *pair)(lowering)


_define_operator(operator.add, "fadd")
_define_operator(operator.sub, "fsub")
_define_operator(operator.mul, "fmul")


# --- memory ---------------------------------------------------------------------------------------------------------


@intrinsic
def rows(typingctx, array, first):
    """The rows of an array from this one on; of a one-dimensional array, its numbers."""
    row = Lanes(array.dtype) if array.ndim == 2 else array.dtype

    def codegen(context, builder, sig, args):
        data = context.make_array(sig.args[0])(context, builder, args[0]).data
        start = builder.bitcast(data, context.get_value_type(sig.return_type))
        return builder.gep(start, [context.cast(builder, args[1], sig.args[1], types.intp)])

    return Rows(row)(array, first), codegen


@intrinsic
def numbers(typingctx, array):
    """The numbers of an array of any shape, one after another."""

    def codegen(context, builder, sig, args):
        return context.make_array(sig.args[0])(context, builder, args[0]).data

    return Rows(array.dtype)(array), codegen


def _row_pointer(context, builder, sig, args):
    """Address of a row, and its alignment: that of one number, as arrays begin anywhere."""
    row = sig.args[0].row
    pointer = builder.gep(args[0], [context.cast(builder, args[1], sig.args[1], types.intp)])
    return pointer, (row.dtype if isinstance(row, Lanes) else row).bitwidth // 8


@type_callable(operator.getitem)
def _type_of_row(context):
    def typer(rows, i):
        return rows.row if isinstance(rows, Rows) and isinstance(i, types.Integer) else None

    return typer


@lower_builtin(operator.getitem, Rows, types.Integer)
def _get_row(context, builder, sig, args):
    pointer, alignment = _row_pointer(context, builder, sig, args)
    return builder.load(pointer, align=alignment)


@type_callable(operator.setitem)
def _type_of_setting(context):
    def typer(rows, i, value):
        return types.none if isinstance(rows, Rows) and isinstance(i, types.Integer) else None

    return typer


@lower_builtin(operator.setitem, Rows, types.Integer, types.Any)
def _set_row(context, builder, sig, args):
    pointer, alignment = _row_pointer(context, builder, sig, args)
    builder.store(_splat(context, builder, args[2], sig.args[2], sig.args[0].row), pointer, align=alignment)
    return context.get_dummy_value()


@intrinsic
def every(typingctx, rows, value):
    """A number as what these rows hold: the same in every lane."""

    def codegen(context, builder, sig, args):
        return _splat(context, builder, args[1], sig.args[1], sig.return_type)

    return rows.row(rows, value), codegen


# --- functions ------------------------------------------------------------------------------------------------------


def _define_unary(name, in_one):
    """An LLVM intrinsic of one argument on all lanes, and its equal for one number."""

    @intrinsic
    def on_lanes(typingctx, value):
        def codegen(context, builder, sig, args):
            vector_type = args[0].type
            symbol = f"llvm.{name}.v{value.width}f{value.dtype.bitwidth}"
            signature = ir.FunctionType(vector_type, [vector_type])
            return builder.call(cgutils.get_or_insert_function(builder.module, signature, symbol), args)

        return value(value), codegen

    def either(value):
        return (lambda value: on_lanes(value)) if isinstance(value, Lanes) else in_one

    return either


def root(value):
    """Square root of every lane."""


def nearest(value):
    """The nearest whole number, of two the even one."""


overload(root, jit_options=_INLINED)(_define_unary("sqrt", lambda value: math.sqrt(value)))
overload(nearest, jit_options=_INLINED)(_define_unary("rint", lambda value: np.rint(value)))


def smaller(a, b):
    """The smaller of the two, lane by lane."""


@intrinsic
def _smaller_lanes(typingctx, a, b):
    def codegen(context, builder, sig, args):
        return builder.select(builder.fcmp_ordered("<", *args), *args)

    return a(a, b), codegen


@overload(smaller, jit_options=_INLINED)
def _smaller(a, b):
    if isinstance(a, Lanes):
        return lambda a, b: _smaller_lanes(a, b)
    return lambda a, b: min(a, b)


def exceeds(value, bound):
    """1 in the lanes where the value is more than the bound, else 0."""


@intrinsic
def _exceeds_lanes(typingctx, value, bound):
    def codegen(context, builder, sig, args):
        limit = _splat(context, builder, args[1], sig.args[1], value)
        vector_type = context.get_value_type(value)
        one = ir.Constant(vector_type, [1.0] * value.width)
        nought = ir.Constant(vector_type, [0.0] * value.width)
        return builder.select(builder.fcmp_ordered(">", args[0], limit), one, nought)

    return value(value, bound), codegen


@overload(exceeds, jit_options=_INLINED)
def _exceeds(value, bound):
    if isinstance(value, Lanes):
        return lambda value, bound: _exceeds_lanes(value, bound)
    return lambda value, bound: 1.0 if value > bound else 0.0


def anywhere(value, bound):
    """Whether the value is more than the bound in any lane."""


@intrinsic
def _anywhere_in_lanes(typingctx, value, bound):
    def codegen(context, builder, sig, args):
        limit = _splat(context, builder, args[1], sig.args[1], value)
        flags = ir.IntType(value.width)
        found = builder.bitcast(builder.fcmp_ordered(">", args[0], limit), flags)
        return builder.icmp_unsigned("!=", found, ir.Constant(flags, 0))

    return types.boolean(value, bound), codegen


@overload(anywhere, jit_options=_INLINED)
def _anywhere(value, bound):
    if isinstance(value, Lanes):
        return lambda value, bound: _anywhere_in_lanes(value, bound)
    return lambda value, bound: value > bound
