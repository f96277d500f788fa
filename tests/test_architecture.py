"""The architecture: which package may import which, what a newcomer can run, what importing costs."""

import ast
import doctest
import graphlib
import importlib
import importlib.util
import inspect
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import skpose
from skpose.datasets import make_gait
from skpose.io import save_bvh

PACKAGE = Path(skpose.__file__).parent
ROOT = Path(__file__).parent.parent
PAGES = sorted((ROOT / "docs").glob("*.md"))

# The direction of data: a package, or a file at the top, imports only from lines above its own.
LAYERS = [
    ["_utils"],
    ["skeleton"],
    ["keypoints"],
    ["_compiled"],
    ["kinematics"],
    ["io"],
    ["metrics", "datasets"],
    ["geodesics"],
    ["_base"],
    ["neighbors", "preprocessing", "manifold", "cluster"],
    ["motions"],
    ["scores", "statistics", "biomechanics", "robots"],
    ["view"],
    ["plot", "checks"],
    ["__init__"],
    ["_cli"],
    ["__main__"],
]
# All packages without an underscore, and the whole.
PUBLIC = [skpose] + [
    importlib.import_module(f"skpose.{path.parent.name}") for path in sorted(PACKAGE.glob("[!_]*/__init__.py"))
]
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}


def name_of(one):
    """Return the path of a file from the root of the project or of the package, or the name of a module."""
    if inspect.ismodule(one):
        return one.__name__
    return one.relative_to(ROOT if ROOT in one.parents else PACKAGE.parent).as_posix()


def over(all_of_them):
    """Make one test of a rule for a file or module, which names all that break it."""

    def decorate(rule):
        def test():
            broken = []
            for one in all_of_them:
                try:
                    rule(one)
                except AssertionError as error:
                    broken.append(f"{name_of(one)}: {error}")
            assert not broken, "\n" + "\n".join(broken)

        test.__name__, test.__doc__ = rule.__name__, rule.__doc__
        return test

    return decorate


def node_of(path):
    """The package or top-level file that a file belongs to."""
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imported(path):
    """Packages and top-level files that a file imports, anywhere in it: in functions and for types too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module == "skpose":
            tops = [alias.name for alias in node.names]
            names = [f"skpose.{name}" if name in LEVEL else "skpose" for name in tops]
        else:
            names = [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
        for name in names:
            top, *rest = name.split(".")
            if top == "skpose":
                yield rest[0] if rest else "__init__"


CALLERS = [path for path in sorted(PACKAGE.rglob("*.py")) if node_of(path) != "_compiled"]
CALLERS += sorted((ROOT / "tests").rglob("*.py")) + sorted((ROOT / "benchmarks").glob("*.py"))


def without_entry(path):
    """Names in a file of imported functions that only compiled functions can call."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("skpose._compiled"):
            for alias in node.names:
                name = alias.asname or alias.name
                try:
                    value = getattr(importlib.import_module(node.module), alias.name)
                except AttributeError:  # a module
                    value = importlib.import_module(f"{node.module}.{alias.name}")
                of_module = vars(value) if inspect.ismodule(value) else {"": value}
                for attribute, function in of_module.items():
                    if getattr(function, "targetoptions", {}).get("no_cpython_wrapper"):
                        yield f"{name}.{attribute}".rstrip(".")


def called_from_python(node):
    """Names of functions that are called outside of compiled functions."""
    if isinstance(node, ast.FunctionDef) and any("jit" in ast.unparse(one) for one in node.decorator_list):
        return
    if isinstance(node, ast.Call):
        yield ast.unparse(node.func)
    for child in ast.iter_child_nodes(node):
        yield from called_from_python(child)


@pytest.mark.slow
@over(CALLERS)
def test_python_calls_no_function_without_an_entry(path):
    if not (without := set(without_entry(path))):
        return
    text = ast.parse(path.read_text(encoding="utf-8"))
    assigned = (target for node in text.body if isinstance(node, ast.Assign) for target in node.targets)
    with_entry = {name.id for target in assigned for name in ast.walk(target) if isinstance(name, ast.Name)}
    wrong = without & set(called_from_python(text)) - with_entry
    assert not wrong, f"{wrong} would crash: from_python of tests/compiled/entries.py makes an entry"


@pytest.mark.slow
@over(sorted(PACKAGE.rglob("*.py")))
def test_imports_follow_the_flow_of_data(path):
    here = node_of(path)
    assert here in LEVEL, f"{here} is not in LAYERS: say where in the flow of data it stands"
    for there in set(imported(path)) - {here}:
        assert LEVEL[there] < LEVEL[here], f"{path.relative_to(PACKAGE)} imports {there}, which comes after {here}"


def module_of(path):
    return ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")


def imported_modules(path):
    """Modules of the package that a file imports, anywhere in it: in functions and for types too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.split(".")[0] == "skpose")
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "skpose":
            folder = PACKAGE.parent.joinpath(*node.module.split("."))
            for alias in node.names:
                is_module = (folder / f"{alias.name}.py").is_file() or (folder / alias.name).is_dir()
                # A private name is as private as a module.
                yield f"{node.module}.{alias.name}" if is_module or alias.name.startswith("_") else node.module


@pytest.mark.slow
def test_no_circle_of_imports():
    graph = {module_of(path): set(imported_modules(path)) for path in PACKAGE.rglob("*.py")}
    order = list(graphlib.TopologicalSorter(graph).static_order())  # raises CycleError with the circle
    assert len(order) == len(graph)


LARGE = ["numpy", "scipy", "numba", "sklearn", "joblib", "matplotlib", "dask", "zarr", "ray"]
SLOW = ["skpose.datasets", "sklearn.neighbors", "sklearn.model_selection", "matplotlib", "dask", "zarr", "ray"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("program", "slow"),
    [
        ("import skpose", LARGE),
        ("from skpose._cli.main import main; main(['--help'])", LARGE),
        ("from skpose import pose_distances, PoseKNeighborsTransformer", SLOW),
    ],
)
def test_importing_leaves_the_slow_parts_alone(program, slow):
    code = f"""
import sys
try:
    {program}
except SystemExit:
    pass
print([name for name in {slow} if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.slow
def test_works_where_nothing_can_be_cached():
    code = """
import warnings, numba.core.caching
numba.core.caching.CacheImpl._locator_classes = []  # as where neither the package nor the home can be written to
with warnings.catch_warnings(record=True) as caught:
    warnings.simplefilter("always")
    from skpose import pose_distances
assert ["NUMBA_CACHE_DIR" in str(w.message) for w in caught] == [True], caught
print(pose_distances([[0.0], [1.0]], metric="angle")[0, 1])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stdout.strip(), done.returncode) == ("1.0", 0), done.stderr


MODULES = [module.name for module in pkgutil.walk_packages(skpose.__path__, "skpose.")]


def with_examples(names):
    """Return the modules whose text has an example."""
    files = {name: Path(importlib.util.find_spec(name).origin) for name in names}
    return [name for name, file in files.items() if ">>>" in file.read_text(encoding="utf-8")]


@pytest.mark.parametrize("name", with_examples(MODULES))
def test_docstring_examples(name):
    failures, _ = doctest.testmod(importlib.import_module(name))
    assert failures == 0


@over(PUBLIC)
def test_every_public_name_has_an_example(module):
    for name in module.__all__:
        assert ">>>" in getattr(module, name).__doc__ or name in {"Bone"}, name


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", [path for path in PAGES if ">>>" in path.read_text(encoding="utf-8")], ids=lambda path: path.stem
)
def test_the_pages_examples_run(path):
    failures, _ = doctest.testfile(str(path), module_relative=False)
    assert failures == 0


@over(PUBLIC)
def test_every_public_name_is_in_the_reference(module):
    listed = set((ROOT / "docs" / "api.md").read_text(encoding="utf-8").split())
    assert set(module.__all__) <= listed


@over([*PAGES, ROOT / "README.md", ROOT / "CONTRIBUTING.md"])
def test_links_between_pages_lead_somewhere(path):
    text = path.read_text(encoding="utf-8")
    for page in re.findall(r"skpose\.github\.io/skpose/(\w+)\.html", text):
        assert (ROOT / "docs" / f"{page}.md").exists(), page
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", text):
        built = target.startswith("examples/") and path.parent.name == "docs"  # by the gallery
        assert built or (path.parent / target).exists(), target


def test_the_readmes_program_runs(tmp_path, monkeypatch, capsys):
    (program,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.S)
    (tmp_path / "bvh").mkdir()
    gait = make_gait(2, 1, duration=1.0, random_state=0)
    for person, action, motion in zip(gait.subjects, gait.actions, gait, strict=True):
        save_bvh(tmp_path / "bvh" / f"{person}_{action}_1.bvh", motion, scale=0.01)
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "README.md", "exec"), {})
    assert len(capsys.readouterr().out.strip("[]\n").split()) == 2  # the scores of two folds
