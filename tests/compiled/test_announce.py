"""A call that compiles for long says so, once."""

import logging
import os
import subprocess
import sys
from multiprocessing import Pool

import numba
import pytest

from skpose._compiled import path, pose
from skpose._compiled.simd import announce

MESSAGE = "skpose compiles {} for this machine: once, {}"


class Clock:
    """A clock that goes on by hand."""

    def __init__(self):
        self.now = 100.0

    def monotonic(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(announce, "time", clock)
    monkeypatch.setattr(announce, "CACHED", True)
    return clock


def compile_for(waiting, clock, room, *seconds):
    """Compile functions of a room one in another, each for so many seconds."""
    with waiting.for_function(f"{room.__name__}.any"):
        if seconds[1:]:
            compile_for(waiting, clock, pose, *seconds[1:])
        clock.now += seconds[0]
        waiting.check()


def test_it_is_said_once_for_each_subject(clock, caplog):
    waiting = announce.Waiting()
    for room in (pose, path, pose, path):
        compile_for(waiting, clock, room, 1.5, 1.5)
        clock.now += 60.0
    assert caplog.messages == [MESSAGE.format(*room.COMPILES) for room in (pose, path)]


def test_functions_that_one_call_compiles_add_up(clock, caplog):
    waiting = announce.Waiting()
    for _ in range(3):
        assert not caplog.messages
        compile_for(waiting, clock, path, 0.8)
        clock.now += 0.1
    assert caplog.messages == [MESSAGE.format(*path.COMPILES)]


def test_nothing_is_said_of_many_short_ones(clock, caplog):
    waiting = announce.Waiting()
    for _ in range(9):
        compile_for(waiting, clock, path, 1.9)
        clock.now += 1.0
    assert not caplog.messages


def test_nothing_is_once_where_nothing_is_stored(clock, caplog, monkeypatch):
    monkeypatch.setattr(announce, "CACHED", False)
    compile_for(announce.Waiting(), clock, path, 3.0)
    assert caplog.messages == [MESSAGE.format(*path.COMPILES).replace("once", "in every process")]


def test_a_level_silences_it(clock, caplog):
    waiting, logger = announce.Waiting(), logging.getLogger("skpose")
    before = logger.level
    logger.setLevel("ERROR")
    try:
        compile_for(waiting, clock, path, 3.0)
    finally:
        logger.setLevel(before)
    assert not caplog.messages


def announced_in_worker(_):
    waiting = announce.Waiting()
    waiting.began = -1e9
    waiting.module = "skpose._compiled.path.any"
    waiting.check()
    return waiting.announced


@pytest.mark.slow
def test_workers_say_nothing():
    assert announced_in_worker(0) == {"geodesics"}
    with Pool(1) as pool:
        assert pool.map(announced_in_worker, [0]) == [set()]


@pytest.mark.slow
@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
def test_a_first_call_says_it_on_stderr(tmp_path):
    program = (
        "from skpose._compiled.simd import announce; announce.PATIENCE = 0.0\n"
        "from skpose import Skeleton, pose_distances\n"
        "for X in ([[0.0, 1.0]], [[1.0, 0.0], [2.0, 1.0]]): pose_distances(X, skeleton=Skeleton.chain(2))\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    for expected in ([MESSAGE.format(*pose.COMPILES)], []):  # the second process finds it in the cache
        run = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True
        )
        assert run.stderr.splitlines() == expected
