"""Where a person is in a skeleton: the joint at each knee, shoulder and so on, whatever the rig calls them.

A person has a pair of equal legs that start near the root, a pair of equal arms higher on the spine, and a head. The
sides come from names. In each limb the three joints are those whose distances are a person's: a thigh is about as long
as a shank, an upper arm as a forearm. So "LeftLeg" may be the thigh in one rig and the shank in another. Words in names
decide where lengths leave a choice. Only lengths of bones count, so any rest pose works.
"""

import itertools
import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np

from skpose.skeleton import Skeleton
from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._sides import OTHER, split_sides

T = TypeVar("T")
SIDES = ("left", "right")
HIP, KNEE, ANKLE, SHOULDER, ELBOW, WRIST = "hip", "knee", "ankle", "shoulder", "elbow", "wrist"
LEG, ARM = LIMBS = ((HIP, KNEE, ANKLE), (SHOULDER, ELBOW, WRIST))
COLLAR = "collar"  # where the collarbone begins
BALL, TOE = "ball", "toe"  # of the foot, where the toes begin, and their end
HAND = "hand"  # a point of the hand that shows its direction from the wrist
HEAD = "head"  # the joint between neck and head
HEAD_TOP, HEAD_CENTER = "head_top", "head_center"
HIPS = "hips"  # the joint that carries both legs, if it is not the root
ORDER = (LEG, (COLLAR, *ARM))  # in this order, as far as known
ENDS_OF = ((ANKLE, BALL), (ANKLE, TOE), (WRIST, HAND))  # likewise; robots have both at one joint

# Parts of the body in names, in lower case and without signs; the first that is found counts.
PARTS = {
    "twist": "twist|roll$|helper|捩",
    TOE: "toe|ball|つま先",
    ANKLE: "ankle|ank$|ajc|足首",
    "foot": "foot|feet",
    "shank": "shin|calf|shank|lowe?r?leg|tibia",
    KNEE: "knee|kne$|kjc|ひざ|膝",
    "thigh": "thigh|upp?e?r?leg|femur",
    "leg": "hip|hjc|leg|足",
    WRIST: "wrist|wjc|手首",
    HAND: "hand|手",
    "forearm": "fo?r?e?arm|lowe?r?arm|radius",
    ELBOW: "elbow|elb$|ejc|ひじ|肘",
    "upper arm": "upp?e?r?arm|uarm|humerus|shldr",
    COLLAR: "collar|clav",
    "arm": "shoulder|arm|肩|腕",
}
OF_LEG = (TOE, ANKLE, "foot", "shank", KNEE, "thigh", "leg")
# Parts in names of the joints of a limb, of each by the convention that bones begin at their joints, or end there;
# those that are in names of several joints; and how much more the name of the joint counts than that of a bone.
BEGINS = (("thigh",), (KNEE, "shank"), (ANKLE, "foot")), (("upper arm",), (ELBOW, "forearm"), (WRIST, HAND))
ENDS = ((), (KNEE, "thigh"), (ANKLE, "shank")), ((), (ELBOW, "upper arm"), (WRIST, "forearm"))
CONVENTIONS = ((BEGINS, ("", "leg", "arm"), 0.0), (ENDS, ("", "leg", "arm", COLLAR), 0.1))
SURE = 2  # joints of a limb whose names state the part
HEADS, TOPS = "head|頭", "end$|nub$|top"
HEEL = "heel|hee$|calc"
FINGERS = ("middle|finger2|fin$|中指", "hand|finger|digit", "index|人指", "end$|nub$")  # in this order
CENTERS = ("spineshoulder", "shouldercenter", "fhd")  # names of layouts whose head is its centre
NO_PERSON = ("tail", "wing", "paw", "hoof")  # the first letters of names that animals have
SIGNS = re.compile(r"[\W_]+")  # between words
NUMBERED = re.compile(r"(.*[^\W_])([\W_]\d+)((?:_?(?:end|nub))?)", re.IGNORECASE)

# Of legs and of arms: the ratio of the first segment to the second, also if names state the parts: arms may end within
# the forearm, and a name at the other end of its bone makes it 0.3 or 3.
TYPICAL, RATIOS = (1.0, 1.15), ((0.75, 1.35), (0.75, 1.6))
NAMED = ((0.6, 1.7), (0.5, 2.6))
# The largest lengths before and after both segments, as shares of their length, and that as a share of all.
BEFORE, AFTER, MOST = (0.5, 0.9), (0.45, 0.9), (0.6, 0.4)
SEGMENTS = (("thigh", "shank"), ("upper arm", "forearm"))
LEG_TO_ARM = (0.9, 3.0)
SYMMETRY = 1.25  # how many times as long as on the other side
FORWARD = 0.5  # cosine of the largest angle between the direction forward and a foot that ends at the toe
LONGEST = 16  # places in a limb, fingers included: a longer chain is hair, or a tail
SMALL = 0.01  # of the longest chain of a skeleton: joints as near are at one place


class Anatomy(NamedTuple):
    """The joints of a skeleton that are a person's."""

    joints: dict[str, int]  # "left_knee", "head" and so on
    trunk: list[int]  # the joints after the root, or after the joint of the hips, up to the one that carries the arms
    neck: list[int]  # the joints after that up to the head
    twists: list[int]  # joints within the segments of the limbs, which rotate them about themselves
    reason: str = ""  # why it is not a person, or what is uncertain


NONE = Anatomy({}, [], [], [])


@lru_cache(maxsize=64)
def find_anatomy(skeleton: Skeleton, *, any_proportions: bool = False) -> Anatomy:
    """Find where a person is in a skeleton; `any_proportions` accepts other proportions than a person's."""
    tree = _Tree(skeleton)
    joints = _find_limbs(tree)
    if not joints:
        return NONE
    names = zip(skeleton.joint_names, tree.keys, strict=True)
    animal = [name for name, (_, rest) in names if rest.startswith(NO_PERSON)]
    odd = f"it has a joint {animal[0]!r}, as animals have" if animal else _find_disproportion(skeleton, joints)
    if odd and not any_proportions:
        return NONE._replace(reason=odd)
    # Joints are points that a camera sees without collarbones, if they are named as joints; then heads do not rotate.
    bends = [joints[f"left_{mark}"] for mark in (KNEE, ELBOW) if f"left_{mark}" in joints]
    named = any(tree.parts[joint] in (KNEE, ELBOW) for joint in bends)
    are_points = tree.is_own and f"left_{COLLAR}" not in joints and named
    for side in SIDES:
        _add_foot(tree, joints, side, are_points)
        _add_hand(tree, joints, side)
    _add_head(tree, joints, are_points)
    trunk, neck = _axis(skeleton, joints)
    hips = pair_of(joints, HIP)
    if hips and (middle := common_parent(skeleton, *hips)) >= 0:
        joints[HIPS] = middle
    segments = [(side, *ends) for limb in LIMBS for ends in itertools.pairwise(limb) for side in SIDES]
    inside = [j for segment in segments for j in _path_between(skeleton, joints, *segment)[1:]]
    twists = sorted({*inside, *(j for j, part in enumerate(tree.parts) if part == "twist")} - {*joints.values()})
    return Anatomy(joints, trunk, neck, twists, odd)


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


def _path_between(skeleton: Skeleton, joints: Mapping[str, int], side: str, start: str, end: str) -> list[int]:
    """The joints up from one landmark of a limb to another, which is left out; none if one is not known."""
    path, first = path_up(skeleton, joints.get(f"{side}_{end}", -1)), joints.get(f"{side}_{start}", -1)
    return path[: path.index(first)] if first in path else []


def pair_of(joints: Mapping[str, T], mark: str) -> tuple[T, T] | None:
    """The joints of both sides at a landmark, or their positions, if both are known."""
    left, right = joints.get(f"left_{mark}"), joints.get(f"right_{mark}")
    return None if left is None or right is None else (left, right)


# --- names ------------------------------------------------------------------------------------------------------------


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


# --- limbs ------------------------------------------------------------------------------------------------------------


class _Tree:
    """A skeleton as a tree of lengths and words."""

    def __init__(self, skeleton: Skeleton):
        self.skeleton, self.is_own, n = skeleton, skeleton.offset_frame == "own", skeleton.n_joints
        self.keys = _keys_of(skeleton.joint_names)
        self.parts = [
            next((part for part, words in PARTS.items() if re.search(words, rest)), "") for _, rest in self.keys
        ]
        index = {key: j for j, key in reversed([*enumerate(self.keys)])}
        self.partners = [index.get((OTHER[side], rest), -1) if side else -1 for side, rest in self.keys]
        self.lengths = np.linalg.norm(skeleton.offsets, axis=1)
        self.children: list[list[int]] = [[] for _ in range(n + 1)]  # the last are the root's, whose index is -1
        self.reach = np.zeros(n + 1)  # the length of the longest chain after each joint
        for j in range(n - 1, -1, -1):
            parent = int(skeleton.parents[j])
            self.children[parent].insert(0, j)
            self.reach[parent] = max(self.reach[parent], self.lengths[j] + self.reach[j])

    def longest(self, joints: Sequence[int]) -> int:
        """The joint, of several with one parent, with which the longest chain begins."""
        return max(joints, key=lambda j: self.lengths[j] + self.reach[j])

    def chain(self, joint: int) -> list[int]:
        """A joint and the longest chain of joints after it that both sides have."""
        found = [joint]
        while below := [j for j in self.children[found[-1]] if self.partners[j] >= 0]:
            found.append(self.longest(below))
        return found

    def is_near(self, length: float) -> bool:
        return length <= SMALL * float(self.reach[-1])

    def after(self, joint: int, without: str) -> list[int]:
        """The first joints after a joint that are at another place, without some names."""
        found = []
        for j in self.children[joint]:
            found += self.after(j, without) if self.is_near(self.lengths[j]) else [j]
        return [j for j in found if not re.search(without, self.keys[j][1])]


def _find_limbs(tree: _Tree) -> dict[str, int]:
    """The joints of both legs and both arms, as far as they are found."""
    starts = []  # at which a pair of limbs may begin: the votes for legs, the distance from the root, the joint
    for left, (side, _) in enumerate(tree.keys):
        parent = int(tree.skeleton.parents[left])
        if side == "left" and tree.partners[left] >= 0 and (parent < 0 or not tree.keys[parent][0]):
            parts = [tree.parts[j] for j in tree.chain(left) if tree.parts[j] not in ("", "twist")]
            depth = float(tree.lengths[path_up(tree.skeleton, parent)].sum())
            starts.append((sum(1 if part in OF_LEG else -1 for part in parts), depth, left))
    joints: dict[str, int] = {}
    above = -1.0  # the distance from the root at which the legs begin
    for limb, sign in (0, 1), (1, -1):  # by words; otherwise legs begin near the root, and arms next to them
        found = []
        for votes, depth, start in starts:
            chain, is_usual = _split_limb(tree, tree.chain(start), limb)
            if chain and sign * votes >= 0 and chain[0] not in joints.values():
                order = votes != 0, is_usual, depth > above, -depth * (votes == 0), tree.reach[start]
                found.append((order, chain, depth))
        if found:
            _, chain, above = max(found)
            for mark, joint in zip((*LIMBS[limb], COLLAR), chain, strict=False):
                joints |= {f"left_{mark}": joint, f"right_{mark}": tree.partners[joint]}
    return joints


def _split_limb(tree: _Tree, chain: list[int], limb: int) -> tuple[list[int], bool]:
    """The three joints of a limb in a chain, after them the collarbone's, and whether lengths are usual."""
    along = np.cumsum(tree.lengths[chain]) - tree.lengths[chain[0]]
    places: list[list[int]] = []  # joints at one place
    parts: list[list[str]] = []  # in their names, each part where it is first
    at: list[float] = []
    for i, joint in enumerate(chain):
        if not i or not tree.is_near(along[i] - at[-1]):
            places, parts, at = [*places, []], [*parts, []], [*at, float(along[i])]
        places[-1].append(joint)
        parts[-1].append("" if any(tree.parts[joint] in before for before in parts) else tree.parts[joint])
    best: tuple[tuple[bool, float, float], list[int]] = ((False, 0.0, 0.0), [])
    for three in itertools.combinations(range(min(len(places), LONGEST)), 3):
        if tree.is_own and not tree.skeleton.bones[places[three[2]][0]].dofs:
            continue  # a marker on the segment before
        start, middle, end = (at[i] for i in three)
        ratio, whole = (middle - start) / (end - middle), end - start
        for names, vague, more in CONVENTIONS[tree.is_own :]:
            agree = 0.0
            for i, ours, mark in zip(three, names[limb], LIMBS[limb], strict=True):
                here = {*parts[i]}
                agree += 1.0 + more * (mark in here) if here & {*ours} else -1.0 if not here & {*vague} else 0.0
            low, high = (NAMED if agree >= SURE else RATIOS)[limb]
            is_usual = bool(low <= ratio <= high)
            is_most = max(start / BEFORE[limb], (at[-1] - end) / AFTER[limb]) <= whole and whole >= MOST[limb] * at[-1]
            order = is_usual, agree, -abs(float(np.log(ratio / TYPICAL[limb])))
            if (agree >= SURE or (is_usual and is_most)) and (not best[1] or order > best[0]):
                joints = [
                    next((j for j in places[i] if tree.parts[j] in ours), places[i][0])
                    for i, ours in zip(three, names[limb], strict=True)
                ]
                best = order, joints + places[three[0] - 1][-1:] * (limb == 1 and three[0] > 0)
    return best[1], best[0][0]


# --- ends -------------------------------------------------------------------------------------------------------------


def _add_foot(tree: _Tree, joints: dict[str, int], side: str, are_points: bool) -> None:
    """Add ball and toe. An End Site at the ankle is the toe if it points forward; it may be at the floor."""
    ahead = tree.after(joints[f"{side}_{ANKLE}"], HEEL) if f"{side}_{ANKLE}" in joints else []
    if not ahead:
        return
    first = tree.longest(ahead)
    if are_points:
        joints[f"{side}_{TOE}"] = first
    elif second := tree.after(first, HEEL):
        joints |= {f"{side}_{BALL}": first, f"{side}_{TOE}": tree.longest(second)}
    elif tree.is_own or tree.skeleton.bones[first].dofs:
        joints[f"{side}_{BALL}"] = first
    elif _points_forward(tree.skeleton, first, joints):
        joints[f"{side}_{TOE}"] = first


def _add_hand(tree: _Tree, joints: dict[str, int], side: str) -> None:
    """Add the hand: the middle finger, if there are fingers."""
    ahead = tree.after(joints[f"{side}_{WRIST}"], "thumb") if f"{side}_{WRIST}" in joints else []
    ahead = [j for j in ahead if not tree.is_own or tree.skeleton.bones[j].dofs]
    for words in FINGERS if ahead else ():
        if found := [j for j in ahead if re.search(words, tree.keys[j][1])]:
            joints[f"{side}_{HAND}"] = tree.longest(found)
            return


def _add_head(tree: _Tree, joints: dict[str, int], are_points: bool) -> None:
    """Add the joint between neck and head, and the top or the centre of the head."""
    middle = ["" if side else rest for side, rest in tree.keys]
    head = next((j for j, rest in enumerate(middle) if re.search(HEADS, rest) and not re.search(TOPS, rest)), -1)
    if head < 0:
        return
    parent = int(tree.skeleton.parents[head])
    if are_points:
        joints[HEAD_CENTER if any(rest.startswith(CENTERS) for _, rest in tree.keys) else HEAD_TOP] = head
    elif tree.is_own and KNEE not in tree.parts:
        joints |= {HEAD_TOP: head} | ({HEAD: parent} if parent >= 0 else {})
    else:
        joints[HEAD] = head
        above = [j for j in tree.after(head, "^$") if middle[j]]
        for top in [j for j in above if re.search(TOPS, middle[j])][:1] or above * (len(above) == 1):
            joints[HEAD_TOP] = top


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


# --- checks -----------------------------------------------------------------------------------------------------------


def find_misplaced(skeleton: Skeleton, joints: Mapping[str, int], more: Sequence[tuple[str, str]] = ()) -> str:
    """State which joints do not follow each other as in a person, by more pairs than `ORDER`; empty if all do."""
    names, above = skeleton.joint_names, {mark: path_up(skeleton, joint)[1:] for mark, joint in joints.items()}
    for side, order in itertools.product(SIDES, (*ORDER, *more)):
        for upper, lower in itertools.pairwise(mark for part in order if (mark := f"{side}_{part}") in joints):
            if joints[upper] not in above[lower]:
                return f"its joint {names[joints[lower]]!r} does not come after {names[joints[upper]]!r}"
    firsts = {f"{side}_{mark}" for side in SIDES for mark in (SHOULDER, HIP)}.intersection(joints)
    for mark in sorted(firsts | {HEAD, HEAD_TOP, HEAD_CENTER}.intersection(joints)):
        if any(joints[first] in above[mark] for first in firsts - {mark}):
            return f"its joint {names[joints[mark]]!r} comes after an arm or a leg"
    return ""


def length_of(skeleton: Skeleton, joints: Mapping[str, int], side: str, start: str, end: str) -> float:
    """The length of the bones between two landmarks of a limb, m; 0 if one is not known."""
    path = _path_between(skeleton, joints, side, start, end)
    return float(np.linalg.norm(skeleton.offsets[path], axis=1).sum())


def _find_disproportion(skeleton: Skeleton, joints: dict[str, int]) -> str:
    """State which lengths are not a person's; empty if all are."""
    wholes = []
    for limb, (low, high), names in zip(LIMBS, NAMED, SEGMENTS, strict=True):
        sides = [[length_of(skeleton, joints, side, *ends) for ends in itertools.pairwise(limb)] for side in SIDES]
        for side, (a, b) in zip(SIDES, sides, strict=True):
            if not low * b <= a <= high * b:
                return f"its {side} {names[0]} is {a:.2g} m long, its {names[1]} {b:.2g} m"
        wholes.append([sum(lengths) for lengths in sides])
        if max(wholes[-1]) > SYMMETRY * min(wholes[-1]):
            return f"its {names[0]} and {names[1]} are {wholes[-1][0]:.2g} and {wholes[-1][1]:.2g} m long"
    (leg, _), (arm, _) = wholes
    if leg and arm and not LEG_TO_ARM[0] * arm <= leg <= LEG_TO_ARM[1] * arm:
        return f"its legs are {leg:.2g} m long, its arms {arm:.2g} m"
    return ""


def _axis(skeleton: Skeleton, joints: dict[str, int]) -> tuple[list[int], list[int]]:
    """The joints of the trunk, and of the neck up to the head."""
    hips, shoulders = pair_of(joints, HIP), pair_of(joints, SHOULDER)
    if not shoulders:
        return [], []
    chest = common_parent(skeleton, *shoulders)
    below = path_up(skeleton, common_parent(skeleton, *hips)) if hips else []
    trunk = [joint for joint in reversed(path_up(skeleton, chest)) if joint not in below]
    above = path_up(skeleton, joints.get(HEAD, -1))[1:]
    neck = [joint for joint in reversed(above) if joint not in path_up(skeleton, chest)]
    return trunk, neck if chest < 0 or chest in above else []


# --- places -----------------------------------------------------------------------------------------------------------
# Labels of joints in tables and plots, by their place on a person: "left knee (lfemur)".


WORDS = {BALL: "ball of foot", COLLAR: "collarbone", HEAD_CENTER: "head center"}


def joint_places(skeleton: Skeleton) -> list[str]:
    """The place of each joint, followed by its name in brackets if that differs."""
    return _labels(skeleton, _places(skeleton, find_anatomy(skeleton)))


def rotation_places(skeleton: Skeleton) -> list[str]:
    """The place of the centre of rotation of each joint: its parent's if offsets are in its own frame.

    Joints next to a limb, such as the thumb, whose parent is at the wrist, keep their names.
    """
    places = _places(skeleton, find_anatomy(skeleton))
    if skeleton.offset_frame == "own":
        parents = skeleton.parents.tolist()
        continues = [place != "" or parents.count(parent) == 1 for place, parent in zip(places, parents, strict=True)]
        before = [places[parent] if parent >= 0 and places[parent] != HIPS else "" for parent in parents]
        places = [place if is_limb else "" for place, is_limb in zip(before, continues, strict=True)]
    return _labels(skeleton, places)


def _places(skeleton: Skeleton, person: Anatomy) -> list[str]:
    """The landmark of each joint as text; "" if it is not one."""
    places = [""] * skeleton.n_joints
    for mark, joint in person.joints.items():
        side, part = mark.split("_", 1) if mark.startswith(("left_", "right_")) else ("", mark)
        places[joint] = f"{side} {WORDS.get(part, part.replace('_', ' '))}".strip()
    return places


def describe_joints(skeleton: Skeleton) -> tuple[list[str], str]:
    """What each joint is on a person, or "", and why the skeleton is not a person, or uncertain."""
    person = find_anatomy(skeleton, any_proportions=True)
    places = _places(skeleton, person)
    for name, joints in (("spine", person.trunk), ("neck", person.neck), ("twist", person.twists)):
        for joint in joints:
            places[joint] = places[joint] or name
    return places, person.reason


def _labels(skeleton: Skeleton, places: list[str]) -> list[str]:
    return [
        name if not place or _letters(name) == _letters(place) else f"{place} ({name})"
        for name, place in zip(skeleton.joint_names, places, strict=True)
    ]


def _letters(name: str) -> str:
    return re.sub(r"[\W_]", "", name).lower()
