"""The joints of a person, as found or as given by the user."""

from collections.abc import Mapping, Sequence

import numpy as np

from skpose._utils.validation import near_names
from skpose.biomechanics._segments import LANDMARKS, LIMBS
from skpose.kinematics._anatomy import SIDES, Anatomy, find_anatomy, pair_of, path_up
from skpose.skeleton import Skeleton
from skpose.skeleton._rest import positions_at_zero
from skpose.skeleton._sides import split_sides

FIRST = tuple(f"{side}_{mark}" for mark in ("hip", "shoulder") for side in SIDES)  # the joints at which limbs begin
HEADS = ("head", "head_top", "head_center")
OTHER_SIDE = -0.5  # cosine of the angle between the lines of hips and shoulders from which one is exchanged
LEGS = tuple(f"{side}_{mark}" for side in SIDES for mark in ("hip", "knee", "ankle"))


def find_person(skeleton: Skeleton, joints: Mapping[str, str] | None) -> Anatomy:
    """The landmarks of a skeleton with both legs, by its names or as given."""
    person = add_joints(skeleton, find_anatomy(skeleton), joints, LANDMARKS)
    require(person, LEGS)
    if joints:
        check_joints(skeleton, person, joints)
    return person


def add_joints(skeleton: Skeleton, person: Anatomy, joints: Mapping[str, str] | None, marks: Sequence[str]) -> Anatomy:
    """Anatomy with the joints that the user gives for some marks."""
    given = {} if joints is None else dict(joints)
    for mark, name in given.items():
        if mark not in marks:
            raise ValueError(f"joints has the unknown landmark {mark!r}: {near_names(marks, str(mark), 'see joints')}")
        if name not in skeleton.joint_names:
            near = near_names(skeleton.joint_names, str(name))
            raise ValueError(f"joints[{mark!r}] is {name!r}, which is not a joint: {near}")
    numbers = {mark: skeleton.joint_names.index(name) for mark, name in given.items()}
    return person._replace(joints=person.joints | numbers)


def require(person: Anatomy, marks: Sequence[str]) -> None:
    """Refuse a person without some of the landmarks."""
    if absent := [mark for mark in marks if mark not in person.joints]:
        raise ValueError(f"{', '.join(absent)} not found: pass joints={{{absent[0]!r}: ...}}")


def check_joints(skeleton: Skeleton, person: Anatomy, given: Mapping[str, str]) -> None:
    """Refuse landmarks, some given by the user, that are not at the joints of a person."""
    joints = {mark: joint for mark, joint in person.joints.items() if mark in LANDMARKS}
    below = {mark: path_up(skeleton, joint)[1:] for mark, joint in joints.items()}
    chains = [(f"{side}_{start}", f"{side}_{end}") for side in SIDES for start, ends in LIMBS.values() for end in ends]
    for upper, lower in chains:
        if (
            {upper, lower} <= joints.keys()
            and not {upper, lower}.isdisjoint(given)
            and joints[upper] not in below[lower]
        ):
            names = skeleton.joint_names[joints[upper]], skeleton.joint_names[joints[lower]]
            raise ValueError(f"{lower} is {names[1]!r}, which is not below {upper}, {names[0]!r}: check joints=")
    firsts = [mark for mark in FIRST if mark in joints]
    for mark in (*firsts, *(head for head in HEADS if head in joints)):
        if above := [first for first in firsts if first != mark and joints[first] in below[mark]]:
            raise ValueError(f"{mark} is below {above[0]}, expected limbs and head apart: check joints=")
    for mark in given:
        for other in joints:
            if joints[other] == joints[mark] and _part(other) != _part(mark):
                raise ValueError(f"{mark} and {other} are one joint, {given[mark]!r}: check joints=")
    hips, shoulders = pair_of(person.joints, "hip"), pair_of(person.joints, "shoulder")
    if hips is not None and shoulders is not None:
        at_zero = positions_at_zero(skeleton)
        across, above = (at_zero[right] - at_zero[left] for left, right in (hips, shoulders))
        if across @ above < OTHER_SIDE * np.linalg.norm(across) * np.linalg.norm(above):
            raise ValueError("the left arm is on the side of the right leg: exchange left and right of one in joints=")
    if not any(mark.endswith(("ball", "toe")) for mark in joints):  # toes that point backward show exchanged sides
        by_name = dict(zip(skeleton.joint_names, split_sides(skeleton.joint_names), strict=True))
        for mark, name in given.items():
            side = by_name[name][0]
            if side and mark.startswith(SIDES) and not mark.startswith(side):
                raise ValueError(
                    f"joints[{mark!r}] is {name!r}, on the {side} by its name: name a toe too, or exchange"
                )


def _part(mark: str) -> str:
    """A landmark, or the one that may be at the same joint: a foot ends at the ball or the toe."""
    return "head" if mark in HEADS else mark.replace("toe", "ball")
