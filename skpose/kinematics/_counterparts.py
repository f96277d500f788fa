"""The joints of two differently rigged skeletons that are counterparts of each other."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from skpose._validation.names import near_names
from skpose._validation.skeletons import check_skeleton
from skpose._warnings import warn
from skpose.kinematics._landmarks import SIDES, Landmarks, find_landmarks, path_up, plain_names
from skpose.kinematics._lengths import find_bones, find_mapped_above
from skpose.kinematics._matching import match_landmarks
from skpose.kinematics._rigs import ANKLE, COLLAR, ELBOW, KNEE, LIMBS, SHOULDER, WRIST
from skpose.skeleton import Skeleton

People = tuple[Landmarks, Landmarks]  # of the source and of the target
ENDS = (KNEE, ANKLE, ELBOW, WRIST)  # of the bones by which people of different rigs are compared in size
SHOWN = 4  # names in a message
# A share of the longest path from the root: hands, feet, head and neck of a person are shorter, a forearm with its hand
# is longer.
LIMB = 0.28
HINT = "; joints that it leaves out stay at rest. skpose.kinematics.find_counterparts returns those found by names"


class Counterparts(NamedTuple):
    """The counterparts of the joints of a target in a source."""

    there: np.ndarray  # (n_joints,) the index of each joint's counterpart, -1 where it has none
    placed: np.ndarray  # (n_joints,) whether both are at one place of a person, and not only in one direction
    measured: np.ndarray  # (n_joints,) whether the bones before a joint count where sizes are compared
    people: People | None  # the landmarks of source and target, if both are of known rigs

    def in_words(self, by_place: bool = False) -> str:
        """Return in words how many joints have counterparts."""
        return f"{int((self.placed if by_place else self.there >= 0).sum())} of {len(self.there)} joints"


def find_counterparts(source: Skeleton, target: Skeleton) -> dict[str, str]:
    """Return which joint of one skeleton `retarget` takes as the counterpart of each joint of another, by their names.

    It can be changed and passed to `retarget` and to `MotionDataset.retarget` as ``joints=``.

    Parameters
    ----------
    source : Skeleton
        The skeleton of a motion.
    target : Skeleton
        The skeleton that its poses shall have.

    Returns
    -------
    dict of str to str
        Names of joints of `target`, in its order, to names of joints of `source`. Joints without a counterpart are
        left out. The two roots are counterparts always.

    Raises
    ------
    ValueError
        If the skeletons have no name in common and are not both of known rigs, or if an arm or a leg has no
        counterpart. For a skeleton that has the names of a person and is none: a joint of an animal, or joints that do
        not follow each other as in a person.

    Warns
    -----
    UserWarning
        If a skeleton has names, but not the proportions of a person: `retarget` refuses the counterparts unless they
        are passed.

    See Also
    --------
    retarget : Return the poses of a motion on another skeleton.

    Notes
    -----
    Where all joints of one skeleton have their names in the other, joints of equal names are counterparts.
    Otherwise, if both are people of known rigs, those that are at the same place of a person. Known are the names
    of CMU and HDM05 (as ASF and as BVH), Bandai-Namco, LAFAN1, Mixamo, SMPL, Rokoko, Xsens, Unreal, 3ds Max's
    Biped, AnimatedDrawings, of `skpose.keypoints.layouts` and of `skpose.datasets.humanoid`: with any prefix that
    all names of a skeleton have, such as "mixamorig:" and "Bip01 ", or a number that all end with, such as ".001",
    any spelling of left and right, and in any case.

    Names alone do not suffice: "LeftShoulder" is the shoulder in one rig and the beginning of the collarbone in
    another. A skeleton is of a rig if all names of both legs or of both arms are the rig's, if these joints follow
    each other as in a person, and have a person's proportions at angle zero; one with a tail is none. Joints
    between the hips and the chest, and in the neck, of which rigs have any number, are counterparts in their order,
    where they are at nearly the same share of the length. Joints of equal names that are attached to counterparts,
    such as fingers, are counterparts.

    The ends of hands, feet and the head are joints of the rig, or those with the name of the last joint and a word for
    the end, as the End Sites of a file have, "LeftHand_end". A foot without a joint at its ball ends at the toe if it
    points forward at angle zero.

    If one of the skeletons is of no known rig, joints of equal names are counterparts, and no others.

    Examples
    --------
    >>> from skpose import Bone, Skeleton
    >>> from skpose.datasets import humanoid
    >>> from skpose.kinematics import find_counterparts
    >>> chain = {"UpLeg": None, "Leg": "UpLeg", "Foot": "Leg"}
    >>> mixamo = Skeleton(
    ...     Bone(f"mixamorig:{side}{name}", above and f"mixamorig:{side}{above}", (0, -0.4, 0), "xyz")
    ...     for side in ("Left", "Right")
    ...     for name, above in chain.items()
    ... )
    >>> find_counterparts(mixamo, humanoid().select(["left_shank", "right_shank"]))["left_thigh"]
    'mixamorig:LeftLeg'
    """
    check_skeleton(source)
    check_skeleton(target)
    people = _people(source, target, any_proportions=True)
    _check_people(people)
    there = _found_by_names(source, target, people).there
    for person, whose in _find_uncertain(people):
        warn(
            f"the counterparts rest on names of {whose} that may mean other joints than a person's: {person.reason}. "
            "Check them: retarget takes them as joints=, and refuses them otherwise"
        )
    return {name: source.joint_names[j] for name, j in zip(target.joint_names, there, strict=True) if j >= 0}


def counterparts(source: Skeleton, target: Skeleton, joints: Mapping[str, str] | None) -> Counterparts:
    """Return the counterparts of the joints of a target: the given ones, or those that follow from the names."""
    people = _people(source, target, any_proportions=joints is not None)
    if joints is None:
        _check_people(people)
        return _found_by_names(source, target, people)
    there = _by_names(source, target, joints, people)
    _check_order(source, target, there)
    agreed = _agreeing(people, there) if _are_known(source, target, people) else None
    return Counterparts(there, there >= 0, there >= 0, agreed)


def _people(source: Skeleton, target: Skeleton, *, any_proportions: bool) -> People:
    """Return the landmarks of both skeletons."""
    theirs, ours = (find_landmarks(skeleton, any_proportions=any_proportions) for skeleton in (source, target))
    return theirs, ours


def _are_known(source: Skeleton, target: Skeleton, people: People) -> bool:
    """Return whether landmarks are the counterparts of each other, and not equal names."""
    return bool(people[0].joints and people[1].joints) and not _have_equal_names(source, target, people)


def _found_by_names(source: Skeleton, target: Skeleton, people: People) -> Counterparts:
    """Return the counterparts that follow from the names."""
    if known := _are_known(source, target, people):
        there, placed = match_landmarks(source, target, people)
        ends = [j for name, j in people[1].joints.items() if name.partition("_")[2] in ENDS]
        measured = np.isin(np.arange(target.n_joints), ends) & (there >= 0)
    else:
        there = _by_names(source, target, None, people)
        placed = measured = there >= 0
    _check_order(source, target, there)
    _check_limbs(source, target, there, people)
    return Counterparts(there, placed, measured, people if known else None)


def _agreeing(people: People, there: np.ndarray) -> People:
    """Return the landmarks that given counterparts agree with, and those of collarbones that have none."""
    theirs, ours = (person.joints for person in people)
    same = {name for name, joint in ours.items() if there[joint] >= 0 and there[joint] == theirs.get(name)}
    alone = {
        f"{side}_{COLLAR}"
        for side in SIDES
        if f"{side}_{SHOULDER}" in same
        and f"{side}_{COLLAR}" not in theirs
        and there[ours.get(f"{side}_{COLLAR}", 0)] < 0
    }
    return (
        people[0]._replace(joints={name: j for name, j in theirs.items() if name in same}),
        people[1]._replace(joints={name: j for name, j in ours.items() if name in same | alone}),
    )


def _have_equal_names(source: Skeleton, target: Skeleton, people: People) -> bool:
    """Return whether one skeleton has all names of the other, and equal names are at one place, if that is known."""
    names = [plain_names(skeleton.joint_names) for skeleton in (source, target)]
    if not (set(names[0]) <= set(names[1]) or set(names[1]) <= set(names[0])):
        return False
    theirs, ours = (person.joints for person in people)
    pairs = [(theirs[mark], ours[mark]) for mark in theirs.keys() & ours.keys()]
    if people[0].trunk and people[1].trunk:
        pairs.append((people[0].trunk[-1], people[1].trunk[-1]))
    return all(names[0][j] == names[1][k] for j, k in pairs)


def _by_names(source: Skeleton, target: Skeleton, joints: Mapping[str, str] | None, people: People) -> np.ndarray:
    """Return the index (n_joints,) of the counterpart of each joint of the target by a mapping, or by equal names."""
    if joints is None:
        plain = dict(zip(plain_names(source.joint_names), source.joint_names, strict=True))
        pairs = zip(target.joint_names, plain_names(target.joint_names), strict=True)
        joints = {
            name: name if name in source else plain[short] for name, short in pairs if name in source or short in plain
        }
        if not joints:
            raise ValueError(
                "the motion's skeleton and the given one have no name of a joint in common: pass joints=, a mapping of "
                f"joints of the given skeleton ({_list_some(target.joint_names)}) to the motion's "
                f"({_list_some(source.joint_names)}){_list_rigs(people)}"
            )
    check_joints(source, target, joints)
    index = {name: i for i, name in enumerate(source.joint_names)}
    return np.array([index[joints[name]] if name in joints else -1 for name in target.joint_names], dtype=np.intp)


def _find_uncertain(people: People) -> list[tuple[Landmarks, str]]:
    """Return the landmarks that may not be those of a person, where the other skeleton is one, and whose they are."""
    named = zip(people, people[::-1], ("the motion's skeleton", "the given skeleton"), strict=True)
    return [(one, whose) for one, other, whose in named if one.reason and other.joints]


def _check_people(people: People) -> None:
    """Refuse a person and a skeleton that has the names of one and is none, by its names or its proportions."""
    for person, whose in _find_uncertain(people):
        if person.joints:
            continue
        rig = next(other.rig for other in people if other.joints)
        raise ValueError(
            f"the names of {whose} may mean other joints than those of a person of {rig}: {person.reason}. Pass "
            "joints=, a mapping of joints of the given skeleton to the motion's, if they are counterparts; "
            "skpose.kinematics.find_counterparts returns those found by names, where only proportions differ"
        )


def _check_limbs(source: Skeleton, target: Skeleton, there: np.ndarray, people: People) -> None:
    """Refuse counterparts that leave an arm or a leg, or as long a part of another skeleton, without any."""
    ours = people[1].joints
    out: dict[int, None] = {}  # in their order
    for side in SIDES:
        for limb in LIMBS:
            joints = [ours[f"{side}_{mark}"] for mark in limb if f"{side}_{mark}" in ours]
            alone = [joint for joint in joints if there[joint] < 0]
            if len(alone) > 1 or joints[-1:] == alone:  # a knee or an elbow alone may be missing: the limb is straight
                out.update(dict.fromkeys(alone))
    if not all(f"{side}_{mark}" in ours for side in SIDES for limb in LIMBS for mark in limb):
        out.update(dict.fromkeys(_long_parts(target, there)))
    if out:
        found = int((there >= 0).sum())
        free = [name for j, name in enumerate(source.joint_names) if j not in there]
        raise ValueError(
            f"only {found} of {target.n_joints} joints of the given skeleton have counterparts in the motion's, and "
            f"limbs would stay at rest: {_list_some([target.joint_names[j] for j in out], 8)} have none"
            f"{_list_rigs(people)}. Pass joints=, a mapping of joints of the given skeleton to the motion's, of which "
            f"{_list_some(free, 8)} are free{HINT}"
        )


def _long_parts(target: Skeleton, there: np.ndarray) -> list[int]:
    """Return the joints of those parts of a skeleton without counterparts that are as long as limbs.

    A part ends at the end of a chain, or is of several joints that move before a chain that does not branch.
    """
    lengths = np.linalg.norm(target.offsets, axis=1)
    from_root = np.array([lengths[path_up(target, j)].sum() for j in range(target.n_joints)])
    children = [np.flatnonzero(target.parents == j) for j in range(target.n_joints)]
    branches = np.array([len(below) > 1 for below in children])
    for j in reversed(range(target.n_joints)):
        branches[j] |= any(branches[child] for child in children[j])
    out: set[int] = set()
    for end in range(target.n_joints):
        if len(children[end]) and (there[end] < 0 or branches[end]):
            continue  # neither the end of a chain nor a joint with a counterpart that no branch follows
        path = path_up(target, end)
        if there[end] >= 0:
            path = path[1:]
        part = []
        for joint in path:
            if there[joint] >= 0:
                break
            part.append(joint)
        moving = [joint for joint in part if target.bones[joint].dofs]
        if lengths[part].sum() > LIMB * from_root.max() and len(moving) > (there[end] >= 0):
            out.update(part)
    return sorted(out)


def _list_rigs(people: People) -> str:
    """Return in words of which rigs two skeletons are."""
    words = []
    for person, whose in zip(people, ("the motion's skeleton", "the given one"), strict=True):
        if person.rig:
            words.append(f"{whose} has names of {person.rig}")
        else:
            words.append(f"{whose} has names of no rig that is known")
    return "; " + ", ".join(words)


def check_joints(source: Skeleton, target: Skeleton, joints: Any) -> None:
    """Refuse a mapping with unknown names, or with two joints that have one counterpart."""
    if not isinstance(joints, Mapping):
        raise TypeError(
            "joints must be a mapping of the given skeleton's joints to those of the motion's, such as "
            f'{{"left_knee": "LeftLeg"}}, got {type(joints).__name__}'
        )
    if not joints:
        raise ValueError("joints has no counterparts: name at least one joint, or pass None to match equal names")
    first: dict[str, str] = {}
    for name, counterpart in joints.items():
        for joint, skeleton, whose in ((name, target, "the given skeleton"), (counterpart, source, "the motion's")):
            if joint not in skeleton:
                near = near_names(skeleton.joint_names, joint) if isinstance(joint, str) else "names are strings"
                swapped = counterpart in target and name in source
                hint = "; its keys are joints of the given skeleton, its values those of the motion's" * swapped
                raise ValueError(f"joints maps {name!r} to {counterpart!r}, but {whose} has no {joint!r}: {near}{hint}")
        if counterpart in first:
            raise ValueError(
                f"joints maps {first[counterpart]!r} and {name!r} to one joint, {counterpart!r}: a joint is the "
                "counterpart of one only; leave out the other"
            )
        first[counterpart] = name


def _check_order(source: Skeleton, target: Skeleton, there: np.ndarray) -> None:
    """Refuse counterparts that are in the opposite order along the tree."""
    for joint in np.flatnonzero(there >= 0):
        above = find_mapped_above(target, there, int(joint))
        if above >= 0 and find_bones(source, int(there[above]), int(there[joint])) is not None:
            names = target.joint_names[joint], target.joint_names[above]
            others = source.joint_names[there[joint]], source.joint_names[there[above]]
            raise ValueError(
                f"joints maps {names[0]!r} to {others[0]!r} and {names[1]!r} to {others[1]!r}, but {names[0]!r} comes "
                f"after {names[1]!r} and {others[0]!r} before {others[1]!r}: exchange the two"
            )


def _list_some(names: Sequence[str], n: int = SHOWN) -> str:
    return ", ".join(map(repr, names[:n])) + ", …" * (len(names) > n)
