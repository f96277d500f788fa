"""Joints of a skeleton that stay at rest while a motion is retargeted onto it."""

from collections.abc import Iterable

import numpy as np

from skpose._warnings import warn
from skpose.kinematics._counterparts import Counterparts
from skpose.kinematics._landmarks import SIDES, path_up
from skpose.kinematics._lines import find_carriers
from skpose.kinematics._rigs import ANKLE, HEAD, WRIST
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import NO_DIRECTION

SHOWN = 6  # names in a report
# The last joints of a person's limbs, and of the trunk, beyond which hands, feet and the head are.
LAST = (*(f"{side}_{mark}" for side in SIDES for mark in (WRIST, ANKLE)), HEAD)


def joints_at_rest(skeleton: Skeleton, moving: Iterable[int]) -> list[int]:
    """Return the joints that could move bones and do not; of several one after another, the first.

    What they carry moves with the joints before them, in its rest pose.
    """
    moving = set(moving)
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    carriers = {
        carrier
        for carrier, length in zip(find_carriers(skeleton), lengths, strict=True)
        if length > NO_DIRECTION * lengths.max()
    }
    found: list[int] = []
    for joint, bone in enumerate(skeleton.bones):
        if bone.dofs and joint not in moving and joint in carriers:
            above = next((j for j in path_up(skeleton, joint)[1:] if skeleton.bones[j].dofs), -1)
            if above in moving or above < 0:
                found.append(joint)
    return found


def movers_of(skeleton: Skeleton, joints: Iterable[int]) -> set[int]:
    """Return the joints that move any of some joints relative to the root."""
    first = 0 if skeleton.offset_frame == "own" else 1
    return {j for joint in joints for j in path_up(skeleton, int(joint))[first:]}


def in_words(skeleton: Skeleton, at_rest: list[int]) -> str:
    """Return what a report says of joints that stay at rest; nothing if there are none."""
    names = [skeleton.joint_names[joint] for joint in at_rest]
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return f"; at rest: {', '.join(names[:SHOWN])}{more}" if names else ""


def warn_of_ends(source: Skeleton, target: Skeleton, found: Counterparts, at_rest: list[int]) -> None:
    """Warn if a hand, a foot or the head of a person stays at rest, and that of the motion has a bone."""
    if found.people is None:
        return
    theirs, ours = (person.joints for person in found.people)
    still, free = [], []
    carriers = find_carriers(target)
    for mark in LAST:
        if mark not in theirs or mark not in ours:
            continue
        ends = {carriers[joint] for joint in _after(target, ours[mark])}
        bones = _after(source, theirs[mark])
        if ends and ends <= set(at_rest) and bones:  # and not a thumb alone
            still += [target.joint_names[joint] for joint in sorted(ends)]
            free += [source.joint_names[joint] for joint in bones if joint not in found.there]
    if still:
        remedy = f", such as {', '.join(map(repr, free[:SHOWN]))}" if free else ""
        warn(
            f"{', '.join(map(repr, still))} stay at rest, as the names of the two skeletons do not show which bones of "
            "hands, feet and head are counterparts: pass joints=, a mapping of joints of the given skeleton to the "
            f"motion's{remedy}. skpose.kinematics.find_counterparts returns those found by names"
        )


def _after(skeleton: Skeleton, joint: int) -> list[int]:
    """Return the joints at which the first bones with a length after a joint end."""
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    found = []
    for child in np.flatnonzero(skeleton.parents == joint).tolist():
        found += [child] if lengths[child] > NO_DIRECTION * lengths.max() else _after(skeleton, child)
    return found
