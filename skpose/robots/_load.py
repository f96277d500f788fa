"""The skeleton of a robot from MuJoCo's model.

Geometry, masses, motors and sensors do not move links. They are cut from the text before MuJoCo reads it, so that
missing meshes and masses do not matter. Files may come from strangers: MuJoCo reads a text without includes, of bounded
size.

MuJoCo places a link (its *body*) by a position and an orientation in the coordinate system of the parent link, and then
applies its joints one after another, each about an axis through a point of the link. Each step becomes a bone whose
dofs come last; bones between two joints at one point have length zero.
"""

import math
import os
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.typing import ArrayLike
from skpose._utils.validation import list_names, near_names
from skpose._utils.warnings import warn
from skpose.io._source import HEAD, ROBOT, MocapFormatError, Readable
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._bone import BALL, HINGE, SLIDE
from skpose.skeleton._rotations import rotations_of

if TYPE_CHECKING:
    import mujoco

# Elements of a model other than bodies, frames and joints; elements that refer to others come first.
REMOVED = (
    *("sensors", "actuators", "tendons", "equalities", "keys", "tuples", "pairs", "excludes", "skins", "flexes"),
    *("cameras", "lights", "sites", "geoms", "meshes", "hfields", "materials", "textures", "numerics", "texts"),
    "plugins",
)
READS_URDF = (4, 0)  # the first version of MuJoCo that reads mimic joints and reports the limits that it ignores
MJCF, URDF = "mujoco", "robot"  # the first element
# Elements that are cut from the text: deleting them one by one from MuJoCo's model takes quadratic time.
CUT = (
    *("asset", "sensor", "actuator", "contact", "keyframe", "custom", "deformable", "flexcomp"),
    *("geom", "site", "camera", "light", "visual", "collision"),
)
EXPANDED = "replicate", "composite"  # elements that MuJoCo repeats `count` times
MOST = 100_000  # elements after that
FREE, SPHERICAL, SLIDE_JOINT, HINGE_JOINT = range(4)  # mujoco.mjtJoint
DOFS = {SPHERICAL: BALL, SLIDE_JOINT: SLIDE, HINGE_JOINT: HINGE}  # of a bone
WORLD = 0  # MuJoCo's number of the world's body
IN_QPOS = {FREE: 7, SPHERICAL: 4, SLIDE_JOINT: 1, HINGE_JOINT: 1}  # numbers of a joint in qpos
SHAPES: dict[int, tuple[int, ...]] = {FREE: (7,), SPHERICAL: (3,), SLIDE_JOINT: (), HINGE_JOINT: ()}  # of held values
EXACT = 1e-15  # entries of rotation matrices this near to 0, 1 and −1 are rounded: quarter turns are exact
WITHIN = 1e-6  # rad or m, the allowed excess of a held value over the limits: the digits of a file


class RobotFile(NamedTuple):
    """A robot as MuJoCo's model."""

    name: str  # of the file
    model: Any  # mujoco.MjModel
    is_urdf: bool
    notes: tuple[str, ...]  # what the skeleton does not keep

    def error(self, message: str) -> MocapFormatError:
        return MocapFormatError(self.name, None, message)


class Joint(NamedTuple):
    """A joint of the model."""

    name: str
    kind: int
    body: int
    address: int  # in qpos
    point: np.ndarray  # on the axis, in the coordinate system of the link
    axis: np.ndarray
    reference: float  # the number in qpos at which the link is as in the file
    limits: tuple[float, float] | None
    held: np.ndarray | None  # the value at which it stays

    def in_qpos(self) -> slice:
        return slice(self.address, self.address + IN_QPOS[self.kind])


class Robot(NamedTuple):
    """The skeleton of a robot, and where its joints are in qpos."""

    skeleton: Skeleton
    root: int  # number of the link that is the root
    root_name: str
    joints: tuple[Joint, ...]  # of the whole model
    columns: dict[str, Joint]  # joint of each bone with dofs, in the skeleton's order
    free: Joint | None  # the free joint of the root
    notes: tuple[str, ...]  # what is not kept


def load_robot(
    path: "Readable | mujoco.MjModel",
    *,
    root: str | None = None,
    held: Mapping[str, ArrayLike] | None = None,
) -> Skeleton:
    """Load the skeleton of a robot from an MJCF or URDF file, as MuJoCo reads it.

    The joints of the skeleton are the robot's links (MuJoCo's bodies), by name and in MuJoCo's order. The columns of
    its poses are the robot's joints, by name, in the order of ``qpos`` and with its numbers.

    Parameters
    ----------
    path : str, path-like, file or mujoco.MjModel
        The file, an open file without includes, or a compiled model. A file includes files of its folder only.
    root : str, default=None
        The link that is the root of the skeleton; links that it does not carry are left out. None is the link with the
        free joint; without one, the first link of a URDF file, and "world" otherwise.
    held : mapping of str to float or array-like, default=None
        Joints that stay at a value and have no columns: rad for a hinge, m for a slide, a rotation vector (3,) in rad
        for a ball joint.

    Returns
    -------
    Skeleton
        With ``offset_frame="parent"``. A hinge or a slide is a column with the name of the joint, in rad or m; a ball
        joint has three, the rotation vector of `Bone`. It has the joint limits of the file.

    Raises
    ------
    ImportError
        If MuJoCo is not installed.
    MocapFormatError
        If MuJoCo cannot read the file; if several links with joints move freely and `root` is None; if `root` or `held`
        has an unknown name, or a held value is beyond the joint limits; if it includes a file outside its folder,
        or has more than 100,000 elements after MuJoCo repeats them.

    Warns
    -----
    UserWarning
        If the file has equality constraints, mimic joints, tendons, or limits of ball joints or in the wrong
        order, which the skeleton does not keep; if links or joints are left out.

    See Also
    --------
    motion_from_qpos : Convert MuJoCo's ``qpos`` to a motion.
    qpos_from_motion : Convert a motion to MuJoCo's ``qpos``.

    Notes
    -----
    Geometry, masses, motors and sensors are ignored, so that missing meshes do not matter. Links are not fused. Models
    that a file attaches (``<attach>``) are not read: compile them in MuJoCo and pass the `mujoco.MjModel`.

    A link without a name is "body_3", by its number in MuJoCo; a joint without a name is its link's with "_joint". A
    link with several joints has bones of length zero for all but the last. A joint that is not at the origin of its
    link has one bone to its point and a rigid one back. These bones are named by the joint with "_anchor", and count as
    points of the robot in distances unless `Skeleton.with_weights` sets them to zero.

    Examples
    --------
    >>> import io
    >>> from skpose.robots import load_robot
    >>> arm = load_robot(io.StringIO('''
    ...     <mujoco>
    ...       <worldbody>
    ...         <body name="upper_arm" pos="0 0 1">
    ...           <joint name="shoulder" axis="0 1 0" range="-90 90"/>
    ...           <body name="forearm" pos="0.3 0 0">
    ...             <joint name="elbow" axis="0 1 1"/>
    ...             <body name="hand" pos="0.25 0 0"/>
    ...           </body>
    ...         </body>
    ...       </worldbody>
    ...     </mujoco>'''))
    >>> arm.joint_names, arm.dof_names
    (('upper_arm', 'forearm', 'hand'), ('shoulder', 'elbow'))
    >>> arm.limits.round(2)
    array([[-1.57,  1.57],
           [ -inf,   inf]])
    """
    file = read_robot(path)
    robot = build_robot(file, root, held)
    if robot.notes:
        warn(f"{os.path.basename(file.name)}: {'; '.join(robot.notes)}")
    return robot.skeleton


# --- the file ---------------------------------------------------------------------------------------------------------


def read_robot(path: Any) -> RobotFile:
    """Compile the model of a file or an open file; a `mujoco.MjModel` is taken as it is."""
    try:
        import mujoco
    except ImportError:
        raise ImportError("robots need MuJoCo: pip install 'skpose[robot]'") from None
    if isinstance(path, mujoco.MjModel):
        constraints = [path.equality(i).name or f"number {i}" for i in range(path.neq) if path.eq_active0[i]]
        tendons = [path.tendon(i).name or f"number {i}" for i in range(path.ntendon)]
        return RobotFile("the model", path, False, _notes(constraints, tendons))
    if hasattr(path, "read"):
        name, content = str(getattr(path, "name", "the open file")), path.read()
    else:
        name, content = os.fspath(path), Path(path).read_bytes()
    text = _Text(name, path)
    simple = text.simplify(content)
    is_urdf = text.root == URDF
    if is_urdf and tuple(map(int, re.findall(r"\d+", mujoco.__version__)[:2])) < READS_URDF:
        raise ImportError(f"URDF files need MuJoCo 4.0 or later, found {mujoco.__version__}")
    with _collect_warnings(mujoco) as said:
        try:
            spec = mujoco.MjSpec.from_string(simple)
            constraints = [
                one.name or " and ".join(filter(None, (one.name1, one.name2))) for one in spec.equalities if one.active
            ]
            notes = _notes(constraints, [one.name or "unnamed" for one in spec.tendons])
            model = _compile_bodies(spec)
        except (ValueError, RuntimeError, mujoco.FatalError) as error:
            message = " ".join(str(error).split()).removeprefix("Error: ")
            raise MocapFormatError(name, None, f"MuJoCo cannot read this file: {message}") from None
    return RobotFile(name, model, is_urdf, (*notes, *dict.fromkeys(said)))


class _Text:
    """The text of a robot without geometry, motors and sensors, and with the files that it includes."""

    def __init__(self, name: str, path: Any):
        self.name, self.root = name, ""  # the first element
        self.folder = Path(path).resolve().parent if isinstance(path, str | os.PathLike) else None
        self.size, self.seen = 0, set[Path]()

    def simplify(self, content: bytes | str, times: int = 1, is_included: bool = False) -> str:
        """Write each element in its line, which MuJoCo's messages state; those of an included file in one."""
        text = content if isinstance(content, str) else content.decode("utf-8", errors="replace")
        parser = expat.ParserCreate()
        pieces: list[str] = []
        open_elements: list[tuple[str, int]] = []  # and how often MuJoCo repeats their content
        line, inside = 1, 0  # the last line, and the number of open elements around a cut

        def start(tag: str, attributes: dict[str, str]) -> None:
            nonlocal line, inside
            repeats = open_elements[-1][1] if open_elements else times
            is_part = tag in CUT and all(one[0] != "composite" for one in open_elements)
            if not inside and (tag == "include" or is_part):
                inside = len(open_elements) + 1
                if tag == "include":
                    pieces.append(self._included(attributes.get("file", ""), repeats))
            if tag in EXPANDED:
                repeats *= math.prod(map(int, re.findall(r"\d+", attributes.get("count", ""))))
            self.size += 0 if inside else repeats
            if self.size > MOST:
                raise self.error(f"the robot has more than {MOST} elements", parser.CurrentLineNumber)
            self.root = self.root or tag
            if self.root not in (MJCF, URDF):
                raise self.error(f"expected <mujoco> (MJCF) or <robot> (URDF), found <{tag}>")
            if self.root == URDF and tag.startswith("xacro:"):
                raise self.error("expected URDF, found a xacro template: expand it with xacro")
            if not (inside or (is_included and not open_elements)):
                before = "" if is_included else "\n" * (parser.CurrentLineNumber - line)
                pieces.append(f"{before}<{tag}{''.join(f' {k}={quoteattr(v)}' for k, v in attributes.items())}>")
                line = parser.CurrentLineNumber
            open_elements.append((tag, repeats))

        def end(tag: str) -> None:
            nonlocal inside
            if not (inside or (is_included and len(open_elements) == 1)):
                pieces.append(f"</{tag}>")
            inside = 0 if inside == len(open_elements) else inside
            open_elements.pop()

        def refuse(*_: object) -> None:
            raise self.error("expected no declarations of entities", parser.CurrentLineNumber)

        parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, refuse
        try:
            parser.Parse(text, True)
        except expat.ExpatError as error:
            raise self.error(f"expected XML: {expat.ErrorString(error.code)}", error.lineno) from None
        return "".join(pieces)

    def error(self, message: str, line: int | None = None) -> MocapFormatError:
        return MocapFormatError(self.name, line, message)

    def _included(self, file: str, times: int) -> str:
        """The content of an included file, in one line."""
        if self.folder is None:
            raise self.error(f"an open file cannot include {file!r}: pass its path")
        path = (self.folder / file).resolve()
        if not path.is_relative_to(self.folder):
            raise self.error(f"expected included files in the folder of this file, got {file!r}")
        if path in self.seen:
            raise self.error(f"{file!r} is included twice")
        self.seen.add(path)
        try:
            data = path.read_bytes()
        except OSError as error:
            raise self.error(f"cannot read the included {file!r}: {error.strerror}") from None
        return self.simplify(data, times, is_included=True)


def is_robot(path: Readable) -> bool:
    """Whether a file, or an open file of bytes, is a robot, by its beginning."""
    if isinstance(path, str | os.PathLike):
        with Path(path).open("rb") as file:
            return is_robot(file)
    return bool(re.match(ROBOT.signature, path.read(HEAD), re.DOTALL | re.IGNORECASE))


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


# --- the skeleton -----------------------------------------------------------------------------------------------------


def build_robot(file: RobotFile, root: str | None, held: Mapping[str, Any] | None) -> Robot:
    """Build the skeleton of the links below a root, with some joints held."""
    model = file.model
    bodies = [model.body(i).name or f"body_{i}" for i in range(model.nbody)]
    joints = _joints_of(file, bodies, held or {})
    free = {joint.body: joint for joint in joints if joint.kind == FREE}
    jointed = {joint.body for joint in joints if joint.kind != FREE}
    robots = [body for body in free if jointed & _below(model, body)]
    top = _choose_root(file, bodies, robots, root)
    inside = _below(model, top)
    for body in free.keys() - robots:  # a free link that carries no joints is an object next to the robot
        inside -= {body, *_below(model, body)}
    for name in (bodies[body] for body in robots if body in inside):
        raise file.error(f"{name!r} moves freely, and only a root can: pass root={name!r}, got {bodies[top]!r}")
    bones: list[Bone] = []
    columns: dict[str, Joint] = {}
    try:
        for body in sorted(inside):
            carrier = int(model.body_parentid[body])
            parent = None if carrier == top else bodies[carrier]
            place = np.array(model.body_pos[body]), _matrix(model.body_quat[body])
            own = [joint for joint in joints if joint.body == body]
            bones += _bones_of_body(bodies[body], parent, place, own, columns)
        if not columns:
            raise ValueError(f"{bodies[top]!r} carries no joint that moves")
        skeleton = Skeleton(bones, "parent")
    except ValueError as error:
        raise file.error(str(error)) from None
    notes = (*file.notes, *_left_out(model, bodies, joints, top, inside))
    return Robot(skeleton, top, bodies[top], tuple(joints), columns, free.get(top), notes)


def _joints_of(file: RobotFile, bodies: Sequence[str], held: Mapping[str, Any]) -> list[Joint]:
    """All joints of the model; one without a name has its link's name and "_joint"."""
    model = file.model
    names: list[str] = []
    for i, body in enumerate(model.jnt_bodyid):
        name = model.joint(i).name or f"{bodies[body]}_joint"
        while name in names:
            name += "_"
        names.append(name)
    if unknown := [name for name in held if name not in names]:
        raise file.error(
            f"held has an unknown joint, {unknown[0]!r}: {near_names(names, unknown[0], list_names(names))}"
        )
    joints = []
    for i, name in enumerate(names):
        kind, address = int(model.jnt_type[i]), int(model.jnt_qposadr[i])
        limits = tuple(model.jnt_range[i].tolist()) if model.jnt_limited[i] else None
        value = np.array(held[name], dtype=np.float64) if name in held else None
        if value is not None:
            if value.shape != SHAPES[kind] or not np.isfinite(value).all():
                raise file.error(f"held[{name!r}] must be finite, of shape {SHAPES[kind]}, got {held[name]!r}")
            if value.ndim == 0 and limits and not limits[0] - WITHIN <= value <= limits[1] + WITHIN:
                raise file.error(f"held[{name!r}] must be in [{limits[0]:.6g}, {limits[1]:.6g}], got {value:g}")
        body, point, axis = int(model.jnt_bodyid[i]), np.array(model.jnt_pos[i]), np.array(model.jnt_axis[i])
        joints.append(Joint(name, kind, body, address, point, axis, float(model.qpos0[address]), limits, value))
    return joints


def _choose_root(file: RobotFile, bodies: Sequence[str], robots: Sequence[int], root: str | None) -> int:
    """The link of this name; without a name, the one with joints that moves freely, or the world."""
    if root is not None:
        if root not in bodies:
            raise file.error(f"root is an unknown link, {root!r}: {near_names(bodies, root, list_names(bodies))}")
        return bodies.index(root)
    if len(robots) > 1:
        names = list_names(bodies[body] for body in robots)
        raise file.error(f"several links with joints move freely: choose root= among {names}")
    if robots:
        return robots[0]
    model = file.model
    first = np.flatnonzero(model.body_parentid[1:] == WORLD) + 1
    if file.is_urdf and len(first) == 1 and not model.body_jntnum[first[0]]:
        link = int(first[0])
        if not model.body_pos[link].any() and _matrix(model.body_quat[link]) is None:
            return link  # it has the world's coordinate system
    return WORLD


def _below(model: Any, top: int) -> set[int]:
    """The links that a link carries, without mocap bodies."""
    inside = {top}
    for body in range(1, model.nbody):  # parents first
        if int(model.body_parentid[body]) in inside and model.body_mocapid[body] < 0:
            inside.add(body)
    return inside - {top}


def _bones_of_body(
    name: str,
    parent: str | None,
    place: tuple[np.ndarray, np.ndarray | None],
    joints: Sequence[Joint],
    columns: dict[str, Joint],
) -> list[Bone]:
    """The bones from one link to the next: one for each joint, and a rigid one where the link is elsewhere."""
    offset, rest = place[0], np.eye(3) if place[1] is None else place[1]
    bones: list[Bone] = []
    for joint in joints:
        point = np.zeros(3) if joint.kind == SLIDE_JOINT else joint.point
        offset = offset + rest @ point
        if joint.kind == SLIDE_JOINT:
            offset = offset - joint.reference * (rest @ joint.axis)
        elif joint.kind == HINGE_JOINT and joint.reference:
            rest = rest @ Rotation.from_rotvec(-joint.reference * joint.axis).as_matrix()
        anchor = f"{joint.name}_anchor"
        bone = Bone(anchor, parent, offset + 0.0, DOFS[joint.kind], _exact(rest))
        if joint.kind != SPHERICAL:
            bone = bone._replace(
                limits=None if joint.limits is None else (joint.limits,), axis=joint.axis, dof_name=joint.name
            )
        if joint.held is not None:
            value = np.reshape(joint.held, (1, -1))
            offset = offset + rest @ (joint.axis * value[0] if joint.kind == SLIDE_JOINT else np.zeros(3))
            rest = rest @ rotations_of(bone, value).as_matrix()[0]
            offset = offset - rest @ point
            continue
        bones.append(bone)
        columns[anchor] = joint
        parent, offset, rest = anchor, -point, np.eye(3)
    if bones and not offset.any() and _exact(rest) is None:
        columns[name] = columns.pop(bones[-1].name)
        bones[-1] = bones[-1]._replace(name=name)
    else:
        bones.append(Bone(name, parent, offset + 0.0, "", _exact(rest)))
    return bones


def _matrix(quaternion: np.ndarray) -> np.ndarray | None:
    """The rotation matrix of a quaternion (w, x, y, z); None for the identity."""
    return _exact(Rotation.from_quat(quaternion[[1, 2, 3, 0]]).as_matrix())


def _exact(matrix: np.ndarray) -> np.ndarray | None:
    """A rotation matrix without rounding errors at 0, 1 and −1; None for the identity."""
    nearest = np.rint(matrix)
    matrix = np.where(np.abs(matrix - nearest) <= EXACT, nearest, matrix) + 0.0
    return None if (matrix == np.eye(3)).all() else matrix


def _left_out(model: Any, bodies: Sequence[str], joints: Sequence[Joint], top: int, inside: set[int]) -> list[str]:
    """What the skeleton leaves out: other links, joints above the root that are not held, limits."""
    chain = [top]
    while chain[-1] != WORLD:
        chain.append(int(model.body_parentid[chain[-1]]))
    others = [bodies[body] for body in range(1, model.nbody) if body not in inside.union(chain)]
    above = [joint.name for joint in joints if joint.body in chain and joint.kind != FREE and joint.held is None]
    balls = [joint.name for joint in joints if joint.kind == SPHERICAL and joint.limits and joint.body in inside]
    ends = zip(joints, model.jnt_range, strict=True)
    wrong = [one.name for one, (low, high) in ends if one.body in inside and one.limits is None and low > high]
    notes = {
        f"links that {bodies[top]!r} does not carry are left out": others,
        f"joints that carry {bodies[top]!r} move the root and have no columns": above,
        "limits of ball joints are not kept": balls,
        "limits in the wrong order are not kept": wrong,
    }
    return [f"{note}: {list_names(names)}" for note, names in notes.items() if names]
