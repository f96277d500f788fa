"""The landmarks of a person and of a robot that are counterparts, and how both stand at angle zero."""

import functools
from collections.abc import Mapping

from skpose._warnings import warn
from skpose.kinematics._by_limbs._places import (
    ARM,
    LEG,
    Place,
    Stance,
    find_robot,
    find_stance,
    joint_places,
    length_of_leg,
    missing_links,
    robot_places,
)
from skpose.kinematics._by_limbs._robots import HEEL, TIP, Robot
from skpose.kinematics._counterparts import check_joints
from skpose.kinematics._landmarks import SIDES, find_landmarks, path_up
from skpose.kinematics._rigs import ANKLE, BALL, HAND, HIP, SHOULDER, TOE, WRIST
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import split_sides

EXAMPLE = '{"left_knee_link": "LeftLeg"}'
LIMBS = {LEG: "legs", ARM: "arms"}
PERSON = 0.2, 1.5  # m, the shortest and the longest legs that a person has


def stances_of(source: Skeleton, target: Skeleton, joints: Mapping[str, str] | None) -> tuple[Stance, Stance]:
    """Return how the skeletons of a motion and of a robot stand, with landmarks by their names or by counterparts."""
    if joints is not None:
        check_joints(source, target, joints)
    return _stances(source, target, None if joints is None else tuple(joints.items()))


def warn_of_sizes(theirs: Stance, ours: Stance) -> None:
    """Warn if the motion is of no person's size, and if no point of the target shows where its soles are."""
    leg = length_of_leg(theirs)
    if not PERSON[0] <= leg <= PERSON[1]:
        warn(
            f"the legs of the motion's skeleton are {leg:.3g} m long, and those of people {PERSON[0]:g} to "
            f"{PERSON[1]:g} m: its positions are likely in another unit than metres; convert them"
        )
    if ours.lowest:
        low = " and ".join(repr(lowest.joint) for lowest in ours.lowest.values())
        warn(
            "no point of the soles of the given skeleton is named: they are taken to be as low as its joints "
            f"{low}, and stand in the floor by as much as they are lower. Name a joint at the front of each "
            "sole with joints=, as the counterpart of the ball of the foot"
        )


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
                f"has the names of no person or robot that is known: {_nearly_in_words(skeleton)}pass joints=, a "
                "mapping of joints of the given "
                f"skeleton to those of the motion's, such as {EXAMPLE}. One of the two must be known, as it shows "
                "which joint is a knee"
            )
        if not _has_any(places):
            raise ValueError(
                'method="limbs" needs hips, knees and ankles of both sides, or shoulders, elbows and wrists, but '
                f"{whose} has only {', '.join(sorted(places))}: name the others with joints="
            )
        if places is ours:
            _check_whole(skeleton, places, robot)
        found.append(find_stance(skeleton, places, robot if places is ours else None))
    one, other = found
    _check_limbs(one, other)
    _check_sides(target, other)
    return one, other


def _nearly_in_words(skeleton: Skeleton) -> str:
    """Return in words which robot a skeleton nearly is, and which links it lacks; nothing if it is near to none."""
    robot, missing = missing_links(skeleton)
    if robot is None:
        return ""
    if not missing:
        return f"it is the {robot.name}, and a motion must be a person's. For a robot's motion, or another one, "
    return f"it is nearly the {robot.name}, but has no {', '.join(map(repr, missing))}. Rename its links, or "


def _check_whole(skeleton: Skeleton, places: dict[str, Place], robot: Robot | None) -> None:
    """Refuse a target of which some but not all landmarks of a limb are known, and a robot whose legs are not named."""
    for limb, name in LIMBS.items():
        marks = [f"{side}_{mark}" for side in SIDES for mark in limb]
        missing = [mark for mark in marks if mark not in places]
        stands = limb == LEG and robot is not None and LEG[0] in robot.left
        if missing and (stands or len(missing) < len(marks)):
            raise ValueError(
                f'method="limbs" needs all joints of the {name} of the given skeleton, but {", ".join(missing)} '
                f"{'have' if len(missing) > 1 else 'has'} no counterpart: name the joints with joints="
            )
        for side in SIDES if not missing else ():
            for above, below in ((limb[0], limb[1]), (limb[1], limb[2])):
                upper, lower = (places[f"{side}_{mark}"].joint for mark in (above, below))
                if upper == lower or upper not in path_up(skeleton, lower):
                    raise ValueError(
                        f"joints= names {skeleton.joint_names[upper]!r} as {side}_{above} and "
                        f"{skeleton.joint_names[lower]!r} as {side}_{below}, but in the given skeleton the first does "
                        "not carry the second: exchange or correct them"
                    )


def _check_sides(target: Skeleton, ours: Stance) -> None:
    """Refuse landmarks of one side whose joints are of the other: by their names, or as feet would point backward."""
    for mark, place in ours.places.items():
        side = mark.partition("_")[0]
        named = split_sides([target.joint_names[place.joint]])[0][0]
        if side in SIDES and named in SIDES and named != side:
            raise ValueError(
                f"joints= names {target.joint_names[place.joint]!r} of the given skeleton as {mark}: left and right "
                "are exchanged"
            )
    left = [
        ours.places[f"left_{mark}"].at_zero - ours.places[f"right_{mark}"].at_zero
        for mark in (HIP, SHOULDER)
        if f"left_{mark}" in ours.places
    ]
    if min(float(line @ ours.axes[:, 1]) for line in left) < 0.0:
        raise ValueError(
            "the left hip, or shoulder, of the given skeleton is to the right of the other one at angle zero: joints= "
            "exchanges left and right"
        )
    fronts = [
        ours.places[mark].at_zero - ours.places[f"{side}_{ANKLE}"].at_zero
        for side in SIDES
        for mark in (f"{side}_{BALL}", f"{side}_{TOE}", f"{side}_{TIP}")
        if mark in ours.places and f"{side}_{ANKLE}" in ours.places
    ]
    if fronts and max(float(line @ ours.axes[:, 0]) for line in fronts) < 0.0:
        raise ValueError(
            "the feet of the given skeleton point backward at angle zero: joints= exchanges left and right, or the "
            "front of the soles with their back"
        )


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
        mark, link = marks.get(counterpart, ""), links.get(name, "")
        limbs = [f"{side}_{one}" for side in SIDES for limb in LIMBS for one in limb]
        if mark in limbs and link in limbs and mark != link:
            raise ValueError(
                f"joints= names {counterpart!r} of the motion's skeleton, its {mark}, as the counterpart of {name!r}, "
                f"which is the {link} of the given skeleton"
            )
        mark = mark or link
        if not mark:
            continue
        theirs[mark] = joint_places(source, {mark: source.joint_names.index(counterpart)})[mark]
        joint = target.joint_names.index(name)
        place = known.get(mark)
        ours[mark] = place if place and place.joint == joint else joint_places(target, {mark: joint})[mark]
    for mark, place in known.items():  # the sole of a foot, and a hand, have no counterpart of their own
        side, _, name = mark.partition("_")
        if (name in (HEEL, TIP) and f"{side}_{ANKLE}" in ours) or (name == HAND and f"{side}_{WRIST}" in ours):
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
