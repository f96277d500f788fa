"""Biovision hierarchy (BVH) files.

A joint's channels turn what hangs on it, so a bone's offset is given in the axes of the joint at its near end; Euler
angles are intrinsic in the order in which the joint lists its channels: R = R_1 · R_2 · R_3. The root's channels are
the body's global position and orientation and no part of a pose.
"""

from dataclasses import dataclass, field

import numpy as np

from skpose.io._text import MocapFormatError, PathLike, finite_number, finite_numbers, read_lines
from skpose.motion import Motion
from skpose.skeleton import Bone, Skeleton


@dataclass
class _Joint:
    """One block of the hierarchy."""

    name: str
    parent: "_Joint | None"
    line: int
    offset: list[float] | None = None
    channels: list[str] = field(default_factory=list)  # such as "Xposition", "Zrotation", in lower case

    @property
    def axes(self) -> str:
        return "".join(channel[0].upper() for channel in self.channels if channel.endswith("rotation"))


def load_bvh(path: PathLike, *, scale: float = 1.0) -> Motion:
    """Read a skeleton and its motion from a BVH file.

    Parameters
    ----------
    path : str or path-like
        The file.
    scale : float, default=1.0
        Metres per unit of length. The format has no unit: files in centimetres want 0.01, in inches 0.0254.

    Returns
    -------
    Motion
        Its skeleton has a joint for every JOINT and every End Site (named after the joint that it ends, with "_end"),
        the ROOT being the root. A root's OFFSET is added to its position channels.

    Raises
    ------
    MocapFormatError
        If the file is not a whole BVH file, or moves a joint other than the root by position channels; with its name
        and the line.
    OSError
        If it cannot be read.

    Examples
    --------
    >>> from skpose.io import load_bvh
    >>> load_bvh("dance.bvh", scale=0.01)  # doctest: +SKIP
    Motion(1200 frames at 60 Hz, 20.0 s, Skeleton(n_joints=52, n_dofs=114))
    """
    lines = read_lines(path, "a BVH file")
    joints, motion_line = _read_hierarchy(lines, path)
    root = joints[0]
    bones = []
    for joint in joints[1:]:
        if any(channel.endswith("position") for channel in joint.channels):
            raise MocapFormatError(
                path,
                joint.line,
                f"joint {joint.name!r} has position channels; bones have a fixed length here, and only the root moves",
            )
        parent = None if joint.parent is root else joint.parent.name
        bones.append(Bone(joint.name, parent, tuple(scale * x for x in joint.offset), joint.axes))
    try:
        skeleton = Skeleton(bones, offset_frame="parent")
    except ValueError as error:
        raise MocapFormatError(path, None, str(error)) from None

    # By the joint's place in the file, as a joint may have the name of the root.
    first = np.cumsum([0] + [len(joint.channels) for joint in joints])
    numbers, frame_rate = _read_frames(lines, motion_line, first[-1], path)

    def rotations(i: int) -> np.ndarray:
        columns = [first[i] + k for k, channel in enumerate(joints[i].channels) if channel.endswith("rotation")]
        return np.radians(numbers[:, columns])

    positions = np.tile(np.array(root.offset), (len(numbers), 1))
    for k, channel in enumerate(root.channels):
        if channel.endswith("position"):
            positions[:, "xyz".index(channel[0])] += numbers[:, k]
    angles = np.concatenate([rotations(i) for i in range(1, len(joints))], axis=1)
    return Motion(skeleton, angles, frame_rate, scale * positions, rotations(0), root.axes)


def _read_hierarchy(lines: list[str], path: PathLike) -> tuple[list[_Joint], int]:
    """The blocks in the order of the file, the root first, and the number of the line MOTION."""
    joints: list[_Joint] = []
    joint: _Joint | None = None  # the block that we are in
    opened: _Joint | None = None  # the block that the next { opens
    first = True
    for line, text in enumerate(lines, start=1):
        for tokens in _statements(text):
            word = tokens[0].upper()
            if first and word != "HIERARCHY":
                raise MocapFormatError(path, line, f"expected HIERARCHY, found {text.strip()[:40]!r}; not a BVH file?")
            if opened is not None and word != "{":
                raise MocapFormatError(path, line, f"expected {{ after {opened.name!r}, found {tokens[0]!r}")
            if first:
                first = False
            elif word == "{":
                if opened is None:
                    raise MocapFormatError(path, line, "found { where no joint begins")
                joint, opened = opened, None
                joints.append(joint)
            elif word == "}":
                if joint is None:
                    raise MocapFormatError(path, line, "found } where no joint is open")
                if joint.offset is None:
                    raise MocapFormatError(
                        path, line, f"joint {joint.name!r}, begun in line {joint.line}, has no OFFSET"
                    )
                joint = joint.parent
            elif word in ("ROOT", "JOINT", "END"):
                if (word == "ROOT") != (joint is None):
                    raise MocapFormatError(
                        path, line, f"found {word} {'outside' if joint is None else 'inside'} a joint"
                    )
                if word == "ROOT" and joints:
                    raise MocapFormatError(path, line, "found a second ROOT; one skeleton a file, please")
                name = f"{joint.name}_end" if word == "END" else " ".join(tokens[1:])
                opened = _Joint(name, joint, line)
            elif word == "MOTION":
                if joint is not None or not joints:
                    where = f"joint {joint.name!r} is still open" if joint else "there is no ROOT"
                    raise MocapFormatError(path, line, f"found MOTION, but {where}")
                return joints, line
            elif joint is not None and word == "OFFSET":
                if len(tokens) != 4:
                    raise MocapFormatError(
                        path, line, f"OFFSET of {joint.name!r}: expected 3 numbers, found {len(tokens) - 1}"
                    )
                joint.offset = [finite_number(t, path, line, f"OFFSET of {joint.name!r}") for t in tokens[1:]]
            elif joint is not None and word == "CHANNELS":
                joint.channels = _channels(tokens[1:], joint, path, line)
            else:
                raise MocapFormatError(
                    path, line, f"expected OFFSET, CHANNELS, JOINT, End Site or }}, found {tokens[0]!r}"
                )
    raise MocapFormatError(path, len(lines), "the file ends without MOTION; not BVH, or cut short")


def _statements(text: str) -> list[list[str]]:
    """The tokens of one line of the hierarchy, a brace being a statement of its own."""
    parts = text.replace("{", "\n{\n").replace("}", "\n}\n").split("\n")
    return [part.split() for part in parts if part.strip()]


def _channels(tokens: list[str], joint: _Joint, path: PathLike, line: int) -> list[str]:
    channels = [token.lower() for token in tokens[1:]]
    known = {f"{axis}{kind}" for axis in "xyz" for kind in ("position", "rotation")}
    if not tokens or tokens[0] != str(len(channels)):
        raise MocapFormatError(
            path, line, f"CHANNELS of {joint.name!r}: expected a number and as many names, found {' '.join(tokens)!r}"
        )
    for channel in channels:
        if channel not in known or channels.count(channel) > 1:
            raise MocapFormatError(
                path, line, f"CHANNELS of {joint.name!r}: expected Xposition … Zrotation, each once, found {channel!r}"
            )
    return channels


def _read_frames(lines: list[str], motion_line: int, width: int, path: PathLike) -> tuple[np.ndarray, float]:
    """The frames (n_frames, width) after MOTION, and their rate in Hz."""
    head: dict[str, tuple[int, str]] = {}
    tokens: list[str] = []
    token_lines: list[int] = []
    for line, text in enumerate(lines[motion_line:], start=motion_line + 1):
        if ":" in text and len(head) < 2:
            key, value = text.split(":", 1)
            head[" ".join(key.lower().split())] = (line, value.strip())
        elif text.strip():
            tokens += (found := text.split())
            token_lines += [line] * len(found)
    for key in ("frames", "frame time"):
        if key not in head:
            raise MocapFormatError(path, motion_line, f"expected {key.title()}: after MOTION; is the file cut short?")
    line, value = head["frames"]
    if not value.isdecimal():
        raise MocapFormatError(path, line, f"Frames: expected a whole number, found {value!r}")
    n_frames = int(value)
    line, value = head["frame time"]
    frame_time = finite_number(value, path, line, "Frame Time")
    if frame_time <= 0:
        raise MocapFormatError(path, line, f"Frame Time: expected a positive number of seconds, found {value!r}")
    if len(tokens) != n_frames * width:
        raise MocapFormatError(
            path,
            len(lines),
            f"expected {n_frames} frames of {width} numbers, {n_frames * width} in all, found {len(tokens)}; "
            "is the file cut short, or its Frames: line wrong?",
        )
    return finite_numbers(tokens, token_lines, path, "a frame").reshape(n_frames, width), 1.0 / frame_time
