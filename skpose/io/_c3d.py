"""Reader of C3D files, positions of markers as most motion-capture systems write them.

A file has a header of one block, blocks of parameters, and frames: the points of each, then its analog samples. What a
file states is compared with its length before any of it is used. Only what is requested of the parameters is decoded:
what points do not need cannot refuse a file. C3D user guide, https://www.c3d.org/HTML/default.htm.
"""

import io
import math
import struct
from typing import Literal, NamedTuple, NoReturn

import numpy as np

from skpose._validation.options import check_choice, check_positive
from skpose.io._arguments import Readable
from skpose.io._lengths import complaint_of_unit, metres_of
from skpose.io._source import Source
from skpose.keypoints import Keypoints

BLOCK = 512  # bytes
FIRST = 8 * BLOCK  # bytes, of which the first says in which of these blocks the parameters begin
INTEL, DEC, MIPS = 84, 85, 86  # the processors whose numbers are in the file; those of MIPS have the high byte first
SIZES = {-1: 1, 1: 1, 2: 2, 4: 4}  # bytes of one value: characters, bytes, integers, floats
MANY_FRAMES = 65535  # the largest count of POINT:FRAMES, which stands for larger ones as well
UP: dict[str, Literal["x", "y", "z"]] = {"+X": "x", "+Y": "y", "+Z": "z", "X": "x", "Y": "y", "Z": "z"}


def load_c3d(path: Readable, *, up: Literal["x", "y", "z"] | None = None, scale: float | None = None) -> Keypoints:
    """Read positions of markers from a C3D file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    up : {"x", "y", "z"}, default=None
        The axis that points up. None is the file's POINT:Y_SCREEN; where it has none, z, with a warning.
    scale : float, default=None
        Metres per unit of length. None is the unit that the file names, POINT:UNITS.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a marker is lost.

    Raises
    ------
    MocapFormatError
        If the file does not follow its format, is cut short, or holds no points; with its name and the parameter.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If the file does not say which axis points up. If it holds points without a label, which are left out. If the
        markers are less than 0.3 or more than 5 m apart: the file may name the wrong unit.

    See Also
    --------
    load_trc : Read a TRC file.
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    A marker is lost where its residual is negative. Numbers may be floats or scaled integers, of Intel, DEC or MIPS.
    Analog channels, events, force plates and rotations are left out.

    References
    ----------
    .. [1] Motion Lab Systems, "The C3D file format user guide", https://www.c3d.org/HTML/default.htm.

    Examples
    --------
    >>> from skpose.io import load_c3d
    >>> load_c3d("walk.c3d")  # doctest: +SKIP
    Keypoints(580 frames at 100 Hz, 5.8 s, 51 points, 0.8 % not seen)
    """
    if up is not None:
        check_choice("up", up, ("x", "y", "z"))
    if scale is not None:
        check_positive("scale", scale)
    with Source(path, "a C3D file", binary=True) as source:
        if source.binary != "C3D":
            raise source.error("expected a C3D file, whose second byte is 80; this is none, or is damaged")
        with source.format_errors():
            parameters, frames, positions = _read(source)
            labels = parameters.texts("POINT:LABELS")[: frames.n_points]
            named = _find_named(source, labels, frames.n_points)
            if scale is None and (scale := metres_of(unit := parameters.text("POINT:UNITS"))) is None:
                raise source.error(complaint_of_unit("POINT:UNITS", unit))
            up = _up(source, parameters.text("POINT:Y_SCREEN")) if up is None else up
            found = Keypoints(positions[:, named] * scale, [labels[i] for i in named], frames.frame_rate, up=up)
        source.warn_of_extent(found.positions, scale)
        return found


class Frames(NamedTuple):
    """The frames as a file states them, which is long enough for them."""

    n_frames: int
    n_points: int
    frame_rate: float  # Hz
    factor: float  # of integers; negative where numbers are floats
    start: int  # bytes before the first frame
    n_numbers: int  # of a frame, those of its analog samples included

    @property
    def size(self) -> int:
        """The bytes of a number."""
        return 4 if self.factor < 0 else 2


class Parameters:
    """The parameters of a C3D file, by `GROUP:NAME`; each is decoded when it is requested.

    Parameters
    ----------
    source : Source
        The file, for its errors.
    data : bytes
        The file from its beginning to the first frame.
    processor : int
        The one whose numbers these are.
    """

    def __init__(self, source: Source, data: bytes, processor: int):
        self._source, self.processor, self.order = source, processor, _order(processor)
        self._records: dict[str, list[bytes]] = {}
        groups, records = dict[int, str](), list[tuple[int, str, bytes]]()
        at = BLOCK * (data[0] - 1) + 4
        while at < len(data) and (length := abs(int.from_bytes(data[at : at + 1], signed=True))):
            here = at + 2 + length
            name = data[at + 2 : here].split(b"\0")[0].decode("utf-8", errors="replace")
            group = int.from_bytes(data[at + 1 : at + 2], signed=True)
            offset = int.from_bytes(data[here : here + 2], "big" if self.processor == MIPS else "little")
            end = here + offset if offset else len(data)  # 0 is that of the last record; of some it is too large
            if here + 2 > len(data) or group == 0 or offset == 1:
                self._refuse(f"the parameter record at byte {at}, {name[:40]!r}, is damaged or cut short")
            if group < 0:
                groups[-group] = name
            else:
                records.append((group, name, data[here + 2 : end]))
            at = end
        for group, name, record in records:
            self._records.setdefault(f"{groups.get(group, '')}:{name}", []).append(record)

    def _refuse(self, message: str) -> NoReturn:
        raise self._source.error(message)

    def _decode(self, name: str) -> tuple[int, tuple[int, ...], bytes] | None:
        """Return kind, shape (the first dimension is the fastest) and bytes of a parameter; None if there is none."""
        records = self._records.get(name)
        if not records:
            return None
        record = records[0]
        if any(other != record for other in records):
            self._refuse(f"it has two parameters {name}, which differ")
        kind, n_dims = struct.unpack("2b", record[:2].ljust(2, b"\0"))
        shape = tuple(record[2 : 2 + max(n_dims, 0)])
        data = record[2 + len(shape) :][: math.prod(shape) * SIZES.get(kind, 0)]
        if kind not in SIZES or len(shape) != n_dims or len(data) != math.prod(shape) * SIZES[kind]:
            self._refuse(f"{name}: its record has no values of the kind {kind} and shape {shape}; is it damaged?")
        return kind, shape, data

    def number(self, name: str, default: float | None = None) -> float:
        """Return the one finite number of a parameter, an integer as a signed one; `default` where there is none."""
        found = self._decode(name)
        if found is None:
            if default is None:
                self._refuse(f"it has no parameter {name}")
            return default
        kind, _, data = found
        if kind == -1 or not data:
            self._refuse(f"{name}: expected a number, found {'text' if data else 'nothing'}")
        values = self.floats(data) if kind == 4 else np.frombuffer(data, f"{self.order}i{kind}").astype(np.float64)
        if len(values) != 1 or not np.isfinite(values[0]):
            shown = ", ".join(f"{value:g}" for value in values[:9])
            self._refuse(f"{name}: expected one finite number, found {shown}")
        return float(values[0])

    def text(self, name: str) -> str:
        """Return the first text of a parameter, empty where there is none."""
        return next(iter(self.texts(name)), "")

    def texts(self, name: str) -> list[str]:
        """Return all texts of a parameter and its continuations, NAME2 and so on, without the blanks around them."""
        texts, i = list[str](), 1
        while found := self._decode(name if i == 1 else f"{name}{i}"):
            kind, shape, data = found
            if kind != -1:
                self._refuse(f"{name}: expected text, found numbers")
            width = max(shape[0], 1) if shape else 1
            pieces = (data[at : at + width] for at in range(0, len(data), width))
            texts += [piece.split(b"\0")[0].decode("utf-8", errors="replace").strip() for piece in pieces]
            i += 1
        return texts

    def floats(self, data: bytes) -> np.ndarray:
        """Return floats of 32 bits; those of DEC have their words in the other order, and are four times as large."""
        if self.processor != DEC:
            return np.frombuffer(data, f"{self.order}f4").astype(np.float64)
        words = np.frombuffer(data, "<u4").astype(np.uint32)
        return (words >> 16 | words << 16).view(np.float32).astype(np.float64) / 4


def _order(processor: int) -> str:
    """Return the order of the bytes of integers, as struct and numpy call it."""
    return ">" if processor == MIPS else "<"


def _read(source: Source) -> tuple[Parameters, Frames, np.ndarray]:
    """Return parameters, frames, and positions (n_frames, n_points, 3) in the file's unit, NaN for lost markers."""
    file = source.seekable()
    length = file.seek(0, io.SEEK_END)
    file.seek(0)
    data = file.read(FIRST)
    at = BLOCK * (data[0] - 1) + 3
    if len(data) < BLOCK or len(data) <= at:
        raise source.error(f"expected a header and parameters, found {len(data)} bytes; is the file cut short?")
    processor = data[at]
    if processor not in (INTEL, DEC, MIPS):
        raise source.error(f"expected the processor 84, 85 or 86 in byte {at + 1}, found {processor}")
    header = struct.unpack(f"{_order(processor)}10H", data[:20])
    start = BLOCK * (header[8] - 1)
    if not at < start <= length:
        raise source.error(f"the frames begin at block {header[8]} by the header: is the file cut short, or damaged?")
    data += file.read(max(start - len(data), 0))
    parameters = Parameters(source, data[:start], processor)
    frames = _frames(source, parameters, header, data[:24], length)
    file.seek(start)
    data = file.read(frames.n_frames * frames.n_numbers * frames.size)
    rows = np.frombuffer(data, np.uint8).reshape(frames.n_frames, -1)
    data = rows[:, : 4 * frames.n_points * frames.size].tobytes()  # without analog samples
    is_float = frames.factor < 0
    numbers = parameters.floats(data) if is_float else np.frombuffer(data, f"{parameters.order}i2").astype(np.float64)
    points = numbers.reshape(frames.n_frames, frames.n_points, 4)
    positions = points[:, :, :3] * (1.0 if is_float else frames.factor)
    positions[np.signbit(points[:, :, 3])] = np.nan
    return parameters, frames, positions


def _frames(source: Source, parameters: Parameters, header: tuple[int, ...], first: bytes, length: int) -> Frames:
    """Return what a file of so many bytes states about its frames, with the numbers of its header."""
    n_points = int(parameters.number("POINT:USED"))
    if n_points == 0:
        raise source.error("it holds no points: is it a file of analog channels, such as forces, alone?")
    n_frames = int(parameters.number("POINT:FRAMES", 0.0))
    n_frames += 65536 if -32768 <= n_frames < 0 else 0
    n_frames = n_frames or header[4] - header[3] + 1
    if n_frames == MANY_FRAMES:
        n_frames = int(parameters.number("POINT:LONG_FRAMES", n_frames))
    if n_points < 0 or n_frames < 1:
        raise source.error(f"it states {n_frames} frames of {n_points} points: expected at least one")
    frame_rate = parameters.number("POINT:RATE", 0.0) or float(parameters.floats(first[20:24])[0])
    if not (frame_rate > 0 and np.isfinite(frame_rate) and np.isfinite(1 / frame_rate)):
        raise source.error(f"POINT:RATE: expected a positive number, found {frame_rate:g}")
    factor = parameters.number("POINT:SCALE", float(parameters.floats(first[12:16])[0]))
    if factor == 0 or not np.isfinite(factor):
        raise source.error(f"POINT:SCALE: expected a number that is not zero, found {factor:g}")
    stated = parameters.number("POINT:DATA_START", 0.0)
    if stated not in (0, header[8], header[8] - 65536):
        raise source.error(
            f"the frames begin at block {header[8]} by the header, and at {stated:g} by POINT:DATA_START"
        )
    n_numbers = 4 * n_points + _analog_samples(source, parameters, header, frame_rate)
    frames = Frames(n_frames, n_points, frame_rate, factor, BLOCK * (header[8] - 1), n_numbers)
    n_bytes = n_numbers * frames.size
    there, left = divmod(length - frames.start, n_bytes)
    if there < n_frames:
        raise source.error(f"it states {n_frames} frames of {n_points} points, and holds {there}; is it cut short?")
    if n_frames == MANY_FRAMES and (there - n_frames) * n_bytes + left >= BLOCK + n_bytes:
        raise source.error(f"it holds more than the {MANY_FRAMES} frames that it states, and no POINT:LONG_FRAMES")
    return frames


def _analog_samples(source: Source, parameters: Parameters, header: tuple[int, ...], frame_rate: float) -> int:
    """Return the number of analog samples between the points of two frames, of all channels."""
    per_frame = header[9]
    n_channels = int(parameters.number("ANALOG:USED", header[2] // max(per_frame, 1)))
    if n_channels < 0:
        raise source.error(f"ANALOG:USED: expected a number of channels, found {n_channels}")
    ratio = parameters.number("ANALOG:RATE", 0.0) / frame_rate
    if n_channels and ratio and not abs(ratio - per_frame) < 1:  # rates are rounded
        raise source.error(
            f"it has {per_frame} analog samples a frame by the header, and {ratio:g} by ANALOG:RATE: which are the "
            "points is not certain"
        )
    return n_channels * per_frame


def _find_named(source: Source, labels: list[str], n_points: int) -> list[int]:
    """Return the indices of the points that have a name; refuse names that are given twice."""
    named = [i for i, label in enumerate(labels) if label]
    if not named:
        raise source.error("none of its points has a name (POINT:LABELS)")
    if twice := sorted({label for label in labels if label and labels.count(label) > 1}):
        raise source.error(
            f"POINT:LABELS: several points are named {', '.join(map(repr, twice[:9]))}: rename them, as points are "
            "matched by name"
        )
    if without := n_points - len(named):
        source.warn(f"{without} of {n_points} points have no label and are left out")
    return named


def _up(source: Source, axis: str) -> Literal["x", "y", "z"]:
    if not axis:
        source.warn(
            "it does not say which axis points up (POINT:Y_SCREEN): z is taken, as is usual; pass up= otherwise"
        )
        return "z"
    if (up := UP.get(axis.upper())) is None:
        raise source.error(f"POINT:Y_SCREEN: expected +X, +Y or +Z, found {axis[:40]!r}; up= chooses the axis")
    return up
