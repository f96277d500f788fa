"""Distances written into arrays on disk: block by block, resumed after a crash, never a half-written block for done."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from itertools import count
from pathlib import Path

import numpy as np
import pytest
import zarr
from conftest import random_tree

from skpose import Skeleton, pose_distances
from skpose._parallel.progress import heard_by

BODY = random_tree(0)


@pytest.fixture(scope="module")
def X():
    rng = np.random.default_rng(0)
    return np.cumsum(rng.normal(0, 0.1, size=(150, BODY.n_dofs)), axis=0)


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    """Blocks of 16 × 16."""
    monkeypatch.setattr("skpose.metrics._matrix.PANEL", 16)


@pytest.fixture(params=["memmap", "npy", "zarr"])
def array(request, tmp_path):
    """A function that opens an array on disk, made anew if a shape is given."""

    kind = {}

    def opened(shape=None, dtype=np.float64):
        path, mode = tmp_path / "D.npy", "r+" if shape is None else "w+"
        if shape is not None:
            kind.update(shape=shape, dtype=dtype)
        if request.param == "zarr":
            store = tmp_path / "D.zarr"
            return (
                zarr.open_array(store, mode="r+")
                if shape is None
                else zarr.create_array(store, chunks=(40, 50), **kind)
            )
        return (np.memmap if request.param == "memmap" else np.lib.format.open_memmap)(path, mode=mode, **kind)

    return opened


@pytest.fixture
def journal(array, tmp_path):
    """The notes on what is done, None if there are none."""

    def read():
        if (tmp_path / "D.zarr").exists():
            found = array().attrs.get("skpose.unfinished")
            return found and found["notes"]
        path = tmp_path / "D.npy.progress"
        return [json.loads(line) for line in path.read_text().splitlines()[1:]] if path.exists() else None

    return read


class Stop(BaseException):
    """Like Ctrl-C, but meant."""


@contextmanager
def stopped_after(n_blocks):
    """Let so many blocks be done, and no more."""
    numbers = count(1)

    @contextmanager
    def listener(_, n_steps):
        def advance():
            if next(numbers) == n_blocks:
                raise Stop

        yield advance

    with heard_by(listener), pytest.raises(Stop):
        yield


@contextmanager
def counted():
    """Counts the blocks that are computed."""
    blocks = []

    @contextmanager
    def listener(_, n_steps):
        yield lambda: blocks.append(n_steps)

    with heard_by(listener):
        yield blocks


@pytest.mark.parametrize("triangle", [True, False])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_the_same_as_in_memory_and_no_notes_are_left(array, journal, X, triangle, dtype):
    X, Y = X.astype(dtype), None if triangle else X[:40].astype(dtype) + dtype(0.1)
    expected = pose_distances(X, Y, skeleton=BODY)
    out = array(expected.shape, dtype)
    assert pose_distances(X, Y, skeleton=BODY, out=out) is out
    np.testing.assert_array_equal(out[:], expected)
    assert journal() is None


@pytest.mark.parametrize("metric", ["spatial", "geodesic"])
@pytest.mark.parametrize("triangle", [True, False])
def test_the_same_call_goes_on_where_it_stopped(array, journal, X, metric, triangle):
    X = X if metric == "spatial" else X[:50, :3].astype(np.float32)
    skeleton = BODY if metric == "spatial" else Skeleton.chain(3)
    Y = None if triangle else X[:40] + X.dtype.type(0.1)
    parameters = {"skeleton": skeleton, "metric": metric}
    expected = pose_distances(X, Y, **parameters)
    out = array(expected.shape, expected.dtype)
    with stopped_after(4):
        pose_distances(X, Y, out=out, **parameters)
    assert len(journal()) == 4
    del out
    with counted() as blocks:
        pose_distances(X, Y, out=array(), **parameters)
    np.testing.assert_array_equal(array()[:], expected)
    edges = [-(-n // 16) for n in expected.shape]
    assert len(blocks) == (edges[0] * (edges[0] + 1) // 2 if triangle else edges[0] * edges[1]) - 4
    assert journal() is None


def test_what_does_not_hold_what_was_noted_is_computed_again(array, journal, X):
    expected = pose_distances(X, skeleton=BODY)
    out = array(expected.shape)
    with stopped_after(6):
        pose_distances(X, skeleton=BODY, out=out)
    done = journal()
    out[done[0][0], done[0][2] + 1] += 1e-9  # a block on the diagonal
    out[done[3][2], done[3][0]] = np.nan  # what mirrors one above it
    with counted() as blocks:
        pose_distances(X, skeleton=BODY, out=out)
    np.testing.assert_array_equal(out[:], expected)
    assert len(blocks) == 55 - 4


def test_an_array_that_is_made_anew_has_nothing_done(tmp_path, X):
    expected = pose_distances(X, skeleton=BODY)
    for _ in range(2):
        out = np.lib.format.open_memmap(tmp_path / "D.npy", mode="w+", shape=expected.shape)
        with stopped_after(30):
            pose_distances(X, skeleton=BODY, out=out)
    out = np.lib.format.open_memmap(tmp_path / "D.npy", mode="w+", shape=expected.shape)
    pose_distances(X, skeleton=BODY, out=out)
    np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize("cut", [1, 10, 40])
def test_notes_that_were_cut_short_count_as_far_as_they_go(tmp_path, X, cut):
    expected = pose_distances(X, skeleton=BODY)
    out = np.lib.format.open_memmap(tmp_path / "D.npy", mode="w+", shape=expected.shape)
    with stopped_after(20):
        pose_distances(X, skeleton=BODY, out=out)
    path = tmp_path / "D.npy.progress"
    path.write_bytes(path.read_bytes()[:-cut] + b"\0\0")
    with counted() as blocks:
        pose_distances(X, skeleton=BODY, out=out)
    np.testing.assert_array_equal(out, expected)
    assert 55 - 20 < len(blocks) <= 55 - 18


@pytest.mark.parametrize(
    "other",
    [
        {"metric": "position"},
        {"n_steps": 9},
        {"wrap": False},
        {"skeleton": random_tree(1)},
        {"X": None},
        {"Y": None},
    ],
    ids=lambda other: next(iter(other)),
)
def test_other_distances_are_not_mixed_in(array, X, other):
    out = array((len(X), len(X)))
    with stopped_after(4):
        pose_distances(X, skeleton=BODY, out=out)
    before = out[:].copy()
    call = {"X": X, "Y": None, "skeleton": BODY}
    call |= {"X": X + 1e-9} if "X" in other else {"Y": X.copy()} if "Y" in other else other
    with pytest.raises(ValueError, match=r"out holds the beginning of other distances \(spatial, \[150, 150\]"):
        pose_distances(**call, out=out)
    np.testing.assert_array_equal(out[:], before)


def test_other_partitions_of_the_work_go_on_with_the_first(array, X, monkeypatch):
    expected = pose_distances(X, skeleton=BODY)
    out = array(expected.shape)
    with stopped_after(4):
        pose_distances(X, skeleton=BODY, out=out, n_jobs=2)
    monkeypatch.setattr("skpose.metrics._matrix.PANEL", 64)
    pose_distances(X, skeleton=BODY, out=out)
    np.testing.assert_array_equal(out[:], expected)


def test_unconverged_from_before_are_counted(tmp_path, X, monkeypatch):
    from sklearn.exceptions import ConvergenceWarning

    from skpose.metrics._convergence import Unconverged
    from skpose.metrics._matrix import DistanceMatrix

    compute = DistanceMatrix.distances
    monkeypatch.setattr(DistanceMatrix, "distances", lambda *args: (compute(*args)[0], Unconverged(2, 0.25)))
    out = np.memmap(tmp_path / "D", float, "w+", shape=(150, 150))
    with stopped_after(5):
        pose_distances(X, skeleton=BODY, out=out)
    with pytest.warns(ConvergenceWarning, match="110 of 11175 geodesics did not converge"):
        pose_distances(X, skeleton=BODY, out=out)


def test_somebody_elses_file_is_left_alone(tmp_path, X):
    (tmp_path / "D.progress").write_text("My notes\n")
    out = np.memmap(tmp_path / "D", float, "w+", shape=(150, 150))
    with pytest.raises(ValueError, match=r"D\.progress is where skpose keeps its notes, but it holds something else"):
        pose_distances(X, skeleton=BODY, out=out)
    assert (tmp_path / "D.progress").read_text() == "My notes\n"


def test_parts_of_files_and_copies_on_write_are_plain_arrays(tmp_path, X):
    expected = pose_distances(X, skeleton=BODY)
    whole = np.memmap(tmp_path / "D", float, "w+", shape=(300, 300))
    pose_distances(X, skeleton=BODY, out=whole[150:, :150])
    np.testing.assert_array_equal(whole[150:, :150], expected)
    assert not whole[:150].any()
    whole.flush()
    private = np.memmap(tmp_path / "D", float, "c", shape=(300, 300))
    pose_distances(X, skeleton=BODY, out=private[:150, 150:])
    np.testing.assert_array_equal(private[:150, 150:], expected)
    assert not np.memmap(tmp_path / "D", float, "r", shape=(300, 300))[:150].any()
    assert [path.name for path in tmp_path.iterdir()] == ["D"]


@pytest.mark.parametrize(
    ("out", "got"),
    [
        (np.zeros((150, 149)), r"got float64 \(150, 149\)"),
        (np.zeros((150, 150), np.float32), "got float32"),
        (np.broadcast_to(0.0, (150, 150)), r"got float64 \(150, 150\), read-only"),
        ([0.0], "got list"),
        (zarr.create_array({}, shape=(150, 150), dtype="f4"), "got float32"),
    ],
)
def test_an_out_that_does_not_fit_is_refused(X, out, got):
    with pytest.raises(ValueError, match=rf"out must be a writeable float64 array of shape \(150, 150\), {got}"):
        pose_distances(X, skeleton=BODY, out=out)


PROGRAM = """
import sys
import numpy as np
import skpose.metrics._matrix
from skpose import pose_distances
from skpose.datasets import humanoid
body = humanoid()
rng = np.random.default_rng(0)
X = np.cumsum(rng.normal(0, 0.05, size=({n}, body.n_dofs)), axis=0).astype(np.float32)
pose_distances(X[:20], skeleton=body, metric="position")
before = open("/proc/self/status").read()
out = np.lib.format.open_memmap("D.npy", mode="{mode}", dtype=X.dtype, shape=(len(X), len(X)))
skpose.metrics._matrix.PANEL = 256
print("begun", flush=True)
pose_distances(X, skeleton=body, metric="position", out=out)
print(before + open("/proc/self/status").read())
"""


def start(folder, n, mode):
    program = [sys.executable, "-c", PROGRAM.format(n=n, mode=mode)]
    process = subprocess.Popen(program, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    return process


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_killed_and_resumed_gives_the_same_bytes(tmp_path, how):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    for folder in (whole, killed):
        folder.mkdir()
    start(whole, 3000, "w+").communicate()
    process = start(killed, 3000, "w+")
    notes = killed / "D.npy.progress"
    while not (notes.exists() and notes.read_text().count("\n") > 10):
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(how)
    process.communicate()
    assert process.returncode == -how
    assert notes.exists()
    assert (killed / "D.npy").read_bytes() != (whole / "D.npy").read_bytes()
    _, errors = start(killed, 3000, "r+").communicate()
    assert (killed / "D.npy").read_bytes() == (whole / "D.npy").read_bytes(), errors
    assert os.listdir(killed) == ["D.npy"]


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="there is no /proc")
def test_what_is_written_does_not_stay_resident(tmp_path):
    out, errors = start(tmp_path, 7000, "w+").communicate()
    before, after = (int(kilobytes) for kilobytes in re.findall(r"VmHWM:\s+(\d+) kB", out))
    assert (tmp_path / "D.npy").stat().st_size > 190_000_000, errors
    assert after - before < 60_000
