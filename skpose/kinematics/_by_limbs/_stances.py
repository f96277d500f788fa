"""The landmarks of a person and of a robot that are counterparts, and how both stand at angle zero."""

import functools
from collections.abc import Mapping

from skpose.kinematics._by_limbs._places import (
    ARM,
    LEG,
    Place,
    Stance,
    find_robot,
    find_stance,
    joint_places,
    robot_places,
)
from skpose.kinematics._counterparts import check_joints
from skpose.kinematics._landmarks import SIDES, find_landmarks
from skpose.skeleton import Skeleton

EXAMPLE = '{"left_knee_link": "LeftLeg"}'
LIMBS = {LEG: "legs", ARM: "arms"}


def stances_of(source: Skeleton, target: Skeleton, joints: Mapping[str, str] | None) -> tuple[Stance, Stance]:
    """Return how the skeletons of a motion and of a robot stand, with landmarks by their names or by counterparts."""
    if joints is not None:
        check_joints(source, target, joints)
    return _stances(source, target, None if joints is None else tuple(joints.items()))


@functools.lru_cache(maxsize=16)
def _stances(source: Skeleton, target: Skeleton, pairs: tuple[tuple[str, str], ...] | None) -> tuple[Stance, Stance]:
    """Return how both skeletons stand, given pairs of joints of target and source, or None."""
    joints = None if pairs is None else dict(pairs)
    robot = find_robot(target)
    known = robot_places(target, robot) if robot else {}
    there = find_landmarks(source, any_proportions=joints is not None)
    theirs, ours = joint_places(source, there.joints), known
    if joints is not None:
        theirs, ours = _by_counterparts(source, target, joints, there.joints, known)
    elif not known:
        ours = joint_places(target, find_landmarks(target).joints)
    found = []
    for skeleton, places, whose in ((source, theirs, "the motion's skeleton"), (target, ours, "the given skeleton")):
        if not places:
            raise ValueError(
                f'method="limbs" needs to know hips, knees and ankles, or shoulders, elbows and wrists, but {whose} '
                "has the names of no person or robot that is known: pass joints=, a mapping of joints of the given "
                f"skeleton to those of the motion's, such as {EXAMPLE}. One of the two must be known, as it shows "
                "which joint is a knee"
            )
        if not _has_any(places):
            raise ValueError(
                'method="limbs" needs hips, knees and ankles of both sides, or shoulders, elbows and wrists, but '
                f"{whose} has only {', '.join(sorted(places))}: name the others with joints="
            )
        found.append(find_stance(skeleton, places, robot if places is ours else None))
    one, other = found
    _check_limbs(one, other)
    return one, other


def _has_any(places: dict[str, Place]) -> bool:
    """Return whether both legs, or both arms, have all their landmarks."""
    return any(all(f"{side}_{mark}" in places for side in SIDES for mark in limb) for limb in LIMBS)


def _by_counterparts(
    source: Skeleton,
    target: Skeleton,
    joints: Mapping[str, str],
    landmarks: dict[str, int],
    known: dict[str, Place],
) -> tuple[dict[str, Place], dict[str, Place]]:
    """Return the places of landmarks that given counterparts have: by those of the motion, or else of the robot."""
    marks = {source.joint_names[joint]: mark for mark, joint in landmarks.items()}
    links = {target.joint_names[place.joint]: mark for mark, place in reversed(known.items())}
    theirs, ours = joint_places(source, landmarks), {}
    for name, counterpart in joints.items():
        mark = marks.get(counterpart, "") or links.get(name, "")
        if not mark:
            continue
        theirs[mark] = joint_places(source, {mark: source.joint_names.index(counterpart)})[mark]
        joint = target.joint_names.index(name)
        place = known.get(mark)
        ours[mark] = place if place and place.joint == joint else joint_places(target, {mark: joint})[mark]
    for mark, place in known.items():  # the sole of a foot, and a hand, have no counterpart of their own
        side, _, name = mark.partition("_")
        if (name in ("heel", "tip") and f"{side}_ankle" in ours) or (name == "hand" and f"{side}_wrist" in ours):
            ours.setdefault(mark, place)
    return theirs, ours


def _check_limbs(theirs: Stance, ours: Stance) -> None:
    """Refuse a motion without the limbs that the target has, and one without legs, which has no place on a floor."""
    for limb, name in LIMBS.items():
        if ours.has(limb) and not theirs.has(limb):
            raise ValueError(
                f'method="limbs" needs the {name} of the motion, as the given skeleton has {name}, but in its skeleton '
                f"{', '.join(limb)} of both sides are not known by their names: name them with joints="
            )
    if not theirs.has(LEG):
        raise ValueError(
            'method="limbs" needs the legs of the motion: they show how large it is and where its floor is'
        )
    if not ours.has(LEG) and not theirs.has(ARM):
        raise ValueError('method="limbs" needs the shoulders of the motion for a skeleton without legs')
