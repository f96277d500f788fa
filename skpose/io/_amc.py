"""Reader of Acclaim motion files (AMC): the angles of an ASF skeleton, frame by frame and bone by bone."""

from typing import Literal

import numpy as np

from skpose.io._acclaim import Acclaim
from skpose.io._amc_frames import Layout, read_frames
from skpose.io._arguments import Readable, check_choice, check_positive
from skpose.io._asf import AsfFile, content_of
from skpose.io._rows import drop_not_finite
from skpose.io._source import Chunk, Source
from skpose.skeleton import Motion


def load_amc(
    path: Readable,
    asf: Readable | AsfFile,
    *,
    frame_rate: float = 120.0,
    scale: float | None = None,
    on_nan: Literal["raise", "drop"] = "raise",
    missing: Literal["raise", "rest"] = "raise",
) -> Motion:
    """Read a motion from an Acclaim AMC file and the ASF file of its skeleton.

    Parameters
    ----------
    path : str, path-like or file
        The AMC file, or an open one; compressed by gzip or not.
    asf : str, path-like, file or AsfFile
        The ASF file that it belongs to, which states which angles the numbers are. An `AsfFile` is read once for
        several motions.
    frame_rate : float, default=120.0
        Frames per second; the format does not store it. 120 Hz is CMU's usual rate.
    scale : float, default=None
        Metres per unit of length, as in `load_asf`; None for an `AsfFile`, which has its scale.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite: refuse the file, or leave these frames out. The
        others keep their times, see `Motion.frame_numbers`; that of the first frame of the file is 0.
    missing : {"raise", "rest"}, default="raise"
        What to do with a bone that a frame does not mention: refuse the file, or set its angles there to zero.

    Returns
    -------
    Motion
        Motion with the angles in rad, assigned to columns by name, and the skeleton of the ASF file. If the AMC file
        states ``:FORCE-ALL-JOINTS-BE-3DOF``, every bone that has dofs has three.

    Raises
    ------
    MocapFormatError
        If a file does not follow its format, is cut short, or the two do not belong together; with its name, the line
        and the column.
    OSError
        If one cannot be read.
    ValueError
        If a scale differs from that of an `AsfFile`.

    See Also
    --------
    save_bvh : Write the motion in a format that most programs read.

    Notes
    -----
    The root's position and orientation in the ASF file are added to the root's numbers.

    Cost: some 25 MB a second. Memory is at most some 2.3 times that of the array.

    Examples
    --------
    >>> from skpose.io import load_amc
    >>> load_amc("02_01.amc", "02.asf")  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, Skeleton(n_joints=30, n_dofs=56))
    """
    content = content_of(asf, scale)
    with Source(path, "an AMC file") as source:
        return read_amc(source, content, frame_rate=frame_rate, on_nan=on_nan, missing=missing)


def read_amc(
    source: Source, asf: Acclaim, *, frame_rate: float = 120.0, on_nan: str = "raise", missing: str = "raise"
) -> Motion:
    """Read the motion of an open AMC file, with the content of its ASF file."""
    check_positive("frame_rate", frame_rate)
    check_choice("on_nan", on_nan, ("raise", "drop"))
    check_choice("missing", missing, ("raise", "rest"))
    asf, in_radians, first = _read_head(source, asf)
    layout = Layout(asf.channels, source, asf.name, fill=missing == "rest", keep_nan=on_nan == "drop")
    numbers = read_frames(source, layout, first)
    numbers, frames = drop_not_finite(numbers, np.arange(len(numbers)), source)  # none if on_nan="raise"
    with source.format_errors():
        return _motion(numbers, frames, asf, in_radians, frame_rate)


def _read_head(source: Source, asf: Acclaim) -> tuple[Acclaim, bool, Chunk]:
    """Return the skeleton, whether angles are in radians, and the line after the keywords before the first frame."""
    in_radians = bool(asf.radians)
    while (text := source.readline()) is not None:
        if not (words := source.words(text, source.line)):
            continue
        token = words[0]
        keyword = token.lower()
        if not keyword.startswith(":"):
            return asf, in_radians, Chunk(source.line, 0, text.encode())
        if keyword in (":degrees", ":radians"):
            in_radians = keyword == ":radians"
            if asf.radians not in (None, in_radians):
                raise source.error(f"angles in {keyword[1:]}, but {asf.name} has the other unit", token)
        elif keyword == ":force-all-joints-be-3dof":
            asf = asf.with_three_dofs
    return asf, in_radians, Chunk(source.line, 0, b"")


def _motion(numbers: np.ndarray, frames: np.ndarray, asf: Acclaim, in_radians: bool, frame_rate: float) -> Motion:
    """Return the motion of a file's numbers (n_frames, n_channels), with each channel assigned by name."""
    names = [f"{bone}_{channel}" for bone, its in asf.channels.items() for channel in its]
    column = {name: i for i, name in enumerate(names)}
    skeleton, root = asf.skeleton, asf.root
    angles = numbers[:, [column[name] for name in skeleton.dof_names]]
    root_angles = numbers[:, [column[f"root_r{axis}"] for axis in root.axes]]
    root_angles = root_angles + [root.orientation["xyz".index(axis)] for axis in root.axes]
    if not in_radians:
        angles, root_angles = np.radians(angles, out=angles), np.radians(root_angles)
    positions = np.tile(root.position, (len(numbers), 1))
    for i, axis in enumerate("xyz"):
        if f"root_t{axis}" in column:
            positions[:, i] += numbers[:, column[f"root_t{axis}"]]
    return Motion(skeleton, angles, frame_rate, asf.scale * positions, root_angles, root.axes, frames)
