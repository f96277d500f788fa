"""The names of `skpose`, which are imported when they are first used."""

import ast
import importlib
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

import skpose

PACKAGES = sorted(path.parent.name for path in Path(skpose.__file__).parent.glob("[!_]*/__init__.py"))


def run(program):
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_every_name_is_that_of_its_package():
    for name in skpose.__all__:
        (home,) = (package for package in PACKAGES if name in importlib.import_module(f"skpose.{package}").__all__)
        assert getattr(skpose, name) is getattr(importlib.import_module(f"skpose.{home}"), name)


def test_type_checkers_see_the_same_names():
    """Those of `TYPE_CHECKING`, which is false here."""
    source = ast.parse(Path(skpose.__file__).read_text(encoding="utf-8"))
    (checking,) = (node for node in source.body if isinstance(node, ast.If))
    homes = {alias.name: node.module for node in checking.body[:-1] for alias in node.names}
    assert homes == dict.fromkeys(PACKAGES, "skpose") | {
        name: f"skpose.{package}" for package, names in skpose._PACKAGES.items() for name in names
    }
    assert sorted(name for names in skpose._PACKAGES.values() for name in names) == skpose.__all__


@pytest.mark.slow
def test_all_names_can_be_imported_at_once():
    names = run("from skpose import *; print(*(name for name in dir() if not name.startswith('_')))")
    assert names == skpose.__all__


def test_packages_are_attributes(monkeypatch):
    for package in PACKAGES:
        home = importlib.import_module(f"skpose.{package}")
        monkeypatch.delattr(skpose, package)  # as before the import, which sets it
        assert getattr(skpose, package) is home


@pytest.mark.slow
def test_pickles_are_read_where_nothing_is_imported_yet(tmp_path):
    path = tmp_path / "s.pickle"
    path.write_bytes(pickle.dumps([skpose.Skeleton.chain(2), skpose.pose_distances]))
    program = f"import pickle; print(pickle.load(open({str(path)!r}, 'rb'))[0].n_dofs)"
    assert run(program) == ["2"]


def test_other_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="module 'skpose' has no attribute 'Skeletons'"):
        skpose.Skeletons  # noqa: B018
    assert not hasattr(skpose, "_base_")
    with pytest.raises(ImportError, match="cannot import name 'Skeletons' from 'skpose'"):
        exec("from skpose import Skeletons")
