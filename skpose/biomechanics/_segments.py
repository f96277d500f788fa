"""The segments of a person: which joint carries each, and its rotation.

A segment is what is rigid between two joints: the thigh, the trunk. It is found by the landmarks of its skeleton, the
joints with known names. Its *axes* follow the ISB: x forward, y up, z to the right, where the person
stands with hanging arms.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import near_names
from skpose.kinematics._anatomy import ENDS_OF, SIDES, Anatomy, find_anatomy, find_misplaced, pair_of
from skpose.kinematics._body import find_segments as find_axes
from skpose.kinematics._orientations import poses_of
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._rest import ROOT, find_carriers, find_movers, positions_at_zero, unit
from skpose.skeleton._skeleton import check_joints

# Limbs: the landmarks at which each segment begins and may end; the first that is there is taken.
LIMBS = {
    "thigh": ("hip", ("knee",)),
    "shank": ("knee", ("ankle",)),
    "foot": ("ankle", ("ball", "toe")),
    "upper_arm": ("shoulder", ("elbow",)),
    "forearm": ("elbow", ("wrist",)),
    "hand": ("wrist", ("hand",)),
}


class Segment(NamedTuple):
    """A segment of a skeleton."""

    carrier: int  # the joint with which it rotates; -1 is the root
    start: int  # the joints at its ends; -1 is the root
    end: int
    points: tuple[int, ...]  # the joints that are fixed to it, which need not be those at its ends; -1 is the root
    at_zero: np.ndarray  # (n_points, 3) where these are at angle zero, from its start, m
    along: np.ndarray  # (3,) from its start to its end at angle zero, m


def find_segments(skeleton: Skeleton, person: Anatomy) -> dict[str, Segment]:
    """The segments that a skeleton has, by name: "pelvis", "left_thigh" and so on."""
    carriers, movers, joints = find_carriers(skeleton), find_movers(skeleton), person.joints
    zero = positions_at_zero(skeleton)  # the last is the root
    segments: dict[str, Segment] = {}

    def add(name: str, carrier: int, start: int, end: int) -> None:
        if not np.any(zero[end] - zero[start]) and name != "head":
            return  # without a length it has no direction
        carried = [j for j in range(skeleton.n_joints) if carriers[j] == carrier]
        points = tuple(sorted({*carried, *(int(skeleton.parents[j]) for j in carried)}))
        segments[name] = Segment(carrier, start, end, points, zero[list(points)] - zero[start], zero[end] - zero[start])

    trunk = find_axes(skeleton, person)
    for name, axes, mark in (("pelvis", "pelvis", "hip"), ("trunk", "chest", "shoulder")):
        if axes in trunk and (both := pair_of(joints, mark)):
            add(name, trunk[axes].joint, *both)
    for side in SIDES:
        for name, (begin, ends) in LIMBS.items():
            found = [joints[f"{side}_{end}"] for end in ends if f"{side}_{end}" in joints]
            if f"{side}_{begin}" in joints and found:
                add(f"{side}_{name}", carriers[found[0]], joints[f"{side}_{begin}"], found[0])
    top = [joints[mark] for mark in ("head_top", "head_center") if mark in joints]
    if top:
        add("head", carriers[top[0]], int(skeleton.parents[top[0]]), top[0])
    elif "head" in joints and skeleton.offset_frame == "parent":
        add("head", movers[joints["head"]], joints["head"], joints["head"])
    return segments


class Turned(NamedTuple):
    """The segments of a skeleton in each frame."""

    since_zero: dict[str, np.ndarray]  # (n_frames, 3, 3) rotations since angle zero, in the world
    positions: np.ndarray  # (n_frames, n_joints + 1, 3) of the joints in the axes of the world, the root the last, m

    def direction(self, segment: Segment) -> np.ndarray:
        """The directions (n_frames, 3) from the start of a segment to its end; zeros without length."""
        return unit(self.positions[:, segment.end] - self.positions[:, segment.start])

    def mean(self) -> "Turned":
        """The mean of the frames, as one."""
        rotations = {
            name: Rotation.from_matrix(each).mean().as_matrix()[None] for name, each in self.since_zero.items()
        }
        return Turned(rotations, self.positions.mean(axis=0, keepdims=True))


def turn_segments(motion: Motion, segments: dict[str, Segment]) -> Turned:
    """How the segments of a motion are turned."""
    joints, rotations = poses_of(motion)
    positions = np.concatenate([joints, np.zeros((len(motion), 1, 3))], axis=1)
    return Turned({name: rotations[segment.carrier].as_matrix() for name, segment in segments.items()}, positions)


# --- person -----------------------------------------------------------------------------------------------------------
# The joints of a person, as found or as given by the user.


LEGS = tuple(f"{side}_{mark}" for side in SIDES for mark in ("hip", "knee", "ankle"))
HEADS = ("head", "head_top", "head_center")
ENDS = tuple(f"{side}_{mark}" for side in SIDES for mark in ("ball", "toe", "shoulder", "elbow", "wrist", "hand"))
LANDMARKS = (*LEGS, *ENDS, *HEADS)
OTHER_SIDE = -0.5  # cosine of the angle between the lines of hips and shoulders from which one is exchanged


def find_person(skeleton: Skeleton, joints: Mapping[str, str] | None, required: Collection[str] = LEGS) -> Anatomy:
    """The landmarks of a skeleton, by its names or as given."""
    given, found = dict(joints or {}), find_anatomy(skeleton)
    check_joints(skeleton, given.values(), "joints")
    for mark in given:
        if mark not in LANDMARKS:
            near = near_names(LANDMARKS, str(mark), "see joints")
            raise ValueError(f"joints has the unknown landmark {mark!r}: {near}")
    numbers = {mark: skeleton.joint_names.index(name) for mark, name in given.items()}
    found = found._replace(joints=found.joints | numbers)
    require(found.joints, required)
    if given:
        _check_joints(skeleton, found, given)
    return found


def require(joints: Collection[str], marks: Collection[str]) -> None:
    """Refuse a person without some of the landmarks."""
    if absent := [mark for mark in marks if mark not in joints]:
        raise ValueError(f"{', '.join(absent)} not found: pass joints={{{absent[0]!r}: ...}}")


def _check_joints(skeleton: Skeleton, person: Anatomy, given: Mapping[str, str]) -> None:
    """Refuse landmarks, some given by the user, that are not at the joints of a person."""
    joints = {mark: joint for mark, joint in person.joints.items() if mark in LANDMARKS}
    if misplaced := find_misplaced(skeleton, joints, ENDS_OF):
        raise ValueError(f"joints do not fit the skeleton: {misplaced}")
    # A foot ends at the ball or the toe, so that both may be at one joint.
    parts = {mark: "head" if mark in HEADS else mark.replace("toe", "ball") for mark in joints}
    for mark in given:
        for other in joints:
            if joints[other] == joints[mark] and parts[other] != parts[mark]:
                raise ValueError(f"{mark} and {other} are one joint, {given[mark]!r}: check joints=")
    hips, shoulders = pair_of(joints, "hip"), pair_of(joints, "shoulder")
    if hips is not None and shoulders is not None:
        at_zero = positions_at_zero(skeleton)
        across, above = (at_zero[right] - at_zero[left] for left, right in (hips, shoulders))
        if across @ above < OTHER_SIDE * np.linalg.norm(across) * np.linalg.norm(above):
            raise ValueError("the left arm is on the side of the right leg: exchange left and right of one in joints=")


# --- seen -------------------------------------------------------------------------------------------------------------
# Segments of a person that positions show: nothing of them, the direction of their line, or all of the rotation.


# Least distance of a point from the line of its segment, relative to its length, if the point shows how the
# segment is rotated about the line. An epicondyle is 5 cm from the line of a thigh of 40 cm.
OFF_LINE = 0.05
SPREAD = 0.1  # the same of some of the points, about their own line, as a root of a sum of squares
APART = 0.5  # least distance of two points that show the direction of the line, likewise
NOTHING, DIRECTION, ROTATION = 0, 1, 2


def find_seen(motion: Motion, segments: dict[str, Segment]) -> tuple[set[str], dict[str, np.ndarray]]:
    """The segments as the positions show them to which a motion was fitted; a recording of rotations shows all.

    They are the names of segments of which no frame shows more than the direction; and of each segment, (n_frames,),
    whether a frame shows as much as any.
    """
    if motion.seen is None:
        return set(), {name: np.ones(len(motion), dtype=bool) for name in segments}
    known = find_shown(motion, range(motion.skeleton.n_joints))
    lines, frames = set(), {"trunk": np.zeros(len(motion), dtype=bool)}  # where the skeleton has none
    for name, segment in segments.items():
        patterns, which = np.unique(_seen_points(motion, known, segment), axis=0, return_inverse=True)
        shown: np.ndarray = np.array([_shows(segment, pattern) for pattern in patterns], dtype=int)[which.ravel()]
        most = int(shown.max(initial=NOTHING))
        if most < ROTATION:
            lines.add(name)
        frames[name] = shown >= max(most, DIRECTION)
    return lines, frames


def find_shown(motion: Motion, joints: Sequence[int]) -> np.ndarray:
    """In which frames the places of joints are known, (n_frames, n): the joint, or what it is fixed to, is seen.

    Three points that are not on one line show where everything is that is fixed to them.
    """
    if motion.seen is None:
        return np.ones((len(motion), len(joints)), dtype=bool)
    carriers, parents = np.array(find_carriers(motion.skeleton)), np.asarray(motion.skeleton.parents)
    zero, shown = positions_at_zero(motion.skeleton), motion.seen[:, joints].copy()
    for carrier in np.unique(carriers):
        carried = np.flatnonzero(carriers == carrier)
        points = np.array(sorted({*carried, *parents[carried]} - {ROOT}))
        patterns, which = np.unique(motion.seen[:, points], axis=0, return_inverse=True)
        size = float(np.linalg.norm(np.ptp(zero[points], axis=0)))
        shows = np.array([_is_spread(zero[points[pattern]], size) for pattern in patterns], dtype=bool)[which.ravel()]
        shown |= shows[:, None] & np.isin(joints, points)
    return shown


def _is_spread(points: np.ndarray, size: float) -> bool:
    """Whether points (n, 3) of a segment of some size, m, are not on one line."""
    return len(points) > 2 and bool(np.linalg.svd(points - points.mean(axis=0))[1][1] > SPREAD * size)


def _seen_points(motion: Motion, known: np.ndarray, segment: Segment) -> np.ndarray:
    """Which points of a segment, its start and its end are known, (n_frames, n_points + 2).

    The root has no position of its own. It is where a joint of no length is, or as far from a joint that another
    segment carries as their bone is long.
    """
    points = (*segment.points, segment.start, segment.end)
    columns = known[:, points].copy()
    if ROOT in points:
        at_zero = positions_at_zero(motion.skeleton)
        at_root = [
            joint
            for joint, parent in enumerate(motion.skeleton.parents)
            if parent == ROOT and (joint not in segment.points or not at_zero[joint].any())
        ]
        columns[:, np.equal(points, ROOT)] = known[:, at_root].any(axis=1, keepdims=True)
    return columns


def _shows(segment: Segment, seen: np.ndarray) -> int:
    """How much of a segment is shown by its known points and ends, (n_points + 2,) of bool."""
    length = float(np.linalg.norm(segment.along))
    (*_, start, end), fixed = seen, seen[:-2]
    points = segment.at_zero[fixed]
    if not length:  # as a head has that ends where it begins
        return DIRECTION if seen.any() else NOTHING
    across = points - (points @ segment.along)[:, None] * segment.along / length**2
    off_line = np.linalg.norm(across, axis=1) >= OFF_LINE * length
    ends_are_fixed = {segment.start, segment.end} <= {*segment.points}
    if (ends_are_fixed and fixed.all() and off_line.any()) or _is_spread(points, length):
        return ROTATION
    on_line = points[~off_line] @ segment.along / length
    two = len(on_line) > 1 and np.ptp(on_line) >= APART * length
    return DIRECTION if (start and end) or two else NOTHING
