"""The compiled loops over poses and over pairs, whatever the metric."""

import functools

import numpy as np
from numba import from_dtype, types

from skpose._compiled.forward import workspace_rows
from skpose._compiled.jit import jit
from skpose._compiled.lanes import anywhere, lanes, rows
from skpose._compiled.tree import Steps, Tree

CACHE_LINE = 64  # bytes
BLOCKS_IN_CACHE = 16  # blocks of lanes that are used on one row after the other
FLOAT64_LANES = lanes(np.dtype(np.float64))


@jit
def aligned(n_rows, width, dtype):
    """An empty array (n_rows, width) that begins at a cache line, as a row that straddles two takes twice the time."""
    raw = np.empty(n_rows * width + CACHE_LINE, dtype)
    skip = (-raw.ctypes.data % CACHE_LINE) // raw.itemsize
    return raw[skip : skip + n_rows * width].reshape((n_rows, width))


def _encode_poses(poses, encode, tree, steps, codes):
    n_poses, n_dofs = poses.shape
    scratch = aligned(workspace_rows(tree), FLOAT64_LANES, poses.dtype)
    pose = aligned(n_dofs, FLOAT64_LANES, poses.dtype)
    code = aligned(codes.shape[1], FLOAT64_LANES, poses.dtype)
    for start in range(0, n_poses, FLOAT64_LANES):
        for w in range(FLOAT64_LANES):
            i = min(start + w, n_poses - 1)
            for d in range(n_dofs):
                pose[d, w] = poses[i, d]
        encode(pose, tree, steps, scratch, code)
        for w in range(min(FLOAT64_LANES, n_poses - start)):
            for k in range(codes.shape[1]):
                codes[start + w, k] = code[k, w]


def _pair_distances(X, Y, first, last, first_block, last_block, triangle, measure, tree, steps, distances):
    width = Y.shape[1]
    scratch = aligned(workspace_rows(tree), width, X.dtype)
    out = aligned(2 * BLOCKS_IN_CACHE, width, X.dtype)
    doubts = rows(out, 0)
    n_doubtful, worst = 0, 0.0
    for group in range(first_block, last_block, BLOCKS_IN_CACHE):
        end = min(group + BLOCKS_IN_CACHE, last_block)
        for i in range(first, min(last, end * width) if triangle else last):
            start = max(group, i // width) if triangle else group
            first_wanted = i + 1 - start * width if triangle else 0
            n_columns = min(end * width, distances.shape[1]) - start * width
            for k in range(end - start):
                doubts[2 * k + 1] = 0.0
                if k * width < first_wanted or n_columns < (k + 1) * width:
                    for w in range(width):
                        if not first_wanted <= k * width + w < n_columns:
                            out[2 * k + 1, w] = -1.0
            measure(X[i], Y, start, end, tree, steps, scratch, out)
            for k in range(end - start):
                for w in range(min(width, n_columns - k * width)):
                    distances[i, (start + k) * width + w] = out[2 * k, w]
                if anywhere(doubts[2 * k + 1], 0.0):
                    for w in range(width):
                        if out[2 * k + 1, w] > 0.0:
                            n_doubtful += 1
                            worst = max(worst, out[2 * k + 1, w])
    return n_doubtful, worst


def _pair_distance(x, y, n_codes, encode, measure, tree, steps):
    scratch, out = np.empty(workspace_rows(tree)), np.zeros(2)
    codes = np.empty((2, n_codes))
    encode(x, tree, steps, scratch, codes[0])
    encode(y, tree, steps, scratch, codes[1])
    measure(codes[0], codes[1], 0, 1, tree, steps, scratch, out)
    return out[0]


def array_type(dtype, ndim, *, readonly, layout="C"):
    return types.Array(dtype, ndim, layout, readonly=readonly)


@functools.cache
def shared_types(dtype):
    """numba's types of a Tree and of Steps."""
    whole, real = types.int64, from_dtype(dtype)
    kinds = dict.fromkeys(("weight", "sign", "shift"), (real, 1))
    kinds |= {"fixed_turn": (real, 2), "offset": (real, 2), "runs": (whole, 2)}
    fields = [array_type(*kinds.get(name, (whole, 1)), readonly=False) for name in Tree._fields]
    steps = [whole, types.float64, types.float64, types.float64]
    return types.NamedTuple(fields, Tree), types.NamedTuple(steps, Steps)


# A function passed to a compiled function keeps it from numba's disk cache unless its type is spelled out, and what is
# spelled out is compiled at once; hence the three below are compiled when they are first asked for.


@functools.cache
def _encode_poses_loop():
    real = types.float64
    tree, steps = shared_types(np.dtype(np.float64))
    row = array_type(real, 2, readonly=False)
    encode = types.FunctionType(types.void(row, tree, steps, row, row))
    poses, codes = array_type(real, 2, readonly=True), array_type(real, 2, readonly=False)
    return jit(_encode_poses, signatures=[types.void(poses, encode, tree, steps, codes)])


def encode_poses(poses, encode, tree, steps, codes):
    """Write the codes (n_poses, n_codes) of poses (n_poses, n_dofs), in float64."""
    _encode_poses_loop()(np.ascontiguousarray(poses, dtype=np.float64), encode, tree, steps, codes)


@functools.cache
def pair_distance_function():
    """``pair(x, y, n_codes, encode, measure, tree, steps)``: the distance of two poses, in float64."""
    real = types.float64
    tree, steps = shared_types(np.dtype(np.float64))
    pose, row = array_type(real, 1, readonly=True), array_type(real, 1, readonly=False)
    encode = types.FunctionType(types.void(pose, tree, steps, row, row))
    measure = types.FunctionType(types.void(row, row, types.intp, types.intp, tree, steps, row, row))
    return jit(_pair_distance, signatures=[real(pose, pose, types.intp, encode, measure, tree, steps)])


@functools.cache
def pair_distances_loop(dtype):
    """``loop(X, Y, first, last, first_block, last_block, triangle, measure, tree, steps, distances)``: one tile.

    X holds codes as rows, Y blocks of n_codes rows of lanes, one after another. With ``triangle`` X and Y are the same
    poses and only the columns from the diagonal's block on are written. Returns how many distances are in doubt, and by
    how much at most: a measure says so in every second row of what it puts out, which holds -1 on entry where nobody
    wants a distance.
    """
    real, at = from_dtype(dtype), types.intp
    tree, steps = shared_types(dtype)
    x, Y = array_type(real, 1, readonly=True), array_type(real, 2, readonly=True)
    scratch = array_type(real, 2, readonly=False)
    measure = types.FunctionType(types.void(x, Y, at, at, tree, steps, scratch, scratch))
    X, distances = array_type(real, 2, readonly=True), array_type(real, 2, readonly=False, layout="A")
    found = types.Tuple((types.int64, types.float64))
    signature = found(X, Y, at, at, at, at, types.boolean, measure, tree, steps, distances)
    return jit(_pair_distances, signatures=[signature])


def in_lanes(codes):
    """Codes (n, n_codes) as blocks of n_codes rows of lanes, one after another, the last one filled up with copies."""
    width = lanes(codes.dtype)
    n_blocks, n_codes = -(-len(codes) // width), codes.shape[1]
    rows_of_lanes = aligned(n_blocks * n_codes, width, codes.dtype)
    blocks = rows_of_lanes.reshape(n_blocks, n_codes, width)
    n_full = len(codes) // width
    blocks[:n_full] = codes[: n_full * width].reshape(n_full, width, n_codes).transpose(0, 2, 1)
    if n_full < n_blocks:
        blocks[-1] = codes[np.minimum(np.arange(n_full * width, n_blocks * width), len(codes) - 1)].T
    return rows_of_lanes
