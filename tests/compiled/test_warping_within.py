"""Dynamic time warping up to a limit, sums along one path, and distances to boxes, on motions of a few frames."""

import numpy as np
import pytest
from conftest import random_tree

from skpose import pose_distances
from skpose._compiled.pose import loops
from skpose._compiled.pose.measure import measure_boxes
from skpose._compiled.pose.tree import Steps
from skpose._compiled.warping.paths import Paths, accumulate, path_to
from skpose.kinematics._tree import tree_of
from skpose.metrics import Spatial
from skpose.motions._inputs import Sequences
from skpose.motions._search import Aligner, Bounds, SequenceIndex

TREE = random_tree(0, n=4)
METRIC = Spatial(4)


def motion(n_frames, seed):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(size=(n_frames, TREE.n_dofs)) * 0.3, axis=0)


def costs_of(query, other):
    return pose_distances(query, other, skeleton=TREE, metric=METRIC)


@pytest.mark.parametrize("paths", [Paths(1.0, False), Paths(0.2, False), Paths(1.0, True)])
@pytest.mark.parametrize("lengths", [(1, 9), (9, 1), (12, 17)])
def test_ends_within_a_limit(lengths, paths):
    query, other = motion(lengths[0], 1), motion(lengths[1], 2)
    index = SequenceIndex(Sequences.of([other]), TREE, METRIC)
    expected = costs_of(query, other)
    accumulate(expected, paths)
    ends = expected[-1] if paths.is_open else expected[-1, -1:]
    for limit in (np.inf, ends.max(), np.median(ends), 0.999 * ends.min()):
        for bounds in (Bounds(index, query), None):
            aligner = Aligner(index, paths)
            found = aligner.ends(aligner.encode(query), 0, len(other), bounds, limit)
            sums = found.sums if paths.is_open else found.sums[-1:]
            np.testing.assert_array_equal(sums, np.where(ends <= limit * (1 + 1e-9), ends, np.inf))
            for j in np.flatnonzero(np.isfinite(sums)) if paths.is_open else ():
                assert found.starts[j] == path_to(expected, True, j)[0, 1]


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n_coordinates", [1, 5, 18])
def test_distances_to_boxes(n_coordinates, dtype):
    rng = np.random.default_rng(0)
    corners = rng.normal(size=(2, 21, n_coordinates))
    low, high = corners.min(axis=0).astype(dtype), corners.max(axis=0).astype(dtype)
    points = rng.normal(size=(4, n_coordinates)).astype(dtype)
    points[0] = (low[3] + high[3]) / 2
    nearest = np.clip(points[:, np.newaxis], low, high)
    expected = np.linalg.norm(points[:, np.newaxis] - nearest, axis=2)
    lanes = loops.in_lanes(np.concatenate([low, high], axis=1))
    found = np.empty((4, 21), dtype)
    pairs = loops.PairRange(0, 4, 0, len(lanes) // (2 * n_coordinates), triangle=False)
    tree, steps = tree_of(None, np.dtype(dtype)), Steps.of(1, wrap=False)
    loops.pair_distances(points, lanes, pairs, measure_boxes, tree, steps, found)
    np.testing.assert_allclose(found, expected, rtol=1e-5 if dtype is np.float32 else 1e-12, atol=1e-30)
    assert found[0, 3] == 0.0
