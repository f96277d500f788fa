"""The target positions of places on a robot in each frame of a person's motion.

The pelvis and the chest of the robot are put where the person's are, in the size of its legs, as near as its trunk can.
From the robot's own hips and shoulders the ends of its limbs are where the person's are, in the size of each limb; feet
that stand are held still; knees and elbows bend to the same side as the person's.
"""

import functools
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.warnings import warn
from skpose.kinematics._anatomy import ANKLE, ARM, ELBOW, HAND, HIP, KNEE, LEG, SHOULDER, SIDES, WRIST, path_up
from skpose.kinematics._forward import joint_positions
from skpose.kinematics._inverse import FittedPoses, Task, problem_of
from skpose.robots._contacts import Contact, Held, find_contacts, find_floor, hold_foot
from skpose.robots._stance import Place, Stance, has_limb, rolls_of, sole_of, with_places
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._bone import ranges_of, with_columns
from skpose.skeleton._rest import ROOT, positions_at_zero, unit
from skpose.skeleton._root import root_orientations
from skpose.skeleton._upright import axes_with_up_last

FLIP, FASTEST_FLIP = np.radians(60.0), 100.0  # rad between frames, and rad/s, beyond which a foot cannot turn
UP = 0.7  # sine of the angle above the horizontal up to which a foot stands
SLOPE = np.radians(30.0)  # of the line from ankle to toes above the floor, if no foot stands flat
# Share of a limb's first bone: knees bend forward and elbows backward by so much if the person's are straight.
POLE = 0.15
BENT = 0.3  # share of the first bone off the line of the limb's ends, from which on only the person's bend counts
BENDS = 0.5  # rad
STRETCH = (
    0.985,
    0.9995,
)  # shares of a limb's length: it stretches ever less from the first on, and never reaches the second
STIFFNESS = 0.005  # m/rad, of all joints towards their rest pose
TRUNK_STIFFNESS = 1e-3
# Of the squared distances of places: four on the pelvis, four on the chest, three on the sole of each foot.
WEIGHTS = {"pelvis": 0.3, "chest": 0.2, "knee": 0.3, "foot": 40.0, "elbow": 0.3, "wrist": 1.0, "hand": 0.5}
WHEELS = 50.0  # of a robot without legs, on the floor
LEVER = 0.2  # m, from a point on a pelvis or a chest to the points that show its orientation
FASTEST = 20.0  # rad/s, of a joint; the G1 reaches 20 to 37
CORNERS = LEVER * np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


class Target(NamedTuple):
    """A place on a link, and where it should be in each frame."""

    place: Place
    position: np.ndarray  # (n_frames, 3)
    weight: float
    group: str = ""


class Aim(NamedTuple):
    """The target positions of places on the robot."""

    skeleton: Skeleton  # the robot with joints that are held at rest
    rest: np.ndarray  # (n_dofs,) its pose at rest
    bent: np.ndarray  # (n_dofs,) the pose at rest with bent knees and elbows, the start of the search
    rolls: list[int]  # joints that stay at rest, though they carry places
    targets: list[Target]
    legs: dict[str, Held]
    paths: dict[str, np.ndarray]  # (n_frames, 3) of the person's toes, by side, and pelvis, in the size of the robot
    is_on_base: bool  # whether the robot's joints move it over the floor, and its root stays


def aim_at(motion: Motion, skeleton: Skeleton, theirs: Stance, ours: Stance, factor: float | None) -> Aim:
    """Find the targets of places on the robot; `factor` None is the ratio of the legs."""
    person, theirs = lay_unsure_feet(person_of(motion, theirs), theirs, motion.times)
    warn_of_flips(person, motion.times)
    rest, rolls, on_legs = rest_pose(skeleton), rolls_of(skeleton, ours), has_limb(ours.places, LEG)
    held = hold_at_rest(skeleton, tuple(rolls))
    base = _base_of(skeleton, ours.pelvis if on_legs else ours.chest)
    if on_legs and base != ROOT:
        name = skeleton.joint_names[base]
        raise ValueError(f"joints move the base {name!r} of a robot with legs: use load_robot(path, root={name!r})")
    size = _size_of_legs(theirs, ours)
    scale = size * np.ones(3) if factor is None else np.array([factor, factor, size])  # heights scale with the legs
    targets: list[Target] = []
    if on_legs:
        contacts, floor = find_ground(person, theirs, motion.times)
        trunk = _put_trunk(skeleton, person, ours, scale, floor)
    else:
        ankle = float(np.percentile([person.at[f"{side}_{ANKLE}"][:, 2] for side in SIDES], 5))
        targets, trunk = _put_on_wheels(person, ours, base, scale, ankle)
    first = solve(held, targets + trunk, rest, TRUNK_STIFFNESS, motion.times)
    starts, pelvis, chest = _read_trunk(first, held, ours)
    legs: dict[str, Held] = {}
    if on_legs:
        for side in SIDES:
            sole, leg = sole_of(ours, side), person.at[f"{side}_{ANKLE}"] - person.at[f"{side}_{HIP}"]
            ankles = starts[f"{side}_{HIP}"] + size * leg
            legs[side] = hold_foot(ankles, person.feet[side], sole, contacts[side], motion.times, ours.leg())
        shift = _shift_within_reach(legs, starts, ours)
        starts = {mark: start + shift for mark, start in starts.items()}
        middle = (starts[f"left_{HIP}"] + starts[f"right_{HIP}"]) / 2.0
        targets += targets_of_link(ours, ours.pelvis, ours.middle(HIP), middle, pelvis, WEIGHTS["pelvis"])
        for side, leg in legs.items():
            targets += _put_leg(person, ours, side, starts[f"{side}_{HIP}"], leg)
    if has_limb(ours.places, ARM):
        middle = (starts[f"left_{SHOULDER}"] + starts[f"right_{SHOULDER}"]) / 2.0
        if ours.chest != ours.pelvis or not on_legs:
            targets += targets_of_link(ours, ours.chest, ours.middle(SHOULDER), middle, chest, WEIGHTS["chest"])
        for side in SIDES:
            targets += _put_arm(person, ours, side, starts[f"{side}_{SHOULDER}"], chest)
    paths = {side: scale * person.at[theirs.toe(side)] for side in theirs.feet} | {"pelvis": scale * person.middle(HIP)}
    return Aim(held, rest, _bend_limbs(held, ours, rest), rolls, targets, legs, paths, is_on_base=base != ROOT)


# --- the person -------------------------------------------------------------------------------------------------------


class Person(NamedTuple):
    """The parts of a person that are retargeted; the vertical is the last axis, columns are forward, left and up."""

    at: dict[str, np.ndarray]  # by landmark, positions (n_frames, 3)
    feet: dict[str, np.ndarray]  # by side, axes (n_frames, 3, 3)
    pelvis: np.ndarray  # (n_frames, 3, 3) axes
    chest: np.ndarray
    seen: dict[str, np.ndarray]  # by side, whether toes and ankle were seen (n_frames,)

    def middle(self, mark: str) -> np.ndarray:
        """The positions (n_frames, 3) of the middle between a landmark of both sides."""
        return (self.at[f"left_{mark}"] + self.at[f"right_{mark}"]) / 2.0


def person_of(motion: Motion, stance: Stance) -> Person:
    """The parts of a person in a motion."""
    trunk = {"pelvis": stance.pelvis, "chest": stance.chest}
    links = {link: (joint, stance.links.get(link, stance.axes)) for link, joint in trunk.items()} | stance.feet
    vertical = np.eye(3)[axes_with_up_last(motion.up)]
    roots = vertical @ root_orientations(motion.root_angles, motion.root_axes).as_matrix()
    places = [*stance.places.values(), *(place for link in links.values() for place in show_axes(*link))]
    points = positions_of(motion.skeleton, places, motion.angles, roots, motion.root_positions @ vertical.T)
    at = {mark: points[:, i] for i, mark in enumerate(stance.places)}
    firsts = range(len(at), len(places), 3)
    shown = {link: axes_from(points[:, i : i + 3]) for i, link in zip(firsts, links, strict=True)}
    feet, seen = {}, {}
    every = np.ones((len(motion), motion.skeleton.n_joints), bool) if motion.seen is None else motion.seen
    for side in stance.feet:
        mark = stance.toe(side)
        feet[side] = level(shown["pelvis"]) if mark == f"{side}_{ANKLE}" else shown[side]
        joints = [stance.places[name].joint for name in (mark, f"{side}_{ANKLE}")]
        seen[side] = np.asarray(every[:, joints].all(axis=1))
    return Person(at, feet, shown["pelvis"], shown["chest"], seen)


def lay_unsure_feet(person: Person, theirs: Stance, times: np.ndarray) -> tuple[Person, Stance]:
    """Find the axes of feet that do not show at angle zero how they stand.

    Such feet are level where they stand flat in the motion. If none does, a foot that points along the shank at angle
    zero stands with a slope of `SLOPE`.
    """
    feet, zero = dict(person.feet), dict(theirs.feet)
    for side in [side for side in theirs.unsure if theirs.toe(side) != f"{side}_{ANKLE}"]:  # others are level
        joint, axes = theirs.feet[side]
        ends = [theirs.places[mark].at_zero for mark in (f"{side}_{ANKLE}", theirs.toe(side))]
        line = unit(axes.T @ (ends[1] - ends[0]))
        flat = [slice(contact.flat_first, contact.flat_end) for contact in _contacts_of(person, theirs, side, times)]
        ups = np.concatenate([np.zeros((0, 3)), *(person.feet[side][part, 2] for part in flat)])
        if len(ups):
            up = ups.mean(axis=0)
        elif not theirs.links:
            up = np.array([-np.sin(SLOPE), 0.0, np.cos(SLOPE)])
        else:
            raise ValueError(f"the {side} foot must stand flat in the motion, as its skeleton does not at angle zero")
        forward = unit(line - (line @ unit(up)) * unit(up))
        turn = np.stack([forward, np.cross(unit(up), forward), unit(up)], axis=1)
        feet[side], zero[side] = person.feet[side] @ turn, (joint, axes @ turn)
    return person._replace(feet=feet), theirs._replace(feet=zero, unsure=())


def warn_of_flips(person: Person, times: np.ndarray) -> None:
    """Warn if a foot turns between two frames as no foot can, an error of the recording."""
    for side, axes in person.feet.items():
        cosines = (np.einsum("nij,nij->n", axes[1:], axes[:-1]) - 1.0) / 2.0
        turns = np.arccos(np.clip(cosines, -1.0, 1.0))
        flips = (turns > FLIP) & (turns / np.diff(times) > FASTEST_FLIP)
        if flips.any():
            i = int(np.where(flips, turns, 0.0).argmax())
            warn(
                f"the {side} foot turns by {np.degrees(turns[i]):.0f}° from frame {i} to {i + 1}: correct the recording"
            )


def _contacts_of(person: Person, theirs: Stance, side: str, times: np.ndarray) -> list[Contact]:
    """When a foot stands: where it was seen, and its toes do not point up."""
    may = person.seen[side]
    if side not in theirs.unsure:
        may = may & (person.feet[side][:, 2, 0] < UP)
    return find_contacts(person.at[theirs.toe(side)], person.at[f"{side}_{ANKLE}"], times, theirs.leg(), may)


def show_axes(joint: int, axes: np.ndarray) -> list[Place]:
    """Three places on a link that show its axes."""
    return [Place(joint, np.zeros(3)), Place(joint, axes[:, 0]), Place(joint, axes[:, 1])]


def axes_from(points: np.ndarray) -> np.ndarray:
    """Axes (n, 3, 3) from the positions (n, 3, 3) of the places of `show_axes`."""
    x, y = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    return np.stack([x, y, np.cross(x, y)], axis=2)


def level(axes: np.ndarray) -> np.ndarray:
    """Turn axes (n, 3, 3) level, with their heading."""
    ahead = axes[:, :, 0] + np.cross(axes[:, :, 1], [0.0, 0.0, 1.0])  # on its back, where its head is
    ahead[:, 2] = 0.0
    x, z = unit(ahead), np.broadcast_to([0.0, 0.0, 1.0], ahead.shape)
    return np.stack([x, np.cross(z, x), z], axis=2)


def find_ground(person: Person, theirs: Stance, times: np.ndarray) -> tuple[dict[str, list[Contact]], float]:
    """When each foot stands, and the height of the ankle of a foot that stands flat."""
    contacts, heights, lowest = {}, [], np.inf
    for side in SIDES:
        toes, contacts[side] = person.at[theirs.toe(side)], _contacts_of(person, theirs, side, times)
        axes, zero = (
            theirs.feet[side][1],
            [theirs.places[mark].at_zero for mark in (f"{side}_{ANKLE}", theirs.toe(side))],
        )
        above = float((zero[0] - zero[1]) @ axes[:, 2])
        heights += [float(np.median(toes[c.first : c.end, 2])) + above for c in contacts[side]]
        lowest = min(lowest, float(toes[:, 2].min()) + above)
    return contacts, find_floor(np.array(heights), theirs.leg()) if heights else lowest


# --- the targets ----------------------------------------------------------------------------------------


def _size_of_legs(theirs: Stance, ours: Stance) -> float:
    """The ratio of the lengths of the legs, robot to person; without legs, of the heights of the shoulders."""
    leg = theirs.leg()
    if has_limb(ours.places, LEG):
        return ours.leg() / leg
    trunk = float((theirs.middle(SHOULDER) - theirs.middle(HIP)) @ theirs.axes[:, 2])
    return STRETCH[0] * float(ours.middle(SHOULDER) @ ours.axes[:, 2]) / (leg + trunk)


def _put_trunk(skeleton: Skeleton, person: Person, ours: Stance, scale: np.ndarray, ankle: float) -> list[Target]:
    """Put pelvis and chest where the person's are, along the axes of the world times a scale (3,).

    The person's ankles have the given height where feet stand on the floor.
    """
    soles = np.mean([sole_of(ours, side).tip[2] for side in SIDES])
    at = scale * (person.middle(HIP) - [0.0, 0.0, ankle]) - [0.0, 0.0, soles]
    middle = ours.middle(HIP)
    targets = targets_of_link(ours, ours.pelvis, middle, at, person.pelvis, WEIGHTS["pelvis"])
    if has_limb(ours.places, ARM):
        below = path_up(skeleton, ours.pelvis)
        moving = [j for j in path_up(skeleton, ours.chest) if j not in below and skeleton.bones[j].dofs]
        pivot = positions_at_zero(skeleton)[moving[-1]] if moving else middle  # about which the chest moves first
        chest = at + person.pelvis @ (ours.axes.T @ (pivot - middle))
        targets += targets_of_link(ours, ours.chest, pivot, chest, person.chest, WEIGHTS["chest"])
    return targets


def _base_of(skeleton: Skeleton, trunk: int) -> int:
    """The link of a mobile base, which joints move over the floor; without one, the root.

    These are slides, and hinges at the same point, before all others on the way to the trunk.
    """
    base = ROOT
    for joint in reversed(path_up(skeleton, trunk)):
        bone = skeleton.bones[joint]
        if any(bone.offset) or not (bone.is_slide or (bone.is_hinge and base != ROOT)):
            break
        base = joint
    return base


def _put_on_wheels(
    person: Person, ours: Stance, base: int, scale: np.ndarray, floor: float
) -> tuple[list[Target], list[Target]]:
    """Put a base without legs on the floor below the person's hips, and the chest in the height of the person's.

    If joints move the base, the root stays.
    """
    hips, shoulders = person.middle(HIP), person.middle(SHOULDER)
    below = scale * hips * [1.0, 1.0, 0.0]
    wheels = targets_of_link(ours, base, np.zeros(3), below, level(person.pelvis), WHEELS)
    if base != ROOT:
        still = np.broadcast_to(ours.axes, person.pelvis.shape)
        wheels += targets_of_link(ours, ROOT, np.zeros(3), np.zeros_like(hips), still, WHEELS)
    at = scale * (hips - [0.0, 0.0, floor]) + scale[2] * (shoulders - hips)
    return wheels, targets_of_link(ours, ours.chest, ours.middle(SHOULDER), at, person.chest, WEIGHTS["chest"])


def _read_trunk(
    found: FittedPoses, skeleton: Skeleton, ours: Stance
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """The positions of hips and shoulders, and the axes of pelvis and chest."""
    links = [(HIP, ours.pelvis)] * has_limb(ours.places, LEG) + [(SHOULDER, ours.chest)] * has_limb(ours.places, ARM)
    marks = [(f"{side}_{mark}", link) for mark, link in links for side in SIDES]
    places = [Place(link, ours.places[mark].at_zero) for mark, link in marks]
    places += show_axes(ours.pelvis, ours.axes) + show_axes(ours.chest, ours.axes)
    points = positions_in(found, skeleton, places)
    starts = {mark: points[:, i] for i, (mark, _) in enumerate(marks)}
    return starts, axes_from(points[:, -6:-3]), axes_from(points[:, -3:])


def _stretch(distances: np.ndarray, length: float) -> np.ndarray:
    """Limit distances to the reach of a limb, smoothly."""
    start, most = (share * length for share in STRETCH)
    beyond = np.maximum(distances - start, 0.0)
    return np.where(beyond > 0.0, most - (most - start) * np.exp(-beyond / (most - start)), distances)


def _shift_within_reach(legs: dict[str, Held], starts: dict[str, np.ndarray], ours: Stance) -> np.ndarray:
    """The shift (n_frames, 3) of the hips by which legs reach feet that stand."""
    length = ours.leg()
    shift = np.zeros_like(starts[f"left_{HIP}"])
    for _ in range(3):  # each leg moves the other hip
        for side, leg in legs.items():
            reach = leg.ankles - starts[f"{side}_{HIP}"] - shift
            distance = np.linalg.norm(reach, axis=1)
            shift += (leg.stands * (distance - _stretch(distance, length)))[:, None] * unit(reach)
    return shift


def _bend(
    start: np.ndarray, end: np.ndarray, toward: np.ndarray, lengths: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """The middle joint and the end (n_frames, 3) of a limb that bends toward a direction.

    An end that is too far away is not reached.
    """
    a, b = lengths
    reach, along = np.linalg.norm(end - start, axis=1), unit(end - start)
    d = np.maximum(_stretch(reach, a + b), abs(a - b) + 1e-6)
    share = (a * a - b * b + d * d) / (2.0 * d)
    height = np.sqrt(np.maximum(a * a - share * share, 0.0))
    across = toward - (toward * along).sum(axis=1, keepdims=True) * along
    return start + share[:, None] * along + height[:, None] * unit(across), start + d[:, None] * along


def _bend_limbs(skeleton: Skeleton, stance: Stance, rest: np.ndarray) -> np.ndarray:
    """Bend the hinges of knees and elbows of the pose at rest, to the side of the larger limit.

    A limb that is straight at a limit does not bend by small steps: its ends come nearer by the square of the angle.
    """
    pose = rest.copy()
    middles = {place.joint for mark, place in stance.places.items() if mark.partition("_")[2] in (KNEE, ELBOW)}
    for joint, (bone, columns) in enumerate(with_columns(skeleton.bones)):
        if joint in middles and bone.n_dofs == 1 and bone.limits is not None:
            lower, upper = bone.limits[0]
            pose[columns] = min(upper, BENDS) if upper > -lower else max(lower, -BENDS)
    return pose


def _find_pole(person: Person, side: str, limb: Sequence[str], left: np.ndarray, sign: float) -> np.ndarray:
    """The direction (n_frames, 3) in which a limb bends: the person's, or for a straight one the natural one.

    Left (n_frames, 3) is the axis of the joint: about it a knee bends forward, with the sign −1, and an elbow backward
    where the arm hangs, down where it points forward.
    """
    start, middle, end = (person.at[f"{side}_{mark}"] for mark in limb)
    first, along = middle - start, unit(end - start)
    across = first - (first * along).sum(axis=1, keepdims=True) * along
    size = np.linalg.norm(first, axis=1, keepdims=True)
    straight = np.maximum(1.0 - np.linalg.norm(across, axis=1, keepdims=True) / (BENT * size), 0.0) ** 2
    return np.asarray(across + sign * POLE * size * straight * np.cross(left, along))


def _put_leg(person: Person, ours: Stance, side: str, start: np.ndarray, leg: Held) -> list[Target]:
    """The targets of a leg: the knee, and the corners of the sole."""
    lengths = ours.length(HIP, KNEE), ours.length(KNEE, ANKLE)
    knee, end = _bend(start, leg.ankles, _find_pole(person, side, LEG, leg.frames[:, :, 1], -1.0), lengths)
    end = end + leg.stands[:, None] * (leg.ankles - end)
    targets = [Target(ours.places[f"{side}_{KNEE}"], knee, WEIGHTS["knee"])]
    (joint, axes), (heel, tip, half) = ours.feet[side], sole_of(ours, side)
    ankle = ours.places[f"{side}_{ANKLE}"].at_zero
    for x, y in ((tip[0], half), (tip[0], -half), (heel[0], 0.0)):
        corner = np.array([x, y, tip[2]])
        place, at = Place(joint, ankle + axes @ corner), end + leg.frames @ corner
        targets.append(Target(place, at, WEIGHTS["foot"], f"{side} foot"))
    return targets


def _put_arm(person: Person, ours: Stance, side: str, start: np.ndarray, chest: np.ndarray) -> list[Target]:
    """The targets of an arm: elbow, wrist and hand."""
    lengths = ours.length(SHOULDER, ELBOW), ours.length(ELBOW, WRIST)
    joints = np.stack([person.at[f"{side}_{mark}"] for mark in ARM])
    wished = start + np.tensordot(lengths, unit(np.diff(joints, axis=0)), axes=1)
    elbow, end = _bend(start, wished, _find_pole(person, side, ARM, chest[:, :, 1], 1.0), lengths)
    wrist = ours.places[f"{side}_{WRIST}"]
    targets = [Target(ours.places[f"{side}_{ELBOW}"], elbow, WEIGHTS["elbow"])]
    targets.append(Target(wrist, end, WEIGHTS["wrist"], "hands"))
    hand = ours.places.get(f"{side}_{HAND}")
    if hand is not None and f"{side}_{HAND}" in person.at:
        length = float(np.linalg.norm(hand.at_zero - wrist.at_zero))
        along = unit(person.at[f"{side}_{HAND}"] - person.at[f"{side}_{WRIST}"])
        targets.append(Target(hand, end + length * along, WEIGHTS["hand"], "hands"))
    return targets


# --- the poses --------------------------------------------------------------------------------------------------------
# The poses whose places on links are nearest to given positions.


def targets_of_link(
    stance: Stance, joint: int, origin: np.ndarray, at: np.ndarray, axes: np.ndarray, weight: float
) -> list[Target]:
    """Targets around a point of a link that show its position (n_frames, 3) and its axes (n_frames, 3, 3)."""
    return [Target(Place(joint, origin + stance.axes @ corner), at + axes @ corner, weight) for corner in CORNERS]


def solve(
    skeleton: Skeleton, targets: Sequence[Target], rest: np.ndarray, stiffness: float, times: np.ndarray
) -> FittedPoses:
    """Find the poses of a motion whose places are nearest to their targets, each frame starting from the one before.

    The poses are of the joints that carry places; the places are the last joints. The limits of the skeleton are
    enforced. `stiffness` is the regularization of `inverse_kinematics`, m/rad.
    """
    part = with_places(skeleton, [target.place for target in targets])
    n, first = len(times), part.n_joints - len(targets)
    wished = np.full((n, part.n_joints, 3), np.nan)
    wished[:, first:] = np.stack([target.position for target in targets], axis=1)
    weights = np.concatenate([np.zeros(first), [target.weight for target in targets]])
    limits = "ignore" if part.limits is None else "enforce"
    problem = problem_of(wished, part, weights, rest[part.columns_in(skeleton)], None, limits, stiffness)
    changes = FASTEST * np.diff(times, prepend=-np.inf)
    problem = replace(problem, changes=changes, rules=problem.rules._replace(tries_first=True))
    return problem.fit(problem.solve(Task(0, n, 0, n)))  # one task, so that no frame depends on where a task ends


def positions_in(found: FittedPoses, skeleton: Skeleton, places: Sequence[Place]) -> np.ndarray:
    """The positions (n_frames, n_places, 3) of other places on the same joints."""
    poses = np.zeros((len(found), skeleton.n_dofs))  # other angles do not move these places
    poses[:, found.skeleton.columns_in(skeleton)] = found.poses
    roots = Rotation.from_rotvec(found.root_rotations).as_matrix()
    return positions_of(skeleton, places, poses, roots, found.root_positions)


def positions_of(
    skeleton: Skeleton, places: Sequence[Place], poses: np.ndarray, roots: np.ndarray, origins: np.ndarray
) -> np.ndarray:
    """The positions (n_frames, n_places, 3) of places in poses whose root is rotated by matrices and at origins."""
    part = with_places(skeleton, places)
    points = joint_positions(poses[:, part.columns_in(skeleton)], part)[:, -len(places) :]
    return np.asarray(points @ roots.transpose(0, 2, 1) + origins[:, None])


def rest_pose(skeleton: Skeleton) -> np.ndarray:
    """The pose (n_dofs,) nearest to all angles zero within the limits."""
    return np.asarray(np.clip(np.zeros(skeleton.n_dofs), *ranges_of(skeleton.bones).T))


@functools.lru_cache(maxsize=16)
def hold_at_rest(skeleton: Skeleton, joints: tuple[int, ...]) -> Skeleton:
    """Keep some joints of a skeleton at rest, by limits."""
    rest = rest_pose(skeleton)
    bones = (
        bone._replace(limits=[(angle, angle) for angle in rest[columns]]) if joint in joints else bone
        for joint, (bone, columns) in enumerate(with_columns(skeleton.bones))
    )
    return Skeleton(bones, skeleton.offset_frame)
