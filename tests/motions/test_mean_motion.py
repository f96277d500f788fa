"""Means of motions: what they are on motions whose mean is known, and what holds for all."""

import re

import numpy as np
import pytest
import reference
from conftest import SKELETONS
from sklearn.exceptions import ConvergenceWarning

from skpose import Motion, Skeleton, forward_kinematics, pose_distances
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean
from skpose.motions import MeanMotion, mean_motion
from skpose.motions._barycenter import Barycenter

ARM = Skeleton.chain(3)
METRICS = ["position", "geodesic"]


def swings(n_motions=4, seed=0, skeleton=ARM, spread=0.15, least=9):
    """Motions of different lengths and tempos along one curve, each a little off."""
    rng = np.random.default_rng(seed)
    ends, bend = rng.normal(scale=0.5, size=(2, 2, skeleton.n_dofs))
    motions = []
    for _ in range(n_motions):
        t = np.linspace(0, 1, rng.integers(least, least + 5))[:, None] ** rng.uniform(0.7, 1.4)
        off = rng.normal(scale=spread, size=skeleton.n_dofs)
        motions.append(ends[0] + t * (ends[1] - ends[0]) + np.sin(np.pi * t) * bend[0] + off)
    return motions


def objective_of(poses, motions, skeleton, metric="position"):
    costs = [pose_distances(poses, motion, skeleton=skeleton, metric=metric) ** 2 for motion in motions]
    return sum(map(reference.least_sum, costs))


def bone_lengths(poses, skeleton):
    positions = reference.forward_kinematics(poses, skeleton)
    near = np.concatenate([positions, np.zeros_like(positions[:, :1])], axis=1)[:, skeleton.parents]
    return np.linalg.norm(positions - near, axis=-1)


@pytest.mark.parametrize("metric", METRICS)
def test_a_single_motion_is_its_own_mean(metric):
    (motion,) = swings(1)
    mean = mean_motion([motion], skeleton=ARM, metric=metric)
    np.testing.assert_array_equal(mean.poses, motion)
    assert mean.converged
    assert mean.objective == 0.0
    assert not mean.std.any()
    np.testing.assert_array_equal(mean.n_poses, 1)


@pytest.mark.parametrize("metric", METRICS)
def test_copies_warped_in_time_have_the_motion_as_their_mean(metric):
    (motion,) = swings(1, seed=1)
    rng = np.random.default_rng(0)
    copies = [np.repeat(motion, rng.integers(1, 4, len(motion)), axis=0) for _ in range(3)]
    mean = mean_motion([motion, *copies], skeleton=ARM, metric=metric)
    assert mean.objective < 1e-20
    assert len(np.unique(mean.poses.round(9), axis=0)) == len(motion)
    assert mean.joint_std.max() < 1e-9


@pytest.mark.parametrize(
    ("name", "metric"),
    [(name, "position") for name in SKELETONS] + [(name, "geodesic") for name in ("chain", "ball joints", "weights")],
)
def test_the_objective_is_the_sum_of_best_paths_and_never_rises(name, metric):
    skeleton = SKELETONS[name]
    motions = swings(3, seed=2, skeleton=skeleton, spread=0.08 if metric == "geodesic" else 0.3, least=5)
    mean = mean_motion(motions, skeleton=skeleton, metric=metric, tol=0.0)
    assert mean.n_iter > 1
    assert (np.diff(mean.objectives) <= 0).all()
    assert mean.objective < 0.95 * mean.objectives[0]
    np.testing.assert_allclose(mean.objective, objective_of(mean.poses, motions, skeleton, metric), rtol=1e-9)
    np.testing.assert_allclose((mean.std**2 * mean.n_poses).sum(), mean.objective, rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_the_objective_never_rises_on_poses_far_apart(seed):
    rng = np.random.default_rng(seed)
    skeleton = SKELETONS["mixed joints"]
    motions = [rng.uniform(-2, 2, size=(n, skeleton.n_dofs)) for n in (6, 8, 9)]
    mean = mean_motion(motions, skeleton=skeleton, tol=0.0)
    assert (np.diff(mean.objectives) <= 0).all()
    assert mean.converged


@pytest.mark.parametrize("metric", METRICS)
def test_each_frame_is_the_frechet_mean_of_equal_frames(metric):
    """With a window of zero all frames i of equal lengths are aligned, and no others."""
    rng = np.random.default_rng(3)
    (motion,) = swings(1, seed=3)
    motions = motion + rng.normal(scale=0.2, size=(4, *motion.shape))
    mean = mean_motion(motions, skeleton=ARM, metric=metric, window=0.0)
    assert mean.n_iter == 2  # of which the second finds nothing to change
    np.testing.assert_array_equal(mean.n_poses, 4)
    for frame in range(len(motion)):
        expected = frechet_mean(motions[:, frame], ARM, metric=metric)
        np.testing.assert_allclose(mean.std[frame] ** 2, expected.variance, rtol=1e-4)
        distance = pose_distances(mean.poses[[frame]], expected.pose[None], skeleton=ARM, metric="position")
        assert distance[0, 0] < (1e-7 if metric == "position" else 0.01 * mean.std[frame])


def test_a_frame_whose_poses_stay_the_same_is_computed_once(monkeypatch):
    calls = []
    nearest = Barycenter._nearest_to_mean
    monkeypatch.setattr(Barycenter, "_nearest_to_mean", lambda *given: calls.append(0) or nearest(*given))
    (motion,) = swings(1)
    mean = mean_motion([motion, motion + 0.1, motion - 0.2], skeleton=ARM, window=0.0)
    assert mean.n_iter == 2
    assert len(calls) == len(motion)


def test_a_frame_stays_where_its_new_pose_would_be_worse(monkeypatch):
    monkeypatch.setattr(Barycenter, "_nearest_to_mean", lambda self, pose, group: (pose + 1.0, True))
    motions = swings(3)
    mean = mean_motion(motions, skeleton=ARM)
    assert any(np.array_equal(mean.poses, m) for m in motions)
    assert mean.objectives[0] == mean.objective


def test_the_spread_of_each_joint_is_that_of_its_positions():
    rng = np.random.default_rng(4)
    (motion,) = swings(1, seed=3)
    motions = motion + rng.normal(scale=0.2, size=(4, *motion.shape))
    mean = mean_motion(motions, skeleton=ARM, window=0.0)
    F = np.stack([reference.forward_kinematics(m, ARM) for m in motions])
    at = reference.forward_kinematics(mean.poses, ARM)
    np.testing.assert_allclose(mean.joint_std, np.sqrt(((F - at) ** 2).sum(axis=3).mean(axis=0)), rtol=1e-9)
    np.testing.assert_allclose((mean.joint_std**2).sum(axis=1), mean.std**2, rtol=1e-9)


def test_bones_keep_their_lengths_where_positions_do_not():
    skeleton = SKELETONS["humanoid"]
    motions = swings(5, skeleton=skeleton, spread=0.4)
    mean = mean_motion(motions, skeleton=skeleton)
    np.testing.assert_allclose(
        bone_lengths(mean.poses, skeleton), bone_lengths(motions[0][:1], skeleton).repeat(len(mean), axis=0), atol=1e-12
    )


def test_the_mean_is_nearer_than_any_of_the_motions():
    motions = swings(6, seed=5)
    mean = mean_motion(motions, skeleton=ARM)
    assert mean.objective < min(objective_of(m, motions, ARM) for m in motions)


def test_joints_without_weight_count_for_nothing():
    """The last joint moves at random, and its angle stays that of the motion at the start."""
    rng = np.random.default_rng(6)
    motions = [m + [0, 0, 1] * rng.normal(size=(len(m), 1)) for m in swings(4, seed=6)]
    seen = [np.delete(m, 2, axis=1) for m in motions]
    arm = ARM.with_weights([1.0, 1.0, 0.0])
    mean, expected = mean_motion(motions, skeleton=arm), mean_motion(seen, skeleton=Skeleton.chain(2))
    np.testing.assert_allclose(mean.objectives, expected.objectives, rtol=1e-9)
    np.testing.assert_allclose(mean.poses[:, :2], expected.poses, atol=1e-7)
    assert any(np.array_equal(mean.poses[:, 2], m[:, 2]) for m in motions)
    assert (mean.joint_std[:, 2] > 0.3).any()


def test_number_of_frames_and_frame_rate():
    skeleton = SKELETONS["humanoid"]
    motions = [Motion(skeleton, m, 30) for m in swings(3, skeleton=skeleton)]
    mean = mean_motion(motions)
    assert len(mean) in map(len, motions)
    assert mean.frame_rate == 30
    fine = mean_motion(motions, n_frames=2 * len(mean) - 1)
    assert len(fine) == 2 * len(mean) - 1
    assert fine.frame_rate == 60  # the same duration
    assert fine.to_motion().times[-1] == pytest.approx(mean.to_motion().times[-1])
    one = mean_motion(motions, n_frames=1)
    assert one.n_poses.tolist() == [sum(map(len, motions))]
    expected = frechet_mean(np.concatenate([m.angles for m in motions]), skeleton)
    assert one.std[0] ** 2 == pytest.approx(expected.variance, rel=1e-6)


def test_a_motion_from_arrays_needs_a_frame_rate():
    mean = mean_motion(swings(), skeleton=ARM)
    assert mean.frame_rate is None
    assert mean.to_motion(25).frame_rate == 25
    np.testing.assert_array_equal(mean.to_motion(25).angles, mean.poses)
    with pytest.raises(ValueError, match="frame_rate=, as the mean is one of arrays"):
        mean.to_motion()


def test_the_root_and_the_form_of_the_motions_do_not_matter_to_the_poses():
    skeleton = SKELETONS["humanoid"]
    arrays = swings(3, skeleton=skeleton)
    rng = np.random.default_rng(0)
    motions = [Motion(skeleton, m, 30, rng.normal(size=(len(m), 3)), rng.normal(size=(len(m), 3))) for m in arrays]
    expected = mean_motion(arrays, skeleton=skeleton)
    for given in (motions, [m.astype(np.float32).astype(float) for m in arrays]):
        mean = mean_motion(given, skeleton=skeleton)
        np.testing.assert_allclose(mean.objectives, expected.objectives, rtol=1e-5)


@pytest.mark.parametrize("metric", METRICS)
def test_threads_change_nothing(metric):
    motions = swings(3)
    one, two = (mean_motion(motions, skeleton=ARM, metric=metric, n_jobs=n) for n in (1, 2))
    np.testing.assert_array_equal(one.poses, two.poses)
    np.testing.assert_array_equal(one.objectives, two.objectives)


def test_a_window_is_kept():
    (motion,) = swings(1)
    late = np.concatenate([motion[:1].repeat(8, axis=0), motion])
    free, narrow = (mean_motion([motion, motion, late], skeleton=ARM, window=w) for w in (None, 0.1))
    assert free.objective < 1e-20
    assert narrow.objective > 0.01


def test_warns_once_where_it_did_not_converge():
    gait = make_gait(3, 1, activities=["walk"], duration=1, frame_rate=20, random_state=0)
    with pytest.warns(ConvergenceWarning, match="max_iter=1 iterations; raise max_iter") as caught:
        mean = mean_motion(gait, max_iter=1, n_frames=15)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert not mean.converged
    assert repr(mean).endswith("not converged in 1 iteration)")
    assert repr(mean_motion(gait)).startswith("MeanMotion(20 frames, y up, standard deviation 0.")
    assert isinstance(mean, MeanMotion)


def test_warns_of_degrees():
    with pytest.warns(UserWarning, match="values of motions reach"):
        mean_motion([np.degrees(m) for m in swings()], skeleton=ARM)


@pytest.mark.parametrize(
    ("given", "options", "expected"),
    [
        (swings(), {}, "mean_motion needs a skeleton to place the joints, got arrays and skeleton=None"),
        (swings()[0], {"skeleton": ARM}, "pass [motions] for one motion"),
        ([], {"skeleton": ARM}, "got none"),
        (swings(), {"skeleton": ARM, "metric": "spatial"}, "mean_motion needs means by descent"),
        (swings(), {"skeleton": ARM, "n_frames": 0}, "'n_frames' parameter of mean_motion must be an int in the range"),
        (swings(), {"skeleton": Skeleton.chain(2)}, "3 columns"),
    ],
)
def test_refuses(given, options, expected):
    with pytest.raises((ValueError, TypeError), match=re.escape(expected)):
        mean_motion(given, **options)


def test_the_mean_squat_of_hdm05(hdm05):
    """The typical squat is low in the middle, upright at both ends, and its knees bend together."""
    squats = [motion.to_rotvec().resample(12) for motion in hdm05[hdm05.actions == "squat"]]
    mean = mean_motion(squats)
    assert (np.diff(mean.objectives) <= 0).all()
    assert mean.objective < 0.7 * mean.objectives[0]
    names = mean.skeleton.joint_names
    F = forward_kinematics(mean.poses, mean.skeleton)
    legs = [np.linalg.norm(F[:, names.index(side)], axis=1) for side in ("lfoot", "rfoot")]
    np.testing.assert_allclose(*legs, atol=0.05)
    middle = len(mean) // 2
    assert legs[0][middle - 3 : middle + 3].min() < 0.75 * legs[0][0]
    assert legs[0][-1] > 0.95 * legs[0][0]
    np.testing.assert_allclose(bone_lengths(mean.poses, mean.skeleton).std(axis=0), 0.0, atol=1e-12)


def test_frames_whose_mean_does_not_converge_are_warned_of_once_and_tried_again(monkeypatch):
    found = Barycenter._nearest_to_mean
    tried = []

    def unconverged(self, pose, group):
        tried.append(len(group))
        return found(self, pose, group)[0], False

    monkeypatch.setattr(Barycenter, "_nearest_to_mean", unconverged)
    with pytest.warns(ConvergenceWarning, match=r"in \d+ of \d+ frames the mean .* did not converge") as caught:
        mean = mean_motion(swings(3), skeleton=ARM)
    assert len(caught) == 1
    assert len(tried) == len(mean) * mean.n_iter
