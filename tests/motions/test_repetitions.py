"""Repetitions: motions whose repetitions are known, and motions without repetitions."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from skpose import Bone, Motion, Skeleton, forward_kinematics, motions
from skpose.datasets import make_gait
from skpose.motions._template import Frames

segment_repetitions = functools.partial(motions.segment_repetitions, random_state=0, n_surrogates=19)
ARM = Skeleton.chain(3)


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


@pytest.mark.parametrize("metric", ["position", "angle"])
def test_repetitions_with_pauses_are_found_where_they_are(metric):
    poses, truth = recording([30, 30, 30, 30], [15, 22, 5, 30, 12])
    found = segment_repetitions(poses, skeleton=ARM, metric=metric)
    assert_found(found, truth, 5)
    assert found.distances[found.template] == 0.0
    assert 0.5 < found.fitness <= 1 - 1 / 4
    assert found.pvalue == 0.05
    for motion, start, stop in zip(found.motions, found.starts, found.stops, strict=True):
        np.testing.assert_array_equal(motion, poses[start:stop])
    fitter = segment_repetitions(poses, skeleton=ARM, metric=metric, min_fitness=0.9)
    assert (len(fitter), fitter.fitness) == (0, found.fitness)


def test_tempo_and_noise():
    poses, truth = recording([60, 44, 80, 66, 52], [20, 40, 30, 60, 30, 10], noise=0.01)
    found = segment_repetitions(poses, skeleton=ARM, metric="position")
    assert_found(found, truth, 22)  # the first and last frames of an exercise are slower than its noise
    assert np.median(np.abs(np.stack([found.starts, found.stops], axis=1) - truth)) <= 6


def test_stillness_is_left_out():
    """A long pause with a small sway is neither a repetition nor a part of one."""
    poses, truth = recording([60, 60, 60], [100, 150, 100, 800])
    sway = 0.02 * np.sin(np.arange(len(poses)) / 15)[:, None]
    assert_found(segment_repetitions(poses + sway, skeleton=ARM, metric="position"), truth, 8)


def test_a_short_hold_belongs_to_the_repetition():
    half, hold = exercise(30)[:15], 6
    one = np.concatenate([half, np.repeat(half[-1:], hold, axis=0), exercise(30)[15:], np.zeros((25, 3))])
    found = segment_repetitions(np.concatenate([one] * 5), skeleton=ARM, metric="position")
    assert_found(found, np.array([(i * len(one), i * len(one) + 36) for i in range(5)]), 5)


def test_a_long_hold_belongs_to_the_repetition():
    """Neither the way there nor the way back is a repetition; the longer pause is between repetitions."""
    half, hold = exercise(30)[:15], 30
    one = np.concatenate([half, np.repeat(half[-1:], hold, axis=0), exercise(30)[15:], np.zeros((45, 3))])
    found = segment_repetitions(np.concatenate([one] * 5), skeleton=ARM, metric="position")
    assert_found(found, np.array([(i * len(one), i * len(one) + 60) for i in range(5)]), 5)


def test_a_part_of_the_movement_is_not_a_repetition():
    """The recording begins in the middle of an exercise: the rest of it does not come back."""
    poses, truth = recording([30] * 5, [1, 35, 35, 35, 35, 35])
    found = segment_repetitions(poses[truth[0, 0] + 15 :], skeleton=ARM, metric="position")
    assert_found(found, truth[1:] - truth[0, 0] - 15, 5)


@pytest.mark.parametrize("n", [1, 30])
def test_a_pose_that_lasts_does_not_repeat(n):
    found = segment_repetitions(np.ones((n, 3)), skeleton=ARM)
    assert (len(found), found.template, found.motions, found.pvalue) == (0, None, [], 1.0)
    assert repr(found) == "Repetitions(none, fitness 0.00, p = 1)"
    assert "repeats" in found.reason


def test_one_exercise_does_not_repeat():
    assert len(segment_repetitions(exercise(100), skeleton=ARM, metric="position")) == 0


@pytest.mark.slow
@pytest.mark.parametrize("width", [0, 5], ids=["white noise", "smoothed random walk"])
def test_noise_does_not_repeat(width):
    """White noise has the fitness of walks; its p-values are uniform."""
    pvalues, n_found = [], 0
    for seed in range(40):
        poses = np.random.default_rng(seed).normal(size=(60, 3))
        if width:
            poses = gaussian_filter1d(np.cumsum(poses, axis=0), width, axis=0)
        found = segment_repetitions(0.3 * poses / poses.std(), skeleton=ARM, metric="position")
        pvalues.append(found.pvalue)
        n_found += len(found) > 0
    assert n_found <= 6  # 2 are expected
    assert width or 0.3 < np.mean(pvalues) < 0.75


def test_the_same_rotations_in_other_euler_angles_change_nothing():
    """(x, y, z) and (x + π, π − y, z + π) are one rotation, and far apart along a line in the angles."""
    skeleton = Skeleton([Bone("arm", None, (0.4, 0, 0), "xyz"), Bone("hand", "arm", (0.3, 0, 0), "z")])
    poses, truth = recording([30] * 4, [8, 10, 9, 12, 8], seed=1, noise=1e-3)
    poses = np.column_stack([poses, poses[:, 0]])
    twins = poses.copy()
    for start, stop in truth[1::2]:
        twins[start:stop, :3] = poses[start:stop, :3] * [1, -1, 1] + np.pi
    expected, found = (segment_repetitions(p, skeleton=skeleton) for p in (poses, twins))
    assert len(expected) == 4
    np.testing.assert_array_equal(found.starts, expected.starts)
    np.testing.assert_allclose(found.distances, expected.distances, atol=1e-6)


def test_lengths_that_are_asked_for():
    poses, truth = recording([30] * 6, [10] * 7)
    half = segment_repetitions(poses, skeleton=ARM, metric="position", max_frames=20)
    assert (half.stops - half.starts)[half.template] <= 20
    assert_found(segment_repetitions(poses, skeleton=ARM, metric="position", min_frames=20, max_frames=40), truth, 5)


@pytest.mark.parametrize("activity", ["run", "walk"])
def test_strides_of_generated_gait(activity):
    """As many as the knee bends, as far apart, on both sides."""
    motion = make_gait(1, 1, activities=[activity], duration=4, frame_rate=20, random_state=0)[0]
    found = segment_repetitions(motion, metric="position", n_jobs=2)
    knee = motion.angles[:, motion.skeleton.dof_names.index("left_shank_rx")]
    period = np.diff(find_peaks(np.abs(knee), prominence=np.ptp(knee) / 2)[0]).mean()
    assert abs(len(found) - len(motion) / period) <= 1.2
    # The first one may be a part of a stride, which is aligned to a whole one.
    np.testing.assert_allclose(np.diff(found.starts)[1:], period, atol=3)
    mirrored = segment_repetitions(motion.mirrored(), metric="position")
    np.testing.assert_array_equal(mirrored.starts, found.starts)
    assert all(isinstance(m, Motion) and m.frame_rate == 20 for m in found.motions)


@pytest.mark.parametrize(
    ("n_frames", "period"), [(300, 8.4), (300, 25), pytest.param(4500, 16.4, marks=pytest.mark.slow)]
)
def test_the_count_does_not_depend_on_the_length_of_the_recording(n_frames, period):
    """Nor on whether a repetition lasts whole frames: several times the movement fit better then, and do not count."""
    turns = 2 * np.pi * np.arange(n_frames) / period
    circle = np.stack([np.sin(turns), np.cos(turns), np.zeros(n_frames)], axis=1)
    circle += 0.01 * np.random.default_rng(0).normal(size=circle.shape)
    found = segment_repetitions(circle, skeleton=ARM, metric="position")
    assert abs(len(found) - n_frames / period) <= 1
    assert abs(np.median(found.stops - found.starts) - period) <= 1 + 0.02 * period


@pytest.mark.slow
def test_long_repetitions_of_long_motions(monkeypatch):
    """Sections contain only a part of each: they are found among every second frame, or fewer."""
    poses, truth = recording([500, 460, 540, 500], [100, 150, 100, 200, 100], noise=0.002)
    monkeypatch.setattr(Frames, "most", 300)
    assert_found(segment_repetitions(poses, skeleton=ARM, metric="position"), truth, 80)


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
@pytest.mark.parametrize(("person", "n", "pause"), [("bk", 6, 0), ("dg", 6, 60)])
def test_squats_of_hdm05_with_euler_angles(hdm05, person, n, pause):
    """Whole ones: the files have several triples of the same rotations, and stand still at both ends of a squat."""
    motion, truth = joined(hdm05, person, "squat", n, pause)
    found = segment_repetitions(motion)
    assert_found(found, truth, 16)  # it begins and ends standing: 16 frames are half a second
    assert (found.stops - found.starts > 0.5 * np.ptp(truth, axis=1)).all()


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


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"min_frames": 9, "max_frames": 8}, "min_frames"),
        ({"n_surrogates": 9}, "n_surrogates"),
        ({"alpha": 0}, "alpha"),
    ],
)
def test_options_are_checked(options, match):
    with pytest.raises(ValueError, match=match):
        segment_repetitions(exercise(9), skeleton=ARM, **options)
