"""Means of motions: what they are on motions whose mean is known, and what holds for all."""

import numpy as np
import pytest
import reference
from conftest import SKELETONS
from sklearn.exceptions import ConvergenceWarning

from skpose import Motion, Skeleton, forward_kinematics, pose_distances
from skpose.datasets import make_gait
from skpose.geodesics import frechet_mean
from skpose.motions import MeanMotion, mean_motion

ARM = Skeleton.chain(3)


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


def objective_of(poses, motions, skeleton):
    costs = [pose_distances(poses, motion, skeleton=skeleton, metric="position") ** 2 for motion in motions]
    return sum(map(reference.least_sum, costs))


def bone_lengths(poses, skeleton):
    positions = reference.forward_kinematics(poses, skeleton)
    near = np.concatenate([positions, np.zeros_like(positions[:, :1])], axis=1)[:, skeleton.parents]
    return np.linalg.norm(positions - near, axis=-1)


def test_a_single_motion_is_its_own_mean():
    (motion,) = swings(1)
    mean = mean_motion([motion], skeleton=ARM)
    np.testing.assert_array_equal(mean.poses, motion)
    assert mean.converged
    assert mean.objective == 0.0
    assert not mean.std.any()
    np.testing.assert_array_equal(mean.n_poses, 1)


def test_copies_warped_in_time_have_the_motion_as_their_mean():
    (motion,) = swings(1, seed=1)
    rng = np.random.default_rng(0)
    copies = [np.repeat(motion, rng.integers(1, 4, len(motion)), axis=0) for _ in range(3)]
    mean = mean_motion([motion, *copies], skeleton=ARM)
    assert mean.objective < 1e-20
    assert len(np.unique(mean.poses.round(9), axis=0)) == len(motion)
    assert mean.joint_std.max() < 1e-9


@pytest.mark.parametrize("name", ["mixed joints", "weights"])
def test_the_objective_is_the_sum_of_best_paths_and_never_rises(name):
    skeleton = SKELETONS[name]
    motions = swings(3, seed=2, skeleton=skeleton, spread=0.3, least=5)
    mean = mean_motion(motions, skeleton=skeleton, tol=0.0)
    assert mean.n_iter > 1
    assert (np.diff(mean.objectives) <= 0).all()
    assert mean.objective < 0.95 * mean.objectives[0]
    np.testing.assert_allclose(mean.objective, objective_of(mean.poses, motions, skeleton), rtol=1e-9)
    np.testing.assert_allclose((mean.std**2 * mean.n_poses).sum(), mean.objective, rtol=1e-12)


def test_each_frame_is_the_frechet_mean_of_equal_frames():
    """With a window of zero all frames i of equal lengths are aligned, and no others."""
    rng = np.random.default_rng(3)
    (motion,) = swings(1, seed=3)
    motions = motion + rng.normal(scale=0.2, size=(4, *motion.shape))
    mean = mean_motion(motions, skeleton=ARM, window=0.0)
    assert mean.n_iter == 2  # of which the second finds nothing to change
    np.testing.assert_array_equal(mean.n_poses, 4)
    for frame in range(len(motion)):
        expected = frechet_mean(motions[:, frame], ARM)
        np.testing.assert_allclose(mean.std[frame] ** 2, expected.variance, rtol=1e-4)
        distance = pose_distances(mean.poses[[frame]], expected.pose[None], skeleton=ARM, metric="position")
        assert distance[0, 0] < 1e-7


def test_bones_keep_their_lengths_where_positions_do_not():
    skeleton = SKELETONS["humanoid"]
    motions = swings(5, skeleton=skeleton, spread=0.4)
    mean = mean_motion(motions, skeleton=skeleton)
    np.testing.assert_allclose(
        bone_lengths(mean.poses, skeleton), bone_lengths(motions[0][:1], skeleton).repeat(len(mean), axis=0), atol=1e-12
    )


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


def test_threads_change_nothing():
    motions = swings(3)
    one, two = (mean_motion(motions, skeleton=ARM, n_jobs=n) for n in (1, 2))
    np.testing.assert_array_equal(one.poses, two.poses)
    np.testing.assert_array_equal(one.objectives, two.objectives)


def test_warns_once_where_it_did_not_converge():
    gait = make_gait(3, 1, activities=["walk"], duration=1, frame_rate=20, random_state=0)
    with pytest.warns(ConvergenceWarning, match="max_iter=1") as caught:
        mean = mean_motion(gait, max_iter=1, n_frames=15)
    assert len(caught) == 1
    assert caught[0].filename == __file__
    assert not mean.converged
    assert repr(mean).endswith("not converged in 1 iterations)")
    assert repr(mean_motion(gait)).startswith("MeanMotion(20 frames, y up, standard deviation 0.")
    assert isinstance(mean, MeanMotion)


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
