"""The files of a command, read one by one: at which rate and scale, which are left out, and what is said of them."""

import errno
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from skpose._cli.messages import Note, Skipped, count_files, describe, group
from skpose._cli.stages import steps
from skpose._validation.units import LARGEST, SMALLEST, UNITS, extent_of, likely_unit
from skpose._warnings import warn
from skpose.datasets._shared import NAME, rows_of
from skpose.io import AsfFile, MocapFormatError, file_format, load_motion
from skpose.io._shared import Stored, open_file
from skpose.keypoints import Keypoints
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import size_of

STDIN = "-"
AUTO = "auto"  # a scale
AMC = re.compile(r".+\.amc(\.gz)?", re.IGNORECASE)
# The options of frame rates, and the arguments that they are, the first before the second.
RATES = {"--file-frame-rate": "file_frame_rate", "--amc-frame-rate": "frame_rate"}
COMMON = 0.8, 2.5  # m; another unit that makes a skeleton as large is possible as well


class Rate(NamedTuple):
    """The frame rate of an AMC file, Hz, and what states it."""

    hertz: float
    origin: str


class Scale(NamedTuple):
    """The unit that was chosen for a file by its size."""

    name: str  # of the file
    size: float  # m
    unit: str | None  # None is the one that the format has
    others: tuple[str, ...]  # that make it the size of a person too


class Reader:
    """Reads the files of a command, each with the same options.

    Parameters
    ----------
    options : dict
        Arguments of `load_motion`. The `scale` may be "auto", `asf` a pipe. `frame_rate` is that of AMC files, and
        `file_frame_rate` that of all.
    skipped : Skipped, default=None
        Where the files that cannot be read are noted, with the errors; None raises the first of them.
    remedy : str, default=""
        The end of the message on a file of several that cannot be read.
    """

    def __init__(self, options: dict[str, Any], skipped: Skipped | None = None, remedy: str = ""):
        self._options, self._skipped, self._remedy = options, skipped, remedy
        self.rates: dict[Path, Rate] = {}  # of the files that were read last
        self._notes: list[Note] = []
        self._scales: list[Scale] = []
        asf = None if options.get("asf") is None else read_if_pipe(options["asf"])
        self._pipe = asf if isinstance(asf, BytesIO) else None
        self._skeletons: dict[float | None, AsfFile] = {}  # of the pipe, by scale

    def read(
        self, files: Sequence[Path], load: Callable[..., Any] = load_motion, *, frames: bool = False, required: int = 0
    ) -> Iterator[tuple[Path, Any]]:
        """Yield each file with its content.

        With `frames`, motions without any are as those that cannot be read. Of the first files, as many as are
        `required`, none is left out.
        """
        names = [name_of(path) for path in files]
        if self._skipped is None:  # before minutes go by with the files ahead of one that is not there
            self._check_exist(files)
        self.rates = self._find_rates(files)
        n_read = 0
        try:
            what = f"reading {len(files)} files"
            for i, (path, name) in enumerate(steps(what, list(zip(files, names, strict=True)))):
                try:
                    content = self._read(path, load)
                    if frames and not len(content):
                        raise ValueError(f"{name} has no frames")
                except (OSError, ValueError) as error:
                    message = _describe(error, name)
                    if self._skipped is None or i < required:
                        raise ValueError(message + (self._remedy if i >= required and files[1:] else "")) from None
                    self._skipped.messages.append(message)
                    self._skipped.n_files = len(files)
                    continue
                n_read += 1
                if len(files) == 1:
                    self._report(files)  # before the content is shown
                yield path, content
        finally:
            self._report(files)
        if not n_read:
            raise ValueError("no file can be read")

    def _check_exist(self, files: Sequence[Path]) -> None:
        for path in files:
            if str(path) != STDIN and not path.exists():
                missing = FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path))
                raise ValueError(describe(missing) + (self._remedy if files[1:] else ""))

    def _find_rates(self, files: Iterable[Path]) -> dict[Path, Rate]:
        """Return the rates of AMC files by an index.csv, or by a name as in HDM05, unless an option chooses one."""
        files = [path for path in files if AMC.fullmatch(path.name)]
        stated = {
            path: Rate(float(match["rate"]), "its name") for path in files if (match := NAME.fullmatch(path.name))
        }
        for path, row in rows_of(files).items():
            if row["frames_per_second"] is not None:
                stated[path] = Rate(row["frames_per_second"], row["index"].name)
        option = next((name for name in RATES if self._options.get(RATES[name]) is not None), None)
        if option is None:
            return stated
        hertz = self._options[RATES[option]]
        for path, rate in stated.items():
            if rate.hertz != hertz:
                text = f"{option} {hertz:g} replaces the {rate.hertz:g} Hz that {rate.origin} states"
                self._notes.append(Note(name_of(path), text))
        return {}

    def _read(self, path: Path, load: Callable[..., Any]) -> Any:
        """Return the content of a file, and note the warnings."""
        file = read_if_pipe(path)
        hertz = self._rate_of(path, file)

        def load_at(scale: float | None) -> Any:
            if isinstance(file, BytesIO):
                file.seek(0)
            options = self._options | {"scale": scale, "frame_rate": hertz}
            options.pop("file_frame_rate", None)
            if self._pipe is not None:
                options["asf"] = self._skeleton(self._pipe, scale)
            return load(file, **options)

        with warnings.catch_warnings(record=True) as caught:
            scale = self._options["scale"]
            content = load_at(scale) if scale != AUTO else self._load_by_size(load_at, name_of(path))
        for one in caught:
            text = str(one.message)
            if text.startswith("AMC files do not state"):
                text = text.replace("frame_rate=", "--amc-frame-rate")
            self._notes.append(Note(name_of(path), text, one.category))
        return content

    def _rate_of(self, path: Path, file: Path | BytesIO) -> float | None:
        """Return the frame rate at which a file is read, Hz; None is the one that it states, or the usual one."""
        if (hertz := self._options.get("file_frame_rate")) is not None:
            return hertz
        if path in self.rates:
            return self.rates[path].hertz
        hertz = self._options.get("frame_rate")
        return hertz if hertz is not None and _is_amc(file) else None

    def _skeleton(self, pipe: BytesIO, scale: float | None) -> AsfFile:
        if scale not in self._skeletons:
            pipe.seek(0)
            self._skeletons[scale] = AsfFile(pipe, scale=scale)
        return self._skeletons[scale]

    def _load_by_size(self, load_at: Callable[[float | None], Any], name: str) -> Any:
        """Return the content in the unit that the format has, or in the one in which it has the size of a person."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                content = load_at(None)
                size = _size(content)
            except MocapFormatError:  # as where a file should state its unit, and does not
                size = np.inf
        if SMALLEST <= size <= LARGEST or size == 0.0:
            self._notes += [Note(name, str(one.message), one.category) for one in caught]
            self._scales.append(Scale(name, size, None, ()))
            return content
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            in_units = _size(load_at(1.0))
        unit = likely_unit(in_units)
        if not SMALLEST <= in_units * UNITS[unit] <= LARGEST:
            raise ValueError(
                f"{name} is {in_units:.3g} units of length from end to end, the size of a person in none of "
                f"{', '.join(UNITS)}: pass --scale, the metres of one unit"
            )
        others = tuple(other for other in UNITS if other != unit and COMMON[0] <= in_units * UNITS[other] <= COMMON[1])
        self._scales.append(Scale(name, in_units * UNITS[unit], unit, others))
        return load_at(UNITS[unit])

    def _report(self, files: Sequence[Path]) -> None:
        """Say what has been found of the files, once for all that it is true of."""
        names = [name_of(path) for path in files]
        units: dict[tuple[str | None, tuple[str, ...]], list[Scale]] = {}
        for scale in self._scales:
            units.setdefault((scale.unit, scale.others), []).append(scale)
        for (unit, others), scales in units.items():
            sizes = [scale.size for scale in scales]
            span = f"{min(sizes):.3g}" + (f" to {max(sizes):.3g}" if max(sizes) > min(sizes) else "")
            text = "as without --scale" if unit is None else f"{unit}, --scale {UNITS[unit]:.4g}"
            more = "".join(f"; {other}, --scale {UNITS[other]:.4g}, are possible too" for other in others)
            of = count_files([scale.name for scale in scales], names)
            print(f"skpose: --scale auto: {of}: {text}: {span} m from end to end{more}", file=sys.stderr)
        notes = group(self._notes, names)
        self._scales, self._notes = [], []
        for text, category in notes:
            warn(text, category)


def _is_amc(file: Path | BytesIO) -> bool:
    """Return whether a file has the format AMC; what cannot be read has none here, which its reader reports."""
    try:
        return file_format(file) == "AMC"
    except (OSError, ValueError):
        return False
    finally:
        if isinstance(file, BytesIO):
            file.seek(0)


def _size(content: Motion | Skeleton | Keypoints | Stored) -> float:
    """Return the size of a skeleton at angle zero, or of points in the median frame, m; zero where there is none."""
    if isinstance(content, Keypoints | Stored):
        return extent_of(content.positions)
    return size_of(content if isinstance(content, Skeleton) else content.skeleton)


def name_of(path: Path) -> str:
    """Return the name of a file for messages."""
    return "standard input" if str(path) == STDIN else str(path)


def read_if_pipe(path: Path) -> Path | BytesIO:
    """Return the path of a file, or what a pipe, which can be read only once, holds; "-" is standard input."""
    if str(path) != STDIN and (path.is_file() or not path.exists()):  # the reader reports that there is none
        return path
    if str(path) == STDIN:
        content = BytesIO(sys.stdin.buffer.read())
    else:
        with open_file(path) as file:
            content = BytesIO(file.read())
    content.name = name_of(path)
    return content


def _describe(error: Exception, name: str) -> str:
    """Return the message of an error with the file that it is about, and that file's folder."""
    if not isinstance(error, MocapFormatError):
        message = describe(error)
        return message if name in message else f"{name}: {message}"
    line, column = (
        f", {what} {value}" if value is not None else ""
        for what, value in (("line", error.line), ("column", error.column))
    )
    other = f"{name}: " if error.filename != name else ""
    return f"{other}{error.filename}{line}{column}: {error.message}"
