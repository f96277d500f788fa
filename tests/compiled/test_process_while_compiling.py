"""What compiling does to the process: nothing that another thread sees."""

import functools
import gc
import threading

import numpy as np
import pytest
from conftest import random_tree
from numba import config, njit
from numba.core.types.functions import BaseFunction

from skpose._compiled.pose.jacobian import position_jacobians
from skpose._compiled.simd import fallback
from skpose.kinematics._tree import tree_of

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")


def state():
    return gc.get_threshold(), gc.isenabled(), gc.get_freeze_count(), BaseFunction.get_call_type


@pytest.fixture
def compile_meanwhile():
    """Compile a kernel, anew and uncached, while another thread calls a function again and again: what that returns."""
    before = gc.get_threshold()

    def compile_kernel(function):
        done, seen = threading.Event(), []

        def watch():
            while not done.is_set():
                seen.append(function())

        watcher = threading.Thread(target=watch)
        whole = functools.partial(njit, pipeline_class=fallback.external_compiler, no_cfunc_wrapper=True)
        tree = tree_of(random_tree(0))
        poses = np.zeros((1, len(tree.column)))
        jacobians = np.empty((1, 3 * len(tree.offset) - 3, len(tree.column)))
        watcher.start()
        try:
            whole(position_jacobians.py_func)(poses, tree, jacobians)
        finally:
            done.set()
            watcher.join()
        assert np.abs(jacobians).sum() > 0.0
        return seen

    yield compile_kernel
    gc.set_threshold(*before)


def test_another_thread_sees_what_it_saw_before(compile_meanwhile):
    before = state()
    seen = compile_meanwhile(state)
    assert len(seen) > 20
    assert set(seen) == {before}
    assert state() == before


def test_thresholds_that_a_user_sets_meanwhile_stay(compile_meanwhile):
    first, own = gc.get_threshold(), (701, 11, 12)
    calls = iter(range(10**9))

    def set_once():
        if next(calls) == 10:
            gc.set_threshold(*own)
        return gc.get_threshold()

    seen = compile_meanwhile(set_once)
    assert seen[0] == first
    assert set(seen[10:]) == {own}
    assert len(seen) > 20
    assert gc.get_threshold() == own


def test_an_error_leaves_the_process_as_it_was():
    """Numba asks for the type of a constant while it compiles; that fails."""
    before, seen = state(), []

    class Constant:
        @property
        def _numba_type_(self):
            seen.append(state())
            raise RuntimeError

    constant = Constant()
    with pytest.raises(RuntimeError):
        njit(pipeline_class=fallback.external_compiler)(lambda: constant)()
    assert seen
    assert set(seen) == {before}
    assert state() == before
