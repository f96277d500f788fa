"""The joints of a person, as found or as given by the user."""

from collections.abc import Collection, Mapping

import numpy as np

from skpose._utils.validation import near_names
from skpose.kinematics._anatomy import ENDS_OF, SIDES, Anatomy, find_anatomy, find_misplaced, pair_of
from skpose.skeleton import Skeleton
from skpose.skeleton._rest import positions_at_zero

LEGS = tuple(f"{side}_{mark}" for side in SIDES for mark in ("hip", "knee", "ankle"))
HEADS = ("head", "head_top", "head_center")
ENDS = tuple(f"{side}_{mark}" for side in SIDES for mark in ("ball", "toe", "shoulder", "elbow", "wrist", "hand"))
LANDMARKS = (*LEGS, *ENDS, *HEADS)
OTHER_SIDE = -0.5  # cosine of the angle between the lines of hips and shoulders from which one is exchanged


def find_person(skeleton: Skeleton, joints: Mapping[str, str] | None, required: Collection[str] = LEGS) -> Anatomy:
    """The landmarks of a skeleton, by its names or as given."""
    given, numbers, found = dict(joints or {}), dict[str, int](), find_anatomy(skeleton)
    for mark, name in given.items():
        if mark not in LANDMARKS:
            near = near_names(LANDMARKS, str(mark), "see joints")
            raise ValueError(f"joints has the unknown landmark {mark!r}: {near}")
        if name not in skeleton.joint_names:
            near = near_names(skeleton.joint_names, str(name))
            raise ValueError(f"joints[{mark!r}] is {name!r}, which is not a joint: {near}")
        numbers[mark] = skeleton.joint_names.index(name)
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
