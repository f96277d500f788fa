"""Acclaim motion files (AMC): the angles of an ASF skeleton, frame by frame and bone by bone."""

from collections.abc import Iterator
from itertools import chain
from typing import Literal

import numpy as np

from skpose.io._asf import Asf, read_asf
from skpose.io._source import NUMBER, WHOLE, Readable, Source, Token, check_choice, check_positive, complaint
from skpose.skeleton import Motion


def load_amc(
    path: Readable,
    asf: Readable,
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
    asf : str, path-like or file
        The ASF file that it belongs to; it says which angles the numbers are.
    frame_rate : float, default=120.0
        Frames per second; the format does not store it. 120 Hz is CMU's usual rate.
    scale : float, default=None
        Metres per unit of length, as in `load_asf`.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite: refuse the file, or leave them out.
    missing : {"raise", "rest"}, default="raise"
        What to do with a bone that a frame does not mention: refuse the file, or take its angles there as zero.

    Returns
    -------
    Motion
        Angles placed by name, in rad. Its skeleton is that of the ASF file; where the AMC file says
        ``:FORCE-ALL-JOINTS-BE-3DOF``, every bone that turns at all turns about three axes, as the numbers do.

    Raises
    ------
    MocapFormatError
        If a file is not what it should be, is cut short, or the two do not belong together; with its name, the line
        and the column.
    OSError
        If one cannot be read.

    See Also
    --------
    save_bvh : Write the motion in a format that most programs read.

    Notes
    -----
    The root's position and orientation in the ASF file are added to the root's numbers.

    Examples
    --------
    >>> from skpose.io import load_amc
    >>> load_amc("02_01.amc", "02.asf")  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, Skeleton(n_joints=30, n_dofs=56))
    """
    with Source(asf, "an ASF file") as source:
        skeleton = read_asf(source, scale)
    with Source(path, "an AMC file") as source:
        return read_amc(source, skeleton, frame_rate=frame_rate, on_nan=on_nan, missing=missing)


Line = tuple[int, str]  # its number, and its text without a comment


def read_amc(
    source: Source, asf: Asf, *, frame_rate: float = 120.0, on_nan: str = "raise", missing: str = "raise"
) -> Motion:
    """`load_amc` of a source, with the ASF file read already."""
    check_positive("frame_rate", frame_rate)
    check_choice("on_nan", on_nan, ("raise", "drop"))
    check_choice("missing", missing, ("raise", "rest"))
    lines = _lines(source)
    asf, in_radians, first = _read_head(source, asf, lines)
    channels = {"root": asf.root.channels} | asf.dofs
    layout = _Layout(channels, source, asf.name, fill=missing == "rest", keep_nan=on_nan == "drop")
    rows, last = [], None
    for number, frame in _frames(source, first, lines):
        if last is not None and int(number) != last + 1:
            raise source.error(f"expected frame {last + 1}, found frame {number}", number)
        last = int(number)
        rows.append(layout.row(number, frame))
    if not rows:
        raise source.error("the file ends without a frame; not AMC, or cut short", source.line)
    numbers = np.array(rows)
    if on_nan == "drop":
        numbers = numbers[np.isfinite(numbers).all(axis=1)]
    with source.blamed():
        return _motion(numbers, channels, asf, in_radians, frame_rate)


def _lines(source: Source) -> Iterator[Line]:
    """The lines that say anything."""
    for first, block in source.blocks():
        for line, text in enumerate(b"".join(block).decode("utf-8", errors="replace").split("\n"), first):
            if "#" in text:
                text = text.partition("#")[0]
            if text and not text.isspace():
                yield line, text


def _read_head(source: Source, asf: Asf, lines: Iterator[Line]) -> tuple[Asf, bool, Line | None]:
    """The skeleton and the unit of angles as the keywords before the first frame have them, and the line after."""
    in_radians = bool(asf.radians)
    for line, text in lines:
        token, *_ = source.words(text, line)
        keyword = token.lower()
        if not keyword.startswith(":"):
            return asf, in_radians, (line, text)
        if keyword in (":degrees", ":radians"):
            in_radians = keyword == ":radians"
            if asf.radians not in (None, in_radians):
                raise source.error(f"angles in {keyword[1:]}, but {asf.name} has the other unit", token)
        elif keyword == ":force-all-joints-be-3dof":
            asf = asf.with_three_dofs()
    return asf, in_radians, None


def _frames(source: Source, first: Line | None, lines: Iterator[Line]) -> Iterator[tuple[Token, list[Line]]]:
    """The frames, each with its number and its lines."""
    number, frame = None, []
    for line, text in chain([first] if first else [], lines):
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


class _Layout:
    """Where a frame's numbers stand among its words; each frame is tried with the layout of the one before.

    Parameters
    ----------
    channels : dict of lists of str
        The bones' names and those of their angles, in the order of the numbers that `row` returns.
    """

    def __init__(self, channels: dict[str, list[str]], source: Source, asf: str, fill: bool, keep_nan: bool):
        self.channels, self.source, self.asf, self.fill, self.keep_nan = channels, source, asf, fill, keep_nan
        self.n_words = -1
        self.names: dict[int, str] = {}  # what must stand where
        self.numbers: list[int] = []  # where each number stands; -1 is the word after the last, a zero

    def row(self, number: Token, frame: list[Line]) -> np.ndarray:
        """The numbers of a frame."""
        text = " ".join([text for _, text in frame])
        words = text.split()
        if len(words) != self.n_words or any(words[i] != name for i, name in self.names.items()):
            self._learn(number, frame)
        words.append("0")
        try:
            row = np.array([words[i] for i in self.numbers], dtype=np.float64)
            doubtful = "_" in text or not text.isascii() or not np.isfinite(row).all()  # "1_0" is a number to Python
        except ValueError:
            doubtful = True
        if doubtful:
            self._check(number, frame)
        return row

    def _learn(self, number: Token, frame: list[Line]) -> None:
        """The layout of this frame, if it is whole."""
        first: dict[str, int] = {}
        self.names, self.n_words = {}, 0
        for line, text in frame:
            name, *values = self.source.words(text, line)
            if name not in self.channels or name in first or len(values) != len(self.channels[name]):
                raise self.source.error(self._fault(name, values, number, name in first), name)
            self.names[self.n_words], first[name] = str(name), self.n_words + 1
            self.n_words += 1 + len(values)
        absent = [name for name in self.channels if name not in first]
        if absent and not self.fill:
            more = f" and {len(absent) - 5} more" if len(absent) > 5 else ""
            raise self.source.error(
                f"frame {number} ends without {', '.join(absent[:5])}{more}; is the file cut short? missing='rest' "
                "takes their angles as zero",
                frame[-1][0] if frame else number,
            )
        self.numbers = [
            first[name] + k if name in first else -1 for name, its in self.channels.items() for k in range(len(its))
        ]

    def _fault(self, name: Token, values: list[Token], number: Token, again: bool) -> str:
        """What is wrong with a line of a frame."""
        if name not in self.channels:
            return f"{self.asf} has no bone {str(name[:40])!r} with degrees of freedom; is it the right skeleton?"
        if again:
            return f"{str(name)!r} stands twice in frame {number}"
        expected = self.channels[name]
        return (
            f"{str(name)!r} has {len(values)} numbers, but {self.asf} gives it {len(expected)} ({' '.join(expected)}); "
            "is the line cut short, or the skeleton another?"
        )

    def _check(self, number: Token, frame: list[Line]) -> None:
        """Every number of a frame by itself; an error names the first that is none."""
        for line, text in frame:
            for token in self.source.words(text, line)[1:]:
                if not NUMBER.fullmatch(token):
                    raise self.source.error(f"frame {number}: {complaint(token)}", token)
                if not self.keep_nan and not np.isfinite(float(token)):
                    raise self.source.error(
                        f"frame {number}: {complaint(token)}; on_nan='drop' leaves such frames out", token
                    )


def _motion(
    numbers: np.ndarray, channels: dict[str, list[str]], asf: Asf, in_radians: bool, frame_rate: float
) -> Motion:
    """Every column of the file put where its name says, in rad and m."""
    names = [f"{bone}_{channel}" for bone, its in channels.items() for channel in its]
    column = {name: i for i, name in enumerate(names)}
    skeleton, root = asf.skeleton(), asf.root
    angles = numbers[:, [column[name] for name in skeleton.dof_names]]
    root_angles = numbers[:, [column[f"root_r{axis}"] for axis in root.axes]]
    root_angles = root_angles + [root.orientation["xyz".index(axis)] for axis in root.axes]
    if not in_radians:
        angles, root_angles = np.radians(angles), np.radians(root_angles)
    positions = np.tile(root.position, (len(numbers), 1))
    for i, axis in enumerate("xyz"):
        if f"root_t{axis}" in column:
            positions[:, i] += numbers[:, column[f"root_t{axis}"]]
    return Motion(skeleton, angles, frame_rate, asf.scale * positions, root_angles, root.axes)
