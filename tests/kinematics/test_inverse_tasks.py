"""Inverse kinematics in tasks: no pose shows where one ends, which thread or worker has it, and all can be watched."""

import joblib
import numpy as np
import pytest
from conftest import in_space

from skpose import inverse_kinematics
from skpose.datasets import make_gait
from skpose.kinematics import _inverse

TASK = 64
RESULTS = "poses", "residuals", "converged", "root_positions", "root_rotations", "n_iter"


@pytest.fixture
def small_tasks(monkeypatch):
    monkeypatch.setattr(_inverse, "TASK", TASK)
    monkeypatch.setattr(_inverse, "WARM_UP", 32)


@pytest.fixture(scope="module")
def walk():
    """Positions of a walk and its skeleton."""
    gait = make_gait(1, 1, duration=4.0, random_state=0).motions[0]
    return in_space(gait), gait.skeleton


def assert_same(one, other):
    for name in RESULTS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("alone", [False, True])
def test_threads_change_no_bit(small_tasks, walk, alone):
    positions, skeleton = walk
    noisy = positions + np.random.default_rng(0).normal(0, 0.01, positions.shape)
    options = {"initial": np.zeros((len(noisy), skeleton.n_dofs))} if alone else {"lengths": [100, 1, 139]}
    expected = inverse_kinematics(noisy, skeleton, **options)
    assert_same(inverse_kinematics(noisy, skeleton, n_jobs=2, **options), expected)


@pytest.mark.slow
def test_workers_change_no_bit(small_tasks, monkeypatch, walk):
    expected = inverse_kinematics(*walk)
    monkeypatch.setattr(_inverse, "WORTH_SENDING", 0)
    with joblib.parallel_config(backend="loky", n_jobs=2):
        assert_same(inverse_kinematics(*walk), expected)


def test_a_task_follows_the_one_before(small_tasks, monkeypatch, walk):
    """All poses are nearly those that one long task has."""
    positions, skeleton = walk
    parts = inverse_kinematics(positions, skeleton)
    monkeypatch.setattr(_inverse, "TASK", 10_000)
    whole = inverse_kinematics(positions, skeleton)
    np.testing.assert_allclose(parts.poses, whole.poses, atol=0.02)
    np.testing.assert_array_equal(parts.poses[:TASK], whole.poses[:TASK])


@pytest.mark.parametrize("name", ["right_hand", "chest"])
def test_joints_that_are_long_lost_keep_their_angles_from_task_to_task(small_tasks, monkeypatch, walk, name):
    positions, skeleton = walk
    lost = positions.copy()
    lost[50:200, skeleton.joint_names.index(name)] = np.nan
    parts = inverse_kinematics(lost, skeleton)
    monkeypatch.setattr(_inverse, "TASK", 10_000)
    whole = inverse_kinematics(lost, skeleton)
    np.testing.assert_allclose(parts.poses, whole.poses, atol=0.05)
