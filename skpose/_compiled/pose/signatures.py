"""numba's types of a Tree and of Steps, spelled out."""

import functools

import numpy as np
from numba import from_dtype, types

from skpose._compiled.pose.tree import Steps, Tree
from skpose._compiled.simd.shared import shared_type
from skpose._compiled.simd.signatures import array_type


@functools.cache
def shared_types(dtype):
    """Numba's types of a Tree and of Steps."""
    integer, real = types.int64, from_dtype(dtype)
    kinds = dict.fromkeys(("weight", "sign", "shift", "scale"), (real, 1))
    kinds |= dict.fromkeys(("fixed_rotation", "reference", "offset", "slide_axis"), (real, 2))
    kinds |= {"dof_ranges": (integer, 2), "ball_axes": (real, 3)}
    fields = [array_type(*kinds.get(name, (integer, 1)), readonly=False) for name in Tree._fields]
    steps = [integer, types.float64, types.float64, types.float64, array_type(types.float64, 2, readonly=False)]
    return shared_type(Tree, fields), types.NamedTuple(steps, Steps)


TREE, _ = shared_types(np.dtype(np.float64))
