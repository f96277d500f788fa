"""Places on the links of a skeleton, and how its pelvis, chest and feet stand at angle zero.

A place is a point that is fixed to a joint's axes. A copy of the skeleton with one rigid bone to each place has their
positions as those of joints: so orientations are found, and reached, by points.
"""

import functools
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from skpose.kinematics._by_limbs._contacts import Sole
from skpose.kinematics._by_limbs._robots import HEEL, ROBOTS, TIP, Robot, places_of
from skpose.kinematics._landmarks import SIDES, common_parent, path_up
from skpose.kinematics._lines import ROOT, find_carriers, find_movers, unit
from skpose.kinematics._rigs import ANKLE, BALL, COLLAR, ELBOW, HAND, HIP, KNEE, SHOULDER, TOE, WRIST
from skpose.skeleton import Bone, Skeleton
from skpose.skeleton._shared import axes_at_zero, axes_of, positions_at_zero

NEAR = 0.8  # cosine of the angle to an axis of the root up to which a skeleton stands along it, or faces it
FACING = np.cos(np.radians(45.0))  # of the angle between hips and shoulders in a pose of somebody who stands
HANGING = np.cos(np.radians(60.0))  # of that between a leg and the direction down there
POINTED = np.cos(np.radians(15.0))  # of the angle between foot and shank, up to which the foot has no direction forward
EXACT = 1e-3  # rad, of the axes of a robot from those of the root, up to which they are these
UPRIGHT = np.cos(np.radians(10.0))  # of a shank at angle zero, below which the foot is as tilted as that
NO_LENGTH = 0.02  # of the bone before, up to which one has no direction
ROLL = np.cos(np.radians(20.0))  # of the angle between the axis of a forearm's roll and the forearm
SOLE = 0.25  # shanks, half the width of a sole and its length behind the ankle, where a table has none
LEG, ARM = (HIP, KNEE, ANKLE), (SHOULDER, ELBOW, WRIST)


class Place(NamedTuple):
    """A point fixed to the axes of a joint; -1 is the root."""

    joint: int
    at_zero: np.ndarray  # (3,) at angle zero, m, in the axes of the root


class Lowest(NamedTuple):
    """The lowest joint that an ankle carries, or the ankle, and how far the foot reaches, from the ankle, m."""

    joint: str
    height: float
    ahead: float


class Stance(NamedTuple):
    """Landmarks of a skeleton as it stands at angle zero; axes have forward, left and up in their columns."""

    places: dict[str, Place]  # of landmarks
    axes: np.ndarray  # (3, 3) of the trunk, in those of the root
    pelvis: int  # the joint with which the pelvis moves
    chest: int
    feet: dict[str, tuple[int, np.ndarray]]  # by side, the joint with which the foot moves and its axes
    name: str  # of the robot
    sole: float  # half the width of a sole, m
    unsure: tuple[str, ...] = ()  # sides whose foot does not show at angle zero how it stands
    stands: bool = True  # whether that of angle zero is a pose of a person who stands
    links: Mapping[str, np.ndarray] = MappingProxyType(
        {}
    )  # axes of pelvis and chest where they are not those of the trunk
    lowest: Mapping[str, Lowest] = MappingProxyType({})  # by side, of feet of which only the ankle is named

    def has(self, limb: Sequence[str]) -> bool:
        """Return whether both sides have all landmarks of a limb."""
        return all(f"{side}_{mark}" in self.places for side in SIDES for mark in limb)

    def in_words(self) -> str:
        """Return in words what is known of the skeleton."""
        low = " and ".join(repr(lowest.joint) for lowest in self.lowest.values())
        sole = f", soles as low as {low}" if low else ""
        return f"{self.name + ', ' if self.name else ''}{len(self.places)} places{sole}"

    def length(self, start: str, end: str) -> float:
        """Return the distance between two landmarks at angle zero, m, the mean of both sides."""
        ends = [(self.places[f"{side}_{start}"].at_zero, self.places[f"{side}_{end}"].at_zero) for side in SIDES]
        return float(np.mean([np.linalg.norm(b - a) for a, b in ends]))


def find_robot(skeleton: Skeleton) -> Robot | None:
    """Return the robot whose links a skeleton has, all that its table names."""
    names = set(skeleton.joint_names)
    return next((robot for robot in ROBOTS if {link for link, _ in places_of(robot).values()} <= names), None)


def missing_links(skeleton: Skeleton) -> tuple[Robot | None, list[str]]:
    """Return the robot that a skeleton nearly is, with more than half of its links, and the links that it lacks."""
    names = set(skeleton.joint_names)
    links = [{link for link, _ in places_of(robot).values()} for robot in ROBOTS]
    robot, needed = max(zip(ROBOTS, links, strict=True), key=lambda pair: len(pair[1] & names) / len(pair[1]))
    return (robot, sorted(needed - names)) if 2 * len(needed & names) > len(needed) else (None, [])


def robot_places(skeleton: Skeleton, robot: Robot) -> dict[str, Place]:
    """Return the places of a robot's landmarks."""
    zero, index = positions_at_zero(skeleton), {name: j for j, name in enumerate(skeleton.joint_names)}
    axes = robot_axes(skeleton, robot)
    return {
        mark: Place(index[link], zero[index[link]] + axes @ np.array(offset))
        for mark, (link, offset) in places_of(robot).items()
    }


def robot_axes(skeleton: Skeleton, robot: Robot) -> np.ndarray:
    """Return the axes (3, 3) of a robot in those of the root at angle zero, forward, left and up in their columns.

    By the origins of its links, as the root of another file may be turned.
    """
    zero, index = positions_at_zero(skeleton), {name: j for j, name in enumerate(skeleton.joint_names)}
    at = {mark: zero[index[link]] for mark, (link, _) in places_of(robot).items()}
    low = HIP if f"left_{HIP}" in at else WRIST
    trunk = np.mean([at[f"{side}_{SHOULDER}"] - at[f"{side}_{low}"] for side in SIDES], axis=0)
    left = unit(at[f"left_{SHOULDER}"] - at[f"right_{SHOULDER}"])
    forward = unit(np.cross(left, trunk))
    here = np.stack([forward, left, np.cross(forward, left)], axis=1)
    x, z = unit(np.array(robot.trunk))  # how that of its file leans
    axes = here @ np.array([[z, 0.0, -x], [0.0, 1.0, 0.0], [x, 0.0, z]])
    return np.eye(3) if np.abs(axes - np.eye(3)).max() < EXACT else axes


def joint_places(skeleton: Skeleton, joints: dict[str, int]) -> dict[str, Place]:
    """Return the places of landmarks that are joints."""
    zero = positions_at_zero(skeleton)
    return {mark: Place(joint, zero[joint]) for mark, joint in joints.items()}


def find_stance(skeleton: Skeleton, places: dict[str, Place], robot: Robot | None = None) -> Stance:
    """Return how a skeleton with these places stands at angle zero."""
    movers = [*find_movers(skeleton), ROOT]  # the last is that of the root
    places = _with_length(places)
    hips, shoulders = ([places.get(f"{side}_{mark}") for side in SIDES] for mark in (HIP, SHOULDER))
    pelvis, chest = (_link_of(skeleton, pair, movers) for pair in (hips, shoulders))
    axes = robot_axes(skeleton, robot) if robot else _trunk_axes(hips, shoulders, places)
    links = {} if _is_standing(hips, shoulders, places, axes) else _link_axes(skeleton, places, pelvis, chest)
    feet, unsure = {}, []
    for side in SIDES:
        if f"{side}_{ANKLE}" in places:
            joint, frame, is_sure = _foot(skeleton, places, side, axes, movers)
            feet[side] = joint, frame
            unsure += [side] * (bool(links) or not is_sure)
    name, sole = (robot.name, robot.sole) if robot else ("", 0.0)
    stance = Stance(places, axes, pelvis, chest, feet, name, sole, tuple(unsure), not links, links)
    unnamed = [side for side in feet if toe_of(stance, side) == f"{side}_{ANKLE}" and f"{side}_{TIP}" not in places]
    return stance._replace(lowest={side: _lowest_of(skeleton, stance, side) for side in unnamed})


def _lowest_of(skeleton: Skeleton, stance: Stance, side: str) -> Lowest:
    """Return the lowest joint of a foot of which only the ankle is named, and how far the foot reaches."""
    ankle, zero = stance.places[f"{side}_{ANKLE}"], positions_at_zero(skeleton)
    carried = [joint for joint in range(skeleton.n_joints) if ankle.joint in path_up(skeleton, joint)]
    ends = np.array([(zero[joint] - ankle.at_zero) @ stance.feet[side][1] for joint in carried])
    i = int(ends[:, 2].argmin())
    return Lowest(skeleton.joint_names[carried[i]], float(ends[i, 2]), float(ends[:, 0].max()))


def _with_length(places: dict[str, Place]) -> dict[str, Place]:
    """Return places without hands, balls and toes that are at the joint before: these show no direction."""
    kept = dict(places)
    for side in SIDES:
        for start, end, middle in ((WRIST, HAND, ELBOW), (ANKLE, BALL, KNEE), (ANKLE, TOE, KNEE)):
            marks = [f"{side}_{mark}" for mark in (start, end, middle)]
            if all(mark in places for mark in marks):
                origin, tip, before = (places[mark].at_zero for mark in marks)
                if np.linalg.norm(tip - origin) <= NO_LENGTH * np.linalg.norm(before - origin):
                    kept.pop(marks[1])
    return kept


def _trunk_axes(hips: list[Place | None], shoulders: list[Place | None], places: dict[str, Place]) -> np.ndarray:
    """Return the axes (3, 3) of the trunk at angle zero by what is known of hips and shoulders."""
    ends = [_ends(pair) for pair in (hips, shoulders)]
    left = next(pair[0] - pair[1] for pair in reversed(ends) if pair is not None)  # as one limb is known
    up = _snap(_upward([None if pair is None else pair.mean(axis=0) for pair in ends], places))
    left = _snap(unit(left - (left @ up) * up))
    return np.stack([np.cross(left, up), left, up], axis=1)


def _is_standing(
    hips: list[Place | None], shoulders: list[Place | None], places: dict[str, Place], axes: np.ndarray
) -> bool:
    """Return whether the pose of angle zero is one in which legs hang and hips face forward as shoulders do."""
    ends = [_ends(pair) for pair in (hips, shoulders)]
    if ends[0] is not None and ends[1] is not None:
        lines = [unit(pair[0] - pair[1]) for pair in ends if pair is not None]
        if lines[0] @ lines[1] < FACING:
            return False
    legs = [tuple(f"{side}_{mark}" for mark in (HIP, ANKLE)) for side in SIDES]
    known = [leg for leg in legs if all(mark in places for mark in leg)]
    return all(unit(places[hip].at_zero - places[ankle].at_zero) @ axes[:, 2] > HANGING for hip, ankle in known)


def _link_axes(skeleton: Skeleton, places: dict[str, Place], pelvis: int, chest: int) -> dict[str, np.ndarray]:
    """Return the axes (3, 3) of pelvis and chest by what each of them carries at angle zero, in any pose.

    The pelvis carries both hips and the spine, the chest both collarbones or shoulders, and ends below them.
    """
    zero = np.vstack([positions_at_zero(skeleton), np.zeros(3)])  # the last is the root
    spine = [joint for joint in path_up(skeleton, chest) if joint not in path_up(skeleton, pelvis)]
    mark = COLLAR if all(f"{side}_{COLLAR}" in places for side in SIDES) else SHOULDER
    found = {}
    for link, end in (("pelvis", HIP), ("chest", mark)):
        pair = _ends([places.get(f"{side}_{end}") for side in SIDES])
        if pair is None or not spine:
            continue
        middle = pair.mean(axis=0)
        up = zero[spine[-1]] - middle if link == "pelvis" else middle - zero[chest]
        left = unit(pair[0] - pair[1])
        up = up - (up @ left) * left
        if np.linalg.norm(up) > NO_LENGTH * np.linalg.norm(pair[0] - pair[1]):
            up = unit(up)
            found[link] = np.stack([np.cross(left, up), left, up], axis=1)
    return found


def _ends(pair: list[Place | None]) -> np.ndarray | None:
    """Return the positions (2, 3) of a place on both sides at angle zero, if both are known."""
    left, right = pair
    return None if left is None or right is None else np.stack([left.at_zero, right.at_zero])


def _upward(ends: list[np.ndarray | None], places: dict[str, Place]) -> np.ndarray:
    """Return the direction in which the trunk stands at angle zero; without shoulders, or hips, from what is known."""
    hips, shoulders = ends
    if hips is None or shoulders is None:
        low = [places[f"{side}_{ANKLE}"].at_zero for side in SIDES if f"{side}_{ANKLE}" in places]
        hips = hips if hips is not None else np.zeros(3)
        if shoulders is None:
            return unit(hips - np.mean(low, axis=0))
    return unit(shoulders - hips)


def _snap(direction: np.ndarray) -> np.ndarray:
    """Return the axis of the root that a direction is near to, or the direction itself."""
    axis = int(np.abs(direction).argmax())
    return np.eye(3)[axis] * np.sign(direction[axis]) if abs(direction[axis]) > NEAR else direction


def _link_of(skeleton: Skeleton, pair: list[Place | None], movers: list[int]) -> int:
    """Return the joint with which what carries both places moves; the root without both."""
    if pair[0] is None or pair[1] is None:
        return ROOT
    return movers[common_parent(skeleton, pair[0].joint, pair[1].joint)]


def _foot(
    skeleton: Skeleton, places: dict[str, Place], side: str, axes: np.ndarray, movers: list[int]
) -> tuple[int, np.ndarray, bool]:
    """Return the joint with which a foot moves, its axes at angle zero, and whether it is flat there.

    A leg that is spread at angle zero has a foot that is tilted with it. One that points along the shank is not flat.
    """
    ankle = places[f"{side}_{ANKLE}"]
    is_table = f"{side}_{TIP}" in places
    end = next((places[f"{side}_{mark}"] for mark in (TIP, BALL, TOE) if f"{side}_{mark}" in places), None)
    shank = unit(places[f"{side}_{KNEE}"].at_zero - ankle.at_zero)
    up = axes[:, 2] if shank @ axes[:, 2] > UPRIGHT or is_table else shank
    forward = axes[:, 0] if end is None or is_table else end.at_zero - ankle.at_zero
    is_pointed = bool(unit(forward) @ -up > POINTED)
    joint = ankle.joint
    if end is not None:
        joint = end.joint if is_table else find_carriers(skeleton)[end.joint]
    if is_pointed:
        up = axes[:, 0]  # the instep
    forward = unit(forward - (forward @ up) * up)
    return movers[joint], np.stack([forward, np.cross(up, forward), up], axis=1), not is_pointed


def toe_of(stance: Stance, side: str) -> str:
    """Return the landmark at the toes on which a foot stands; the ankle if it has none."""
    return next(mark for mark in (f"{side}_{name}" for name in (BALL, TOE, ANKLE)) if mark in stance.places)


def length_of_leg(stance: Stance) -> float:
    """Return the length of the legs, m."""
    return stance.length(HIP, KNEE) + stance.length(KNEE, ANKLE)


def middle_of(stance: Stance, mark: str) -> np.ndarray:
    """Return the middle (3,) between two places at angle zero."""
    return np.asarray(np.mean([stance.places[f"{side}_{mark}"].at_zero for side in SIDES], axis=0))


def sole_of(stance: Stance, side: str) -> Sole:
    """Return the sole of a foot.

    Where no table has it the floor is below the lowest joint of the foot that is named, or of all that it has.
    """
    places, (_, axes) = stance.places, stance.feet[side]
    ankle = places[f"{side}_{ANKLE}"].at_zero
    if f"{side}_{TIP}" in places:
        heel, tip = ((places[f"{side}_{mark}"].at_zero - ankle) @ axes for mark in (HEEL, TIP))
        return Sole(heel, tip, stance.sole)
    size = SOLE * float(np.linalg.norm(places[f"{side}_{KNEE}"].at_zero - ankle))
    ends = [(places[f"{side}_{mark}"].at_zero - ankle) @ axes for mark in (BALL, TOE) if f"{side}_{mark}" in places]
    if side in stance.lowest:
        low, front = stance.lowest[side].height, max(2.0 * size, stance.lowest[side].ahead)
    else:
        low, front = min(end[2] for end in ends), max(end[0] for end in ends)
    return Sole(np.array([-size, 0.0, low]), np.array([front, 0.0, low]), size / 2.0)


def rolls_of(skeleton: Skeleton, stance: Stance) -> list[int]:
    """Return the hinges beyond the elbows about the line from elbow to wrist: rolls of forearms.

    What a person has there differs from rig to rig, and the direction of a hand does not show it.
    """
    found = []
    axes = axes_at_zero(skeleton)
    for side in SIDES:
        if not stance.has(ARM):
            break
        elbow, wrist = (stance.places[f"{side}_{mark}"] for mark in (ELBOW, WRIST))
        hand = stance.places.get(f"{side}_{HAND}", wrist)
        along = unit(wrist.at_zero - elbow.at_zero)
        for joint in path_up(skeleton, hand.joint):
            if joint == elbow.joint:
                break
            bone = skeleton.bones[joint]
            if bone.n_dofs == 1 and not bone.is_slide and abs(axes[joint] @ axes_of(bone)[0] @ along) > ROLL:
                found.append(joint)
    return found


def with_places(skeleton: Skeleton, places: Sequence[Place]) -> Skeleton:
    """Return the joints of a skeleton that carry places, with one rigid bone to each place, "place 0" and so on."""
    return _with_points(skeleton, tuple((joint, *at_zero.tolist()) for joint, at_zero in places))


@functools.lru_cache(maxsize=64)  # as the motions of a dataset ask for the same ones
def _with_points(skeleton: Skeleton, points: tuple[tuple[int, float, float, float], ...]) -> Skeleton:
    """Return the joints of a skeleton that carry points, the joint and the position of each at angle zero."""
    zero, axes = positions_at_zero(skeleton), [*axes_at_zero(skeleton), np.eye(3)]
    needed = {joint for point in points for joint in path_up(skeleton, point[0])}
    if not any(skeleton.bones[joint].dofs for joint in needed):  # as a skeleton has some
        needed.update(path_up(skeleton, next(j for j, bone in enumerate(skeleton.bones) if bone.dofs)))
    bones = [bone for j, bone in enumerate(skeleton.bones) if j in needed]
    for i, (joint, *at_zero) in enumerate(points):
        offset = axes[joint].T @ (np.array(at_zero) - zero[joint])
        bones.append(Bone(f"place {i}", skeleton.joint_names[joint] if joint >= 0 else None, offset))
    return Skeleton(bones, skeleton.offset_frame)
