"""Motions of robots as MuJoCo's ``qpos``, and back."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._typing import ArrayLike
from skpose._validation.motions import check_frame_rate
from skpose._validation.options import check_kind
from skpose._warnings import warn
from skpose.io._arguments import Readable
from skpose.io._qpos_checks import (
    STAYS,
    check_given,
    check_held_in,
    check_skeleton_of,
    columns_in_words,
    numbers_of_held,
)
from skpose.io._robot_bones import IN_QPOS, SPHERICAL, WORLD, Joint, Robot, build_robot
from skpose.io._robot_file import RobotFile, read_robot
from skpose.skeleton import Bone, Motion
from skpose.skeleton._shared import FORMS, continuous_columns, continuous_root_angles, root_orientations, rotations_of

if TYPE_CHECKING:
    import mujoco

UPRIGHT, NEARLY_ALL = 0.8, 0.9  # cosine above which an axis points up; share of the frames
# Quarter turns of the world after which z points up.
TO_Z_UP = {"x": Rotation.from_rotvec([0, -np.pi / 2, 0]), "y": Rotation.from_rotvec([np.pi / 2, 0, 0])}


def qpos_from_motion(
    motion: Motion,
    path: "Readable | mujoco.MjModel",
    *,
    root: str | None = None,
    held: Mapping[str, ArrayLike] | None = None,
) -> np.ndarray:
    """Return a motion of a robot as MuJoCo's ``qpos``, one row for each frame.

    Parameters
    ----------
    motion : Motion
        On the skeleton that `load_robot` read.
    path : str, path-like, file or mujoco.MjModel
        The robot: its file, or its model.
    root : str, default=None
        As in `load_robot`.
    held : mapping of str to float or array-like, default=None
        As in `load_robot`, the values of all joints that are no columns: rad, m, a rotation vector in rad; of a free
        joint other than the root's, as of an object next to the robot, position and quaternion (w, x, y, z).

    Returns
    -------
    ndarray of shape (n_frames, nq)
        With a free joint first the root's position, m, and its quaternion (w, x, y, z); then the joints, rad, in the
        order of the model; of a ball joint a quaternion. Quaternions are continuous: each is the one of ±q that is
        nearer to the one before, the first has w ≥ 0.

    Raises
    ------
    ImportError
        If MuJoCo is not installed.
    ValueError
        If the motion is not on the robot's skeleton with this root and these joints held: columns that are no joints,
        other bones, joints without a column that are not held; if the root moves and the robot has no free joint.

    Warns
    -----
    UserWarning
        If another axis than z points up in the motion, and the root's z axis points along the world's z nevertheless.

    See Also
    --------
    motion_from_qpos : The inverse.
    load_robot : Read the robot.

    Notes
    -----
    MuJoCo's z axis points up. A motion in which another axis does is rotated by a quarter turn of the world.

    Examples
    --------
    >>> import io
    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.io import load_robot, qpos_from_motion
    >>> robot = '''
    ...     <mujoco>
    ...       <worldbody>
    ...         <body name="base">
    ...           <freejoint/>
    ...           <body name="leg"><joint name="hip" axis="0 1 0"/><body name="foot" pos="0 0 -0.3"/></body>
    ...         </body>
    ...       </worldbody>
    ...     </mujoco>'''
    >>> swing = Motion(load_robot(io.StringIO(robot)), [[0.0], [0.5]], 30, [[0, 0, 0.3], [0.1, 0, 0.3]], up="z")
    >>> qpos_from_motion(swing, io.StringIO(robot))
    array([[0. , 0. , 0.3, 1. , 0. , 0. , 0. , 0. ],
           [0.1, 0. , 0.3, 1. , 0. , 0. , 0. , 0.5]])
    """
    check_kind(motion, Motion, "motion", "Motion(skeleton, poses, frame_rate, up='z') makes one of poses")
    file = read_robot(path, "qpos_from_motion")
    robot = build_robot(file, root, held)
    check_skeleton_of(file, robot, motion)
    check_given(file, robot)
    qpos = np.zeros((len(motion), file.model.nq))
    for joint in robot.joints:
        if joint.held is not None:
            qpos[:, joint.address : joint.address + IN_QPOS[joint.kind]] = numbers_of_held(joint)
    first = {}
    column = 0
    for bone in motion.skeleton.bones:
        first[bone.name] = column
        column += bone.n_dofs
    for name, joint in robot.columns:
        bone = motion.skeleton[name]
        angles = motion.angles[:, first[name] : first[name] + bone.n_dofs]
        if joint.kind == SPHERICAL:
            angles = _continuous_quaternions(rotations_of(bone, angles)) if len(motion) else np.zeros((0, 4))
        qpos[:, joint.address : joint.address + IN_QPOS[joint.kind]] = angles
    _place_root(file, robot, motion, qpos)
    return qpos


def motion_from_qpos(
    qpos: ArrayLike,
    path: "Readable | mujoco.MjModel",
    frame_rate: float,
    *,
    root: str | None = None,
    held: Mapping[str, ArrayLike] | None = None,
) -> Motion:
    """Return MuJoCo's ``qpos``, one row for each frame, as a motion on the robot's skeleton.

    Parameters
    ----------
    qpos : array-like of shape (n_frames, nq)
        As of a simulation, see `qpos_from_motion`.
    path : str, path-like, file or mujoco.MjModel
        The robot: its file, or its model.
    frame_rate : float
        Frames per second, Hz.
    root : str, default=None
        As in `load_robot`.
    held : mapping of str to float or array-like, default=None
        As in `load_robot`; in all frames these joints must stand at these values.

    Returns
    -------
    Motion
        On the skeleton that `load_robot` reads, with z up. The root is at the place that the link has in MuJoCo's
        world; angles and rotation vectors are continuous.

    Raises
    ------
    ImportError
        If MuJoCo is not installed.
    ValueError
        For another number of columns than the model has, quaternions that have not length one, a joint that is held
        and is elsewhere.

    See Also
    --------
    qpos_from_motion : The inverse.
    load_robot : Read the robot.

    Examples
    --------
    >>> import io
    >>> from skpose.io import motion_from_qpos
    >>> robot = '''
    ...     <mujoco>
    ...       <worldbody>
    ...         <body name="base">
    ...           <freejoint/>
    ...           <body name="leg"><joint name="hip" axis="0 1 0"/><body name="foot" pos="0 0 -0.3"/></body>
    ...         </body>
    ...       </worldbody>
    ...     </mujoco>'''
    >>> motion = motion_from_qpos([[0, 0, 0.3, 1, 0, 0, 0, 0], [0.1, 0, 0.3, 1, 0, 0, 0, 0.5]], io.StringIO(robot), 30)
    >>> motion, motion.root_name
    (Motion(2 frames at 30 Hz, 0.1 s, z up, Skeleton(n_joints=2, n_dofs=1)), 'base')
    >>> motion.angles
    array([[0. ],
           [0.5]])
    """
    file = read_robot(path, "motion_from_qpos")
    robot = build_robot(file, root, held)
    check_frame_rate(frame_rate)
    array = np.asarray(qpos, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != file.model.nq:
        raise ValueError(
            f"qpos must have shape (n_frames, {file.model.nq}), {columns_in_words(robot)}, got {array.shape}"
        )
    if not np.isfinite(array).all():
        frame, column = np.argwhere(~np.isfinite(array))[0]
        raise ValueError(f"qpos holds {array[frame, column]} at frame {frame}, column {column}")
    check_held_in(file, robot, array)
    columns = []
    for name, joint in robot.columns:
        numbers = array[:, joint.address : joint.address + IN_QPOS[joint.kind]]
        if joint.kind == SPHERICAL:
            numbers = _vectors(robot.skeleton[name], _rotations(numbers, joint))
        columns.append(numbers)
    positions, orientations = _root_in(file, robot, array)
    angles, axes = np.zeros((0, 3)), "xyz"
    if len(array):
        angles, axes = continuous_root_angles(orientations, "xyz")
    return Motion(
        robot.skeleton,
        np.concatenate(columns, axis=1),
        frame_rate,
        positions,
        angles,
        axes,
        up="z",
        root_name=robot.root_name,
    )


def _place_root(file: RobotFile, robot: Robot, motion: Motion, qpos: np.ndarray) -> None:
    """Write position and orientation of the root, where it has a free joint; refuse a movement where it has none."""
    if not len(motion):
        return
    positions, orientations = motion.root_positions, root_orientations(motion.root_angles, motion.root_axes)
    if robot.free is None:
        away = np.abs(positions - positions[0]).max(), (orientations * orientations[0].inv()).magnitude().max()
        if max(away) > STAYS:
            raise file.error(
                f"{robot.root_name!r} has no free joint, and the root of the motion moves, by {away[0]:.3g} m and "
                f"{away[1]:.3g} rad: motion.root_positions and motion.root_angles hold its movement, or add a "
                "<freejoint/> to the robot"
            )
        return
    if motion.up != "z":
        upward = orientations.apply([0.0, 0.0, 1.0])[:, 2]
        if (upward > UPRIGHT).mean() >= NEARLY_ALL:
            warn(
                f"{motion.up} is the axis that points up in this motion, and is turned to MuJoCo's z, but the root's z "
                'axis points along z in nearly all frames: if z is up, use dataclasses.replace(motion, up="z")'
            )
        positions, orientations = TO_Z_UP[motion.up].apply(positions), TO_Z_UP[motion.up] * orientations
    at = robot.free.address
    qpos[:, at : at + 3], qpos[:, at + 3 : at + 7] = positions, _continuous_quaternions(orientations)


def _continuous_quaternions(rotations: Rotation) -> np.ndarray:
    """Return rotations (n,) over time as quaternions (n, 4) of w, x, y, z without changes of sign; the first w ≥ 0."""
    quaternions = rotations.as_quat(canonical=True)[:, [3, 0, 1, 2]]
    signs = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    return quaternions * np.cumprod(np.concatenate([[1.0], signs]))[:, None] + 0.0


def _rotations(numbers: np.ndarray, joint: Joint) -> Rotation:
    """Return quaternions (n, 4) of w, x, y, z as rotations."""

    def refuse(bad: np.ndarray, expected: str) -> None:
        if bad.any():
            frame = int(np.argmax(bad))
            raise ValueError(f"qpos of joint {joint.name!r} at frame {frame} {expected}, got {numbers[frame].tolist()}")

    return FORMS["quaternion_wxyz"].read(numbers, refuse)


def _vectors(bone: Bone, rotations: Rotation) -> np.ndarray:
    return continuous_columns(bone, rotations) if len(rotations) else np.zeros((0, 3))


def _root_in(file: RobotFile, robot: Robot, qpos: np.ndarray) -> tuple[np.ndarray, Rotation]:
    """Return positions (n, 3) and orientations (n,) of the root in the world."""
    if robot.free is not None:
        at = robot.free.address
        return qpos[:, at : at + 3], _rotations(qpos[:, at + 3 : at + 7], robot.free)
    positions, quaternions = np.zeros((len(qpos), 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(qpos), 1))
    if robot.root != WORLD:
        import mujoco  # it has been imported to read the robot

        data = mujoco.MjData(file.model)
        for i, row in enumerate(qpos):
            data.qpos[:] = row
            mujoco.mj_kinematics(file.model, data)
            positions[i], quaternions[i] = data.xpos[robot.root], data.xquat[robot.root]
    return positions, Rotation.from_quat(quaternions[:, [1, 2, 3, 0]])
