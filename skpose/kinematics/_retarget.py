"""Retargeting: the poses of a motion on another skeleton, which may be rigged differently."""

from collections.abc import Mapping
from dataclasses import replace
from numbers import Real
from typing import Literal

import numpy as np

from skpose._validation.skeletons import check_skeleton, limits_of
from skpose.kinematics._at_rest import in_words, joints_at_rest, movers_of, warn_of_ends
from skpose.kinematics._by_limbs._stances import stances_of, warn_of_sizes
from skpose.kinematics._by_limbs._targets import by_limbs
from skpose.kinematics._counterparts import Counterparts, counterparts
from skpose.kinematics._forward import forward_kinematics
from skpose.kinematics._inverse import inverse_kinematics
from skpose.kinematics._lengths import ratio_of_lengths
from skpose.kinematics._limits import check_within_limits
from skpose.kinematics._lines import find_lines, pair_of
from skpose.kinematics._orientations import by_orientations
from skpose.kinematics._rigs import HIP
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import check_rest_poses, mismatch, root_orientations, seen_of

Method = Literal["numbers", "orientations", "positions", "limbs", "auto", "unchecked"]
UNCHANGED = "same numbers"  # the report
METHODS = ("numbers", "orientations", "positions", "limbs", "auto", "unchecked")
LIMITS = (None, "ignore", "enforce")
OTHER_RIG = (
    'retarget(..., method="orientations") converts between rigs by the directions of the bones, method="positions" by '
    'the positions of the joints, and method="auto" by the first that can'
)
OTHER_REST = 'method="orientations" keeps the directions of the bones in the world, "unchecked" the numbers'


def retarget(
    motion: Motion,
    skeleton: Skeleton,
    *,
    method: Method = "numbers",
    joints: Mapping[str, str] | None = None,
    scale: float | Literal["lengths"] | None = None,
    joint_limits: Literal["ignore", "enforce"] | None = None,
    n_jobs: int | None = None,
    verbose: int = 0,
) -> Motion:
    """Return the poses of a motion on another skeleton.

    Poses are compared on one skeleton, such as `Skeleton.mean` of several people's. Where both skeletons have the same
    joints and dofs, the numbers of one are poses of the other. Where they are rigged differently, by other names, dofs,
    orders of Euler angles, rest poses or joints in between, the poses are converted.

    Parameters
    ----------
    motion : Motion
        The motion.
    skeleton : Skeleton
        The skeleton that the poses shall have.
    method : {"numbers", "orientations", "positions", "limbs", "auto", "unchecked"}, default="numbers"
        "numbers" takes the angles as they are, columns matched by dof name; the joints, parents and dofs must be the
        same. It refuses skeletons on which a bone's directions at angle zero, or the rest rotations of a joint with
        dofs, are more than 45° apart, as those of a T-pose and an A-pose. "unchecked" takes them at any difference.

        "orientations" converts the angles, and the root's orientation, so that every bone points in the world where its
        counterpart does. It is exact, and refuses what cannot be. "positions" finds the poses whose joints are nearest
        to their counterparts, by `inverse_kinematics`: joints with few dofs, such as hinges, come as near as they can.

        "limbs" is for robots and other skeletons of hinges, in their own size and within their limits: limbs point
        where the person's do, feet that stand are held still, and what cannot be reached comes as near as it can.

        "auto" is the first of "numbers", "orientations" and "positions" that can; of "numbers" and "limbs" for a
        skeleton with a hinge about any axis, such as a robot. `MotionDataset.retarget` states which it was.
    joints : mapping of str to str, default=None
        The counterpart of each joint: names of joints of `skeleton` to names of joints of ``motion.skeleton``. Joints
        that are left out have none. None takes those that `find_counterparts` finds by names: equal ones, and the
        joints of people whose rigs are known. The two roots are counterparts always.
    scale : float or "lengths", default=None
        Factor of positions in the world, m: of the root, and for "positions" of all joints. "lengths" is the ratio of
        the lengths, summed, of the bones that both skeletons have, between joints with counterparts: the motion as a
        person of the size of `skeleton` would perform it. Of people of different rigs it is that of legs and arms.
        None is 1, and "lengths" for "limbs", where it is the ratio of the legs. There a number is the factor of the way
        over the floor only, and heights are those of the legs: steps may be longer than legs reach.
    joint_limits : {"ignore", "enforce"}, default=None
        Whether angles are kept inside ``skeleton.limits``. By "positions" and "limbs" poses are found within them;
        "numbers" and "orientations" have no choice, and refuse a motion that leaves them. None enforces them by
        "limbs", if there are any, and ignores them by the others: people leave the limits of their files often.
    n_jobs : int, default=None
        For "positions", see `inverse_kinematics`; "limbs" follows a motion from frame to frame, on one thread.
    verbose : int, default=0
        Whether to print the method, how many joints have counterparts, how near they came, and which joints stay at
        rest, as `MotionDataset.retargeting` states it; for "positions" also the progress.

    Returns
    -------
    Motion
        Of the given skeleton, at the same times.

    Raises
    ------
    ValueError
        If the method cannot, see above; the message names the joint and the remedy. If `joints` has an unknown name, or
        one counterpart for two joints. Without `joints`, if an arm, a leg or as long a part of `skeleton` has no
        counterpart, so that it would stay at rest, or if the names of one skeleton do not mean a person's joints.

    Warns
    -----
    UserWarning
        By orientations without `joints`, if a hand, a foot or the head stays at rest that has a bone in both. By limbs,
        if the motion's legs are shorter than 0.2 or longer than 1.5 m, if one of its feet turns by more than 60° from
        one frame to the next, and if no point of the soles of `skeleton` is known.

    See Also
    --------
    find_counterparts : Return the counterparts that are taken without `joints`.

    Notes
    -----
    By orientations, the counterpart of a bone is the line between the counterparts of its ends, or, where its near end
    has none, the bone that ends at the counterpart of its far end. Joints that carry no bone with a counterpart keep
    their rest pose relative to their parent. Twists about bones are those of the counterpart. The bones that one joint
    carries together, such as those of the pelvis, are fitted by least squares, as no joint can bend them; beyond 45°
    they are refused. A bone that is shorter than a thousandth of the longest has no direction.

    A root that carries no bone by itself takes the orientation of the motion's root, rotated by those quarter turns
    that bring the two rest poses nearest to each other: files differ in the axes that point up and forward.

    In people of known rigs, see `find_counterparts`, bones to the hips and from the spine to the shoulders are as steep
    as the rig has them. For these the line from side to side is the counterpart. Bones of a limb without counterparts
    point along the line between the joints around them that have some. A foot whose counterpart has no joint at the
    ball points as a whole to where the toe is. The middle between the hips stays in its place,
    and not the root, which is higher up in some rigs.

    By positions, lengths differ unless the skeletons are of one person; then no pose has the joints where their
    counterparts are, and directions differ by some degrees. Prefer orientations where they can. Twists about bones at
    the end of a chain are not seen, and are those of the rest pose. The root's place and orientation follow from
    the joints that have counterparts, not from the motion's root: fewer than three joints do not show them. In people
    of known rigs joints of the trunk, and ends of hands, feet and head, are at other places in each rig, and have no
    part in it unless `joints` names them.

    By limbs, both need hips, knees and ankles, or shoulders, elbows and wrists: of known rigs, of the robots Unitree
    G1, Booster T1, EngineAI PM01 and Galaxea R1 Pro, or by `joints`. The pelvis is where the person's is, in the size
    of the legs, above a floor at zero on which the person's feet stand; pelvis and chest are rotated as the person's,
    as near as the trunk can. From its own hips, ankles are where the person's are, in the size of the legs, and knees
    bend to the side to which the person's do; from its own shoulders, upper arms, forearms and hands point as the
    person's. A foot stands while its ball is slower than 0.6 legs a second, near the floor, within 5 % of a leg of one
    place, and seen; it is flat while the ankle is below 0.35. There it is held, level where the person's tilt is below
    24°, and blended in and out over 0.15 s, and longer where the foot would go from one place to the next at more than
    half a leg a second. A foot that slides on stands nowhere. No corner of a sole is below the floor. Heights of
    standing feet within 6 % of a leg are one floor. Where a leg cannot reach a foot that stands, the pelvis
    comes nearer. Then inverse kinematics finds the poses nearest to the pelvis, the chest, knees, soles, elbows, wrists
    and hands, of which soles count most: within the limits, from frame to frame, no angle faster than 20 rad/s. Rolls
    of forearms, heads, and all that has no counterpart, stay at rest. A robot without legs stands on the floor below
    the person's hips. How the root of a robot is turned at angle zero is seen by its hips and shoulders; the motion
    keeps the axis of the world that points up. Where the motion's skeleton does not stand at angle zero, its feet are
    level as they are where they stand flat. Some 0.12 ms a frame for 29 hinges.

    By limbs the report has the distances of soles and hands from where they shall be, the mean and that of 95 %, and by
    how much toes move at most while they stand: above some mm what the person does is beyond what the robot can; and
    whether toes or pelvis are faster than the person's by 1 m/s, or the robot was raised by 1 mm for its soles.

    Examples
    --------
    A leg of ZXY angles, as in BVH files, on a leg of ball joints with other names:

    >>> import numpy as np
    >>> from skpose import Bone, Motion, Skeleton, forward_kinematics
    >>> from skpose.kinematics import retarget
    >>> bvh = Skeleton([Bone("Leg", None, (0, -0.4, 0), "ZXY"), Bone("Foot", "Leg", (0, -0.4, 0))], "parent")
    >>> balls = Skeleton([Bone("thigh", None, (0, 0, -0.5), "rotvec"), Bone("shank", "thigh", (0, 0, -0.5), "rotvec")])
    >>> lift = Motion(bvh, [[0, np.pi / 2, 0]], frame_rate=30)
    >>> there = retarget(lift, balls, method="orientations", joints={"thigh": "Leg", "shank": "Foot"}, scale="lengths")
    >>> forward_kinematics(there.angles, balls).round(3) + 0.0  # in the axes of the root
    array([[[ 0. , -0.5,  0. ],
            [ 0. , -0.5, -0.5]]])
    """
    result, report = retarget_and_report(motion, skeleton, method, joints, scale, joint_limits, n_jobs, verbose)
    if verbose:
        print(report)
    return result


def retarget_and_report(
    motion: Motion,
    skeleton: Skeleton,
    method: Method,
    joints: Mapping[str, str] | None,
    scale: float | Literal["lengths"] | None,
    joint_limits: Literal["ignore", "enforce"] | None,
    n_jobs: int | None,
    verbose: int,
) -> tuple[Motion, str]:
    """Return the motion on another skeleton, and in words which method it was and how near it came."""
    if not isinstance(motion, Motion):
        raise TypeError(f"motion must be a skpose.Motion, got {type(motion).__name__}")
    if method not in METHODS:
        raise ValueError(f"method must be {', '.join(map(repr, METHODS[:-1]))} or {METHODS[-1]!r}, got {method!r}")
    check_skeleton(skeleton)
    is_number = isinstance(scale, Real) and not isinstance(scale, bool) and 0.0 < scale < np.inf
    if not (scale is None or (isinstance(scale, str) and scale == "lengths") or is_number):
        raise ValueError(f'scale must be a positive number, or "lengths", got {scale!r}')
    if joint_limits not in LIMITS:
        raise ValueError(f'joint_limits must be "ignore", "enforce" or None, got {joint_limits!r}')
    if joints is not None and method in ("numbers", "unchecked"):
        raise ValueError(f'method="{method}" matches dofs by name, and joints= is for other methods: {OTHER_RIG}')
    if method == "auto":
        # Numbers match the names of dofs: where counterparts are given they are not taken.
        is_robot = any(bone.is_hinge for bone in skeleton.bones)
        tried: list[Method] = ["numbers"] if joints is None else []
        tried += [] if is_robot else ["orientations"]
        for first in tried:
            try:
                return retarget_and_report(motion, skeleton, first, joints, scale, joint_limits, n_jobs, verbose)
            except ValueError:
                if not is_robot:
                    counterparts(motion.skeleton, skeleton, joints)  # raises what no method can mend
        method = "limbs" if is_robot else "positions"
    if method == "limbs":
        return _by_limbs(motion, skeleton, joints, scale, joint_limits)
    result, report = _by_counterparts(motion, skeleton, method, joints, scale, joint_limits, n_jobs, verbose)
    if joint_limits == "enforce":
        check_within_limits(result, method)
    return result, report


def _by_limbs(
    motion: Motion,
    skeleton: Skeleton,
    joints: Mapping[str, str] | None,
    scale: float | Literal["lengths"] | None,
    joint_limits: Literal["ignore", "enforce"] | None,
) -> tuple[Motion, str]:
    """Return the motion on a skeleton of hinges, and how near it came."""
    theirs, ours = stances_of(motion.skeleton, skeleton, joints)
    warn_of_sizes(theirs, ours)
    if joint_limits == "enforce":
        limits_of(skeleton)
    if not len(motion):
        return replace(motion, skeleton=skeleton, angles=np.zeros((0, skeleton.n_dofs)), seen=None), "limbs, no frames"
    factor = None if scale is None or isinstance(scale, str) else float(scale)
    fitted = by_limbs(motion, skeleton, theirs, ours, factor, joint_limits or "enforce")
    at_rest = joints_at_rest(skeleton, fitted.moving)
    return fitted.motion, f"limbs, {ours.in_words()}{fitted.in_words()}{in_words(skeleton, at_rest)}"


def _by_counterparts(
    motion: Motion,
    skeleton: Skeleton,
    method: Method,
    joints: Mapping[str, str] | None,
    scale: float | Literal["lengths"] | None,
    joint_limits: Literal["ignore", "enforce"] | None,
    n_jobs: int | None,
    verbose: int,
) -> tuple[Motion, str]:
    """Return the motion by the numbers, the orientations or the positions of joints, and how near it came."""
    scale = 1.0 if scale is None else scale
    if method in ("numbers", "unchecked"):
        angles = _same_numbers(motion, skeleton, method)
        pairs = counterparts(motion.skeleton, skeleton, None) if scale == "lengths" else None
        factor = float(scale) if pairs is None else _ratio(motion, skeleton, pairs)
        result = replace(
            motion,
            skeleton=skeleton,
            angles=angles,
            root_positions=factor * motion.root_positions,
            seen=seen_of(motion.seen, motion.skeleton.joint_names, skeleton.joint_names),
        )
        return result, UNCHANGED
    found = counterparts(motion.skeleton, skeleton, joints)
    factor = _ratio(motion, skeleton, found) if scale == "lengths" else float(scale)
    if method == "positions":
        return _by_positions(motion, skeleton, found, factor, joint_limits or "ignore", n_jobs, verbose)
    lines = find_lines(motion.skeleton, skeleton, found.there, found.people)
    result, apart, at_rest = by_orientations(motion, skeleton, found.there, lines)
    if joints is None:
        warn_of_ends(motion.skeleton, skeleton, found, at_rest)
    report = f"orientations, {found.in_words()}, directions within {round(apart, 2):g}°{in_words(skeleton, at_rest)}"
    return replace(result, root_positions=_root_positions(motion, result, found, factor)), report


def _ratio(motion: Motion, skeleton: Skeleton, found: Counterparts) -> float:
    """Return the ratio of the lengths of the bones that both skeletons have."""
    return ratio_of_lengths(motion.skeleton, skeleton, found.there, found.measured)


def _root_positions(motion: Motion, result: Motion, found: Counterparts, factor: float) -> np.ndarray:
    """Return the positions (n_frames, 3) of the root of a result, times a factor.

    In people of known rigs it is the middle between the hips that stays where it is: roots are above it in some rigs.
    """
    hips = [pair_of(person, HIP) for person in found.people or ()]
    if not hips or None in hips:
        return factor * motion.root_positions
    middles = [_middle(one, pair) for one, pair in zip((motion, result), hips, strict=True) if pair is not None]
    return factor * middles[0] + (result.root_positions - middles[1])


def _middle(motion: Motion, pair: tuple[int, int]) -> np.ndarray:
    """Return the positions (n_frames, 3) of the middle between two joints in the world."""
    middle = forward_kinematics(motion.angles, motion.skeleton)[:, pair].mean(axis=1)
    return root_orientations(motion.root_angles, motion.root_axes).apply(middle) + motion.root_positions


def _same_numbers(motion: Motion, skeleton: Skeleton, method: str) -> np.ndarray:
    """Return the angles in the order of the dofs of another skeleton with the same joints and dofs."""
    difference = mismatch(motion.skeleton, skeleton)
    if difference:
        raise ValueError(f"the motion's angles do not carry over to this skeleton: {difference}. {OTHER_RIG}")
    if method == "numbers":
        check_rest_poses([motion.skeleton, skeleton], ["the motion's skeleton", "the given one"], OTHER_REST)
    column = {name: i for i, name in enumerate(motion.skeleton.dof_names)}
    return motion.angles[:, [column[name] for name in skeleton.dof_names]]


def _by_positions(
    motion: Motion,
    skeleton: Skeleton,
    pairs: Counterparts,
    factor: float,
    joint_limits: str,
    n_jobs: int | None,
    verbose: int,
) -> tuple[Motion, str]:
    """Return the motion whose joints are nearest to their counterparts, in the world times a factor."""
    count = pairs.in_words(by_place=True)
    if not len(motion):
        seen = np.zeros((0, skeleton.n_joints), bool)
        nothing = replace(motion, skeleton=skeleton, angles=np.zeros((0, skeleton.n_dofs)), seen=seen)
        return nothing, f"positions, {count}"
    root = root_orientations(motion.root_angles, motion.root_axes)
    positions = forward_kinematics(motion.angles, motion.skeleton)
    wished = np.full((len(motion), skeleton.n_joints, 3), np.nan)
    for joint in np.flatnonzero(pairs.placed):
        wished[:, joint] = factor * (root.apply(positions[:, pairs.there[joint]]) + motion.root_positions)
    fitted = inverse_kinematics(wished, skeleton, joint_limits=joint_limits, n_jobs=n_jobs, verbose=verbose)
    result = replace(
        fitted.to_motion(motion.frame_rate, motion.up), frame_numbers=motion.frame_numbers, root_name=motion.root_name
    )
    if motion.seen is not None and result.seen is not None:
        result = replace(result, seen=result.seen & motion.seen[:, pairs.there])
    at_rest = joints_at_rest(skeleton, movers_of(skeleton, np.flatnonzero(pairs.placed)))
    apart = round(100.0 * float(np.nanmax(fitted.residuals)), 2)
    return result, f"positions, {count} within {apart:g} cm{in_words(skeleton, at_rest)}"
