"""Inverse kinematics against scipy: from what it finds, no optimiser finds less."""

import numpy as np
import pytest
from conftest import random_tree
from placed import FIGURE, at_random, least_cost

from skpose import inverse_kinematics
from skpose.datasets import humanoid

N = 2
SKELETONS = {"figure": FIGURE, "tree": random_tree(1, offset_frame="parent"), "humanoid": humanoid()}


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


@pytest.mark.parametrize(("noisy", "rho"), [("figure", 0.02), ("tree", 0.0)], indirect=["noisy"])
def test_no_lower_sum_with_weights_and_an_initial_pose(noisy, rho):
    skeleton, positions = noisy
    rng = np.random.default_rng(2)
    weights = rng.uniform(0, 2, skeleton.n_joints) * (rng.uniform(size=skeleton.n_joints) > 0.2)
    options = {"weights": weights, "initial": rng.normal(0, 0.2, skeleton.n_dofs)}
    fitted = inverse_kinematics(positions, skeleton, regularization=rho, **options)
    assert_least(fitted, positions, rho=rho, **options)


@pytest.mark.parametrize(("size", "rho"), [(0.3, 0.0), (1.5, 0.02)])
@pytest.mark.slow
def test_no_lower_sum_within_limits(size, rho):
    positions = at_random(FIGURE, 2 * N, size)[1]
    fitted = inverse_kinematics(positions, FIGURE, joint_limits="enforce", regularization=rho)
    lower, upper = FIGURE.limits.T
    assert ((fitted.poses >= lower) & (fitted.poses <= upper)).all()
    assert ((fitted.poses == lower) | (fitted.poses == upper)).any()
    assert_least(fitted, positions, enforce=True, rho=rho)
