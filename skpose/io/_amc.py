"""Acclaim motion files (AMC): the angles of an ASF skeleton, frame by frame and bone by bone.

A frame is a line for its number, and one for the name and the numbers of each bone.
"""

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np

from skpose._utils.warnings import warn
from skpose.io._arguments import PathLike, Readable
from skpose.io._asf import AsfFile
from skpose.io._conventions import Up, check_options, stand
from skpose.io._numbers import drop_not_finite
from skpose.io._source import WHOLE, Source, open_source
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
        raise ValueError(f"scale must be that of {asf!r}, {asf.scale}, or None, got {scale!r}")
    lines = list(_lines(source))
    n_keywords = next((i for i, (_, text) in enumerate(lines) if not text.lstrip().startswith(":")), len(lines))
    in_radians = bool(asf.radians)
    for line, text in lines[:n_keywords]:
        keyword = text.split()[0].lower()
        if keyword in (":degrees", ":radians"):
            in_radians = keyword == ":radians"
            if asf.radians not in (None, in_radians):
                raise source.error(f"angles in {keyword[1:]}, but {asf.name} has the other unit", line)
        elif keyword == ":force-all-joints-be-3dof":
            asf = asf.with_three_dofs()
    rows = _Rows(source, asf, fill=missing == "rest", finite=on_nan == "raise").read(lines[n_keywords:])
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
    names = [f"{bone}_{channel}" for bone, channels in asf.channels.items() for channel in channels]
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


def _lines(source: Source) -> Iterator[Line]:
    """Yield the lines that are not empty, without comments."""
    for number, text in enumerate(source.lines, 1):
        if "#" in text:
            text = text.partition("#")[0]
        if text and not text.isspace():
            yield number, text


class _Rows:
    """Reads the numbers of each frame, at the same places among the words as in the frame before if they fit.

    Parameters
    ----------
    source, asf : Source, AsfFile
        The file and its skeleton, whose `channels` have the order of the numbers in a row.
    fill : bool
        Whether the numbers of a bone that a frame does not mention are zero.
    finite : bool
        Whether numbers must be finite.
    """

    def __init__(self, source: Source, asf: AsfFile, *, fill: bool, finite: bool):
        self.source, self.asf, self.channels, self.fill, self.finite = source, asf, asf.channels, fill, finite
        self.n_words = -1
        self.names: dict[int, str] = {}  # bones by the index of their name
        self.places: list[int] = []  # index of each number; -1 is a zero appended to the words

    def read(self, lines: list[Line]) -> np.ndarray:
        """The numbers of all frames, (n_frames, n_channels)."""
        starts = [i for i, (_, text) in enumerate(lines) if text.strip().isdecimal()]
        if not starts or starts[0] > 0:
            line = lines[0][0] if lines else len(self.source.lines)
            raise self.source.error("expected the number of a frame, found none; not AMC, or cut short", line)
        rows, first = list[np.ndarray](), int(lines[0][1].strip()[:18])
        for expected, (start, stop) in enumerate(zip(starts, [*starts[1:], len(lines)], strict=True), first):
            line, number = lines[start]
            if not WHOLE.fullmatch(number.strip()) or int(number) != expected:
                raise self.source.error(f"expected frame {expected}, found frame {number.strip()[:40]}", line)
            rows.append(self._row(line, lines[start + 1 : stop]))
        return np.array(rows)

    def _row(self, line: int, frame: list[Line]) -> np.ndarray:
        text = " ".join([text for _, text in frame])
        words = text.split()
        if len(words) == self.n_words and all(words[i] == name for i, name in self.names.items()):
            words.append("0")
            try:
                row = np.array([words[i] for i in self.places], dtype=np.float64)
                if np.isfinite(row).all() and "_" not in text and text.isascii():  # "1_0" is a number to Python
                    return row
            except ValueError:
                pass  # the other way names the word
        return self._read_new(line, frame)

    def _read_new(self, line: int, frame: list[Line]) -> np.ndarray:
        """The numbers of a frame, NaN where one is not finite, and learn their places for the next frames."""
        found: dict[str, list[float]] = {}
        starts: dict[str, int] = {}
        self.names, n_words = {}, 0
        for at, text in frame:
            name, *values = text.split()
            is_rigid = name in self.asf.bones and name not in self.channels
            is_known = is_rigid or len(values) == len(self.channels.get(name, ()))
            if not is_known or name in found or name not in {**self.asf.bones, **self.channels}:
                raise self.source.error(
                    f"expected a bone of {self.asf.name} with its numbers, found {name[:40]!r} with {len(values)}", at
                )
            numbers = [self.source.number(value, name, at, finite=self.finite, nan=not self.finite) for value in values]
            if is_rigid and any(np.isfinite(number) and number != 0.0 for number in numbers):
                raise self.source.error(f"expected zeros of {name!r}, which has no dofs; is it the right skeleton?", at)
            self.names[n_words], found[name], starts[name] = name, numbers, n_words + 1
            n_words += 1 + len(values)
        absent = [name for name in self.channels if name not in found]
        if absent and not self.fill:
            at = frame[-1][0] if frame else line
            raise self.source.error(f"expected {', '.join(absent[:5])} in the frame: missing='rest' takes zeros", at)
        has_rigid = len(found) + len(absent) > len(self.channels)  # whose zeros are checked in every frame
        self.n_words = -1 if has_rigid else n_words
        channels = [(name, k) for name, its in self.channels.items() for k in range(len(its))]
        self.places = [starts[name] + k if name in found else -1 for name, k in channels]
        row = np.array([found[name][k] if name in found else 0.0 for name, k in channels])
        is_whole = all(np.isfinite(numbers).all() for numbers in found.values())
        return row if is_whole else np.full_like(row, np.nan)
