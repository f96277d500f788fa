"""Inverse kinematics against scipy: from what it finds, no optimiser finds less."""

import numpy as np
import pytest
import reference
from conftest import in_turns, random_tree
from placed import FIGURE, at_random, least_cost, of
from scipy.spatial.transform import Rotation

from skpose import inverse_kinematics
from skpose.datasets import humanoid

N = 4
SKELETONS = {"figure": FIGURE, "tree": random_tree(1, offset_frame="parent"), "humanoid": humanoid()}
RHO = [0.0, 0.02]
NOISY_AND_RHO = pytest.mark.parametrize(("noisy", "rho"), in_turns(list(SKELETONS), RHO), indirect=["noisy"])


@pytest.fixture(params=SKELETONS)
def noisy(request):
    """A skeleton, and noisy positions of its poses."""
    skeleton = SKELETONS[request.param]
    positions = at_random(skeleton, N)[1]
    return skeleton, positions + np.random.default_rng(1).normal(0, 0.03, positions.shape)


def assert_least(fitted, positions, **options):
    assert fitted.converged.all()
    for i in range(len(fitted)):
        cost, least = least_cost(fitted, i, positions[i], **options)
        assert cost <= least * (1 + 1e-8) + 1e-16


@NOISY_AND_RHO
def test_no_lower_sum_at_noisy_positions(noisy, rho):
    skeleton, positions = noisy
    assert_least(inverse_kinematics(positions, skeleton, regularization=rho), positions, rho=rho)


@NOISY_AND_RHO
def test_no_lower_sum_with_weights_and_an_initial_pose(noisy, rho):
    skeleton, positions = noisy
    rng = np.random.default_rng(2)
    weights = rng.uniform(0, 2, skeleton.n_joints) * (rng.uniform(size=skeleton.n_joints) > 0.2)
    options = {"weights": weights, "initial": rng.normal(0, 0.2, skeleton.n_dofs)}
    fitted = inverse_kinematics(positions, skeleton, regularization=rho, **options)
    assert_least(fitted, positions, rho=rho, **options)


def test_no_lower_sum_where_bones_have_other_lengths():
    positions = at_random(humanoid(1.9), N, size=0.4)[1] * np.array([1.0, 0.9, 1.1])
    fitted = inverse_kinematics(positions, humanoid(1.6))
    assert np.median(fitted.residuals) > 0.01
    assert_least(fitted, positions)


@pytest.mark.parametrize(("size", "rho"), in_turns([0.3, 1.5], RHO))
def test_no_lower_sum_within_limits(size, rho):
    positions = at_random(FIGURE, 2 * N, size)[1]
    fitted = inverse_kinematics(positions, FIGURE, joint_limits="enforce", regularization=rho)
    lower, upper = FIGURE.limits.T
    assert ((fitted.poses >= lower) & (fitted.poses <= upper)).all()
    assert ((fitted.poses == lower) | (fitted.poses == upper)).any()
    assert_least(fitted, positions, enforce=True, rho=rho)


def test_limits_change_nothing_where_they_are_kept():
    poses = np.clip(at_random(FIGURE, N)[0], FIGURE.limits[:, 0] + 0.1, FIGURE.limits[:, 1] - 0.1)
    positions = reference.forward_kinematics(poses, FIGURE)
    fitted = inverse_kinematics(positions, FIGURE, joint_limits="enforce")
    np.testing.assert_allclose(of(fitted), positions, atol=1e-6)


def test_the_sum_is_stationary(noisy):
    """The forces and the moments of the distances balance about the root, and at a ball joint below it."""
    skeleton, positions = noisy
    fitted = inverse_kinematics(positions, skeleton)
    forces = of(fitted) - positions
    np.testing.assert_allclose(forces.sum(axis=1), 0, atol=1e-6)
    np.testing.assert_allclose(np.cross(of(fitted), forces).sum(axis=1), 0, atol=1e-5)


def test_movements_of_the_world_move_the_root_only(noisy):
    skeleton, positions = noisy
    turn, shift = Rotation.from_rotvec([0.3, -0.4, 0.5]), np.array([1.0, 2.0, -3.0])
    fitted = inverse_kinematics(positions, skeleton)
    moved = inverse_kinematics(turn.apply(positions.reshape(-1, 3)).reshape(positions.shape) + shift, skeleton)
    np.testing.assert_allclose(moved.residuals, fitted.residuals, atol=1e-5)
    expected = turn.apply(of(fitted).reshape(-1, 3)).reshape(positions.shape) + shift
    np.testing.assert_allclose(of(moved), expected, atol=1e-4)
