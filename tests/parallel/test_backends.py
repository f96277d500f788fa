"""Tasks on joblib's backends: all come back once, the payload is sent once, a dead worker changes nothing."""

import concurrent.futures
import os
import signal
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import joblib
import numpy as np
import pytest
from conftest import SKELETONS, random_tree

from skpose import (
    PoseKNeighborsTransformer,
    PoseRadiusNeighborsTransformer,
    SpatialMDS,
    pose_distances,
    pose_distances_chunked,
)
from skpose._parallel import backends
from skpose._parallel.backends import BackendError, from_workers, in_processes
from skpose._parallel.progress import report_to
from skpose.metrics import Spatial
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._registry import METRICS

TREE = random_tree(0)
TASKS = [(i, i + 1) for i in range(30)]
IN_SEARCHES = [name for name, metric in METRICS.items() if metric().lower_bound() is not None]
slow = pytest.mark.slow
kills = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")


@contextmanager
def dask_cluster():
    """Start a scheduler and two worker processes on this machine."""
    from dask.distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster,
        Client(cluster) as client,
    ):
        yield client


@pytest.fixture(scope="module")
def client():
    with dask_cluster() as client:
        yield client


@pytest.fixture(params=["loky", pytest.param("multiprocessing", marks=slow), pytest.param("dask", marks=slow)])
def processes(request):
    """joblib's configuration for two workers."""
    if request.param == "dask":
        request.getfixturevalue("client")
    with joblib.parallel_config(backend=request.param, n_jobs=None if request.param == "dask" else 2):
        yield


@pytest.fixture(params=["loky", "dask"])  # multiprocessing waits for dead workers
def mortal_processes(request):
    """The same, with workers that no other test uses, so that they can be killed."""
    if request.param == "loky":
        with joblib.parallel_config(backend="loky", n_jobs=2):
            yield
    else:
        with dask_cluster(), joblib.parallel_config(backend="dask"):
            yield


@pytest.fixture
def small_tasks(monkeypatch):
    """Even little work goes to the workers, in many tasks; that some did is a part of the test."""
    sent = []

    def counted(function, shared, tasks, n_jobs):
        sent.append(len(tasks))
        return from_workers(function, shared, tasks, n_jobs)

    for module in ("skpose.metrics._tiled", "skpose.neighbors._queries"):
        monkeypatch.setattr(f"{module}.from_workers", counted)
        monkeypatch.setattr(f"{module}.WORTH_SENDING", 0)
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 64)
    yield
    assert max(sent) > 1


@pytest.fixture(scope="module")
def X():
    rng = np.random.default_rng(0)
    return np.cumsum(rng.normal(0, 0.1, size=(200, TREE.n_dofs)), axis=0)


class Shared:
    """A payload with an array."""

    def __init__(self, size):
        self.numbers = np.arange(float(size))


def use(shared, task):
    """Return in which process the payload arrived, as which object there, and one of its numbers."""
    return os.getpid(), id(shared), float(shared.numbers[task[0]])


def fail(shared, task):
    if task[0] == 7:
        raise ArithmeticError("seven")
    return task


def die_once(folder, task):
    """Kill the process that runs this, unless one was killed before."""
    try:
        Path(folder, "dead").touch(exist_ok=False)
    except FileExistsError:
        time.sleep(0.05)
        return task[0]
    return os.kill(os.getpid(), signal.SIGKILL)


def die(shared, task):
    os.kill(os.getpid(), signal.SIGKILL)


def test_only_processes_count_as_processes(processes):
    assert in_processes(None)
    with joblib.parallel_config(backend="threading", n_jobs=2):
        assert not in_processes(None)


def test_without_a_configuration_there_are_only_threads():
    assert not in_processes(2)
    with joblib.parallel_config(backend="loky", n_jobs=1):
        assert not in_processes(None)
        assert in_processes(2)


def test_each_task_comes_back_once_and_the_payload_arrives_once(processes):
    check_that_each_comes_once()


@slow
def test_each_task_comes_back_once_from_dask(client):
    """`client` is the default of joblib's dask backend."""
    with joblib.parallel_config(backend="dask"):
        check_that_each_comes_once()


def check_that_each_comes_once():
    returned = list(from_workers(use, Shared(100_000), TASKS, None))
    assert sorted(task for task, _ in returned) == TASKS
    assert all(number == task[0] for task, (_, _, number) in returned)
    arrived = {(pid, address) for _, (pid, address, _) in returned}
    assert len(arrived) == len({pid for pid, _ in arrived}) <= 2
    assert os.getpid() not in {pid for pid, _ in arrived}


def test_an_error_of_a_task_is_raised_unchanged(processes):
    with pytest.raises(ArithmeticError, match="seven"):
        list(from_workers(fail, None, TASKS, None))


@kills
@slow
def test_tasks_of_a_worker_that_dies_are_run_again(mortal_processes, tmp_path):
    returned = dict(from_workers(die_once, str(tmp_path), TASKS, None))
    assert (tmp_path / "dead").exists()
    assert returned == {task: task[0] for task in TASKS}


@kills
@slow
def test_tasks_that_kill_every_worker_are_an_error_and_no_endless_wait(mortal_processes):
    with pytest.raises(BackendError, match="3 tasks did not come back from joblib's workers in 3 attempts"):
        list(from_workers(die, None, TASKS[:3], None))


def test_no_more_tasks_start_than_are_taken(processes, tmp_path, monkeypatch):
    monkeypatch.setattr(backends, "UNFINISHED", 2)
    results = iter(from_workers(note, str(tmp_path), [(i, i) for i in range(40)], None))
    next(results)
    time.sleep(1.0)
    assert len(list(tmp_path.iterdir())) <= 2 * 2 + 1
    assert len(list(results)) == 39


def note(folder, task):
    Path(folder, str(task[0])).touch()


def work_without_threads(matrix, tile):
    def refuse(*_):
        raise RuntimeError("a worker started threads of its own")

    before, concurrent.futures.ThreadPoolExecutor.submit = concurrent.futures.ThreadPoolExecutor.submit, refuse
    try:
        return matrix.distances(tile)[0].sum()
    finally:
        concurrent.futures.ThreadPoolExecutor.submit = before


@pytest.mark.parametrize("processes", ["loky"], indirect=True)
def test_workers_start_no_threads(processes, X):
    matrix = DistanceMatrix(X, None, Spatial(), TREE)
    (total,) = dict(from_workers(work_without_threads, matrix, matrix.tiling(1).tiles(), None)).values()
    assert total == pose_distances(X, skeleton=TREE).sum()


def for_geodesics(metric, skeleton, X, n):
    """Return the skeleton and the poses, fewer and of a small skeleton for geodesics."""
    return (SKELETONS["chain"], X[:n, :4]) if metric == "geodesic" else (skeleton, X)


@pytest.mark.parametrize("metric", METRICS)
def test_matrices_are_the_same_to_the_last_bit(processes, small_tasks, X, metric, monkeypatch):
    skeleton, X = for_geodesics(metric, TREE, X, 40)
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 16 if metric == "geodesic" else 64)
    for options in ({}, {"Y": X[::3] + 0.1}):
        parameters = {"skeleton": skeleton, "metric": metric, **options}
        with joblib.parallel_config(backend="threading", n_jobs=1):
            expected = pose_distances(X, **parameters)
        np.testing.assert_array_equal(pose_distances(X, **parameters), expected)
    chunks = pose_distances_chunked(X, X[::3] + 0.1, skeleton=skeleton, metric=metric, working_memory=0.05)
    np.testing.assert_array_equal(np.concatenate(list(chunks)), expected)


@pytest.mark.parametrize("metric", IN_SEARCHES)
def test_graphs_are_the_same_to_the_last_bit(processes, small_tasks, X, metric):
    poses = X[:70] if metric == "geodesic" else X
    queries = poses[::2] + 0.01
    for transformer in (
        PoseKNeighborsTransformer(TREE, metric=metric, n_neighbors=3),
        PoseRadiusNeighborsTransformer(TREE, metric=metric, radius=1.0),
    ):
        graph = transformer.fit(poses).transform(queries)
        with joblib.parallel_config(backend="threading", n_jobs=1):
            expected = transformer.transform(queries)
        assert graph.nnz > len(queries)
        for part in ("data", "indices", "indptr"):
            np.testing.assert_array_equal(getattr(graph, part), getattr(expected, part))


def test_landmarks_give_the_same_coordinates(processes, small_tasks, X):
    mds = SpatialMDS(TREE, n_components=2, landmarks=20, random_state=0)
    found = mds.fit_transform(X)
    with joblib.parallel_config(backend="threading", n_jobs=1):
        np.testing.assert_array_equal(mds.fit_transform(X), found)


@kills
@slow
@pytest.mark.parametrize("what", ["matrix", "graph"])
def test_a_dask_worker_killed_in_the_middle_changes_nothing(small_tasks, X, what):
    def work():
        if what == "matrix":
            return pose_distances(X, skeleton=TREE)
        return PoseKNeighborsTransformer(TREE, n_neighbors=3).fit(X).transform(X).toarray()

    expected = work()
    n_done = 0
    with dask_cluster() as client:

        @contextmanager
        def reporter(_, n_steps):
            def advance():
                nonlocal n_done
                n_done += 1
                if n_done == 2:
                    os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)

            assert n_steps >= 4
            yield advance

        with joblib.parallel_config(backend="dask"), report_to(reporter):
            found = work()
    assert n_done >= 4
    np.testing.assert_array_equal(found, expected)
