"""Retargeting of a person's motion onto a robot, within its joint limits."""

from collections.abc import Mapping
from dataclasses import replace
from numbers import Real

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d
from scipy.spatial.transform import Rotation

from skpose._utils.sklearn import Interval, validate_params
from skpose._utils.warnings import warn
from skpose.kinematics import FittedPoses
from skpose.kinematics._anatomy import ANKLE, HIP, path_up
from skpose.kinematics._counterparts import check_counterparts
from skpose.kinematics._retarget import at_rest_in_words, joints_at_rest
from skpose.robots._stance import HEEL, TIP, Place, Stance, sole_of, stances_of
from skpose.robots._targets import STIFFNESS, Aim, aim_at, positions_in, solve
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import ROOT
from skpose.skeleton._root import continuous_root_angles
from skpose.skeleton._upright import axes_with_up_last

PERSON = 0.2, 1.5  # m, the shortest and the longest legs of people
# The heading first, so that no heading is near to where Euler angles jump for a root whose z axis is up.
ROOT_AXES = {"x": "XZY", "y": "YZX", "z": "ZYX"}
AT_LIMIT = 1e-9  # rad
NEARBY = 0.025  # s before and after, within which the person is as fast
FASTER = 1.0  # m/s above the person's, from which on the report names the speed
RAISED = 1e-3  # m, from which on the report names the height
AROUND = 0.1  # s before and after a frame, to blend the height


@validate_params(
    {
        "motion": [Motion],
        "robot": [Skeleton],
        "scale": [Interval(Real, 0, None, closed="neither"), None],
        "verbose": ["verbose"],
    },
    prefer_skip_nested_validation=True,
)
def retarget_to_robot(
    motion: Motion,
    robot: Skeleton,
    *,
    joints: Mapping[str, str] | None = None,
    scale: float | None = None,
    verbose: int = 0,
) -> Motion:
    """Retarget the motion of a person to a robot, in its own size and within its joint limits.

    Limbs point where the person's do, feet that stand are held still, and positions that the robot cannot reach are
    approached as closely as it can. It works for any skeleton of hinges with legs, arms or both.

    Parameters
    ----------
    motion : Motion
        The motion of a person, see the notes of `skpose.kinematics.retarget`.
    robot : Skeleton
        The robot's skeleton, such as from `load_robot`. Unitree G1, Booster T1, EngineAI PM01 and Galaxea R1 Pro are
        known by the names of their links; the limbs of others are found as a person's are, or given as `joints`.
    joints : mapping of str to str, default=None
        Joints of `robot` to their counterparts in ``motion.skeleton``: hips, knees and ankles, or shoulders, elbows and
        wrists, of both sides. None finds them.
    scale : float, default=None
        Factor of the distance travelled over the floor. None is the ratio of the lengths of the legs, which heights are
        always scaled by; with a larger factor steps may be longer than the legs reach.
    verbose : int, default=0
        Whether to print how many landmarks were found, how close soles and hands come to their targets (mean, 95th
        percentile), how much standing feet slide, how many joint limits are reached, and which joints stay at rest.

    Returns
    -------
    Motion
        On the robot's skeleton, at the same times, with the same axis up.

    Raises
    ------
    ValueError
        If hips, knees and ankles, or shoulders, elbows and wrists, are not known in both skeletons; if a foot of the
        robot has no joint at its front; if sides are exchanged; if the feet of the motion do not show how they stand.

    Warns
    -----
    UserWarning
        If the person's legs are shorter than 0.2 or longer than 1.5 m; if a foot turns by more than 60° between two
        frames; if the pelvis gets faster than the person's by 1 m/s.

    See Also
    --------
    skpose.kinematics.retarget : Retarget motions between rigs of people.
    qpos_from_motion : Convert the result to MuJoCo's ``qpos``.

    Notes
    -----
    *Targets.* The pelvis is where the person's is, in the size of the legs, above a floor at height zero. Pelvis and
    chest are oriented as the person's. Ankles are where the person's are relative to the hips, in the size of the legs,
    and knees bend to the same side; upper arms, forearms and hands point where the person's do. Forearm rolls, the head
    and joints without a counterpart stay at rest. A robot without legs stands on the floor below the person's hips.

    *Ground contact.* A foot stands while its ball is slower than 0.6 leg lengths per second, near the floor, within 5 %
    of a leg length of one place, and seen; it is flat while the ankle is slower than 0.35. There it is held still,
    level if the person's foot tilts by less than 24°, and blended in and out over 0.15 s. No corner of a sole is below
    the floor. If a leg cannot reach a standing foot, the pelvis moves closer.

    *Poses.* Inverse kinematics finds the poses nearest to pelvis, chest, knees, soles, elbows, wrists and hands, with
    the largest weight on the soles: within the joint limits, from frame to frame, and no angle faster than 20 rad/s.
    This takes some 0.12 ms per frame for 29 hinges.

    Examples
    --------
    >>> from skpose import Bone, Motion, Skeleton
    >>> from skpose.datasets import humanoid
    >>> from skpose.robots import retarget_to_robot
    >>> bones, joints = [], {}
    >>> for side, y in (("left", 0.1), ("right", -0.1)):
    ...     hip, knee, ankle, toe = (f"{side}_{name}" for name in ("hip", "knee", "ankle", "toe"))
    ...     bones.append(Bone(hip, None, (0, y, 0), "hinge", axis=(0, 1, 0)))
    ...     bones.append(Bone(knee, hip, (0, 0, -0.3), "hinge", axis=(0, 1, 0)))
    ...     bones.append(Bone(ankle, knee, (0, 0, -0.3), "hinge", axis=(0, 1, 0)))
    ...     bones.append(Bone(toe, ankle, (0.12, 0, -0.05)))
    ...     joints |= {hip: f"{side}_pelvis", knee: f"{side}_thigh", ankle: f"{side}_shank", toe: f"{side}_foot"}
    >>> biped, person = Skeleton(bones, "parent"), humanoid()
    >>> standing = Motion(person, [[0.0] * person.n_dofs] * 3, 30)
    >>> retarget_to_robot(standing, biped, joints=joints).root_positions.round(2)[0] + 0.0
    array([0.  , 0.64, 0.  ])
    """
    result, report = retarget_and_report(motion, robot, joints, scale)
    if verbose:
        print(report)
    return result


def retarget_and_report(
    motion: Motion, robot: Skeleton, joints: Mapping[str, str] | None, scale: float | None
) -> tuple[Motion, str]:
    """Retarget a motion, and state how close it came."""
    if joints is not None:
        check_counterparts(motion.skeleton, robot, joints)
    theirs, ours = stances_of(motion.skeleton, robot, None if joints is None else tuple(joints.items()))
    if not PERSON[0] <= theirs.leg() <= PERSON[1]:
        warn(f"the legs of the motion are {theirs.leg():.3g} m long: its unit is likely not metres")
    if not len(motion):
        return replace(motion, skeleton=robot, angles=np.zeros((0, robot.n_dofs)), seen=None), "limbs, no frames"
    aim = aim_at(motion, robot, theirs, ours, scale)
    final = solve(aim.skeleton, aim.targets, aim.bent, STIFFNESS, motion.times)
    soles = {}
    for side in aim.legs:
        (joint, axes), ankle = ours.feet[side], ours.places[f"{side}_{ANKLE}"].at_zero
        places = [Place(joint, ankle + axes @ corner) for corner in sole_of(ours, side).corners()]
        soles[side] = positions_in(final, robot, places)
    raised = _raise_above_floor([sole[:, :, 2].min(axis=1) for sole in soles.values()], motion.times)
    final = replace(final, root_positions=final.root_positions + raised)
    if aim.legs and len(motion) > 1:
        pelvis = positions_in(final, robot, [Place(ours.pelvis, ours.middle(HIP))])[:, 0]
        _warn_of_throws(pelvis, aim.paths["pelvis"], motion.times)
    roots, origins, vertical = final.root_rotations, final.root_positions, np.eye(3)[axes_with_up_last(motion.up)]
    if aim.is_on_base:  # exactly
        roots, origins = np.zeros_like(roots), np.zeros_like(origins)
    roots = Rotation.from_rotvec(roots).as_matrix()
    root_angles, root_axes = continuous_root_angles(Rotation.from_matrix(vertical.T @ roots), ROOT_AXES[motion.up])
    angles = np.tile(aim.rest, (len(motion), 1))
    angles[:, final.skeleton.columns_in(robot)] = final.poses
    result = replace(
        motion,
        skeleton=robot,
        angles=angles,
        root_positions=origins @ vertical,
        root_angles=root_angles,
        root_axes=root_axes,
        seen=_seen_of(motion, robot, theirs, ours),
    )
    tips = {side: sole[:, 2:].mean(axis=1) + raised for side, sole in soles.items()}
    return result, _report(robot, ours, final, aim, tips, float(raised.max()))


def _report(
    robot: Skeleton, ours: Stance, final: FittedPoses, aim: Aim, tips: dict[str, np.ndarray], raised: float
) -> str:
    """State how close a motion came to its targets."""
    words = ["limbs", *([ours.robot.name] if ours.robot else []), f"{len(ours.places)} places"]
    for name, groups in (("soles", ("left foot", "right foot")), ("hands", ("hands",))):
        if places := [i for i, target in enumerate(aim.targets) if target.group in groups]:
            off = final.residuals[:, -len(aim.targets) :][:, places]
            words.append(f"{name} {_mm(off.mean())} mm off (95 %: {_mm(np.percentile(off, 95))})")
    if aim.legs:
        stood = [tips[side][c.first : c.end] for side, leg in aim.legs.items() for c in leg.contacts]
        slides = [np.linalg.norm(points - points.mean(axis=0), axis=1).max() for points in stood]
        words.append(f"feet stand {len(slides)} times and slide by {_mm(max(slides, default=0.0))} mm at most")
    if raised >= RAISED:
        words.append(f"raised by up to {_mm(raised)} mm where soles would be below the floor")
    if final.skeleton.limits is not None:
        lower, upper = final.skeleton.limits.T
        reach = ((final.poses <= lower + AT_LIMIT) | (final.poses >= upper - AT_LIMIT)) & (lower < upper)
        words += [f"{n} angles reach their limits" for n in [reach.any(axis=0).sum()] if n]
    if not final.converged.all():
        words.append(f"{(~final.converged).sum()} of {len(final.poses)} frames did not converge")
    moving = {robot.joint_names.index(bone.name) for bone in final.skeleton.bones if bone.dofs} - set(aim.rolls)
    return ", ".join(words) + at_rest_in_words(robot, joints_at_rest(robot, moving))


def _mm(metres: float) -> str:
    return f"{float(f'{1e3 * metres:.2g}'):g}"


def _raise_above_floor(lowest: list[np.ndarray], times: np.ndarray) -> np.ndarray:
    """The shift (n_frames, 3) that raises soles, of these lowest heights (n_frames,), to the floor at zero.

    It changes slowly: the mean over the frames around of the largest shift around each.
    """
    raised = np.zeros((len(times), 3))
    raised[:, 2] = -np.min(lowest, axis=0, initial=0.0)
    if len(times) > 1:
        size = 2 * max(1, round(AROUND / float(np.median(np.diff(times))))) + 1
        raised[:, 2] = uniform_filter1d(maximum_filter1d(raised[:, 2], size, mode="nearest"), size, mode="nearest")
    return raised


def _warn_of_throws(ours: np.ndarray, theirs: np.ndarray, times: np.ndarray) -> None:
    """Warn if the path of a pelvis (n_frames, 3) is faster than the person's shortly before or after."""
    steps = np.diff(times)
    speeds, known = (np.linalg.norm(np.diff(path, axis=0), axis=1) / steps for path in (ours, theirs))
    around = 2 * int(np.ceil(NEARBY / float(np.median(steps)))) + 1
    thrown = speeds - maximum_filter1d(known, around, mode="nearest")
    if thrown.max() >= FASTER:
        most = f"{thrown.max():.2g} m/s"
        warn(f"the pelvis is up to {most} faster than the person's, in frame {thrown.argmax()}: check the recording")


def _seen_of(motion: Motion, robot: Skeleton, theirs: Stance, ours: Stance) -> np.ndarray | None:
    """Whether each joint of a robot was seen (n_frames, n_joints): if the landmarks around it were."""
    if motion.seen is None:
        return None
    shown: dict[int, np.ndarray] = {}  # by joint of the robot, whether its counterparts were seen
    for mark, place in ours.places.items():
        side, _, name = mark.partition("_")
        counterpart = theirs.toe(side) if name in (HEEL, TIP) else mark
        if counterpart in theirs.places:
            here = motion.seen[:, theirs.places[counterpart].joint]
            shown[place.joint] = shown.get(place.joint, True) & here
    seen, known = np.ones((len(motion), robot.n_joints), bool), np.zeros(robot.n_joints, bool)
    for joint, here in shown.items():
        path = [*path_up(robot, joint), ROOT]
        end = next(i for i, above in enumerate(path[1:], 1) if above in shown or above == ROOT)
        known[path[:end]] = True
        seen[:, joint] &= here
        seen[:, path[1:end]] &= (here & shown.get(path[end], True))[:, None]
    return seen & known
