"""Python's `range` in compiled functions, in a fourth of the instructions that numba writes for each loop.

numba counts the passes of a loop beforehand, for a step of either sign and for zero. Here a loop compares its number
with the end, for a step whose sign is known when it is compiled. `compiler` puts this in the place of numba's own
`range`, in our functions only.
"""

from typing import Any

from numba import types
from numba.extending import lower_builtin, models, register_model

from skpose._compiled.simd.private import AbstractTemplate, alloca_once_value, impl_ret_borrowed, ir, signature


class _IteratorType(types.SimpleIteratorType):
    def __init__(self, step: int):
        self.step = step
        super().__init__(f"SkposeRangeIterator({step})", types.int64)


class _RangeType(types.SimpleIterableType):
    def __init__(self, step: int):
        self.step = step
        super().__init__(f"SkposeRange({step})", _IteratorType(step))


@register_model(_RangeType)
class _RangeModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: Any):
        super().__init__(dmm, fe_type, [("start", types.int64), ("stop", types.int64)])


@register_model(_IteratorType)
class _IteratorModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: Any):
        super().__init__(dmm, fe_type, [("number", types.EphemeralPointer(types.int64)), ("stop", types.int64)])


def short_range(*args: int) -> range:
    """Return Python's range."""
    return range(*args)


class _Template(AbstractTemplate):
    key = short_range

    def generic(self, args: tuple, kws: dict) -> Any:
        integers = all(isinstance(types.unliteral(kind), types.Integer) for kind in args)
        step = 1 if len(args) < 3 else getattr(args[2], "literal_value", 0)
        if kws or not integers or not 1 <= len(args) <= 3 or step == 0:  # of no known sign: numba's own
            plain = tuple(types.unliteral(kind) for kind in args)
            return self.context.resolve_function_type(self.context.resolve_value_type(range), plain, kws)
        return signature(_RangeType(step), *[types.int64] * len(args))


SHORT_RANGE = types.Function(_Template)


def _pair(builder: Any, kind: Any, first: Any, second: Any) -> Any:
    pair = builder.insert_value(ir.Constant(kind, ir.Undefined), first, 0)
    return builder.insert_value(pair, second, 1)


@lower_builtin(short_range, types.VarArg(types.Any))
def _range(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    if not isinstance(sig.return_type, _RangeType):
        return context.get_function(range, sig)(builder, args)
    start, stop = (context.get_constant(types.int64, 0), args[0]) if len(args) == 1 else args[:2]
    return _pair(builder, context.get_value_type(sig.return_type), start, stop)


@lower_builtin("getiter", _RangeType)
def _iterate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    number = alloca_once_value(builder, builder.extract_value(args[0], 0))
    stop = builder.extract_value(args[0], 1)
    return _pair(builder, context.get_value_type(sig.return_type), number, stop)


@lower_builtin("iternext", _IteratorType)
def _next(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    at, stop, step = builder.extract_value(args[0], 0), builder.extract_value(args[0], 1), sig.args[0].step
    kind = context.get_value_type(types.int64)
    number = builder.load(at, typ=kind)
    builder.store(builder.add(number, kind(step), flags=("nsw",)), at)
    more = builder.icmp_signed("<" if step > 0 else ">", number, stop)
    pair = _pair(builder, context.get_value_type(sig.return_type), number, more)
    return impl_ret_borrowed(context, builder, sig.return_type, pair)
