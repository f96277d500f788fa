"""Joints by their names: look-up, with near names where there is none, and the joints that one skeleton alone has."""

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from skpose._validation.names import near_names
from skpose.skeleton._bone import Bone

if TYPE_CHECKING:
    from skpose.skeleton._skeleton import Skeleton

HAND_OF_AMASS = re.compile(r"(left|right)_(hand|(index|middle|pinky|ring|thumb)[123])")


def bone_named(skeleton: "Skeleton", name: str) -> Bone:
    """Return the bone that ends at the joint of a name: ``skeleton["left_hand"]``."""
    if not isinstance(name, str):
        raise TypeError(
            f"a skeleton is indexed by the name of a joint, got {type(name).__name__}: skeleton.bones has the bones by "
            "number"
        )
    for bone in skeleton.bones:
        if bone.name == name:
            return bone
    raise KeyError(f"the skeleton has no joint {name!r}: {near_names(skeleton.joint_names, name)}")


def has_joint(skeleton: "Skeleton", name: object) -> bool:
    """Return whether a joint has this name: ``"left_hand" in skeleton``."""
    return name in skeleton.joint_names


def names_of(skeleton: "Skeleton") -> Iterator[str]:
    """Yield the names of the joints, as iteration over a dictionary yields its keys."""
    return iter(skeleton.joint_names)


def as_one_object(skeleton: "Skeleton", dtype: object = None, copy: bool | None = None) -> np.ndarray:
    """Return an array of no dimension that holds the skeleton.

    Without it numpy takes what has a length for a sequence, and makes a table of names of the list of skeletons among
    which a grid search chooses.
    """
    if dtype is not None and np.dtype(dtype) != object:  # type: ignore[call-overload]
        raise TypeError("a Skeleton is no array of numbers")
    array = np.empty((), dtype=object)
    array[()] = skeleton
    return array


def only_one_has(names: Sequence[str]) -> str:
    """Return in words that joints of these names are in one of two skeletons, and the remedy where there is one."""
    more = f" (and {len(names) - 1} more)" if len(names) > 1 else ""
    hands = all(HAND_OF_AMASS.fullmatch(name) for name in names)
    remedy = "; without their hands, load_motion(..., hands=False), motions of SMPL and SMPL-H have one skeleton"
    return f"only one of them has a joint {names[0]!r}{more}{remedy * hands}"
