"""The message while a call compiles."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
from numba import config

from skpose._compiled.simd import cache

MESSAGE = "skpose compiles for this machine, once: 5 s to a minute"


@pytest.fixture
def compile_for(monkeypatch):
    """A function that compiles a function of a module for so many seconds."""
    clock, announcer = SimpleNamespace(now=100.0), cache.Announcer()
    monkeypatch.setattr(cache, "time", SimpleNamespace(monotonic=lambda: clock.now))
    monkeypatch.setattr(cache, "CACHED", True)

    def compile_one(module, seconds):
        function = SimpleNamespace(py_func=SimpleNamespace(__module__=module))
        event = SimpleNamespace(data={"dispatcher": function})
        announcer.on_start(event)
        clock.now += seconds
        announcer.on_end(event)
        clock.now += 60.0

    return compile_one


def test_functions_add_up_and_are_announced_once(compile_for, caplog):
    for _ in range(3):
        assert not caplog.messages
        compile_for("skpose.any", 0.8)
    compile_for("skpose.any", 3.0)
    assert caplog.messages == [MESSAGE]


def test_functions_of_others_are_not_announced(compile_for, caplog):
    compile_for("other", 3.0)
    assert not caplog.messages


@pytest.mark.slow
@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_a_first_call_says_it_on_stderr(tmp_path):
    program = (
        "from skpose._compiled.simd import cache; cache.PATIENCE = 0.0\n"
        "from skpose import Skeleton, pose_distances\n"
        "for X in ([[0.0, 1.0]], [[1.0, 0.0], [2.0, 1.0]]): pose_distances(X, skeleton=Skeleton.chain(2))\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    for expected in ([MESSAGE], []):  # the second process finds it in the cache
        run = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
        )
        assert run.stderr.splitlines() == expected
