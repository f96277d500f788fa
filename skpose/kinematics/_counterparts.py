"""The joints of two differently rigged skeletons that are counterparts of each other."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from skpose._validation.names import near_names
from skpose.skeleton import Skeleton

SHOWN = 4  # names in a message


def counterparts(source: Skeleton, target: Skeleton, joints: Mapping[str, str] | None) -> np.ndarray:
    """Return the index (n_joints,) in the source of the counterpart of each joint of the target; -1 where it has none.

    The roots are counterparts of each other. Nothing is guessed: without a mapping, joints of equal names are.
    """
    if joints is None:
        joints = {name: name for name in target.joint_names if name in source}
        if not joints:
            raise ValueError(
                "the motion's skeleton and the given one have no name of a joint in common: pass joints=, a mapping of "
                f"joints of the given skeleton ({_list_some(target)}) to the motion's ({_list_some(source)})"
            )
    _check(source, target, joints)
    index = {name: i for i, name in enumerate(source.joint_names)}
    there = np.array([index[joints[name]] if name in joints else -1 for name in target.joint_names], dtype=np.intp)
    _check_order(source, target, there)
    return there


def ratio_of_lengths(source: Skeleton, target: Skeleton, there: np.ndarray) -> float:
    """Return how many times as long the target's bones are as the source's: those that both have, summed.

    They are the bones between a joint that has a counterpart and the next one toward the root that has one, or the root
    itself, where the first one's counterpart is further from the root than the second one's.
    """
    lengths = [np.linalg.norm(skeleton.offsets, axis=1) for skeleton in (target, source)]
    sums = np.zeros(2)
    for joint in np.flatnonzero(there >= 0):
        above = _find_mapped_above(target, there, int(joint))
        first = int(there[above]) if above >= 0 else -1
        path = _path(source, int(there[joint]), first)
        if path is not None:
            sums += lengths[0][_path(target, int(joint), above)].sum(), lengths[1][path].sum()
    if not (sums > 0.0).all():
        raise ValueError(
            'scale="lengths" needs bones that both skeletons have, but those between joints with counterparts are '
            f"{sums[1]:.3g} m long in the motion's skeleton and {sums[0]:.3g} m in the given one: pass a number instead"
        )
    return float(sums[0] / sums[1])


def _check(source: Skeleton, target: Skeleton, joints: Any) -> None:
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
        above = _find_mapped_above(target, there, int(joint))
        if above >= 0 and _path(source, int(there[above]), int(there[joint])) is not None:
            names = target.joint_names[joint], target.joint_names[above]
            others = source.joint_names[there[joint]], source.joint_names[there[above]]
            raise ValueError(
                f"joints maps {names[0]!r} to {others[0]!r} and {names[1]!r} to {others[1]!r}, but {names[0]!r} comes "
                f"after {names[1]!r} and {others[0]!r} before {others[1]!r}: exchange the two"
            )


def _find_mapped_above(target: Skeleton, there: np.ndarray, joint: int) -> int:
    """Return the next joint toward the root that has a counterpart, or -1, the root."""
    above = int(target.parents[joint])
    while above >= 0 and there[above] < 0:
        above = int(target.parents[above])
    return above


def _path(skeleton: Skeleton, last: int, first: int) -> list[int] | None:
    """Return the bones from a joint, or from the root, -1, to a joint after it; None if it does not come after it."""
    bones = []
    while last != first:
        if last < 0:
            return None
        bones.append(last)
        last = int(skeleton.parents[last])
    return bones


def _list_some(skeleton: Skeleton) -> str:
    names = skeleton.joint_names
    return ", ".join(map(repr, names[:SHOWN])) + ", …" * (len(names) > SHOWN)
