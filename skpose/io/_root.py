"""The joint of a BVH file that is the root of the skeleton, and its movement.

It is the first joint, ROOT, unless the file has a reference above the skeleton: a joint that stands still and has one
child, which is moved by position channels.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from skpose.io._hierarchy import Joint
from skpose.io._offsets import ROUNDING, UNUSED, local_positions, longest_bone
from skpose.io._source import Source
from skpose.skeleton._shared import continuous_triples

MOST_NAMES = 40  # in a message


class Choice(NamedTuple):
    """The root of the skeleton, and the joints above and below it."""

    chain: list[Joint]  # from ROOT to the root of the skeleton
    below: list[Joint]  # the joints of the skeleton, in the order of the file


def choose_root(
    joints: list[Joint], numbers: np.ndarray, name: str | None, names: dict[Joint | None, str], source: Source
) -> Choice:
    """Return the joint of this name as the root, or, without a name, the one that carries the skeleton."""
    if name is None:
        chain = _find_reference_chain(joints, numbers)
        return Choice(chain, joints[len(chain) :])  # each joint of the chain is an only child
    named = {unique: joint for joint, unique in names.items() if joint is not None and joint.name}
    named[joints[0].name] = joints[0]
    if name not in named:
        known = ", ".join(map(repr, sorted(named)[:MOST_NAMES])) + f" and {len(named) - MOST_NAMES} more" * (
            len(named) > MOST_NAMES
        )
        raise source.error(f"root={name!r} is no joint of this file; expected one of {known}")
    chain = [named[name]]
    while (parent := chain[-1].parent) is not None:
        chain.append(parent)
    kept: set[Joint] = {chain[0]}
    for joint in joints:  # a parent comes before its children
        if joint.parent in kept:
            kept.add(joint)
    left = [str(joint) for joint in joints if joint not in kept and joint not in chain]
    if left:
        more = f" and {len(left) - 5} more" if len(left) > 5 else ""
        source.warn(f"root={name!r} leaves out {', '.join(left[:5])}{more}, which are not below it")
    return Choice(chain[::-1], [joint for joint in joints if joint in kept and joint is not chain[0]])


def _find_reference_chain(joints: list[Joint], numbers: np.ndarray) -> list[Joint]:
    """Return the chain from ROOT to the first joint that position channels move, if nothing above it moves."""
    root = joints[:1]
    if len(joints) < 2 or len(numbers) < 2 or not _is_still(joints[0], numbers, np.inf):
        return root
    n_children: dict[Joint | None, int] = {}
    for joint in joints:
        n_children[joint.parent] = n_children.get(joint.parent, 0) + 1
    longest = longest_bone(joints[1:], numbers)
    for i, joint in enumerate(joints[:-1]):
        child = joints[i + 1]
        if n_children.get(joint) != 1 or not child.name or not _is_still(joint, numbers, longest):
            return root
        positions = numbers[:, [*child.columns("position").values()]]
        if _varies(positions, ROUNDING * longest) and (np.abs(positions) > UNUSED * longest).any():
            return joints[: i + 2]
    return root


def _is_still(joint: Joint, numbers: np.ndarray, longest: float) -> bool:
    positions, angles = (numbers[:, [*joint.columns(kind).values()]] for kind in ("position", "rotation"))
    return not _varies(positions, ROUNDING * longest) and not _varies(angles, np.degrees(ROUNDING))


def _varies(values: np.ndarray, tolerance: float) -> bool:
    return bool((np.ptp(values, axis=0) > tolerance).any())


def root_movement(
    chain: list[Joint], numbers: np.ndarray, longest: float, root_offset: str
) -> tuple[np.ndarray, str, np.ndarray]:
    """Return positions (n_frames, 3) in the file's unit, axes and angles (n_frames, k) in rad of a chain's last joint.

    They are those of its own channels if nothing above it is moved or rotated, and its movement in space otherwise.
    Position channels of ROOT replace its OFFSET, or are added to it.
    """
    first, *more = chain
    positions = np.tile(first.offset, (len(numbers), 1))
    for axis, column in first.columns("position").items():
        start = positions[:, "xyz".index(axis)] if root_offset == "add" else 0.0
        positions[:, "xyz".index(axis)] = start + numbers[:, column]
    above: Rotation | None = None
    for parent, joint in zip(chain, more, strict=False):
        own = _rotation(parent, numbers)
        above = own if above is None else above if own is None else above * own
        local = local_positions(joint, numbers, longest)
        positions += local if above is None else above.apply(local)
    columns = chain[-1].columns("rotation")
    axes = "".join(columns).upper()
    if above is None:
        return positions, axes, np.radians(numbers[:, [*columns.values()]])
    axes = axes if len(axes) == 3 else "ZXY"
    own = _rotation(chain[-1], numbers)
    return positions, axes, continuous_triples(axes, above if own is None else above * own)


def _rotation(joint: Joint, numbers: np.ndarray) -> Rotation | None:
    """Return the rotations of a joint; None if it has none."""
    columns = joint.columns("rotation")
    angles = numbers[:, [*columns.values()]]
    if not angles.any():
        return None
    return Rotation.from_euler("".join(columns).upper(), angles, degrees=True)
