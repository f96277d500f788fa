"""Biovision hierarchy (BVH) files.

A joint's channels turn what hangs on it, so a bone's offset is given in the axes of the joint at its near end; Euler
angles are intrinsic in the order in which the joint lists its channels: R = R_1 · R_2 · R_3. The root's channels are
the body's global position and orientation and no part of a pose.
"""

from typing import Literal

import numpy as np

from skpose.io._hierarchy import Joint, Lexer, read_hierarchy, read_motion_head
from skpose.io._numbers import read_numbers
from skpose.io._source import Readable, Source, Token, check_choice, check_positive
from skpose.skeleton import Bone, Motion, Skeleton

# How much a position may vary, as a part of the longest bone, and still be one that printing has rounded.
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
        Metres per unit of length. The format has no unit: files in centimetres want 0.01, in inches 0.0254.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite: refuse the file, or leave them out.
    trust : {"header", "rows"}, default="header"
        Which to believe about the number of frames: what the file says after ``Frames:``, and refuse it if it has
        more or fewer; or what there is of whole frames.
    stretch : {"raise", "mean"}, default="raise"
        What to do with a file that moves joints besides the root by position channels, as bones of a skeleton have
        fixed lengths: refuse it, or give those bones the mean of their positions.

    Returns
    -------
    Motion
        Its skeleton has a joint for every JOINT and every End Site (named after the joint that it ends, with "_end"),
        the ROOT being the root. Angles are those of the file, in rad, also past 360°; see `Motion.unwrap`.

    Raises
    ------
    MocapFormatError
        If the file is not a whole BVH file; with its name, the line and the column.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If several joints have one name: all but the first get a number. If position channels put joints elsewhere
        than their OFFSET does. If `trust="rows"` leaves out a last frame that is not whole.

    See Also
    --------
    save_bvh : Write one.
    load_motion : Read BVH and AMC alike.

    Notes
    -----
    Rotations are intrinsic in the order in which each joint lists them. Keywords may be in either case, and lines may
    end anywhere but in a name, which is the rest of its line.

    A root's OFFSET is added to its position channels, as the format's first description has it. Position channels of
    other joints stand for their OFFSET, as the programs that write them (MotionBuilder, Blender) mean them: where they
    do not vary they are the bone's offset, unless all are zero, as where a file has them for nothing.

    The numbers take the time: some 7 million a second where all have as many digits after the point, half of it where
    they do not. Memory is at most some 2.2 times that of the array.

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
    """`load_bvh` of a source."""
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

    with source.blamed():
        names = dict(zip(joints, _unique_names(joints, source), strict=True))
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
    """The numbers as (n_frames, width), if there are as many as there should be."""
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
            "the file cut short? trust='rows' takes the whole frames that there are",
            claimed,
        )
    return numbers.reshape(-1, width)


def _radians(numbers: np.ndarray, columns: list[int]) -> np.ndarray:
    angles = numbers[:, columns]
    return np.radians(angles, out=angles)


def _unique_names(joints: list[Joint], source: Source) -> list[str]:
    """A name of its own for each joint: the first of a name keeps it; End Sites have none in the file."""
    names: dict[str, Joint] = {}
    for joint in joints:
        if joint.name:
            names.setdefault(joint.name, joint)
    counts: dict[str, int] = {}
    unique: dict[Joint, str] = {joint: name for name, joint in names.items()}
    again: list[str] = []  # what is to be said of joints that have another's name
    for joint in joints:
        if joint not in unique:
            wanted = name = joint.name or f"{unique.get(joint.parent, joint.parent.name)}_end"
            while name in names:
                counts[wanted] = counts.get(wanted, 1) + 1
                name = f"{wanted}_{counts[wanted]}"
            if joint.name:
                lines = f"{names[wanted].opened.line} and {joint.opened.line}"
                again.append(f"joints in lines {lines} are both named {wanted!r}; the second is {name!r} here")
            names[name], unique[joint] = joint, name
    if again:
        source.warn(again[0] + (f", and {len(again) - 1} more likewise" if len(again) > 1 else ""))
    return [unique[joint] for joint in joints]


def _offsets(root: Joint, joints: list[Joint], numbers: np.ndarray, source: Source, stretch: str) -> np.ndarray:
    """The bones' offsets (n_joints, 3), in the file's unit: OFFSET, or where position channels put the joint."""
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
            f"{len(moved) - 1} joints more), but bones have fixed lengths here; stretch='mean' takes the mean",
            joint.opened,
        )
    # Zeros throughout are channels that a program writes for every joint and leaves alone.
    unused = ~((np.abs(offsets) > rounding) | (vary > rounding)).any(axis=1, where=read)
    offsets[unused] = stated[unused]
    elsewhere = (np.abs(offsets - stated) > rounding).any(axis=1) & stated.any(axis=1)
    elsewhere = np.setdiff1d(np.flatnonzero(elsewhere), moved)
    if len(elsewhere):
        first = elsewhere[0]
        source.warn(
            f"{len(elsewhere)} joints stand where their position channels say, not at their OFFSET: {joints[first]}, "
            f"line {joints[first].opened.line}, at {_shown(offsets[first])}, not {_shown(stated[first])}"
        )
    return offsets


def _shown(vector: np.ndarray) -> str:
    return " ".join(f"{x:.6g}" for x in vector)
