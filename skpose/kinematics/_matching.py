"""Counterparts of joints by the landmarks of two people, and the joints between landmarks by their order."""

import numpy as np

from skpose.kinematics._landmarks import HIPS, Landmarks, path_up, plain_names
from skpose.kinematics._lines import base_of_neck
from skpose.kinematics._rigs import ANKLE, BALL, ELBOW, HEAD, HEAD_CENTER, HEAD_TOP, HIP, KNEE, SHOULDER, TOE, WRIST
from skpose.skeleton import Skeleton

SAME_PLACE = {HIP, KNEE, ANKLE, BALL, SHOULDER, ELBOW, WRIST, HEAD}  # in all rigs, but for a few centimetres
NEARLY = ((BALL, TOE), (TOE, BALL), (HEAD_TOP, HEAD_CENTER), (HEAD_CENTER, HEAD_TOP))  # in one direction
SHARE = 0.25  # of the length of trunk or neck: joints further apart are no counterparts


def match_landmarks(
    source: Skeleton, target: Skeleton, people: tuple[Landmarks, Landmarks]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the index (n_joints,) of the counterpart of each joint of the target, -1 where it has none.

    The second array (n_joints,) states which pairs are at one place of a person.
    """
    _check_hips(source, target, people)
    there = np.full(target.n_joints, -1, dtype=np.intp)
    placed = np.zeros(target.n_joints, dtype=bool)
    theirs, ours = people[0].joints, people[1].joints
    for name, joint in ours.items():
        if name in theirs:
            there[joint] = theirs[name]
            placed[joint] = name.removeprefix("left_").removeprefix("right_") in SAME_PLACE
    for one, other in NEARLY:
        for prefix in ("left_", "right_") if one in (BALL, TOE) else ("",):
            joint, near = ours.get(prefix + one, -1), theirs.get(prefix + other, -1)
            if joint >= 0 and near >= 0 and prefix + one not in theirs and prefix + other not in ours:
                there[joint] = near
    _match_trunk(source, target, people, there)
    _match_equal_names(source, target, people, there)
    return there, placed


def _check_hips(source: Skeleton, target: Skeleton, people: tuple[Landmarks, Landmarks]) -> None:
    """Refuse a skeleton whose root is on the ground where the other's is at the hips: roots are counterparts."""
    far = []
    for skeleton, person in zip((source, target), people, strict=True):
        joints = person.joints
        shank = path_up(skeleton, joints.get(f"left_{ANKLE}", -1))
        shank = shank[: shank.index(joints[f"left_{KNEE}"])] if shank else []
        height = np.linalg.norm(skeleton.offsets[path_up(skeleton, joints.get(HIPS, -1))], axis=1).sum()
        far.append(bool(shank) and height > np.linalg.norm(skeleton.offsets[shank], axis=1).sum())
    for skeleton, person, is_far, whose in zip(
        (source, target), people, far, ("the motion's skeleton", "the given one"), strict=True
    ):
        if is_far and not all(far):
            name = skeleton.joint_names[person.joints[HIPS]]
            raise ValueError(
                f"the root of {whose} is far from its hips, the joint {name!r}, and that of the other one is at the "
                f"hips, so that the roots are no counterparts: read it with the hips as the root, load_bvh(..., "
                f"root={name!r})"
            )


def _match_trunk(source: Skeleton, target: Skeleton, people: tuple[Landmarks, Landmarks], there: np.ndarray) -> None:
    """Match the joints from which the arms begin, and those below and above them.

    Where a neck begins within the chest, as in files whose neck is one joint with a bone before it, and in the other
    skeleton arms and neck begin at one joint, this one is the counterpart of the nearer of the two.
    """
    if not (people[0].trunk and people[1].trunk):
        return
    chains = [
        [*person.trunk, *person.neck, *([person.joints[HEAD]] if HEAD in person.joints else [])] for person in people
    ]
    chests = [len(person.trunk) - 1 for person in people]
    if HEAD in people[0].joints and HEAD in people[1].joints:
        bases = [base_of_neck(skeleton, person) for skeleton, person in zip((source, target), people, strict=True)]
        shares = [_shares(skeleton, chain) for skeleton, chain in zip((source, target), chains, strict=True)]
        for i, j in ((0, 1), (1, 0)):
            if bases[i] >= 0 and bases[j] < 0:
                base = chains[i].index(bases[i])
                place = shares[j][chests[j]]
                chests[i] = base if abs(shares[i][base] - place) < abs(shares[i][chests[i]] - place) else chests[i]
    there[chains[1][chests[1]]] = chains[0][chests[0]]
    below = [chain[: chest + 1] for chain, chest in zip(chains, chests, strict=True)]
    _match_in_order(source, target, below[0], below[1], there)
    if HEAD in people[0].joints and HEAD in people[1].joints:
        above = [chain[chest + 1 :] for chain, chest in zip(chains, chests, strict=True)]
        _match_in_order(source, target, above[0], above[1], there)


def _match_in_order(source: Skeleton, target: Skeleton, theirs: list[int], ours: list[int], there: np.ndarray) -> None:
    """Match the joints of two chains before their last ones, which are counterparts, by their share of the length.

    As many as possible are matched, in their order, and of these the nearest.
    """
    shares = [_shares(skeleton, chain) for skeleton, chain in ((source, theirs), (target, ours))]
    best: dict[tuple[int, int], tuple[int, float, list[tuple[int, int]]]] = {}
    for i in range(len(theirs)):
        for j in range(len(ours)):
            options = [best.get((i - 1, j), (0, 0.0, [])), best.get((i, j - 1), (0, 0.0, []))]
            if i and j and (apart := abs(shares[0][i - 1] - shares[1][j - 1])) <= SHARE:
                count, sum_of_all, pairs = best.get((i - 1, j - 1), (0, 0.0, []))
                options.append((count + 1, sum_of_all + apart, [*pairs, (i - 1, j - 1)]))
            best[i, j] = min(options, key=lambda option: (-option[0], option[1]))
    for i, j in best[len(theirs) - 1, len(ours) - 1][2]:
        there[ours[j]] = theirs[i]


def _shares(skeleton: Skeleton, chain: list[int]) -> np.ndarray:
    """Return the share of the length of a chain at which each of its joints is."""
    lengths = np.cumsum(np.linalg.norm(skeleton.offsets[chain], axis=1))
    return lengths / max(lengths[-1], np.finfo(float).tiny)


def _match_equal_names(
    source: Skeleton, target: Skeleton, people: tuple[Landmarks, Landmarks], there: np.ndarray
) -> None:
    """Match joints of equal names that are no landmarks, such as fingers, where they are attached to counterparts."""
    index = {name: j for j, name in enumerate(plain_names(source.joint_names))}
    theirs, ours = ({*p.joints.values(), *p.trunk, *p.neck} for p in people)
    for joint, name in enumerate(plain_names(target.joint_names)):
        other = index.get(name, -1)
        if there[joint] >= 0 or other < 0 or joint in ours or other in theirs:
            continue
        above = [there[j] for j in path_up(target, joint)[1:] if there[j] >= 0]
        matched = [j for j in path_up(source, other)[1:] if j in there]
        if above[:1] == matched[:1]:
            there[joint] = other
