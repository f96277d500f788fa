"""The distance of two poses, by a metric that is kept at an address: one function for all skeletons and metrics.

A compiled function with many arrays as its constants takes a second to compile, and one with an address a tenth of
that. The address belongs to this process, so numba caches no function on disk that holds one.
"""

import functools
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.signatures import Results, shared_types
from skpose._compiled.simd.jit import by_address, jit
from skpose._compiled.simd.lanes import PAIR, empty_aligned, empty_pairs
from skpose._compiled.simd.signatures import FLAG, INTEGER, REAL, array_type, tuple_type


class PairMetric(NamedTuple):
    """A metric on a skeleton, as the distance of two poses needs it."""

    encode: Any
    measure: Any
    tree: Any
    steps: Any
    n_codes: int  # of a pose of no columns
    n_per_dof: int  # more for each column


_PAIRS, _FLAG_PAIRS = array_type(REAL, 3, readonly=False), array_type(FLAG, 3, readonly=False)


@functools.cache
def _metric_type():
    tree, steps = shared_types(np.dtype(np.float64))
    row = array_type(REAL, 1, readonly=False)
    results = tuple_type(Results, _PAIRS, _FLAG_PAIRS, _PAIRS, row, array_type(INTEGER, 1, readonly=False))
    encode = types.FunctionType(types.void(_PAIRS, tree, steps, _PAIRS, _PAIRS))
    Y, x = array_type(REAL, 3, readonly=True), array_type(REAL, 1, readonly=True)
    measure = types.FunctionType(types.void(x, Y, types.intp, types.intp, tree, steps, _PAIRS, results))
    return tuple_type(PairMetric, encode, measure, tree, steps, types.intp, types.intp)


@intrinsic
def _store(typingctx, metric):
    """Store a metric in memory that is never freed; return its address."""

    def codegen(context, builder, sig, args):
        size = context.get_constant(types.uintp, context.get_abi_sizeof(context.get_value_type(metric)))
        address = builder.ptrtoint(context.nrt.allocate(builder, size), context.get_value_type(types.intp))
        context.nrt.incref(builder, metric, args[0])
        builder.store(args[0], builder.inttoptr(address, ir.PointerType()))
        return address

    return types.intp(metric), codegen


@intrinsic
def _load(typingctx, address):
    """Load the metric that is kept at an address."""

    def codegen(context, builder, sig, args):
        kind = context.get_value_type(sig.return_type)
        value = builder.load(builder.inttoptr(args[0], ir.PointerType()), typ=kind)
        context.nrt.incref(builder, sig.return_type, value)
        return value

    return _metric_type()(address), codegen


@intrinsic(prefer_literal=True)
def address_here(typingctx, address):
    """An address that is a constant of compiled code; numba does not cache such code on disk."""

    def codegen(context, builder, sig, args):
        pointer = context.add_dynamic_addr(builder, address.literal_value, "skpose")
        return builder.ptrtoint(pointer, context.get_value_type(types.intp))

    return types.intp(address), codegen


if config.DISABLE_JIT:  # the metric itself stands for its address
    _store = _load = address_here = lambda metric: metric


def _keep(encode, measure, tree, steps, n_codes, n_per_dof):
    return _store(PairMetric(encode, measure, tree, steps, n_codes, n_per_dof))


@functools.cache
def _keep_loop():
    return jit(_keep, signatures=[types.intp(*_metric_type().types)])


def keep_metric(metric: PairMetric) -> int:
    """Keep a metric for as long as the process lives; return the address that `pair_distance` takes."""
    return _keep_loop()(*metric)


@by_address(lambda: REAL(_PAIRS, types.intp))
def pair_distance(poses, address):
    """Compute the distance of two poses (n_dofs, 1, 2), one in each lane, by a metric that is kept at an address."""
    encode, measure, tree, steps, n_codes, n_per_dof = _load(address)
    n_codes += n_per_dof * poses.shape[0]
    scratch, code = empty_pairs(workspace_rows(tree), np.float64), empty_pairs(n_codes, np.float64)
    first = empty_aligned(1, n_codes, np.float64)[0]
    limit, n_ruled_out = empty_aligned(1, 1, np.float64)[0], empty_aligned(1, 1, np.int64)[0]
    results = Results(
        empty_pairs(1, np.float64), empty_pairs(1, np.bool_), empty_pairs(1, np.float64), limit, n_ruled_out
    )
    limit[0], n_ruled_out[0] = np.inf, 0
    for w in range(PAIR):
        results.skip[0, 0, w], results.gap[0, 0, w] = w == 0, 0.0
    encode(poses, tree, steps, scratch, code)
    for k in range(n_codes):
        first[k] = code[k, 0, 0]
    measure(first, code, 0, 1, tree, steps, scratch, results)
    return results.distances[0, 0, 1]
