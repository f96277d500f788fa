"""Motions of robots as MuJoCo's ``qpos``, and back."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation
from sklearn.utils import check_array

from skpose._utils.sklearn import validate_params
from skpose._utils.typing import ArrayLike
from skpose._utils.validation import check_choice, check_frame_rate, list_names
from skpose._utils.warnings import warn
from skpose.io._source import Readable
from skpose.robots._load import FREE, SPHERICAL, WORLD, Joint, Robot, RobotFile, build_robot, read_robot
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import mismatch, size_of
from skpose.skeleton._root import continuous_root_angles, root_orientations
from skpose.skeleton._rotation_forms import FORMS
from skpose.skeleton._rotations import continuous_columns, rotations_of

if TYPE_CHECKING:
    import mujoco

SAME = 1e-9  # m, and of entries of rotation matrices: the largest difference of equal bones
STAYS = 1e-6  # m or rad, the largest movement of a held joint or of a fixed root: float32
UPRIGHT, NEARLY_ALL = 0.8, 0.9  # cosine above which an axis points up; share of the frames
# The two numbers of a quaternion by which z tilts, in each order.
TILT = {"wxyz": [1, 2], "xyzw": [0, 1]}
OFTEN, RARER = 0.8, 0.3  # shares of the frames in which the root is upright in the other order, and is less often
FAR = 3.0  # times as far from the middle of the limits as these
# Quarter turns of the world after which z points up.
TO_Z_UP = {"x": Rotation.from_rotvec([0, -np.pi / 2, 0]), "y": Rotation.from_rotvec([np.pi / 2, 0, 0])}


@validate_params({"motion": [Motion]}, prefer_skip_nested_validation=True)
def qpos_from_motion(
    motion: Motion,
    path: "Readable | mujoco.MjModel",
    *,
    root: str | None = None,
    held: Mapping[str, ArrayLike] | None = None,
) -> np.ndarray:
    """Convert a motion of a robot to MuJoCo's ``qpos``, one row per frame.

    Parameters
    ----------
    motion : Motion
        On the skeleton of `load_robot`.
    path : str, path-like, file or mujoco.MjModel
        The robot: its file or its model.
    root : str, default=None
        As in `load_robot`.
    held : mapping of str to float or array-like, default=None
        As in `load_robot`, the values of all joints without columns: rad, m, a rotation vector in rad; for a free joint
        other than the root's, position and quaternion (w, x, y, z).

    Returns
    -------
    ndarray of shape (n_frames, nq)
        A free joint has the root's position, m, and its quaternion (w, x, y, z), a ball joint a quaternion, other
        joints rad or m. Quaternions are continuous in time, the first with w ≥ 0.

    Raises
    ------
    ImportError
        If MuJoCo is not installed.
    ValueError
        If the motion is not on the robot's skeleton with this `root` and `held`; if a joint has neither a column nor a
        held value; if the root moves and the robot has no free joint.

    Warns
    -----
    UserWarning
        If the motion's `up` is not z, but the root's z axis points along the world's z.

    See Also
    --------
    motion_from_qpos : The inverse.
    load_robot : Load the robot.

    Notes
    -----
    MuJoCo's z axis points up. Motions with another `up` are rotated by a quarter turn.

    Examples
    --------
    >>> import io
    >>> import numpy as np
    >>> from skpose import Motion
    >>> from skpose.robots import load_robot, qpos_from_motion
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
    file = read_robot(path)
    robot = build_robot(file, root, held)
    _check_skeleton(file, robot.skeleton, motion.skeleton)
    given = {joint.name for joint in (*robot.columns.values(), robot.free) if joint is not None}
    if missing := [joint.name for joint in robot.joints if joint.held is None and joint.name not in given]:
        raise file.error(f"the motion has no columns {list_names(missing)}: give their values with held=")
    qpos = np.zeros((len(motion), file.model.nq))
    for joint in robot.joints:
        if joint.held is not None:
            qpos[:, joint.in_qpos()] = _held_numbers(joint)
    columns = {name: i for i, name in enumerate(motion.skeleton.dof_names)}
    for name, joint in robot.columns.items():
        bone = motion.skeleton[name]
        angles = motion.angles[:, [columns[dof] for dof in bone.dof_names]]
        if joint.kind == SPHERICAL:
            angles = _continuous_quaternions(rotations_of(bone, angles)) if len(motion) else np.zeros((0, 4))
        qpos[:, joint.in_qpos()] = angles
    if len(motion):
        _place_root(file, robot, motion, qpos)
    return qpos


def motion_from_qpos(
    qpos: ArrayLike,
    path: "Readable | mujoco.MjModel",
    frame_rate: float,
    *,
    root: str | None = None,
    held: Mapping[str, ArrayLike] | None = None,
    quaternion: Literal["wxyz", "xyzw"] = "wxyz",
) -> Motion:
    """Convert MuJoCo's ``qpos``, one row per frame, to a motion on the robot's skeleton.

    Parameters
    ----------
    qpos : array-like of shape (n_frames, nq)
        As recorded in a simulation, see `qpos_from_motion`.
    path : str, path-like, file or mujoco.MjModel
        The robot: its file or its model.
    frame_rate : float
        Frames per second, Hz.
    root : str, default=None
        As in `load_robot`.
    held : mapping of str to float or array-like, default=None
        As in `load_robot`; these joints must have these values in all frames.
    quaternion : {"wxyz", "xyzw"}, default="wxyz"
        The order of quaternions: wxyz in MuJoCo, xyzw in Isaac Gym, ROS and tables of Unitree.

    Returns
    -------
    Motion
        On the skeleton of `load_robot`, with z up and the root where the link is in MuJoCo's world. Angles and rotation
        vectors are continuous in time.

    Raises
    ------
    ImportError
        If MuJoCo is not installed.
    ValueError
        If the number of columns is not the model's, quaternions are not of length one, or a held joint moves.

    Warns
    -----
    UserWarning
        If the root is upright, or goes forward, in the other order of quaternions alone; if a quarter of the joints
        are far beyond their limits, as in degrees; if the root is as high as ten robots, as in centimetres.

    See Also
    --------
    qpos_from_motion : The inverse.
    load_robot : Load the robot.

    Examples
    --------
    >>> import io
    >>> from skpose.robots import motion_from_qpos
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
    file = read_robot(path)
    robot = build_robot(file, root, held)
    check_frame_rate(frame_rate)
    check_choice("quaternion", quaternion, tuple(TILT))
    array = check_array(qpos, dtype=np.float64, ensure_min_samples=0, input_name="qpos", copy=True)
    if array.shape[1] != file.model.nq:
        raise ValueError(f"qpos must have shape (n_frames, {file.model.nq}), got {array.shape}")
    if robot.free is not None and len(array):
        _warn_of_root(array[:, robot.free.address :][:, :7], quaternion, robot)
    if quaternion == "xyzw":
        for joint in [joint for joint in robot.joints if joint.kind in (FREE, SPHERICAL)]:
            columns_of = np.arange(file.model.nq)[joint.in_qpos()][-4:]
            array[:, columns_of] = array[:, np.roll(columns_of, 1)]
    _check_held(file, robot, array)
    columns = []
    for name, joint in robot.columns.items():
        numbers = array[:, joint.in_qpos()]
        if joint.kind == SPHERICAL:
            bone = robot.skeleton[name]
            numbers = continuous_columns(bone, _rotations(numbers, joint)) if len(array) else np.zeros((0, 3))
        columns.append(numbers)
    positions, orientations = _root_in(file, robot, array)
    angles, axes = continuous_root_angles(orientations, "xyz") if len(array) else (np.zeros((0, 3)), "xyz")
    poses = np.concatenate(columns, axis=1)
    _warn_of_limits(poses, robot.skeleton)
    return Motion(robot.skeleton, poses, frame_rate, positions, angles, axes, up="z", root_name=robot.root_name)


def _warn_of_root(qpos: np.ndarray, quaternion: str, robot: Robot) -> None:
    """Warn if the columns (n, 7) of the root show another order of quaternions, or another unit of length.

    Where the root is upright in both orders its heading differs by half a turn, and the direction of the path decides.
    """
    numbers, size = qpos[:, 3:], size_of(robot.skeleton)
    upright = {
        order: np.mean(1.0 - 2.0 * (numbers[:, tilt] ** 2).sum(axis=1) > UPRIGHT) for order, tilt in TILT.items()
    }
    other = next(order for order in TILT if order != quaternion)
    w, x, y, z = numbers.T if quaternion == "wxyz" else np.roll(numbers, 1, axis=1).T
    forward, steps = np.stack([1.0 - 2.0 * (y**2 + z**2), 2.0 * (x * y + w * z)], axis=1), np.diff(qpos[:, :2], axis=0)
    length = np.linalg.norm(steps, axis=1).sum()
    is_backward = length > size and (steps * forward[:-1]).sum() < -length / 2.0
    found = ""
    if upright[other] > OFTEN and upright[quaternion] < upright[other] - RARER:
        found = f"upright in {upright[quaternion]:.0%} of the frames, and in {upright[other]:.0%}"
    elif upright[other] > OFTEN and is_backward:
        found = "going backward, and forward"
    if found:
        warn(f"the root is {found} with quaternion={other!r}, if that is the order of the table")
    if (height := float(np.median(np.abs(qpos[:, 2])))) > 10.0 * size:
        warn(f"the root is {height:.3g} m high, and the robot {size:.3g} m from end to end: positions are in metres")


def _warn_of_limits(poses: np.ndarray, skeleton: Skeleton) -> None:
    """Warn if many joints are far beyond their limits and half a turn, as angles in degrees are."""
    limits = np.full((1, 2), np.inf) if skeleton.limits is None else skeleton.limits
    limited = np.flatnonzero(np.isfinite(limits).all(axis=1) & (limits[:, 1] > limits[:, 0]))
    if len(poses) and len(limited):
        middle, half = limits[limited].mean(axis=1), np.diff(limits[limited], axis=1).ravel() / 2.0
        beyond = np.abs(poses[:, limited] - middle).max(axis=0) / half
        if np.mean((beyond > FAR) & (np.abs(poses[:, limited]).max(axis=0) > np.pi)) >= 0.25:
            warn(f"joints are up to {beyond.max():.3g} times as far from the middle as their limits: angles are in rad")


def _check_skeleton(file: RobotFile, skeleton: Skeleton, other: Skeleton) -> None:
    """Refuse a motion on another skeleton; the order of bones, limits and weights do not matter."""
    difference = mismatch(skeleton, other)
    if not difference:
        order = [other.joint_names.index(name) for name in skeleton.joint_names]
        apart = skeleton.offsets - other.offsets[order], skeleton.rest_rotations - other.rest_rotations[order]
        difference = "their bones differ" if max(np.abs(numbers).max() for numbers in apart) > SAME else ""
    if difference:
        raise file.error(f"the motion has another skeleton: {difference}; use the root= and held= of load_robot")


def _held_numbers(joint: Joint) -> np.ndarray:
    """The value of a held joint, as in qpos."""
    value: Any = joint.held
    return Rotation.from_rotvec(value).as_quat()[[3, 0, 1, 2]] if joint.kind == SPHERICAL else np.asarray(value)


def _check_held(file: RobotFile, robot: Robot, qpos: np.ndarray) -> None:
    """Refuse values of held joints that differ from those held."""
    for joint in [joint for joint in robot.joints if joint.held is not None and len(qpos)]:
        numbers, expected = qpos[:, joint.in_qpos()], _held_numbers(joint)
        if joint.kind in (FREE, SPHERICAL):
            signs = np.sign((numbers[:, -4:] * expected[-4:]).sum(axis=1))
            numbers = np.concatenate([numbers[:, :-4], numbers[:, -4:] * signs[:, None]], axis=1)
        away = np.abs(numbers - expected).reshape(len(qpos), -1).max(axis=1)
        if away.max() > STAYS:
            found = numbers[away.argmax()]
            raise file.error(f"joint {joint.name!r} is held at {expected}, got {found} at frame {away.argmax()}")


def _place_root(file: RobotFile, robot: Robot, motion: Motion, qpos: np.ndarray) -> None:
    """Write the root's position and orientation to its free joint; without one, refuse a root that moves."""
    positions, orientations = motion.root_positions, root_orientations(motion.root_angles, motion.root_axes)
    if robot.free is None:
        away = np.abs(positions - positions[0]).max(), (orientations * orientations[0].inv()).magnitude().max()
        if max(away) > STAYS:
            found = f"{away[0]:.3g} m and {away[1]:.3g} rad"
            raise file.error(f"{robot.root_name!r} has no free joint, but the motion's root moves by {found}")
        return
    if motion.up != "z":
        upward = orientations.apply([0.0, 0.0, 1.0])[:, 2]
        if (upward > UPRIGHT).mean() >= NEARLY_ALL:
            warn(f'motion.up is "{motion.up}", but z seems to point up: use dataclasses.replace(motion, up="z")')
        positions, orientations = TO_Z_UP[motion.up].apply(positions), TO_Z_UP[motion.up] * orientations
    at = robot.free.address
    qpos[:, at : at + 3], qpos[:, at + 3 : at + 7] = positions, _continuous_quaternions(orientations)


def _continuous_quaternions(rotations: Rotation) -> np.ndarray:
    """Quaternions (n, 4) of w, x, y, z without changes of sign; the first w ≥ 0."""
    quaternions = rotations.as_quat(canonical=True)[:, [3, 0, 1, 2]]
    signs = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    return quaternions * np.cumprod(np.concatenate([[1.0], signs]))[:, None] + 0.0


def _rotations(numbers: np.ndarray, joint: Joint) -> Rotation:
    """The rotations of quaternions (n, 4) of w, x, y, z."""

    def refuse(bad: np.ndarray, expected: str) -> None:
        if bad.any():
            frame = int(np.argmax(bad))
            raise ValueError(f"qpos of joint {joint.name!r} at frame {frame} {expected}, got {numbers[frame].tolist()}")

    return FORMS["quaternion_wxyz"].read(numbers, refuse)


def _root_in(file: RobotFile, robot: Robot, qpos: np.ndarray) -> tuple[np.ndarray, Rotation]:
    """Positions (n, 3) and orientations (n,) of the root in the world."""
    if robot.free is not None:
        at = robot.free.address
        return qpos[:, at : at + 3], _rotations(qpos[:, at + 3 : at + 7], robot.free)
    positions, quaternions = np.zeros((len(qpos), 3)), np.tile([1.0, 0.0, 0.0, 0.0], (len(qpos), 1))
    if robot.root != WORLD:
        import mujoco

        data = mujoco.MjData(file.model)
        for i, row in enumerate(qpos):
            data.qpos[:] = row
            mujoco.mj_kinematics(file.model, data)
            positions[i], quaternions[i] = data.xpos[robot.root], data.xquat[robot.root]
    return positions, Rotation.from_quat(quaternions[:, [1, 2, 3, 0]])
