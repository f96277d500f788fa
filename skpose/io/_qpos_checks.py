"""Checks of a motion and of ``qpos`` against the robot: that every number has its place, and every place a number."""

from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.io._robot_bones import FREE, IN_QPOS, SPHERICAL, Joint, Robot
from skpose.io._robot_file import RobotFile, list_names
from skpose.skeleton import Bone, Motion

SAME = 1e-9  # m, and of entries of rotation matrices: bones that differ by less are the robot's
STAYS = 1e-6  # m or rad, by which a joint that is held, or the root of a robot that is fixed, may move: float32


def check_skeleton_of(file: RobotFile, robot: Robot, motion: Motion) -> None:
    """Refuse a motion that is not on the robot's skeleton; the order of bones, limits and weights play no part."""
    ours, theirs = robot.skeleton, motion.skeleton
    remedy = "the motion must be on the skeleton of load_robot with the same root= and held="
    if unknown := [name for name in theirs.dof_names if name not in ours.dof_names]:
        root = (
            ": motion.without_root() gives the orientation back to the root" if unknown[0].startswith("root_") else ""
        )
        raise file.error(
            f"the motion has columns {list_names(unknown)}, which are no columns of this robot{root or f': {remedy}'}"
        )
    if missing := [name for name in ours.dof_names if name not in theirs.dof_names]:
        raise file.error(
            f"the motion has no columns {list_names(missing)}: {remedy}; joints that have no column are held at a "
            "value, held="
        )
    for bone in theirs.bones:
        if bone.name not in ours or not _is_same(bone, ours[bone.name]):
            raise file.error(f"the motion's bone {bone.name!r} is none of this robot: {remedy}")


def _is_same(bone: Bone, other: Bone) -> bool:
    """Return whether two bones of one name are at the same place, and rotate likewise."""

    def numbers(one: Bone) -> np.ndarray:
        rest = np.eye(3) if one.rest_rotation is None else np.asarray(one.rest_rotation)
        return np.concatenate([np.ravel(one.offset), np.ravel(rest), np.ravel(one.axis or ())])

    same = (bone.parent, bone.dofs) == (other.parent, other.dofs)
    return same and bool(np.abs(numbers(bone) - numbers(other)).max() <= SAME)


def check_given(file: RobotFile, robot: Robot) -> None:
    """Refuse joints of the model that have neither columns nor a value."""
    given = {joint.address for _, joint in robot.columns} | ({robot.free.address} if robot.free else set())
    missing = [joint for joint in robot.joints if joint.held is None and joint.address not in given]
    if missing:
        values = ", ".join(f"{joint.name!r}: {_initial_value(file, joint)}" for joint in missing)
        raise file.error(
            f"qpos has numbers of {list_names(joint.name for joint in missing)}, which {robot.root_name!r} does not "
            f"carry, so that the motion has none: give their values, such as held={{{values}}}"
        )


def _initial_value(file: RobotFile, joint: Joint) -> str:
    """Return in words the value of a joint at which its link is as the file has it."""
    numbers = [float(f"{x:.6g}") for x in file.model.qpos0[joint.address : joint.address + IN_QPOS[joint.kind]]]
    return str([0.0, 0.0, 0.0] if joint.kind == SPHERICAL else numbers if joint.kind == FREE else numbers[0])


def numbers_of_held(joint: Joint) -> np.ndarray:
    """Return the value of a joint that is held, as in qpos."""
    value: Any = joint.held
    if joint.kind != SPHERICAL:
        return np.asarray(value)
    quaternion: np.ndarray = Rotation.from_rotvec(value).as_quat()[[3, 0, 1, 2]]
    return quaternion


def check_held_in(file: RobotFile, robot: Robot, qpos: np.ndarray) -> None:
    """Refuse numbers of joints that are held and are elsewhere."""
    for joint in robot.joints:
        if joint.held is None or not len(qpos):
            continue
        numbers = qpos[:, joint.address : joint.address + IN_QPOS[joint.kind]]
        expected = numbers_of_held(joint)
        if joint.kind in (FREE, SPHERICAL):
            signs = np.sign((numbers[:, -4:] * expected[-4:]).sum(axis=1))
            numbers = np.concatenate([numbers[:, :-4], numbers[:, -4:] * signs[:, None]], axis=1)
        away = np.abs(numbers - expected).reshape(len(qpos), -1).max(axis=1)
        if away.max() > STAYS:
            frame = int(away.argmax())
            found = ", ".join(f"{x:.6g}" for x in numbers[frame])
            raise file.error(
                f"joint {joint.name!r} is held at {np.array2string(expected, precision=6)}, and in qpos it is at "
                f"{found} at frame {frame}: a joint that moves needs its column"
            )


def columns_in_words(robot: Robot) -> str:
    """Return what the columns of qpos are."""
    counts = {kind: sum(joint.kind == kind for joint in robot.joints) for kind in IN_QPOS}
    parts = [f"7 for a free joint × {counts[FREE]}" * bool(counts[FREE])]
    parts.append(f"4 for a ball joint × {counts[SPHERICAL]}" * bool(counts[SPHERICAL]))
    return " + ".join([*filter(None, parts), f"{len(robot.joints) - counts[FREE] - counts[SPHERICAL]} joints"])
