"""Workers write their tiles themselves, where they see the destination; dead workers and clients lose no noted tile."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import joblib
import numpy as np
import pytest
import zarr
from test_out import TREE, counted, stopped_after

from skpose import pose_distances
from skpose._parallel import lock
from skpose._parallel.checkpoint import FileCheckpoint
from skpose._parallel.file_systems import computer
from skpose._parallel.lock import hold_lock
from skpose.metrics import _run, _writers, _zarr_writer
from skpose.metrics._convergence import Unconverged
from skpose.metrics._matrix import DistanceMatrix
from skpose.metrics._run import WorkerOutput
from skpose.metrics._spatial import Spatial
from skpose.metrics._tiles import Tile, Tiling
from skpose.metrics._writers import FileTarget
from skpose.metrics._zarr_writer import ZarrTarget

KINDS = ["npy", "columns", "zarr", "shards", "group"]
pytestmark = pytest.mark.slow  # two processes, which import numba
kills = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")


@pytest.fixture(scope="module")
def X():
    return np.cumsum(np.random.default_rng(0).normal(0, 0.1, size=(200, TREE.n_dofs)), axis=0)


@pytest.fixture(autouse=True)
def two_workers(monkeypatch):
    """Two processes, to which even little work is sent, in tiles of 32 × 32."""
    monkeypatch.setattr("skpose.metrics._matrix.ENCODED_AT_ONCE", 32)
    monkeypatch.setattr("skpose.metrics._tiled.WORTH_SENDING", 0)
    monkeypatch.setattr(_run, "SECONDS", -1.0)
    with joblib.parallel_config(backend="loky", n_jobs=2):
        yield


def created(folder, kind, shape, dtype=np.float64, chunks=(32, 16)):
    """Return a new array in a folder."""
    if kind == "npy":
        return np.lib.format.open_memmap(folder / "D.npy", mode="w+", shape=shape, dtype=dtype)
    if kind == "columns":
        return np.memmap(folder / "D.npy", mode="w+", shape=shape, dtype=dtype, order="F")
    name, chunks = ("a/b" if kind == "group" else None), ((8, 16) if kind == "shards" else chunks)
    shards = (16, 32) if kind == "shards" else None
    return zarr.create_array(folder / "D.zarr", name=name, shape=shape, dtype=dtype, chunks=chunks, shards=shards)


@pytest.fixture
def only_workers_write(monkeypatch):
    """This process writes nothing."""

    def refuse(*_):
        raise AssertionError("written by this process")

    monkeypatch.setattr(_writers.FileWriter, "write", refuse)
    monkeypatch.setattr(_zarr_writer.ZarrWriter, "write", refuse)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("triangle", [True, False])
def test_the_same_to_the_last_bit(tmp_path, X, only_workers_write, kind, triangle):
    X = X.astype(np.float32)
    Y = None if triangle else X[:70] + np.float32(0.1)
    with joblib.parallel_config(backend="threading", n_jobs=1):
        expected = pose_distances(X, Y, skeleton=TREE)
    out = created(tmp_path, kind, expected.shape, np.float32)
    with counted() as tiles:
        assert pose_distances(X, Y, skeleton=TREE, out=out) is out
    assert len(tiles) == (28 if triangle else 21)
    np.testing.assert_array_equal(out[:], expected)
    assert {path.name for path in tmp_path.rglob("*") if path.is_file()}.isdisjoint({"skpose.lock", "D.npy.lock"})


def test_float64_distances_of_float32_poses(tmp_path, only_workers_write):
    """Geodesics are computed in float64."""
    from skpose import Skeleton

    X, arm = np.random.default_rng(0).normal(size=(70, 2)).astype(np.float32), Skeleton.chain(2)
    out = created(tmp_path, "npy", (70, 70), np.float32)
    pose_distances(X, skeleton=arm, metric="geodesic", out=out)
    with joblib.parallel_config(backend="threading", n_jobs=1):
        np.testing.assert_array_equal(out, pose_distances(X, skeleton=arm, metric="geodesic"))


@pytest.mark.parametrize("kind", ["npy", "zarr"])
def test_workers_check_what_an_earlier_call_wrote(tmp_path, X, monkeypatch, only_workers_write, kind):
    def refuse(*_):
        raise AssertionError("read by this process")

    out = created(tmp_path, kind, (200, 200))
    with stopped_after(9):
        pose_distances(X, skeleton=TREE, out=out)
    _, notes = FileCheckpoint(tmp_path / ("D.npy" if kind == "npy" else "D.zarr")).read()
    assert len(notes) == 9
    top, _, left, _, *_ = notes[4]
    out[left, top + 1] += 1e-9
    monkeypatch.setattr(_writers.FileWriter, "checksums", refuse)
    monkeypatch.setattr(_zarr_writer.ZarrWriter, "checksums", refuse)
    monkeypatch.setattr("skpose.metrics._run.ResumedRun.check", lambda _: None)  # reads a sample at the end
    with counted() as tiles:
        pose_distances(X, skeleton=TREE, out=out)
    assert len(tiles) == 28 - 8
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))


def test_on_dask(tmp_path, X, only_workers_write):
    from dask.distributed import Client, LocalCluster

    out = created(tmp_path, "npy", (200, 200))
    options = {"n_workers": 2, "threads_per_worker": 2, "dashboard_address": ":0"}
    with LocalCluster(**options) as cluster, Client(cluster), joblib.parallel_config(backend="dask"):
        pose_distances(X, skeleton=TREE, out=out)
    np.testing.assert_array_equal(out, pose_distances(X, skeleton=TREE))


class Mortal(DistanceMatrix):
    """A matrix whose first tile kills its worker: in the middle of its bytes, or before the disk has all of them."""

    def __init__(self, X, folder, when):
        super().__init__(X, None, Spatial(), TREE)
        self.dead, self.when, self.client = folder / "dead", when, os.getpid()

    def distances(self, tile, *arguments):
        if os.getpid() != self.client:
            try:
                self.dead.touch(exist_ok=False)
            except FileExistsError:
                pass
            else:
                self.prepare()
        return super().distances(tile, *arguments)

    def prepare(self):
        def die(*_):
            os.kill(os.getpid(), signal.SIGKILL)

        if self.when == "half of the bytes are written":
            _writers.pwrite = lambda file, content, at: die() if at % 7 == 3 else os.pwrite(file, content[:13], at)
        else:
            _writers.fdatasync = _zarr_writer.sync = die


@kills
@pytest.mark.parametrize(
    ("kind", "when"),
    [
        ("npy", "half of the bytes are written"),
        ("npy", "the disk does not have all bytes"),
        ("zarr", "the disk does not have all bytes"),  # zarr writes a chunk under another name, and renames it
    ],
)
def test_a_worker_that_is_killed_while_it_writes_changes_nothing(tmp_path, X, kind, when):
    out = created(tmp_path, kind, (200, 200))
    matrix = Mortal(X, tmp_path, when)
    matrix.write(out, None)
    assert matrix.dead.exists()
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))


CLIENT = """
import os, signal, time
from contextlib import contextmanager
from itertools import count
from pathlib import Path
import joblib, numpy as np, zarr
import skpose.metrics._matrix, skpose.metrics._run, skpose.metrics._tiled
from skpose import pose_distances
from skpose._parallel.progress import report_to
from test_out import TREE

skpose.metrics._matrix.ENCODED_AT_ONCE = 32
skpose.metrics._tiled.WORTH_SENDING = 0
skpose.metrics._run.SECONDS = -1.0

@contextmanager
def reporter(_, n_steps):
    numbers = count(1)

    def advance():
        if next(numbers) == 9:
            (notes,) = Path().rglob("*.progress")
            while notes.read_text().count("\\n") < 2:
                time.sleep(0.01)
            os.kill(os.getpid(), signal.SIGKILL)

    yield advance

if __name__ == "__main__":
    X = np.load("X.npy")
    if "{kind}" == "npy":
        out = np.lib.format.open_memmap("D.npy", mode="r+")
    else:
        out = zarr.open_array("D.zarr", mode="r+")
    with joblib.parallel_config(backend="{backend}", n_jobs=2), report_to(reporter):
        pose_distances(X, skeleton=TREE, out=out)
"""


@kills
@pytest.mark.parametrize("kind", ["npy", "zarr"])
@pytest.mark.parametrize("backend", ["loky", "multiprocessing"])
def test_a_client_that_is_killed_loses_no_noted_tile(tmp_path, X, kind, backend):
    """The reporter kills the client after nine tiles, as soon as one is noted."""
    np.save(tmp_path / "X.npy", X)
    out = created(tmp_path, kind, (200, 200))
    program = [sys.executable, "-c", CLIENT.format(kind=kind, backend=backend)]
    folders = Path(__file__).parent, Path(__file__).parents[1], os.environ.get("PYTHONPATH", "")
    paths = os.pathsep.join(map(str, folders))
    environment = {name: value for name, value in os.environ.items() if name != "COVERAGE_PROCESS_START"}
    with open(tmp_path / "errors", "w") as errors:  # not a pipe, which workers may keep open
        client = subprocess.Popen(
            program,
            cwd=tmp_path,
            env=environment | {"PYTHONPATH": paths, "JOBLIB_TEMP_FOLDER": str(tmp_path)},
            stdout=errors,
            stderr=errors,
            start_new_session=True,
        )
    assert client.wait() == -signal.SIGKILL, (tmp_path / "errors").read_text()
    try:  # its workers live on, and may still write a tile
        _, notes = FileCheckpoint(tmp_path / ("D.npy" if kind == "npy" else "D.zarr")).read()
        assert len(notes) >= 1
        with counted() as tiles:
            pose_distances(X, skeleton=TREE, out=out)
        assert len(tiles) == 28 - len(notes)
        np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(client.pid, signal.SIGTERM)  # which leaves loky the process that removes its files


class Blind(DistanceMatrix):
    """A matrix whose workers see another folder under the same path."""

    def __init__(self, X):
        super().__init__(X, None, Spatial(), TREE)
        self.client = os.getpid()

    def distances(self, tile, *arguments):
        if os.getpid() != self.client:
            lock._content = lambda path: {"process": 1, "host": "elsewhere", "token": "another"}
        return super().distances(tile, *arguments)


@pytest.mark.parametrize("kind", ["npy", "zarr"])
def test_workers_that_do_not_see_the_destination_send_their_tiles_back_with_a_warning(tmp_path, X, kind):
    out = created(tmp_path, kind, (200, 200))
    name = r"D\.npy\.lock" if kind == "npy" else r"D\.zarr.skpose\.lock"
    message = rf"a worker cannot write into out, on {socket.gethostname()}: .*{name} is another file there\. Such "
    with pytest.warns(UserWarning, match=message) as warned, stopped_after(5):
        Blind(X).write(out, None)
    assert len(warned) == 1
    with pytest.warns(UserWarning, match=message):
        Blind(X).write(out, None)  # nor can they check what is there
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))
    joblib.externals.loky.get_reusable_executor().shutdown(kill_workers=True)  # as they stay blind


@pytest.mark.parametrize("kind", ["npy", "zarr"])
def test_a_worker_reports_a_tile_when_the_disk_has_it(tmp_path, monkeypatch, kind):
    array = created(tmp_path, kind, (64, 64))
    target = FileTarget.of(array) if kind == "npy" else ZarrTarget(array)
    seen = []
    for module, name in (_writers, "fdatasync"), (_zarr_writer, "sync"):
        monkeypatch.setattr(module, name, lambda _: seen.append(array[:].sum()))
    with hold_lock(target.path) as token:
        output = WorkerOutput(target, token, Tiling((64, 64), 32, True), "here")
        output.write(Tile(0, 32, 32, 64), np.ones((32, 32)), Unconverged(0, 0.0))
    assert seen == [2 * 32 * 32] * (1 if kind == "npy" else 2 * 2 + 4)  # files of chunks, and their folders


def test_a_worker_writes_only_where_the_token_is(tmp_path):
    """The run that sent the task may have ended, and another one may have started."""
    array = created(tmp_path, "npy", (6, 6))
    target, distances = FileTarget.of(array), np.ones((3, 3))
    with hold_lock(target.path) as token:
        output = WorkerOutput(target, token, Tiling((6, 6), 3, True), computer())
        computed = output.write(Tile(0, 3, 3, 6), distances, Unconverged(1, 0.5))
        assert (computed.distances, computed.obstacle, computed.unconverged) == (None, None, (1, 0.5))
        assert len(computed.checksums) == 2
        assert array.sum() == 18
        missing = output._replace(target=target._replace(path=tmp_path / "E.npy"))
        longer = output._replace(target=target._replace(shape=(7, 6)))
        zarrs = output._replace(target=ZarrTarget(created(tmp_path, "zarr", (6, 6))))
        zarrs.target.path = tmp_path / "E.zarr"
        for other, reason in (missing, "E.npy is missing there"), (longer, "is shorter"), (zarrs, "E.zarr is missing"):
            refused = other.write(Tile(0, 3, 0, 3), distances, Unconverged(0, 0.0))
            assert refused.distances is distances
            assert refused.checksums is None
            assert f"{socket.gethostname()}: " in refused.obstacle
            assert reason in refused.obstacle
    assert "cannot be read" in output.write(Tile(0, 3, 0, 3), distances, Unconverged(0, 0.0)).obstacle
    with hold_lock(target.path):
        assert "another file" in output.write(Tile(0, 3, 0, 3), distances, Unconverged(0, 0.0)).obstacle
    assert array.sum() == 18


def test_two_computers_do_not_write_one_file_on_nfs(tmp_path, monkeypatch):
    array, distances = created(tmp_path, "npy", (6, 6)), np.ones((3, 3))
    monkeypatch.setattr(_writers, "writes_whole_pages", lambda _: "nfs4")
    target, folder = FileTarget.of(array), ZarrTarget(created(tmp_path, "zarr", (6, 6)))
    with hold_lock(target.path) as token:
        output = WorkerOutput(target, token, Tiling((6, 6), 3, True), computer())
        assert output.obstacle() is None
        elsewhere = output._replace(client="another computer")
        refused = elsewhere.write(Tile(0, 3, 3, 6), distances, Unconverged(0, 0.0))
        assert "D.npy is on nfs4, where two computers cannot write one file, but a zarr array" in refused.obstacle
        assert refused.distances is distances
        assert elsewhere._replace(target=folder).obstacle() is None  # whose chunks are files of their own
    assert not array.any()


def test_chunks_that_two_tiles_would_share_are_written_by_this_process_with_a_warning(tmp_path, X):
    out = created(tmp_path, "zarr", (200, 200), chunks=(40, 50))
    message = r"chunks do not fit into tiles of 32 × 32.* create the array with chunks of \(32, 32\), or of a divisor"
    with pytest.warns(UserWarning, match=message):
        pose_distances(X, skeleton=TREE, out=out)
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))


def test_a_store_in_memory_is_written_by_this_process(X):
    out = zarr.create_array({}, shape=(200, 200), dtype="f8", chunks=(32, 32))
    pose_distances(X, skeleton=TREE, out=out)
    np.testing.assert_array_equal(out[:], pose_distances(X, skeleton=TREE))
