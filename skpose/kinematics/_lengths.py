"""The sizes of two skeletons, compared by the bones that both have."""

import numpy as np

from skpose.skeleton import Skeleton


def ratio_of_lengths(source: Skeleton, target: Skeleton, there: np.ndarray, measured: np.ndarray) -> float:
    """Return how many times as long the target's bones are as the source's: those that both have, summed.

    They are the bones between a joint that has a counterpart and the next one toward the root that has one, or the root
    itself, where the first one's counterpart is further from the root than the second one's. There (n_joints,) is the
    index of each joint's counterpart, -1 where it has none; measured (n_joints,) are the joints before which bones
    count.
    """
    lengths = [np.linalg.norm(skeleton.offsets, axis=1) for skeleton in (target, source)]
    sums = np.zeros(2)
    for joint in np.flatnonzero(measured):
        above = find_mapped_above(target, there, int(joint))
        first = int(there[above]) if above >= 0 else -1
        path = find_bones(source, int(there[joint]), first)
        if path is not None:
            sums += lengths[0][find_bones(target, int(joint), above)].sum(), lengths[1][path].sum()
    if not (sums > 0.0).all():
        raise ValueError(
            'scale="lengths" needs bones that both skeletons have, but those between joints with counterparts are '
            f"{sums[1]:.3g} m long in the motion's skeleton and {sums[0]:.3g} m in the given one: pass a number instead"
        )
    return float(sums[0] / sums[1])


def find_mapped_above(target: Skeleton, there: np.ndarray, joint: int) -> int:
    """Return the next joint toward the root that has a counterpart, or -1, the root."""
    above = int(target.parents[joint])
    while above >= 0 and there[above] < 0:
        above = int(target.parents[above])
    return above


def find_bones(skeleton: Skeleton, last: int, first: int) -> list[int] | None:
    """Return the bones from a joint, or from the root, -1, to a joint after it; None if it does not come after it."""
    bones = []
    while last != first:
        if last < 0:
            return None
        bones.append(last)
        last = int(skeleton.parents[last])
    return bones
