"""Inverse kinematics where joints are not seen: what stays open, and where it goes."""

import numpy as np
import pytest
from conftest import in_space
from placed import FIGURE, at_random, of

from skpose import Bone, Skeleton, forward_kinematics, inverse_kinematics
from skpose.datasets import make_gait

ELBOW, WRIST, FINGER = (FIGURE.joint_names.index(name) for name in ("elbow", "wrist", "finger"))
BODY = [Bone("hip", None, (0.3, 0, 0)), Bone("back", None, (0, 0, 0.3)), Bone("neck", None, (0, 0.3, 0))]
ARM = Skeleton([*BODY, Bone("elbow", None, (0, -0.3, 0), "rotvec"), Bone("wrist", "elbow", (0, -0.25, 0), "rotvec")])


@pytest.fixture
def noisy():
    positions = at_random(FIGURE, 6)[1]
    return positions + np.random.default_rng(1).normal(0, 0.03, positions.shape)


@pytest.fixture(scope="module")
def walk():
    """Positions of a walk and its skeleton."""
    gait = make_gait(1, 1, duration=2.5, random_state=0).motions[0]
    return in_space(gait), gait.skeleton


def test_weight_zero_is_not_seen(noisy):
    lost, weights = noisy.copy(), np.ones(noisy.shape[:2])
    lost[2:4, 5], weights[2:4, 5] = np.nan, 0.0
    lost[1, 3, 1], weights[1, 3] = np.nan, 0.0  # one coordinate is enough
    one, other = inverse_kinematics(lost, FIGURE), inverse_kinematics(noisy, FIGURE, weights=weights)
    for name in ("poses", "residuals", "root_positions", "root_rotations"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    np.testing.assert_array_equal(np.isnan(one.residuals), weights == 0.0)


def test_regularization_is_as_heavy_as_distances(noisy):
    """Four times the weight, and twice ρ, are the same sum."""
    one = inverse_kinematics(noisy, FIGURE, regularization=0.1)
    other = inverse_kinematics(noisy, FIGURE, regularization=0.2, weights=np.full(FIGURE.n_joints, 4.0))
    np.testing.assert_allclose(other.poses, one.poses, atol=1e-9)
    assert np.abs(one.poses - inverse_kinematics(noisy, FIGURE).poses).max() > 0.01


def test_a_joint_that_is_never_seen_keeps_the_initial_angles():
    positions = at_random(FIGURE, 5)[1]
    positions[:, FINGER] = np.nan
    columns = [FIGURE.dof_names.index(name) for name in ("finger_ry", "finger_rz")]
    initial = np.zeros(FIGURE.n_dofs)
    initial[columns] = 0.3, -0.4
    fitted = inverse_kinematics(positions, FIGURE, initial=initial)
    np.testing.assert_allclose(fitted.poses[:, columns], [[0.3, -0.4]] * 5, atol=1e-9)
    assert np.nanmax(fitted.residuals) < 1e-6


def test_a_lost_joint_keeps_the_angles_of_the_frame_before(walk):
    positions, skeleton = walk
    lost = positions.copy()
    hand = skeleton.joint_names.index("left_hand")
    lost[60:90, hand] = np.nan
    columns = [i for i, name in enumerate(skeleton.dof_names) if name.startswith("left_hand")]
    fitted = inverse_kinematics(lost, skeleton)
    np.testing.assert_allclose(fitted.poses[60:90, columns], fitted.poses[[59] * 30][:, columns], atol=1e-9)
    assert fitted.converged.all()
    np.testing.assert_allclose(np.delete(of(fitted) - positions, hand, axis=1), 0, atol=1e-6)


def test_frames_in_which_nothing_is_seen_have_the_pose_before(walk):
    positions, skeleton = walk
    lost = positions[:30].copy()
    lost[:3] = lost[10:14] = lost[28:] = np.nan
    with pytest.warns(UserWarning, match="in 9 of 30 frames"):
        fitted = inverse_kinematics(lost, skeleton)
    seen = ~np.isnan(lost).all(axis=(1, 2))
    np.testing.assert_array_equal(fitted.converged, seen)
    np.testing.assert_array_equal(fitted.n_iter > 0, seen)
    for before, gap in ((9, slice(10, 14)), (27, slice(28, 30))):
        for values in (fitted.poses, fitted.root_positions, fitted.root_rotations):
            np.testing.assert_array_equal(values[gap], np.broadcast_to(values[before], values[gap].shape))
    np.testing.assert_allclose(fitted.poses[:3], 0, atol=1e-12)
    np.testing.assert_allclose(of(fitted)[seen], positions[:30][seen], atol=1e-6)


def test_twists_do_not_drift():
    """An arm circles twenty times; only a rotation vector that is off its plane has a twist."""
    t = np.linspace(0, 20 * 2 * np.pi, 1200)
    path = np.stack([0.7 * np.cos(t), 0.9 * np.sin(t), np.zeros(len(t))], axis=1)
    path[:, 1] += 0.3
    poses = np.concatenate([path, 0.3 * path], axis=1)
    positions = forward_kinematics(poses, ARM)
    fitted = inverse_kinematics(positions, ARM)
    assert np.abs(fitted.poses[:, 4]).max() < 0.5  # of the wrist about its bone
    period = 60
    late, later = fitted.poses[300:900], fitted.poses[300 + 5 * period : 900 + 5 * period]
    assert np.abs(late).max() > 0.1
    np.testing.assert_allclose(np.abs(late).max(axis=0), np.abs(later).max(axis=0), atol=0.05)
