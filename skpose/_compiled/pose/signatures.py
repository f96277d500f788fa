"""numba's types of a Tree, of Steps and of metrics, spelled out; loops that take a metric as an argument."""

import functools
import inspect
import threading
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import config, from_dtype, typeof, types

from skpose._compiled.pose.tree import Steps, Tree
from skpose._compiled.simd.jit import inlined, jit
from skpose._compiled.simd.lanes import any_greater, empty_aligned, rows
from skpose._compiled.simd.shared import shared_type
from skpose._compiled.simd.signatures import array_type, tuple_type


class Results(NamedTuple):
    """Distances from one encoded pose to groups of lanes of others, and what goes with them.

    Of one pose to one other, in scalars, the arrays have one axis of length one.
    """

    distances: np.ndarray  # (n_groups, lanes)
    skip: np.ndarray  # (n_groups, lanes) bool: not requested; a measure may compute them
    gap: np.ndarray  # (n_groups, lanes) discretisation error of an unconverged geodesic; zero elsewhere
    limit: np.ndarray  # (1,) of a distance above it only a lower bound above it is needed
    n_ruled_out: np.ndarray  # (1,) how many groups the limit has ruled out


@inlined
def results_of(n_groups, width, dtype):
    """Results of so many groups: none skipped, no gaps, no limit."""
    distances, gap = empty_aligned(n_groups, width, dtype), empty_aligned(n_groups, width, dtype)
    skip = empty_aligned(n_groups, width, np.bool_)
    # np.empty, np.zeros and slices are more functions to compile.
    limit, n_ruled_out = empty_aligned(1, 1, dtype)[0], empty_aligned(1, 1, np.int64)[0]
    limit[0], n_ruled_out[0] = np.inf, 0
    for k in range(n_groups):
        for w in range(width):
            gap[k, w], skip[k, w] = 0.0, False
    return Results(distances, skip, gap, limit, n_ruled_out)


@inlined
def skip_outside(results, group, end, start, stop):
    """Request the frames start:stop, and no others, of the groups group:end."""
    width = results.skip.shape[1]
    for k in range(group, end):
        if k == group or k == end - 1:
            for w in range(width):
                results.skip[k - group, w] = not start <= k * width + w < stop
        else:
            for w in range(width):
                results.skip[k - group, w] = False


@inlined
def add_gaps(results, n_groups, count, worst):
    """Add the requested geodesics of the groups that did not converge; clear their gaps."""
    gaps = rows(results.gap, 0)
    for k in range(n_groups):
        if any_greater(gaps[k], 0.0):
            for w in range(results.gap.shape[1]):
                if results.gap[k, w] > 0.0 and not results.skip[k, w]:
                    count += 1
                    worst = max(worst, results.gap[k, w])
                results.gap[k, w] = 0.0
    return count, worst


# --- signatures -------------------------------------------------------------------------------------------------------


FLOAT64 = np.dtype(np.float64)


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


TREE, _ = shared_types(FLOAT64)


def results_type(dtype):
    """Numba's type of Results."""
    real = from_dtype(dtype)
    kinds = (real, 2), (types.boolean, 2), (real, 2), (real, 1), (types.int64, 1)
    return tuple_type(Results, *(array_type(*kind, readonly=False) for kind in kinds))


def encode_type(dtype=FLOAT64):
    """Numba's type of a function that encodes lanes."""
    tree, steps = shared_types(dtype)
    rows_of_lanes = array_type(from_dtype(dtype), 2, readonly=False)
    return types.FunctionType(types.void(rows_of_lanes, tree, steps, rows_of_lanes, rows_of_lanes))


def measure_type(dtype):
    """Numba's type of a measure on lanes."""
    real = from_dtype(dtype)
    tree, steps = shared_types(dtype)
    x, Y = array_type(real, 1, readonly=True), array_type(real, 2, readonly=True)
    scratch = array_type(real, 2, readonly=False)
    return types.FunctionType(types.void(x, Y, types.intp, types.intp, tree, steps, scratch, results_type(dtype)))


class Loop:
    """A compiled function with a metric's `encode` or `measure` as an argument, compiled at its first call.

    Such an argument keeps a function from numba's disk cache unless its type is spelled out, and what is spelled out is
    compiled at once. Arrays are read-only, but for the last argument, which is written.
    """

    def __init__(self, function: Callable):
        self.function, self.names = function, list(inspect.signature(function).parameters)
        self.compiled: dict[np.dtype, Any] = {}
        self.compiling = threading.Lock()

    def __call__(self, *args: Any) -> Any:
        if config.DISABLE_JIT:
            return self.function(*args)
        dtype = args[self.names.index("tree")].scale.dtype
        with self.compiling:
            if dtype not in self.compiled:
                kinds = tuple(self._type_of(name, arg, dtype) for name, arg in zip(self.names, args, strict=True))
                self.compiled[dtype] = jit(self.function, signatures=[kinds])
        return self.compiled[dtype](*args)

    def _type_of(self, name: str, arg: Any, dtype: np.dtype) -> types.Type:
        if name in ("encode", "measure"):
            return encode_type(dtype) if name == "encode" else measure_type(dtype)
        if not isinstance(arg, np.ndarray):
            return typeof(arg)
        is_written = name == self.names[-1]
        return array_type(from_dtype(arg.dtype), arg.ndim, readonly=not is_written, layout="A" if is_written else "C")
