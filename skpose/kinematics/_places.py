"""Labels of joints in tables and plots, by their place on a person: "left knee (lfemur)"."""

import re

from skpose.kinematics._anatomy import BALL, COLLAR, HEAD_CENTER, HIPS, Anatomy, find_anatomy
from skpose.skeleton import Skeleton

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
