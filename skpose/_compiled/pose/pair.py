"""The distance of two poses, by a metric that is known by an address: one function for all skeletons and metrics."""

import functools
from typing import Any, NamedTuple

import numpy as np
from numba import config, types

from skpose._compiled.pose.forward import workspace_rows
from skpose._compiled.pose.results import Results
from skpose._compiled.pose.signatures import shared_types
from skpose._compiled.simd.jit import by_address, jit
from skpose._compiled.simd.kept import Kept, Layout, keep, kept_at
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
def _types():
    """Return numba's types of the fields of a PairMetric."""
    tree, steps = shared_types(np.dtype(np.float64))
    row = array_type(REAL, 1, readonly=False)
    results = tuple_type(Results, _PAIRS, _FLAG_PAIRS, _PAIRS, row, array_type(INTEGER, 1, readonly=False))
    encode = types.FunctionType(types.void(_PAIRS, tree, steps, _PAIRS, _PAIRS))
    Y, x = array_type(REAL, 3, readonly=True), array_type(REAL, 1, readonly=True)
    measure = types.FunctionType(types.void(x, Y, types.intp, types.intp, tree, steps, _PAIRS, results))
    return encode, measure, tree, steps, types.intp, types.intp


def _keep(encode, measure, tree, steps, n_codes, n_per_dof):
    return keep(PairMetric(encode, measure, tree, steps, n_codes, n_per_dof))


@functools.cache
def _keep_function():
    return jit(_keep, signatures=[types.intp(*_types())])


_LAYOUT = Layout(lambda: tuple_type(PairMetric, *_types()))


def keep_metric(metric: PairMetric) -> Kept:
    """Return what `pair_distance` takes: its address is good as long as the process lives, and only there."""
    return Kept(metric if config.DISABLE_JIT else _keep_function()(*metric))


@by_address(lambda: REAL(_PAIRS, types.intp))
def pair_distance(poses, address):
    """Compute the distance of two poses (n_dofs, 1, 2), one in each lane, by a metric that is kept at an address."""
    encode, measure, tree, steps, n_codes, n_per_dof = kept_at(address, _LAYOUT)
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
