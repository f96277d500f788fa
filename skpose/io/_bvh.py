"""Reader of Biovision hierarchy (BVH) files.

A joint's channels rotate its children, so a bone's offset is given in the axes of the joint at its near end. Euler
angles are intrinsic in the order in which the joint lists its channels: R = R_1 · R_2 · R_3. The root's channels are
the global position and orientation, which are not part of a pose.
"""

from typing import Literal, cast

import numpy as np

from skpose.io._arguments import Readable, check_choice, check_positive
from skpose.io._hierarchy import Joint, Lexer, read_hierarchy, read_motion_head
from skpose.io._numbers import read_numbers
from skpose.io._source import Source
from skpose.io._words import Token
from skpose.skeleton import Bone, Motion, Skeleton

# Variation of a constant position by rounding to the printed digits, at most; as a fraction of the longest bone.
ROUNDING = 1e-4


def load_bvh(
    path: Readable,
    *,
    scale: float = 1.0,
    on_nan: Literal["raise", "drop"] = "raise",
    trust: Literal["header", "rows"] = "header",
    stretch: Literal["raise", "mean"] = "raise",
) -> Motion:
    """Read a skeleton and its motion from a BVH file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    scale : float, default=1.0
        Metres per unit of length. The format has no unit: 0.01 for files in centimetres, 0.0254 for inches.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite: refuse the file, or leave these frames out.
    trust : {"header", "rows"}, default="header"
        Source of the number of frames: the count after ``Frames:``, and a file with more or fewer is refused; or as
        many whole frames as the file has.
    stretch : {"raise", "mean"}, default="raise"
        What to do with a file that moves joints besides the root by position channels, as bones of a skeleton have
        constant lengths: refuse it, or give those bones the mean of their positions.

    Returns
    -------
    Motion
        Motion whose skeleton has a joint for every JOINT and every End Site (named after its parent, with "_end"); the
        ROOT is the root. Angles are those of the file, in rad, also past 360°; see `Motion.unwrap`.

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
        their joint. If `trust="rows"` leaves out a last frame that is not whole.

    See Also
    --------
    save_bvh : Write a BVH file.
    load_motion : Read a BVH or an AMC file.

    Notes
    -----
    Rotations are intrinsic in the order in which each joint lists them. Keywords may be in either case, and lines may
    end anywhere except in a name, which is the rest of its line.

    A root's OFFSET is added to its position channels, as the format's first description requires. Position channels of
    other joints replace their OFFSET, as the programs that write them (MotionBuilder, Blender) mean them: constant ones
    are the bone's offset, unless all are zero, as in files that do not use them.

    Cost: some 7 million numbers a second if all have equally many digits after the point, half of that otherwise.
    Memory is at most some 2.2 times that of the array.

    Examples
    --------
    >>> from skpose.io import load_bvh
    >>> load_bvh("dance.bvh", scale=0.01)  # doctest: +SKIP
    Motion(1200 frames at 60 Hz, 20.0 s, Skeleton(n_joints=52, n_dofs=114))
    """
    with Source(path, "a BVH file") as source:
        return read_bvh(source, scale=scale, on_nan=on_nan, trust=trust, stretch=stretch)


def read_bvh(
    source: Source, *, scale: float = 1.0, on_nan: str = "raise", trust: str = "header", stretch: str = "raise"
) -> Motion:
    """Read the motion of an open BVH file."""
    check_positive("scale", scale)
    check_choice("on_nan", on_nan, ("raise", "drop"))
    check_choice("trust", trust, ("header", "rows"))
    check_choice("stretch", stretch, ("raise", "mean"))
    lexer = Lexer(source)
    root, *joints = all_joints = read_hierarchy(lexer)
    claimed, frame_time = read_motion_head(lexer)
    width = sum(len(joint.channels) for joint in all_joints)
    limit = int(claimed) * width if trust == "header" else None
    numbers = read_numbers(source, lexer.rest(), limit, finite=on_nan == "raise")
    numbers = _frames(numbers, width, claimed, source, trust)
    if on_nan == "drop":
        finite = np.isfinite(numbers).all(axis=1)
        numbers = numbers if finite.all() else numbers[finite]

    with source.format_errors():
        names: dict[Joint | None, str] = dict(zip(joints, _unique_names(joints, source), strict=True))
        bones = [
            Bone(
                names[joint], names.get(joint.parent), tuple(scale * offset), "".join(joint.columns("rotation")).upper()
            )
            for joint, offset in zip(joints, _offsets(root, joints, numbers, source, stretch), strict=True)
        ]
        skeleton = Skeleton(bones, offset_frame="parent")
        positions = np.tile(root.offset, (len(numbers), 1))
        for axis, column in root.columns("position").items():
            positions[:, "xyz".index(axis)] += numbers[:, column]
        root_axes = root.columns("rotation")
        return Motion(
            skeleton,
            _radians(numbers, [column for joint in joints for column in joint.columns("rotation").values()]),
            1.0 / frame_time,
            scale * positions,
            _radians(numbers, [*root_axes.values()]),
            "".join(root_axes).upper(),
        )


def _frames(numbers: np.ndarray, width: int, claimed: Token, source: Source, trust: str) -> np.ndarray:
    """Return the numbers as (n_frames, width), if there are as many as there should be."""
    if width == 0:
        raise source.error("no joint has CHANNELS, so nothing moves; is the file cut short?")
    whole, left = divmod(len(numbers), width)
    if trust == "rows":
        if left:
            source.warn(f"the last frame has {left} of {width} numbers and is left out")
        numbers = numbers[: whole * width]
    elif len(numbers) != int(claimed) * width:
        raise source.error(
            f"expected {int(claimed) * width} numbers, {width} for each of {claimed} frames, found {len(numbers)}; is "
            "the file cut short? trust='rows' reads the whole frames that there are",
            claimed,
        )
    return numbers.reshape(-1, width)


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


def _offsets(root: Joint, joints: list[Joint], numbers: np.ndarray, source: Source, stretch: str) -> np.ndarray:
    """Return the bones' offsets (n_joints, 3), in the file's unit: OFFSET, or the mean of the position channels."""
    stated = np.array([joint.offset for joint in joints]).reshape(-1, 3)
    offsets, vary, read = stated.copy(), np.zeros_like(stated), np.zeros_like(stated, dtype=bool)
    for i, joint in enumerate(joints):
        for axis, column in joint.columns("position").items():
            if len(numbers):
                at, values = (i, "xyz".index(axis)), numbers[:, column]
                offsets[at], vary[at], read[at] = values.mean(), np.ptp(values), True
    if not read.any():
        return stated
    rounding = ROUNDING * np.linalg.norm([*stated, *offsets], axis=1).max()
    moved = np.flatnonzero((vary > rounding).any(axis=1))
    if len(moved) and stretch == "raise":
        joint = joints[moved[0]]
        raise source.error(
            f"position channels move {joint} by up to {vary[moved[0]].max():g} units against {joint.parent} (and "
            f"{len(moved) - 1} joints more), but bones have constant lengths here; stretch='mean' takes the mean",
            joint.opened,
        )
    # Channels that are zero in every frame: a program writes them for every joint and does not use them.
    unused = ~((np.abs(offsets) > rounding) | (vary > rounding)).any(axis=1, where=read)
    offsets[unused] = stated[unused]
    elsewhere = (np.abs(offsets - stated) > rounding).any(axis=1) & stated.any(axis=1)
    elsewhere = np.setdiff1d(np.flatnonzero(elsewhere), moved)
    if len(elsewhere):
        first = elsewhere[0]
        source.warn(
            f"position channels replace the OFFSET of {len(elsewhere)} joints: {joints[first]}, "
            f"line {joints[first].opened.line}, at {_shown(offsets[first])}, not {_shown(stated[first])}"
        )
    return offsets


def _shown(vector: np.ndarray) -> str:
    return " ".join(f"{x:.6g}" for x in vector)
