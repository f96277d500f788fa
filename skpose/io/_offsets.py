"""The offsets of the bones of a BVH file: of each joint's OFFSET and its position channels."""

from collections import Counter

import numpy as np

from skpose.io._hierarchy import Joint
from skpose.io._source import Source

# Variation of a constant position by rounding to the printed digits, at most; as a fraction of the longest bone.
ROUNDING = 1e-4
# Position channels that are not used but not exactly zero, at most; as a fraction of the longest bone.
UNUSED = 1e-3


def local_positions(joint: Joint, numbers: np.ndarray, longest: float) -> np.ndarray:
    """Return the positions (n_frames, 3) of a joint against its parent, in the file's unit.

    Position channels replace OFFSET, unless all are nearly zero: a program writes them for every joint and does not use
    them.
    """
    positions = np.tile(joint.offset, (len(numbers), 1))
    columns = joint.columns("position")
    if (np.abs(numbers[:, [*columns.values()]]) > UNUSED * longest).any():
        for axis, column in columns.items():
            positions[:, "xyz".index(axis)] = numbers[:, column]
    return positions


def longest_bone(joints: list[Joint], numbers: np.ndarray) -> float:
    """Return the length of the longest bone, by OFFSET or by the mean of the position channels, in the file's unit."""
    stated, offsets, _ = _means(joints, numbers)
    return float(np.linalg.norm([*stated, *offsets], axis=1).max(initial=0.0))


def _means(joints: list[Joint], numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return OFFSETs, the same with the means of position channels, and which components these are, (n_joints, 3)."""
    stated = np.array([joint.offset for joint in joints]).reshape(-1, 3)
    offsets, read = stated.copy(), np.zeros_like(stated, dtype=bool)
    for i, joint in enumerate(joints):
        for axis, column in joint.columns("position").items():
            if len(numbers):
                at = (i, "xyz".index(axis))
                offsets[at], read[at] = numbers[:, column].mean(), True
    return stated, offsets, read


def bone_offsets(joints: list[Joint], numbers: np.ndarray, source: Source, stretch: str) -> np.ndarray:
    """Return the bones' offsets (n_joints, 3), in the file's unit: OFFSET, or the mean of the position channels."""
    stated, offsets, read = _means(joints, numbers)
    if not read.any():
        return stated
    longest = np.linalg.norm([*stated, *offsets], axis=1).max()
    vary, largest = np.zeros((2, *stated.shape))
    for i, joint in enumerate(joints):
        for axis, column in joint.columns("position").items():
            at, values = (i, "xyz".index(axis)), numbers[:, column]
            vary[at], largest[at] = np.ptp(values), np.abs(values).max()
    unused = (largest <= UNUSED * longest).all(axis=1)
    moved = np.flatnonzero((vary > ROUNDING * longest).any(axis=1) & ~unused)
    if len(moved) and stretch == "raise":
        joint = joints[moved[0]]
        more = f" (and {len(moved) - 1} joints more)" if len(moved) > 1 else ""
        root = f"root={joint.name!r} takes it as the root; " if _stands_alone(joint, joints) else ""
        raise source.error(
            f"position channels move {joint} by up to {vary[moved[0]].max():g} units against {joint.parent}{more}, but "
            f"bones have constant lengths here; {root}stretch='mean' takes the mean",
            joint.opened,
        )
    offsets[unused] = stated[unused]
    elsewhere = (np.abs(offsets - stated) > ROUNDING * longest).any(axis=1) & stated.any(axis=1)
    elsewhere = np.setdiff1d(np.flatnonzero(elsewhere), moved)
    if len(elsewhere):
        first = elsewhere[0]
        source.warn(
            f"position channels replace the OFFSET of {len(elsewhere)} joints: {joints[first]}, "
            f"line {joints[first].opened.line}, at {_format(offsets[first])}, not {_format(stated[first])}"
        )
    return offsets


def _stands_alone(joint: Joint, joints: list[Joint]) -> bool:
    """Return whether the joint and all above it are the only children of their parents: it carries everything."""
    n_children = Counter(one.parent for one in joints)
    at: Joint | None = joint
    while at is not None and at.parent is not None:
        if n_children[at.parent] > 1:
            return False
        at = at.parent
    return bool(joint.name)


def _format(vector: np.ndarray) -> str:
    return " ".join(f"{x:.6g}" for x in vector)
