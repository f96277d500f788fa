"""Repetitions: motions whose repetitions are known, and what holds for all."""

import functools
import re

import numpy as np
import pytest
from scipy.signal import find_peaks

from skpose import Motion, Skeleton, forward_kinematics
from skpose._compiled.path.family import family_of, segments_of
from skpose.datasets import humanoid, make_gait
from skpose.motions import _repetitions, segment_repetitions
from skpose.motions._template import moving_frames

ARM = Skeleton.chain(3)
KNEE = "left_shank_rx"
STEPS = (1, 1), (1, 2), (2, 1)


def exercise(n_frames, seed=0, skeleton=ARM):
    """A movement from rest and back to it on another path."""
    rng = np.random.default_rng(seed)
    there, aside = np.linalg.qr(rng.normal(size=(skeleton.n_dofs, 2)))[0].T
    t = np.linspace(0, 1, n_frames)[:, None]
    return np.sin(np.pi * t) ** 2 * there + 0.5 * np.sin(2 * np.pi * t) * np.sin(np.pi * t) * aside


def recording(lengths, pauses, seed=0, noise=0.0, skeleton=ARM):
    """Exercises of these lengths, each after a pause, and a last pause; with their true first and last frames."""
    parts, truth, at = [], [], 0
    for pause, length in zip(pauses, [*lengths, 0], strict=True):
        parts += [np.zeros((pause, skeleton.n_dofs)), exercise(length, seed, skeleton)]
        truth.append((at + pause, at + pause + length))
        at += pause + length
    poses = np.concatenate(parts)
    return poses + noise * np.random.default_rng(seed).normal(size=poses.shape), np.array(truth[:-1])


def assert_found(found, truth, tolerance):
    assert len(found) == len(truth), found
    np.testing.assert_allclose(np.stack([found.starts, found.stops], axis=1), truth, atol=tolerance)


def paths_from(similarities, columns, i, k):
    """All paths from a cell on, as (last row, score, cells)."""
    n, m = similarities.shape[0], len(columns)
    here = similarities[i, columns[k]]
    if k == m - 1:
        yield i, here, 1
    for down, right in STEPS:
        if i + down < n and k + right < m:
            for last, score, cells in paths_from(similarities, columns, i + down, k + right):
                yield last, here + score, cells + 1


def best_family(similarities, first, last_row, start, stop):
    """(score, cells, covered, segments) of the best family in some rows, by trying all of them."""

    @functools.cache
    def best(i):
        if i == last_row:
            return 0.0, 0, 0, ()
        found = [best(i + 1)]
        for last, score, cells in paths_from(similarities[:last_row], range(start, stop), i, 0):
            after = best(last + 1)
            found.append(
                (score + after[0], cells + after[1], last + 1 - i + after[2], ((i, last + 1, score / cells), *after[3]))
            )
        return max(found)

    return best(first)


@pytest.mark.parametrize("seed", range(20))
def test_the_best_family_is_that_of_all_families(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(5, 9))
    similarities = rng.uniform(-0.5, 0.5, size=(n, n))
    start, first = int(rng.integers(n - 1)), int(rng.integers(3))
    stop = int(rng.integers(start + 1, min(n, start + 4) + 1))
    score, n_cells, n_covered, segments = best_family(similarities, first, n - 1, start, stop)
    family = family_of(similarities, first, n - 1, start, stop)
    np.testing.assert_allclose(family.score, score, atol=1e-12)
    assert (family.n_cells, family.n_covered) == (n_cells, n_covered)
    found, means = segments_of(similarities, first, n - 1, start, stop)
    np.testing.assert_array_equal(found, np.array([s[:2] for s in segments]).reshape(-1, 2))
    np.testing.assert_allclose(means, [s[2] for s in segments], atol=1e-12)


def test_a_family_may_be_empty():
    assert family_of(np.full((6, 6), -1.0), 0, 6, 1, 4) == (0.0, 0, 0)
    assert family_of(np.ones((6, 6)), 2, 2, 1, 4) == (0.0, 0, 0)
    assert len(segments_of(np.full((6, 6), -1.0), 0, 6, 1, 4)[0]) == 0


@pytest.mark.parametrize("metric", ["position", "spatial", "rotation", "angle"])
def test_repetitions_with_pauses_are_found_where_they_are(metric):
    poses, truth = recording([60, 60, 60, 60], [30, 45, 10, 60, 25])
    found = segment_repetitions(poses, skeleton=ARM, metric=metric)
    assert_found(found, truth, 8)
    assert found.distances[found.template] == 0.0
    np.testing.assert_array_less(found.distances, 0.1)
    for motion, start, stop in zip(found.motions, found.starts, found.stops, strict=True):
        np.testing.assert_array_equal(motion, poses[start:stop])


@pytest.mark.parametrize("seed", range(6))
def test_tempo_and_noise(seed):
    poses, truth = recording([60, 44, 80, 66, 52], [20, 40, 30, 60, 30, 10], seed, noise=0.01)
    found = segment_repetitions(poses, skeleton=ARM, metric="position")
    assert_found(found, truth, 22)  # the first and last frames of an exercise are slower than its noise
    assert np.median(np.abs(np.stack([found.starts, found.stops], axis=1) - truth)) <= 6


def test_stillness_is_left_out():
    """A pause that is longer than all the rest, with a small sway, is no repetition and no part of one."""
    poses, truth = recording([60, 60, 60], [100, 150, 100, 800])
    sway = 0.02 * np.sin(np.arange(len(poses)) / 15)[:, None]
    found = segment_repetitions(poses + sway, skeleton=ARM, metric="position")
    assert_found(found, truth, 8)


def test_moving_frames_are_those_that_move():
    t = np.concatenate([np.zeros(50), np.linspace(0, 2, 40), np.full(50, 2.0)])
    moving = moving_frames(np.abs(t[:, None] - t))
    assert set(range(52, 88)) <= set(moving) <= set(range(45, 95))
    assert len(moving_frames(np.zeros((20, 20)))) == 0


@pytest.mark.parametrize("n", [1, 2, 5, 30])
def test_a_pose_that_lasts_does_not_repeat(n):
    found = segment_repetitions(np.ones((n, 3)), skeleton=ARM)
    assert len(found) == 0
    assert found.template is None
    assert found.motions == []
    assert repr(found) == "Repetitions(none, fitness 0.00)"


@pytest.mark.parametrize("seed", range(4))
def test_what_does_not_repeat_gives_none(seed):
    """One exercise; and a wandering that does not come back."""
    assert len(segment_repetitions(exercise(150, seed), skeleton=ARM, metric="position")) == 0
    away = np.linspace(0, 3, 200)[:, None] * [0.5, 0.2, 0.1] + 0.1 * exercise(200, seed)
    assert len(segment_repetitions(away, skeleton=ARM, metric="position")) == 0


def test_one_that_repeats_among_others_that_do_not():
    poses, truth = recording([60, 60, 60], [30, 30, 30, 30])
    other = np.linspace([3.0, -1.5, 2.0], [0.0, 0.0, 0.0], 120)
    found = segment_repetitions(np.concatenate([other, poses]), skeleton=ARM, metric="position")
    assert_found(found, truth + len(other), 14)


def test_a_fitness_that_is_asked_for():
    poses, _ = recording([60, 60, 60], [30, 30, 30, 30])
    found = segment_repetitions(poses, skeleton=ARM, metric="position")
    assert 0.5 < found.fitness <= 1 - 1 / 3
    none = segment_repetitions(poses, skeleton=ARM, metric="position", min_fitness=0.7)
    assert (len(none), none.fitness) == (0, found.fitness)


def test_lengths_that_are_asked_for():
    poses, truth = recording([60] * 6, [20] * 7)
    half = segment_repetitions(poses, skeleton=ARM, metric="position", max_frames=40)
    template = half.stops[half.template] - half.starts[half.template]
    assert template <= 40
    assert_found(segment_repetitions(poses, skeleton=ARM, metric="position", min_frames=40, max_frames=80), truth, 8)
    walk = make_gait(1, 1, activities=["walk"], duration=8, frame_rate=40, random_state=0)[0]
    one, more = (
        segment_repetitions(walk, metric="position"),
        segment_repetitions(walk, metric="position", min_frames=60),
    )
    assert (one.stops - one.starts)[one.template] < 50
    assert (more.stops - more.starts)[more.template] >= 60


@pytest.mark.parametrize("seed", range(4))
def test_the_template_is_as_long_as_is_asked_for_with_pauses_too(seed):
    poses, _ = recording([60, 44, 80, 66, 52], [20, 40, 30, 60, 30, 10], seed, noise=0.01)
    for least in range(30, 90, 5):
        found = segment_repetitions(poses, skeleton=ARM, metric="position", min_frames=least, min_fitness=0.0)
        if len(found):
            assert found.stops[found.template] - found.starts[found.template] >= least


@pytest.mark.parametrize(("activity", "seed"), [("walk", 0), ("walk", 1), ("run", 0), ("run", 1)])
def test_strides_of_generated_gait(activity, seed):
    """As many as the knee bends, as far apart, on both sides and in both orders of the angles."""
    motion = make_gait(1, 1, activities=[activity], duration=6, frame_rate=40, random_state=seed)[0]
    found = segment_repetitions(motion)
    knee = motion.angles[:, motion.skeleton.dof_names.index(KNEE)]
    period = np.diff(find_peaks(np.abs(knee), prominence=np.ptp(knee) / 2)[0]).mean()
    assert abs(len(found) - len(motion) / period) <= 1.2
    # The first one may be a part of a stride, which is aligned to a whole one.
    np.testing.assert_allclose(np.diff(found.starts)[1:], period, atol=3)
    for other in (motion.mirrored(), motion.to_rotvec()):
        again = segment_repetitions(other, metric="position")
        expected = segment_repetitions(motion, metric="position")
        np.testing.assert_array_equal(again.starts, expected.starts)
        np.testing.assert_allclose(again.distances, expected.distances, atol=1e-9)
    assert all(isinstance(m, Motion) and m.frame_rate == 40 for m in found.motions)
    assert [len(m) for m in found.motions] == (found.stops - found.starts).tolist()


def test_threads_change_nothing():
    poses, _ = recording([50, 60, 70], [20] * 4)
    one, two = (segment_repetitions(poses, skeleton=ARM, n_jobs=n) for n in (1, 2))
    np.testing.assert_array_equal(one.starts, two.starts)
    assert one.fitness == two.fitness


def test_long_motions_are_thinned(monkeypatch):
    poses, truth = recording([60, 60, 60, 61], [30, 45, 10, 60, 0])
    monkeypatch.setattr(_repetitions, "MOST_FRAMES", 200)  # of 386: every second one
    found = segment_repetitions(poses, skeleton=ARM, metric="position", max_frames=70)
    assert_found(found, truth, 10)
    assert (found.starts % 2 == 0).all()
    walk = make_gait(1, 1, activities=["walk"], duration=241 / 40, frame_rate=40, random_state=0)[0]
    strides = segment_repetitions(walk, metric="position")
    assert strides.stops[-1] == len(walk) == 241


def test_without_a_skeleton_angles_and_a_warning():
    poses, truth = recording([60, 60, 60], [30] * 4)
    with pytest.warns(UserWarning, match='without a skeleton means "angle"'):
        found = segment_repetitions(poses)
    assert_found(found, truth, 8)


def test_warns_of_degrees():
    with pytest.warns(UserWarning, match="values of motion reach"):
        segment_repetitions(np.degrees(exercise(30)), skeleton=ARM)


@pytest.mark.parametrize(
    ("given", "options", "expected"),
    [
        ([exercise(9), exercise(9)], {"skeleton": ARM}, "motion must be one motion, a skpose.Motion or an array"),
        (exercise(9), {"metric": "position"}, "the metric 'position' needs a skeleton"),
        (exercise(9), {"skeleton": humanoid()}, "3 columns"),
        (
            exercise(9),
            {"skeleton": ARM, "min_frames": 9, "max_frames": 8},
            "min_frames must be no more than max_frames",
        ),
        (exercise(9), {"skeleton": ARM, "min_fitness": 2}, "'min_fitness' parameter of segment_repetitions must be"),
    ],
)
def test_refuses(given, options, expected):
    with pytest.raises((ValueError, TypeError), match=re.escape(expected)):
        segment_repetitions(given, **options)


@pytest.mark.parametrize("person", ["bd", "bk", "dg"])
def test_squats_of_hdm05_with_stillness_between(hdm05, person):
    """Six recordings of one squat each; all are found, each with its lowest pose within it."""
    squats = [m.to_rotvec().resample(30) for m in hdm05[(hdm05.actions == "squat") & (hdm05.subjects == person)][:6]]
    parts, lowest = [], []
    for squat in squats:
        names = squat.skeleton.joint_names
        legs = np.linalg.norm(forward_kinematics(squat.angles, squat.skeleton)[:, names.index("lfoot")], axis=1)
        lowest.append(sum(map(len, parts)) + legs.argmin())
        parts += [squat, *[squat[-1]] * 20]
    found = segment_repetitions(Motion.concatenate(parts), metric="position")
    assert len(found) == 6
    assert ((found.starts < lowest) & (lowest < found.stops)).all()


def test_strides_of_cmu_are_as_long_as_those_of_the_knee(cmu):
    """The distance from the hip to the left foot is least once in each stride."""
    ratios = []
    for motion in cmu[np.isin(cmu.actions, ["walk", "run/jog"])]:
        motion = motion.to_rotvec()
        F = forward_kinematics(motion.angles, motion.skeleton)
        names = motion.skeleton.joint_names
        leg = np.linalg.norm(F[:, names.index("lfoot")] - F[:, names.index("lhipjoint")], axis=1)
        peaks = find_peaks(-leg, prominence=np.ptp(leg) / 2)[0]
        found = segment_repetitions(motion)
        assert len(found) >= 2
        if len(peaks) > 1:
            ratios.append(np.diff(found.starts).mean() / np.diff(peaks).mean())
    assert len(ratios) > 20
    np.testing.assert_allclose(np.median(ratios), 1.0, atol=0.02)
    np.testing.assert_allclose(ratios, 1.0, atol=0.1)
