"""The bones of a robot: its links, with the dofs of the joints between them, from MuJoCo's model.

MuJoCo places a link, its `body`, by its position and orientation in the axes of the link that carries it,
and then applies its joints one after another, each about an axis through a point of the link. Each step is a bone whose
dofs come last, of length zero where nothing is between two joints.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, NoReturn

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._validation.names import near_names
from skpose.io._robot_file import RobotFile, list_names
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._shared import BALL, HINGE, SLIDE

FREE, SPHERICAL, SLIDE_JOINT, HINGE_JOINT = range(4)  # mujoco.mjtJoint
DOFS = {SPHERICAL: BALL, SLIDE_JOINT: SLIDE, HINGE_JOINT: HINGE}  # of a bone
WORLD = 0  # MuJoCo's number of the world's body
IN_QPOS = {FREE: 7, SPHERICAL: 4, SLIDE_JOINT: 1, HINGE_JOINT: 1}  # numbers of a joint in qpos
EXACT = 1e-15  # entries of rotation matrices that differ by less from 0, 1 and −1 are these: quarter turns are exact
WITHIN = 1e-6  # rad or m, by which a held value may exceed the limits: the digits of a file
EXPECTED = {
    FREE: "seven numbers, the position, m, and the quaternion (w, x, y, z)",
    SPHERICAL: "a rotation vector, rad",
    SLIDE_JOINT: "a number, m",
    HINGE_JOINT: "a number, rad",
}
SHAPES: dict[int, tuple[int, ...]] = {FREE: (7,), SPHERICAL: (3,), SLIDE_JOINT: (), HINGE_JOINT: ()}

Held = Mapping[str, Any]


class Joint(NamedTuple):
    """A joint of the model."""

    name: str
    kind: int
    body: int
    address: int  # in qpos
    point: np.ndarray  # through which the axis passes, in the axes of the link
    axis: np.ndarray
    reference: float  # the number in qpos at which the link is as the file has it
    limits: tuple[float, float] | None
    held: np.ndarray | None  # the value at which it stays


class Column(NamedTuple):
    """The columns of a joint in a pose, and its numbers in qpos."""

    bone: str
    joint: Joint


class Robot(NamedTuple):
    """The skeleton of a robot, and where the numbers of its joints are in qpos."""

    skeleton: Skeleton
    root: int  # number of the link that is the root
    root_name: str
    joints: tuple[Joint, ...]  # of the whole model
    columns: tuple[Column, ...]  # in the order of the skeleton's columns
    free: Joint | None  # the free joint of the root
    notes: tuple[str, ...]  # what is not kept


def build_robot(file: RobotFile, root: str | None, held: Held | None) -> Robot:
    """Return the skeleton of a robot below a root, with some joints held, and what is not kept."""
    model = file.model
    bodies = _body_names(model)
    _check_finite(file, bodies)
    joints = _joints_of(file, bodies, held or {})
    of_body: dict[int, list[Joint]] = {}
    for joint in joints:
        of_body.setdefault(joint.body, []).append(joint)
    top = _choose_root(file, bodies, joints, root)
    inside = _without_objects(model, _below(model, top), joints)
    moving = [joint for joint in joints if joint.body in inside]
    if free := [joint for joint in moving if joint.kind == FREE]:
        raise file.error(
            f"root={bodies[top]!r} carries {bodies[free[0].body]!r}, which moves freely, and only the root of a "
            f"skeleton does: root={bodies[free[0].body]!r}"
        )
    taken = set(bodies)
    bones: list[Bone] = []
    columns: list[Column] = []
    for body in inside:
        carrier = int(model.body_parentid[body])
        parent = None if carrier == top else bodies[carrier]
        place = np.array(model.body_pos[body]), _matrix(model.body_quat[body])
        chain, found = _bones_of_body(bodies[body], parent, place, of_body.get(body, []), taken)
        bones += chain
        columns += found
    if not columns:
        held_too = " and is not held" if held else ""
        raise file.error(f"{bodies[top]!r} carries no joint that moves{held_too}, and a skeleton needs one")
    try:
        skeleton = Skeleton(bones, "parent")
    except ValueError as error:
        raise file.error(str(error)) from None
    own = [joint for joint in of_body.get(top, []) if joint.kind == FREE]
    notes = (*file.notes, *_left_out(model, bodies, joints, top, inside), *_limit_notes(model, moving))
    return Robot(skeleton, top, bodies[top], tuple(joints), tuple(columns), own[0] if own else None, notes)


def _body_names(model: Any) -> list[str]:
    """Return the names of the links; one without a name has its number in MuJoCo."""
    given = [model.body(i).name for i in range(model.nbody)]
    taken = set(given)
    return [name or _new_name(f"body_{i}", taken) for i, name in enumerate(given)]


def _check_finite(file: RobotFile, bodies: Sequence[str]) -> None:
    """Refuse links and joints whose place is no number."""
    model = file.model
    for what, owners, arrays in (
        ("its place", range(model.nbody), (model.body_pos, model.body_quat)),
        ("a joint", model.jnt_bodyid.tolist(), (model.jnt_pos, model.jnt_axis, model.qpos0[model.jnt_qposadr, None])),
    ):
        bad = ~np.all([np.isfinite(array).all(axis=1) for array in arrays], axis=0)
        if bad.any():
            name = bodies[owners[int(np.argmax(bad))]]
            raise file.error(f"link {name!r}: {what} has numbers that are not finite; expected finite ones (m, rad)")


def _new_name(name: str, taken: set[str]) -> str:
    """Return a name that is not among others, with underscores where it would be, and add it to these."""
    while name in taken:
        name += "_"
    taken.add(name)
    return name


def _joints_of(file: RobotFile, bodies: Sequence[str], held: Held) -> list[Joint]:
    """Return all joints of the model; one without a name has that of its link and "_joint"."""
    model = file.model
    given = [model.joint(i).name for i in range(model.njnt)]
    taken = set(given)
    names = [
        name or _new_name(f"{bodies[body]}_joint", taken)
        for name, body in zip(given, model.jnt_bodyid.tolist(), strict=True)
    ]
    if not isinstance(held, Mapping):
        raise TypeError(f"held must be a mapping of joints to values, got {type(held).__name__}")
    if unknown := [name for name in held if name not in names]:
        other = "the file has no joints" if not names else f"its joints are {list_names(names)}"
        raise file.error(f"held[{unknown[0]!r}] is no joint of this file: {near_names(names, str(unknown[0]), other)}")
    joints = []
    for i, name in enumerate(names):
        kind, address = int(model.jnt_type[i]), int(model.jnt_qposadr[i])
        limits = tuple(model.jnt_range[i].tolist()) if model.jnt_limited[i] else None
        joint = Joint(
            name,
            kind,
            int(model.jnt_bodyid[i]),
            address,
            np.array(model.jnt_pos[i]),
            np.array(model.jnt_axis[i]),
            float(model.qpos0[address]),
            limits,
            None,
        )
        joints.append(joint if name not in held else joint._replace(held=_check_held(file, joint, held[name])))
    return joints


def _check_held(file: RobotFile, joint: Joint, value: Any) -> np.ndarray:
    """Return the value of a joint that is held, as an array."""

    def refuse(expected: str) -> NoReturn:
        raise file.error(f"held[{joint.name!r}] must be {expected}, got {value!r}")

    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        refuse(EXPECTED[joint.kind])
    if array.shape != SHAPES[joint.kind] or not np.isfinite(array).all():
        refuse(EXPECTED[joint.kind])
    if joint.kind in (SLIDE_JOINT, HINGE_JOINT) and joint.limits is not None:
        lower, upper = joint.limits
        if not lower - WITHIN <= array <= upper + WITHIN:
            refuse(f"{EXPECTED[joint.kind]}, within its limits, {lower:.6g} to {upper:.6g}")
    return array


def _choose_root(file: RobotFile, bodies: Sequence[str], joints: Sequence[Joint], root: str | None) -> int:
    """Return the link of this name, or, without a name, the one with joints that moves freely, or the world."""
    if root is not None:
        if root not in bodies:
            other = f"its links are {list_names(bodies)}"
            raise file.error(f"root={root!r} is no link of this file: {near_names(bodies, str(root), other)}")
        return bodies.index(root)
    model = file.model
    carriers = {joint.body for joint in joints if joint.kind != FREE}
    free = [joint.body for joint in joints if joint.kind == FREE and carriers & set(_below(model, joint.body))]
    if len(free) > 1:
        raise file.error(
            f"{len(free)} links with joints move freely, {list_names(bodies[body] for body in free)}, and a skeleton "
            f"has one root: choose it, root={bodies[free[0]]!r}"
        )
    if free:
        return free[0]
    first = np.flatnonzero(model.body_parentid[1:] == WORLD) + 1
    if file.is_urdf and len(first) == 1 and not model.body_jntnum[first[0]] and not _is_moved(model, first[0]):
        return int(first[0])  # the first link, which stands in the world's axes
    return WORLD


def _is_moved(model: Any, body: int) -> bool:
    """Return whether a link stands elsewhere than the one that carries it."""
    return bool(model.body_pos[body].any()) or _matrix(model.body_quat[body]) is not None


def _below(model: Any, top: int) -> list[int]:
    """Return the links that a link carries, in MuJoCo's order, but for those that a program moves (mocap)."""
    inside = {top}
    for body in range(1, model.nbody):  # one that carries another comes before it
        if int(model.body_parentid[body]) in inside and body != top and model.body_mocapid[body] < 0:
            inside.add(body)
    return sorted(inside - {top})


def _without_objects(model: Any, inside: Sequence[int], joints: Sequence[Joint]) -> list[int]:
    """Return links without those that move freely and carry no joints: they are objects next to the robot."""
    jointed = {joint.body for joint in joints if joint.kind != FREE}
    left: set[int] = set()
    for joint in joints:
        if joint.kind == FREE and not jointed & {*(carried := _below(model, joint.body))}:
            left |= {joint.body, *carried}
    return [body for body in inside if body not in left]


def _bones_of_body(
    name: str, parent: str | None, place: tuple[np.ndarray, np.ndarray | None], joints: Sequence[Joint], taken: set[str]
) -> tuple[list[Bone], list[Column]]:
    """Return the bones from one link to the next: one for each joint, and a rigid one where the link is elsewhere."""
    offset, rest = place[0], np.eye(3) if place[1] is None else place[1]
    bones: list[Bone] = []
    columns = []
    for joint in joints:
        if joint.held is not None:
            shift, turn = _held_movement(joint)
            offset, rest = offset + rest @ shift, rest @ turn
            continue
        point = np.zeros(3) if joint.kind == SLIDE_JOINT else joint.point
        offset = offset + rest @ point
        if joint.kind == SLIDE_JOINT:
            offset = offset - joint.reference * (rest @ joint.axis)
        elif joint.kind == HINGE_JOINT and joint.reference:
            rest = rest @ _about(joint.axis, -joint.reference)
        anchor = _new_name(f"{joint.name}_anchor", taken)
        bone = Bone(anchor, parent, offset + 0.0, DOFS[joint.kind], _exact(rest))
        if joint.kind != SPHERICAL:
            limits = None if joint.limits is None else (joint.limits,)
            bone = bone._replace(limits=limits, axis=joint.axis, dof_name=joint.name)
        bones.append(bone)
        columns.append(Column(anchor, joint))
        parent, offset, rest = anchor, -point, np.eye(3)
    if bones and not offset.any() and _exact(rest) is None:
        bones[-1], columns[-1] = bones[-1]._replace(name=name), columns[-1]._replace(bone=name)
    else:
        bones.append(Bone(name, parent, offset + 0.0, "", _exact(rest)))
    return bones, columns


def _held_movement(joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """Return the shift and the rotation of a joint at the value at which it is held, in the axes of its link."""
    value: Any = joint.held
    if joint.kind == SLIDE_JOINT:
        return joint.axis * (value - joint.reference), np.eye(3)
    if joint.kind == HINGE_JOINT:
        turn = _about(joint.axis, value - joint.reference)
    else:
        turn = Rotation.from_rotvec(value).as_matrix()
    return joint.point - turn @ joint.point, turn


def _about(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the rotation by an angle about an axis of length one."""
    matrix: np.ndarray = Rotation.from_rotvec(axis * angle).as_matrix()
    return matrix


def _matrix(quaternion: np.ndarray) -> np.ndarray | None:
    """Return the rotation of a quaternion (w, x, y, z), None for none."""
    return _exact(Rotation.from_quat(quaternion[[1, 2, 3, 0]]).as_matrix())


def _exact(matrix: np.ndarray) -> np.ndarray | None:
    """Return a rotation without rounding errors at 0, 1 and −1; None for the identity."""
    nearest = np.rint(matrix)
    matrix = np.where(np.abs(matrix - nearest) <= EXACT, nearest, matrix) + 0.0
    return None if (matrix == np.eye(3)).all() else matrix


def _left_out(model: Any, bodies: Sequence[str], joints: Sequence[Joint], top: int, inside: Sequence[int]) -> list[str]:
    """Return what the skeleton leaves out: links elsewhere, and joints above the root that are not held."""
    chain = [top]
    while chain[-1] != WORLD:
        chain.append(int(model.body_parentid[chain[-1]]))
    others = [body for body in range(1, model.nbody) if body not in {*inside, *chain}]
    above = [joint.name for joint in joints if joint.body in chain and joint.kind != FREE and joint.held is None]
    notes = []
    if others:
        which = "are no part of it (objects, mocap)" if top == WORLD else f"{bodies[top]!r} does not carry"
        notes.append(f"links that {which} are left out: {list_names(bodies[i] for i in others)}")
    if above:
        notes.append(f"joints that carry {bodies[top]!r} move the root and are no columns: {list_names(above)}")
    return notes


def _limit_notes(model: Any, joints: Sequence[Joint]) -> list[str]:
    """Return which limits are not kept: those of ball joints, and those in the wrong order."""
    balls = [joint.name for joint in joints if joint.kind == SPHERICAL and joint.limits is not None]
    ranges = {int(model.jnt_qposadr[i]): model.jnt_range[i] for i in range(model.njnt)}
    wrong = [
        f"{joint.name!r} from {ranges[joint.address][0]:g} to {ranges[joint.address][1]:g}"
        for joint in joints
        if joint.limits is None and ranges[joint.address][0] > ranges[joint.address][1]
    ]
    notes = [f"limits of ball joints are not kept: {list_names(balls)}"] if balls else []
    return notes + ([f"limits in the wrong order are none: {', '.join(wrong[:5])}"] if wrong else [])
