"""The skeleton of a BVH file: which joint is its root, how that moves, and the offsets of the bones.

The root is the first joint, ROOT, unless the file has a reference above the skeleton: a joint that stands still and has
one child, which is moved by position channels.
"""

from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.validation import list_names
from skpose.io._source import Source, Token
from skpose.skeleton._continuity import continuous_triples

# Fractions of the longest bone: variation of a constant position by rounding, and position channels that are not used.
ROUNDING, UNUSED = 1e-4, 1e-3
MOST_NAMES = 40  # in a message


@dataclass(eq=False)
class Joint:
    """One block of the hierarchy."""

    name: str  # empty for an End Site
    parent: "Joint | None"
    opened: Token  # its ROOT, JOINT or End
    offset: list[float] = field(default_factory=list)
    channels: list[str] = field(default_factory=list)  # such as "xposition", "zrotation"
    first: int = 0  # index of its first number in a frame

    def columns(self, kind: str) -> dict[str, int]:
        """The axes of its channels of a kind, in the file's order, and their indices in a frame."""
        return {channel[0]: self.first + k for k, channel in enumerate(self.channels) if channel.endswith(kind)}

    def numbers(self, kind: str, numbers: np.ndarray) -> np.ndarray:
        """The columns of a kind among the numbers (n_frames, n_channels) of a file."""
        return numbers[:, [*self.columns(kind).values()]]

    def __str__(self) -> str:
        return repr(self.name) if self.name else f"the End Site of {self.parent}"


def choose_root(
    joints: list[Joint], numbers: np.ndarray, name: str | None, names: dict[Joint, str], source: Source
) -> tuple[list[Joint], list[Joint]]:
    """Choose the root, by its name, or as the joint that carries the skeleton.

    The result is the chain of joints from ROOT to it, and the joints below it in the order of the file.
    """
    if name is None:
        chain = _find_reference_chain(joints, numbers)
        return chain, joints[len(chain) :]  # each joint of the chain is an only child
    named = {unique: joint for joint, unique in names.items() if joint.name} | {joints[0].name: joints[0]}
    if name not in named:
        raise source.error(f"root={name!r} is not a joint of this file: {', '.join(sorted(named)[:MOST_NAMES])}")
    chain = [named[name]]
    while (parent := chain[-1].parent) is not None:
        chain.append(parent)
    kept = {chain[0]}
    for joint in joints:  # a parent comes before its children
        if joint.parent in kept:
            kept.add(joint)
    if left := [str(joint) for joint in joints if joint not in kept and joint not in chain]:
        source.warn(f"root={name!r} leaves out joints that are not below it: {list_names(left)}")
    return chain[::-1], [joint for joint in joints if joint in kept and joint is not chain[0]]


def _find_reference_chain(joints: list[Joint], numbers: np.ndarray) -> list[Joint]:
    """The chain from ROOT to the first joint that position channels move, if nothing above it moves."""
    root = joints[:1]
    if len(joints) < 2 or len(numbers) < 2 or not _is_still(joints[0], numbers, np.inf):
        return root
    n_children = Counter(joint.parent for joint in joints)
    longest = _longest(*_mean_offsets(joints[1:], numbers))
    for i, (joint, child) in enumerate(pairwise(joints)):
        if n_children[joint] != 1 or not child.name or not _is_still(joint, numbers, longest):
            return root
        positions = child.numbers("position", numbers)
        if _varies(positions, ROUNDING * longest) and (np.abs(positions) > UNUSED * longest).any():
            return joints[: i + 2]
    return root


def _is_still(joint: Joint, numbers: np.ndarray, longest: float) -> bool:
    return not (
        _varies(joint.numbers("position", numbers), ROUNDING * longest)
        or _varies(joint.numbers("rotation", numbers), np.degrees(ROUNDING))
    )


def _varies(values: np.ndarray, tolerance: float) -> bool:
    return bool((np.ptp(values, axis=0) > tolerance).any())


def _mean_offsets(joints: list[Joint], numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """OFFSETs (n_joints, 3), and the same with the means of position channels in their place."""
    stated = np.array([joint.offset for joint in joints]).reshape(-1, 3)
    offsets = stated.copy()
    for i, joint in enumerate(joints):
        for axis, column in joint.columns("position").items():
            if len(numbers):
                offsets[i, "xyz".index(axis)] = numbers[:, column].mean()
    return stated, offsets


def _longest(stated: np.ndarray, offsets: np.ndarray) -> float:
    return float(np.linalg.norm([*stated, *offsets], axis=1).max(initial=0.0))


def bone_offsets(joints: list[Joint], numbers: np.ndarray, source: Source, stretch: str) -> tuple[np.ndarray, float]:
    """The bones' offsets (n_joints, 3), OFFSET or the mean of the position channels, and the longest bone."""
    stated, offsets = _mean_offsets(joints, numbers)
    longest = _longest(stated, offsets)
    if not len(numbers):
        return offsets, longest
    positions = [joint.numbers("position", numbers) for joint in joints]
    vary = np.array([np.ptp(each, axis=0).max(initial=0.0) for each in positions])
    largest = np.array([np.abs(each).max(initial=0.0) for each in positions])
    unused = largest <= UNUSED * longest
    moved = np.flatnonzero((vary > ROUNDING * longest) & ~unused)
    if len(moved) and stretch == "raise":
        joint = joints[moved[0]]
        raise source.error(
            f"position channels move {joint} by {vary[moved[0]]:g} units, but bones have constant lengths: "
            "pass root= or stretch='mean'",
            joint.opened,
        )
    offsets[unused] = stated[unused]
    elsewhere = (np.abs(offsets - stated) > ROUNDING * longest).any(axis=1) & stated.any(axis=1)
    elsewhere = np.setdiff1d(np.flatnonzero(elsewhere), moved)
    if len(elsewhere):
        source.warn(f"position channels replace the OFFSET of {len(elsewhere)} joints, such as {joints[elsewhere[0]]}")
    return offsets, longest


def root_movement(
    chain: list[Joint], numbers: np.ndarray, longest: float, root_offset: str
) -> tuple[np.ndarray, str, np.ndarray]:
    """Positions (n_frames, 3) in the file's unit, axes and angles (n_frames, k) in rad of a chain's last joint.

    They are those of its own channels if nothing above it is moved or rotated, and its movement in space otherwise.
    """
    positions = _positions(chain[0], numbers, -1.0, 1.0 if root_offset == "add" else 0.0)
    above: Rotation | None = None
    for parent, joint in pairwise(chain):
        above = _product(above, _rotation(parent, numbers))
        local = _positions(joint, numbers, UNUSED * longest, 0.0)
        positions += local if above is None else above.apply(local)
    axes = "".join(chain[-1].columns("rotation")).upper()
    if above is None:
        return positions, axes, np.radians(chain[-1].numbers("rotation", numbers))
    axes = axes if len(axes) == 3 else "ZXY"
    turned = _product(above, _rotation(chain[-1], numbers))
    return positions, axes, continuous_triples(axes, turned)


def _product(first: Rotation | None, second: Rotation | None) -> Rotation | None:
    return second if first is None else first if second is None else first * second


def _positions(joint: Joint, numbers: np.ndarray, least: float, share: float) -> np.ndarray:
    """The positions (n_frames, 3) of a joint relative to its parent, in the file's unit.

    Position channels, with a share of OFFSET added, replace it unless all are at most `least`: programs write them
    for every joint without using them.
    """
    positions = np.tile(joint.offset, (len(numbers), 1))
    if (np.abs(joint.numbers("position", numbers)) > least).any():
        for axis, column in joint.columns("position").items():
            positions[:, "xyz".index(axis)] = share * joint.offset["xyz".index(axis)] + numbers[:, column]
    return positions


def _rotation(joint: Joint, numbers: np.ndarray) -> Rotation | None:
    """The rotations of a joint; None if it has none."""
    angles = joint.numbers("rotation", numbers)
    if not angles.any():
        return None
    return Rotation.from_euler("".join(joint.columns("rotation")).upper(), angles, degrees=True)
