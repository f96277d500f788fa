"""The recursion of dynamic time warping, on matrices and fused with the distances, on motions of a few frames."""

import numpy as np
import pytest
import reference
from conftest import metric_of, random_tree

from skpose import Skeleton, motion_distances, pose_distances
from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose.metrics._registry import METRICS

TREE = random_tree(0, n=4)
WITH_FORMULA = [name for name in METRICS if name != "geodesic"]
WINDOWS = [None, 0.0, 0.3]


def motions(lengths, skeleton=TREE, seed=0):
    rng = np.random.default_rng(seed)
    return [rng.uniform(-3, 3, size=(n, skeleton.n_dofs)) for n in lengths]


def paths(window, is_open=False):
    return Paths(1.0 if window is None else window, is_open)


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("shape", [(1, 4), (10, 11), (12, 5)])
def test_sums_of_a_matrix(shape, window):
    costs = np.random.default_rng(0).uniform(size=shape)
    sums = costs.copy()
    accumulate(sums, paths(window))
    assert sums[-1, -1] == pytest.approx(reference.least_sum(costs, window), rel=1e-12)
    if window is None:
        for j in range(shape[1]):
            assert sums[-1, j] == pytest.approx(reference.least_sum(costs[:, : j + 1]), rel=1e-12)
        accumulate(costs_open := costs.copy(), paths(None, is_open=True))
        assert costs_open[-1].min() == pytest.approx(reference.least_sum(costs, kind="subsequence"), rel=1e-12)


@pytest.mark.parametrize("is_open", [False, True])
@pytest.mark.parametrize("shape", [(1, 4), (7, 1), (6, 9)])
def test_a_path_has_the_sum_that_it_is_the_path_of(shape, is_open):
    costs = np.random.default_rng(1).uniform(size=shape)
    accumulate(sums := costs.copy(), paths(None, is_open))
    column = int(sums[-1].argmin()) if is_open else shape[1] - 1
    path = path_to(sums, is_open, column)
    assert path[0, 0] == 0
    assert is_open or path[0, 1] == 0
    assert tuple(path[-1]) == (shape[0] - 1, column)
    assert {tuple(step) for step in np.diff(path, axis=0)} <= {(1, 0), (0, 1), (1, 1)}
    assert costs[tuple(path.T)].sum() == pytest.approx(sums[-1, column], rel=1e-12)


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("metric", WITH_FORMULA)
def test_distances_agree_with_the_definition(metric, window):
    A, B = motions([1, 2, 9]), motions([3, 10], seed=1)
    expected = reference.motion_distances(A, B, skeleton=TREE, metric=metric, window=window, wrap=True)
    found = motion_distances(A, B, skeleton=TREE, metric=metric_of(metric, wrap=True), window=window)
    np.testing.assert_allclose(found, expected, rtol=1e-10)


@pytest.mark.parametrize("metric", METRICS)
def test_fused_and_from_a_matrix_agree(metric):
    chain = Skeleton.chain(2)
    a, b = (0.1 * poses for poses in motions([5, 4], chain))
    costs = pose_distances(a, b, skeleton=chain, metric=metric)
    for alignment, is_open in (("dtw", False), ("subsequence", True)):
        accumulate(sums := costs.copy(), paths(None, is_open))
        expected = sums[-1].min() if is_open else sums[-1, -1]
        distance = motion_distances([a], [b], skeleton=chain, metric=metric, alignment=alignment, normalize=False)
        assert distance[0, 0] == pytest.approx(expected, rel=1e-12)
