"""Biovision hierarchy (BVH) files.

A joint's channels rotate its children, so a bone's offset is given in the axes of the joint at its near end. Euler
angles are intrinsic in the order in which the joint lists its channels: R = R_1 · R_2 · R_3. The root's channels are
the global position and orientation, which are not part of a pose.
"""

import re
from collections import Counter
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, Literal, cast

import numpy as np
from scipy.spatial.transform import Rotation

from skpose._utils.files import new_file
from skpose._utils.units import complaint_of_size, likely_scale
from skpose._utils.validation import check_choice, check_kind, check_positive, list_names
from skpose.io._conventions import (
    FASTEST,
    SLOWEST,
    Up,
    check_even,
    check_options,
    choose_rate,
    quarter_turn,
    stand,
    unused_name,
    warn_of_renamed,
)
from skpose.io._source import PathLike, Readable, Source, Token, drop_not_finite, open_source, read_numbers
from skpose.keypoints._fit import is_of_layout
from skpose.skeleton import Bone, Motion, Skeleton
from skpose.skeleton._bone import is_axes
from skpose.skeleton._rest import positions_at_zero, size_of
from skpose.skeleton._root import root_orientations
from skpose.skeleton._rotations import continuous_triples, rotations_of

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


# --- writer -----------------------------------------------------------------------------------------------------------


DIGITS = 9  # after the point: far below the precision of mocap; no exponents, which some programs cannot read
PARALLEL = 1e-12  # axes that differ by less are the root's
STANDS = 1.3  # times as high as it is deep or wide: a skeleton that stands; arms that are held out are as wide as high


def save_bvh(path: PathLike, motion: Motion, *, scale: float = 1.0, up: Literal["x", "y", "z"] = "y") -> None:
    """Write a motion as a BVH file, which Blender and most other programs open.

    Parameters
    ----------
    path : str or path-like
        The file, which must not exist yet. It is written whole or not at all.
    motion : Motion
        The motion to write. The path of a `geodesic`, a mean or other poses become one as
        ``Motion(skeleton, poses, frame_rate)``.
    scale : float, default=1.0
        Metres per unit of length in the file: 1 writes metres, 0.01 centimetres.
    up : {"x", "y", "z"}, default="y"
        The axis of the file's world that points up. The format does not state it, and programs take y. A motion in
        which another axis points up, `Motion.up`, is turned by a quarter turn of the world, so that people stand in the
        file as they do here; ``up=motion.up`` writes it as it is.

    Raises
    ------
    ValueError
        If a joint's name cannot be written in the format, or frames are missing, see `Motion.frame_numbers`: the format
        has one time between frames.
    OSError
        If it exists, or cannot be written.

    See Also
    --------
    load_bvh : Read a BVH file.

    Notes
    -----
    Joints, offsets and angles of a skeleton that came from a BVH file are written as they are, to nine digits after
    the point, and the root has its name, with an underscore where a joint has it too. A joint with one or two dofs gets
    channels for all three axes, the others zero: Blender refuses files with fewer. A ball joint gets three angles in
    the order ZYX, which BVH has instead of rotation vectors: positions are the same. Of the angles that are one
    rotation it gets those that change least from frame to frame.

    In an ASF skeleton, and any other with offsets in the joints' "own" axes, a joint rotates the bone that *ends* at
    it; in a BVH file it rotates the bones that *start* at it. So the BVH joint with a bone's name is at the bone's near
    end, and the bone's far end is the position of its children, or an End Site. Every joint then has three angles,
    about the root's axes, in the order ZYX: positions are the same, numbers and degrees of freedom are not. A skeleton
    of `fit_skeleton` has names of points, and its BVH joints are at these points; where several bones start, as at the
    neck, there is one more joint for each, such as ``neck_turn``.

    Where the world is turned, all positions of the root are, and its orientation has three angles, the first about the
    axis that points up. Heights, tilts and headings stay, as do the poses.

    The format has no weights: those of `Skeleton.with_weights` are not written. Nor does it state that poses were
    fitted to positions, which do not show how limbs are twisted (`Motion.fitted`): where that matters, as in
    `joint_angles`, use `save_npz`, or state it again by ``dataclasses.replace(motion, seen=True)``.

    Examples
    --------
    >>> from skpose import Motion, Skeleton, geodesic
    >>> from skpose.io import load_bvh, save_bvh
    >>> arm = Skeleton.chain(3)
    >>> path = geodesic([0, 0, 0], [0.5, 1, 1.5], arm).path
    >>> save_bvh("reach.bvh", Motion(arm, path, frame_rate=10))  # doctest: +SKIP
    """
    check_kind(motion, Motion, "motion", "Motion(skeleton, poses, frame_rate) makes one of poses")
    check_positive("scale", scale)
    check_choice("up", up, ("x", "y", "z"))
    is_own = motion.skeleton.offset_frame == "own"
    motion, turn = _stand(at_joints(motion), up)
    skeleton = motion.skeleton
    if slides := [bone.name for bone in skeleton.bones if bone.is_slide]:
        raise ValueError(
            f"joint {slides[0]!r} slides, and BVH files have rotations alone: save_npz and save_csv keep it"
        )
    for name in (motion.root_name, *skeleton.joint_names):
        if name != name.strip() or set(name) & set("{}\r\n"):
            raise ValueError(f"joint {name!r} cannot be written: BVH has names of one line, without braces")
    check_even(motion, "BVH has")
    lines, columns = _hierarchy(motion, turn, scale, is_own)
    lines += ["MOTION", f"Frames: {len(motion)}"]
    lines += [f"Frame Time: {np.format_float_positional(1.0 / motion.frame_rate, trim='-')}", ""]
    with new_file(path) as new, new.open("w", encoding="utf-8", newline="\n") as file:
        file.write("\n".join(lines))
        np.savetxt(file, np.concatenate(columns, axis=1), fmt=f"%.{DIGITS}f")


def at_joints(motion: Motion) -> Motion:
    """The motion with its joints where they rotate, as in BVH and SMPL, and with the ends of the last bones."""
    skeleton = motion.skeleton
    if is_of_layout(skeleton):
        return _at_points(motion)
    if skeleton.offset_frame == "parent":
        return motion
    offsets = dict(zip([None, *skeleton.joint_names], np.insert(skeleton.offsets, 0, 0.0, axis=0), strict=True))
    bones = [bone._replace(offset=offsets[bone.parent]) for bone in skeleton.bones]
    for name in skeleton.joint_names:
        if all(bone.parent != name for bone in skeleton.bones):
            bones.append(Bone(unused_name(f"{name}_end", skeleton.joint_names, ()), name, offsets[name]))
    return replace(motion, skeleton=Skeleton(bones, "parent"), seen=None)


def _at_points(motion: Motion) -> Motion:
    """The motion of a fitted skeleton with a joint at each point, which rotates the bones that start there.

    Where several bones start, each that rotates has one more joint. Joints that rotate none have angles of zero.
    """
    root, *bones = motion.skeleton.bones
    children = {name: [bone for bone in bones if bone.parent == name] for name in motion.skeleton.joint_names}
    columns = motion.skeleton.dof_names
    joints, angles = list[Bone](), list[np.ndarray]()

    def add(name: str, parent: str, offset: Any, turned: Bone | None) -> None:
        dofs, rest = ("ZYX", None) if turned is None else (turned.dofs, turned.rest_rotation)
        joints.append(Bone(name, None if parent == root.name else parent, offset, dofs, rest))
        numbers = [] if turned is None else [motion.angles[:, columns.index(dof)] for dof in turned.dof_names]
        angles.extend(numbers or [np.zeros(len(motion))] * 3)

    for bone in bones:
        parent = str(bone.parent)
        if bone.dofs and (parent == root.name or len(children[parent]) > 1):
            used = {*children, *(joint.name for joint in joints)}
            add(unused_name(f"{parent}_turn", used, ()), parent, (0.0, 0.0, 0.0), bone)
            parent = joints[-1].name
        only = [child for child in children[bone.name] if child.dofs and len(children[bone.name]) == 1]
        add(bone.name, parent, bone.offset, next(iter(only), None))
    skeleton = Skeleton(joints, "parent")
    return replace(motion, skeleton=skeleton, angles=np.stack(angles, axis=1), root_name=root.name, seen=None)


def _stand(motion: Motion, up: Literal["x", "y", "z"]) -> tuple[Motion, np.ndarray]:
    """The motion in a world in which the axis points up, and what the root's own axes are turned by.

    The world is turned by a quarter turn. The root's own axes stay, so that the skeleton does. They are turned with the
    world if the skeleton stands along the motion's vertical at angle zero: then it stands in the file, too.
    """
    if motion.up == up:
        return motion, np.eye(3)
    before, after = "xyz".index(motion.up), "xyz".index(up)
    about = "xyz"[3 - before - after]
    matrix = quarter_turn(motion.up, up)
    turn = Rotation.from_matrix(matrix)
    extent = np.ptp(positions_at_zero(motion.skeleton), axis=0)
    own = matrix if extent[before] > STANDS * extent[after] else np.eye(3)
    # Heading first, and last the axis of the quarter turn: the angle between them is a lean to a side, far from 90°, at
    # which three angles are degenerate, whether or not the root's own axes are turned.
    axes, angles, positions = f"{up}{motion.up}{about}".upper(), np.zeros((0, 3)), motion.root_positions
    if len(motion):
        orientations = turn * root_orientations(motion.root_angles, motion.root_axes)
        angles = continuous_triples(axes, orientations * Rotation.from_matrix(own.T))
        positions = positions @ matrix.T
    return replace(motion, root_positions=positions, root_angles=angles, root_axes=axes, up=up), own


def _hierarchy(motion: Motion, turn: np.ndarray, scale: float, is_full: bool) -> tuple[list[str], list[np.ndarray]]:
    """The lines of the hierarchy, and the columns of its channels.

    `turn`, a rotation matrix of zeros and ones, is what the own axes of the root and of all joints are turned by.
    `is_full` is whether rigid joints have channels.
    """
    skeleton = motion.skeleton
    bones: dict[str | None, Bone] = dict(zip(skeleton.joint_names, skeleton.bones, strict=True))
    children: dict[str | None, list[str]] = {name: [] for name in (None, *bones)}
    first = dict(zip(bones, np.cumsum([0, *(bone.n_dofs for bone in bones.values())]), strict=False))
    # Axes of each joint at angle zero, in those of the root; in BVH all joints' axes are parallel at angle zero.
    rest: dict[str | None, np.ndarray] = {None: turn}
    for bone, rotation in zip(skeleton.bones, skeleton.rest_rotations, strict=True):
        children[bone.parent].append(bone.name)
        rest[bone.name] = rest[bone.parent] @ rotation

    def write(depth: int, *texts: str) -> None:
        lines.extend("\t" * depth + text for text in texts)

    root, lines = motion.root_name, ["HIERARCHY"]
    while root in bones:
        root += "_"
    axes, angles = _intrinsic(motion.root_axes, motion.root_angles)
    columns = [motion.root_positions / scale, np.degrees(angles)]
    write(0, f"ROOT {root}", "{")
    write(1, "OFFSET 0 0 0", _channels(["Xposition", "Yposition", "Zposition"], axes))
    stack: list[tuple[int, str | None]] = [(0, None), *((1, name) for name in reversed(children[None]))]
    while stack:  # no recursion: a chain may be longer than Python's stack
        depth, name = stack.pop()
        if name is None:
            write(depth, "}")
            continue
        bone = bones[name]
        # A joint that the reader makes of an End Site.
        is_end = not bone.dofs and not children[name] and name.startswith(f"{bone.parent}_end")
        write(depth, "End Site" if is_end else f"JOINT {name}", "{")
        offset = rest[bone.parent] @ bone.offset / scale  # in axes that are parallel to the root's at angle zero
        write(depth + 1, "OFFSET " + " ".join(f"{x:.{DIGITS}f}" for x in offset))
        if not is_end:
            angles = motion.angles[:, first[name] : first[name] + bone.n_dofs]
            about_axes = is_axes(bone.dofs) and np.allclose(rest[name], turn, rtol=0, atol=PARALLEL)
            if about_axes and (bone.dofs or not is_full):
                axes, angles = _turn_axes(*_intrinsic(bone.dofs, angles), turn)
            else:
                axes, angles = _about_root(bone, angles, rest[name])
            write(depth + 1, _channels([], axes))
            columns.append(np.degrees(angles))
        stack += [(depth, None), *((depth + 1, child) for child in reversed(children[name]))]
    return lines, columns


def _channels(positions: list[str], axes: str) -> str:
    names = [*positions, *(f"{axis}rotation" for axis in axes)]
    return " ".join(["CHANNELS", str(len(names)), *names])


def _intrinsic(dofs: str, angles: np.ndarray) -> tuple[str, np.ndarray]:
    """The same rotations as intrinsic ones about three axes, zero about those added; none stay none."""
    axes, angles = (dofs[::-1].upper(), angles[:, ::-1]) if dofs.islower() else (dofs, angles)
    more = [axis for axis in "ZXY" if axis not in axes] if axes else []
    return "".join([axes, *more]), np.concatenate([angles, np.zeros((len(angles), len(more)))], axis=1)


def _turn_axes(axes: str, angles: np.ndarray, turn: np.ndarray) -> tuple[str, np.ndarray]:
    """Intrinsic rotations about axes that are turned, each to another one or to its opposite."""
    columns = turn[:, ["XYZ".index(axis) for axis in axes]].T  # (n_axes, 3)
    turned = "".join("XYZ"[i] for i in np.abs(columns).argmax(axis=1))
    return turned, angles if turned == axes else angles * columns.sum(axis=1)


def _about_root(bone: Bone, angles: np.ndarray, axes: np.ndarray) -> tuple[str, np.ndarray]:
    """A joint's rotations as three intrinsic ones about the axes of the root, continuous in time."""
    if not angles.size:  # no frames, or a rigid joint
        return "ZYX", np.zeros((len(angles), 3))
    to_root = Rotation.from_matrix(axes)
    return "ZYX", continuous_triples("ZYX", to_root * rotations_of(bone, angles) * to_root.inv())
