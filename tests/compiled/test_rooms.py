"""The rooms of compiled code: imports point one way, and each room opens with a diagram of what it holds."""

import ast
import re
from pathlib import Path

import pytest

from skpose import _compiled

FOLDER = Path(_compiled.__file__).parent
MAY_IMPORT = {
    "simd": set(),
    "pose": {"simd"},
    "path": {"simd", "pose"},
    "inverse": {"simd", "pose"},
    "warping": {"simd", "pose"},
    "graph_shift": {"simd"},
}


def modules(room):
    return sorted((FOLDER / room).glob("*.py")) or [FOLDER / f"{room}.py"]


def imported(path):
    """The modules that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_every_room_is_known():
    found = {path.stem for path in FOLDER.iterdir() if path.suffix == ".py" or (path / "__init__.py").is_file()}
    assert found - {"__init__"} == set(MAY_IMPORT)


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_imports_point_one_way(room):
    for path in modules(room):
        for name in imported(path):
            package, *parts = name.split(".")
            if package != "skpose":
                continue
            if parts[0] == "_compiled":
                assert parts[1] in MAY_IMPORT[room] | {room}, f"{path} imports {name}"
            else:
                assert parts[0] == "_warnings", f"{path} imports {name}"


@pytest.mark.parametrize("room", [room for room in MAY_IMPORT if (FOLDER / room).is_dir()])
def test_the_diagram_of_a_room_names_its_modules(room):
    text = ast.get_docstring(ast.parse((FOLDER / room / "__init__.py").read_text(encoding="utf-8")))
    for path in modules(room):
        if path.stem != "__init__":
            assert re.search(rf"\b{path.stem}\b", text), f"{path.stem} is not in the diagram of {room}"


def test_vector_registers_know_no_pose():
    words = re.compile(r"\b(pose|poses|skeleton|skeletons|joint|joints|tree|trees)\b", re.IGNORECASE)
    for path in modules("simd"):
        if path.stem != "__init__":  # of which an example is the Tree
            tree = ast.parse(path.read_text(encoding="utf-8"))
            names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
            names |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
            assert not [name for name in names if words.search(name)], path
