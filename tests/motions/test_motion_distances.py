"""Distances between motions: the definition, all lengths and tilings, invariances."""

import tracemalloc
from itertools import pairwise

import joblib
import numpy as np
import pytest
import reference
from conftest import SKELETONS, in_turns, random_tree

from skpose import Skeleton, motion_distances, pose_distances
from skpose._compiled.warping.paths import Paths, accumulate
from skpose._utils.parallel import from_workers
from skpose.metrics._registry import METRICS
from skpose.motions import _distances

HUMANOID, TREE, CHAIN = SKELETONS["humanoid"], random_tree(0), Skeleton.chain(2)
WITH_FORMULA = [name for name in METRICS if name != "geodesic"]
ALIGNMENTS = ["dtw", "subsequence", "frames"]
WINDOWS = [0.0, 0.04, None]


def motions(lengths, skeleton=TREE, seed=0, scale=0.1):
    """Return random walks."""
    rng = np.random.default_rng(seed)
    return [np.cumsum(rng.normal(0, scale, size=(n, skeleton.n_dofs)), axis=0) for n in lengths]


def for_geodesics(metric):
    """Return the skeleton and the lengths of motions, small ones for geodesics."""
    return (CHAIN, [3, 1, 5, 2]) if metric == "geodesic" else (TREE, [9, 1, 30, 12, 17])


def plain(X, Y, skeleton, metric, window=None, alignment="dtw"):
    """Return the distances by our own distances between all frames and a recursion of Python."""
    D = np.empty((len(X), len(Y)))
    for i, j in np.ndindex(D.shape):
        costs = pose_distances(X[i], Y[j].copy(), skeleton=skeleton, metric=metric).astype(float)
        D[i, j] = reference.least_sum(costs, window, alignment)
        D[i, j] /= len(X[i]) + (len(Y[j]) if alignment == "dtw" else 0)
    return D


@pytest.mark.parametrize(("metric", "alignment"), in_turns(list(METRICS), ALIGNMENTS))
def test_the_definition(metric, alignment):
    skeleton, _ = for_geodesics(metric)
    lengths = [4] * 3 if alignment == "frames" else [6, 1, 3]
    X, Y = motions(lengths, skeleton), motions(lengths[:2], skeleton, seed=1)
    parameters = {"skeleton": skeleton, "metric": metric, "alignment": alignment}
    D = motion_distances(X, Y, **parameters)
    np.testing.assert_allclose(D, plain(X, Y, skeleton, metric, alignment=alignment), rtol=1e-10)
    if metric != "geodesic":  # whose definition is a search for the shortest curve
        wrap = metric == "spatial"
        expected = reference.motion_distances(X, Y, skeleton, metric, kind=alignment, wrap=wrap)
        np.testing.assert_allclose(D, expected, rtol=1e-10)


@pytest.mark.parametrize(("n_frames", "window"), in_turns([1, 8, 129, 300], WINDOWS))
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_all_lengths(n_frames, window, dtype):
    """Whether or not columns fill groups of lanes and blocks of them, anywhere among other motions."""
    X = [a.astype(dtype) for a in motions([1, 2, 40], CHAIN)]
    Y = [b.astype(dtype) for b in motions([n_frames, 5, 1, n_frames, 130], CHAIN, seed=1)]
    D = motion_distances(X, Y, skeleton=CHAIN, metric="position", window=window)
    assert D.dtype == dtype
    tolerance = 1e-12 if dtype is np.float64 else 1e-5
    for i, a in enumerate(X):
        for j, b in enumerate(Y):
            costs = pose_distances(a, b, skeleton=CHAIN, metric="position").astype(float)
            accumulate(costs, Paths(1.0 if window is None else window, False))
            assert D[i, j] == pytest.approx(costs[-1, -1] / (len(a) + len(b)), rel=tolerance)


@pytest.mark.parametrize("n_frames", [1, 128, 300])
def test_a_subsequence_in_several_blocks(n_frames):
    X, Y = motions([1, 20, 150], CHAIN), motions([3, n_frames, 300], CHAIN, seed=1)
    D = motion_distances(X, Y, skeleton=CHAIN, alignment="subsequence")
    np.testing.assert_allclose(D, plain(X, Y, CHAIN, "spatial", alignment="subsequence"), rtol=1e-12)


@pytest.mark.parametrize(("metric", "dtype"), in_turns(list(METRICS), [np.float64, np.float32]))
def test_one_triangle_is_symmetric_with_zero_diagonal(metric, dtype):
    skeleton, lengths = for_geodesics(metric)
    X = [a.astype(dtype) for a in motions(lengths, skeleton)]
    for window in (None, 0.3):
        parameters = {"skeleton": skeleton, "metric": metric, "window": window}
        D = motion_distances(X, **parameters)
        assert D.dtype == dtype
        np.testing.assert_array_equal(D, D.T)
        np.testing.assert_array_equal(np.diag(D), 0)
        assert (D[~np.eye(len(D), dtype=bool)] > 0).all()
        copies = [a.copy() for a in X]
        tolerance = 1e-10 if dtype is np.float64 else 2e-5
        np.testing.assert_allclose(D, motion_distances(X, copies, **parameters), rtol=tolerance, atol=1e-12)
        np.testing.assert_array_equal(D, motion_distances(X, X, **parameters))


def test_a_subsequence_is_found_where_it_is():
    (whole,) = motions([60])
    D = motion_distances([whole[20:45], whole], skeleton=TREE, alignment="subsequence")
    assert D[0, 1] == 0
    assert D[1, 0] > 0
    assert motion_distances([whole[20:45]], [whole], skeleton=TREE)[0, 0] > 0


@pytest.mark.parametrize("alignment", ALIGNMENTS)
def test_normalize_divides_by_the_number_of_frames(alignment):
    X, Y = (motions([7] * 3), motions([7] * 2)) if alignment == "frames" else (motions([7, 3, 12]), motions([5, 9]))
    parameters = {"skeleton": TREE, "alignment": alignment}
    sums = motion_distances(X, Y, normalize=False, **parameters)
    frames = np.array([[len(a) + (len(b) if alignment == "dtw" else 0) for b in Y] for a in X])
    np.testing.assert_array_equal(motion_distances(X, Y, **parameters), sums / frames)


def test_a_narrower_window_is_never_nearer():
    X = motions([30, 41, 56])
    D = [motion_distances(X, skeleton=TREE, window=w) for w in (None, 1, 0.5, 0.2, 0.1, 0.05, 0)]
    np.testing.assert_array_equal(D[0], D[1])
    for wide, narrow in pairwise(D):
        assert (wide <= narrow).all()
    assert (D[0] < D[-1])[np.triu_indices(3, 1)].all()


@pytest.mark.parametrize(("metric", "alignment"), in_turns(["spatial", "angle", "position"], ALIGNMENTS))
def test_the_number_of_threads_and_of_tasks_changes_nothing(metric, alignment, monkeypatch):
    skeleton, lengths = for_geodesics(metric)
    X = motions([4] * 5 if alignment == "frames" else lengths, skeleton)
    cases = [(X, None), (X, [a + 0.1 for a in X[:3]])]
    parameters = {"skeleton": skeleton, "metric": metric, "alignment": alignment}
    one = [motion_distances(*case, **parameters) for case in cases]
    monkeypatch.setattr(_distances, "WORK_PER_TASK", 1.0)  # a task for every pair
    monkeypatch.setattr(_distances, "LITTLE_WORK", 1.0)
    monkeypatch.setattr("skpose.metrics._matrix.WORK_PER_TASK", 1.0)
    for edge in (1, 2**20):  # tiles of few motions, and of all
        monkeypatch.setattr(_distances, "ENCODED_AT_ONCE", edge)
        for case, expected in zip(cases, one, strict=True):
            np.testing.assert_array_equal(motion_distances(*case, **parameters), expected)
            np.testing.assert_array_equal(motion_distances(*case, **parameters, n_jobs=2), expected)


@pytest.mark.parametrize("dtypes", [("f4", "f4"), ("f4", "f8")])
def test_float32_in_float32_out(dtypes):
    X, Y = ([m.astype(dtype) for m in motions([5, 9, 40], seed=seed)] for seed, dtype in enumerate(dtypes))
    D = motion_distances(X, Y, skeleton=TREE)
    assert D.dtype == np.result_type(*dtypes)
    exact = motion_distances([a.astype(float) for a in X], [b.astype(float) for b in Y], skeleton=TREE)
    np.testing.assert_allclose(D, exact, rtol=2e-5)
    assert motion_distances([*X, Y[0]], skeleton=TREE).dtype == np.result_type(*dtypes)


def test_auto_is_spatial_with_a_skeleton_and_angle_without():
    X = motions([4, 6])
    expected = motion_distances(X, skeleton=TREE, metric="spatial")
    np.testing.assert_array_equal(motion_distances(X, skeleton=TREE), expected)
    with pytest.warns(UserWarning, match='"auto" without a skeleton means "angle"'):
        D = motion_distances(X)
    np.testing.assert_array_equal(D, motion_distances(X, metric="angle"))
    np.testing.assert_array_equal(D, motion_distances(X, metric="angle", skeleton=TREE))


@pytest.mark.slow
def test_processes_give_the_same_to_the_last_bit(monkeypatch):
    sent = []

    def counted(function, shared, tasks, n_jobs):
        sent.append(len(tasks))
        return from_workers(function, shared, tasks, n_jobs)

    monkeypatch.setattr("skpose.metrics._matrix.from_workers", counted)
    monkeypatch.setattr("skpose.metrics._matrix.WORTH_SENDING", 0)
    monkeypatch.setattr(_distances, "ENCODED_AT_ONCE", 32)
    X, same = motions([12, 15, 9, 20, 15, 8, 14, 30, 11]), motions([6] * 7)
    cases = [(X, None, "dtw"), (X, [a[::-1] for a in X[:3]], "subsequence"), (same, None, "frames")]
    for one, other, alignment in cases:
        parameters = {"skeleton": TREE, "alignment": alignment}
        expected = motion_distances(one, other, **parameters)
        with joblib.parallel_config("loky", n_jobs=2):
            found = motion_distances(one, other, **parameters)
        np.testing.assert_array_equal(found, expected)
    assert min(sent) > 1
    assert len(sent) == len(cases)


def test_memory_is_that_of_some_frames():
    """No matrix of the distances between frames: 16 million of them would be 128 MB."""
    (long,) = motions([4000], CHAIN)
    motion_distances([long[:10]], [long[:10]], skeleton=CHAIN, metric="position")
    tracemalloc.start()
    motion_distances([long], [long[::-1]], skeleton=CHAIN, metric="position")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10e6


def test_out_gets_the_result(tmp_path):
    X = motions([12, 15, 9])
    out = np.lib.format.open_memmap(tmp_path / "D.npy", mode="w+", shape=(3, 3))
    assert motion_distances(X, skeleton=TREE, out=out) is out
    np.testing.assert_array_equal(out, motion_distances(X, skeleton=TREE))
