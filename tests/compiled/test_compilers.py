"""The compilers of parts and wholes: what they keep, that they compute what numba's own does, and do without it."""

import functools
import gc
import operator
import os
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from llvmlite.ir import Instruction
from numba import config, float64, int64, njit
from numba.core import serialize as numba_pickle
from numba.core.compiler import Compiler
from numba.core.errors import TypingError
from numba.core.runtime import _nrt_python, rtsys
from numba.extending import overload
from test_by_address import MODULE, PROGRAM

from skpose import Skeleton, pose_metric
from skpose._compiled.pose.measure import measure_euclidean
from skpose._compiled.simd import compiler as compilers
from skpose._compiled.simd import fallback
from skpose._compiled.simd.jit import internal
from skpose._compiled.simd.lanes import flat

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")

numbas_own = functools.partial(njit, nogil=True, fastmath={"contract"})
whole = functools.partial(numbas_own, pipeline_class=fallback.external_compiler, no_cfunc_wrapper=True)  # not cached


@internal
def scaled(x, n):
    return x * n + 0.5


def address(function):
    (result,) = function.overloads.values()
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


def test_a_whole_has_an_address_and_its_part_has_none():
    function = whole(lambda x: scaled(x, 2))
    assert function(1.0) == 2.5
    assert address(function) != 0
    assert address(scaled) == 0


def test_a_part_is_compiled_once_for_all_literal_numbers():
    assert whole(lambda x: scaled(x, 2) + scaled(x, 3))(1.0) == 6.0
    assert whole(lambda x: scaled(x, 4))(1.0) == 4.5
    assert list(scaled.overloads) == [(float64, int64)]


# --- the same numbers as numba ----------------------------------------------------------------------------------------


def arithmetic(x, n):
    return x / n + x**2 - x**-1 + n**2 + n // 3 - n % 3 + x // 2 + min(x, n) - max(1, n) + abs(-x) + -n + (n << 2)


def branches(x, n):
    total, last = 0.0, None if n > 100 else x
    while n > 0:
        n -= 1
        if n == 3:
            continue
        total += scaled(x, n) if n % 2 else -x
        if total > 1e6:
            break
    else:
        total += 1.0
    return total, last is None


def arrays(x, n):
    a = np.zeros((n, 3))
    for i in range(n):
        a[i] = x + i
        a[i, 1:] *= 2.0
    b, c = a[:, 1], a[-1]
    b[::2] = -c[0]
    return (a * a).sum() + (a + b[-1]).max() + flat(a)[1] + len(a.shape)


def errors_inside(x, n):
    caught = 0
    for i in range(n):
        try:
            if i % 2:
                raise ValueError("odd")
            caught += 10
        except Exception:
            caught += 1
    return caught * x


@pytest.mark.parametrize(
    "function",
    [arithmetic, *(pytest.param(function, marks=pytest.mark.slow) for function in (branches, arrays)), errors_inside],
)
def test_results_are_those_of_numbas_own_compiler(function):
    for arguments in ((1.25, 7), (np.float32(0.1), 4), (2, np.uint8(9)), (1e5, 40)):
        np.testing.assert_array_equal(whole(function)(*arguments), numbas_own(function)(*arguments))


def sometimes(x, i):
    scratch, result = np.empty(100), x[1:]
    if i == 0:
        return result
    if i == 1:
        raise ValueError("one")
    for k in range(len(result)):
        scratch[k] = x[k]
        result = scratch[: k + 1]
    return result


def of_sometimes(part):
    def function(x, i):
        before = part(x, i)
        return before if i == 2 else part(before, 3)

    return function


@pytest.fixture
def counted():
    """Let numba count what is allocated and freed."""
    _nrt_python.memsys_enable_stats()
    yield
    _nrt_python.memsys_disable_stats()


@pytest.mark.usefixtures("counted")
@pytest.mark.parametrize("i", [0, 1, 2, 3])
def test_memory_is_freed_as_by_numbas_own_compiler(i):
    """Numba itself does not free what an exception leaves behind."""

    def kept(function):
        function(np.ones(5), 3)
        before = rtsys.get_allocation_stats()
        for _ in range(10):
            try:
                function(np.ones(5), i)
            except ValueError:
                assert i == 1
        after = rtsys.get_allocation_stats()
        return (after.alloc - before.alloc) - (after.free - before.free)

    own = kept(whole(of_sometimes(internal(sometimes))))
    assert own <= kept(numbas_own(of_sometimes(numbas_own(sometimes))))
    assert own == 0 or i == 1


def test_what_llvmlite_makes_of_a_function_waits_for_no_garbage_collection():
    was_enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        before = sum(issubclass(type(one), Instruction) for one in gc.get_objects())
        whole(lambda x: scaled(x, 2) / (1.0 + scaled(x, x)))(1.0)
        after = sum(issubclass(type(one), Instruction) for one in gc.get_objects())
    finally:
        if was_enabled:
            gc.enable()
    assert after - before < 500  # of the entry point from Python; with all of the function there were 2,000


def test_threads_may_compile_at_the_same_time():
    functions = [whole(eval(f"lambda x: scaled(x, {k}) + scaled(x, x)", globals())) for k in range(8)]
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(lambda function: function(2.0), functions)) == [2.0 * k + 5.0 for k in range(8)]


# --- pickles ----------------------------------------------------------------------------------------------------------


def test_a_function_of_a_module_is_pickled_by_its_name():
    for function in (measure_euclidean, scaled):
        pickled = pickle.dumps(function)
        assert len(pickled) < 100
        assert pickle.loads(pickled) is function
    of_others = pickle.dumps(pose_metric(Skeleton.chain(2), metric="geodesic"))
    assert b"_pose_metric" in of_others  # what makes it again
    assert len(of_others) < 1000  # without code


def test_a_local_function_is_pickled_as_by_numba():
    local = internal(lambda x: 2.0 * x)
    copy = numba_pickle.loads(numba_pickle.dumps(whole(lambda x: local(x) + 1.0)))
    assert copy(3.0) == 7.0


# --- what a developer sees --------------------------------------------------------------------------------------------


@internal
def wrong(x):
    return x.nothing


def test_a_typing_error_has_the_line_and_leaves_nothing_behind():
    function = whole(lambda x: scaled(wrong(x), 1))
    for _ in range(2):
        with pytest.raises(TypingError, match=r"Unknown attribute 'nothing'(?s:.*)return x\.nothing(?s:.*)lambda x"):
            function(1.0)
    assert whole(lambda x: scaled(x, 1))(1.0) == 1.5


def first_of_two(x):
    return x[1.5]


def second_of_two(x):
    return x[1.5]


def test_an_error_of_an_operator_has_the_line_of_its_own_function_only():
    for function, other in ((first_of_two, second_of_two), (second_of_two, first_of_two)):
        with pytest.raises(TypingError) as caught:
            whole(function)(np.ones(3))
        here, there = (f"({each.__code__.co_firstlineno + 1})" for each in (function, other))
        assert here in str(caught.value)
        assert there not in str(caught.value)


def test_an_operator_that_gets_new_rules_is_asked_anew():
    """What operators return is remembered; numba has no ^ of float numbers by itself."""
    exclusive = [whole(eval("lambda x, y: x ^ y")) for _ in range(4)]
    assert exclusive[0](6, 3) == 5
    with pytest.raises(TypingError):
        exclusive[1](6.0, 3.0)

    @overload(operator.xor)
    def xor_of_floats(x, y):
        if x == y == float64:
            return lambda x, y: x + 10.0 * y
        return None

    assert exclusive[2](6.0, 3.0) == 36.0  # a function that has failed stays so
    assert exclusive[3](6, 3) == 5


@internal
def printed(x, n):
    print("x is", x, "and n", n)
    return x


def test_a_part_may_print(capfd):
    assert whole(lambda x: printed(x, 3))(1.0) == 1.0
    assert capfd.readouterr().out == "x is 1.0 and n 3\n"


# --- where numba has changed ------------------------------------------------------------------------------------------


@pytest.fixture
def anew(monkeypatch):
    """Let the compilers be tried again, before and after."""
    monkeypatch.delitem(sys.modules, compilers.__name__)
    fallback._compilers.cache_clear()
    yield monkeypatch
    fallback._compilers.cache_clear()


def test_the_compilers_fit_this_numba(anew):
    assert Compiler not in fallback._compilers()


def test_a_wrong_result_is_noticed(anew):
    anew.setattr(fallback.np, "allclose", lambda *_, **__: False)
    with pytest.warns(UserWarning, match=r"\(ValueError: .*\), so its own"):
        assert fallback._compilers() == (Compiler, Compiler)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (
            lambda patch: patch.setattr("numba.core.typed_passes.IRLegalization.run_pass", lambda _: True),
            "TypeError: .*",
        ),
        (
            lambda patch: patch.setattr("numba.core.untyped_passes.ReconstructSSA.run_pass", lambda *_: False),
            "TypingError: Cannot unify",
        ),
    ],
)
def test_numbas_own_compiler_is_used_where_passes_do_something_else(anew, change, error):
    with anew.context() as patch:
        change(patch)
        with pytest.warns(
            UserWarning, match=rf"does not compile as skpose expects \({error}.*\), so its own"
        ) as warned:
            assert fallback._compilers() == (Compiler, Compiler)
    assert [warning.filename for warning in warned] == [__file__]


CHANGED = "from numba.core import codegen; del codegen.JITCodeLibrary\n"


@pytest.fixture
def run(tmp_path):
    """Run a program in a new process: what it prints, and its warnings."""
    (tmp_path / "module.py").write_text(MODULE)

    def lines(program, cache):
        (tmp_path / "program.py").write_text(program)
        environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / cache)}
        command = [sys.executable, "-W", "always", "program.py"]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines(), done.stderr

    return lines


@pytest.mark.slow
@pytest.mark.parametrize(("first", "warning"), [("", ""), (CHANGED, "program.py:5: UserWarning: numba")])
def test_what_one_process_compiled_is_loaded_by_another_one(run, tmp_path, first, warning):
    expected = ["1.5", "zero has no inverse"]
    printed, warned = run(first + PROGRAM, "cache")
    assert printed == [*expected, "0"]
    assert warning in warned
    assert bool(warned) == bool(warning)
    assert run(PROGRAM, "cache") == ([*expected, "1"], "")
    cached = {path.name.split("-")[0] for path in (tmp_path / "cache").rglob("module.*.nbi")}
    assert cached == {"module.plus_one", "module.inverse"}


LIBRARY = """
import numpy as np

from skpose import forward_kinematics, geodesic, inverse_kinematics, pose_distances, pose_metric
from skpose.datasets import make_gait

walk = make_gait(1, 1, duration=1.0, random_state=0).motions[0]
skeleton, X = walk.skeleton, walk.angles[:9]
for metric in ("angle", "position", "rotation", "spatial", "geodesic"):
    print(*pose_distances(X, skeleton=skeleton, metric=metric).ravel())
print(pose_metric(skeleton)(X[0], X[5]))
print(*geodesic(X[0], X[5], skeleton).path.ravel())
print(*inverse_kinematics(forward_kinematics(X, skeleton), skeleton).poses.ravel())
"""


@pytest.mark.slow
def test_numbas_own_compiler_computes_the_same(run):
    own, warned = run(CHANGED + LIBRARY, "its own")
    assert "does not compile as skpose expects" in warned
    for line, expected in zip(own, run(LIBRARY, "ours")[0], strict=True):
        np.testing.assert_allclose(
            np.fromstring(line, sep=" "), np.fromstring(expected, sep=" "), rtol=1e-10, atol=1e-12
        )
