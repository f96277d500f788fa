"""The nearest motions: equal to brute force to the last bit, with few alignments."""

import pickle

import numpy as np
import pytest
from conftest import in_turns
from joblib import parallel_config
from sklearn.datasets import make_blobs
from sklearn.model_selection import GridSearchCV, LeaveOneGroupOut, cross_val_score
from sklearn.neighbors import KNeighborsClassifier
from sklearn.pipeline import make_pipeline

from skpose import MotionKNeighborsTransformer, Skeleton, motion_distances, pose_distances
from skpose._compiled.warping.paths import Paths
from skpose._parallel.backends import from_workers
from skpose.datasets import make_gait
from skpose.metrics import Spatial
from skpose.metrics._registry import METRICS, resolve
from skpose.motions._bounds import CLOSED, Bounds
from skpose.motions._index import FRAMES_PER_BOX, SequenceIndex
from skpose.motions._inputs import Sequences
from skpose.motions._search import FIRST_MOTIONS, Aligner

ARM = Skeleton.chain(3)


@pytest.fixture(autouse=True)
def searched(monkeypatch):
    """Search also where brute force takes less time."""
    monkeypatch.setattr("skpose.motions._queries.WORTH_FILTERING", 0.0)
    monkeypatch.setattr("skpose.motions._queries.FEWEST_PER_NEIGHBOR", 1)


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


@pytest.mark.parametrize(("metric", "window"), in_turns(sorted(METRICS.keys() - {"geodesic"}), [None, 0.0, 0.1, 1.0]))
def test_equals_brute_force_to_the_last_bit(metric, window):
    motions, queries = smooth_motions(2 * FIRST_MOTIONS, 40, seed=0), smooth_motions(9, 40, seed=1)
    queries += motions[:3]
    search = MotionKNeighborsTransformer(ARM, metric=metric, window=window).fit(motions)
    for k in (1, 5, len(motions)):
        assert_equals_brute_force(search, queries, motions, k, skeleton=ARM, metric=metric, window=window)


def test_geodesics_equal_brute_force():
    motions, queries = smooth_motions(FIRST_MOTIONS + 9, 3, seed=2), smooth_motions(3, 3, seed=3)
    search = MotionKNeighborsTransformer(ARM, metric="geodesic").fit(motions)
    for k in (1, 3):
        assert_equals_brute_force(search, queries, motions, k, skeleton=ARM, metric="geodesic")
    evaluations = search.kneighbors(queries, 1, return_evaluations=True)[2]
    assert evaluations.cells < 0.3 * sum(map(len, queries)) * sum(map(len, motions))


@pytest.mark.parametrize("k", [1, 4])
def test_a_training_motion_is_not_its_own_neighbor(k):
    motions = smooth_motions(70, 20, seed=4)
    motions[5] = motions[3].copy()
    search = MotionKNeighborsTransformer(ARM).fit(motions)
    distances, indices = search.kneighbors(n_neighbors=k)
    expected = by_brute_force(motions, [motion.copy() for motion in motions], k, skeleton=ARM, excludes_itself=True)
    np.testing.assert_array_equal(indices, expected[1])
    np.testing.assert_array_equal(distances, expected[0])
    assert distances[3, 0] == 0.0
    assert indices[3, 0] == 5


def test_equal_distances_are_ordered_by_index():
    motions = [motion for motion in smooth_motions(30, 10, seed=5) for _ in range(3)]
    search = MotionKNeighborsTransformer(ARM).fit(motions)
    for k in (1, 2, 4, 80):
        assert_equals_brute_force(search, motions[:9], motions, k, skeleton=ARM)


@pytest.mark.parametrize(
    "motions",
    [
        [np.zeros((1, 3))],
        [np.zeros((4, 3))] * 5,
        [np.full((3, 3), 1e9), np.zeros((2, 3))],
        [np.array([[2.0 * np.pi, 0.0, 0.0]]), np.array([[0.0, 0.0, 1e-9]])],  # a whole turn is the same pose
    ],
)
@pytest.mark.filterwarnings("ignore:values of .* but angles are in rad:UserWarning")
@pytest.mark.parametrize("metric", ["spatial", "position", "angle"])
def test_few_motions_equal_and_large_numbers(motions, metric):
    queries = [np.zeros((1, 3)), np.zeros((3, 3)), motions[-1] + 0.1]
    search = MotionKNeighborsTransformer(ARM, metric=metric).fit(motions)
    assert_equals_brute_force(search, queries, motions, len(motions), skeleton=ARM, metric=metric)


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


def test_most_motions_are_not_aligned():
    motions = smooth_motions(400, 30, seed=7, centres=40)
    search = MotionKNeighborsTransformer(ARM).fit(motions)
    _, _, evaluations = search.kneighbors(n_neighbors=1, return_evaluations=True)
    assert evaluations.alignments <= 4 * len(motions)
    n_frames = sum(map(len, motions))
    assert evaluations.cells < 0.01 * n_frames**2
    brute = MotionKNeighborsTransformer(ARM, algorithm="brute").fit(motions[:20])
    n_frames = sum(map(len, motions[:20]))
    assert brute.kneighbors(motions[:2], 1, return_evaluations=True)[2] == (40, sum(map(len, motions[:2])) * n_frames)


@pytest.mark.parametrize("metric", ["position", "spatial", "angle"])
@pytest.mark.parametrize("window", [1.0, 0.1])
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


@pytest.mark.parametrize("metric", ["position", "spatial", "geodesic"])
@pytest.mark.parametrize("scale", [1e-2, 1.0, 1e2])
def test_bounds_of_frames_and_boxes_hold_cell_by_cell(metric, scale):
    """Poses that lie far from each other and near themselves: rounding in float32 is larger than many distances."""
    bones = [(bone.name, bone.parent, scale * np.array(bone.offset), bone.dofs) for bone in ARM.bones]
    arm, rng = Skeleton(bones), np.random.default_rng(0)
    motions = [np.concatenate([one, one + 1e-7 * rng.normal(size=one.shape)]) for one in smooth_motions(4, 4, seed=16)]
    query = motions[0] + 1e-6
    index = SequenceIndex(Sequences.of(motions), arm, resolve(metric, arm))
    bounds, frames = Bounds(index, query), index.sequences.poses
    distances = pose_distances(query, frames, skeleton=arm, metric=metric)
    size = scale * 1e-9
    assert (bounds.of_frames(0, len(frames)) <= distances + size).all()
    by_boxes = bounds.of_boxes(0, len(index.boxes))
    for i in range(len(motions)):
        for k, box in enumerate(range(index.box_starts[i], index.box_starts[i + 1])):
            start = index.sequences.starts[i] + FRAMES_PER_BOX * k
            stop = min(start + FRAMES_PER_BOX, index.sequences.starts[i + 1])
            assert (by_boxes[:, box, None] <= distances[:, start:stop] + size).all()


def test_bounds_are_tight_on_motions_of_people():
    gait = make_gait(n_subjects=3, n_sequences=1, duration=2, frame_rate=24, random_state=0)
    motions = [motion.angles for motion in gait]
    index = SequenceIndex(Sequences.of(motions), gait.skeleton, Spatial())
    sums = motion_distances(gait, normalize=False)
    for query, expected in zip(motions, sums, strict=True):
        bounds = Bounds(index, query)
        assert bounds.frames(np.arange(len(motions)), CLOSED).sum() > 0.9 * expected.sum()
        assert bounds.boxes(np.arange(len(motions))).sum() > 0.3 * expected.sum()


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
                assert aligner.evaluations.alignments == len(row)


def test_brute_force_where_it_takes_less_time(monkeypatch):
    motions = smooth_motions(60, 9, seed=15)
    search = MotionKNeighborsTransformer(ARM).fit(motions)
    searched = search.kneighbors(n_neighbors=2, return_evaluations=True)
    monkeypatch.setattr("skpose.motions._queries.WORTH_FILTERING", np.inf)
    computed = search.kneighbors(n_neighbors=2, return_evaluations=True)
    for found, expected in zip(searched[:2], computed[:2], strict=True):
        np.testing.assert_array_equal(found, expected)
    assert searched[2].alignments < computed[2].alignments == 60 * 60


def test_the_number_of_threads_changes_nothing():
    motions = smooth_motions(90, 20, seed=12)
    results = [MotionKNeighborsTransformer(ARM, n_jobs=n_jobs).fit(motions).kneighbors() for n_jobs in (1, 2, 5)]
    for distances, indices in results[1:]:
        np.testing.assert_array_equal(distances, results[0][0])
        np.testing.assert_array_equal(indices, results[0][1])


@pytest.mark.slow
def test_processes_find_the_same(monkeypatch):
    sent = []

    def counted(function, shared, tasks, n_jobs):
        sent.append(len(tasks))
        return from_workers(function, shared, tasks, n_jobs)

    monkeypatch.setattr("skpose.motions._queries.from_workers", counted)
    monkeypatch.setattr("skpose.motions._queries.WORTH_SENDING", 0)
    motions = smooth_motions(40, 12, seed=13)
    search = MotionKNeighborsTransformer(ARM).fit(motions)
    here = search.kneighbors()
    with parallel_config("loky", n_jobs=2):
        there = search.kneighbors()
    (n_tasks,) = sent  # once, in many tasks
    assert n_tasks > 1
    np.testing.assert_array_equal(here[0], there[0])
    np.testing.assert_array_equal(here[1], there[1])


def test_graph():
    motions = smooth_motions(20, 8, seed=14)
    search = MotionKNeighborsTransformer(ARM, n_neighbors=3).fit(motions)
    graph = search.transform(motions[:6])
    assert graph.shape == (6, 20)
    distances, indices = search.kneighbors(motions[:6], 4)  # itself too
    np.testing.assert_array_equal(graph.indices.reshape(6, 4), indices)
    np.testing.assert_array_equal(graph.data.reshape(6, 4), distances)
    ones = search.set_params(mode="connectivity").transform(motions[:6])
    assert ones.nnz == 18
    assert set(ones.data) == {1.0}
    again = pickle.loads(pickle.dumps(search))
    np.testing.assert_array_equal(again.kneighbors(motions[:2])[0], search.kneighbors(motions[:2])[0])
    with pytest.raises(ValueError, match="n_neighbors = 21, n_samples_fit = 20"):
        search.kneighbors(motions[:2], 21)
    with pytest.raises(ValueError, match="n_neighbors = 20, n_samples_fit = 20"):
        search.kneighbors(n_neighbors=20)
    with pytest.raises(ValueError, match="mode must be"):
        search.kneighbors_graph(mode="distances")


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


@pytest.mark.slow
def test_hdm05_with_a_few_alignments(hdm05):
    """Of other people: at most 4 alignments for k = 1 and 10 for k = 5, of some 125 (DESIGN, section 6)."""
    dataset = hdm05.to_rotvec()
    X, sequence = dataset.poses(12)
    motions = [X[sequence == i] for i in range(len(dataset))]
    aligned = {1: 0, 5: 0}
    for person in np.unique(dataset.subjects):
        there = np.flatnonzero(dataset.subjects == person)
        others = np.flatnonzero(dataset.subjects != person)
        search = MotionKNeighborsTransformer(dataset.skeleton).fit([motions[i] for i in others])
        for k in aligned:
            aligned[k] += search.kneighbors([motions[i] for i in there], k, return_evaluations=True)[2].alignments
        some = [motions[i] for i in there[:3]]
        assert_equals_brute_force(search, some, [motions[i] for i in others], 5, skeleton=dataset.skeleton)
    assert aligned[1] <= 4 * len(motions)
    assert aligned[5] <= 10 * len(motions)
