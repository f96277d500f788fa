"""Inverse kinematics in tasks: no pose shows where one ends, which thread or worker has it, and all can be watched."""

import joblib
import numpy as np
import pytest
from conftest import in_space
from placed import FIGURE, at_random, of

from skpose import inverse_kinematics
from skpose._parallel.backends import from_workers
from skpose.datasets import make_gait
from skpose.kinematics import _inverse, _inverse_problem

TASK = 64
RESULTS = "poses", "residuals", "converged", "root_positions", "root_rotations", "n_iter"
NOT_SEEN = pytest.mark.filterwarnings("ignore:in .* frames, first in frame:UserWarning")


@pytest.fixture
def small_tasks(monkeypatch):
    monkeypatch.setattr(_inverse_problem, "TASK", TASK)
    monkeypatch.setattr(_inverse_problem, "WARM_UP", 32)


@pytest.fixture(scope="module")
def walk():
    """Positions of a walk and its skeleton."""
    gait = make_gait(1, 1, duration=4.0, random_state=0).motions[0]
    return in_space(gait), gait.skeleton


def assert_same(one, other):
    for name in RESULTS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("n_jobs", [2, -1, 5])
@pytest.mark.parametrize("alone", [False, True])
def test_threads_change_no_bit(small_tasks, walk, n_jobs, alone):
    positions, skeleton = walk
    noisy = positions + np.random.default_rng(0).normal(0, 0.01, positions.shape)
    options = {"initial": np.zeros((len(noisy), skeleton.n_dofs))} if alone else {"lengths": [100, 1, 139]}
    expected = inverse_kinematics(noisy, skeleton, **options)
    assert_same(inverse_kinematics(noisy, skeleton, n_jobs=n_jobs, **options), expected)


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["loky", "dask"])
def test_workers_change_no_bit(small_tasks, monkeypatch, walk, backend):
    positions, skeleton = walk
    sent = []

    def counted(function, shared, tasks, n_jobs):
        sent.append(len(tasks))
        return from_workers(function, shared, tasks, n_jobs)

    expected = inverse_kinematics(positions, skeleton)
    monkeypatch.setattr(_inverse, "WORTH_SENDING", 0)
    monkeypatch.setattr(_inverse, "from_workers", counted)
    if backend == "loky":
        with joblib.parallel_config(backend="loky", n_jobs=2):
            found = inverse_kinematics(positions, skeleton)
    else:
        from dask.distributed import Client, LocalCluster

        cluster = LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0")
        with cluster, Client(cluster), joblib.parallel_config(backend="dask"):
            found = inverse_kinematics(positions, skeleton)
    assert sent == [4]
    assert_same(found, expected)


def test_a_task_follows_the_one_before(small_tasks, monkeypatch, walk):
    """All poses are nearly those that one long task has."""
    positions, skeleton = walk
    parts = inverse_kinematics(positions, skeleton)
    monkeypatch.setattr(_inverse_problem, "TASK", 10_000)
    whole = inverse_kinematics(positions, skeleton)
    np.testing.assert_allclose(parts.poses, whole.poses, atol=0.02)
    np.testing.assert_array_equal(parts.poses[:TASK], whole.poses[:TASK])


@pytest.mark.parametrize("name", ["right_hand", "left_thigh", "chest"])
def test_joints_that_are_long_lost_keep_their_angles_from_task_to_task(small_tasks, monkeypatch, walk, name):
    positions, skeleton = walk
    lost = positions.copy()
    lost[50:200, skeleton.joint_names.index(name)] = np.nan
    parts = inverse_kinematics(lost, skeleton)
    monkeypatch.setattr(_inverse_problem, "TASK", 10_000)
    whole = inverse_kinematics(lost, skeleton)
    np.testing.assert_allclose(parts.poses, whole.poses, atol=0.05)


@NOT_SEEN
def test_where_nothing_is_seen_the_pose_is_held_from_task_to_task(small_tasks, walk):
    positions, skeleton = walk
    lost = positions.copy()
    lost[60:180] = np.nan
    fitted = inverse_kinematics(lost, skeleton)
    for values in (fitted.poses, fitted.root_positions, fitted.root_rotations):
        np.testing.assert_array_equal(values[60:180], np.tile(values[59], (120, 1)))
    seen = np.r_[:60, 180:240]
    np.testing.assert_allclose(of(fitted)[seen], positions[seen], atol=1e-6)


@pytest.mark.parametrize("verbose", [0, 1])
def test_progress_is_shown_if_requested(small_tasks, capsys, walk, verbose):
    inverse_kinematics(*walk, verbose=verbose)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert ("Inverse kinematics" in captured.err) == bool(verbose)


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_an_interrupt_ends_the_work_between_tasks(small_tasks, monkeypatch, walk, n_jobs):
    solve, started = _inverse_problem.Problem.solve, []

    def interrupted(self, task):
        started.append(task)
        if len(started) == 2:
            raise KeyboardInterrupt
        return solve(self, task)

    positions, skeleton = np.concatenate([walk[0]] * 4), walk[1]
    monkeypatch.setattr(_inverse_problem.Problem, "solve", interrupted)
    with pytest.raises(KeyboardInterrupt):
        inverse_kinematics(positions, skeleton, n_jobs=n_jobs)
    assert len(started) <= 1 + n_jobs < len(positions) / TASK


def test_the_frames_before_a_task_are_few(walk):
    """However long ago a joint was seen."""
    positions = np.tile(at_random(FIGURE, 1)[1], (4000, 1, 1))
    positions[40:, 3] = positions[1000:, 5] = np.nan
    problem = _inverse_problem.problem_of(positions, FIGURE, None, None, [3500, 500], "ignore", 0.0)
    tasks = list(problem.tasks())
    frames = [problem.warm_up(task).tolist() for task in tasks]
    assert [task.last for task in tasks] == [*range(512, 3500, 512), 3500, 4000]
    assert frames[0] == frames[-1] == []
    assert frames[6] == [*range(8, 40), *range(968, 1000), *range(3040, 3072)]
