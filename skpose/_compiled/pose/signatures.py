"""numba's types of what compiled functions pass to one another, spelled out."""

import functools
from typing import Any

import numpy as np
from numba import from_dtype, types

from skpose._compiled.pose.tree import Steps, Tree
from skpose._compiled.simd.shared import SharedType


def array_type(dtype, ndim, *, readonly, layout="C"):
    return types.Array(dtype, ndim, layout, readonly=readonly)


@functools.cache
def shared_types(dtype):
    """Return numba's types of a Tree and of Steps."""
    whole, real = types.int64, from_dtype(dtype)
    kinds = dict.fromkeys(("weight", "sign", "shift", "scale"), (real, 1))
    kinds |= dict.fromkeys(("fixed_rotation", "reference", "offset"), (real, 2))
    kinds |= dict.fromkeys(("runs", "pieces", "ancestors"), (whole, 2))
    kinds |= {"ball_axes": (real, 3), "places": (whole, 3)}
    fields = [array_type(*kinds.get(name, (whole, 1)), readonly=False) for name in Tree._fields]
    steps = [whole, types.float64, types.float64, types.float64, array_type(types.float64, 2, readonly=False)]
    return SharedType(types.NamedTuple(fields, Tree)), types.NamedTuple(steps, Steps)


def named(kind: type, *fields: Any) -> types.BaseTuple:
    """Return numba's type of a NamedTuple with fields of these types."""
    if all(field == fields[0] for field in fields):
        return types.NamedUniTuple(fields[0], len(fields), kind)
    return types.NamedTuple(fields, kind)


REAL, WHOLE, FLAG = types.float64, types.int64, types.boolean
VECTOR, MATRIX, CUBE = (array_type(REAL, ndim, readonly=False) for ndim in (1, 2, 3))
FLAG_VECTOR, FLAG_MATRIX = (array_type(FLAG, ndim, readonly=False) for ndim in (1, 2))
WHOLE_VECTOR, WHOLE_MATRIX = (array_type(WHOLE, ndim, readonly=False) for ndim in (1, 2))
TREE, _ = shared_types(np.dtype(np.float64))
