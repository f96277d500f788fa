"""The limbs, hands and feet of a person in a motion, how pelvis and chest stand, and the floor."""

from typing import NamedTuple

import numpy as np

from skpose._utils.warnings import warn
from skpose.kinematics._landmarks import SIDES
from skpose.kinematics._lines import unit
from skpose.kinematics._rigs import ANKLE, HAND, HIP, WRIST
from skpose.robots._contacts import Contact, find_contacts, find_floor
from skpose.robots._stance import ARM, LEG, Place, Stance, positions_of
from skpose.skeleton import Motion
from skpose.skeleton._root import root_orientations

FLIP, FASTEST = np.radians(60.0), 100.0  # rad between frames, and rad/s, beyond which a foot cannot turn
UP = 0.7  # sine of the angle above the horizontal up to which a foot stands
SLOPE = np.radians(30.0)  # of the line from ankle to toes above the floor, if no foot stands flat


class Limb(NamedTuple):
    """The positions (n_frames, 3) of a limb's joints, m."""

    start: np.ndarray
    middle: np.ndarray
    end: np.ndarray


class Person(NamedTuple):
    """The parts of a person that are retargeted; the vertical is the last axis, columns are forward, left and up."""

    limbs: dict[str, Limb]  # "left_hip", "left_shoulder", …
    hands: dict[str, np.ndarray]  # by side, directions (n_frames, 3)
    toes: dict[str, np.ndarray]  # by side, positions (n_frames, 3); of the ankle if the foot has no other point
    feet: dict[str, np.ndarray]  # by side, axes (n_frames, 3, 3)
    pelvis: np.ndarray  # (n_frames, 3, 3) axes
    chest: np.ndarray
    seen: dict[str, np.ndarray]  # by side, whether toes and ankle were seen (n_frames,)

    def middle(self, mark: str) -> np.ndarray:
        """The positions (n_frames, 3) of the middle between both hips or both shoulders."""
        return (self.limbs[f"left_{mark}"].start + self.limbs[f"right_{mark}"].start) / 2.0


def to_vertical(up: str) -> np.ndarray:
    """The matrix (3, 3) that cycles the axes of the world such that the vertical is the last."""
    i = "xyz".index(up)
    return np.eye(3)[[(i + 1) % 3, (i + 2) % 3, i]]


def person_of(motion: Motion, stance: Stance) -> Person:
    """The parts of a person in a motion."""
    named = list(stance.places.items())
    trunk = {"pelvis": stance.pelvis, "chest": stance.chest}
    links = {link: (joint, stance.links.get(link, stance.axes)) for link, joint in trunk.items()} | stance.feet
    places = [place for _, place in named]
    for joint, axes in links.values():
        places += show_axes(joint, axes)
    vertical = to_vertical(motion.up)
    roots = vertical @ root_orientations(motion.root_angles, motion.root_axes).as_matrix()
    points = positions_of(motion.skeleton, places, motion.angles, roots, motion.root_positions @ vertical.T)
    at = {mark: points[:, i] for i, (mark, _) in enumerate(named)}
    firsts = range(len(named), len(places), 3)
    shown = {link: axes_from(points[:, i : i + 3]) for link, i in zip(links, firsts, strict=True)}
    limbs = {
        f"{side}_{limb[0]}": Limb(*(at[f"{side}_{mark}"] for mark in limb))
        for side in SIDES
        for limb in (LEG, ARM)
        if stance.has(limb)
    }
    hands = {side: unit(at[f"{side}_{HAND}"] - at[f"{side}_{WRIST}"]) for side in SIDES if f"{side}_{HAND}" in at}
    toes, feet, seen = {}, {}, dict.fromkeys(stance.feet, np.ones(len(motion), bool))
    for side in stance.feet:
        mark = stance.toe(side)
        toes[side] = at[mark]
        feet[side] = level(shown["pelvis"]) if mark == f"{side}_{ANKLE}" else shown[side]
        joints = [stance.places[name].joint for name in (mark, f"{side}_{ANKLE}")]
        if motion.seen is not None:
            seen[side] = np.asarray(motion.seen[:, joints].all(axis=1))
    return Person(limbs, hands, toes, feet, shown["pelvis"], shown["chest"], seen)


def lay_unsure_feet(person: Person, theirs: Stance, times: np.ndarray) -> tuple[Person, Stance]:
    """Find the axes of feet that do not show at angle zero how they stand.

    Such feet are level where they stand flat in the motion. If none does, a foot that points along the shank at angle
    zero stands with a slope of `SLOPE`.
    """
    feet, zero = dict(person.feet), dict(theirs.feet)
    for side in theirs.unsure:
        if theirs.toe(side) == f"{side}_{ANKLE}":
            continue  # such a foot is level
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
        flips = (turns > FLIP) & (turns / np.diff(times) > FASTEST)
        if flips.any():
            i = int(np.where(flips, turns, 0.0).argmax())
            warn(
                f"the {side} foot turns by {np.degrees(turns[i]):.0f}° from frame {i} to {i + 1}: correct the recording"
            )


def _contacts_of(person: Person, theirs: Stance, side: str, times: np.ndarray) -> list[Contact]:
    """When a foot stands: where it was seen, and its toes do not point up."""
    ankles, may = person.limbs[f"{side}_{HIP}"].end, person.seen[side]
    if side not in theirs.unsure:
        may = may & (person.feet[side][:, 2, 0] < UP)
    return find_contacts(person.toes[side], ankles, times, theirs.leg(), may)


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
        toes, contacts[side] = person.toes[side], _contacts_of(person, theirs, side, times)
        axes, zero = (
            theirs.feet[side][1],
            [theirs.places[mark].at_zero for mark in (f"{side}_{ANKLE}", theirs.toe(side))],
        )
        above = float((zero[0] - zero[1]) @ axes[:, 2])
        heights += [float(np.median(toes[c.first : c.end, 2])) + above for c in contacts[side]]
        lowest = min(lowest, float(toes[:, 2].min()) + above)
    return contacts, find_floor(np.array(heights), theirs.leg()) if heights else lowest
