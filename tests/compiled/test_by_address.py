"""Functions that are compiled apart from their callers: called, cached, and failing as any other."""

import os
import subprocess
import sys

import pytest
from numba import config

MODULE = """
from skpose._compiled.simd.jit import internal, jit, by_address
from skpose._compiled.simd.signatures import REAL


@by_address(lambda: REAL(REAL))
def inverse(x):
    if x == 0.0:
        raise ValueError("zero has no inverse")
    return 1.0 / x


@internal
def twice_the_inverse(x):
    return 2.0 * inverse(x)


@jit
def plus_one(x):
    return 1.0 + twice_the_inverse(x)
"""
PROGRAM = """
from module import plus_one

print(plus_one(4.0))
try:
    plus_one(0.0)
except ValueError as error:
    print(error)
print(sum(plus_one.stats.cache_hits.values()) if hasattr(plus_one, "stats") else "plain Python")
"""


@pytest.fixture
def run(tmp_path):
    """Run the program in a new process: its lines."""
    (tmp_path / "module.py").write_text(MODULE)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}

    def lines(**variables):
        command = [sys.executable, "-c", PROGRAM]
        done = subprocess.run(command, cwd=tmp_path, env=environment | variables, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    return lines


@pytest.mark.slow
@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_of_a_cached_caller_the_separate_function_is_loaded_first(run):
    expected = ["1.5", "zero has no inverse"]
    assert run() == [*expected, "0"]
    assert run() == [*expected, "1"]


def test_as_plain_python(run):
    assert run(NUMBA_DISABLE_JIT="1") == ["1.5", "zero has no inverse", "plain Python"]
