"""Reader of Biovision hierarchy (BVH) files.

A joint's channels rotate its children, so a bone's offset is given in the axes of the joint at its near end. Euler
angles are intrinsic in the order in which the joint lists its channels: R = R_1 · R_2 · R_3. The root's channels are
the global position and orientation, which are not part of a pose.
"""

from typing import Literal, cast

import numpy as np

from skpose._validation.motions import check_frame_rate
from skpose._validation.options import check_choice, check_positive
from skpose.io._arguments import Readable
from skpose.io._hierarchy import Joint, Lexer, read_hierarchy, read_motion_head
from skpose.io._numbers import drop_not_finite, in_words, read_numbers
from skpose.io._offsets import bone_offsets, longest_bone
from skpose.io._rates import choose_rate, complaint_of_frame_time
from skpose.io._root import choose_root, root_movement
from skpose.io._source import Source
from skpose.io._up import Up, check_up_of_file, stand
from skpose.io._words import Token
from skpose.skeleton import Bone, Motion, Skeleton


def load_bvh(
    path: Readable,
    *,
    frame_rate: float | None = None,
    scale: float = 1.0,
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
        Frames per second, Hz. None is the file's own, by its Frame Time. A number comes before it, with a warning where
        they differ by more than 1 %; the poses are the same, see `Motion.resample` for others.
    scale : float, default=1.0
        Metres per unit of length. The format has no unit: 0.01 for files in centimetres, 0.0254 for inches.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite: refuse the file, or leave these frames out. The
        others keep their numbers and times, see `Motion.frame_numbers`.
    trust : {"header", "rows"}, default="header"
        Source of the number of frames: the count after ``Frames:``, and a file with more or fewer is refused; or as
        many whole frames as the file has. Where most lines hold one frame each, the others are left out as lines, so
        that a number that is missing in one does not shift those after it.
    stretch : {"raise", "mean"}, default="raise"
        What to do with a file that moves joints besides the root by position channels, as bones of a skeleton have
        constant lengths: refuse it, or give those bones the mean of their positions.
    root : str, default=None
        Name of the joint that is the root of the skeleton. Joints above it are left out, and their movement is part of
        the root's. None is the first joint, ROOT; but if that stands still and has a single child, which position
        channels move, it is that child, also through several such joints.
    root_offset : {"replace", "add"}, default="replace"
        What the position channels of ROOT do with its OFFSET: replace it, as those of other joints do, or are added to
        it, as the format's first description has it. See Notes.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The direction of the file's world that points up. None is y, as is usual, with a warning where poses stand along
        another axis. Where an axis points down the world is turned by half a turn, so that `Motion.up` is an axis:
        about x if y or z points down, about y if x does.

    Returns
    -------
    Motion
        Motion whose skeleton has a joint for every JOINT and every End Site (named after its parent, with "_end")
        below the root. Angles are those of the file, in rad, also past 360°; see `Motion.unwrap`.

    Raises
    ------
    MocapFormatError
        If the file is not a whole BVH file; with its name, the line and the column.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If several joints have one name: all but the first get a number. If position channels differ from the OFFSET of
        their joint. If frames, or joints that are not below `root`, are left out. If the skeleton has not the size of a
        person, 0.3 to 5 m from end to end at angle zero: the message names the `scale` that would give it. If no `up`
        is given, and in nearly all frames the pose stands along another axis than y, or the joints with "head" in their
        names are below those with "foot", "toe" or "ankle". If the file states another frame rate than the one that is
        given, or less than 2 or more than 2,000 frames a second: the message names the rates that may be meant.

    See Also
    --------
    save_bvh : Write a BVH file.
    load_motion : Read a BVH or an AMC file.

    Notes
    -----
    Rotations are intrinsic in the order in which each joint lists them. Keywords may be in either case, and lines may
    end anywhere except in a name, which is the rest of its line.

    Position channels replace the OFFSET of their joint, as the programs that write them (MotionBuilder, Blender) mean
    them: those of ROOT are its position, constant ones of another joint are the bone's offset. Where all of another
    joint are at most 0.1 % of the longest bone, its OFFSET is kept. The format's first description [1]_ adds ROOT's
    OFFSET to its channels; of 419 public files in which that makes a difference, 414 have the feet on the floor without
    it, and 5 with it.

    Cost: 140 MB a second where equally many digits stand after each point, as most programs write them, and 40 to 60
    otherwise. Memory is at most some 2.2 times that of the array.

    References
    ----------
    .. [1] J. Lander, "Working with motion capture file formats", Game Developer, January 1998.

    Examples
    --------
    >>> from skpose.io import load_bvh
    >>> load_bvh("dance.bvh", scale=0.01)  # doctest: +SKIP
    Motion(1200 frames at 60 Hz, 20.0 s, y up, Skeleton(n_joints=52, n_dofs=114))
    """
    with Source(path, "a BVH file") as source:
        return read_bvh(
            source,
            frame_rate=frame_rate,
            scale=scale,
            on_nan=on_nan,
            trust=trust,
            stretch=stretch,
            root=root,
            root_offset=root_offset,
            up=up,
        )


def read_bvh(
    source: Source,
    *,
    frame_rate: float | None = None,
    scale: float = 1.0,
    on_nan: str = "raise",
    trust: str = "header",
    stretch: str = "raise",
    root: str | None = None,
    root_offset: str = "replace",
    up: Up | None = None,
) -> Motion:
    """Read the motion of an open BVH file."""
    if frame_rate is not None:
        check_frame_rate(frame_rate)
    check_positive("scale", scale)
    check_choice("on_nan", on_nan, ("raise", "drop"))
    check_choice("trust", trust, ("header", "rows"))
    check_choice("stretch", stretch, ("raise", "mean"))
    check_choice("root_offset", root_offset, ("replace", "add"))
    check_up_of_file(up)
    lexer = Lexer(source)
    joints = read_hierarchy(lexer)
    claimed, frame_time = read_motion_head(lexer)
    width = sum(len(joint.channels) for joint in joints)
    rate = _rate_of(source, frame_time, frame_rate)
    numbers, frame_numbers = _read_rows(lexer, width, claimed, trust, on_nan)
    if frame_rate is None and len(numbers) > 1 and (complaint := complaint_of_frame_time(1.0 / rate)):
        source.warn(complaint)

    with source.format_errors():
        names: dict[Joint | None, str] = dict(zip(joints[1:], _unique_names(joints[1:], source), strict=True))
        chain, below = choose_root(joints, numbers, root, names, source)
        _check_moves(joints, chain[-1], below, source)
        offsets = bone_offsets(below, numbers, source, stretch)
        positions, axes, angles = root_movement(chain, numbers, longest_bone(below, numbers), root_offset)
        parents = {**names, chain[-1]: None}
        bones = [
            Bone(names[joint], parents[joint.parent], offset, "".join(joint.columns("rotation")).upper())
            for joint, offset in zip(below, scale * offsets, strict=True)
        ]
        skeleton = Skeleton(bones, offset_frame="parent")
        source.warn_of_size(skeleton, scale)
        motion = Motion(
            skeleton,
            _radians(numbers, [column for joint in below for column in joint.columns("rotation").values()]),
            rate,
            scale * positions,
            angles,
            axes,
            frame_numbers,
            root_name=chain[-1].name,
        )
    return stand(motion, up, source)


def _check_moves(joints: list[Joint], root: Joint, below: list[Joint], source: Source) -> None:
    """Raise an error unless a joint below the root can be rotated."""
    if not any(joint.columns("rotation") for joint in below):
        others = any(joint.columns("rotation") for joint in joints[1:])
        raise source.error(
            f"expected joints with rotation channels below the root {root.name!r}, found none: without a degree of "
            f"freedom there is no pose; {'choose another root=' if others else 'export all joints of the skeleton'}",
            root.opened,
        )


def _rate_of(source: Source, word: Token, given: float | None) -> float:
    """Return the frame rate, Hz, by the word after "Frame Time:", or the one that is given."""
    seconds = source.number(word, "Frame Time", finite=False)
    if given is None and not (seconds > 0 and np.isfinite(seconds) and np.isfinite(1.0 / seconds)):
        raise source.error(
            f"Frame Time: expected a positive number, found {str(word)!r}; frame_rate= chooses the rate", word
        )
    if given is not None and not seconds > 0:
        return given
    return choose_rate(source, given, 1.0 / seconds, "Frame Time")


def _read_rows(lexer: Lexer, width: int, claimed: Token, trust: str, on_nan: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (n_frames, width) after the head of MOTION, and the numbers of these frames, from 0."""
    source = lexer.source
    if width == 0:
        raise source.error("no joint has CHANNELS, so nothing moves; is the file cut short?")
    n_frames, counts, finite = int(claimed), list[int](), on_nan == "raise"
    if trust == "rows":
        numbers = read_numbers(source, lexer.rest(), width, None, finite=finite, counts=counts)
    else:
        numbers = read_numbers(source, lexer.rest(), width, n_frames, finite=finite)
    frames = None
    if len(numbers) != n_frames * width:
        if trust == "header":
            raise source.error(
                f"expected {in_words(n_frames * width, width)}, found {in_words(len(numbers), width)}; is the file cut "
                "short? trust='rows' reads the whole frames that there are",
                claimed,
            )
        # The rest of the line of "Frame Time:", if there is any, is a line of its own.
        numbers, frames = _by_line(numbers, counts, source.line - len(counts) + 1, width, source)
    rows = numbers[: len(numbers) // width * width].reshape(-1, width)
    frames = np.arange(len(rows)) if frames is None else frames
    return (rows, frames) if finite else drop_not_finite(rows, frames, source)


def _by_line(
    numbers: np.ndarray, counts: list[int], first: int, width: int, source: Source
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return the numbers of the lines that hold one frame, and which of all lines these are.

    Where such lines are not the majority, a line is no frame: all numbers and None.
    """
    lines = np.flatnonzero(counts)
    count = np.array(counts)[lines]
    whole = count == width
    if 2 * np.count_nonzero(whole) <= len(lines):
        if left := len(numbers) % width:
            source.warn(f"the last frame has {left} of {width} numbers and is left out")
        return numbers, None
    if not whole.all():
        at = int(np.argmin(whole))
        source.warn(
            f"{np.count_nonzero(~whole)} of {len(lines)} lines of numbers are left out, as they are not one frame: "
            f"line {first + lines[at]} has {count[at]} numbers, not {width}"
        )
    return numbers[np.repeat(whole, count)], np.flatnonzero(whole)


def _radians(numbers: np.ndarray, columns: list[int]) -> np.ndarray:
    angles = numbers[:, columns]
    return np.radians(angles, out=angles)


def _unique_names(joints: list[Joint], source: Source) -> list[str]:
    """Return a different name for each joint: the first of a name keeps it; End Sites have none in the file."""
    names: dict[str, Joint] = {}
    for joint in joints:
        if joint.name:
            names.setdefault(joint.name, joint)
    counts: dict[str, int] = {}
    unique: dict[Joint | None, str] = {joint: name for name, joint in names.items()}
    repeated: list[str] = []  # warnings on joints that have another's name
    for joint in joints:
        if joint not in unique:
            parent = cast(Joint, joint.parent)  # only the root, which is not among the joints, has none
            stem = name = joint.name or f"{unique.get(parent, parent.name)}_end"
            while name in names:
                counts[stem] = counts.get(stem, 1) + 1
                name = f"{stem}_{counts[stem]}"
            if joint.name:
                lines = f"{names[stem].opened.line} and {joint.opened.line}"
                repeated.append(f"joints in lines {lines} are both named {stem!r}; the second is {name!r} here")
            names[name], unique[joint] = joint, name
    if repeated:
        source.warn(repeated[0] + (f", and {len(repeated) - 1} more likewise" if len(repeated) > 1 else ""))
    return [unique[joint] for joint in joints]
