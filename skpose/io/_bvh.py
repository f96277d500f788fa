"""Biovision hierarchy (BVH) files.

A joint's channels rotate its children, so a bone's offset is given in the axes of the joint at its near end. Euler
angles are intrinsic in the order in which the joint lists its channels: R = R_1 · R_2 · R_3. The root's channels are
the global position and orientation, which are not part of a pose.
"""

import re
from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal, cast

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.units import complaint_of_size, likely_scale
from skpose._utils.validation import list_names
from skpose.io._conventions import (
    FASTEST,
    SLOWEST,
    Up,
    check_options,
    choose_rate,
    stand,
    unused_name,
    warn_of_renamed,
)
from skpose.io._source import Readable, Source, Token, drop_not_finite, open_source, read_numbers
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._rest import size_of
from skpose.skeleton._rotations import continuous_triples

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
    *_, longest = _mean_offsets(joints[1:], numbers)
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


def _mean_offsets(joints: list[Joint], numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """OFFSETs (n_joints, 3), the same with the means of position channels in their place, and the longest of both."""
    stated = np.array([joint.offset for joint in joints]).reshape(-1, 3)
    offsets = stated.copy()
    for i, joint in enumerate(joints):
        for axis, column in joint.columns("position").items():
            if len(numbers):
                offsets[i, "xyz".index(axis)] = numbers[:, column].mean()
    return stated, offsets, float(np.linalg.norm([*stated, *offsets], axis=1).max(initial=0.0))


def bone_offsets(joints: list[Joint], numbers: np.ndarray, source: Source, stretch: str) -> tuple[np.ndarray, float]:
    """The bones' offsets (n_joints, 3), OFFSET or the mean of the position channels, and the longest bone."""
    stated, offsets, longest = _mean_offsets(joints, numbers)
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
    positions, above = _positions(chain[0], numbers, -1.0, 1.0 if root_offset == "add" else 0.0), Rotation.identity()
    for parent, joint in pairwise(chain):
        above *= _rotation(parent, numbers)
        positions += above.apply(_positions(joint, numbers, UNUSED * longest, 0.0))
    axes = "".join(chain[-1].columns("rotation")).upper()
    if not any(joint.numbers("rotation", numbers).any() for joint in chain[:-1]):
        return positions, axes, np.radians(chain[-1].numbers("rotation", numbers))
    axes = axes if len(axes) == 3 else "ZXY"
    return positions, axes, continuous_triples(axes, above * _rotation(chain[-1], numbers))


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


def _rotation(joint: Joint, numbers: np.ndarray) -> Rotation:
    """The rotations of a joint; one that is the identity if it has none."""
    angles = joint.numbers("rotation", numbers)
    if not angles.any():
        return Rotation.identity()
    return Rotation.from_euler("".join(joint.columns("rotation")).upper(), angles, degrees=True)


# --- bvh --------------------------------------------------------------------------------------------------------------


WORD = re.compile(rb"[{}]|[^\s{}]+")
# After MOTION; "Frames:12" and "Frames : 12" mean the same.
HEAD = re.compile(rb"\s*Frames\s*:?\s*(\d{1,18})\s+Frame\s+Time\s*:?\s*([^\s:]+)", re.IGNORECASE)
# Names may have blanks in them.
STATEMENT = re.compile(
    rb"(?:(?:ROOT|JOINT|END)[ \t]+(?P<name>[^\s{}][^{}\r\n]*+)\s*+\{"
    rb"|OFFSET\s+([^\s{}]+)\s+([^\s{}]+)\s+([^\s{}]+)(?P<more>(?:[ \t]+[-+.\deE]+)*)"
    rb"|CHANNELS\s+(?P<n>\d)(?P<channels>(?:\s+[xyz](?:position|rotation)(?![^\s{}]))*)"
    rb"|MOTION(?![^\s{}])|\})",
    re.IGNORECASE,
)


def load_bvh(
    path: Readable,
    *,
    frame_rate: float | None = None,
    scale: float | Literal["auto"] = 1.0,
    on_nan: Literal["raise", "drop"] = "raise",
    trust: Literal["header", "rows"] = "header",
    stretch: Literal["raise", "mean"] = "raise",
    root: str | None = None,
    root_offset: Literal["replace", "add"] = "replace",
    up: Up | None = None,
) -> Motion:
    """Read a skeleton and its motion from a BVH file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    frame_rate : float, default=None
        Frames per second, Hz. By default 1 / Frame Time; a number replaces it, with a warning if the two differ by more
        than 1 %.
    scale : float or "auto", default=1.0
        Metres per unit of length. The format has no unit: 0.01 for files in centimetres, 0.0254 for inches. "auto" is 1
        if the skeleton is then between 0.3 and 5 m from end to end, else the unit with which it is nearest to 1.7 m.
    on_nan : {"raise", "drop"}, default="raise"
        Refuse a file with NaN or infinite numbers, or leave these frames out. The other frames keep their numbers and
        times, see `Motion.frame_numbers`.
    trust : {"header", "rows"}, default="header"
        Refuse a file with another number of frames than it states, or read the whole frames that it has.
    stretch : {"raise", "mean"}, default="raise"
        Refuse a file whose position channels change the length of a bone, or take the mean.
    root : str, default=None
        Name of the joint that becomes the root of the skeleton. Joints that are not below it are left out; the movement
        of those above it is part of the root's. By default it is the first joint, ROOT; if that stands still and has a
        single child, which position channels move, it is that child.
    root_offset : {"replace", "add"}, default="replace"
        Whether the position channels of ROOT replace its OFFSET or are added to it.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis of the file's world that points up. By default y, with a warning if poses stand along another axis. If
        an axis points down, the world is turned by half a turn: about x for y and z, about y for x.

    Returns
    -------
    Motion
        Motion whose skeleton has a joint for every JOINT and every End Site (named after its parent, with "_end")
        below the root. Angles are those of the file, in rad, also past 360°; see `Motion.unwrap`.

    Raises
    ------
    MocapFormatError
        If the file is not a complete BVH file; with its name, line and column.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If several joints have one name, position channels differ from an OFFSET, frames or joints are left out, the
        skeleton is not of the size of a person, people stand along another axis than y, or the frame rate is unlikely
        or replaced.

    See Also
    --------
    save_bvh : Write a BVH file.
    load_motion : Read a motion of any format.

    Notes
    -----
    Rotations are intrinsic in the order in which each joint lists them.

    Position channels replace the OFFSET of their joint, as the programs that write them (MotionBuilder, Blender) mean
    them. If all of a joint are at most 0.1 % of the longest bone, its OFFSET is kept. The format's first description
    [1]_ adds ROOT's OFFSET to its channels; of 419 public files in which that makes a difference, 414 have the feet on
    the floor without it, and 5 with it.

    The file is read into memory as a whole.

    References
    ----------
    .. [1] J. Lander, "Working with motion capture file formats", Game Developer, January 1998.

    Examples
    --------
    >>> from skpose.io import load_bvh
    >>> load_bvh("dance.bvh", scale=0.01)  # doctest: +SKIP
    Motion(1200 frames at 60 Hz, 20.0 s, y up, Skeleton(n_joints=52, n_dofs=114))
    """
    check_options(
        frame_rate=frame_rate, scale=scale, on_nan=on_nan, trust=trust, stretch=stretch, root_offset=root_offset, up=up
    )
    source = open_source(path, "a BVH file")
    joints, start = _read_hierarchy(source)
    head = HEAD.match(source.data, start)
    if head is None:
        word = _next_word(source, start, "Frames:")
        raise source.error(f"expected Frames: and Frame Time: after MOTION, found {word[:40]!r}", word)
    claimed, frame_time = Token(head, 1), Token(head, 2)
    seconds = source.number(frame_time, "Frame Time", finite=False, nan=True)
    stated = 1.0 / seconds if seconds > 0.0 else np.nan
    if frame_rate is None and not 0.0 < stated < np.inf:
        raise source.error(f"Frame Time: expected a positive number, found {frame_time}: pass frame_rate=", frame_time)
    rate = choose_rate(source, frame_rate, stated, "Frame Time")
    n_channels = sum(len(joint.channels) for joint in joints)
    numbers, frames = _read_rows(source, head.end(), n_channels, claimed, trust, on_nan)
    if frame_rate is None and len(numbers) > 1 and not SLOWEST <= rate <= FASTEST:
        source.warn(f"Frame Time is {seconds:g}, {rate:.3g} frames a second: is it in seconds? pass frame_rate=")
    with source.format_errors():
        names = _unique_names(joints[1:], source)
        chain, below = choose_root(joints, numbers, root, names, source)
        if not any(joint.columns("rotation") for joint in below):
            raise source.error(f"expected rotation channels below the root {chain[-1]}, found none", chain[-1].opened)
        offsets, longest = bone_offsets(below, numbers, source, stretch)
        positions, axes, angles = root_movement(chain, numbers, longest, root_offset)
        parents: dict[Joint | None, str] = {joint: name for joint, name in names.items() if joint is not chain[-1]}

        def skeleton_of(scale: float) -> Skeleton:
            bones = [
                Bone(names[joint], parents.get(joint.parent), offset, "".join(joint.columns("rotation")).upper())
                for joint, offset in zip(below, scale * offsets, strict=True)
            ]
            return Skeleton(bones, offset_frame="parent")

        scale = likely_scale(size_of(skeleton_of(1.0))) if scale == "auto" else scale
        skeleton = skeleton_of(scale)
        source.warn(complaint_of_size(size_of(skeleton), scale))
        poses = numbers[:, [column for joint in below for column in joint.columns("rotation").values()]]
        motion = Motion(
            skeleton,
            np.radians(poses, out=poses),
            rate,
            scale * positions,
            angles,
            axes,
            frames,
            root_name=chain[-1].name,
        )
    return stand(motion, up, source)


def _next_word(source: Source, at: int, expected: str) -> Token:
    match = WORD.search(source.data, at)
    if match is None:
        end = source.data.rstrip().count(b"\n") + 1
        raise source.error(f"expected {expected}, found the end of the file; is it cut short?", end)
    return Token(match)


def _read_hierarchy(source: Source) -> tuple[list[Joint], int]:
    """The joints in the order of the file, the root first, and the byte after the word MOTION."""
    first, joints = _next_word(source, 0, "HIERARCHY"), list[Joint]()
    if first.upper() != "HIERARCHY":
        raise source.error(f"expected HIERARCHY, found {first[:40]!r}; not a BVH file?", first)
    joint, at = cast(Joint | None, None), first.at + len(first)  # the block that is open
    while True:
        expected = "MOTION, as a file has one skeleton" if joints else "ROOT"
        if joint is not None:
            expected = f"OFFSET and 3 numbers, CHANNELS, JOINT or End Site and {{, or }} in {joint}"
        word = _next_word(source, at, expected)
        keyword, match = word.upper(), STATEMENT.match(source.data, word.at)
        if match and keyword in ("ROOT", "JOINT", "END") and (joint is None and not joints) == (keyword == "ROOT"):
            joint = Joint("" if keyword == "END" else match["name"].decode(errors="replace").strip(), joint, word)
            joints.append(joint)
        elif match and keyword == "MOTION" and joints and joint is None:
            for before, one in pairwise(joints):
                one.first = before.first + len(before.channels)
            return joints, match.end()
        elif match and joint is not None and keyword == "OFFSET" and not joint.offset:
            joint.offset = [source.number(Token(match, group), f"OFFSET of {joint}") for group in (2, 3, 4)]
            if match["more"].strip(b" \t+-.0"):  # zeros, of a rotation, are left out
                raise source.error(f"OFFSET of {joint}: expected 3 numbers, found more", word)
        elif match and joint is not None and keyword == "CHANNELS" and not joint.channels:
            joint.channels = match["channels"].decode().lower().split()
            if not len({*joint.channels}) == len(joint.channels) == int(match["n"]):
                expected = "their number, and as many of Xposition … Zrotation, each once"
                raise source.error(f"CHANNELS of {joint}: expected {expected}", word)
        elif joint is not None and joint.offset and word == "}":
            joint = joint.parent
        else:
            found = source.data[word.at : word.at + 40].decode(errors="replace").split("\n")[0].strip()
            raise source.error(f"expected {expected}, found {found!r}", word)
        at = match.end() if match else word.at + 1


def _read_rows(
    source: Source, start: int, width: int, claimed: Token, trust: str, on_nan: str
) -> tuple[np.ndarray, np.ndarray]:
    """The numbers (n_frames, width) from a byte on, and the numbers of these frames, from 0."""
    if width == 0:
        raise source.error("no joint has CHANNELS, so nothing moves; is the file cut short?")
    numbers = read_numbers(source, start, finite=on_nan == "raise")
    frames = np.arange(len(numbers) // width)
    if len(numbers) != int(claimed) * width:
        if trust == "header":
            raise source.error(
                f"expected {claimed} frames of {width} numbers, found {len(numbers) / width:.6g}; "
                "trust='rows' reads the whole frames",
                claimed,
            )
        counts = np.array([count for line in source.data[start:].split(b"\n") if (count := len(line.split()))])
        is_frame = counts == width
        if 2 * np.count_nonzero(is_frame) > len(counts):  # a number that is missing in a line shifts no other line
            numbers, frames = numbers[np.repeat(is_frame, counts)], np.flatnonzero(is_frame)
        if left := counts.sum() - len(frames) * width:
            source.warn(f"{left} numbers that are not a whole frame of {width} are left out")
    return drop_not_finite(numbers[: len(frames) * width].reshape(-1, width), frames, source)


def _unique_names(joints: list[Joint], source: Source) -> dict[Joint, str]:
    """A different name for each joint: the first of a name keeps it; End Sites have none in the file."""
    unique, used, reserved = dict[Joint, str](), dict[str, str](), {joint.name for joint in joints}
    for joint in joints:
        parent = cast(Joint, joint.parent)  # only the root, which is not among the joints, has none
        name = joint.name or unused_name(f"{unique.get(parent, parent.name)}_end", {*used, *reserved}, ())
        unique[joint] = unused_name(name, used, reserved)
        used[unique[joint]] = name
    warn_of_renamed(source, "joints", used)
    return unique
