"""Repetitions: motions whose repetitions are known, and what holds for all."""

import functools
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from skpose import Bone, Motion, Skeleton, forward_kinematics, motions
from skpose._compiled.path.family import family_of, first_far, fitness_by_length, segments_of
from skpose.datasets import humanoid, make_gait
from skpose.metrics import Angle
from skpose.motions._frames import Frames
from skpose.motions._template import LONGEST_PAUSE

segment_repetitions = functools.partial(motions.segment_repetitions, random_state=0)  # the same p-values in each run
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


def paths_from(similarities, is_cut, columns, i, k):
    """All paths from a cell on that go on across no cut, which are before some rows: last row, score, cells."""
    n, m = similarities.shape[0], len(columns)
    here = similarities[i, columns[k]]
    if k == m - 1:
        yield i, here, 1
    for down, right in STEPS:
        if i + down < n and k + right < m and not is_cut[i + 1 : i + down + 1].any():
            for last, score, cells in paths_from(similarities, is_cut, columns, i + down, k + right):
                yield last, here + score, cells + 1


def best_family(similarities, is_cut, first, last_row, start, stop):
    """(score, cells, covered, segments) of the best family in some rows, by trying all of them."""

    @functools.cache
    def best(i):
        if i == last_row:
            return 0.0, 0, 0, ()
        found = [best(i + 1)]
        for last, score, cells in paths_from(similarities[:last_row], is_cut, range(start, stop), i, 0):
            after = best(last + 1)
            found.append(
                (score + after[0], cells + after[1], last + 1 - i + after[2], ((i, last + 1, score / cells), *after[3]))
            )
        return max(found)

    return best(first)


def some_slow(values, n):
    """All values, those after the first n slow ones."""
    return [pytest.param(value, marks=() if i < n else pytest.mark.slow) for i, value in enumerate(values)]


@pytest.mark.parametrize("seed", range(20))
def test_the_best_family_is_that_of_all_families(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(5, 9))
    similarities = rng.uniform(-0.5, 0.5, size=(n, n))
    start, first = int(rng.integers(n - 1)), int(rng.integers(3))
    stop = int(rng.integers(start + 1, min(n, start + 4) + 1))
    for pauses in (np.zeros(n, dtype=np.int64), rng.integers(0, 5, size=n)):
        expected = best_family(similarities, pauses > 2, first, n - 1, start, stop)
        family = family_of(similarities, pauses, 2.0, first, n - 1, start, stop)
        np.testing.assert_allclose(family.score, expected[0], atol=1e-12)
        assert (family.n_cells, family.n_covered) == expected[1:3]
        if not pauses.any():
            found, means = segments_of(similarities, first, n - 1, start, stop)
            np.testing.assert_array_equal(found, np.array([s[:2] for s in expected[3]]).reshape(-1, 2))
            np.testing.assert_allclose(means, [s[2] for s in expected[3]], atol=1e-12)


def test_a_family_may_be_empty():
    pauses = np.zeros(6, dtype=np.int64)
    assert family_of(np.full((6, 6), -1.0), pauses, 0.0, 0, 6, 1, 4) == (0.0, 0, 0)
    assert family_of(np.ones((6, 6)), pauses, 0.0, 2, 2, 1, 4) == (0.0, 0, 0)
    assert len(segments_of(np.full((6, 6), -1.0), 0, 6, 1, 4)[0]) == 0


@pytest.mark.parametrize("share", [0.8, np.inf])
@pytest.mark.parametrize("seed", range(6))
def test_the_fitness_of_each_length_in_another_order(seed, share):
    """By its equation, of the best of all families, from the matrix in that order."""
    rng = np.random.default_rng(seed)
    n, lengths = 8, np.array([2, 3, 4])
    distances = rng.uniform(size=(n, n))
    distances = np.triu(distances, 1) + np.triu(distances, 1).T
    similarities, is_far, order = 0.5 - distances, distances > 0.7, rng.permutation(n)
    expected = []
    for m in lengths:
        best, uncut = 0.0, np.zeros(n, dtype=bool)
        for start in range(0, n - m + 1, max(1, m // 3)):
            stop = start + m
            if not is_far[np.ix_(order, order)][start:stop, start:stop].any():
                continue
            permuted = similarities[np.ix_(order, order)]
            from_first = 1 - permuted[start]
            if from_first[stop - 1 : stop + 1].min() > share * from_first[start:stop].max():
                continue
            both = [best_family(permuted, uncut, *rows, start, stop) for rows in ((0, start), (stop, n))]
            score, n_cells, n_covered = (sum(family[i] for family in both) for i in range(3))
            if score > 0:
                sigma, gamma = score / (n_cells + m), n_covered / n
                best = max(best, 2 * sigma * gamma / (sigma + gamma))
        expected.append(best)
    np.testing.assert_allclose(fitness_by_length(similarities, is_far, order, lengths, 3, share), expected, atol=1e-12)
    assert max(expected) > 0.0
    reach = [next((j for j in range(n) if is_far[i : j + 1, i : j + 1].any()), n) for i in range(n)]
    np.testing.assert_array_equal(first_far(is_far), reach)


@pytest.mark.parametrize("metric", some_slow(["position", "spatial", "rotation", "angle"], 2))
def test_repetitions_with_pauses_are_found_where_they_are(metric):
    poses, truth = recording([60, 60, 60, 60], [30, 45, 10, 60, 25])
    found = segment_repetitions(poses, skeleton=ARM, metric=metric)
    assert_found(found, truth, 8)
    assert found.distances[found.template] == 0.0
    np.testing.assert_array_less(found.distances, 0.1)
    for motion, start, stop in zip(found.motions, found.starts, found.stops, strict=True):
        np.testing.assert_array_equal(motion, poses[start:stop])


@pytest.mark.parametrize("seed", some_slow(range(6), 2))
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
    moving = Frames(t[:, None], Angle(), None, 1).moving(1)
    assert set(range(52, 88)) <= set(moving) <= set(range(45, 95))
    assert len(Frames(np.zeros((20, 1)), Angle(), None, 1).moving(1)) == 0


@pytest.mark.parametrize("n", [1, 2, 5, 30])
def test_a_pose_that_lasts_does_not_repeat(n):
    found = segment_repetitions(np.ones((n, 3)), skeleton=ARM)
    assert len(found) == 0
    assert found.template is None
    assert found.motions == []
    assert found.pvalue == 1.0
    assert found.pauses.tolist() == ([[0, n]] if n >= 5 else [])
    assert repr(found) == f"Repetitions(none{', 1 pause' if n >= 5 else ''}, fitness 0.00, p = 1)"


@pytest.mark.parametrize("seed", some_slow(range(4), 2))
def test_what_does_not_repeat_gives_none(seed):
    """One exercise; and a wandering that does not come back."""
    assert len(segment_repetitions(exercise(150, seed), skeleton=ARM, metric="position")) == 0
    away = np.linspace(0, 3, 200)[:, None] * [0.5, 0.2, 0.1] + 0.1 * exercise(200, seed)
    assert len(segment_repetitions(away, skeleton=ARM, metric="position")) == 0


def noise(kind, seed, n_frames=150, skeleton=ARM):
    rng = np.random.default_rng(seed)
    poses = rng.normal(size=(n_frames, skeleton.n_dofs))
    if kind == "smoothed random walk":
        poses = gaussian_filter1d(np.cumsum(poses, axis=0), 5, axis=0)
    return 0.3 * poses / poses.std()


@pytest.mark.parametrize("kind", ["white noise", "smoothed random walk"])
def test_noise_does_not_repeat(kind):
    """White noise has the fitness of walks."""
    found = [segment_repetitions(noise(kind, seed), skeleton=ARM, metric="position") for seed in range(10)]
    assert np.median([one.fitness for one in found]) > (0.3 if kind == "white noise" else 0.1)
    assert sum(len(one) > 0 for one in found) <= 2  # of ten; 0.5 are expected, and more than 2 in one of 80 cases
    of_any = segment_repetitions(noise(kind, 0), skeleton=ARM, metric="position", alpha=1.0, min_fitness=0.0)
    assert len(of_any) > 1 or kind != "white noise"
    assert (of_any.fitness, of_any.pvalue) == (found[0].fitness, found[0].pvalue)


@pytest.mark.slow
@pytest.mark.parametrize("leaves_out", [False, True], ids=["all frames", "moving frames"])
def test_the_p_value_of_white_noise(leaves_out, monkeypatch):
    """Of 200 draws as many are below each level as it says; no more where slow frames are left out of the motion."""
    if not leaves_out:
        monkeypatch.setattr("skpose.motions._frames.STILL", -1.0)
    found = [
        segment_repetitions(noise("white noise", seed, 60), skeleton=ARM, metric="position", random_state=seed)
        for seed in range(200)
    ]
    p = np.array([one.pvalue for one in found])
    for level in (0.05, 0.1, 0.3, 0.5, 0.8):
        excess, deviation = (p <= level).mean() - level, np.sqrt(level * (1 - level) / len(p))
        assert excess < 3 * deviation, level
        assert excess > -0.5 * level if leaves_out else excess > -3 * deviation, level


def test_how_sure_it_is():
    poses, truth = recording([60, 60, 60], [30] * 4)
    found = segment_repetitions(poses, skeleton=ARM, metric="position")
    assert found.pvalue == 0.01
    few = segment_repetitions(poses, skeleton=ARM, metric="position", n_surrogates=19)
    assert few.pvalue == 0.05
    assert_found(few, truth, 8)
    assert len(segment_repetitions(poses, skeleton=ARM, metric="position", alpha=0.01)) == 3
    again = [segment_repetitions(noise("white noise", 3), skeleton=ARM, random_state=seed).pvalue for seed in (1, 1, 5)]
    assert again[0] == again[1] != again[2]


@pytest.mark.parametrize("pause", [80, 400])
@pytest.mark.parametrize("sway", [0.0, 0.02])
def test_standing_is_a_pause_and_no_slow_repetition(pause, sway):
    """The recording begins and ends in the middle of an exercise: from middle to middle it has one more."""
    poses, truth = recording([60] * 5, [1, pause, pause, pause, pause, 1])
    poses += sway * np.sin(np.arange(len(poses)) / 15)[:, None]
    cut = slice(truth[0, 0] + 30, truth[-1, 1] - 30)
    found = segment_repetitions(poses[cut], skeleton=ARM, metric="position")
    assert len(found) >= 3
    np.testing.assert_array_less(found.stops - found.starts, 75)
    expected = np.stack([truth[:-1, 1], truth[1:, 0]], axis=1) - cut.start
    np.testing.assert_allclose(found.pauses, expected, atol=14)
    both = np.concatenate([np.stack([found.starts, found.stops], axis=1), found.pauses])
    both = both[np.argsort(both[:, 0])]
    assert (both[:-1, 1] <= both[1:, 0]).all()
    assert f"{len(found)} of" in repr(found)
    assert ", 4 pauses, " in repr(found)


def test_a_short_hold_belongs_to_the_repetition():
    """A fifth of a second in each, at the same pose, is a part of the movement; LONGEST_PAUSE says how long may be."""
    half, hold = exercise(60)[:30], 12
    assert hold < LONGEST_PAUSE * 50
    one = np.concatenate([half, np.repeat(half[-1:], hold, axis=0), exercise(60)[30:], np.zeros((50, 3))])
    found = segment_repetitions(np.concatenate([one] * 5), skeleton=ARM, metric="position")
    assert_found(found, np.array([(i * len(one), i * len(one) + 72) for i in range(5)]), 8)
    assert len(found.pauses) == 5


@pytest.mark.parametrize("pauses", some_slow([(30, 50), (90, 90), (60, 90), (40, 90)], 2))
def test_a_long_hold_belongs_to_the_repetition_if_it_comes_back_only_behind_it(pauses):
    """Neither there nor back again is a repetition. The longer of the two pauses is between repetitions."""
    (hold, pause), half = pauses, exercise(60)[:30]
    parts = [half, np.repeat(half[-1:], hold, axis=0), exercise(60)[30:], np.zeros((pause, 3))]
    one = np.concatenate(parts)
    poses = np.concatenate([one] * 5) + 1e-3 * np.random.default_rng(0).normal(size=(5 * len(one), 3))
    found = segment_repetitions(poses, skeleton=ARM, metric="position")
    assert_found(found, np.array([(i * len(one), i * len(one) + 60 + hold) for i in range(5)]), 8)
    assert len(found.pauses) == 5


def test_a_part_of_the_movement_is_no_repetition():
    """The recording begins in the middle of an exercise: what is left of it does not come back."""
    poses, truth = recording([60] * 5, [1, 70, 70, 70, 70, 70])
    found = segment_repetitions(poses[truth[0, 0] + 30 :], skeleton=ARM, metric="position")
    assert_found(found, truth[1:] - truth[0, 0] - 30, 8)


@pytest.mark.parametrize("seed", some_slow(range(4), 1))
def test_every_repetition_comes_back(seed):
    """Its last pose is nearer to its first than its farthest one is."""
    rng = np.random.default_rng(seed)
    for poses in (
        gaussian_filter1d(np.cumsum(rng.normal(size=(400, 3)), axis=0), 5, axis=0) / 9,
        recording([60, 44, 80], [10, 20, 15, 30], seed, noise=0.01)[0],
        circle(300, 21.3),
    ):
        found = segment_repetitions(poses, skeleton=ARM, metric="position", alpha=1.0, min_fitness=0.0)
        for one in found.motions:
            positions = forward_kinematics(one, ARM).reshape(len(one), -1)
            away = np.linalg.norm(positions - positions[0], axis=1)
            assert away[-1] <= 0.95 * away.max()


def test_small_movements_among_large_ones():
    """Most poses of the recording are farther apart than those of the movement that repeats."""
    poses, truth = recording([60] * 8, [20] * 9)
    rng = np.random.default_rng(0)
    other = gaussian_filter1d(np.cumsum(rng.normal(size=(300, 3)), axis=0), 15, axis=0)
    found = segment_repetitions(np.concatenate([other / other.std(), 0.7 * poses]), skeleton=ARM, metric="position")
    assert_found(found, truth + len(other), 20)


@pytest.mark.parametrize("metric", some_slow(["auto", "spatial", "geodesic"], 2))
def test_other_euler_angles_of_the_same_rotations_change_nothing(metric):
    """(x, y, z) and (x + π, π − y, z + π) are one rotation, and far apart along a line in the angles."""
    skeleton = Skeleton([Bone("arm", None, (0.4, 0, 0), "xyz"), Bone("hand", "arm", (0.3, 0, 0), "z")])
    poses, truth = recording([30] * 4, [8, 10, 9, 12, 8], seed=1, noise=1e-3)
    poses = np.column_stack([poses, poses[:, 0]])
    twins = poses.copy()
    for start, stop in truth[1::2]:
        twins[start:stop, :3] = poses[start:stop, :3] * [1, -1, 1] + np.pi
    expected, found = (
        segment_repetitions(p, skeleton=skeleton, metric=metric, n_surrogates=19) for p in (poses, twins)
    )
    assert len(expected) == 4
    np.testing.assert_array_equal(found.starts, expected.starts)
    np.testing.assert_array_equal(found.stops, expected.stops)
    np.testing.assert_allclose(found.distances, expected.distances, atol=1e-6)
    as_balls = segment_repetitions(Motion(skeleton, twins, 30).to_rotvec(), metric=metric, n_surrogates=19)
    np.testing.assert_array_equal(as_balls.starts, expected.starts)


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


@pytest.mark.parametrize("seed", some_slow(range(6), 2))
def test_a_length_that_one_repetition_has(seed):
    """It is the template; pairs with the pauses in them are longer, too, and none is taken for want of it."""
    lengths = np.random.default_rng(seed).integers(40, 60, size=8)
    poses, truth = recording(lengths, [30] * 9)
    found = segment_repetitions(poses, skeleton=ARM, metric="position", n_surrogates=19)
    longest = (found.stops - found.starts).max()
    again = segment_repetitions(poses, skeleton=ARM, metric="position", min_frames=longest, n_surrogates=19)
    assert_found(again, truth, 8)
    assert again.stops[again.template] - again.starts[again.template] == longest


@pytest.mark.parametrize("seed", some_slow(range(4), 1))
def test_the_template_is_as_long_as_is_asked_for_with_pauses_too(seed):
    poses, _ = recording([60, 44, 80, 66, 52], [20, 40, 30, 60, 30, 10], seed, noise=0.01)
    for least in range(30, 90, 10):
        found = segment_repetitions(poses, skeleton=ARM, metric="position", min_frames=least, min_fitness=0.0)
        if len(found):
            assert found.stops[found.template] - found.starts[found.template] >= least


@pytest.mark.parametrize("seed", some_slow(range(2), 1))
@pytest.mark.parametrize("activity", some_slow(["run", "walk"], 1))
def test_strides_of_generated_gait(activity, seed):
    """As many as the knee bends, as far apart, on both sides and in both orders of the angles."""
    motion = make_gait(1, 1, activities=[activity], duration=4, frame_rate=40, random_state=seed)[0]
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
    assert (one.fitness, one.pvalue) == (two.fitness, two.pvalue)


def circle(n_frames, period, noise=0.0):
    """A movement that goes round and round."""
    turns = 2 * np.pi * np.arange(n_frames) / period
    poses = np.stack([np.sin(turns), np.cos(turns), np.zeros(n_frames)], axis=1)
    return poses + noise * np.random.default_rng(0).normal(size=poses.shape)


CIRCLES = [(1000, 25), (1000, 8.4), (1000, 9.5)]
LONG_CIRCLES = [(1500, 10.3), (2500, 25), (4500, 25), (2500, 12.6), (4500, 16.4), (3000, 23.3), (5000, 133)]


@pytest.mark.parametrize("circles", some_slow([*CIRCLES, *LONG_CIRCLES], len(CIRCLES)))
def test_the_count_does_not_depend_on_the_length_of_the_recording(circles):
    """Nor on whether it lasts whole frames: several times the movement fit better then, and do not count."""
    n_frames, period = circles
    noise = 0.0 if period == 25 else 0.01
    found = segment_repetitions(circle(n_frames, period, noise), skeleton=ARM, metric="position", n_surrogates=19)
    assert abs(len(found) - n_frames / period) <= 1
    assert abs(np.median(found.stops - found.starts) - period) <= 1 + 0.02 * period


@pytest.mark.slow
@pytest.mark.parametrize("most", [100, 200, 250])
def test_long_motions_have_the_repetitions_of_short_ones(most, monkeypatch):
    """As many, at the same places: sections of 100 frames have two or three of them."""
    poses, truth = recording([60, 50, 60, 61, 66, 54] * 2, [30, 45, 10, 60, 20, 30] * 2 + [0])
    expected = segment_repetitions(poses, skeleton=ARM, metric="position", max_frames=70)
    assert_found(expected, truth, 10)
    monkeypatch.setattr(Frames, "most", most)  # of 1092
    found = segment_repetitions(poses, skeleton=ARM, metric="position", max_frames=70)
    assert_found(found, truth, 10)
    assert len(found.pauses) == len(expected.pauses)


def test_long_repetitions_of_long_motions(monkeypatch):
    """Sections have only a part of each: they are found among every second frame, or fewer."""
    poses, truth = recording([500, 460, 540, 500], [100, 150, 100, 200, 100], noise=0.002)
    monkeypatch.setattr(Frames, "most", 300)
    assert_found(segment_repetitions(poses, skeleton=ARM, metric="position", n_surrogates=19), truth, 80)


def test_memory_is_bounded(monkeypatch):
    """At no time are more distances computed at once than those of sections, or of a template of a few frames."""
    sizes = []
    measure = Frames._measure

    def measured(self, rows, columns):
        sizes.append(len(rows) * len(rows if columns is None else columns))
        return measure(self, rows, columns)

    monkeypatch.setattr(Frames, "_measure", measured)
    monkeypatch.setattr(Frames, "most", 200)
    found = segment_repetitions(circle(600, 50), skeleton=ARM, metric="position", n_surrogates=19)
    assert len(found) == 12
    assert max(sizes) <= 300**2  # those of the surrogates
    sizes.clear()
    assert len(segment_repetitions(circle(600, 20), skeleton=ARM, metric="position", n_surrogates=19)) == 30
    assert max(sizes) <= 300**2


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
        (exercise(9), {"skeleton": ARM, "n_surrogates": 9}, "found at alpha=0.05: use n_surrogates=19 or more"),
        (exercise(9), {"skeleton": ARM, "alpha": 0.001}, "use n_surrogates=999 or more"),
        (exercise(9), {"skeleton": ARM, "alpha": 0}, "'alpha' parameter of segment_repetitions must be"),
        (exercise(9), {"skeleton": ARM, "min_fitness": 2}, "'min_fitness' parameter of segment_repetitions must be"),
    ],
)
def test_refuses(given, options, expected):
    with pytest.raises((ValueError, TypeError), match=re.escape(expected)):
        segment_repetitions(given, **options)


@pytest.mark.slow
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


def joined(hdm05, person, action, n, pause):
    """Recordings of one repetition each, at 30 Hz, each with stillness after it; and where each begins and ends."""
    rng, parts, truth, at = np.random.default_rng(0), [], [], 0
    for motion in hdm05[np.char.endswith(hdm05.actions.astype(str), action) & (hdm05.subjects == person)][:n]:
        sway = 1e-3 * rng.normal(size=(pause, motion.skeleton.n_dofs))
        parts += [motion[::4], *[replace(motion[-1], angles=motion[-1].angles + one) for one in sway]]
        truth.append((at, at + len(parts[-1 - pause])))
        at = truth[-1][1] + pause
    return Motion.concatenate([replace(part, frame_rate=30, frame_numbers=None) for part in parts]), np.array(truth)


@pytest.mark.slow
@pytest.mark.parametrize(("n", "pause"), [(4, 60), (6, 0), (6, 60)])
@pytest.mark.parametrize("person", ["bk", "dg"])
def test_squats_of_hdm05_with_euler_angles(hdm05, person, n, pause):
    """Whole ones: the files have several triples of the same rotations, and stand still at both ends of a squat."""
    motion, truth = joined(hdm05, person, "squat", n, pause)
    found = segment_repetitions(motion)
    assert_found(found, truth, 16)  # it begins and ends standing: 16 frames are half a second
    assert (found.stops - found.starts > 0.5 * np.ptp(truth, axis=1)).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("action", "n", "pause"), [("to the front", 6, 0), ("to the front", 6, 60), ("throw basketball", 3, 60)]
)
def test_parts_that_do_not_come_back_are_no_templates(hdm05, action, n, pause):
    """They are as fit, or fitter, and would be found: a ninth of a throw, or the leg from the middle to the end."""
    motion, truth = joined(hdm05, "bk", action, n, pause)
    found = segment_repetitions(motion, metric="position")
    assert len(found) == n
    common = np.minimum(found.stops, truth[:, 1]) - np.maximum(found.starts, truth[:, 0])
    assert (common > 0.5 * np.ptp(truth, axis=1)).all()


@pytest.mark.slow
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
    assert np.mean(np.abs(np.array(ratios) - 1.0) <= 0.1) > 0.95
    np.testing.assert_allclose(ratios, 1.0, atol=0.2)  # the first of two may be a part, where the recording begins


@pytest.mark.slow
def test_what_does_not_repeat_of_hdm05(hdm05):
    """Files of one repetition; and eight of them one after the other."""
    chosen = hdm05[~np.isin(hdm05.actions, ["jog in a circle", "sneak"])].to_rotvec()
    files = [m.resample(30) for m in chosen.motions]
    assert not any(len(segment_repetitions(m, metric="position")) for m in files[::8])
    for person in ("bd", "bk", "dg"):
        rng = np.random.default_rng(0)
        its_own = [np.flatnonzero((chosen.subjects == person) & (chosen.actions == a)) for a in set(chosen.actions)]
        eight = [files[rng.choice(indices)] for indices in sorted(its_own, key=len)[:8]]
        assert len(segment_repetitions(Motion.concatenate(eight), metric="position")) == 0
