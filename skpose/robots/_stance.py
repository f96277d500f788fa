"""The landmarks of a person and of a robot that are counterparts, and how both stand at angle zero.

A *place* is a point fixed to a joint's coordinate system. A copy of the skeleton with one rigid bone to each place has
their positions as joints. So orientations are measured, and reached, by points.
"""

import functools
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from skpose.kinematics._anatomy import (
    ANKLE,
    ARM,
    BALL,
    ELBOW,
    HAND,
    HIP,
    KNEE,
    LEG,
    SHOULDER,
    SIDES,
    TOE,
    WRIST,
    common_parent,
    find_anatomy,
    find_misplaced,
    pair_of,
    path_up,
)
from skpose.kinematics._body import body_axes, foot_axes, is_standing
from skpose.robots._contacts import Sole
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._bone import axes_of
from skpose.skeleton._rest import ROOT, axes_at_zero, find_carriers, find_movers, positions_at_zero, unit
from skpose.skeleton._sides import split_sides

EXACT = 1e-3  # rad, the largest angle between equal axes of robot and root
ROLL = np.cos(np.radians(20.0))  # of the angle between the axis of a forearm's roll and the forearm
SOLE = 0.25  # shanks, half the width of a sole and its length behind the ankle, without a table
LIMBS = {LEG: "legs", ARM: "arms"}


# --- known robots -----------------------------------------------------------------------------------------------------
# The robots whose links are known, one table each, with its source.
#
# A table has for each landmark of a person the link, and the offset from its origin if any: in m at angle zero, in the
# axes of the root, x forward, y left and z up. It has the left side; the right one is its mirror image. Names are those
# of bodies in MJCF files and of links in URDF files.
#
# A hip is where the axis of the hinge that swings the leg forward meets the plane of the leg, a shoulder likewise, so
# that both move with the trunk. An ankle is at the hinge that the shank carries. Heels and toes are the ends of the
# sole, below the middle of the foot.


HEEL, TIP = "heel", "tip"  # the ends of the sole
Vector = tuple[float, float, float]


class Robot(NamedTuple):
    """The landmarks of a robot."""

    name: str
    source: str
    left: Mapping[str, Any]  # a link, or a link and how far from its origin
    right: tuple[tuple[str, str], ...]  # parts of names on the left side, and on the right
    # Forward and up, m: from the middle between the origins of the links of the hips, or else of the wrists, to that
    # between the shoulders', at angle zero. It shows how the root of a file is turned.
    trunk: tuple[float, float]
    sole: float = 0.0  # half its width, m


ROBOTS = (
    Robot(
        "Unitree G1",
        "g1_29dof.xml of https://github.com/unitreerobotics/unitree_mujoco: the soles are the spheres of 5 mm at the "
        "corners of each foot, the hinges of the hips, the shoulders and the wrists do not meet by up to 5 cm",
        {HIP: ("left_hip_pitch_link", (0.0, 0.052, 0.0)), KNEE: "left_knee_link", ANKLE: "left_ankle_pitch_link"}
        | {HEEL: ("left_ankle_roll_link", (-0.05, 0.0, -0.035)), TIP: ("left_ankle_roll_link", (0.12, 0.0, -0.035))}
        | {
            SHOULDER: ("left_shoulder_pitch_link", (0.0, 0.0466, 0.0135)),
            ELBOW: "left_elbow_link",
            WRIST: "left_wrist_pitch_link",
        }
        | {HAND: ("left_wrist_yaw_link", (0.05, 0.0, 0.0))},
        (("left", "right"),),
        (0.0, 0.39448),
        0.03,
    ),
    Robot(
        "Booster T1",
        "t1.xml of https://github.com/google-deepmind/mujoco_menagerie: the soles are the boxes of its feet; and the "
        "model with hands of https://github.com/YanjieZe/GMR",
        {HIP: "Hip_Pitch_Left", KNEE: "Shank_Left", ANKLE: "Ankle_Cross_Left"}
        | {HEEL: ("left_foot_link", (-0.1015, 0.0, -0.03)), TIP: ("left_foot_link", (0.1215, 0.0, -0.03))}
        | {SHOULDER: "AL2", ELBOW: "AL4", WRIST: "AL6"},
        (("Left", "Right"), ("left", "right"), ("AL", "AR")),
        (-0.005, 0.3345),
        0.05,
    ),
    Robot(
        "EngineAI PM01",
        "serial_pm01_edu.xml of https://github.com/engineai-robotics/engineai_robotics_native_sdk: the soles are the "
        "boxes of its feet, and the forearm is one link without a wrist",
        {HIP: ("LINK_HIP_PITCH_L", (0.0, 0.0494, -0.0132)), KNEE: "LINK_KNEE_PITCH_L", ANKLE: "LINK_ANKLE_PITCH_L"}
        | {HEEL: ("LINK_ANKLE_ROLL_L", (-0.0853, 0.0, -0.0463)), TIP: ("LINK_ANKLE_ROLL_L", (0.1193, 0.0, -0.0463))}
        | {SHOULDER: ("LINK_SHOULDER_PITCH_L", (0.0, 0.0669, -0.0208)), ELBOW: "LINK_ELBOW_PITCH_L"}
        | {WRIST: "LINK_ELBOW_YAW_L"},
        (("_L", "_R"),),
        (-0.030355, 0.357598),
        0.0536,
    ),
    Robot(
        "Galaxea R1 Pro",
        "r1_pro.xml of https://github.com/YanjieZe/GMR: the hinges of shoulders, elbows and wrists meet in these "
        "points; wheels carry it",
        {SHOULDER: ("left_arm_link1", (0.0, 0.0813, 0.0)), ELBOW: ("left_arm_link4", (0.0, -0.0351, 0.0))}
        | {WRIST: ("left_arm_link6", (0.0, 0.028, 0.0)), HAND: ("left_arm_link7", (-0.0295, 0.0, -0.1))},
        (("left", "right"),),
        (0.0, 0.56805),
    ),
)


def places_of(robot: Robot) -> dict[str, tuple[str, Vector]]:
    """The link and the offset of each landmark, "left_knee" and so on."""
    places = {}
    for mark, place in robot.left.items():
        link, (x, y, z) = (place, (0.0, 0.0, 0.0)) if isinstance(place, str) else place
        other = link
        for left, right in robot.right:
            other = other.replace(left, right)
        places[f"left_{mark}"] = link, (x, y, z)
        places[f"right_{mark}"] = other, (x, -y, z)
    return places


# --- stances ----------------------------------------------------------------------------------------------------------


class Place(NamedTuple):
    """A point fixed to the coordinate system of a joint; -1 is the root."""

    joint: int
    at_zero: np.ndarray  # (3,) at angle zero, m, in the coordinate system of the root


class Stance(NamedTuple):
    """Anatomy of a skeleton as it stands at angle zero; axes have forward, left and up in their columns."""

    places: dict[str, Place]  # of landmarks
    axes: np.ndarray  # (3, 3) of the trunk, relative to the root
    pelvis: int  # the joint that moves the pelvis
    chest: int
    feet: dict[str, tuple[int, np.ndarray]]  # by side, the joint that moves the foot, and its axes
    robot: Robot | None  # if it is known
    unsure: tuple[str, ...] = ()  # sides whose foot does not show at angle zero how it stands
    links: Mapping[str, np.ndarray] = MappingProxyType({})  # axes of pelvis and chest if the person does not stand

    def length(self, start: str, end: str) -> float:
        """The distance between two landmarks at angle zero, m, the mean of both sides."""
        ends = [(self.places[f"{side}_{start}"].at_zero, self.places[f"{side}_{end}"].at_zero) for side in SIDES]
        return float(np.mean([np.linalg.norm(b - a) for a, b in ends]))

    def leg(self) -> float:
        """The length of the legs, m."""
        return self.length(HIP, KNEE) + self.length(KNEE, ANKLE)

    def middle(self, mark: str) -> np.ndarray:
        """The middle (3,) between a landmark of both sides at angle zero."""
        return np.asarray(np.mean([self.places[f"{side}_{mark}"].at_zero for side in SIDES], axis=0))

    def toe(self, side: str) -> str:
        """The landmark at the toes on which a foot stands; the ankle if it has none."""
        return next(mark for mark in (f"{side}_{name}" for name in (BALL, TOE, ANKLE)) if mark in self.places)


def has_limb(places: Mapping[str, Place], limb: Sequence[str]) -> bool:
    """Whether both sides have all landmarks of a limb."""
    return all(f"{side}_{mark}" in places for side in SIDES for mark in limb)


# --- the landmarks ----------------------------------------------------------------------------------------------------


@functools.lru_cache(maxsize=16)
def stances_of(source: Skeleton, target: Skeleton, pairs: tuple[tuple[str, str], ...] | None) -> tuple[Stance, Stance]:
    """The stances of a person and a robot, by names or by pairs of joints of target and source."""
    robot, axes, known = _known_robot(target) or (None, None, {})
    theirs = _joint_places(source, find_anatomy(source, any_proportions=pairs is not None).joints)
    if pairs is not None:
        theirs, ours = _by_counterparts(source, target, dict(pairs), theirs, known)
    else:
        ours = known or _joint_places(target, find_anatomy(target).joints)
    for limb, name in LIMBS.items():
        if not has_limb(theirs, limb) and (limb == LEG or has_limb(ours, limb)):
            raise ValueError(f"the {name} of the motion are not known by their names: name their joints with joints=")
    if not any(has_limb(ours, limb) for limb in LIMBS):
        raise ValueError("legs and arms of the robot are not known by their names: name their joints with joints=")
    _check_limbs(target, ours)
    other = find_stance(target, ours, robot, axes)
    _check_sides(target, other)
    return find_stance(source, theirs), other


def _joint_places(skeleton: Skeleton, joints: dict[str, int]) -> dict[str, Place]:
    zero = positions_at_zero(skeleton)
    return {mark: Place(joint, zero[joint]) for mark, joint in joints.items()}


def _known_robot(skeleton: Skeleton) -> tuple[Robot, np.ndarray, dict[str, Place]] | None:
    """The robot that has these links, its axes (3, 3) and its places, however its root is turned, or None."""
    zero, index = positions_at_zero(skeleton), {name: j for j, name in enumerate(skeleton.joint_names)}
    for robot in ROBOTS:
        links = places_of(robot)
        if {link for link, _ in links.values()} <= index.keys():
            at = {mark: zero[index[link]] for mark, (link, _) in links.items()}
            low = HIP if f"left_{HIP}" in at else WRIST
            up = np.mean([at[f"{side}_{SHOULDER}"] - at[f"{side}_{low}"] for side in SIDES], axis=0)
            left = unit(at[f"left_{SHOULDER}"] - at[f"right_{SHOULDER}"])
            forward = unit(np.cross(left, up))
            x, z = unit(np.array(robot.trunk))  # how the trunk leans in the robot's own file
            lean = np.array([[z, 0.0, -x], [0.0, 1.0, 0.0], [x, 0.0, z]])
            axes = np.stack([forward, left, np.cross(forward, left)], axis=1) @ lean
            axes = np.eye(3) if np.abs(axes - np.eye(3)).max() < EXACT else axes
            points = {mark: (index[link], axes @ np.array(offset)) for mark, (link, offset) in links.items()}
            return robot, axes, {mark: Place(joint, zero[joint] + offset) for mark, (joint, offset) in points.items()}
    return None


def _by_counterparts(
    source: Skeleton, target: Skeleton, joints: Mapping[str, str], theirs: dict[str, Place], known: dict[str, Place]
) -> tuple[dict[str, Place], dict[str, Place]]:
    """The places of given counterparts, by the landmarks of the motion, or else of the robot."""
    marks = {source.joint_names[place.joint]: mark for mark, place in theirs.items()}
    links = {target.joint_names[place.joint]: mark for mark, place in reversed(known.items())}
    limbs = {f"{side}_{mark}" for side in SIDES for limb in LIMBS for mark in limb}
    ours: dict[str, Place] = {}
    for name, counterpart in joints.items():
        mark, link = marks.get(counterpart, ""), links.get(name, "")
        if {mark, link} <= limbs and mark != link:
            raise ValueError(f"joints maps {name!r}, the robot's {link}, to {counterpart!r}, the motion's {mark}")
        if mark := mark or link:
            theirs |= _joint_places(source, {mark: source.joint_names.index(counterpart)})
            joint, place = target.joint_names.index(name), known.get(mark)
            ours[mark] = place if place and place.joint == joint else _joint_places(target, {mark: joint})[mark]
    return theirs, known | ours


def _check_limbs(skeleton: Skeleton, places: dict[str, Place]) -> None:
    """Refuse limbs of which some joints are not known, and joints that do not follow each other."""
    for limb, name in LIMBS.items():
        marks = [f"{side}_{mark}" for side in SIDES for mark in limb]
        missing = [mark for mark in marks if mark not in places]
        if 0 < len(missing) < len(marks):
            raise ValueError(f"the {name} of the robot have no {', '.join(missing)}: name the joints with joints=")
    if misplaced := find_misplaced(skeleton, {mark: place.joint for mark, place in places.items()}):
        raise ValueError(f"joints must be in the order of a limb of the robot, but {misplaced}")


def _check_sides(skeleton: Skeleton, ours: Stance) -> None:
    """Refuse feet without a front, and landmarks whose sides are exchanged, by their names or at angle zero."""
    for mark, place in ours.places.items():
        side, name = mark.partition("_")[0], skeleton.joint_names[place.joint]
        named = split_sides([name])[0][0]
        if side in SIDES and named in SIDES and named != side:
            raise ValueError(f"joints exchanges left and right: {name!r} is the {mark}")

    at = {mark: place.at_zero @ ours.axes for mark, place in ours.places.items()}
    for side in ours.feet:
        if not {f"{side}_{mark}" for mark in (BALL, TOE, TIP)} & at.keys():
            raise ValueError(f"the {side} foot of the robot has no front: name a joint there with joints=")
    left = [pair[0][1] - pair[1][1] for mark in (HIP, SHOULDER) if (pair := pair_of(at, mark))]
    feet = [(f"{side}_{mark}", f"{side}_{ANKLE}") for side in SIDES for mark in (BALL, TOE, TIP)]
    fronts = [at[a][0] - at[b][0] for a, b in feet if a in at and b in at]
    if min(left) < 0.0 or (fronts and max(fronts) < 0.0):
        raise ValueError("joints exchanges left and right, or front and back: the robot's feet point backward")


# --- how a skeleton stands --------------------------------------------------------------------------------------------


def find_stance(
    skeleton: Skeleton, places: dict[str, Place], robot: Robot | None = None, axes: np.ndarray | None = None
) -> Stance:
    """How a skeleton with these places stands at angle zero; `axes` are given for known robots."""
    movers = find_movers(skeleton)
    at = {mark: place.at_zero for mark, place in places.items()}
    pelvis, chest = (
        movers[common_parent(skeleton, *(places[f"{side}_{mark}"].joint for side in SIDES))]
        if all(f"{side}_{mark}" in places for side in SIDES)
        else ROOT
        for mark in (HIP, SHOULDER)
    )
    axes = body_axes(at) if axes is None else axes
    stands = is_standing(at, axes)
    links = {} if stands else {link: body_axes(at, mark) for link, mark in (("pelvis", HIP), ("chest", SHOULDER))}
    feet, unsure = {}, []
    for side in [side for side in SIDES if f"{side}_{ANKLE}" in places]:
        joint, frame, is_flat = _foot(skeleton, places, side, axes)
        feet[side] = movers[joint], frame
        unsure += [side] * (not (stands and is_flat))
    return Stance(places, axes, pelvis, chest, feet, robot, tuple(unsure), links)


def _foot(skeleton: Skeleton, places: dict[str, Place], side: str, axes: np.ndarray) -> tuple[int, np.ndarray, bool]:
    """The joint that moves a foot, the foot's axes at angle zero, and whether it is flat there."""
    ankle, knee = places[f"{side}_{ANKLE}"], places[f"{side}_{KNEE}"]
    if (tip := places.get(f"{side}_{TIP}")) is not None:
        return tip.joint, axes, True
    end = next((places[f"{side}_{mark}"] for mark in (BALL, TOE) if f"{side}_{mark}" in places), None)
    forward = axes[:, 0] if end is None else end.at_zero - ankle.at_zero
    foot, is_flat = foot_axes(unit(knee.at_zero - ankle.at_zero), forward, axes)
    return ankle.joint if end is None else find_carriers(skeleton)[end.joint], foot, is_flat


def sole_of(stance: Stance, side: str) -> Sole:
    """The sole of a foot; without a table, the floor is below the lowest joint of the foot."""
    places, (_, axes) = stance.places, stance.feet[side]
    ankle = places[f"{side}_{ANKLE}"].at_zero
    if stance.robot and f"{side}_{TIP}" in places:
        heel, tip = ((places[f"{side}_{mark}"].at_zero - ankle) @ axes for mark in (HEEL, TIP))
        return Sole(heel, tip, stance.robot.sole)
    size = SOLE * float(np.linalg.norm(places[f"{side}_{KNEE}"].at_zero - ankle))
    ends = [(places[f"{side}_{mark}"].at_zero - ankle) @ axes for mark in (BALL, TOE) if f"{side}_{mark}" in places]
    low, front = min(end[2] for end in ends), max(end[0] for end in ends)
    return Sole(np.array([-size, 0.0, low]), np.array([front, 0.0, low]), size / 2.0)


def rolls_of(skeleton: Skeleton, stance: Stance) -> list[int]:
    """The hinges beyond the elbows about the line from elbow to wrist: rolls of forearms.

    What a person has there differs from rig to rig, and the direction of a hand does not show it.
    """
    found = []
    axes = axes_at_zero(skeleton)
    for side in SIDES if has_limb(stance.places, ARM) else ():
        elbow, wrist = (stance.places[f"{side}_{mark}"] for mark in (ELBOW, WRIST))
        hand = stance.places.get(f"{side}_{HAND}", wrist)
        along = unit(wrist.at_zero - elbow.at_zero)
        for joint in set(path_up(skeleton, hand.joint)) - set(path_up(skeleton, elbow.joint)):
            bone = skeleton.bones[joint]
            if bone.n_dofs == 1 and not bone.is_slide and abs(axes[joint] @ axes_of(bone)[0] @ along) > ROLL:
                found.append(joint)
    return found


# --- places as joints -------------------------------------------------------------------------------------------------


def with_places(skeleton: Skeleton, places: Sequence[Place]) -> Skeleton:
    """The joints of a skeleton that carry places, with one rigid bone to each place, "place 0" and so on."""
    return _with_points(skeleton, tuple((joint, *at_zero.tolist()) for joint, at_zero in places))


@functools.lru_cache(maxsize=64)  # the motions of a dataset need the same ones
def _with_points(skeleton: Skeleton, points: tuple[tuple[int, float, float, float], ...]) -> Skeleton:
    zero, axes = positions_at_zero(skeleton), [*axes_at_zero(skeleton), np.eye(3)]
    needed = {joint for point in points for joint in path_up(skeleton, point[0])}
    if not any(skeleton.bones[joint].dofs for joint in needed):  # a skeleton needs dofs
        needed.update(path_up(skeleton, next(j for j, bone in enumerate(skeleton.bones) if bone.dofs)))
    bones = [bone for j, bone in enumerate(skeleton.bones) if j in needed]
    for i, (joint, *at_zero) in enumerate(points):
        offset = axes[joint].T @ (np.array(at_zero) - zero[joint])
        bones.append(Bone(f"place {i}", skeleton.joint_names[joint] if joint >= 0 else None, offset))
    return Skeleton(bones, skeleton.offset_frame)
