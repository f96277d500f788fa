"""What compiling does to the process."""

import gc

import pytest
from numba import config
from numba.core.types.functions import BaseFunction

from skpose._compiled.simd.compiler import NEVER
from skpose._compiled.simd.jit import internal, jit

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")


@pytest.fixture
def constant_and_thresholds():
    """Record the threshold of full collections while numba asks for the type of a constant, which fails."""
    seen = []

    class Constant:
        @property
        def _numba_type_(self):
            seen.append(gc.get_threshold()[2])
            raise RuntimeError

    return Constant(), seen


def test_the_settings_of_garbage_collection_are_as_before_after_compiling():
    before = gc.get_threshold()

    @internal
    def part(value):
        return value + 1

    @jit
    def whole(value):
        return part(value)

    assert whole(1) == 2
    assert gc.get_threshold() == before


def test_they_and_numba_are_so_too_after_an_error_and_full_collections_wait_meanwhile(constant_and_thresholds):
    before, (constant, seen) = gc.get_threshold(), constant_and_thresholds
    ask = BaseFunction.get_call_type

    @internal
    def part():
        return constant

    @jit
    def whole():
        return part()

    with pytest.raises(RuntimeError):
        whole()
    assert set(seen) == {NEVER}
    assert gc.get_threshold() == before
    assert BaseFunction.get_call_type is ask
