"""The order of the house: which file may import which, what a newcomer can run, what importing costs."""

import ast
import doctest
import importlib
import pkgutil
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import skpose
import skpose.datasets
import skpose.io
import skpose.plot

PACKAGE = Path(skpose.__file__).parent
ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = sorted((ROOT / "docs").glob("*.md"))

# The direction of the data: a file imports only from lines above its own.
LAYERS = [
    ["_lanes", "_threads", "_progress", "_engine", "_journal", "skeleton"],
    ["_kernels", "motion", "_validation"],
    ["_measures", "_tree", "_loops", "_jacobian", "_graph_shift", "_blocks", "io._source"],
    ["_path_energy", "_nearest", "io._numbers"],
    ["_minimiser", "io._hierarchy"],
    ["_mean"],
    ["io._asf", "io._bvh", "io._save"],
    ["io._amc"],
    ["io._load"],
    ["io"],
    ["datasets._cmu_digests", "datasets._motions"],
    ["datasets._cmu", "datasets._gait"],
    ["datasets"],
    ["kinematics", "metrics"],
    ["geodesic", "mean"],
    ["_matrix", "_lazy"],
    ["_destination", "_screen"],
    ["pairwise"],
    ["_search"],
    ["_geodesic_search"],
    ["_queries"],
    ["_callbacks", "_estimator"],
    ["_graph"],
    ["transformer", "cluster", "manifold", "neighbors"],
    ["plot._axes"],
    ["plot._pose", "plot._mds", "plot._distances", "plot._geodesic"],
    ["plot"],
    ["__init__"],
    ["compare"],
    ["reproduce"],
    ["_report"],
    ["commands"],
    ["__main__"],
]
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}


def module_name(path):
    name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
    return name.removesuffix(".__init__")


def imported(path):
    """Modules of the package that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "skpose")
        elif isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "skpose":
            folder = PACKAGE.parent.joinpath(*node.module.split("."))
            for alias in node.names:
                is_module = (folder / f"{alias.name}.py").is_file() or (folder / alias.name).is_dir()
                yield f"{node.module}.{alias.name}" if is_module else node.module


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=module_name)
def test_imports_point_up_the_flow_of_data(path):
    here = module_name(path)
    assert here in LEVEL, f"{here} has no place in LAYERS: say where in the flow of data it stands"
    for name in imported(path):
        there = name.removeprefix("skpose").lstrip(".") or "__init__"
        assert LEVEL[there] < LEVEL[here], f"{here} imports {there}, which comes after it"


def test_importing_leaves_the_slow_parts_alone():
    slow = ["skpose.datasets", "sklearn.neighbors", "sklearn.model_selection", "matplotlib", "dask", "zarr", "ray"]
    code = f"import sys, skpose; print([name for name in {slow} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_works_where_nothing_can_be_cached():
    code = """
import warnings, numba.core.caching
numba.core.caching.CacheImpl._locator_classes = []  # as where neither the package nor the home can be written to
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    import skpose
assert [str(w.message)[:21] for w in caught] == ["numba finds no folder"], caught
print(skpose.pose_distances([[0.0], [1.0]])[0, 1])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stdout.strip(), done.returncode) == ("1.0", 0), done.stderr


@pytest.mark.parametrize("name", [m.name for m in pkgutil.walk_packages(skpose.__path__, "skpose.")])
def test_docstring_examples(name):
    failures, _ = doctest.testmod(importlib.import_module(name))
    assert failures == 0


def test_every_public_name_has_an_example():
    for module in (skpose, skpose.plot):
        for name in module.__all__:
            assert ">>>" in getattr(module, name).__doc__ or name == "Bone", name


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.stem)
def test_the_pages_examples_run(path):
    failures, _ = doctest.testfile(str(path), module_relative=False)
    assert failures == 0


def test_every_public_name_is_in_the_reference():
    listed = set((ROOT / "docs" / "api.md").read_text(encoding="utf-8").split())
    for module in (skpose, skpose.io, skpose.datasets, skpose.plot):
        assert set(module.__all__) <= listed


@pytest.mark.parametrize("path", [*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"], ids=lambda path: path.stem)
def test_links_between_pages_lead_somewhere(path):
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", path.read_text(encoding="utf-8")):
        built = target.startswith("examples/") and path.parent.name == "docs"  # by the gallery
        assert built or (path.parent / target).exists(), target


def test_the_readmes_program_runs(tmp_path, monkeypatch, capsys):
    (program,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.S)
    (tmp_path / "bvh").mkdir()
    for name in ("anna_walk_1", "anna_run_2", "ben_walk_1", "ben_run_2"):
        shutil.copy(ROOT / "tests" / "data" / "biped.bvh", tmp_path / "bvh" / f"{name}.bvh")
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "README.md", "exec"), {})
    assert len(capsys.readouterr().out.strip("[]\n").split()) == 2  # the scores of two folds


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_run(path, capsys):
    runpy.run_path(str(path))
    assert capsys.readouterr().out
