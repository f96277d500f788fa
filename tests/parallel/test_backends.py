"""Tasks on joblib's backends: each comes back once, and a dead worker is an error."""

import os
import signal
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import joblib
import numpy as np
import pytest
from conftest import random_tree

from skpose import PoseKNeighborsTransformer, pose_distances
from skpose._utils import parallel
from skpose._utils.parallel import from_workers, in_processes
from skpose.metrics import pose_distances_chunked
from skpose.neighbors import PoseRadiusNeighborsTransformer

TREE = random_tree(0)
TASKS = [(i, i + 1) for i in range(30)]
kills = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")


@contextmanager
def workers(backend):
    """Two workers, with dask those of a cluster of their own."""
    if backend != "dask":
        with joblib.parallel_config(backend=backend, n_jobs=2):
            yield
        return
    from dask.distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0") as cluster,
        Client(cluster),
        joblib.parallel_config(backend="dask"),
    ):
        yield


class Shared:
    """A payload with an array."""

    def __init__(self, size):
        self.numbers = np.arange(float(size))


def use(shared, task):
    """In which process the payload arrived, and one of its numbers."""
    return os.getpid(), float(shared.numbers[task[0]])


def fail(shared, task):
    if task[0] == 7:
        raise ArithmeticError("seven")
    return task


def note(folder, task):
    Path(folder, str(task[0])).touch()


def die(shared, task):
    os.kill(os.getpid(), signal.SIGKILL)


def test_only_processes_count_as_processes():
    assert not in_processes(2)
    for backend, n_jobs, expected in (("loky", 2, True), ("loky", 1, False), ("threading", 2, False)):
        with joblib.parallel_config(backend=backend, n_jobs=n_jobs):
            assert in_processes(None) == expected


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["loky", "multiprocessing", "dask"])
def test_tasks_and_payload(backend, tmp_path, monkeypatch):
    with workers(backend):
        returned = list(from_workers(use, Shared(200_000), TASKS, None))
        assert sorted(task for task, _ in returned) == TASKS
        assert all(number == task[0] for task, (_, number) in returned)
        assert os.getpid() not in {pid for _, (pid, _) in returned}
        with pytest.raises(ArithmeticError, match="seven"):
            list(from_workers(fail, None, TASKS, None))
        monkeypatch.setattr(parallel, "UNFINISHED", 2)
        results = iter(from_workers(note, str(tmp_path), [(i, i) for i in range(40)], None))
        next(results)
        time.sleep(1.0)
        assert len(list(tmp_path.iterdir())) <= 2 * 2 + 1  # no more start than are taken
        assert len(list(results)) == 39


@kills
@pytest.mark.slow
@pytest.mark.parametrize("backend", ["loky", "dask"])  # multiprocessing waits for dead workers
def test_workers_that_die_are_an_error(backend):
    with workers(backend), pytest.raises(Exception, match=r"worker|cancelled"):
        list(from_workers(die, None, TASKS[:3], None))


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["loky", "multiprocessing", "dask"])
def test_results_are_the_same_to_the_last_bit(backend, monkeypatch):
    sent = []

    def counted(function, shared, tasks, n_jobs):
        sent.append(len(tasks))
        return from_workers(function, shared, tasks, n_jobs)

    for module in ("skpose.metrics._matrix", "skpose.neighbors._graph"):
        monkeypatch.setattr(f"{module}.from_workers", counted)
        monkeypatch.setattr(f"{module}.WORTH_SENDING", 0)
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 64)
    X = np.cumsum(np.random.default_rng(0).normal(0, 0.1, size=(200, TREE.n_dofs)), axis=0)
    searches = [PoseKNeighborsTransformer(TREE, n_neighbors=3), PoseRadiusNeighborsTransformer(TREE, radius=1.0)]

    def compute():
        for metric in ("angle", "rotation", "spatial"):
            yield pose_distances(X, skeleton=TREE, metric=metric)
            yield pose_distances(X, X[::3] + 0.1, skeleton=TREE, metric=metric)
        chunks = pose_distances_chunked(X, X[::3] + 0.1, skeleton=TREE, working_memory=0.05)
        yield np.concatenate(list(chunks))
        for search in searches:
            yield search.fit(X).transform(X[::2] + 0.01).toarray()

    expected = list(compute())
    with workers(backend):
        for found, one in zip(compute(), expected, strict=True):
            np.testing.assert_array_equal(found, one)
    assert max(sent) > 1
