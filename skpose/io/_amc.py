"""Reader of Acclaim motion files (AMC): the angles of an ASF skeleton, frame by frame and bone by bone.

A frame is a line for its number, and one for the name and the numbers of each bone.
"""

from collections.abc import Iterator
from itertools import chain
from typing import Literal

import numpy as np

from skpose._validation.options import check_choice, check_positive
from skpose._warnings import warn
from skpose.io._acclaim import Acclaim
from skpose.io._arguments import Readable
from skpose.io._asf import AsfFile, content_of
from skpose.io._numbers import drop_not_finite
from skpose.io._source import Chunk, Source
from skpose.io._up import Up, check_up_of_file, stand
from skpose.io._words import NUMBER, WHOLE, Token, complaint
from skpose.skeleton import Motion

Line = tuple[int, str]  # its number, and its text without a comment
USUAL_RATE = 120.0  # Hz, of CMU and HDM05


def load_amc(
    path: Readable,
    asf: Readable | AsfFile,
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
    asf : str, path-like, file or AsfFile
        The ASF file that it belongs to, which states which angles the numbers are. An `AsfFile` is read once for
        several motions.
    frame_rate : float, default=None
        Frames per second, Hz; the format does not store it. None is 120 Hz, the usual rate of CMU and HDM05, with a
        warning.
    scale : float, default=None
        Metres per unit of length, as in `load_asf`; None for an `AsfFile`, which has its scale.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite: refuse the file, or leave these frames out. The
        others keep their times, see `Motion.frame_numbers`; that of the first frame of the file is 0.
    missing : {"raise", "rest"}, default="raise"
        What to do with a bone that a frame does not mention: refuse the file, or set its angles there to zero.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The direction of the file's world that points up, see `load_bvh`; None is y, with a warning where poses stand
        along another axis.

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

    Warns
    -----
    UserWarning
        If no frame rate is given. The text is the same for every file, so that Python shows it once for many files.

    See Also
    --------
    save_bvh : Write the motion in a format that most programs read.

    Notes
    -----
    The root's position and orientation in the ASF file are added to the root's numbers. Rigid bones, those without
    dofs, need not be in the AMC file; where they are, their numbers must be zero.

    Cost: some 25 MB a second. Memory is at most some 2.3 times that of the array.

    Examples
    --------
    >>> from skpose.io import load_amc
    >>> load_amc("02_01.amc", "02.asf", frame_rate=120)  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, y up, Skeleton(n_joints=30, n_dofs=56))
    """
    content = content_of(asf, scale)
    with Source(path, "an AMC file") as source:
        return read_amc(source, content, frame_rate=frame_rate, on_nan=on_nan, missing=missing, up=up)


def read_amc(
    source: Source,
    asf: Acclaim,
    *,
    frame_rate: float | None = None,
    on_nan: str = "raise",
    missing: str = "raise",
    up: Up | None = None,
) -> Motion:
    """Read the motion of an open AMC file, with the content of its ASF file."""
    if frame_rate is not None:
        check_positive("frame_rate", frame_rate)
    check_choice("on_nan", on_nan, ("raise", "drop"))
    check_choice("missing", missing, ("raise", "rest"))
    check_up_of_file(up)
    asf, in_radians, first = _read_head(source, asf)
    reader = RowReader(asf, source, fill=missing == "rest", keep_nan=on_nan == "drop")
    numbers = read_frames(source, reader, first)
    numbers, frames = drop_not_finite(numbers, np.arange(len(numbers)), source)  # none if on_nan="raise"
    with source.format_errors():
        motion = _motion(numbers, frames, asf, in_radians, frame_rate or USUAL_RATE)
    if frame_rate is None:
        warn(
            f"AMC files do not state their frame rate: {USUAL_RATE:g} Hz is taken, the usual rate of CMU and HDM05; "
            "pass frame_rate=, in Hz"
        )
    return stand(motion, up, source)


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


class RowReader:
    """Indices of a frame's numbers among its words; each frame is read with those of the previous one if they fit.

    Parameters
    ----------
    asf : Acclaim
        The skeleton: its `channels`, by bone, have the order of the numbers that `row` returns.
    source : Source
        The AMC file, for its errors.
    fill : bool
        Whether the numbers of a bone that a frame does not mention are zero.
    keep_nan : bool
        Whether numbers may be NaN or infinite.
    """

    def __init__(self, asf: Acclaim, source: Source, fill: bool, keep_nan: bool):
        self.asf, self.channels, self.source, self.fill, self.keep_nan = asf, asf.channels, source, fill, keep_nan
        self.n_words = -1
        self.names: dict[int, str] = {}  # bones by the index of their name
        self.numbers: list[int] = []  # index of each number; -1 is a zero appended to the words
        self.zeros: list[int] = []  # indices of the numbers of rigid bones

    def row(self, number: Token, frame: list[Line]) -> np.ndarray:
        """Return the numbers of a frame."""
        text = " ".join([text for _, text in frame])
        words = text.split()
        if len(words) != self.n_words or any(words[i] != name for i, name in self.names.items()):
            self._learn(number, frame)
        words.append("0")
        try:
            row = np.array([words[i] for i in self.numbers + self.zeros], dtype=np.float64)
            as_expected = np.isfinite(row).all() and not row[len(self.numbers) :].any()
            regular = bool(as_expected) and "_" not in text and text.isascii()  # "1_0" is a number to Python
        except ValueError:
            self._learn(number, frame)  # an error if lines end elsewhere, so that a name is among the numbers
            regular = False
        if not regular:
            self._check(number, frame)
            if not np.isfinite(row).all():
                row[:] = np.nan  # of a rigid bone too: the frame is left out
        return row[: len(self.numbers)]

    def _learn(self, number: Token, frame: list[Line]) -> None:
        """Learn the indices from this frame, if it is complete."""
        first: dict[str, int] = {}
        self.names, self.n_words, self.zeros = {}, 0, []
        for line, text in frame:
            name, *values = self.source.words(text, line)
            rigid = name in self.asf.bones and name not in self.channels
            fits = rigid or (name in self.channels and len(values) == len(self.channels[name]))
            if name in first or not fits:
                raise self.source.error(self._fault(name, values, number, name in first), name)
            self.names[self.n_words], first[name] = str(name), self.n_words + 1
            if rigid:
                self.zeros += range(self.n_words + 1, self.n_words + 1 + len(values))
            self.n_words += 1 + len(values)
        absent = [name for name in self.channels if name not in first]
        if absent and not self.fill:
            more = f" and {len(absent) - 5} more" if len(absent) > 5 else ""
            raise self.source.error(
                f"frame {number} ends without {', '.join(absent[:5])}{more}; is the file cut short? missing='rest' "
                "sets their angles to zero",
                frame[-1][0] if frame else number,
            )
        self.numbers = [
            first[name] + k if name in first else -1 for name, its in self.channels.items() for k in range(len(its))
        ]

    def _fault(self, name: Token, values: list[Token], number: Token, again: bool) -> str:
        """Return what is wrong with a line of a frame."""
        if again:
            return f"{str(name)!r} appears twice in frame {number}"
        if name not in self.channels:
            return f"{self.asf.name} has no bone {str(name[:40])!r}; is it the right skeleton?"
        expected = self.channels[name]
        return (
            f"{str(name)!r} has {len(values)} numbers, but {self.asf.name} gives it {len(expected)} "
            f"({' '.join(expected)}); is the line cut short, or the skeleton another?"
        )

    def _check(self, number: Token, frame: list[Line]) -> None:
        """Check every word of a frame; an error names the first that is no number, or not zero as it must be."""
        for line, text in frame:
            name, *values = self.source.words(text, line)
            for token in values:
                if not NUMBER.fullmatch(token):
                    raise self.source.error(f"frame {number}: {complaint(token)}", token)
                if not self.keep_nan and not np.isfinite(float(token)):
                    raise self.source.error(
                        f"frame {number}: {complaint(token)}; on_nan='drop' leaves such frames out", token
                    )
                if name not in self.channels and np.isfinite(float(token)) and float(token) != 0.0:
                    raise self.source.error(
                        f"frame {number}: expected 0, found {str(token[:40])!r}, as {self.asf.name} gives "
                        f"{str(name[:40])!r} no degrees of freedom; is it the right skeleton?",
                        token,
                    )


def read_frames(source: Source, reader: RowReader, first: Chunk) -> np.ndarray:
    """Return the numbers of all frames, (n_frames, n_channels), from the line after the keywords on."""
    rows: list[np.ndarray] = []
    last: int | None = None
    for number, frame in _frames(source, _lines(source, first)):
        if last is not None and int(number) != last + 1:
            raise source.error(f"expected frame {last + 1}, found frame {number}", number)
        last = int(number)
        rows.append(reader.row(number, frame))
    if not rows:
        raise source.error("the file ends without a frame; not AMC, or cut short", source.line)
    return np.array(rows)


def _lines(source: Source, first: Chunk) -> Iterator[Line]:
    """Yield the lines that are not empty, without comments, from a first one on."""
    for line, _, text in chain((first,), source.chunks()):
        for n, one in enumerate(text.decode("utf-8", errors="replace").split("\n"), line):
            if "#" in one:
                one = one.partition("#")[0]
            if one and not one.isspace():
                yield n, one


def _frames(source: Source, lines: Iterator[Line]) -> Iterator[tuple[Token, list[Line]]]:
    """Yield the frames, each with its number and its lines."""
    number: Token | None = None
    frame: list[Line] = []
    for line, text in lines:
        if text.strip().isdecimal() and WHOLE.fullmatch(text.strip()):  # the first for speed, the second for ASCII
            if number is not None:
                yield number, frame
            number, frame = Token(text.strip(), line, 1), []
        elif number is None:
            raise source.error(f"expected a frame number, found {text.strip()[:40]!r}; not an AMC file?", line)
        else:
            frame.append((line, text))
    if number is not None:
        yield number, frame
