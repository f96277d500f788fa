"""Several numbers in one vector register, as a numba type.

LLVM vectorises a loop over lanes only where it can prove that no store touches a later load, which it cannot do for
slices of one scratch buffer. Here the lanes are a value instead: ``load(A, i)`` takes row i of a two-dimensional array
as one LLVM vector, ``+ - *`` and `root` work on all its lanes, ``store(A, i, v)`` puts it back. On a one-dimensional
array the same calls take and put one number, so a kernel written with them compiles to either: many poses at once, or
one.

numba's disk cache watches the file of the function that it compiled, `_kernels.py`, and does not see edits here: after
one, touch that file.
"""

import math
import operator

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


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(dmm.lookup(fe_type.dtype).get_value_type(), fe_type.width))


def _splat(context, builder, value, source, target):
    """One number in every lane."""
    if isinstance(source, Lanes):
        return value
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


def _row_pointer(context, builder, array_type, array, index, vector_type):
    struct = context.make_array(array_type)(context, builder, array)
    width = ir.Constant(ir.IntType(64), vector_type.count)
    start = builder.gep(struct.data, [builder.mul(index, width)])
    return builder.bitcast(start, vector_type.as_pointer())


@intrinsic
def _load_row(typingctx, array, index):
    result = Lanes(array.dtype)

    def codegen(context, builder, sig, args):
        i = context.cast(builder, args[1], sig.args[1], types.intp)
        pointer = _row_pointer(context, builder, sig.args[0], args[0], i, context.get_value_type(result))
        return builder.load(pointer, align=array.dtype.bitwidth // 8)

    return result(array, index), codegen


@intrinsic
def _store_row(typingctx, array, index, value):
    def codegen(context, builder, sig, args):
        target = Lanes(array.dtype)
        vector = _splat(context, builder, args[2], sig.args[2], target)
        i = context.cast(builder, args[1], sig.args[1], types.intp)
        pointer = _row_pointer(context, builder, sig.args[0], args[0], i, vector.type)
        builder.store(vector, pointer, align=array.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(array, index, value), codegen


def load(array, index):
    """Row `index` of a (n, lanes) array as Lanes; of a (n,) array, one number."""


@overload(load, jit_options=_INLINED)
def _load(array, index):
    if array.ndim == 2:
        return lambda array, index: _load_row(array, index)
    return lambda array, index: array[index]


def store(array, index, value):
    """Put Lanes, or one number for every lane, into row `index`."""


@overload(store, jit_options=_INLINED)
def _store(array, index, value):
    if array.ndim == 2:
        return lambda array, index, value: _store_row(array, index, value)

    def store_one(array, index, value):
        array[index] = value

    return store_one


def zero(array):
    """Nought in every lane of a row of this array."""


@overload(zero, jit_options=_INLINED)
def _zero(array):
    nought = array.dtype(0.0)
    if array.ndim == 2:
        return lambda array: _splat_like(array, nought)
    return lambda array: nought


@intrinsic
def _splat_like(typingctx, array, value):
    target = Lanes(array.dtype)

    def codegen(context, builder, sig, args):
        return _splat(context, builder, args[1], sig.args[1], target)

    return target(array, value), codegen


def root(value):
    """Square root of every lane."""


@intrinsic
def _root_lanes(typingctx, value):
    def codegen(context, builder, sig, args):
        vector_type = args[0].type
        name = f"llvm.sqrt.v{value.width}f{value.dtype.bitwidth}"
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector_type, [vector_type]), name)
        return builder.call(function, args)

    return value(value), codegen


@overload(root, jit_options=_INLINED)
def _root(value):
    if isinstance(value, Lanes):
        return lambda value: _root_lanes(value)
    return lambda value: math.sqrt(value)


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
