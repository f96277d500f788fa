"""The landmarks of a skeleton: which joint is its left knee, by the names of the rigs that are known.

Names alone do not suffice, as "LeftShoulder" is the shoulder in one rig and the collarbone's beginning in another. So a
skeleton is of a rig only as a whole: at least both legs or both arms have all their names, joints follow each other as
in a person, and the lengths at angle zero are a person's. Uncertain joints are left out.
"""

import itertools
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from skpose.kinematics._rigs import (
    ANKLE,
    BALL,
    COLLAR,
    ELBOW,
    END_NAMES,
    ENDS,
    HAND,
    HEAD,
    HIP,
    KNEE,
    LIMBS,
    RIGS,
    SHOULDER,
    TOE,
    WRIST,
    Rig,
)
from skpose.skeleton import Skeleton
from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._sides import others, split_sides

SIDES = ("left", "right")
NUMBERED = re.compile(rf"(.*[^\W_])([\W_]\d+)((?:_?(?:{'|'.join(END_NAMES)}))?)", re.IGNORECASE)
SIGNS = re.compile(r"[\W_]+")  # between words
HIPS = "hips"  # the joint that carries both legs, if it is not the root
ORDER = ((HIP, KNEE, ANKLE), (COLLAR, SHOULDER, ELBOW, WRIST))  # in this order, as far as known
NO_PERSON = ("tail", "wing", "paw", "hoof")  # the first letters of names that animals have
# Lengths in a person, between two joints.
LENGTHS = {"thigh": (HIP, KNEE), "shank": (KNEE, ANKLE), "upper arm": (SHOULDER, ELBOW), "forearm": (ELBOW, WRIST)}
LENGTHS |= {"leg": (HIP, ANKLE), "arm": (SHOULDER, WRIST)}
# Lengths of the first over the second in people and in files of them; arms are short where a file ends within the
# forearm, and a name that is at the other end of its bone makes them 0.3 or 3.
PROPORTIONS = (
    ("thigh", "shank", 0.6, 1.7),
    ("upper arm", "forearm", 0.5, 2.6),
    ("leg", "arm", 0.9, 3.0),
)
FORWARD = 0.5  # cosine of the largest angle between the direction forward and a foot that ends at the toe
SYMMETRY = 1.25  # how many times as long as on the other side


class Landmarks(NamedTuple):
    """The landmarks of a skeleton."""

    rig: str  # the names of the rigs that it may be of; empty if it is of none
    joints: dict[str, int]  # "left_knee", "head" and so on
    trunk: list[int]  # the joints after the root, or after the joint of the hips, up to the one that carries the arms
    neck: list[int]  # the joints after that up to the head
    reason: str = ""  # why a rig whose names it has was not taken, or is uncertain


NONE = Landmarks("", {}, [], [])


def find_landmarks(skeleton: Skeleton, *, any_proportions: bool = False) -> Landmarks:
    """Find the landmarks of a skeleton by its names; `any_proportions` accepts other proportions than a person's."""
    keys = _keys_of(skeleton.joint_names)
    ends = {}  # by joint the child that has its name and a word for the end, such as "Head_end" after "Head"
    for j, (side, rest) in enumerate(keys):
        parent = int(skeleton.parents[j])
        if parent >= 0 and (side, rest) in [(keys[parent][0], keys[parent][1] + word) for word in END_NAMES]:
            ends[parent] = j
    animal = [name for name, (_, rest) in zip(skeleton.joint_names, keys, strict=True) if rest.startswith(NO_PERSON)]
    candidates = [(rig, *_find(keys, ends, rig, skeleton)) for rig in RIGS]
    most = max(n_known for *_, n_known in candidates)
    if not most:
        return NONE
    found = [(rig, joints) for rig, joints, n_known in candidates if n_known == most]
    proportions = ""
    for rig, joints in found:
        complaint = f"it has a joint {animal[0]!r}, as animals have" if animal else find_misplaced(skeleton, joints)
        proportions = proportions or _find_disproportion(skeleton, joints)
        if complaint or (proportions and not any_proportions):
            return NONE._replace(reason=f"it has names of {rig.name}, but {complaint or proportions}")
    # Several rigs may have the same names: what they agree on is certain.
    joints = {name: j for name, j in found[0][1].items() if all(other.get(name) == j for _, other in found)}
    _add_ends(joints, ends, skeleton)
    trunk, neck = _axis(skeleton, joints)
    hips = pair_of(joints, HIP)
    if hips and (middle := common_parent(skeleton, *hips)) >= 0:
        joints[HIPS] = middle
    names = " or ".join(rig.name for rig, _ in found)
    return Landmarks(names, joints, trunk, neck, f"it has names of {names}, but {proportions}" if proportions else "")


def path_up(skeleton: Skeleton, joint: int) -> list[int]:
    """A joint and all joints above it."""
    path = []
    while joint >= 0:
        path.append(joint)
        joint = int(skeleton.parents[joint])
    return path


def common_parent(skeleton: Skeleton, a: int, b: int) -> int:
    """The last joint that both joints come after; -1 is the root."""
    above = path_up(skeleton, a)[1:]
    return next((joint for joint in path_up(skeleton, b)[1:] if joint in above), -1)


def pair_of(joints: Mapping[str, int], mark: str) -> tuple[int, int] | None:
    """The joints of both sides at a landmark, if both are known."""
    left, right = joints.get(f"left_{mark}"), joints.get(f"right_{mark}")
    return None if left is None or right is None else (left, right)


def plain_names(names: Sequence[str]) -> list[str]:
    """Names without a namespace, and without a prefix or a number that all of them have: "mixamorig:", "Bip01 ",
    ".001".

    A word for a side stays: the names of a left arm differ from a right one's.
    """
    names, start = _without_number(names)
    word = re.sub(r"[^\W_]*$", "", start)
    return names if split_sides([word])[0][0] else [name.removeprefix(word) for name in names]


def _keys_of(names: Sequence[str]) -> list[tuple[str, str]]:
    """The side of each name, and the rest of it in lower case without signs between words.

    A prefix or a number that all names have is left out. It is not a side: the names of a rig have both.
    """
    names, start = _without_number(names)
    sides = split_sides([name.removeprefix(start) for name in names])
    return [(side, SIGNS.sub("", rest).lower()) for side, rest in sides]


def _without_number(names: Sequence[str]) -> tuple[list[str], str]:
    """Names without a namespace, and without a number at the end of all; and the prefix that all have.

    Such numbers are ".001" of Blender's duplicates and "_01". A word for the end of a chain stays: "Head.001_end".
    """
    names = [name.rpartition(":")[2] or name for name in names]
    found = [NUMBERED.fullmatch(name) for name in names]
    if len(found) > 1 and found[0] and len({match and match[2] for match in found}) == 1:
        names = [match[1] + match[3] for match in found if match]
    first, last = min(names, default=""), max(names, default="")
    start = next((i for i in range(len(first)) if first[i] != last[i : i + 1]), len(first))
    return names, first[:start] if len(names) > 1 else ""


def _table_of(rig: Rig) -> dict[tuple[str, str], str]:
    """The landmark of each name of a rig, both sides, or "" for others."""
    left = list(rig.left)
    right = [others(name)[0] for name in left]
    keys = _keys_of([*rig.middle, *left, *right, "z"])[:-1]  # the last, so that nothing is common to all
    marks = [*rig.middle.values(), *(f"left_{mark}" if mark else "" for mark in rig.left.values())]
    marks += [f"right_{mark}" if mark else "" for mark in rig.left.values()]
    return dict(zip(keys, marks, strict=True))


TABLES = {rig.name: _table_of(rig) for rig in RIGS}


def _add_ends(joints: dict[str, int], ends: dict[int, int], skeleton: Skeleton) -> None:
    """Add the ends of hands, head and feet, where no other joint is known to be there.

    A foot without a joint at the ball ends at the toe if it points forward at angle zero, and perhaps at the floor if
    it points down.
    """
    for prefix in ("", "left_", "right_"):
        for mark, end in ENDS.items():
            joint = ends.get(joints.get(prefix + mark, -1), -1)
            if joint >= 0 and prefix + end not in joints:
                joints[prefix + end] = joint
    for side in SIDES:
        toe = ends.get(joints.get(f"{side}_{ANKLE}", -1), -1)
        if (
            toe >= 0
            and not {f"{side}_{BALL}", f"{side}_{TOE}"} & joints.keys()
            and _points_forward(skeleton, toe, joints)
        ):
            joints[f"{side}_{TOE}"] = toe


def _points_forward(skeleton: Skeleton, joint: int, joints: dict[str, int]) -> bool:
    """Whether the bone that ends at a joint points forward at angle zero, by hips and shoulders."""
    hips, shoulders = pair_of(joints, HIP), pair_of(joints, SHOULDER)
    if not (hips and shoulders):
        return False
    where = positions_at_zero(skeleton)
    middles = [where[list(pair)].mean(axis=0) for pair in (shoulders, hips)]
    forward = np.cross(where[hips[0]] - where[hips[1]], middles[0] - middles[1])
    bone = where[joint] - where[int(skeleton.parents[joint])]
    return bool(bone @ forward > FORWARD * np.linalg.norm(bone) * np.linalg.norm(forward))


def _find(
    keys: list[tuple[str, str]], ends: dict[int, int], rig: Rig, skeleton: Skeleton
) -> tuple[dict[str, int], int]:
    """The joints that have names of a rig, by landmark, and the number of names.

    Ends of chains do not count: each file and reader has its own names for them. Legs and arms need all names of both
    sides; a rig needs one of the two.
    """
    if rig.frame not in (None, skeleton.offset_frame):
        return {}, 0
    table = TABLES[rig.name]
    known = {j: table[key] for j, key in enumerate(keys) if key in table and j not in ends.values()}
    joints = {mark: j for j, mark in known.items() if mark}
    if len(joints) < sum(map(bool, known.values())):
        return {}, 0  # two joints at one place: not this rig
    legs, arms = (all(f"{side}_{mark}" in joints for side in SIDES for mark in limb) for limb in LIMBS)
    if not legs and not arms:
        return {}, 0
    if not (legs and arms):
        out = (*ORDER[0], BALL, TOE) if not legs else (*ORDER[1], HAND)
        joints = {name: j for name, j in joints.items() if name.partition("_")[2] not in out}
    return joints, len(known)


def find_misplaced(skeleton: Skeleton, joints: Mapping[str, int]) -> str:
    """State which joints do not follow each other as in a person; empty if all do."""
    names = skeleton.joint_names
    for side in SIDES:
        for order in ORDER:
            here = [joints[f"{side}_{mark}"] for mark in order if f"{side}_{mark}" in joints]
            for above, below in itertools.pairwise(here):
                if above not in path_up(skeleton, below)[1:]:
                    return f"its joint {names[below]!r} does not come after {names[above]!r}"
    if HEAD in joints and any(
        joints.get(f"{side}_{mark}") in path_up(skeleton, joints[HEAD]) for side in SIDES for mark in (SHOULDER, HIP)
    ):
        return f"its joint {names[joints[HEAD]]!r} comes after an arm or a leg"
    return ""


def _find_disproportion(skeleton: Skeleton, joints: dict[str, int]) -> str:
    """State which lengths are not a person's; empty if all are."""
    lengths, norms = {}, np.linalg.norm(skeleton.offsets, axis=1)
    for side in SIDES:
        for part, (start, end) in LENGTHS.items():
            path = path_up(skeleton, joints.get(f"{side}_{end}", -1))
            above = joints.get(f"{side}_{start}", -1)
            if above in path:
                lengths[side, part] = float(norms[path[: path.index(above)]].sum())
        for first, second, low, high in PROPORTIONS:
            a, b = lengths.get((side, first)), lengths.get((side, second))
            if a is not None and b is not None and not low * b <= a <= high * b:
                return f"its {side} {first} is {a:.2g} m long, its {second} {b:.2g} m"
    for part in ("leg", "arm"):
        a, b = (lengths.get((side, part), 0.0) for side in SIDES)
        if max(a, b) > SYMMETRY * min(a, b):
            return f"one {part} is {a:.2g} m long, the other {b:.2g} m"
    return ""


def _axis(skeleton: Skeleton, joints: dict[str, int]) -> tuple[list[int], list[int]]:
    """The joints of the trunk, and of the neck up to the head."""
    hips, shoulders = pair_of(joints, HIP), pair_of(joints, SHOULDER)
    if not shoulders:
        return [], []
    chest = common_parent(skeleton, *shoulders)
    below = path_up(skeleton, common_parent(skeleton, *hips)) if hips else []
    trunk = [joint for joint in reversed(path_up(skeleton, chest)) if joint not in below]
    neck = []
    if HEAD in joints:
        above = path_up(skeleton, joints[HEAD])[1:]
        neck = [joint for joint in reversed(above) if joint not in path_up(skeleton, chest)]
        neck = neck if chest < 0 or chest in above else []
    return trunk, neck
