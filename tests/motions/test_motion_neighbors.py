"""The nearest motions: bit for bit those of brute force, with few alignments."""

import numpy as np
import pytest
from conftest import in_turns
from sklearn.datasets import make_blobs
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import Skeleton, motion_distances
from skpose._compiled.warping.paths import Paths
from skpose.datasets import make_gait
from skpose.metrics import Spatial
from skpose.metrics._registry import METRICS, resolve
from skpose.motions import MotionKNeighborsTransformer
from skpose.motions._inputs import Sequences
from skpose.motions._search import CLOSED, FIRST_MOTIONS, Aligner, Bounds, MotionSearch, SequenceIndex

ARM = Skeleton.chain(3)


@pytest.fixture(autouse=True)
def searched(monkeypatch):
    """Search also where brute force takes less time."""
    monkeypatch.setattr("skpose.motions._search.WORTH_FILTERING", 0.0)
    monkeypatch.setattr("skpose.motions._search.FEWEST_PER_NEIGHBOR", 1)


def smooth_motions(n_motions, longest, seed, centres=4):
    """Random walks around a few poses, of one frame to `longest`."""
    rng = np.random.default_rng(seed)
    middle = make_blobs(n_motions, 3, centers=centres, cluster_std=0.3, random_state=seed)[0] / 5.0
    return [pose + np.cumsum(rng.normal(size=(rng.integers(1, longest + 1), 3)) * 0.1, axis=0) for pose in middle]


def by_brute_force(queries, motions, k, excludes_itself=False, **parameters):
    """Indices and distances of the k nearest, by distance and then by index."""
    D = motion_distances(queries, motions, **parameters)
    if excludes_itself:
        np.fill_diagonal(D, np.inf)
    order = D.argsort(axis=1, kind="stable")[:, :k]
    return np.take_along_axis(D, order, axis=1), order


def assert_equals_brute_force(search, queries, motions, k, **parameters):
    distances, indices = by_brute_force(queries, motions, k, **parameters)
    found = search.kneighbors(queries, k)
    np.testing.assert_array_equal(found[1], indices)
    np.testing.assert_array_equal(found[0], distances)


@pytest.mark.parametrize(("metric", "window"), in_turns(sorted(METRICS.keys() - {"geodesic"}), [None, 0.1]))
def test_equals_brute_force_to_the_last_bit(metric, window):
    motions, queries = smooth_motions(2 * FIRST_MOTIONS, 40, seed=0), smooth_motions(9, 40, seed=1)
    queries += motions[:3]
    search = MotionKNeighborsTransformer(ARM, metric=metric, window=window).fit(motions)
    for k in (1, 5, len(motions)):
        assert_equals_brute_force(search, queries, motions, k, skeleton=ARM, metric=metric, window=window)


def test_a_training_motion_is_not_its_own_neighbor():
    k = 4
    motions = smooth_motions(70, 20, seed=4)
    motions[5] = motions[3].copy()
    search = MotionKNeighborsTransformer(ARM).fit(motions)
    distances, indices = search.kneighbors(n_neighbors=k)
    expected = by_brute_force(motions, [motion.copy() for motion in motions], k, skeleton=ARM, excludes_itself=True)
    np.testing.assert_array_equal(indices, expected[1])
    np.testing.assert_array_equal(distances, expected[0])
    assert distances[3, 0] == 0.0
    assert indices[3, 0] == 5


def test_float32_motions_are_measured_in_float64():
    motions = [motion.astype(np.float32) for motion in smooth_motions(60, 9, seed=6)]
    wide = [motion.astype(np.float64) for motion in motions]
    for algorithm in ("auto", "brute"):
        search = MotionKNeighborsTransformer(ARM, algorithm=algorithm).fit(motions)
        distances, indices = search.kneighbors(motions[:5], 3)
        assert distances.dtype == np.float64
        expected = by_brute_force(wide[:5], wide, 3, skeleton=ARM)
        np.testing.assert_array_equal(indices, expected[1])
        np.testing.assert_array_equal(distances, expected[0])


def test_few_cells_are_measured():
    motions = smooth_motions(400, 30, seed=7, centres=40)
    search = MotionSearch(SequenceIndex(Sequences.of(motions), ARM, Spatial()), None)
    for i in range(0, 400, 20):
        search.nearest(motions[i], i, 1)
    n_frames = sum(map(len, motions))
    assert search.aligner.n_cells < 0.01 * sum(map(len, motions[::20])) * n_frames


@pytest.mark.parametrize(("metric", "window"), [("position", 0.1), ("spatial", 1.0), ("angle", 0.1)])
def test_every_bound_is_a_lower_bound(metric, window):
    motions, queries = smooth_motions(40, 40, seed=8), smooth_motions(6, 40, seed=9)
    index = SequenceIndex(Sequences.of(motions), ARM, resolve(metric, ARM))
    sums = motion_distances(queries, motions, skeleton=ARM, metric=metric, window=window, normalize=False)
    everything = np.arange(len(motions))
    closed = motion_distances(queries, motions, skeleton=ARM, metric=metric, normalize=False)
    for query, expected, unbounded in zip(queries, sums, closed, strict=True):
        bounds = Bounds(index, query)
        by_ends, by_boxes = bounds.ends(), bounds.boxes(everything)
        by_frames = bounds.frames(everything, Paths(window, False))
        assert (by_ends <= unbounded * (1 + 1e-9) + 1e-12).all()
        assert (by_boxes <= bounds.frames(everything, CLOSED) * (1 + 1e-9) + 1e-4).all()
        assert (by_boxes <= unbounded * (1 + 1e-9) + 1e-12).all()
        assert (by_frames <= expected * (1 + 1e-9) + 1e-12).all()


@pytest.mark.parametrize("window", [1.0, 0.1])
def test_an_alignment_up_to_a_limit_is_exact_or_infinite(window):
    motions, queries = smooth_motions(20, 60, seed=10), smooth_motions(4, 60, seed=11)
    index = SequenceIndex(Sequences.of(motions), ARM, Spatial())
    sums = motion_distances(queries, motions, skeleton=ARM, window=window, normalize=False)
    for query, row in zip(queries, sums, strict=True):
        bounds = Bounds(index, query)
        for with_bounds in (bounds, None):
            for factor in (0.5, 0.999, 1.0, 1.5):
                aligner = Aligner(index, Paths(window, False))
                codes = aligner.encode(query)
                for i, expected in enumerate(row):
                    start, stop = index.sequences.starts[i : i + 2]
                    found, _ = aligner.ends(codes, start, stop, with_bounds, factor * expected)
                    assert found[-1] == (expected if factor >= 1.0 else np.inf)


def test_actions_of_other_people():
    gait = make_gait(n_subjects=3, n_sequences=2, duration=1.5, frame_rate=12, random_state=0)
    knn = make_pipeline(MotionKNeighborsTransformer(n_neighbors=1), KNeighborsClassifier(1, metric="precomputed"))
    scores = cross_val_score(knn, list(gait), gait.actions, groups=gait.subjects, cv=LeaveOneGroupOut())
    assert (scores == 1.0).all()
    grid = {
        "motionkneighborstransformer__metric": ["position", "spatial"],
        "motionkneighborstransformer__window": [0.2],
    }
    search = GridSearchCV(knn, grid, cv=LeaveOneGroupOut()).fit(list(gait), gait.actions, groups=gait.subjects)
    assert search.best_score_ == 1.0


def test_geodesics_equal_brute_force():
    motions, queries = smooth_motions(20, 3, seed=2), smooth_motions(2, 3, seed=3)
    search = MotionKNeighborsTransformer(ARM, metric="geodesic").fit(motions)
    assert_equals_brute_force(search, queries, motions, 2, skeleton=ARM, metric="geodesic")


def test_graph():
    motions = smooth_motions(20, 8, seed=14)
    search = MotionKNeighborsTransformer(ARM, n_neighbors=3, n_jobs=2).fit(motions)
    graph = search.transform(motions[:6])
    assert graph.shape == (6, 20)
    distances, indices = search.kneighbors(motions[:6], 4)  # with the motion itself
    np.testing.assert_array_equal(graph.indices.reshape(6, 4), indices)
    np.testing.assert_array_equal(graph.data.reshape(6, 4), distances)
    assert search.set_params(mode="connectivity").transform(motions[:6]).nnz == 18
    with pytest.raises(ValueError, match="n_neighbors"):
        search.kneighbors(motions[:2], 21)
