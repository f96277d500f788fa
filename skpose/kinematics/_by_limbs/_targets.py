"""Retargeting by limbs, onto a skeleton of hinges with limits such as a robot's.

Three steps, each for all frames of a motion. The pelvis and the chest of the target are put where the person's are, in
the size of its legs, as near as its trunk can. From its own hips and shoulders the ends of its limbs are where the
person's are, in the size of each limb; feet that stand are held still; knees and elbows bend to the side to which the
person's do. Inverse kinematics finds the poses that are nearest to all of these, within the limits.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.spatial.transform import Rotation

from skpose.kinematics._by_limbs._contacts import Contact, Held, hold_foot
from skpose.kinematics._by_limbs._person import (
    Limb,
    Person,
    axes_from,
    find_ground,
    lay_unsure_feet,
    level,
    lowest_ankle,
    person_of,
    show_axes,
    to_vertical,
    warn_of_flips,
)
from skpose.kinematics._by_limbs._places import ARM, LEG, Place, Stance, length_of_leg, rolls_of, sole_of, toe_of
from skpose.kinematics._by_limbs._robots import HEEL, TIP
from skpose.kinematics._by_limbs._solver import Solution, Targets, hold_at_rest, rest_within_limits, solve
from skpose.kinematics._landmarks import SIDES, path_up
from skpose.kinematics._lines import ROOT, unit
from skpose.kinematics._rigs import ANKLE, ELBOW, HAND, HIP, KNEE, SHOULDER, WRIST
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import continuous_root_angles, positions_at_zero

POLE = (
    0.15  # of the first bone of a limb, by which knees bend forward and elbows backward where the person's are straight
)
BENT = 0.3  # of it, by which a joint is off the line of the limb's ends where only the person's bend counts
BENDS = 0.5  # rad
STRETCH = 0.985, 0.9995  # of a limb, from which on it stretches ever less, and which it never reaches
STIFFNESS = 0.005  # m/rad, of all joints towards their rest pose
TRUNK_STIFFNESS = 1e-3
# Of the squared distances of places: four on the pelvis, four on the chest, three on the sole of each foot.
WEIGHTS = {"pelvis": 0.3, "chest": 0.2, "knee": 0.3, "foot": 40.0, "elbow": 0.3, "wrist": 1.0, "hand": 0.5}
WHEELS = 50.0  # of a robot without legs, on the floor
FASTEST = 20.0  # rad/s, of a joint; those of a G1 reach 20 to 37
# Heading first, so that no heading is near to where Euler angles jump for a root whose z axis is up.
ROOT_AXES = {"x": "XZY", "y": "YZX", "z": "ZYX"}
AT_LIMIT = 1e-9  # rad
NEARBY = 0.025  # s before and after, within which the person is as fast
FASTER = 1.0  # m/s more than the person's, from which a report names it; feet that go to where they are held have less
BELOW = 1e-3  # m, from which a report names soles below the floor


class Fitted(NamedTuple):
    """A motion on the target, and how near it came."""

    motion: Motion
    feet: np.ndarray  # distances of places on the feet from where they shall be, m
    hands: np.ndarray  # those of wrists and hands
    slides: np.ndarray  # (n_contacts,) by how much the toes move at most while they stand, m
    below: float  # by how much a corner of a sole is below the floor at most, m
    feet_faster: float  # by how much toes, and the pelvis, are faster than the person's at most, m/s
    pelvis_faster: float
    at_limits: int  # angles that are at a limit in some frame
    n_left: int  # frames that did not converge
    moving: list[int]  # joints

    def in_words(self) -> str:
        """Return in words how near the motion came."""
        parts = [
            f"{name} {_millimetres(off)}" for name, off in (("soles", self.feet), ("hands", self.hands)) if off.size
        ]
        if len(self.slides):
            parts.append(f"feet stand {len(self.slides)} times and slide by {_round(self.slides.max())} mm at most")
        elif self.feet.size:
            parts.append("feet stand nowhere")
        if self.below >= BELOW:
            parts.append(f"soles are {_round(self.below)} mm below the floor at most")
        faster = (("toes", self.feet_faster), ("the pelvis", self.pelvis_faster))
        named = [f"{name} by up to {speed:.2g} m/s" for name, speed in faster if speed >= FASTER]
        if named:
            parts.append(f"faster than the person's: {' and '.join(named)}")
        if self.at_limits:
            parts.append(f"{self.at_limits} angles reach their limits")
        if self.n_left:
            parts.append(f"{self.n_left} of {len(self.motion)} frames did not converge")
        return "".join(f", {part}" for part in parts)


def _round(metres: float) -> str:
    return f"{float(f'{1e3 * metres:.2g}'):g}"


def _millimetres(distances: np.ndarray) -> str:
    """Return in words how far off places are."""
    return f"{_round(distances.mean())} mm off (95 %: {_round(float(np.percentile(distances, 95)))})"


class Aim(NamedTuple):
    """The positions of places to which the poses of the target shall be near."""

    skeleton: Skeleton  # the target with the limits that are enforced
    rest: np.ndarray  # (n_dofs,) its pose at rest
    bent: np.ndarray  # (n_dofs,) that with knees and elbows bent, from which the poses are searched
    rolls: list[int]  # its joints that stay there, though they carry places
    targets: Targets
    legs: dict[str, Held]
    ways: dict[str, np.ndarray]  # (n_frames, 3) of the person's toes, by side, and hips, in the size of the target
    is_on_base: bool  # whether its own joints move it over the floor, and its root stays where it is


def by_limbs(
    motion: Motion, skeleton: Skeleton, theirs: Stance, ours: Stance, factor: float | None, joint_limits: str
) -> Fitted:
    """Return a motion on a skeleton; a factor is that of positions in the world, None the ratio of the legs."""
    aim = aim_at(motion, skeleton, theirs, ours, factor, joint_limits)
    final = solve(aim.skeleton, aim.targets, aim.bent, STIFFNESS, motion.times, FASTEST)
    return _collect(motion, skeleton, theirs, ours, final, aim)


def aim_at(
    motion: Motion, skeleton: Skeleton, theirs: Stance, ours: Stance, factor: float | None, joint_limits: str
) -> Aim:
    """Return where places on the target shall be."""
    person, theirs = lay_unsure_feet(person_of(motion, theirs), theirs, motion.times)
    warn_of_flips(person, motion.times)
    rest = rest_within_limits(skeleton, joint_limits)
    rolls = rolls_of(skeleton, ours)
    held = hold_at_rest(skeleton, tuple(rolls), joint_limits)
    trunk, on_legs = Targets(ours.axes), ours.has(LEG)
    size = _size_of_legs(theirs, ours)
    scale = size * np.ones(3) if factor is None else np.array([factor, factor, size])  # heights are those of the legs
    contacts: dict[str, list[Contact]] = {}
    if on_legs:
        contacts, floor = find_ground(person, theirs, motion.times)
        _put_trunk(trunk, skeleton, person, ours, scale, floor)
    else:
        _put_on_wheels(trunk, person, ours, _base_of(skeleton, ours.chest), scale, lowest_ankle(person))
    first = solve(held, trunk, rest, TRUNK_STIFFNESS, motion.times, FASTEST)
    starts, pelvis, chest = _read_trunk(first, held, ours)
    targets = Targets(ours.axes)
    legs: dict[str, Held] = {}
    if on_legs:
        legs = {side: _stand(person, theirs, ours, side, starts, contacts[side], motion.times) for side in SIDES}
        shift = _shift_within_reach(legs, starts, ours)
        starts = {mark: start + shift for mark, start in starts.items()}
        middle = (starts[f"left_{HIP}"] + starts[f"right_{HIP}"]) / 2.0
        targets.add_link(ours.pelvis, _middle(ours, HIP), middle, pelvis, WEIGHTS["pelvis"])
        for side, leg in legs.items():
            _put_leg(targets, person, ours, side, starts[f"{side}_{HIP}"], leg)
    else:
        for i in trunk.groups["wheels"]:
            targets.add(trunk.places[i], trunk.positions[i], WHEELS, "links")
    if ours.has(ARM):
        middle = (starts[f"left_{SHOULDER}"] + starts[f"right_{SHOULDER}"]) / 2.0
        if ours.chest != ours.pelvis or not on_legs:
            targets.add_link(ours.chest, _middle(ours, SHOULDER), middle, chest, WEIGHTS["chest"])
        for side in SIDES:
            _put_arm(targets, person, ours, side, starts[f"{side}_{SHOULDER}"], chest)
    is_on_base = not on_legs and _base_of(skeleton, ours.chest) != ROOT
    ways = {side: scale * person.toes[side] for side in legs}
    if on_legs:
        ways["pelvis"] = scale * (person.limbs[f"left_{HIP}"].start + person.limbs[f"right_{HIP}"].start) / 2.0
    return Aim(held, rest, _bend_limbs(held, ours, rest), rolls, targets, legs, ways, is_on_base)


# --- where the target shall be ----------------------------------------------------------------------------------------


def _size_of_legs(theirs: Stance, ours: Stance) -> float:
    """Return how many times as long legs are in the target; without legs, how many times as high its shoulders."""
    leg = length_of_leg(theirs)
    if ours.has(LEG):
        return length_of_leg(ours) / leg
    trunk = float((_middle(theirs, SHOULDER) - _middle(theirs, HIP)) @ theirs.axes[:, 2])
    return STRETCH[0] * float(_middle(ours, SHOULDER) @ ours.axes[:, 2]) / (leg + trunk)


def _middle(stance: Stance, mark: str) -> np.ndarray:
    """Return the middle (3,) between two places at angle zero."""
    return np.asarray(np.mean([stance.places[f"{side}_{mark}"].at_zero for side in SIDES], axis=0))


def _pivot(skeleton: Skeleton, stance: Stance) -> np.ndarray:
    """Return the point (3,) at angle zero about which the chest moves first, or the middle between the hips."""
    path = [joint for joint in path_up(skeleton, stance.chest) if joint not in path_up(skeleton, stance.pelvis)]
    moving = [joint for joint in path if skeleton.bones[joint].dofs]
    return positions_at_zero(skeleton)[moving[-1]] if moving else _middle(stance, HIP)


def _put_trunk(
    targets: Targets, skeleton: Skeleton, person: Person, ours: Stance, scale: np.ndarray, ankle: float
) -> None:
    """Put pelvis and chest where the person's are, along the axes of the world in another size (3,).

    The person's ankles have the given height where feet stand on the floor.
    """
    soles = np.mean([sole_of(ours, side).tip[2] for side in SIDES])
    hips = (person.limbs[f"left_{HIP}"].start + person.limbs[f"right_{HIP}"].start) / 2.0
    at = scale * (hips - [0.0, 0.0, ankle]) - [0.0, 0.0, soles]
    middle = _middle(ours, HIP)
    targets.add_link(ours.pelvis, middle, at, person.pelvis, WEIGHTS["pelvis"])
    if ours.has(ARM):
        pivot = _pivot(skeleton, ours)
        chest = at + person.pelvis @ (ours.axes.T @ (pivot - middle))
        targets.add_link(ours.chest, pivot, chest, person.chest, WEIGHTS["chest"])


def _base_of(skeleton: Skeleton, chest: int) -> int:
    """Return the link of a mobile base, which joints move over the floor, and the root where none do.

    These are slides, and hinges at the same point, before all others.
    """
    base = ROOT
    for joint in reversed(path_up(skeleton, chest)):
        bone = skeleton.bones[joint]
        if any(bone.offset) or not (bone.is_slide or (bone.is_hinge and base != ROOT)):
            break
        base = joint
    return base


def _put_on_wheels(targets: Targets, person: Person, ours: Stance, base: int, scale: np.ndarray, floor: float) -> None:
    """Put a base without legs on the floor below the person's hips, and the chest in the height of the person's.

    Where joints move the base the root stays where it is.
    """
    hips, shoulders = (
        (person.limbs[f"left_{mark}"].start + person.limbs[f"right_{mark}"].start) / 2.0 for mark in (HIP, SHOULDER)
    )
    targets.add_link(base, np.zeros(3), scale * hips * [1.0, 1.0, 0.0], level(person.pelvis), WHEELS, "wheels")
    if base != ROOT:
        still = np.broadcast_to(ours.axes, person.pelvis.shape)
        targets.add_link(ROOT, np.zeros(3), np.zeros_like(hips), still, WHEELS, "wheels")
    at = scale * (hips - [0.0, 0.0, floor]) + scale[2] * (shoulders - hips)
    targets.add_link(ours.chest, _middle(ours, SHOULDER), at, person.chest, WEIGHTS["chest"])


def _read_trunk(
    found: Solution, skeleton: Skeleton, ours: Stance
) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray]:
    """Return where hips and shoulders of the target came, and the axes of its pelvis and chest."""
    links = [(HIP, ours.pelvis)] * ours.has(LEG) + [(SHOULDER, ours.chest)] * ours.has(ARM)
    marks = [(f"{side}_{mark}", link) for mark, link in links for side in SIDES]
    places = [Place(link, ours.places[mark].at_zero) for mark, link in marks]
    points = found.positions(skeleton, places + show_axes(ours.pelvis, ours.axes) + show_axes(ours.chest, ours.axes))
    starts = {mark: points[:, i] for i, (mark, _) in enumerate(marks)}
    return starts, axes_from(points[:, -6:-3]), axes_from(points[:, -3:])


def _stand(
    person: Person,
    theirs: Stance,
    ours: Stance,
    side: str,
    starts: dict[str, np.ndarray],
    contacts: list[Contact],
    times: np.ndarray,
) -> Held:
    """Return where a leg of the target ends, from its own hip, with the foot held while it stands."""
    limb, length = person.limbs[f"{side}_{HIP}"], length_of_leg(ours)
    end = starts[f"{side}_{HIP}"] + _size_of_legs(theirs, ours) * (limb.end - limb.start)
    return hold_foot(end, person.feet[side], sole_of(ours, side), contacts, times, length)


def _stretch(distances: np.ndarray, length: float) -> np.ndarray:
    """Return how far a limb reaches that shall reach some distances: ever less as it stretches."""
    start, most = (share * length for share in STRETCH)
    beyond = np.maximum(distances - start, 0.0)
    return np.where(beyond > 0.0, most - (most - start) * np.exp(-beyond / (most - start)), distances)


def _shift_within_reach(legs: dict[str, Held], starts: dict[str, np.ndarray], ours: Stance) -> np.ndarray:
    """Return by how much (n_frames, 3) hips move so that legs reach feet that stand."""
    length = length_of_leg(ours)
    shift = np.zeros_like(starts[f"left_{HIP}"])
    for _ in range(3):  # each leg moves the hip of the other one
        for side, leg in legs.items():
            reach = leg.ankles - starts[f"{side}_{HIP}"] - shift
            distance = np.linalg.norm(reach, axis=1)
            shift += (leg.stands * (distance - _stretch(distance, length)))[:, None] * unit(reach)
    return shift


def _bend(
    start: np.ndarray, end: np.ndarray, toward: np.ndarray, lengths: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return where the middle joint of a limb and its end are (n_frames, 3) that bends toward a direction.

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
    """Return a pose with the hinges of knees and elbows away from zero, on the side where they have more room.

    A limb that is straight at a limit does not bend by small steps: its ends come nearer by the square of the angle.
    """
    pose, first = rest.copy(), np.cumsum([0, *(bone.n_dofs for bone in skeleton.bones)])
    for mark in (f"{side}_{name}" for side in SIDES for name in (KNEE, ELBOW)):
        bone = skeleton.bones[stance.places[mark].joint] if mark in stance.places else None
        if bone is not None and bone.n_dofs == 1 and bone.limits is not None:
            lower, upper = bone.limits[0]
            pose[first[stance.places[mark].joint]] = min(upper, BENDS) if upper > -lower else max(lower, -BENDS)
    return pose


def _find_pole(limb: Limb, left: np.ndarray, sign: float) -> np.ndarray:
    """Return the direction (n_frames, 3) to which a limb bends: to that of the person, or as a straight one would.

    Left (n_frames, 3) is the axis of the joint: about it a knee bends forward, with the sign −1, and an elbow backward
    where the arm hangs, down where it points forward.
    """
    first, along = limb.middle - limb.start, unit(limb.end - limb.start)
    across = first - (first * along).sum(axis=1, keepdims=True) * along
    size = np.linalg.norm(first, axis=1, keepdims=True)
    straight = np.maximum(1.0 - np.linalg.norm(across, axis=1, keepdims=True) / (BENT * size), 0.0) ** 2
    return np.asarray(across + sign * POLE * size * straight * np.cross(left, along))


def _put_leg(targets: Targets, person: Person, ours: Stance, side: str, start: np.ndarray, leg: Held) -> None:
    """Add the places of a leg: the knee, and the corners of the sole."""
    limb, lengths = person.limbs[f"{side}_{HIP}"], (ours.length(HIP, KNEE), ours.length(KNEE, ANKLE))
    knee, end = _bend(start, leg.ankles, _find_pole(limb, leg.frames[:, :, 1], -1.0), lengths)
    end = end + leg.stands[:, None] * (leg.ankles - end)
    targets.add(ours.places[f"{side}_{KNEE}"], knee, WEIGHTS["knee"], "knees")
    (joint, axes), (heel, tip, half) = ours.feet[side], sole_of(ours, side)
    ankle = ours.places[f"{side}_{ANKLE}"].at_zero
    for x, y in ((tip[0], half), (tip[0], -half), (heel[0], 0.0)):
        corner = np.array([x, y, tip[2]])
        targets.add(Place(joint, ankle + axes @ corner), end + leg.frames @ corner, WEIGHTS["foot"], f"{side} foot")


def _put_arm(targets: Targets, person: Person, ours: Stance, side: str, start: np.ndarray, chest: np.ndarray) -> None:
    """Add the places of an arm: elbow, wrist and hand."""
    limb, lengths = person.limbs[f"{side}_{SHOULDER}"], (ours.length(SHOULDER, ELBOW), ours.length(ELBOW, WRIST))
    wished = start + lengths[0] * unit(limb.middle - limb.start) + lengths[1] * unit(limb.end - limb.middle)
    elbow, end = _bend(start, wished, _find_pole(limb, chest[:, :, 1], 1.0), lengths)
    wrist = ours.places[f"{side}_{WRIST}"]
    targets.add(ours.places[f"{side}_{ELBOW}"], elbow, WEIGHTS["elbow"], "elbows")
    targets.add(wrist, end, WEIGHTS["wrist"], "hands")
    hand = ours.places.get(f"{side}_{HAND}")
    if hand is not None and side in person.hands:
        length = float(np.linalg.norm(hand.at_zero - wrist.at_zero))
        targets.add(hand, end + length * person.hands[side], WEIGHTS["hand"], "hands")


# --- what came of it --------------------------------------------------------------------------------------------------


def _collect(motion: Motion, skeleton: Skeleton, theirs: Stance, ours: Stance, final: Solution, aim: Aim) -> Fitted:
    """Return the motion of the whole skeleton in the world, and how near it came."""
    angles = np.tile(aim.rest, (len(motion), 1))
    names = final.skeleton.dof_names
    columns = [skeleton.dof_names.index(name) for name in names]
    angles[:, columns] = final.poses
    vertical = to_vertical(motion.up)
    roots, origins = final.roots, final.origins
    if aim.is_on_base:  # exactly
        roots, origins = np.broadcast_to(np.eye(3), roots.shape), np.zeros_like(origins)
    root_angles, root_axes = continuous_root_angles(Rotation.from_matrix(vertical.T @ roots), ROOT_AXES[motion.up])
    result = replace(
        motion,
        skeleton=skeleton,
        angles=angles,
        root_positions=origins @ vertical,
        root_angles=root_angles,
        root_axes=root_axes,
        seen=_seen_of(motion, skeleton, theirs, ours),
    )
    feet = [i for side in SIDES for i in aim.targets.groups.get(f"{side} foot", [])]
    slides, below, feet_faster, pelvis_faster = [], 0.0, 0.0, 0.0
    for foot, leg in aim.legs.items():
        (joint, axes), ankle = ours.feet[foot], ours.places[f"{foot}_{ANKLE}"].at_zero
        corners = final.positions(skeleton, [Place(joint, ankle + axes @ x) for x in sole_of(ours, foot).corners()])
        below = max(below, -float(corners[:, :, 2].min()))
        tips = corners[:, 2:].mean(axis=1)
        feet_faster = max(feet_faster, _faster(tips, aim.ways[foot], motion.times))
        for contact in leg.contacts:
            stood = tips[contact.first : contact.end]
            slides.append(np.linalg.norm(stood - stood.mean(axis=0), axis=1).max())
    if aim.legs:
        pelvis = final.positions(skeleton, [Place(ours.pelvis, _middle(ours, HIP))])[:, 0]
        pelvis_faster = _faster(pelvis, aim.ways["pelvis"], motion.times)
    rolled = {name for joint in aim.rolls for name in skeleton.bones[joint].dof_names}
    at_limits = 0
    if aim.skeleton.limits is not None:
        lower, upper = np.array(aim.skeleton.limits)[columns].T
        reach = ((final.poses <= lower + AT_LIMIT) | (final.poses >= upper - AT_LIMIT)) & (lower < upper)
        at_limits = int(reach.any(axis=0).sum())
    moving = [j for j, bone in enumerate(skeleton.bones) if bone.dofs and set(bone.dof_names) <= set(names) - rolled]
    return Fitted(
        result,
        final.residuals[:, feet],
        final.residuals[:, aim.targets.groups.get("hands", [])],
        np.array(slides),
        below,
        feet_faster,
        pelvis_faster,
        at_limits,
        int((~final.converged).sum()),
        moving,
    )


def _faster(ours: np.ndarray, theirs: np.ndarray, times: np.ndarray) -> float:
    """Return by how much a way (n_frames, 3) is faster than another is shortly before or after, m/s, at most."""
    if len(times) < 2:
        return 0.0
    steps = np.diff(times)
    speeds, known = (np.linalg.norm(np.diff(way, axis=0), axis=1) / steps for way in (ours, theirs))
    around = 2 * int(np.ceil(NEARBY / float(np.median(steps)))) + 1
    return float((speeds - maximum_filter1d(known, around, mode="nearest")).max())


def _seen_of(motion: Motion, skeleton: Skeleton, theirs: Stance, ours: Stance) -> np.ndarray | None:
    """Return in which frames each joint of a skeleton was seen: where those landmarks were between which it is."""
    if motion.seen is None:
        return None
    marks: dict[int, set[int]] = {}  # joints of the person that are counterparts of those at a joint of the target
    for mark, place in ours.places.items():
        side, _, name = mark.partition("_")
        counterpart = toe_of(theirs, side) if name in (HEEL, TIP) else mark
        if counterpart in theirs.places:
            marks.setdefault(place.joint, set()).add(theirs.places[counterpart].joint)
    needed: list[set[int]] = [set() for _ in range(skeleton.n_joints)]
    for joint, here in marks.items():
        needed[joint] |= here
        between: list[int] = []
        for above in path_up(skeleton, joint)[1:]:
            if above in marks:
                for j in between:
                    needed[j] |= marks[above]
                break
            between.append(above)
            needed[above] |= here
    seen = np.zeros((len(motion), skeleton.n_joints), bool)
    for j, joints in enumerate(needed):
        if joints:
            seen[:, j] = motion.seen[:, sorted(joints)].all(axis=1)
    return seen
