"""Acclaim motion files (AMC): the angles of an ASF skeleton, frame by frame and bone by bone.

A frame is a line for its number, and one for the name and the numbers of each bone.
"""

import os
import re
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np

from skpose._utils.warnings import warn
from skpose.io._asf import AsfFile
from skpose.io._conventions import Up, check_options, stand
from skpose.io._source import WHOLE, PathLike, Readable, Source, drop_not_finite, open_source, parse
from skpose.skeleton import Motion

Line = tuple[int, str]  # its number, and its text without a comment
USUAL_RATE = 120.0  # Hz, of CMU and HDM05
KEYWORD = re.compile(r":[a-z][\w-]*", re.ASCII | re.IGNORECASE)  # such as :degrees and :fully-specified
NUMERIC = re.compile(r"[+-]?[.\d]|nan|[+-]?inf", re.ASCII | re.IGNORECASE)  # how a number begins, also a damaged one


def load_amc(
    path: Readable,
    asf: Readable | AsfFile | None = None,
    *,
    frame_rate: float | None = None,
    scale: float | None = None,
    on_nan: Literal["raise", "drop"] = "raise",
    missing: Literal["raise", "rest"] = "raise",
    up: Up | None = None,
) -> Motion:
    """Read a motion from an Acclaim AMC file and the ASF file of its skeleton.

    Parameters
    ----------
    path : str, path-like or file
        The AMC file, or an open one; compressed by gzip or not.
    asf : str, path-like, file or AsfFile, default=None
        The ASF file of its skeleton. By default walk.asf in the folder of walk.amc, or 02.asf for 02_01.amc, or
        HDM_bd.asf for HDM_bd_walk_001_120.amc.
    frame_rate : float, default=None
        Frames per second, Hz; the format does not store it. By default 120 Hz, the usual rate of CMU and HDM05, with a
        warning.
    scale : float, default=None
        Metres per unit of length, as in `load_asf`.
    on_nan : {"raise", "drop"}, default="raise"
        Refuse a file with NaN or infinite numbers, or leave these frames out. The other frames keep their numbers and
        times, see `Motion.frame_numbers`.
    missing : {"raise", "rest"}, default="raise"
        Refuse a file in which a frame does not mention a bone, or set the angles of the bone to zero.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis of the file's world that points up, as in `load_bvh`.

    Returns
    -------
    Motion
        Motion with the angles in rad, assigned to columns by name, and the skeleton of the ASF file. If the AMC file
        states ``:FORCE-ALL-JOINTS-BE-3DOF``, every bone that has dofs has three.

    Raises
    ------
    MocapFormatError
        If a file is damaged, or the two do not belong together; with its name and line.
    OSError
        If one cannot be read, or the ASF file is not found.

    Warns
    -----
    UserWarning
        If no frame rate is given. The text is the same for every file, so that Python shows it once.

    See Also
    --------
    save_bvh : Write the motion in a format that most programs read.

    Notes
    -----
    The root's position and orientation in the ASF file are added to the root's numbers. The numbers of bones without
    dofs must be zero.

    Examples
    --------
    >>> from skpose.io import load_amc
    >>> load_amc("02_01.amc", "02.asf", frame_rate=120)  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, y up, Skeleton(n_joints=30, n_dofs=56))
    """
    check_options(frame_rate=frame_rate, scale=scale, on_nan=on_nan, missing=missing, up=up)
    source = open_source(path, "an AMC file")
    if asf is None:
        asf = asf_path(source.name)
        if not os.path.lexists(asf):
            raise FileNotFoundError(f"{source.name} needs its skeleton, and there is no {asf}: pass asf=")
    if not isinstance(asf, AsfFile):
        asf = AsfFile(asf, scale=scale)
    elif scale not in (None, asf.scale):
        raise ValueError(f"scale must be that of {asf.name}, {asf.scale}, or None, got {scale!r}")
    texts = (line.partition("#")[0] for line in source.lines)
    lines = [(number, text) for number, text in enumerate(texts, 1) if text and not text.isspace()]
    n_keywords = next((i for i, (_, text) in enumerate(lines) if not text.lstrip().startswith(":")), len(lines))
    keywords = {text.split()[0].lower(): line for line, text in lines[:n_keywords]}
    unit = next((word for word in keywords if word in (":degrees", ":radians")), None)
    in_radians = bool(asf.radians) if unit is None else unit == ":radians"
    if unit and asf.radians not in (None, in_radians):
        raise source.error(f"angles in {unit[1:]}, but {asf.name} has the other unit", keywords[unit])
    if ":force-all-joints-be-3dof" in keywords:
        asf = asf.with_three_dofs()
    rows = _read_rows(source, asf, lines[n_keywords:], fill=missing == "rest", finite=on_nan == "raise")
    numbers, frames = drop_not_finite(rows, np.arange(len(rows)), source)
    with source.format_errors():
        motion = _motion(numbers, frames, asf, in_radians, frame_rate or USUAL_RATE)
    if frame_rate is None:
        warn(
            f"AMC files do not state their frame rate: {USUAL_RATE:g} Hz is taken, the usual rate of CMU and HDM05; "
            "pass frame_rate=, in Hz"
        )
    return stand(motion, up, source)


def is_amc(source: Source) -> bool:
    """Whether a file begins with a keyword, or with the number of a frame and a bone with numbers."""
    lines = [words for line in source.head.splitlines()[:1000] if (words := line.partition("#")[0].split())]
    if not lines:
        return "#" in source.head  # comments, which the other formats do not have
    bone = lines[1] if len(lines) > 1 else []
    is_frame = len(lines[0]) == 1 and WHOLE.fullmatch(lines[0][0]) and (len(bone) < 2 or NUMERIC.match(bone[1]))
    return bool(KEYWORD.fullmatch(lines[0][0]) or is_frame)


def asf_path(amc: PathLike) -> Path:
    """The path at which the ASF file of an AMC file is expected.

    It is walk.asf in the folder of walk.amc if there is such a file; otherwise the name is cut at its last underscore,
    02.asf for 02_01.amc as in the CMU database, then at the one before it, and so on: HDM_bd.asf for
    HDM_bd_walk_001_120.amc. For a link, the file that it points to is tried too. If none exists, it is 02.asf.
    """
    amc = Path(amc)
    candidates = [asf for path in (amc, Path(os.path.realpath(amc))) for asf in _asf_paths(path)]
    found = next((path for path in candidates if os.path.lexists(path) and not path.is_dir()), None)
    return found or _asf_paths(amc)[:2][-1]


def _asf_paths(amc: Path) -> list[Path]:
    name = amc.name[:-3] if amc.name.lower().endswith(".gz") else amc.name
    parts = Path(name).stem.split("_")
    return [amc.with_name(f"{'_'.join(parts[:n])}.asf") for n in range(len(parts), 0, -1)]


def _motion(numbers: np.ndarray, frames: np.ndarray, asf: AsfFile, in_radians: bool, frame_rate: float) -> Motion:
    """The motion of a file's numbers (n_frames, n_channels), with each channel assigned by name."""
    names = (f"{bone}_{channel}" for bone, channels in asf.channels.items() for channel in channels)
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


def _read_rows(source: Source, asf: AsfFile, lines: list[Line], *, fill: bool, finite: bool) -> np.ndarray:
    """The numbers of all frames, (n_frames, n_channels), zero for bones that a frame does not mention if `fill`."""
    starts = [i for i, (_, text) in enumerate(lines) if text.strip().isdecimal()]
    if not starts or starts[0] > 0:
        line = lines[0][0] if lines else len(source.lines)
        raise source.error("expected the number of a frame, found none; not AMC, or cut short", line)
    columns_of, frames, texts = dict[tuple, np.ndarray](), list[np.ndarray](), list[str]()
    for expected, (start, stop) in enumerate(pairwise([*starts, len(lines)]), int(lines[0][1].strip()[:18])):
        line, number = lines[start]
        if not WHOLE.fullmatch(number.strip()) or int(number) != expected:
            raise source.error(f"expected frame {expected}, found frame {number.strip()[:40]}", line)
        frame = [text.split() for _, text in lines[start + 1 : stop]]
        form = tuple([words[0] for words in frame]), tuple(map(len, frame))
        if form not in columns_of:  # most files have one form
            columns_of[form] = _columns(source, asf, form, [line for line, _ in lines[start:stop]], fill)
        frames.append(columns_of[form])
        texts.append(" ".join([word for words in frame for word in words[1:]]))
    numbers = parse("\n".join(texts).encode())
    if numbers is None or (finite and not np.isfinite(numbers).all()):
        words_at = ((line, text.split()) for line, text in lines)
        numbers = np.array(
            [
                source.number(word, words[0], line, finite=finite, nan=not finite)  # which raises for one of them
                for line, words in words_at
                for word in words[1:]
            ]
        )
    columns, at = np.concatenate(frames), np.repeat(np.arange(len(frames)), [len(each) for each in frames])
    n_channels = sum(map(len, asf.channels.values()))
    wrong = (columns == n_channels) & np.isfinite(numbers) & (numbers != 0.0)
    if wrong.any():
        line, _ = lines[starts[at[wrong.argmax()]]]
        raise source.error("expected zeros of the bones without dofs in this frame; is it the right skeleton?", line)
    rows = np.zeros((len(frames), n_channels + 1))
    rows[at, columns] = numbers
    return rows[:, :-1]


def _columns(source: Source, asf: AsfFile, form: tuple, lines: list[int], fill: bool) -> np.ndarray:
    """The column of each number of a frame, by the first words of its lines and their lengths; the last if rigid."""
    channels = asf.channels
    first = dict(zip([*channels, ""], np.cumsum([0, *map(len, channels.values())]).tolist(), strict=True))
    columns, names = list[int](), form[0]
    for i, (name, n_words) in enumerate(zip(*form, strict=True)):
        n = n_words - 1
        is_rigid = name in asf.bones and name not in channels
        if name in names[:i] or not (is_rigid or (name in channels and n == len(channels[name]))):
            what = f"a bone of {asf.name} with its numbers, found {name[:40]!r} with {n}"
            raise source.error(f"expected {what}", lines[i + 1])
        columns += [first[""]] * n if is_rigid else range(first[name], first[name] + n)
    absent = [name for name in channels if name not in names]
    if absent and not fill:
        raise source.error(f"expected {', '.join(absent[:5])} in the frame: missing='rest' takes zeros", lines[-1])
    return np.array(columns, dtype=int)
