"""The loops that keep the nearest poses, compared with brute force in numpy.

Poses on a grid of integers under "angle" have exact distances, many of them equal.
"""

import numpy as np
import pytest
from reference import distances as reference_distances

from skpose import Skeleton
from skpose._compiled.pose.loops import FLOAT64_LANES, in_lanes
from skpose._compiled.pose.nearest import Groups, Heaps, nearest_of_groups
from skpose._compiled.simd.lanes import lanes
from skpose.kinematics._tree import tree_of
from skpose.metrics._registry import METRICS

N_QUERIES, N_POSES = 5, 61
DTYPES = [np.dtype(np.float64), np.dtype(np.float32)]


@pytest.fixture
def grid():
    """Queries, poses and their distances."""
    rng = np.random.default_rng(0)
    X, Y = (rng.integers(-2, 3, size=(n, 4)).astype(float) for n in (N_QUERIES, N_POSES))
    Y[[7, 40]] = X[0]
    return X, Y, np.linalg.norm(X[:, None] - Y, axis=2)


def heaps(limits, capacity, dtype=np.float64):
    """Empty heaps; what is read before it is written is a wrong answer."""
    n = len(limits)
    return Heaps(
        np.array(limits, dtype), np.full((n, capacity), -1, dtype), np.full((n, capacity), -1), np.zeros(n, np.int64)
    )


def search_groups(X, Y, found, *, metric="angle", skeleton=None):
    """Run the loop over all poses in groups; return the number of pairs measured."""
    chosen, dtype = METRICS[metric](), found.values.dtype
    codes, others = (chosen.encode_poses(poses, skeleton).astype(dtype) for poses in (X, Y))
    n_groups = -(-len(Y) // lanes(dtype))
    indices = np.append(np.arange(len(Y)), np.full(n_groups * lanes(dtype) - len(Y), -1))
    groups = Groups(in_lanes(others), indices, np.zeros((len(X), n_groups), np.float32))
    tail = np.full(len(X), -1), chosen.measure, tree_of(skeleton, dtype), chosen.steps, found
    return nearest_of_groups(codes, groups, 0, len(X), *tail)


def entries(found, i):
    """Values and indices of row i, sorted."""
    order = np.lexsort((found.indices[i, : found.counts[i]], found.values[i, : found.counts[i]]))
    return found.values[i, order], found.indices[i, order]


def assert_nearest(found, D, k, limit=np.inf):
    """The first k entries of each row of D up to the limit, by value and then by index."""
    for i, row in enumerate(D):
        order = np.argsort(row, kind="stable")
        order = order[row[order] <= limit][:k]
        values, indices = entries(found, i)
        np.testing.assert_array_equal(indices, order)
        np.testing.assert_array_equal(values, row[order].astype(values.dtype))


# --- groups ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("k", [1, 7, N_POSES])
def test_k_nearest_of_groups_ties_by_index(grid, dtype, k):
    X, Y, D = grid
    found = heaps(np.full(N_QUERIES, np.inf), k, dtype)
    assert search_groups(X, Y, found) == D.size
    assert_nearest(found, D, k)


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("limit", [0.0, 3.0, 100.0])
def test_a_distance_equal_to_the_limit_is_kept_and_none_above_it(grid, dtype, limit):
    X, Y, D = grid
    assert (limit == D).any() or limit > D.max()
    found = heaps(np.full(N_QUERIES, limit), N_POSES, dtype)
    search_groups(X, Y, found)
    assert_nearest(found, D, N_POSES, limit)
    few = heaps(np.full(N_QUERIES, limit), 3, dtype)
    search_groups(X, Y, few)
    assert_nearest(few, D, 3, limit)


def test_what_is_ruled_out_within_a_limit_is_not_measured():
    skeleton, rng = Skeleton.chain(3), np.random.default_rng(0)
    X, Y = rng.uniform(-3, 3, size=(2, 3)), rng.uniform(-3, 3, size=(4 * FLOAT64_LANES, 3))
    D = reference_distances(X, Y, skeleton, "spatial", wrap=True)
    options = {"metric": "spatial", "skeleton": skeleton}
    limit = 1.5 * D.min(axis=1).max()
    counts = []
    for most in (np.inf, limit):
        found = heaps([most, most], len(Y))
        counts.append(search_groups(X, Y[D[0].argsort()], found, **options))
        for i, row in enumerate(D[:, D[0].argsort()]):
            values, indices = entries(found, i)
            assert set(indices) == set(np.flatnonzero(row <= most))
            np.testing.assert_allclose(values, row[indices], rtol=1e-9)
    assert counts[0] == D.size > counts[1] > 0
