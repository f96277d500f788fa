"""Blocks on joblib's engines: all come back once, what they share is shipped once, a dead worker loses nothing."""

import concurrent.futures
import os
import signal
import subprocess
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
from skpose._compiled.tree import Steps
from skpose._parallel import backends as engine
from skpose._parallel.backends import EngineError, from_workers, in_processes
from skpose._parallel.progress import heard_by
from skpose.metrics._matrix import DistanceMatrix

BODY = random_tree(0)
BLOCKS = [(i, i + 1) for i in range(30)]


@contextmanager
def dask_cluster():
    """A scheduler and two worker processes on this machine, as they are elsewhere on many."""
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


@pytest.fixture(params=["loky", "multiprocessing", "dask"])
def processes(request):
    """joblib's configuration for two workers."""
    if request.param == "dask":
        request.getfixturevalue("client")
    with joblib.parallel_config(backend=request.param, n_jobs=None if request.param == "dask" else 2):
        yield


@pytest.fixture(params=["loky", "dask"])  # multiprocessing waits for the dead
def mortal_processes(request):
    """The same, with workers of one's own to kill: some never come back."""
    if request.param == "loky":
        with joblib.parallel_config(backend="loky", n_jobs=2):
            yield
    else:
        with dask_cluster(), joblib.parallel_config(backend="dask"):
            yield


@pytest.fixture
def small_blocks(monkeypatch):
    """Even little work goes to the workers, in many blocks; that some did is a part of the test."""
    sent = []

    def counted(function, shared, blocks, n_jobs):
        sent.append(len(blocks))
        return from_workers(function, shared, blocks, n_jobs)

    monkeypatch.setattr("skpose.metrics._pairwise.from_workers", counted)
    monkeypatch.setattr("skpose.neighbors._queries.from_workers", counted)
    monkeypatch.setattr("skpose.metrics._pairwise.WORTH_SHIPPING", 0)
    monkeypatch.setattr("skpose.neighbors._queries.WORTH_SHIPPING", 0)
    monkeypatch.setattr("skpose.metrics._matrix.PANEL", 64)
    yield
    assert max(sent) > 1


@pytest.fixture(scope="module")
def X():
    rng = np.random.default_rng(0)
    return np.cumsum(rng.normal(0, 0.1, size=(200, BODY.n_dofs)), axis=0)


class Shared:
    """Tells in which process, and there as which object, it arrived."""

    def __init__(self, size):
        self.numbers = np.arange(float(size))


def use(shared, block):
    return os.getpid(), id(shared), float(shared.numbers[block[0]])


def fail(shared, block):
    if block[0] == 7:
        raise ArithmeticError("seven")
    return block


def die_once(folder, block):
    """Kills its process, with whatever else that is doing, unless somebody has died before."""
    try:
        Path(folder, "dead").touch(exist_ok=False)
    except FileExistsError:
        time.sleep(0.05)
        return block[0]
    return os.kill(os.getpid(), signal.SIGKILL)


def die(shared, block):
    os.kill(os.getpid(), signal.SIGKILL)


def test_only_processes_are_asked_for(processes):
    assert in_processes(None)
    with joblib.parallel_config(backend="threading", n_jobs=2):
        assert not in_processes(None)


def test_without_a_configuration_there_are_only_threads():
    assert not in_processes(2)
    with joblib.parallel_config(backend="loky", n_jobs=1):
        assert not in_processes(None)
        assert in_processes(2)


def test_each_block_comes_back_once_and_what_is_shared_arrives_once(processes):
    returned = list(from_workers(use, Shared(100_000), BLOCKS, None))
    assert sorted(block for block, _ in returned) == BLOCKS
    assert all(number == block[0] for block, (_, _, number) in returned)
    arrived = {(pid, place) for _, (pid, place, _) in returned}
    assert len(arrived) == len({pid for pid, _ in arrived}) <= 2
    assert os.getpid() not in {pid for pid, _ in arrived}


def test_an_error_of_the_work_is_raised_as_it_is(processes):
    with pytest.raises(ArithmeticError, match="seven"):
        list(from_workers(fail, None, BLOCKS, None))


def test_a_worker_that_dies_loses_nothing(mortal_processes, tmp_path):
    returned = dict(from_workers(die_once, str(tmp_path), BLOCKS, None))
    assert (tmp_path / "dead").exists()
    assert returned == {block: block[0] for block in BLOCKS}


def test_blocks_that_kill_every_worker_are_an_error_and_no_endless_wait(mortal_processes):
    with pytest.raises(EngineError, match="3 blocks did not come back from joblib's workers in 3 attempts"):
        list(from_workers(die, None, BLOCKS[:3], None))


def test_no_more_blocks_are_begun_than_are_taken(processes, tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "UNDER_WAY", 2)
    blocks = iter(from_workers(note, str(tmp_path), [(i, i) for i in range(40)], None))
    next(blocks)
    time.sleep(1.0)
    assert len(list(tmp_path.iterdir())) <= 2 * 2 + 1
    assert len(list(blocks)) == 39


def note(folder, block):
    Path(folder, str(block[0])).touch()


def work_without_threads(matrix, block):
    def refuse(*_):
        raise RuntimeError("a worker began threads of its own")

    before, concurrent.futures.ThreadPoolExecutor.submit = concurrent.futures.ThreadPoolExecutor.submit, refuse
    try:
        return matrix.distances(block)[0].sum()
    finally:
        concurrent.futures.ThreadPoolExecutor.submit = before


@pytest.mark.parametrize("processes", ["loky"], indirect=True)
def test_workers_begin_no_threads(processes, X):
    matrix = DistanceMatrix(X, None, "spatial", BODY, Steps.of(10, wrap=True), X.dtype)
    (total,) = dict(from_workers(work_without_threads, matrix, matrix.blocks(4096), None)).values()
    assert total == pose_distances(X, skeleton=BODY).sum()


@pytest.mark.parametrize("metric", ["position", "spatial"])
def test_matrices_are_the_same_to_the_last_bit(processes, small_blocks, X, metric):
    for options in ({}, {"Y": X[::3] + 0.1}):
        parameters = {"skeleton": BODY, "metric": metric, **options}
        with joblib.parallel_config(backend="threading", n_jobs=1):
            expected = pose_distances(X, **parameters)
        np.testing.assert_array_equal(pose_distances(X, **parameters), expected)
        chunks = pose_distances_chunked(X, options.get("Y", X[::3]), skeleton=BODY, metric=metric, working_memory=0.05)
        whole = pose_distances(X, options.get("Y", X[::3]), skeleton=BODY, metric=metric)
        np.testing.assert_array_equal(np.concatenate(list(chunks)), whole)


@pytest.mark.parametrize("processes", ["dask"], indirect=True)
def test_geodesics_are_the_same_to_the_last_bit(processes, small_blocks, X):
    parameters = {"skeleton": SKELETONS["chain"], "metric": "geodesic"}
    poses = X[:40, :4]
    with joblib.parallel_config(backend="threading", n_jobs=1):
        expected = pose_distances(poses, **parameters)
    np.testing.assert_array_equal(pose_distances(poses, **parameters), expected)


@pytest.mark.parametrize("metric", ["spatial", "geodesic"])
def test_graphs_are_the_same_to_the_last_bit(processes, small_blocks, X, metric):
    poses = X if metric == "spatial" else X[:70]
    queries = poses[::2] + 0.01
    for transformer in (
        PoseKNeighborsTransformer(BODY, metric=metric, n_neighbors=3),
        PoseRadiusNeighborsTransformer(BODY, metric=metric, radius=1.0),
    ):
        transformer.fit(poses)
        graph, evaluations = transformer.transform(queries), transformer.n_evaluations_
        with joblib.parallel_config(backend="threading", n_jobs=1):
            expected = transformer.transform(queries)
        assert graph.nnz > len(queries)
        for part in ("data", "indices", "indptr"):
            np.testing.assert_array_equal(getattr(graph, part), getattr(expected, part))
        assert sum(evaluations) > 0


def test_landmarks_place_poses_alike(processes, small_blocks, X):
    mds = SpatialMDS(2, skeleton=BODY, landmarks=20, random_state=0)
    there = mds.fit_transform(X)
    with joblib.parallel_config(backend="threading", n_jobs=1):
        np.testing.assert_array_equal(mds.fit_transform(X), there)


@pytest.mark.parametrize("what", ["matrix", "graph"])
def test_a_dask_worker_killed_in_the_middle_changes_nothing(small_blocks, X, what):
    def work():
        if what == "matrix":
            return pose_distances(X, skeleton=BODY)
        return PoseKNeighborsTransformer(BODY, n_neighbors=3).fit(X).transform(X).toarray()

    expected = work()
    n_done = 0
    with dask_cluster() as client:

        @contextmanager
        def listener(_, n_steps):
            def advance():
                nonlocal n_done
                n_done += 1
                if n_done == 2:
                    os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)

            assert n_steps >= 4
            yield advance

        with joblib.parallel_config(backend="dask"), heard_by(listener):
            found = work()
    assert n_done >= 4
    np.testing.assert_array_equal(found, expected)


WITH_RAY = """
import joblib, numpy as np, ray
from ray.util.joblib import register_ray
from skpose import PoseKNeighborsTransformer, pose_distances
from skpose.datasets import humanoid
import skpose._parallel.backends, skpose.metrics._matrix, skpose.neighbors._queries, skpose.metrics._pairwise
skpose.metrics._pairwise.WORTH_SHIPPING = skpose.neighbors._queries.WORTH_SHIPPING = 0
skpose.metrics._matrix.PANEL = 64
body = humanoid()
X = np.random.default_rng(0).normal(0, 0.3, size=(200, body.n_dofs))
search = PoseKNeighborsTransformer(body).fit(X)
expected = pose_distances(X, skeleton=body), search.kneighbors()
ray.init(num_cpus=2, include_dashboard=False)
register_ray()
with joblib.parallel_config("ray", n_jobs=2):
    assert skpose._parallel.backends.in_processes(None)
    np.testing.assert_array_equal(pose_distances(X, skeleton=body), expected[0])
    for found, wanted in zip(search.kneighbors(), expected[1]):
        np.testing.assert_array_equal(found, wanted)
print("the same")
"""


def test_ray_gives_the_same():
    pytest.importorskip("ray")
    done = subprocess.run([sys.executable, "-c", WITH_RAY], capture_output=True, text=True, check=False)
    assert "the same" in done.stdout.splitlines(), done.stderr  # ray may have something to say too
