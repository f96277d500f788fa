"""Distances between motions: the definition, at all lengths and tilings, and what must change nothing."""

import tracemalloc
from contextlib import contextmanager, nullcontext
from itertools import pairwise

import joblib
import numpy as np
import pytest
import reference
from conftest import SKELETONS, in_turns, random_tree
from sklearn.exceptions import ConvergenceWarning

from skpose import Skeleton, motion_distances, pose_distances
from skpose._compiled.warping.paths import Paths, accumulate
from skpose._parallel.backends import from_workers
from skpose._parallel.progress import report_to
from skpose.metrics import Geodesic, Spatial
from skpose.metrics._convergence import Unconverged
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._registry import METRICS
from skpose.motions import _matrix
from skpose.motions._inputs import Sequences
from skpose.motions._matrix import MotionMatrix, motion_pairs

HUMANOID, TREE, CHAIN = SKELETONS["humanoid"], random_tree(0), Skeleton.chain(2)
WITH_FORMULA = [name for name in METRICS if name != "geodesic"]
ALIGNMENTS = ["dtw", "subsequence", "frames"]
WINDOWS = [0.0, 0.04, 0.5, 1.0, None]


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


@pytest.mark.parametrize("alignment", ALIGNMENTS)
@pytest.mark.parametrize("metric", METRICS)
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


@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("n_frames", [1, 2, 3, 8, 17, 127, 128, 129, 255, 256, 300])
def test_all_lengths(n_frames, dtype, window):
    """Columns that fill groups of lanes and blocks of them or do not, at any place among other motions."""
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


@pytest.mark.parametrize(("shape", "window"), in_turns([(300, 129), (129, 300), (127, 128), (257, 256)], WINDOWS))
def test_long_motions_in_a_band(shape, window):
    X, Y = motions(shape[:1], CHAIN), motions(shape[1:], CHAIN, seed=1)
    D = motion_distances(X, Y, skeleton=CHAIN, window=window)
    np.testing.assert_allclose(D, plain(X, Y, CHAIN, "spatial", window), rtol=1e-12)


@pytest.mark.parametrize("n_frames", [1, 127, 128, 129, 300])
def test_a_subsequence_in_several_blocks(n_frames):
    X, Y = motions([1, 20, 150], CHAIN), motions([3, n_frames, 300], CHAIN, seed=1)
    D = motion_distances(X, Y, skeleton=CHAIN, alignment="subsequence")
    np.testing.assert_allclose(D, plain(X, Y, CHAIN, "spatial", alignment="subsequence"), rtol=1e-12)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("metric", METRICS)
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


def test_equal_motions_are_at_distance_zero_between_two_lists():
    X = motions([3, 20, 40])
    for alignment in ("dtw", "subsequence"):
        D = motion_distances(X, [a.copy() for a in X], skeleton=TREE, alignment=alignment)
        np.testing.assert_array_equal(np.diag(D), 0)


def test_a_subsequence_is_found_where_it_is():
    (whole,) = motions([60])
    D = motion_distances([whole[20:45], whole], skeleton=TREE, alignment="subsequence")
    assert D[0, 1] == 0
    assert D[1, 0] > 0
    assert motion_distances([whole[20:45]], [whole], skeleton=TREE)[0, 0] > 0


def test_a_slower_motion_is_nearer_than_without_warping():
    (walk,) = motions([50])
    slow = np.repeat(walk, 3, axis=0)
    assert motion_distances([walk], [slow], skeleton=TREE)[0, 0] == 0
    assert motion_distances([slow], [np.repeat(walk, 3, axis=0)[::-1]], skeleton=TREE)[0, 0] > 0


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


def test_position_is_never_more_than_geodesic_nor_that_than_spatial():
    X = motions([3, 4, 2], CHAIN, scale=0.5)
    position, geodesic, spatial = (
        motion_distances(X, skeleton=CHAIN, metric=metric) for metric in ("position", "geodesic", "spatial")
    )
    assert (position <= geodesic).all()
    assert (geodesic <= spatial * (1 + 1e-9)).all()


@pytest.mark.parametrize("alignment", ["dtw", "subsequence"])
def test_the_order_of_motions_and_of_rows_changes_nothing(alignment):
    X, Y = motions([9, 130, 30, 12, 17]), motions([200, 3, 30], seed=1)
    parameters = {"skeleton": TREE, "alignment": alignment}
    D = motion_distances(X, Y, **parameters)
    order, other = [3, 0, 4, 2, 1], [2, 0, 1]
    D_in_order = motion_distances([X[i] for i in order], [Y[j] for j in other], **parameters)
    np.testing.assert_array_equal(D_in_order, D[np.ix_(order, other)])
    np.testing.assert_array_equal(motion_distances(X[1:2], Y[:1], **parameters), D[1:2, :1])
    if alignment == "dtw":
        S = motion_distances(X, **parameters)
        S_in_order = motion_distances([X[i] for i in order], **parameters)
        np.testing.assert_allclose(S_in_order, S[np.ix_(order, order)], rtol=1e-12)


def test_both_directions_of_time_have_one_distance():
    X, Y = motions([9, 30, 17]), motions([12, 33], seed=1)
    for window in (None, 0.2):
        forward = motion_distances(X, Y, skeleton=TREE, window=window)
        backward = motion_distances([a[::-1] for a in X], [b[::-1] for b in Y], skeleton=TREE, window=window)
        np.testing.assert_allclose(forward, backward, rtol=1e-12)


@pytest.mark.parametrize(("metric", "alignment"), in_turns(list(METRICS), ALIGNMENTS))
def test_the_number_of_threads_and_of_tasks_changes_nothing(metric, alignment, monkeypatch):
    skeleton, lengths = for_geodesics(metric)
    X = motions([4] * 5 if alignment == "frames" else lengths, skeleton)
    cases = [(X, None), (X, [a + 0.1 for a in X[:3]])]
    parameters = {"skeleton": skeleton, "metric": metric, "alignment": alignment}
    one = [motion_distances(*case, **parameters) for case in cases]
    monkeypatch.setattr(_matrix, "WORK_PER_TASK", 1.0)  # a task for every pair
    monkeypatch.setattr(_matrix, "LITTLE_WORK", 1.0)
    monkeypatch.setattr("skpose.metrics._matrix.WORK_PER_TASK", 1.0)
    for edge in (1, 4, 2**20):  # tiles of few motions, and of all
        monkeypatch.setattr(_matrix, "ENCODED_AT_ONCE", edge)
        for case, expected in zip(cases, one, strict=True):
            np.testing.assert_array_equal(motion_distances(*case, **parameters), expected)
            np.testing.assert_array_equal(motion_distances(*case, **parameters, n_jobs=2), expected)
            with joblib.parallel_config(n_jobs=3):
                np.testing.assert_array_equal(motion_distances(*case, **parameters), expected)


@pytest.mark.parametrize("most_cells", [1, 50, 400, 10**9])
@pytest.mark.parametrize("triangle", [True, False])
def test_tasks_are_all_pairs_once(triangle, most_cells):
    n = np.array([9, 1, 30, 12, 1, 17])
    m = n if triangle else np.array([3, 40, 1])
    found = np.zeros((len(n), len(m)), dtype=int)
    for pairs in motion_pairs(n, m, triangle, most_cells):
        part = found[pairs.first : pairs.last, pairs.left : pairs.right]
        part += np.arange(pairs.left, pairs.right) > np.arange(pairs.first, pairs.last)[:, None] if triangle else 1
        if part.size > 1 and pairs.last - pairs.first > 1 and pairs.right - pairs.left > 1:
            cells = n[pairs.first : pairs.last].sum() * m[pairs.left : pairs.right].sum()
            assert cells <= most_cells
    np.testing.assert_array_equal(found, np.triu(np.ones_like(found), 1) if triangle else 1)


@pytest.mark.parametrize("dtypes", [("f4", "f4"), ("f4", "f8"), ("f8", "f4")])
def test_float32_in_float32_out(dtypes):
    X, Y = ([m.astype(dtype) for m in motions([5, 9, 40], seed=seed)] for seed, dtype in enumerate(dtypes))
    D = motion_distances(X, Y, skeleton=TREE)
    assert D.dtype == np.result_type(*dtypes)
    exact = motion_distances([a.astype(float) for a in X], [b.astype(float) for b in Y], skeleton=TREE)
    np.testing.assert_allclose(D, exact, rtol=2e-5)
    assert motion_distances([*X, Y[0]], skeleton=TREE).dtype == np.result_type(*dtypes)


def test_metric_parameters_arrive():
    turn = 2 * np.pi * np.ones((1, TREE.n_dofs))
    X = motions([4, 6])
    a, b = [X[0]], [X[1] + turn]
    wrapped = motion_distances(a, b, skeleton=TREE)
    np.testing.assert_allclose(wrapped, motion_distances(X[:1], X[1:], skeleton=TREE), rtol=1e-9)
    assert (motion_distances(a, b, skeleton=TREE, metric=Spatial(wrap=False)) > 2 * wrapped).all()
    coarse = motion_distances(X[:1], [X[1] + 1.0], skeleton=TREE, metric=Spatial(1))
    np.testing.assert_allclose(coarse, motion_distances(X[:1], [X[1] + 1.0], skeleton=TREE, metric="position"))
    assert (coarse < motion_distances(X[:1], [X[1] + 1.0], skeleton=TREE)).all()


def test_auto_is_spatial_with_a_skeleton_and_angle_without():
    X = motions([4, 6])
    expected = motion_distances(X, skeleton=TREE, metric="spatial")
    np.testing.assert_array_equal(motion_distances(X, skeleton=TREE), expected)
    with pytest.warns(UserWarning, match='"auto" without a skeleton means "angle"'):
        D = motion_distances(X)
    np.testing.assert_array_equal(D, motion_distances(X, metric="angle"))
    np.testing.assert_array_equal(D, motion_distances(X, metric="angle", skeleton=TREE))


@pytest.mark.parametrize("alignment", ALIGNMENTS)
def test_unconverged_geodesics_are_counted_once_and_warned_of(alignment, monkeypatch):
    X = motions([3, 3, 3], CHAIN)
    n_cells = {"frames": 9, "dtw": 27, "subsequence": 81}[alignment]  # of one triangle where it is symmetric
    compute = MotionMatrix.distances
    monkeypatch.setattr(MotionMatrix, "distances", lambda *args: (compute(*args)[0], Unconverged(2, 0.25)))
    with pytest.warns(ConvergenceWarning, match=f"2 of {n_cells} geodesics did not converge.* is 0.25"):
        motion_distances(X, skeleton=CHAIN, metric="geodesic", alignment=alignment)


@pytest.mark.parametrize("window", [None, 0.4])
def test_as_many_geodesics_did_not_converge_as_there_are_such_pairs_of_frames(window):
    """Those of pairs of frames that are requested, and not of what else is in their group of lanes."""
    skeleton, rng, metric = SKELETONS["ball joints"], np.random.default_rng(0), Geodesic(2)
    a, b = (rng.uniform(-3, 3, size=(n, skeleton.n_dofs)) for n in (3, 4))

    def unconverged(matrix):
        return Unconverged.join(matrix.write(None, 1)[1])

    pairs = [(i, j) for i in range(3) for j in range(4) if window is None or abs(i / 2 - j / 3) <= window]
    each = [unconverged(DistanceMatrix(a[[i]], b[[j]], metric, skeleton)) for i, j in pairs]
    expected = Unconverged.join(each)
    assert expected.count > 0
    matrix = MotionMatrix(Sequences.of([a]), Sequences.of([b, b]), metric, skeleton, window=window)
    assert unconverged(matrix) == (2 * expected.count, expected.gap)


class Stop(BaseException):
    """An interruption like Ctrl-C."""


def stopped_after(n_tiles):
    """Let so many tiles be written, and no more."""

    @contextmanager
    def reporter(_, n_steps):
        done = []

        def advance():
            done.append(1)
            if len(done) == n_tiles:
                raise Stop

        assert n_steps > n_tiles
        yield advance

    return report_to(reporter)


@pytest.fixture
def two_motions_a_tile(monkeypatch):
    monkeypatch.setattr(_matrix, "ENCODED_AT_ONCE", 32)


@pytest.mark.parametrize(
    ("alignment", "triangle"), [("dtw", True), ("dtw", False), ("subsequence", True), ("frames", True)]
)
def test_the_same_call_continues_where_it_stopped(tmp_path, alignment, triangle, two_motions_a_tile, monkeypatch):
    X = motions([15] * 9 if alignment == "frames" else [12, 15, 9, 20, 15, 8, 14, 30, 11])
    Y = None if triangle else motions([9, 12, 20, 15], seed=1)
    parameters = {"skeleton": TREE, "alignment": alignment}
    expected = motion_distances(X, Y, **parameters)
    path = tmp_path / "D.npy"
    out = np.lib.format.open_memmap(path, mode="w+", shape=expected.shape)
    with stopped_after(3), pytest.raises(Stop):
        motion_distances(X, Y, out=out, **parameters)
    assert not np.array_equal(out, expected)
    del out
    tiles, compute = [], MotionMatrix.distances

    def counted(matrix, tile, *args):
        tiles.append(tile)
        return compute(matrix, tile, *args)

    monkeypatch.setattr(MotionMatrix, "distances", counted)
    out = np.lib.format.open_memmap(path, mode="r+")
    assert motion_distances(X, Y, out=out, **parameters) is out
    np.testing.assert_array_equal(out, expected)
    rows, columns = -(-len(X) // 2), -(-expected.shape[1] // 2)
    symmetric = triangle and alignment != "subsequence"
    assert len(tiles) == (rows * (rows + 1) // 2 if symmetric else rows * columns) - 3
    assert [file.name for file in tmp_path.iterdir()] == ["D.npy"]


@pytest.mark.parametrize(
    ("other", "name"),
    [
        ({"metric": "position"}, "metric or parameters of it"),
        ({"alignment": "subsequence"}, "alignment, window or normalize"),
        ({"window": 0.3}, "alignment, window or normalize"),
        ({"normalize": False}, "alignment, window or normalize"),
        ({"skeleton": random_tree(1)}, "skeleton"),
        ({"X": motions([12] * 9, seed=1)}, "X"),
        ({"X": [motions([12 * 9])[0][9 * i : 9 * i + 9] for i in range(12)][:9]}, "X"),
        ({"Y": motions([12] * 9)}, "Y"),
    ],
    ids=lambda value: "+".join(value) if isinstance(value, dict) else "",
)
def test_other_distances_are_not_mixed_in(tmp_path, other, name, two_motions_a_tile):
    call = {"X": motions([12] * 9), "skeleton": TREE}
    out = np.lib.format.open_memmap(tmp_path / "D.npy", mode="w+", shape=(9, 9))
    with stopped_after(3), pytest.raises(Stop):
        motion_distances(**call, out=out)
    with pytest.raises(ValueError, match=f"the beginning of other distances, with another {name}: finish those with"):
        motion_distances(**call | other, out=out)


def test_an_out_that_does_not_fit_is_refused():
    for wrong in (np.zeros((2, 3)), np.zeros((2, 2), np.float32), [0.0]):
        with pytest.raises(ValueError, match=r"out must be a writeable float64 array of shape \(2, 2\), got"):
            motion_distances(motions([3, 4]), skeleton=TREE, out=wrong)


@contextmanager
def dask_cluster():
    from dask.distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster,
        Client(cluster),
    ):
        yield


@pytest.mark.parametrize(
    "backend", [pytest.param(name, marks=pytest.mark.slow) for name in ("loky", "multiprocessing", "dask")]
)
def test_backends_give_the_same_to_the_last_bit(backend, monkeypatch):
    sent = []

    def counted(function, shared, tasks, n_jobs):
        sent.append(len(tasks))
        return from_workers(function, shared, tasks, n_jobs)

    monkeypatch.setattr("skpose.metrics._tiled.from_workers", counted)
    monkeypatch.setattr("skpose.metrics._tiled.WORTH_SENDING", 0)
    monkeypatch.setattr(_matrix, "ENCODED_AT_ONCE", 32)
    X, same = motions([12, 15, 9, 20, 15, 8, 14, 30, 11]), motions([6] * 7)
    cases = [(X, None, "dtw"), (X, [a[::-1] for a in X[:3]], "subsequence"), (same, None, "frames")]
    with dask_cluster() if backend == "dask" else nullcontext():
        for one, other, alignment in cases:
            parameters = {"skeleton": TREE, "alignment": alignment}
            expected = motion_distances(one, other, **parameters)
            with joblib.parallel_config(backend=backend, n_jobs=None if backend == "dask" else 2):
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
