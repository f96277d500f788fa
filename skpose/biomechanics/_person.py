"""The joints of a person, by the names of known rigs or as a user names them, and whether these can be a person's."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from skpose._validation.names import near_names
from skpose.biomechanics._segments import LANDMARKS, LIMBS, SIDES, pair
from skpose.kinematics._shared import Landmarks, find_landmarks, path_up
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import positions_at_zero, split_sides

FIRST = tuple(f"{side}_{mark}" for mark in ("hip", "shoulder") for side in SIDES)  # the joints at which limbs begin
HEADS = ("head", "head_top", "head_center")
OTHER_SIDE = -0.5  # cosine of the angle between the lines of hips and shoulders from which one is exchanged


def find_person(skeleton: Skeleton, joints: Any) -> Landmarks:
    """Return the landmarks of a skeleton, by its names or as they are given."""
    given = {} if joints is None else joints
    if not isinstance(given, Mapping):
        raise TypeError(
            f"joints must be a mapping of landmarks to names of joints, such as {{'left_knee': 'KneeL'}}, got "
            f"{type(given).__name__}"
        )
    person = find_landmarks(skeleton)
    for landmark, name in given.items():
        if landmark not in LANDMARKS:
            raise ValueError(f"joints has the landmark {landmark!r}; expected one of {', '.join(LANDMARKS)}")
        if name not in skeleton.joint_names:
            near = near_names(skeleton.joint_names, str(name))
            raise ValueError(f"joints[{landmark!r}] is {name!r}, which is no joint of the skeleton: {near}")
        person = person._replace(joints=person.joints | {landmark: skeleton.joint_names.index(name)})
    needed = [f"{side}_{mark}" for side in SIDES for mark in ("hip", "knee", "ankle")]
    absent = [mark for mark in needed if mark not in person.joints]
    if absent:
        because = f" ({person.reason})" if person.reason else ""
        raise ValueError(
            f"the joints {', '.join(absent)} of this skeleton are not known by their names{because}; its joints are "
            f"{', '.join(skeleton.joint_names)}. Pass joints=, such as {{{absent[0]!r}: {skeleton.joint_names[0]!r}}}"
        )
    if given:
        check_joints(skeleton, person, given)
    return person


def check_joints(skeleton: Skeleton, person: Landmarks, given: Mapping[str, str]) -> None:
    """Refuse landmarks of which a user has named some, if they are not at the joints of a person."""
    joints = {mark: joint for mark, joint in person.joints.items() if mark in LANDMARKS}

    def words(*marks: str) -> str:
        """Return landmarks with their joints, and which of them the user has named."""
        return " and ".join(
            f"{mark} is {skeleton.joint_names[joints[mark]]!r}{'' if mark in given else ' by its name'}"
            for mark in marks
        )

    def is_below(mark: str, above: str) -> bool:
        return joints[above] in path_up(skeleton, joints[mark])[1:]

    for mark in given:
        same = [other for other in joints if joints[other] == joints[mark] and _part(other) != _part(mark)]
        if same:
            raise ValueError(f"{words(mark, same[0])}: expected two joints; pass joints= with the name of each")
    for above, below in _chains(joints):
        if (above in given or below in given) and not is_below(below, above):
            upper, lower = (mark.partition("_")[2] for mark in (above, below))
            raise ValueError(
                f"{words(above, below)}, which does not come after it in the skeleton: expected the {lower} below the "
                f"{upper} of its side; are names exchanged, or those of two sides mixed?"
            )
    firsts = [mark for mark in FIRST if mark in joints]
    for mark in (*firsts, *(head for head in HEADS if head in joints)):
        for first in firsts:
            if mark != first and is_below(mark, first):
                raise ValueError(
                    f"{words(first, mark)}, which comes after it in the skeleton: expected limbs and head that are no "
                    "part of a limb"
                )
    _check_sides(skeleton, person, given)


def _part(mark: str) -> str:
    """Return a landmark, or the one that may be at the same joint: a foot ends at the ball or the toe."""
    return "head" if mark in HEADS else mark.replace("toe", "ball")


def _chains(joints: Mapping[str, int]) -> list[tuple[str, str]]:
    """Return pairs of landmarks of which the second comes after the first in a person."""
    pairs = [(f"{side}_{start}", f"{side}_{end}") for side in SIDES for start, ends in LIMBS.values() for end in ends]
    return [both for both in pairs if set(both) <= joints.keys()]


def _check_sides(skeleton: Skeleton, person: Landmarks, given: Mapping[str, str]) -> None:
    """Refuse arms on the other side than the legs, and names of the other side where no foot shows the front.

    Where feet are known, toes that point backward show that left and right are exchanged.
    """
    hips, shoulders = pair(person, "hip"), pair(person, "shoulder")
    if hips is not None and shoulders is not None:
        at_zero = positions_at_zero(skeleton)
        across, above = (at_zero[right] - at_zero[left] for left, right in (hips, shoulders))
        if across @ above < OTHER_SIDE * np.linalg.norm(across) * np.linalg.norm(above):
            raise ValueError(
                "the joints of the left arm are on the side of the right leg: expected both on one side; pass joints= "
                "with left and right of the arms or of the legs exchanged"
            )
    if any(f"{side}_{mark}" in person.joints for side in SIDES for mark in ("ball", "toe")):
        return
    for side, (mark, name) in zip(_sides_of(skeleton, given), given.items(), strict=True):
        if side and mark.startswith(SIDES) and not mark.startswith(side):
            raise ValueError(
                f"joints[{mark!r}] is {name!r}, which by its name is on the {side}: expected a joint of the "
                f"{mark.partition('_')[0]}. If the names are wrong, name a toe too, which shows where the front is"
            )


def _sides_of(skeleton: Skeleton, given: Mapping[str, str]) -> list[str]:
    """Return the side of each joint that is given by its name, "" where it says none."""
    sides = dict(zip(skeleton.joint_names, (side for side, _ in split_sides(skeleton.joint_names)), strict=True))
    return [sides[name] for name in given.values()]
