"""The best windows of long motions: equal to brute force."""

import numpy as np
import pytest
from conftest import in_turns

from skpose import Motion, Skeleton, pose_distances
from skpose.datasets import MotionDataset, make_gait
from skpose.metrics import Spatial
from skpose.metrics._registry import METRICS
from skpose.motions import MotionIndex, MotionMatch, find_motion
from skpose.motions._inputs import Sequences
from skpose.motions._search import SequenceIndex, WindowSearch

ARM = Skeleton.chain(3)


@pytest.fixture(autouse=True)
def searched(monkeypatch):
    """Search also where brute force takes less time."""
    monkeypatch.setattr("skpose.motions._search.WORK_PER_WINDOW", 0.0)


def wander(n_frames, rng):
    return np.cumsum(rng.normal(size=(n_frames, 3)) * 0.2, axis=0) + rng.normal(size=3) * 0.5


@pytest.fixture(scope="module")
def recordings():
    rng = np.random.default_rng(0)
    return [wander(n, rng) for n in (300, 1, 7, 120, 9, 41, 260)]


def best_windows(query, motions, k, **parameters):
    """All frames of all motions as ends, then the best, then the best of the others: brute force, frame by frame."""
    windows = []
    for number, motion in enumerate(motions):
        D = pose_distances(query, motion, **parameters)
        sums, begins = D.copy(), np.tile(np.arange(len(motion)), (len(query), 1))
        for i in range(1, len(query)):
            for j in range(len(motion)):
                before = [(i - 1, j - 1), (i - 1, j), (i, j - 1)] if j else [(i - 1, j)]
                best = min(before, key=lambda cell: sums[cell])  # the first of equal ones
                sums[i, j], begins[i, j] = D[i, j] + sums[best], begins[best]
        windows += [
            MotionMatch(number, int(begins[-1, e]), e + 1, float(sums[-1, e] / len(query))) for e in range(len(motion))
        ]
    chosen = []
    for window in sorted(windows, key=lambda w: (w.distance, w.motion, w.stop)):
        frames = set(range(window.start, window.stop))
        others = [set(range(w.start, w.stop)) for w in chosen if w.motion == window.motion]
        if all(2 * len(frames & other) <= min(len(frames), len(other)) for other in others):
            chosen.append(window)
    return chosen[:k]


@pytest.mark.parametrize(("metric", "n_frames"), in_turns(sorted(METRICS.keys() - {"geodesic"}), [1, 5, 30]))
def test_equals_brute_force(recordings, metric, n_frames):
    rng = np.random.default_rng(n_frames)
    for query in (wander(n_frames, rng), recordings[0][100 : 100 + n_frames], recordings[3][40 : 40 + n_frames] + 0.01):
        expected = best_windows(query, recordings, 30, skeleton=ARM, metric=metric)
        index = MotionIndex(recordings, skeleton=ARM, metric=metric)
        for k in (1, 30):
            assert find_motion(query, index, k=k) == expected[:k]


def test_equal_windows_come_in_their_order():
    rng = np.random.default_rng(1)
    piece, rest = wander(20, rng), np.zeros((30, 3))
    recording = np.concatenate([rest, piece, rest, piece, rest])
    found = find_motion(piece, [recording, recording], k=4, skeleton=ARM)
    assert [(m.motion, m.start, m.stop) for m in found] == [(0, 30, 50), (0, 80, 100), (1, 30, 50), (1, 80, 100)]
    assert [m.distance for m in found] == [0.0] * 4


def test_long_recordings_are_scanned_in_parts(recordings, monkeypatch):
    query = recordings[3][40:70] + 0.01
    expected = find_motion(query, recordings, k=8, skeleton=ARM)
    monkeypatch.setattr("skpose.motions._search.SCANNED_AT_ONCE", 1)
    assert find_motion(query, recordings, k=8, skeleton=ARM) == expected
    monkeypatch.setattr("skpose.motions._search.MOST_CELLS", 1)
    assert find_motion(query, recordings, k=8, skeleton=ARM) == expected
    monkeypatch.setattr("skpose.motions._search.FIRST_SHARE", 1.0)
    assert find_motion(query, recordings, k=8, skeleton=ARM) == expected


def test_few_cells_are_measured():
    """A hundred waves, ten of them like the query: most pairs of frames are ruled out."""
    rng = np.random.default_rng(2)
    waves = [rng.normal(size=3) * np.sin(np.linspace(0, 2 * np.pi, 60))[:, None] for _ in range(90)]
    query = np.array([1.0, -0.7, 0.4]) * np.sin(np.linspace(0, 2 * np.pi, 60))[:, None]
    waves += [query * rng.uniform(0.9, 1.1) for _ in range(10)]
    recording = np.concatenate([waves[i] for i in rng.permutation(100)])
    search = WindowSearch(SequenceIndex(Sequences.of([recording]), ARM, Spatial()), 1)
    windows = search.best(query, 10)
    assert len(windows) == 10
    assert search.n_cells < 0.05 * len(query) * len(recording)


def test_motions_and_datasets():
    gait = make_gait(n_subjects=2, n_sequences=1, duration=3, frame_rate=24, random_state=0)
    query = gait.motions[2][10:30]
    index = MotionIndex(gait)
    assert (index.frame_rate, index.skeleton) == (24, gait.skeleton)
    (best,) = find_motion(query, index, k=1)
    assert best == MotionMatch(2, 10, 30, 0.0)
    assert find_motion(query, list(gait), k=1, skeleton=gait.skeleton) == [best]
    angles = [motion.angles for motion in gait]
    assert find_motion(query.angles, angles, k=1, skeleton=gait.skeleton) == [best]


def test_an_index_has_a_metric_and_a_frame_rate(recordings):
    index = MotionIndex(recordings, skeleton=ARM)
    with pytest.raises(ValueError, match="MotionIndex"):
        find_motion(recordings[0][:9], index, metric="position")
    with pytest.raises(ValueError, match="query has 2 columns"):
        find_motion(recordings[0][:9, :2], MotionIndex(recordings, metric="angle"))
    there = MotionIndex([Motion(ARM, motion, 30) for motion in recordings])
    with pytest.raises(ValueError, match="query has 60 Hz"):
        find_motion(Motion(ARM, recordings[0][:9], 60), there)
    dataset = MotionDataset([Motion(ARM, motion, 30) for motion in recordings])
    assert find_motion(Motion(ARM, recordings[0][:9], 30), dataset, k=1)[0].distance == 0.0
