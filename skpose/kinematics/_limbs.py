"""Retargeting by limbs, onto a skeleton of hinges with limits such as a robot's.

Three steps, each for all frames of a motion. The pelvis and the chest of the target are put where the person's are, in
the size of its legs, as near as its trunk can. From its own hips and shoulders the ends of its limbs are where the
person's are, in the size of each limb; feet that stand are held still; knees and elbows bend to the side to which the
person's do. Inverse kinematics finds the pose that is nearest to all of these, within the limits, frame after frame.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.kinematics._contacts import Contact, find_contacts, find_floor, hold_foot
from skpose.kinematics._forward import forward_kinematics
from skpose.kinematics._inverse_problem import Task, problem_of
from skpose.kinematics._landmarks import SIDES
from skpose.kinematics._lines import ROOT, unit
from skpose.kinematics._places import ARM, LEG, Place, Stance, sole_of, with_places
from skpose.kinematics._rigs import ANKLE, BALL, ELBOW, HAND, HIP, KNEE, SHOULDER, TOE, WRIST
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import root_orientations

LEVER = 0.2  # m, of the points that show the orientation of a pelvis or a chest
POLE = 0.05  # of a limb's length, by which knees bend forward and elbows backward where the person's are straight
STIFFNESS = 0.01  # m/rad, of a joint towards its rest pose


class Limb(NamedTuple):
    """The positions (n_frames, 3) of a limb's joints in the world, m."""

    start: np.ndarray
    middle: np.ndarray
    end: np.ndarray


class Person(NamedTuple):
    """What is taken of a motion, in the world with the vertical as its last axis; axes have forward, left, up."""

    limbs: dict[str, Limb]  # "left_hip", "left_shoulder", …
    hands: dict[str, np.ndarray]  # by side, directions (n_frames, 3)
    toes: dict[str, np.ndarray]  # by side, positions (n_frames, 3)
    feet: dict[str, np.ndarray]  # by side, axes (n_frames, 3, 3)
    pelvis: np.ndarray  # (n_frames, 3, 3) axes
    chest: np.ndarray


def to_vertical(up: str) -> np.ndarray:
    """Return the matrix (3, 3) that takes the world to one whose last axis is the vertical, by a cycle of its axes."""
    i = "xyz".index(up)
    return np.eye(3)[[(i + 1) % 3, (i + 2) % 3, i]]


def _frame_places(joint: int, origin: np.ndarray, axes: np.ndarray, lever: float = 1.0) -> list[Place]:
    """Return three places on a link: a point, and those ahead of it and to the left."""
    return [Place(joint, origin + lever * axis) for axis in (np.zeros(3), axes[:, 0], axes[:, 1])]


def _axes_from(points: np.ndarray) -> np.ndarray:
    """Return axes (n, 3, 3) from the positions (n, 3, 3) of the places of `_frame_places`."""
    x, y = points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]
    return np.stack([x, y, np.cross(x, y)], axis=2)


def person_of(motion: Motion, stance: Stance) -> Person:
    """Return what is taken of a motion."""
    named = list(stance.places.items())
    links = {"pelvis": (stance.pelvis, stance.axes), "chest": (stance.chest, stance.axes)} | stance.feet
    places = [place for _, place in named]
    for joint, axes in links.values():
        places += _frame_places(joint, np.zeros(3), axes)
    skeleton = with_places(motion.skeleton, places)
    columns = [motion.skeleton.dof_names.index(name) for name in skeleton.dof_names]
    points = forward_kinematics(motion.angles[:, columns], skeleton)[:, -len(places) :]
    turn = to_vertical(motion.up) @ root_orientations(motion.root_angles, motion.root_axes).as_matrix()
    points = points @ turn.transpose(0, 2, 1) + (motion.root_positions @ to_vertical(motion.up).T)[:, None]
    at = {mark: points[:, i] for i, (mark, _) in enumerate(named)}
    axes = {link: _axes_from(points[:, i : i + 3]) for link, i in zip(links, range(len(named), len(places), 3), strict=True)}
    limbs = {
        f"{side}_{limb[0]}": Limb(*(at[f"{side}_{mark}"] for mark in limb))
        for side in SIDES
        for limb in (LEG, ARM)
        if stance.has(limb)
    }
    hands = {side: unit(at[f"{side}_{HAND}"] - at[f"{side}_{WRIST}"]) for side in SIDES if f"{side}_{HAND}" in at}
    toes = {side: at[f"{side}_{mark}"] for side in SIDES for mark in (TOE, BALL) if f"{side}_{mark}" in at}
    feet = {side: axes[side] for side in stance.feet}
    return Person(limbs, hands, toes, feet, axes["pelvis"], axes["chest"])


class Targets:
    """Places on the links of the target, their positions in each frame and weights."""

    def __init__(self, stance: Stance):
        self.stance = stance
        self.places: list[Place] = []
        self.positions: list[np.ndarray] = []
        self.weights: list[float] = []

    def add(self, place: Place, position: np.ndarray, weight: float) -> int:
        """Add a place with its positions (n_frames, 3); return its number."""
        self.places.append(place)
        self.positions.append(position)
        self.weights.append(weight)
        return len(self.places) - 1

    def add_frame(self, joint: int, origin: np.ndarray, at: np.ndarray, axes: np.ndarray, weight: float) -> None:
        """Add four places that show the position and the orientation of a link."""
        for corner in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
            arm = LEVER * np.array(corner)
            self.add(Place(joint, origin + self.stance.axes @ arm), at + axes @ arm, weight)


class Solution(NamedTuple):
    """Poses of the target's joints that carry places."""

    skeleton: Skeleton
    poses: np.ndarray
    roots: np.ndarray  # (n, 3, 3) orientations
    origins: np.ndarray  # (n, 3)
    residuals: np.ndarray  # (n, n_places) m
    n_iter: np.ndarray


def solve(skeleton: Skeleton, targets: Targets, rest: np.ndarray, joint_limits: str, stiffness: float) -> Solution:
    """Find the poses whose places are nearest to the positions of the targets, each frame from the one before."""
    part = with_places(skeleton, targets.places)
    n, first = len(targets.positions[0]), part.n_joints - len(targets.places)
    wished = np.full((n, part.n_joints, 3), np.nan)
    wished[:, first:] = np.stack(targets.positions, axis=1)
    weights = np.concatenate([np.zeros(first), targets.weights])
    columns = [skeleton.dof_names.index(name) for name in part.dof_names]
    limits = joint_limits if part.limits is not None else "ignore"
    problem = problem_of(wished, part, weights, rest[columns], None, limits, stiffness)
    found = problem.collect(problem.solve(Task(0, n, 0, n)))  # in one task, so that nothing depends on where it ends
    roots = Rotation.from_rotvec(found.root_rotations).as_matrix()
    return Solution(part, found.poses, roots, found.root_positions, found.residuals[:, first:], found.n_iter)


class Weights(NamedTuple):
    """Weights of the squared distances of places from where they shall be."""

    pelvis: float = 1.0  # of each of four points
    chest: float = 0.5
    feet: float = 20.0
    knees: float = 0.5
    hands: float = 2.0
    elbows: float = 0.5
    base: float = 50.0  # of a robot on wheels


def _place(stance: Stance, side: str, mark: str) -> Place:
    return stance.places[f"{side}_{mark}"]


def _middle(stance: Stance, mark: str) -> np.ndarray:
    """Return the middle (3,) between two places at angle zero."""
    return np.mean([_place(stance, side, mark).at_zero for side in SIDES], axis=0)


def _bend(start: np.ndarray, end: np.ndarray, toward: np.ndarray, lengths: tuple[float, float]) -> np.ndarray:
    """Return where a limb's middle joint is (n, 3) that bends toward a direction, its ends being where they are.

    Ends that are too far apart, or too near, leave it on their line.
    """
    reach = end - start
    distance = np.linalg.norm(reach, axis=1)
    along = unit(reach)
    a, b = lengths
    d = np.clip(distance, abs(a - b) + 1e-9, a + b)
    share = (a * a - b * b + d * d) / (2.0 * d)
    height = np.sqrt(np.maximum(a * a - share * share, 0.0))
    across = toward - (toward * along).sum(axis=1, keepdims=True) * along
    return start + share[:, None] * along + height[:, None] * unit(across)


def by_limbs(
    motion: Motion,
    skeleton: Skeleton,
    theirs: Stance,
    ours: Stance,
    factor: float | None,
    joint_limits: str,
    weights: Weights = Weights(),
    stiffness: float = STIFFNESS,
    hold: bool = True,
):
    person = person_of(motion, theirs)
    up = to_vertical(motion.up)
    times = motion.times
    n = len(motion)
    rest = np.zeros(skeleton.n_dofs)
    has_legs, has_arms = (theirs.has(limb) and ours.has(limb) for limb in (LEG, ARM))
    contacts: dict[str, list[Contact]] = {}
    floor = 0.0
    trunk = Targets(ours)
    if has_legs:
        leg = theirs.length(HIP, KNEE) + theirs.length(KNEE, ANKLE)
        size = (ours.length(HIP, KNEE) + ours.length(KNEE, ANKLE)) / leg
        scale = size if factor is None else factor
        heights = []
        for side in SIDES:
            contacts[side] = find_contacts(person.toes[side], person.limbs[f"{side}_{HIP}"].end, times, leg) if side in person.toes else []
            zero = theirs.feet[side][1].T @ (theirs.places.get(f"{side}_{TOE}", theirs.places.get(f"{side}_{BALL}")).at_zero - _place(theirs, side, ANKLE).at_zero)
            heights += [np.median(person.toes[side][c.first:c.end, 2]) - zero[2] for c in contacts[side]]
        floor = find_floor(np.array(heights)) if heights else 0.0 # TODO
        soles = {side: sole_of(ours, side) for side in SIDES}
        ankle = -float(np.mean([soles[side][1][2] for side in SIDES]))
        lift = np.array([0.0, 0.0, ankle - scale * floor])
        middle = (person.limbs[f"left_{HIP}"].start + person.limbs[f"right_{HIP}"].start) / 2.0
        trunk.add_frame(ours.pelvis, _middle(ours, HIP), scale * middle + lift, person.pelvis, 1.0)
    if has_legs:
        # chest about the pivot: the shoulders' middle, from the hips
        c0 = _middle(ours, HIP) 
        # position of chest link's own joint
        from skpose.skeleton._shared import positions_at_zero
        c0 = positions_at_zero(skeleton)[ours.chest] if ours.chest >= 0 else _middle(ours, HIP)
        rel = ours.axes.T @ (c0 - _middle(ours, HIP))
        trunk.add_frame(ours.chest, c0, scale * middle + lift + person.pelvis @ rel, person.chest, 0.5)
    found = solve(skeleton, trunk, rest, joint_limits, 1e-3)
    marks = [(side, mark) for side in SIDES for mark in ((HIP,) if has_legs else ()) + ((SHOULDER,) if has_arms else ())]
    places = [Place(ours.pelvis if mark == HIP else ours.chest, _place(ours, side, mark).at_zero) for side, mark in marks]
    places += _frame_places(ours.pelvis, np.zeros(3), ours.axes) + _frame_places(ours.chest, np.zeros(3), ours.axes)
    part = with_places(skeleton, places)
    cols = [found.skeleton.dof_names.index(name) for name in part.dof_names]
    at = forward_kinematics(found.poses[:, cols], part)[:, -len(places):] @ found.roots.transpose(0, 2, 1) + found.origins[:, None]
    pelvis, chest = _axes_from(at[:, len(marks):len(marks) + 3]), _axes_from(at[:, len(marks) + 3:])
    origin = dict(zip(marks, at.swapaxes(0, 1), strict=False))
    targets = Targets(ours)
    hm = (origin["left", HIP] + origin["right", HIP]) / 2
    targets.add_frame(ours.pelvis, _middle(ours, HIP), hm, pelvis, weights.pelvis)
    if ours.chest != ours.pelvis:
        targets.add_frame(ours.chest, c0, hm + pelvis @ rel, chest, weights.chest)
    info = {}
    for side in SIDES:
        if has_legs:
            limb = person.limbs[f"{side}_{HIP}"]
            start = origin[side, HIP]
            heel, tip, half = soles[side]
            end = start + size * (limb.end - limb.start)
            frames = person.feet[side]
            if hold:
                end, frames, flat = hold_foot(end, frames, tip, heel, contacts[side], times, leg * scale)
            lengths = ours.length(HIP, KNEE), ours.length(KNEE, ANKLE)
            pole = size * (limb.middle - limb.start) + POLE * leg * size * frames[:, :, 0]
            knee = _bend(start, end, pole, lengths)
            targets.add(_place(ours, side, KNEE), knee, weights.knees)
            joint, axes = ours.feet[side]
            a0 = _place(ours, side, ANKLE).at_zero
            for x, y in ((heel[0], 0.0), (tip[0], half), (tip[0], -half)):
                corner = np.array([x, y, tip[2]])
                i = targets.add(Place(joint, a0 + axes @ corner), end + frames @ corner, weights.feet)
                info.setdefault(side, []).append(i)
        if has_arms:
            limb = person.limbs[f"{side}_{SHOULDER}"]
            start = origin[side, SHOULDER]
            lengths = ours.length(SHOULDER, ELBOW), ours.length(ELBOW, WRIST)
            s = sum(lengths) / (theirs.length(SHOULDER, ELBOW) + theirs.length(ELBOW, WRIST))
            end = start + s * (limb.end - limb.start)
            pole = s * (limb.middle - limb.start) - POLE * sum(lengths) * chest[:, :, 0]
            elbow = _bend(start, end, pole, lengths)
            targets.add(_place(ours, side, ELBOW), elbow, weights.elbows)
            info["hand" + side] = targets.add(_place(ours, side, WRIST), end, weights.hands)
            if side in person.hands and f"{side}_{HAND}" in ours.places:
                h = float(np.linalg.norm(_place(ours, side, HAND).at_zero - _place(ours, side, WRIST).at_zero))
                targets.add(_place(ours, side, HAND), end + h * person.hands[side], weights.hands / 2)
    final = solve(skeleton, targets, rest, joint_limits, stiffness)
    return person, contacts, found, targets, final, info
