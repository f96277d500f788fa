"""MuJoCo's model of a robot, with its links and joints alone.

Geometry, masses, motors and sensors do not move links. They are removed before MuJoCo compiles the model, so that
missing meshes and masses do not matter.
"""

import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from skpose._utils.validation import list_names
from skpose.io import MocapFormatError
from skpose.io._arguments import Readable

# Elements of a model other than bodies, frames and joints; elements that refer to others come first.
REMOVED = (
    *("sensors", "actuators", "tendons", "equalities", "keys", "tuples", "pairs", "excludes", "skins", "flexes"),
    *("cameras", "lights", "sites", "geoms", "meshes", "hfields", "materials", "textures", "numerics", "texts"),
    "plugins",
)
READS_URDF = (4, 0)  # the first version of MuJoCo that reads mimic joints and reports the limits that it ignores
# Blanks, declarations and comments before the first element, none of which is tried twice, and its name.
FIRST_ELEMENT = re.compile(
    r"(?:\s|(?><\?.*?\?>)|(?><!--.*?-->)|(?><!DOCTYPE[^>\[]*(?:\[.*?\])?[^>]*>))*+<([\w:.-]+)", re.DOTALL
)
MJCF, URDF = "mujoco", "robot"  # the first element
HEAD = 1 << 18  # bytes, at most, before the end of the first element
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)


class RobotFile(NamedTuple):
    """A robot as MuJoCo's model."""

    name: str  # of the file
    model: Any  # mujoco.MjModel
    is_urdf: bool
    notes: tuple[str, ...]  # what the skeleton does not keep

    def error(self, message: str) -> MocapFormatError:
        return MocapFormatError(self.name, None, message)


def read_robot(path: Any) -> RobotFile:
    """Compile the model of a file or an open file; a `mujoco.MjModel` is taken as it is."""
    try:
        import mujoco
    except ImportError:
        raise ImportError("robots need MuJoCo: pip install 'skpose[robot]'") from None
    if isinstance(path, mujoco.MjModel):
        active = [i for i in range(path.neq) if path.eq_active0[i]]
        constraints = [path.equality(i).name or f"number {i}" for i in active]
        tendons = [path.tendon(i).name or f"number {i}" for i in range(path.ntendon)]
        return RobotFile("the model", path, False, _notes(constraints, tendons))
    name, text = _read_text(path)
    is_urdf = _is_urdf(name, text)
    if is_urdf and tuple(map(int, re.findall(r"\d+", mujoco.__version__)[:2])) < READS_URDF:
        raise ImportError(f"URDF files need MuJoCo 4.0 or later, found {mujoco.__version__}")
    with _collect_warnings(mujoco) as said:
        try:
            if isinstance(path, str | os.PathLike):
                spec = mujoco.MjSpec.from_file(os.fspath(path))  # which finds the files that this one includes
            else:
                spec = mujoco.MjSpec.from_string(text)
            equalities = [one for one in spec.equalities if one.active]
            constraints = [one.name or " and ".join(filter(None, (one.name1, one.name2))) for one in equalities]
            notes = _notes(constraints, [one.name or "unnamed" for one in spec.tendons])
            model = _compile_bodies(spec)
        except (ValueError, RuntimeError, mujoco.FatalError) as error:
            message = " ".join(str(error).split()).removeprefix("Error: ")
            raise MocapFormatError(name, None, f"MuJoCo cannot read this file: {message}") from None
    return RobotFile(name, model, is_urdf, (*notes, *dict.fromkeys(said)))


def _read_text(path: Any) -> tuple[str, str]:
    """Read the name of a file and its text."""
    if hasattr(path, "read"):
        name, content = str(getattr(path, "name", "the open file")), path.read()
    else:
        with Path(path).open("rb") as file:
            name, content = os.fspath(path), file.read()
    return name, content if isinstance(content, str) else content.decode("utf-8", errors="replace")


def _is_urdf(name: str, text: str) -> bool:
    """Whether a robot is URDF and not MJCF; refuse other files."""
    element = _first_element(text)
    if element not in (MJCF, URDF):
        raise MocapFormatError(name, None, f"expected <mujoco> (MJCF) or <robot> (URDF), found <{element}>")
    if element == URDF and "<xacro:" in COMMENT.sub("", text):
        raise MocapFormatError(name, None, "expected URDF, found a xacro template: expand it with xacro")
    return element == URDF


def _first_element(text: str) -> str:
    """The name of the first element of a text in XML; empty if there is none."""
    found = FIRST_ELEMENT.match(text.removeprefix("\ufeff"))
    return found[1] if found else ""


def is_robot(path: Readable) -> bool:
    """Whether a file, or an open file of bytes, is a robot, by its beginning."""
    if isinstance(path, str | os.PathLike):
        with Path(path).open("rb") as file:
            return is_robot(file)
    return _first_element(path.read(HEAD).decode("utf-8", errors="replace")) in (MJCF, URDF)


@contextmanager
def _collect_warnings(mujoco: Any) -> Iterator[list[str]]:
    """Collect MuJoCo's warnings, which it would print and write to a file in the current folder."""
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about dynamics
            yield said
    finally:
        mujoco.set_mju_user_warning(before)


def _compile_bodies(spec: Any) -> Any:
    """Compile links and joints alone, without fusing links."""
    for kind in REMOVED:
        for one in list(getattr(spec, kind, ())):
            spec.delete(one)
    spec.compiler.fusestatic = False
    spec.memory = -1  # as much as the model needs
    for body in spec.bodies[1:]:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
        body.fullinertia, body.ipos = np.full(6, np.nan), np.zeros(3)
    return spec.compile()


def _notes(constraints: list[str], tendons: list[str]) -> tuple[str, ...]:
    notes = {"equality constraints and mimic joints": constraints, "tendons": tendons}
    return tuple(f"{what} are not kept: {list_names(names)}" for what, names in notes.items() if names)
