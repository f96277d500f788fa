"""The loops that keep the nearest poses, compared with brute force in numpy; also as plain Python, NUMBA_DISABLE_JIT=1.

Poses on a grid of integers under "angle" have exact distances, many of them equal.
"""

import numpy as np
import pytest
from numba import njit
from reference import distances as reference_distances

from skpose import Skeleton
from skpose._compiled.pose.candidates import (
    Batch,
    Boxes,
    Candidates,
    Known,
    copy_code,
    nearest_of_boxes_loop,
    nearest_of_candidates_loop,
)
from skpose._compiled.pose.loops import FLOAT64_LANES, in_lanes
from skpose._compiled.pose.nearest import Groups, Heaps, bounds_of_groups_loop, nearest_of_groups_loop
from skpose._compiled.simd.lanes import lanes
from skpose.kinematics._tree import tree_of
from skpose.metrics._registry import METRICS

N_QUERIES, N_POSES = 5, 61
DTYPES = [np.dtype(np.float64), np.dtype(np.float32)]
NONE = np.full(N_QUERIES, -1)


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


def search_groups(
    X, Y, found, *, metric="angle", skeleton=None, rows=None, excluded=NONE, measure=None, bounds=None, slack=0.0
):
    """Run the loop over all poses in groups; return the number of pairs measured."""
    chosen, dtype = METRICS[metric](), found.values.dtype
    codes, lanes_of_codes = (chosen.encode_poses(poses, skeleton).astype(dtype) for poses in (X, Y))
    codes_in_lanes, width = in_lanes(lanes_of_codes), lanes(dtype)
    n_groups = -(-len(Y) // width)
    indices = np.full(n_groups * width, -1)
    indices[: len(Y)] = np.arange(len(Y))
    bounds = np.zeros((len(X), n_groups), np.float32) if bounds is None else bounds
    groups = Groups(codes_in_lanes, indices, bounds, np.full(len(X), slack))
    tail = excluded, measure or chosen.measure, tree_of(skeleton, dtype), chosen.steps, found
    return nearest_of_groups_loop(dtype)(codes, groups, *(rows or (0, len(X))), *tail)


def search_candidates(X, Y, candidates, found, *, at_once=FLOAT64_LANES, rows=None, measure=None):
    """Run the loop over candidates under "angle"; return the numbers of pairs measured and unconverged, and the gap."""
    chosen = METRICS["angle"]()
    batch = Batch(*(rows or (0, len(X))), at_once, False)
    tail = chosen.encode, measure or chosen.measure, tree_of(None), chosen.steps, found
    return nearest_of_candidates_loop(Y.dtype)(chosen.encode_poses(X, None), Y, candidates, batch, *tail)


def entries(found, i):
    """Values and indices of row i, sorted."""
    order = np.lexsort((found.indices[i, : found.counts[i]], found.values[i, : found.counts[i]]))
    return found.values[i, order], found.indices[i, order]


def assert_nearest(found, D, k, limit=np.inf, excluded=NONE):
    """The first k entries of each row of D up to the limit, by value and then by index."""
    for i, row in enumerate(D):
        order = np.argsort(row, kind="stable")
        order = order[(row[order] <= limit) & (order != excluded[i])][:k]
        values, indices = entries(found, i)
        np.testing.assert_array_equal(indices, order)
        np.testing.assert_array_equal(values, row[order].astype(values.dtype))


def all_candidates(n_queries, bounds=None, order=None):
    """All poses, in an order, as candidates of each query."""
    order = np.arange(N_POSES) if order is None else order
    bounds = np.zeros((n_queries, N_POSES)) if bounds is None else bounds
    orders = np.tile(order, (n_queries, 1))
    return Candidates(orders, orders, bounds, np.full(n_queries, N_POSES))


# --- groups ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("k", [1, 2, 7, N_POSES])
def test_k_nearest_of_groups_ties_by_index(grid, dtype, k):
    X, Y, D = grid
    found = heaps(np.full(N_QUERIES, np.inf), k, dtype)
    assert search_groups(X, Y, found) == D.size
    assert_nearest(found, D, k)


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("limit", [0.0, 2.0, 3.0, 100.0])
def test_a_distance_equal_to_the_limit_is_kept_and_none_above_it(grid, dtype, limit):
    X, Y, D = grid
    assert (limit == D).any() or limit > D.max()
    found = heaps(np.full(N_QUERIES, limit), N_POSES, dtype)
    search_groups(X, Y, found)
    assert_nearest(found, D, N_POSES, limit)
    few = heaps(np.full(N_QUERIES, limit), 3, dtype)
    search_groups(X, Y, few)
    assert_nearest(few, D, 3, limit)


def test_the_excluded_pose_is_not_kept(grid):
    X, Y, D = grid
    excluded = D.argmin(axis=1)
    found = heaps(np.full(N_QUERIES, np.inf), N_POSES)
    search_groups(X, Y, found, excluded=excluded)
    assert_nearest(found, D, N_POSES, excluded=excluded)
    assert (found.counts == N_POSES - 1).all()


def test_no_other_rows_are_touched(grid):
    X, Y, D = grid
    found = heaps(np.full(N_QUERIES, np.inf), 4)
    search_groups(X, Y, found, rows=(1, 4))
    assert_nearest(Heaps(*(part[1:4] for part in found)), D[1:4], 4)
    assert found.counts[[0, 4]].tolist() == [0, 0]


@pytest.mark.parametrize("per_bound", [1, 2])
@pytest.mark.parametrize("slack", [0.0, 0.5])
def test_only_groups_whose_bound_is_within_the_limit_are_measured(grid, per_bound, slack):
    """Even if they hold poses within it: the search relies on its bounds. One bound may be of several groups."""
    X, Y, D = grid
    limit, width = 3.0, per_bound * FLOAT64_LANES
    n_bounds = -(-N_POSES // width)
    rng = np.random.default_rng(0)
    bounds = rng.choice([0.0, 3.0, 3.25, 4.0], size=(N_QUERIES, n_bounds)).astype(np.float32)
    reached = np.repeat(bounds <= limit + slack, width, axis=1)
    found = heaps(np.full(N_QUERIES, limit), N_POSES)
    reached = reached[:, :N_POSES]
    assert search_groups(X, Y, found, bounds=bounds, slack=slack) == reached.sum() < reached.size
    assert_nearest(found, np.where(reached, D, np.inf), N_POSES, limit)


def test_groups_beyond_what_was_found_meanwhile_are_not_measured(grid):
    """After a group that is not measured; groups next to each other are measured at once."""
    X, Y, _ = grid
    found = heaps(np.full(N_QUERIES, 1.0), 1)
    Y = np.concatenate([X, Y])
    bounds = np.full((N_QUERIES, -(-len(Y) // FLOAT64_LANES)), 1e-3, np.float32)
    bounds[:, :2] = 0.0, 2.0
    assert search_groups(X, Y, found, bounds=bounds) == N_QUERIES * FLOAT64_LANES
    assert found.indices[:, 0].tolist() == list(range(N_QUERIES))


def test_what_is_ruled_out_within_a_limit_is_not_measured():
    skeleton, rng = Skeleton.chain(3), np.random.default_rng(0)
    X, Y = rng.uniform(-3, 3, size=(2, 3)), rng.uniform(-3, 3, size=(4 * FLOAT64_LANES, 3))
    D = reference_distances(X, Y, skeleton, "spatial", wrap=True)
    options = {"metric": "spatial", "skeleton": skeleton, "excluded": NONE[:2]}
    limit = 1.5 * D.min(axis=1).max()
    within = METRICS["spatial"].measure_within
    counts = []
    for measure in (None, within):
        found = heaps([limit, limit], len(Y))
        counts.append(search_groups(X, Y[D[0].argsort()], found, measure=measure, **options))
        for i, row in enumerate(D[:, D[0].argsort()]):
            values, indices = entries(found, i)
            assert set(indices) == set(np.flatnonzero(row <= limit))
            np.testing.assert_allclose(values, row[indices], rtol=1e-9)
    assert counts[0] == D.size > counts[1] > 0


def test_bounds_within_the_limit_become_the_least_distances_of_their_groups(grid):
    X, Y, D = grid
    chosen, dtype = METRICS["angle"](), np.dtype(np.float32)
    width = lanes(dtype)
    n_groups = -(-N_POSES // width)
    least = np.full((N_QUERIES, n_groups * width), np.inf)
    least[:, :N_POSES] = D
    least = least.reshape(N_QUERIES, n_groups, width).min(axis=2)
    before = np.random.default_rng(0).integers(0, 3, size=(N_QUERIES, n_groups)).astype(dtype)
    bounds, limits = before.copy(), np.array([0, 1, 2, 0, 1], dtype)
    tail = limits, chosen.measure, tree_of(None, dtype), chosen.steps, bounds
    bounds_of_groups_loop()(X.astype(dtype), in_lanes(Y.astype(dtype)), 0, N_QUERIES - 1, *tail)
    expected = np.where(before <= limits[:, None], least, before)
    expected[-1] = before[-1]
    np.testing.assert_array_equal(bounds, expected.astype(dtype))


@pytest.mark.parametrize("n_poses", [3, N_POSES, 300])
def test_points_in_boxes_some_and_then_more(grid, n_poses):
    """In order, by value and then by index, without the excluded one, within the limits."""
    X, _, _ = grid
    dtype, rng = np.dtype(np.float32), np.random.default_rng(0)
    width, X = lanes(dtype), X.astype(dtype)
    Y = rng.integers(-2, 3, size=(n_poses, 4)).astype(dtype)
    Y = Y[Y[:, 0].argsort(kind="stable")]
    indices = np.full(-(-n_poses // width) * width, -1)
    indices[:n_poses] = rng.permutation(n_poses)
    groups, levels = np.split(Y, np.arange(width, n_poses, width)), []
    for _ in range(2):
        boxes = np.array([np.concatenate([group[:, :4].min(axis=0), group[:, -4:].max(axis=0)]) for group in groups])
        levels.append(in_lanes(boxes))
        groups = np.split(boxes, np.arange(width, len(boxes), width))
    boxes = Boxes(in_lanes(Y), indices, *levels)
    D = np.linalg.norm(X[:, None].astype(float) - Y, axis=2).astype(dtype)[:, indices[:n_poses].argsort()]
    limits, excluded = np.array([0, 2, 3, 3, 9], dtype), np.arange(N_QUERIES) % n_poses
    known = Known(excluded, np.full(N_QUERIES, -1, dtype), np.full(N_QUERIES, -1))
    entries_of = [([], []) for _ in X]
    for k in (1, 7, n_poses):
        found = heaps(limits, k, dtype)
        nearest_of_boxes_loop()(X, boxes, Batch(0, N_QUERIES, 1, True), known, found)
        for i, n in enumerate(found.counts):
            for mine, part in zip(entries_of[i], (found.values, found.indices), strict=True):
                mine += part[i, :n].tolist()
            if n:
                known.values[i], known.indices[i] = found.values[i, n - 1], found.indices[i, n - 1]
    for i, row in enumerate(D):
        order = np.argsort(row, kind="stable")
        order = order[(row[order] <= limits[i]) & (order != excluded[i])]
        assert entries_of[i] == (row[order].tolist(), order.tolist())


# --- candidates ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@pytest.mark.parametrize("at_once", [1, 3, FLOAT64_LANES])
@pytest.mark.parametrize("k", [1, 6, N_POSES])
def test_k_nearest_of_candidates_in_any_order(grid, dtype, at_once, k):
    X, Y, D = grid
    candidates = all_candidates(N_QUERIES, order=np.random.default_rng(1).permutation(N_POSES))
    found = heaps(np.full(N_QUERIES, np.inf), k)
    assert search_candidates(X, Y.astype(dtype), candidates, found, at_once=at_once) == (D.size, 0, 0.0)
    assert_nearest(found, D, k)


@pytest.mark.parametrize("k", [5, N_POSES])
def test_candidates_are_rows_of_codes_and_what_is_kept_is_sorted_on_request(grid, k):
    X, Y, D = grid
    dtype, order = np.dtype(np.float32), np.random.default_rng(1).permutation(N_POSES)
    candidates = all_candidates(N_QUERIES)._replace(rows=np.tile(order.argsort(), (N_QUERIES, 1)))
    found = heaps(np.full(N_QUERIES, 3.0), k, dtype)
    tail = copy_code, METRICS["angle"].measure, tree_of(None, dtype), METRICS["angle"]().steps, found
    loop, batch = nearest_of_candidates_loop(dtype, dtype), Batch(0, N_QUERIES, lanes(dtype), True)
    loop(X.astype(dtype), Y[order].astype(dtype), candidates, batch, *tail)
    assert_nearest(found, D, k, 3.0)
    for i, n in enumerate(found.counts):
        np.testing.assert_array_equal(found.indices[i, :n], entries(found, i)[1])


def test_only_the_counted_candidates_of_the_batch_are_measured(grid):
    X, Y, D = grid
    counts = np.array([0, 1, 8, 9, N_POSES])
    found = heaps(np.full(N_QUERIES, 3.0), 5)
    candidates = all_candidates(N_QUERIES)._replace(counts=counts)
    assert search_candidates(X, Y, candidates, found, rows=(0, 4)) == (counts[:4].sum(), 0, 0.0)
    for i in range(4):
        assert_nearest(Heaps(*(part[i : i + 1] for part in found)), D[i : i + 1, : counts[i]], 5, 3.0)
    assert found.counts[4] == 0


@pytest.mark.parametrize("at_once", [1, 4])
@pytest.mark.parametrize("limit", [2.0, np.inf])
def test_candidates_are_taken_in_order_until_no_bound_is_within_reach(grid, at_once, limit):
    """A bound may equal the k-th least distance so far; the number measured is that of the rule, step by step."""
    X, Y, D = grid
    k, rng = 3, np.random.default_rng(1)
    bounds = D - rng.integers(0, 2, size=D.shape)
    order = bounds.argsort(axis=1)
    candidates = Candidates(order, order, np.take_along_axis(bounds, order, axis=1), np.full(N_QUERIES, N_POSES))
    found = heaps(np.full(N_QUERIES, limit), k)
    expected = 0
    for i in range(N_QUERIES):
        kept, rest = [], list(order[i])
        while rest:
            reach = sorted(kept)[k - 1] if len(kept) >= k else limit
            batch = [j for j in rest if bounds[i, j] <= reach][:at_once]
            rest = rest[rest.index(batch[-1]) + 1 :] if batch else []
            kept += [D[i, j] for j in batch if D[i, j] <= limit]
            expected += len(batch)
    assert search_candidates(X, Y, candidates, found, at_once=at_once) == (expected, 0, 0.0)
    assert expected < D.size
    assert_nearest(found, D, k, limit)


def test_a_candidate_whose_bound_is_above_the_limit_is_never_measured(grid):
    """Even if its distance is within the limit: the search relies on its bounds."""
    X, Y, D = grid
    bounds = np.zeros(D.shape)
    bounds[:, ::2] = 5.0
    found = heaps(np.full(N_QUERIES, 4.0), N_POSES)
    assert search_candidates(X, Y, all_candidates(N_QUERIES, bounds), found) == (D[:, 1::2].size, 0, 0.0)
    for i in range(N_QUERIES):
        assert set(entries(found, i)[1]) == {j for j in range(1, N_POSES, 2) if D[i, j] <= 4}


def test_unconverged_geodesics_are_counted_with_the_largest_gap(grid):
    X, Y, D = grid

    @njit
    def measure(x, Y, first, last, tree, steps, scratch, results):
        for w in range(results.gap.shape[1]):
            results.distances[0, w] = abs(Y[0, w] - x[0])
            if not results.skip[0, w]:
                results.gap[0, w] = max(0.0, Y[0, w])

    found = heaps(np.full(N_QUERIES, np.inf), N_POSES)
    n_measured, n_unconverged, gap = search_candidates(X, Y, all_candidates(N_QUERIES), found, measure=measure)
    assert (n_measured, n_unconverged, gap) == (D.size, N_QUERIES * (Y[:, 0] > 0).sum(), 2.0)
    assert_nearest(found, np.abs(X[:, None, 0] - Y[:, 0]), N_POSES)


def test_lanes_of_both_precisions_divide_no_index_evenly():
    """So that the tests above include a group of lanes that is not full."""
    assert all(N_POSES % lanes(dtype) for dtype in DTYPES)
