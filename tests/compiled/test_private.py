"""Private parts of numba and llvmlite: where they stand, and what happens where one is missing."""

import ast
import importlib
import inspect
import runpy
import sys
import tomllib
from collections import Counter
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.codegen import CPUCodegen, JITCodeLibrary
from numba.core.typing.context import BaseContext

import skpose
from skpose._compiled.simd import cache, compiler, fallback, private
from skpose._compiled.simd.jit import jit

PACKAGE = Path(skpose.__file__).parent
PRIVATE = ("numba.core", "numba.np", "numba.misc", "numba.typed", "llvmlite")


def names_of(module):
    """The private names that a module imports, as (module, name); of modules that it imports, what it takes of them."""
    tree = ast.parse(inspect.getsource(module))
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module.startswith(PRIVATE):
            for alias in node.names:
                part = f"{node.module}.{alias.name}"
                taken = {
                    (part, one.attr)
                    for one in ast.walk(tree)
                    if isinstance(one, ast.Attribute) and ast.unparse(one.value) == alias.name
                }
                if alias.name.endswith("_passes"):
                    yield from sorted(taken)
                else:
                    yield node.module, alias.name


@pytest.fixture(autouse=True, scope="module")
def rules_are_loaded():
    """Let numba load its rules of types, which it does once, before parts of it are taken away."""
    numba.njit(lambda array: array.shape[0])(np.ones((2, 2)))


@pytest.fixture
def take_away(monkeypatch):
    def take(module, name):
        monkeypatch.delattr(importlib.import_module(module), name)
        if f"{module}.{name}" in sys.modules:
            monkeypatch.setitem(sys.modules, f"{module}.{name}", None)

    return take


@pytest.mark.parametrize(("module", "name"), [*names_of(private)])
def test_a_missing_name_is_an_error_that_says_which_numba_fits(module, name, take_away):
    take_away(module, name)
    with pytest.raises(ImportError) as caught:
        runpy.run_path(private.__file__)
    message = str(caught.value)
    for part in (f"numba {numba.__version__} lacks", name, f"pip install 'numba{private.FITTING}'"):
        assert part in message


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
@pytest.mark.parametrize(("module", "name"), [*names_of(compiler)])
def test_without_a_name_of_the_compilers_numbas_own_is_used(module, name, take_away, monkeypatch):
    monkeypatch.delitem(sys.modules, compiler.__name__)
    monkeypatch.setattr(fallback, "_compilers", fallback._compilers.__wrapped__)  # not cached
    take_away(module, name)
    with pytest.warns(UserWarning, match=rf"does not compile as skpose expects \(.*{name}.*\), so its own"):
        assert fallback._compilers() == (private.Compiler, private.Compiler)


def attributes_of(module):
    """The private parts of numba's classes that a module overrides or uses, as (class, name)."""
    for cls in vars(module).values():
        if isinstance(cls, type) and cls.__module__ == module.__name__:
            base = next((base for base in cls.__mro__ if base.__module__.startswith("numba")), BaseContext)
            names = [name for name, member in vars(cls).items() if inspect.isfunction(member)]
            yield from ((base, name) for name in names if hasattr(base, name) and not name.startswith("__"))


def take_attribute_away(owner, name, monkeypatch):
    """Take an attribute from a class and from those that it inherits from; of instances, what may be set."""
    defining = [base for base in owner.__mro__ if name in vars(base)]
    for base in defining:
        monkeypatch.delattr(base, name)
    if not defining:
        monkeypatch.setattr(owner, name, property(), raising=False)


ATTRIBUTES = {
    *attributes_of(compiler),
    (JITCodeLibrary, "_get_module_for_linking"),
    (CPUCodegen, "_function_pass_manager"),
    (CPUCodegen, "_data_layout"),
    (JITCodeLibrary, "_codegen"),
    (JITCodeLibrary, "_final_module"),
    (JITCodeLibrary, "_linking_libraries"),
}


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled")
@pytest.mark.parametrize(("owner", "name"), sorted(ATTRIBUTES, key=str))
def test_without_an_attribute_that_the_compilers_use_numbas_own_is_used(owner, name, monkeypatch):
    """Without a method that they override too: numba would call another one, and nothing would fail."""
    monkeypatch.delitem(sys.modules, compiler.__name__)
    monkeypatch.setattr(fallback, "_compilers", fallback._compilers.__wrapped__)  # not cached
    take_attribute_away(owner, name, monkeypatch)
    with pytest.warns(UserWarning, match=r"does not compile as skpose expects \(.*\), so its own"):
        assert fallback._compilers() == (private.Compiler, private.Compiler)


def test_a_method_that_numba_would_not_call_is_noticed():
    class Renamed:
        def finalize_all(self):
            """Do what `finalize` did."""

    with pytest.raises(AttributeError, match="JITCodeLibrary has no finalize_all"):
        compiler._overrides(JITCodeLibrary)(Renamed)


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is cached")
@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (FunctionCache, "load_overload"),
        (FunctionCache, "_py_func"),
        (FunctionCache, "_cache_file"),
        *((IndexDataCacheFile, name) for name in ("_version", "_data_name_pattern", "_dump", "flush", "save", "load")),
        (private.Dispatcher, "_cache"),
    ],
)
def test_without_an_attribute_of_the_cache_nothing_is_cached(owner, name, monkeypatch):
    function = jit(lambda x: x)
    before = function._cache
    take_attribute_away(owner, name, monkeypatch)
    with pytest.warns(UserWarning, match="does not cache as skpose expects"):
        cache.cache_under("", function, lambda _: None)
    monkeypatch.undo()
    assert function._cache is before


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is cached")
@pytest.mark.parametrize(("module", "name"), [*names_of(cache)])
def test_without_a_name_of_the_cache_nothing_is_cached(module, name, take_away):
    function = jit(lambda x: x)
    before = function._cache
    take_away(module, name)
    with pytest.warns(UserWarning, match="does not cache as skpose expects"):
        cache.cache_under("", function, lambda _: None)
    assert function._cache is before


def test_every_private_name_is_taken_away_above():
    for module, n_names in ((private, 25), (compiler, 14), (cache, 1)):
        assert len([*names_of(module)]) >= n_names


def test_private_names_stand_once_and_in_one_room():
    found = Counter()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [("", alias.name) for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [(node.module or "", alias.name) for alias in node.names]
            for module, name in names:
                if f"{module}.{name}".lstrip(".").startswith(PRIVATE):
                    assert path.parent.relative_to(PACKAGE).as_posix() == "_compiled/simd", path
                    found[module, name] += 1
    assert found
    assert max(found.values()) == 1, found.most_common(3)


def test_the_versions_that_fit_are_those_of_the_package():
    pyproject = PACKAGE.parent / "pyproject.toml"
    if not pyproject.is_file():
        pytest.skip("the sources are not here")
    dependencies = tomllib.loads(pyproject.read_text(encoding="utf-8"))["project"]["dependencies"]
    assert f"numba{private.FITTING}" in dependencies


def test_pointers_are_opaque():
    """Every load and every address names its type, and no type is made a pointer."""
    for path in (PACKAGE / "_compiled" / "simd").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute):
                assert node.attr != "as_pointer", path
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                needed = {"load": "typ", "gep": "source_etype"}.get(node.func.attr)
                if needed and ast.unparse(node.func.value) == "builder":
                    assert needed in {keyword.arg for keyword in node.keywords}, f"{path}: {ast.unparse(node)}"
