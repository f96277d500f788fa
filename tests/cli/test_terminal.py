"""The terminal: Ctrl-C at any moment, and output that nobody reads."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import DATA

from skpose import Skeleton, pose_distances
from skpose._cli.main import main
from skpose.io import load_bvh

BVH = str(DATA / "biped.bvh")


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.bvh", "b.bvh"):
        shutil.copy(BVH, tmp_path / name)
    return ["a.bvh", "b.bvh"]


def start(*program):
    return subprocess.Popen(
        [sys.executable, *program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8"
    )


# Ctrl-C


@pytest.fixture
def children_receive_ctrl_c(monkeypatch):
    """Let child processes receive SIGINT. They inherit that it is ignored if pytest runs in the background."""
    # Not measured: a signal while coverage holds its lock would leave the process waiting for it.
    monkeypatch.delenv("COVERAGE_PROCESS_START", raising=False)
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, handler)


def with_ctrl_c(test):
    test = pytest.mark.usefixtures("children_receive_ctrl_c")(test)
    return pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")(test)


@pytest.mark.slow
@with_ctrl_c
def test_the_same_command_finishes_a_matrix_after_ctrl_c(files, capsys):
    arguments = ["distances", *files, "--scale", "0.01", "--frame-rate", "150000", "--jobs", "1", "--out", "D.npy"]
    process = start("-m", "skpose", *arguments)
    while not Path("D.npy.progress").exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.001)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate()
    assert process.returncode == 130
    assert err.splitlines()[-1] == "skpose: interrupted; run the same command again to continue"
    assert Path("D.npy.progress").exists()
    assert main(arguments) == 0
    assert "D.npy is unfinished: continuing" in capsys.readouterr().out
    motion = load_bvh(BVH, scale=0.01).resample(150000)
    X = np.concatenate([motion.angles] * 2)
    assert len(X) == 2500
    D = np.load("D.npy", mmap_mode="r")
    np.testing.assert_array_equal(D, pose_distances(X, skeleton=Skeleton.mean([motion.skeleton]), n_jobs=-1))
    assert not Path("D.npy.progress").exists()


IMPORTED = """
import os, signal, sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            sys.meta_path.remove(self)
            try:
                os.kill(os.getpid(), signal.SIGINT)
            except KeyboardInterrupt:
                raise {error}
        return None

sys.meta_path.insert(0, Interrupt())
from skpose._cli.main import main
sys.exit(main(["distances", "a.bvh", "--out", "D.npy"]))
"""


@pytest.mark.slow
@with_ctrl_c
@pytest.mark.parametrize("error", ["KeyboardInterrupt", "ImportError('a part of the library')"])
@pytest.mark.parametrize("module", ["numba", "llvmlite", "sklearn.base", "skpose.neighbors"])
def test_ctrl_c_while_something_is_imported(files, module, error):
    """Also where a library makes another error of it."""
    process = start("-c", IMPORTED.format(module=module, error=error))
    assert process.communicate() == ("", "skpose: interrupted\n")
    assert process.returncode == 130
    assert sorted(os.listdir()) == files


COMPILED = """
import os, signal, sys
from numba.core import event

class Interrupt(event.Listener):
    n_functions = 0

    def on_start(self, event):
        self.n_functions += 1
        if self.n_functions == {nth}:
            os.kill(os.getpid(), signal.SIGINT)

    def on_end(self, event):
        pass

event.register("numba:compile", Interrupt())
from skpose._compiled.simd import announce
announce.PATIENCE = float("inf")  # a slow machine says what it compiles
from skpose._cli.main import main
# One job, so that this thread compiles.
sys.exit(main(["distances", "a.bvh", "--scale", "0.01", "--jobs", "1", "--out", "D.npy"]))
"""


@pytest.mark.slow
@with_ctrl_c
@pytest.mark.parametrize("nth", [1, 5])
def test_ctrl_c_while_numba_compiles(files, tmp_path_factory, monkeypatch, nth):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))
    monkeypatch.delenv("NUMBA_DISABLE_JIT", raising=False)
    process = start("-c", COMPILED.format(nth=nth))
    _, err = process.communicate()
    assert process.returncode == 130
    assert err in ("skpose: interrupted\n", "skpose: interrupted; run the same command again to continue\n")


# Output that nobody reads


def closed(*program):
    """Run a program whose output nobody reads; return its exit status and what it wrote to stderr."""
    process = start(*program)
    process.stdout.close()
    err = process.stderr.read()
    process.stderr.close()
    return process.wait(), err


closed_pipe = pytest.mark.skipif(sys.platform == "win32", reason="Windows has another error for a closed pipe")


@pytest.mark.slow
@closed_pipe
def test_a_closed_output_is_no_error():
    assert closed("-m", "skpose", "info", BVH, "--scale", "0.01") == (1, "")


@pytest.mark.slow
@closed_pipe
@pytest.mark.parametrize("unbuffered", [[], ["-u"]])
def test_a_command_that_writes_a_file_writes_it_though_nobody_reads_its_output(files, unbuffered):
    command = ["-m", "skpose", "distances", *files, "--metric", "position"]
    status, err = closed(*unbuffered, *command, "--out", "D.npy")
    assert (status, "Broken" in err, "ignored" in err) == (0, False, False)
    motion = load_bvh(BVH)
    X = np.concatenate([motion.angles] * 2)
    D = pose_distances(X, skeleton=Skeleton.mean([motion.skeleton]), metric="position")
    np.testing.assert_array_equal(np.load("D.npy"), D)
    assert sorted(os.listdir()) == ["D.npy", *files]


@pytest.mark.slow
@closed_pipe
def test_nor_its_errors(files):
    """As of `skpose ... 2>&1 | head`."""
    program = "import subprocess, sys; sys.exit(subprocess.call(sys.argv[1:], stderr=subprocess.STDOUT))"
    command = [sys.executable, "-u", "-m", "skpose", "neighbors", *files, "--metric", "position", "--neighbors", "1"]
    assert closed("-c", program, *command, "--out", "G.npz") == (0, "")
    assert Path("G.npz").exists()


@pytest.mark.parametrize("name", ["stdin", "stdout", "stderr"])
def test_closed_streams(files, name, monkeypatch):
    """As of `skpose ... >&-`."""
    monkeypatch.setattr(sys, name, None)
    command = ["neighbors", *files, "--metric", "position", "--neighbors", "1", "--out", "G.npz"]
    assert main(command) == 0
    assert Path("G.npz").exists()
    assert main(["info", "-"]) == 1 if name == "stdin" else main(["info", BVH]) == 0
    assert getattr(sys, name) is None
