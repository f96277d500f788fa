"""Files of robots, MJCF and URDF, as MuJoCo's compiled model: links and joints alone, without what needs other files.

Geometry, masses, motors and sensors move no link. They are taken out before the model is compiled, so that missing
meshes and masses are no error; constraints and tendons are noted, as poses without them may be none of the robot.
"""

import os
import re
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Literal, NamedTuple

import numpy as np

from skpose._warnings import warn
from skpose.io._arguments import Readable
from skpose.io._error import MocapFormatError
from skpose.io._opening import open_file
from skpose.io._robot_kind import first_element, robot_kind

# What a model may have besides bodies, frames and joints: first what refers to others, then the others.
OTHERS = (
    "sensors",
    "actuators",
    "tendons",
    "equalities",
    "keys",
    "tuples",
    "pairs",
    "excludes",
    "skins",
    "flexes",
    "cameras",
    "lights",
    "sites",
    "geoms",
    "meshes",
    "hfields",
    "materials",
    "textures",
    "numerics",
    "texts",
    "plugins",
)
# Versions of MuJoCo: the oldest, and the first that reads mimic joints of URDF files and says which limits it ignores.
OLDEST, READS_URDF = (3, 10), (4, 0)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
OTHER_KINDS = {
    "mujocoinclude": "a part of a robot (MJCF) that another file includes: read that file",
    "sdf": "a file of Gazebo (SDF), which MuJoCo does not read: use the robot's URDF or MJCF",
    "OpenSimDocument": "a model of OpenSim, which MuJoCo does not read: load_trc reads the markers of a trial",
    "COLLADA": "a mesh (COLLADA), not a robot",
}
MOST_NAMES = 5  # in a message


class RobotFile(NamedTuple):
    """A robot as MuJoCo's model, and what is said of it."""

    name: str  # of the file
    model: Any  # mujoco.MjModel
    is_urdf: bool
    notes: tuple[str, ...]  # what is not kept

    def error(self, message: str) -> MocapFormatError:
        """Return the error that names this file."""
        return MocapFormatError(self.name, None, message)

    def warn(self, notes: Iterable[str]) -> None:
        """Emit one warning of all that is not kept, at the line of the caller outside this library."""
        if text := "; ".join(notes):
            warn(f"{os.path.basename(self.name)}: {text}")


def list_names(names: Iterable[str]) -> str:
    """Return names for a message: the first ones, and how many there are more."""
    names = list(names)
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(map(repr, names[:MOST_NAMES])) + more


def read_robot(path: Any, caller: str) -> RobotFile:
    """Return the compiled model of a file, an open file, or of a model of MuJoCo that is compiled already."""
    mujoco = _import_mujoco(caller)
    if isinstance(path, mujoco.MjModel):
        return RobotFile("the model", path, False, tuple(_notes_of_model(path, mujoco)))
    name, text = _read_text(path)
    is_urdf = _check_kind(name, text) == "URDF"
    if is_urdf:
        _check_version(mujoco, READS_URDF, f"{caller} of a URDF file")
    with _collect_warnings(mujoco) as said:
        try:
            if isinstance(path, str | os.PathLike):
                spec = mujoco.MjSpec.from_file(os.fspath(path))  # which finds what the file includes
            else:
                spec = mujoco.MjSpec.from_string(text)
            notes = tuple(_notes_of_spec(spec, is_urdf))
            model = _compile_bodies(spec)
        except (ValueError, RuntimeError, mujoco.FatalError) as error:
            message = " ".join(str(error).split()).removeprefix("Error: ")
            raise MocapFormatError(name, None, f"MuJoCo cannot read this file: {message}") from None
    said = [*dict.fromkeys(said)]
    more = [f"and {len(said) - MOST_NAMES} more warnings of MuJoCo"] if len(said) > MOST_NAMES else []
    return RobotFile(name, model, is_urdf, (*notes, *said[:MOST_NAMES], *more))


def _import_mujoco(caller: str) -> Any:
    try:
        import mujoco
    except ImportError:
        raise ImportError(f"{caller} needs MuJoCo: pip install 'skpose[robot]'") from None
    _check_version(mujoco, OLDEST, caller)
    return mujoco


def _check_version(mujoco: Any, oldest: tuple[int, int], caller: str) -> None:
    version = tuple(int(number) for number in re.findall(r"\d+", mujoco.__version__)[:2])
    if version < oldest:
        raise ImportError(
            f"{caller} needs MuJoCo {oldest[0]}.{oldest[1]} or later, and {mujoco.__version__} is installed: pip "
            "install --upgrade mujoco"
        )


def _read_text(path: Readable) -> tuple[str, str]:
    """Return the name of a file and its text."""
    if isinstance(path, str | os.PathLike):
        name = os.fspath(path)
        with open_file(path) as file:
            content = file.read()
    elif hasattr(path, "read"):
        name, content = str(getattr(path, "name", "the open file")), path.read()
    else:
        raise TypeError(f"expected a path, an open file or a mujoco.MjModel, got {type(path).__name__}")
    if isinstance(content, str):
        return name, content
    if content.startswith(b"\x1f\x8b"):
        raise MocapFormatError(name, None, "its gzip compression is not read for robots: decompress it first")
    return name, content.decode("utf-8", errors="replace")


def _check_kind(name: str, text: str) -> Literal["MJCF", "URDF"]:
    """Return the kind of a robot; refuse what is none, and a template of URDF."""
    kind = robot_kind(text)
    if kind is None:
        found = first_element(text)
        expected = "expected a robot, <mujoco> (MJCF) or <robot> (URDF) as the first element"
        if found in OTHER_KINDS:
            raise MocapFormatError(name, None, f"this is {OTHER_KINDS[found]}")
        if text.startswith("version https://git-lfs"):
            raise MocapFormatError(
                name, None, "this is a pointer of Git LFS; get the file itself with git lfs pull. It is no robot"
            )
        shown = f"<{found}>" if found else repr(" ".join(text[:200].split())[:40])
        raise MocapFormatError(name, None, f"{expected}, found {shown}")
    if kind == "URDF" and "<xacro:" in COMMENT.sub("", text):
        raise MocapFormatError(
            name, None, "this is a template of a URDF (xacro): expand it first, with xacro FILE > robot.urdf"
        )
    return kind


@contextmanager
def _collect_warnings(mujoco: Any) -> Iterator[list[str]]:
    """Yield a list of what MuJoCo says meanwhile, which it would print, and write to a file in the current folder."""
    said: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(said.append)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of dynamics, which play no part
            yield said
    finally:
        mujoco.set_mju_user_warning(before)


def _compile_bodies(spec: Any) -> Any:
    """Return the model of links and joints alone; no link is fused with the one that carries it."""
    for kind in OTHERS:
        for one in list(getattr(spec, kind, ())):
            spec.delete(one)
    spec.compiler.fusestatic = False
    spec.memory = -1  # which makes room for all
    for body in spec.bodies[1:]:
        body.explicitinertial, body.mass, body.inertia = True, 1.0, np.ones(3)
        body.fullinertia, body.ipos = np.full(6, np.nan), np.zeros(3)
    return spec.compile()


def _notes_of_spec(spec: Any, is_urdf: bool) -> Iterator[str]:
    """Yield what is not kept of a file: constraints and tendons."""
    couplings, mimics = [], []
    for one in spec.equalities:
        if not one.active:
            continue
        kind = one.type.name.removeprefix("mjEQ_").lower()
        if is_urdf and kind == "joint":
            mimics.append(f"{one.name1} = {_law(one.data, one.name2)}")
        else:
            couplings.append(_coupling(one.name, kind, one.name1, one.name2))
    yield from _notes(couplings, mimics, [one.name for one in spec.tendons])


def _notes_of_model(model: Any, mujoco: Any) -> list[str]:
    """Return what is not kept of a compiled model."""
    couplings = []
    for i in range(model.neq):
        if not model.eq_active0[i]:
            continue
        kind = mujoco.mjtEq(int(model.eq_type[i])).name.removeprefix("mjEQ_").lower()
        of = {"joint": mujoco.mjtObj.mjOBJ_JOINT, "tendon": mujoco.mjtObj.mjOBJ_TENDON}.get(kind, model.eq_objtype[i])
        one, two = (
            (mujoco.mj_id2name(model, int(of), int(number)) or "") if number >= 0 else ""
            for number in (model.eq_obj1id[i], model.eq_obj2id[i])
        )
        couplings.append(_coupling(model.equality(i).name, kind, one, two))
    return list(_notes(couplings, [], [model.tendon(i).name for i in range(model.ntendon)]))


def _notes(couplings: list[str], mimics: list[str], tendons: list[str]) -> Iterator[str]:
    if couplings:
        yield f"equality constraints are not kept, and poses may break them: {_shorten(couplings)}"
    if mimics:
        yield f"mimic joints have columns of their own, and poses may break their laws: {_shorten(mimics)}"
    if tendons:
        yield f"tendons are not kept: {_shorten([repr(name) if name else 'one without a name' for name in tendons])}"


def _shorten(texts: list[str]) -> str:
    more = f" and {len(texts) - MOST_NAMES} more" if len(texts) > MOST_NAMES else ""
    return ", ".join(texts[:MOST_NAMES]) + more


def _coupling(name: str, kind: str, one: str, two: str) -> str:
    """Return an equality constraint in words."""
    two = two or "world" * (kind in ("connect", "weld"))
    between = " and ".join(part for part in (one, two) if part)
    return f"{name} ({kind} of {between})" if name else f"{kind} of {between}"


def _law(coefficients: np.ndarray, other: str) -> str:
    """Return in words the law of a mimic joint: offset + multiplier · other."""
    offset, multiplier = coefficients[:2]
    return f"{multiplier:g} {other}" + (f" {'-' if offset < 0 else '+'} {abs(offset):g}" if offset else "")
