"""The joints of two differently rigged skeletons that are counterparts of each other.

Where all joints of one skeleton have their names in the other, joints of equal names are counterparts. Otherwise, if
both are people, joints with the same landmark are, and joints of trunk and neck by their place along it.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from skpose._utils.validation import list_names
from skpose._utils.warnings import warn
from skpose.kinematics._anatomy import (
    ANKLE,
    BALL,
    COLLAR,
    ELBOW,
    HEAD,
    HEAD_CENTER,
    HEAD_TOP,
    HIP,
    HIPS,
    KNEE,
    LIMBS,
    SHOULDER,
    SIDES,
    TOE,
    WRIST,
    Anatomy,
    find_anatomy,
    find_misplaced,
    path_up,
    plain_names,
)
from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._sides import sides
from skpose.skeleton._skeleton import Skeleton, check_joints

People = tuple[Anatomy, Anatomy]  # of the source and of the target
Names = tuple[list[str], list[str]]
WHOSE = "the motion's skeleton", "the given skeleton"
ENDS = (KNEE, ANKLE, ELBOW, WRIST)  # of the bones by which people of different rigs are compared in size
SAME_PLACE = {HIP, KNEE, ANKLE, BALL, SHOULDER, ELBOW, WRIST, HEAD}  # in all rigs, within a few centimetres
NEARLY = {f"{side}_{a}": f"{side}_{b}" for side in SIDES for a, b in ((BALL, TOE), (TOE, BALL))}  # in one direction
NEARLY |= {HEAD_TOP: HEAD_CENTER, HEAD_CENTER: HEAD_TOP}
NONE = -1  # the index of no joint
SHARE = 0.25  # of the length of trunk or neck: joints further apart are not counterparts
# A share of the longest path from the root: hands, feet, head and neck of a person are shorter, a forearm with its hand
# is longer.
LIMB = 0.28


class Counterparts(NamedTuple):
    """The counterparts of the joints of a target in a source."""

    there: np.ndarray  # (n_joints,) the index of each joint's counterpart, or -1
    placed: np.ndarray  # (n_joints,) whether both are at one place of a person, and not only in one direction
    measured: np.ndarray  # (n_joints,) whether the bones before a joint count where sizes are compared
    landmarks: People
    people: People | None  # the landmarks that are counterparts, if both skeletons are people
    by_landmarks: bool  # whether they are matched by landmarks, and not by equal names


def find_counterparts(source: Skeleton, target: Skeleton) -> dict[str, str]:
    """Find the joints that `retarget` takes as counterparts, by their names.

    Parameters
    ----------
    source : Skeleton
        The skeleton of a motion.
    target : Skeleton
        The skeleton to retarget to.

    Returns
    -------
    dict of str to str
        Names of joints of `target` to names of joints of `source`, for the parameter `joints` of `retarget`. Joints
        without a counterpart are left out.

    Raises
    ------
    ValueError
        If the skeletons have no name in common and are not both people's; if a skeleton has a person's names, but not a
        person's joints.

    Warns
    -----
    UserWarning
        If a skeleton has the names, but not the proportions of a person: `retarget` needs the counterparts as `joints`.

    See Also
    --------
    retarget : Retarget a motion to another skeleton; its notes state how people are found.

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
    found = counterparts(source, target, None, any_proportions=True)
    for one, other, whose in zip(found.landmarks, found.landmarks[::-1], WHOSE, strict=True):
        if one.reason and other.joints:
            warn(f"the joints of {whose} may not be a person's: {one.reason}. Check them and pass them as joints=")
    return {name: source.joint_names[j] for name, j in zip(target.joint_names, found.there, strict=True) if j >= 0}


def counterparts(
    source: Skeleton, target: Skeleton, joints: Mapping[str, str | None] | None, *, any_proportions: bool = False
) -> Counterparts:
    """The counterparts of the joints of a target: as given, and the others by anatomy or by equal names."""
    any_proportions |= joints is not None
    theirs, ours = (find_anatomy(skeleton, any_proportions=any_proportions) for skeleton in (source, target))
    names = plain_names(source.joint_names), plain_names(target.joint_names)
    given = {} if joints is None else _indices_of(source, target, joints)
    people = _with_given(theirs, ours, given)
    known = _are_known(names, people)
    for skeleton, one, other, whose in zip((source, target), people, people[::-1], WHOSE, strict=True):
        if given and (misplaced := find_misplaced(skeleton, one.joints)):
            raise ValueError(f"joints do not fit {whose}: {misplaced}")
        if one.reason and other.joints and not one.joints:
            raise ValueError(f"the joints of {whose} may not be a person's: {one.reason}. Pass joints=")
    if known:
        there, placed = _match_landmarks(source, target, people, names)
    else:
        there = _match_names(source, target, names, required=not given)
        placed = there >= 0
    there[np.isin(there, [other for other in given.values() if other >= 0])] = NONE
    there[[*given]] = [*given.values()]
    placed[[*given]] = there[[*given]] >= 0
    placed &= there >= 0
    agreeing, measured = _agreeing(people, there), placed
    if known:
        ends = [j for name, j in people[1].joints.items() if name.partition("_")[2] in ENDS]
        measured = np.isin(np.arange(target.n_joints), ends) & (there >= 0)
    _check_order(source, target, there)
    return Counterparts(there, placed, measured, people, agreeing if agreeing[0].joints else None, known)


def _indices_of(source: Skeleton, target: Skeleton, joints: Mapping[str, str | None]) -> dict[int, int]:
    """The counterparts that are given, and -1 for joints that shall have none."""
    check_counterparts(source, target, joints)
    return {
        target.joint_names.index(name): NONE if other is None else source.joint_names.index(other)
        for name, other in joints.items()
    }


def _with_given(theirs: Anatomy, ours: Anatomy, given: Mapping[int, int]) -> People:
    """The landmarks with those that are given by a landmark of the other skeleton."""
    for joint, other in given.items():
        mark = next((mark for mark, j in ours.joints.items() if j == joint), "")
        if mark and other >= 0 and theirs.joints:
            rest = {name: j for name, j in theirs.joints.items() if j != other}
            theirs = theirs._replace(joints=rest | {mark: other})
        elif ours.joints and not mark:
            ours = ours._replace(joints=ours.joints | {n: joint for n, j in theirs.joints.items() if j == other})
    return theirs, ours


def _match_names(source: Skeleton, target: Skeleton, names: Names, *, required: bool) -> np.ndarray:
    """The counterpart (n_joints,) of each joint by equal names."""
    index, plain = ({name: j for j, name in enumerate(some)} for some in (source.joint_names, names[0]))
    pairs = zip(target.joint_names, names[1], strict=True)
    there = np.array([index.get(name, plain.get(short, NONE)) for name, short in pairs], np.intp)
    if required and not (there >= 0).any():
        raise ValueError("the skeletons have no joint names in common, and are not both people: pass joints=")
    if len(np.unique(there[there >= 0])) < (there >= 0).sum():
        raise ValueError("several joints have the same name without prefix: pass joints=")
    return there


def _are_known(names: Names, people: People) -> bool:
    """Whether landmarks are the counterparts of each other: one skeleton lacks names of the other, or means others."""
    theirs, ours = (person.joints for person in people)
    if not (theirs and ours):
        return False
    if not (set(names[0]) <= set(names[1]) or set(names[1]) <= set(names[0])):
        return True
    pairs = [(theirs[mark], ours[mark]) for mark in theirs.keys() & ours.keys()]
    if people[0].trunk and people[1].trunk:
        pairs.append((people[0].trunk[-1], people[1].trunk[-1]))
    return any(names[0][j] != names[1][k] for j, k in pairs)


def _agreeing(people: People, there: np.ndarray) -> People:
    """The landmarks that are counterparts, and collarbones without counterparts."""
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


def check_counterparts(source: Skeleton, target: Skeleton, joints: Mapping[str, str | None]) -> None:
    """Refuse a mapping with unknown names, or with two joints that have one counterpart."""
    if not isinstance(joints, Mapping) or not joints:
        raise ValueError("joints must name at least one joint of the given skeleton and its counterpart")
    others = [name for name in joints.values() if name is not None]
    check_joints(target, joints, "joints")
    check_joints(source, others, "joints.values()")
    if len(set(others)) < len(others):
        raise ValueError("joints must have each counterpart once")


# --- by landmarks -----------------------------------------------------------------------------------------------------


def _match_landmarks(source: Skeleton, target: Skeleton, people: People, names: Names) -> tuple[np.ndarray, np.ndarray]:
    """The counterpart (n_joints,) of each joint of the target, and whether both are at one place of a person."""
    _check_hips(source, target, people)
    there = np.full(target.n_joints, -1, dtype=np.intp)
    placed = np.zeros(target.n_joints, dtype=bool)
    theirs, ours = people[0].joints, people[1].joints
    for name, joint in ours.items():
        if name in theirs:
            there[joint] = theirs[name]
            placed[joint] = name.removeprefix("left_").removeprefix("right_") in SAME_PLACE
    for one, other in NEARLY.items():
        if one in ours and other in theirs and one not in theirs and other not in ours:
            there[ours[one]] = theirs[other]
    if people[0].trunk and people[1].trunk:
        _match_trunk(source, target, people, there)
    _match_equal_names(source, target, people, names, there)
    return there, placed


def _check_hips(source: Skeleton, target: Skeleton, people: People) -> None:
    """Refuse a skeleton whose root is on the ground where the other's is at the hips: roots are counterparts."""
    far = []
    for skeleton, person in zip((source, target), people, strict=True):
        zero = positions_at_zero(skeleton)  # the last is the root
        hips, knee, ankle = (zero[person.joints.get(mark, -1)] for mark in (HIPS, f"left_{KNEE}", f"left_{ANKLE}"))
        far.append(bool(0.0 < np.linalg.norm(ankle - knee) < np.linalg.norm(hips)))
    if far[0] != far[1]:
        i = far.index(True)
        name = (source, target)[i].joint_names[people[i].joints[HIPS]]
        raise ValueError(f"the root of {WHOSE[i]} is far from the hips: read it with load_bvh(..., root={name!r})")


def _match_trunk(source: Skeleton, target: Skeleton, people: People, there: np.ndarray) -> None:
    """Match the joints from which the arms begin, and those below and above them."""
    heads = [[person.joints[HEAD]] if HEAD in person.joints else [] for person in people]
    chains = [[*person.trunk, *person.neck, *head] for person, head in zip(people, heads, strict=True)]
    (theirs, ours), (chest, other) = chains, [len(person.trunk) - 1 for person in people]
    there[ours[other]] = theirs[chest]
    _match_in_order(source, target, theirs[: chest + 1], ours[: other + 1], there)
    if all(heads):
        _match_in_order(source, target, theirs[chest + 1 :], ours[other + 1 :], there)


def _match_in_order(source: Skeleton, target: Skeleton, theirs: list[int], ours: list[int], there: np.ndarray) -> None:
    """Match the joints of two chains before their last ones, which are counterparts, by their share of the length.

    As many as possible are matched, in their order, and of these the nearest.
    """
    pairs = (source, theirs), (target, ours)
    lengths = [np.cumsum(np.linalg.norm(skeleton.offsets[chain], axis=1)) for skeleton, chain in pairs]
    shares = [along / max(along[-1], np.finfo(float).tiny) for along in lengths]
    best: dict[tuple[int, int], tuple[int, float, list[tuple[int, int]]]] = {}
    for i in range(len(theirs)):
        for j in range(len(ours)):
            options = [best.get((i - 1, j), (0, 0.0, [])), best.get((i, j - 1), (0, 0.0, []))]
            if i and j and (apart := abs(shares[0][i - 1] - shares[1][j - 1])) <= SHARE:
                count, sum_of_all, matched = best.get((i - 1, j - 1), (0, 0.0, []))
                options.append((count + 1, sum_of_all + apart, [*matched, (i - 1, j - 1)]))
            best[i, j] = min(options, key=lambda option: (-option[0], option[1]))
    for i, j in best[len(theirs) - 1, len(ours) - 1][2]:
        there[ours[j]] = theirs[i]


def _match_equal_names(source: Skeleton, target: Skeleton, people: People, names: Names, there: np.ndarray) -> None:
    """Match joints of equal names without landmarks, such as fingers, that are attached to counterparts."""
    index = {name: j for j, name in enumerate(names[0])}
    theirs, ours = ({*p.joints.values(), *p.trunk, *p.neck} for p in people)
    for joint, name in enumerate(names[1]):
        other = index.get(name, -1)
        if there[joint] < 0 <= other and joint not in ours and other not in theirs:
            above = [there[j] for j in path_up(target, joint)[1:] if there[j] >= 0]
            matched = [j for j in path_up(source, other)[1:] if j in there]
            if above[:1] == matched[:1]:
                there[joint] = other


# --- checks -----------------------------------------------------------------------------------------------------------


def _check_order(source: Skeleton, target: Skeleton, there: np.ndarray) -> None:
    """Refuse counterparts that are in the opposite order along the tree."""
    for joint in np.flatnonzero(there >= 0).tolist():
        above = _mapped_above(target, there, joint)
        if above >= 0 and there[joint] in path_up(source, there[above]):
            names, others = target.joint_names, source.joint_names
            pairs = f"{names[above]!r}: {others[there[above]]!r} and {names[joint]!r}: {others[there[joint]]!r}"
            raise ValueError(f"counterparts are in opposite orders along the skeletons: {pairs}")


def check_limbs(source: Skeleton, target: Skeleton, found: Counterparts, joints: Mapping[str, Any] | None) -> None:
    """Refuse counterparts that leave an arm or a leg, or as long a part of another skeleton, without any.

    With given joints they are refused only if parts of the source are left over too.
    """
    there, ours = found.there, found.landmarks[1].joints
    if joints is not None:
        back = np.full(source.n_joints, NONE)
        back[there[there >= 0]] = np.flatnonzero(there >= 0)
        if not _long_parts(source, back):
            return
        there = np.where([name in joints for name in target.joint_names], 0, there)
    out: list[int] = []
    for side in SIDES:
        for limb in LIMBS:
            marks = [ours[f"{side}_{mark}"] for mark in limb if f"{side}_{mark}" in ours]
            alone = [joint for joint in marks if there[joint] < 0]
            if len(alone) > 1 or marks[-1:] == alone:  # a knee or an elbow alone may be missing: the limb is straight
                out += alone
    if not all(f"{side}_{mark}" in ours for side in SIDES for limb in LIMBS for mark in limb):
        sided = sides(target.joint_names)  # a person's trunk without arms may rest
        out += [joint for joint in _long_parts(target, there) if sided[joint] or not ours]
    if out:
        names = list_names([target.joint_names[j] for j in dict.fromkeys(out)])
        raise ValueError(f"limbs would stay at rest: {names} have no counterparts. Pass joints={{...}}")


def _long_parts(target: Skeleton, there: np.ndarray) -> list[int]:
    """The joints of those parts of a skeleton without counterparts that are as long as limbs.

    A part ends at the end of a chain, or consists of several joints that move before a chain that does not branch.
    """
    lengths, joints = np.linalg.norm(target.offsets, axis=1), range(target.n_joints)
    leaves = {*joints} - {*target.parents.tolist()}
    longest = max(lengths[path_up(target, leaf)].sum() for leaf in leaves)
    n_leaves = np.bincount([j for leaf in leaves for j in path_up(target, leaf)])  # at each joint and after it
    out: set[int] = set()
    for end in [j for j in joints if j in leaves or (there[j] >= 0 and n_leaves[j] == 1)]:
        path = path_up(target, end)[int(there[end] >= 0) :]
        part = path[: next((i for i, joint in enumerate(path) if there[joint] >= 0), len(path))]
        moving = [joint for joint in part if target.bones[joint].dofs]
        if lengths[part].sum() > LIMB * longest and len(moving) > (there[end] >= 0):
            out.update(part)
    return sorted(out)


# --- sizes ------------------------------------------------------------------------------------------------------------


def ratio_of_lengths(source: Skeleton, target: Skeleton, found: Counterparts) -> float:
    """The ratio of the lengths, summed, of the target's bones and the source's bones between counterparts.

    A bone is between a joint with a counterpart and the next joint toward the root with one, or the root itself.
    """
    lengths = [np.linalg.norm(skeleton.offsets, axis=1) for skeleton in (target, source)]
    sums = np.zeros(2)
    for joint in np.flatnonzero(found.measured).tolist():
        above = _mapped_above(target, found.there, joint)
        path = _bones_between(source, int(found.there[joint]), int(found.there[above]) if above >= 0 else -1)
        if path is not None:
            sums += lengths[0][_bones_between(target, joint, above)].sum(), lengths[1][path].sum()
    if not (sums > 0.0).all():
        raise ValueError('scale="lengths" needs bones between joints with counterparts: pass a number instead')
    return float(sums[0] / sums[1])


def _mapped_above(target: Skeleton, there: np.ndarray, joint: int) -> int:
    """The next joint toward the root that has a counterpart, or -1, the root."""
    return next((above for above in path_up(target, joint)[1:] if there[above] >= 0), -1)


def _bones_between(skeleton: Skeleton, last: int, first: int) -> list[int] | None:
    """The bones from a joint, or the root, -1, to a joint after it; None if it is not after it."""
    path = [*path_up(skeleton, last), -1]
    return path[: path.index(first)] if first in path else None
