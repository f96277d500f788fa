"""numba's types of what compiled functions pass to one another, spelled out."""

from typing import Any

from numba import types


def array_type(dtype, ndim, *, readonly, layout="C"):
    return types.Array(dtype, ndim, layout, readonly=readonly)


def tuple_type(kind: type, *fields: Any) -> types.BaseTuple:
    """Numba's type of a NamedTuple with fields of these types."""
    if all(field == fields[0] for field in fields):
        return types.NamedUniTuple(fields[0], len(fields), kind)
    return types.NamedTuple(fields, kind)


REAL, INTEGER, FLAG = types.float64, types.int64, types.boolean
VECTOR, MATRIX = (array_type(REAL, ndim, readonly=False) for ndim in (1, 2))
FLAG_VECTOR, FLAG_MATRIX = (array_type(FLAG, ndim, readonly=False) for ndim in (1, 2))
INTEGER_VECTOR, INTEGER_MATRIX = (array_type(INTEGER, ndim, readonly=False) for ndim in (1, 2))
