"""Retargeting: the poses of a motion on another skeleton, which may be rigged differently."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from skpose._utils.validation import check_choice, check_kind, check_limits, check_positive, check_skeleton
from skpose._utils.warnings import warn
from skpose.kinematics._anatomy import ANKLE, HEAD, SIDES, WRIST, Anatomy, find_anatomy, path_up
from skpose.kinematics._counterparts import Counterparts, check_limbs, counterparts, ratio_of_lengths
from skpose.kinematics._floor import keep_feet, leg_length
from skpose.kinematics._inverse import inverse_kinematics
from skpose.kinematics._orientations import by_orientations
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._interpolation import seen_of
from skpose.skeleton._rest import ROOT, check_rest_poses, directions_at_zero, find_carriers, find_movers, mismatch

Method = Literal["numbers", "orientations", "positions", "auto", "unchecked"]
METHODS = ("numbers", "orientations", "positions", "auto", "unchecked")
UNCHANGED = "same numbers"  # the report
ROUNDING = 1e-12  # of a ratio of lengths
SHOWN, SHOWN_FACTOR, SHOWN_DISTANCE = 6, 5e-3, 5e-4  # names, least change of size, and m, in a report
# The last joints of a person's limbs, and of the trunk, beyond which hands, feet and the head are.
LAST = (*(f"{side}_{mark}" for side in SIDES for mark in (WRIST, ANKLE)), HEAD)


def retarget(
    motion: Motion,
    skeleton: Skeleton | Motion,
    *,
    method: Method = "numbers",
    joints: Mapping[str, str | None] | None = None,
    scale: float | Literal["lengths"] | None = None,
    joint_limits: Literal["ignore", "enforce"] = "ignore",
    n_jobs: int | None = None,
    verbose: int = 0,
) -> Motion:
    """Retarget a motion to another skeleton.

    Poses are compared on one skeleton, such as `Skeleton.mean` of several people's. If both skeletons have the same
    joints and dofs, the angles of one are poses of the other. If they differ in names, dofs, orders of Euler angles,
    rest poses or joints in between, the poses are converted.

    Parameters
    ----------
    motion : Motion
        The motion.
    skeleton : Skeleton or Motion
        The skeleton to retarget to, or a motion on it. If the rest pose is not a standing one, as in files whose bones
        all point along one axis, a motion with bent limbs shows in which direction knees and elbows bend.
    method : {"numbers", "orientations", "positions", "auto", "unchecked"}, default="numbers"
        "numbers" keeps the angles, with columns matched by dof name; joints, parents and dofs must be equal, and
        the directions of bones and the rest rotations at most 45° apart, so that a T-pose is not taken for an A-pose.
        "unchecked" is the same without the limit of 45°.

        "orientations" converts the angles and the root's orientation. Limbs point in the world where their counterparts
        do and bend about the same axes; pelvis, chest, head and feet are oriented as theirs. It is exact, except that
        legs move a little so that feet stand, or raises an error.

        "positions" finds the poses whose joints are nearest to their counterparts, by `inverse_kinematics`.

        "auto" is the first of "numbers", "orientations" and "positions" that is possible. Skeletons of hinges, such as
        robots, need `skpose.robots.retarget_to_robot` instead.
    joints : mapping of str to str or None, default=None
        Joints of `skeleton` to their counterparts in ``motion.skeleton``, or to None for joints to leave at rest. The
        others are found: joints at the same place of a person, else joints of equal names. The roots are always
        counterparts.
    scale : float or "lengths", default=None
        Factor of positions in the world: of the root, and with "positions" of all joints. None is the ratio of the
        lengths of the legs between people, whose feet then stand on the floor, and 1 otherwise; 1 keeps metres.
        "lengths" is the ratio of the lengths of the bones between counterparts.
    joint_limits : {"ignore", "enforce"}, default="ignore"
        "enforce" keeps angles inside ``skeleton.limits``: "positions" finds such poses, other methods raise an error
        for a motion that leaves the limits.
    n_jobs : int, default=None
        Number of threads of "positions", see `inverse_kinematics`.
    verbose : int, default=0
        Whether to print the method, the number of counterparts, the largest error and which joints stay at rest, as in
        `MotionDataset.retargeting`.

    Returns
    -------
    Motion
        On `skeleton`, at the same times.

    Raises
    ------
    ValueError
        If the method is not possible; if `joints` has unknown names or one counterpart for two joints; if an arm, a leg
        or as long a part of `skeleton` has no counterpart, except where `joints` uses all limbs of the motion.

    Warns
    -----
    UserWarning
        With "orientations", if a hand, a foot or the head stays at rest, or if nothing shows in which direction a knee
        or an elbow bends.

    See Also
    --------
    skpose.robots.retarget_to_robot : Retarget a person's motion to a robot.

    Notes
    -----
    *People* are found by structure and by names, in any rig: a pair of equal legs that start near the root, a pair of
    equal arms higher up, and a head. Names give the sides, such as "Left", "left" or "左". In each limb the joints are
    those whose distances are a person's, so "LeftLeg" may be the thigh or the shank; words in names decide if several
    would fit. ``skpose info FILE`` prints which joint is where. Joints of trunk and neck are matched by their share of
    the length, and joints of equal names attached to counterparts, such as fingers, by name.

    *Orientations.* The axes of pelvis, chest, head and feet at angle zero are forward, left and up. A thigh, shank,
    upper arm or forearm has its own direction, and the axis about which the knee or elbow bends: that of a hinge; or by
    the rest pose, if the person stands there; or the mean over the frames in which the limb is bent. Other bones are
    parallel to the line between the counterparts of their ends. Joints without counterparts rest.

    *Feet.* The root is moved so that the feet that stand are where the motion's are, times the ratio of the lengths of
    the legs. The distance between the feet changes by the difference in the width of the hips. With "orientations",
    thighs rotate by about 2° and knees bend by up to 1.8° to remove what is left, and the report includes it.

    *Positions.* Bones of other lengths leave some centimetres and degrees; prefer orientations where possible. Twists
    at the end of a chain are not determined, and stay at rest. At least three joints need counterparts. In people,
    joints of the trunk and ends of hands, feet and head are not used unless `joints` names them.

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
    >>> forward_kinematics(there.angles, balls).round(3) + 0.0  # relative to the root
    array([[[ 0. , -0.5,  0. ],
            [ 0. , -0.5, -0.5]]])
    """
    result, report = retarget_and_report(motion, skeleton, method, joints, scale, joint_limits, n_jobs, verbose)
    if verbose:
        print(report)
    return result


def retarget_and_report(
    motion: Motion,
    skeleton: Skeleton | Motion,
    method: Method,
    joints: Mapping[str, str | None] | None,
    scale: float | Literal["lengths"] | None,
    joint_limits: str,
    n_jobs: int | None,
    verbose: int,
) -> tuple[Motion, str]:
    """Retarget a motion, and state the method and its error."""
    check_kind(motion, Motion, "motion", "pass one motion")
    shown = skeleton if isinstance(skeleton, Motion) else None
    skeleton = skeleton.skeleton if isinstance(skeleton, Motion) else skeleton
    check_skeleton(skeleton)
    check_choice("method", method, METHODS)
    check_choice("joint_limits", joint_limits, ("ignore", "enforce"))
    if scale is not None and scale != "lengths":
        check_positive("scale", scale)
    if joints is not None and method in ("numbers", "unchecked"):
        raise ValueError(f'method="{method}" matches dofs by name: use joints= with another method')
    if joints is None and method in ("numbers", "unchecked", "auto"):
        try:
            return _by_numbers(motion, skeleton, method, scale, joint_limits)
        except ValueError:
            if method != "auto":
                raise
    if method == "auto" and any(bone.is_hinge for bone in skeleton.bones):
        raise ValueError('the skeleton has hinges: use skpose.robots.retarget_to_robot or method="positions"')
    found = counterparts(motion.skeleton, skeleton, joints)
    check_limbs(motion.skeleton, skeleton, found, joints)
    factor, on_feet = _size(motion.skeleton, skeleton, found.landmarks, scale)
    if scale == "lengths":
        factor = ratio_of_lengths(motion.skeleton, skeleton, found)
    if method != "positions":
        try:
            return _by_orientations(motion, skeleton, found, factor, on_feet, joint_limits, joints, shown)
        except ValueError:
            if method != "auto":
                raise
    return _by_positions(motion, skeleton, found, factor, joint_limits, n_jobs, verbose)


def _size(
    source: Skeleton, target: Skeleton, people: tuple[Anatomy, Anatomy], scale: float | Literal["lengths"] | None
) -> tuple[float, bool]:
    """The factor of positions in the world, and whether feet keep their places: of people, if no scale is given."""
    legs = [leg_length(skeleton, person) for skeleton, person in zip((source, target), people, strict=True)]
    if scale is not None or not all(legs):
        return 1.0 if scale is None or scale == "lengths" else float(scale), False
    factor = legs[1] / legs[0]
    return (1.0 if abs(factor - 1.0) < ROUNDING else factor), True


def _by_numbers(
    motion: Motion, skeleton: Skeleton, method: str, scale: float | Literal["lengths"] | None, joint_limits: str
) -> tuple[Motion, str]:
    """The angles of a motion in the order of the dofs of another skeleton with the same joints and dofs."""
    if difference := mismatch(motion.skeleton, skeleton):
        raise ValueError(
            f"the motion's angles do not carry over to this skeleton: {difference}. method='orientations' converts"
        )
    if method != "unchecked":
        names = "the motion's skeleton", "the given one"
        check_rest_poses([motion.skeleton, skeleton], names, 'method="orientations" keeps directions')
    factor, on_feet = 1.0, False
    if scale == "lengths":
        factor = ratio_of_lengths(motion.skeleton, skeleton, counterparts(motion.skeleton, skeleton, None))
    elif scale is not None or skeleton != motion.skeleton:
        people = find_anatomy(motion.skeleton), find_anatomy(skeleton)
        factor, on_feet = _size(motion.skeleton, skeleton, people, scale)
    result = replace(
        motion,
        skeleton=skeleton,
        angles=motion.angles[:, skeleton.columns_in(motion.skeleton)],
        root_positions=factor * motion.root_positions,
        seen=seen_of(motion, skeleton),
    )
    result = _within_limits(result, joint_limits)
    return keep_feet(motion, result, people, factor) if on_feet else result, UNCHANGED + _scaled(factor)


def _scaled(factor: float) -> str:
    return f", scaled by {factor:.2f}" if abs(factor - 1.0) >= SHOWN_FACTOR else ""


def _by_orientations(
    motion: Motion,
    skeleton: Skeleton,
    found: Counterparts,
    factor: float,
    on_feet: bool,
    joint_limits: str,
    joints: Mapping[str, str | None] | None,
    shown: Motion | None,
) -> tuple[Motion, str]:
    """Make bones parallel to their counterparts."""
    free = joint_limits == "ignore"  # to move the legs
    result, apart, moving, off = by_orientations(motion, skeleton, found, factor, on_feet and free, shown)
    if on_feet and not free:
        result = keep_feet(motion, result, found.landmarks, factor)
    at_rest = joints_at_rest(skeleton, moving)
    if joints is None and found.by_landmarks:
        _warn_of_ends(motion.skeleton, skeleton, found, at_rest)
    count = f"{(found.there >= 0).sum()} of {skeleton.n_joints} joints"
    report = f"orientations, {count}, directions within {round(apart, 2):g}°"
    report += _scaled(factor)
    report += f", feet within {100.0 * off:.2g} cm" if off is not None and off >= SHOWN_DISTANCE else ""
    return _within_limits(result, joint_limits), report + at_rest_in_words(skeleton, at_rest)


def _within_limits(motion: Motion, joint_limits: str) -> Motion:
    """The motion, without rounding errors beyond the limits if these are enforced."""
    if joint_limits == "ignore":
        return motion
    return replace(motion, angles=check_limits(motion.angles, motion.skeleton, "motion.angles"))


def _by_positions(
    motion: Motion,
    skeleton: Skeleton,
    found: Counterparts,
    factor: float,
    joint_limits: str,
    n_jobs: int | None,
    verbose: int,
) -> tuple[Motion, str]:
    """Find the poses whose joints are nearest to their counterparts, in the world times a factor."""
    placed = np.flatnonzero(found.placed).tolist()
    wished = np.full((len(motion), skeleton.n_joints, 3), np.nan)
    wished[:, placed] = factor * motion.positions()[:, found.there[placed]]
    fitted = inverse_kinematics(wished, skeleton, joint_limits=joint_limits, n_jobs=n_jobs, verbose=verbose)
    result = replace(
        fitted.to_motion(motion.frame_rate, motion.up), frame_numbers=motion.frame_numbers, root_name=motion.root_name
    )
    if motion.seen is not None and result.seen is not None:
        result = replace(result, seen=result.seen & motion.seen[:, found.there])
    first = 0 if skeleton.offset_frame == "own" else 1
    at_rest = joints_at_rest(skeleton, {j for joint in placed for j in path_up(skeleton, joint)[first:]})
    apart = round(100.0 * float(np.nanmax(fitted.residuals, initial=0.0)), 2)
    count = f"{len(placed)} of {skeleton.n_joints} joints"
    return result, f"positions, {count} within {apart:g} cm{at_rest_in_words(skeleton, at_rest)}"


# --- joints that stay at rest -----------------------------------------------------------------------------------------


def joints_at_rest(skeleton: Skeleton, moving: Iterable[int]) -> list[int]:
    """The joints that could move bones and do not; of several one after another, the first.

    What they carry moves with the joints before them, in its rest pose.
    """
    moving, movers = {*moving, ROOT}, find_movers(skeleton)
    has_length = np.asarray(directions_at_zero(skeleton).any(axis=1))
    carriers = {carrier for carrier, known in zip(find_carriers(skeleton), has_length, strict=True) if known}
    return [joint for joint in sorted(carriers - moving) if movers[int(skeleton.parents[joint])] in moving]


def at_rest_in_words(skeleton: Skeleton, at_rest: list[int]) -> str:
    """The end of a report on joints that stay at rest; empty if there are none."""
    names = [skeleton.joint_names[joint] for joint in at_rest]
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"; at rest: {', '.join(names[:SHOWN])}{more}" if names else ""


def _warn_of_ends(source: Skeleton, target: Skeleton, found: Counterparts, at_rest: list[int]) -> None:
    """Warn if a hand, a foot or the head stays at rest although the motion's has a bone."""
    theirs, ours = (person.joints for person in found.people or ())
    still, carriers = [], find_carriers(target)
    for mark in LAST:
        if mark in theirs and mark in ours:
            ends = {carriers[joint] for joint in _after(target, ours[mark])}
            if ends and ends <= set(at_rest) and _after(source, theirs[mark]):
                still += [target.joint_names[joint] for joint in sorted(ends)]
    if still:
        warn(f"{', '.join(map(repr, still))} stay at rest, as their counterparts are not known: pass joints=")


def _after(skeleton: Skeleton, joint: int) -> list[int]:
    """The joints at which the first bones with a length after a joint end."""
    has_length, found = np.asarray(directions_at_zero(skeleton).any(axis=1)), []
    for child in np.flatnonzero(skeleton.parents == joint).tolist():
        found += [child] if has_length[child] else _after(skeleton, child)
    return found
