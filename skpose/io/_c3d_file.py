"""A C3D file: its parameters, and which of its bytes are the frames.

A file has a header of one block, blocks of parameters, and frames: the points of each, then its analog samples. Header
and parameters both state how many there are and where, and the length of the file is a third witness: where the two
differ, what the length fits is taken, with a warning, and where it does not decide, the file is refused. Only what is
requested of the parameters is decoded: what points do not need cannot refuse a file. C3D user guide,
https://www.c3d.org/HTML/default.htm.
"""

import io
import math
import struct
from itertools import product
from typing import NamedTuple, NoReturn

import numpy as np

from skpose.io._source import Source

BLOCK = 512  # bytes
INTEL, DEC, MIPS = 84, 85, 86  # the processors whose numbers are in the file; those of MIPS have the high byte first
SIZES = {-1: 1, 1: 1, 2: 2, 4: 4}  # bytes of one value: characters, bytes, integers, floats
MANY_FRAMES = 65535  # the largest count of POINT:FRAMES and of the header, which stands for larger ones as well
SAME_RATE, SAME_SCALE = 0.01, 1e-3  # relative differences between header and parameters that are rounding


class Frames(NamedTuple):
    """Place and content of the frames."""

    start: int  # bytes before the first frame
    n_points: int
    n_analog: int  # analog samples of a frame, of all channels
    is_float: bool
    n_frames: int

    @property
    def n_bytes(self) -> int:
        """The bytes of a frame."""
        return (4 * self.n_points + self.n_analog) * (4 if self.is_float else 2)

    def rest(self, length: int) -> int:
        """Return the bytes of a file of this length that follow the frames; negative if it is too short."""
        return length - self.start - self.n_frames * self.n_bytes


class Recording(NamedTuple):
    """Parameters, frame rate in Hz, and positions in the file's unit, NaN for lost markers."""

    parameters: "Parameters"
    frame_rate: float
    positions: np.ndarray  # (n_frames, n_points, 3)


def _order(processor: int) -> str:
    """Return the order of the bytes of integers, as struct and numpy call it."""
    return ">" if processor == MIPS else "<"


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
            self._records.setdefault(f"{groups.get(group, '')}:{name}".upper(), []).append(record)

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


def read_recording(source: Source) -> Recording:
    """Return parameters, frame rate, and positions (n_frames, n_points, 3) of a file."""
    file = source.seekable()
    length = file.seek(0, io.SEEK_END)
    file.seek(0)
    data = file.read(BLOCK)
    data += file.read(BLOCK * max(data[0], 1) - len(data))
    at = BLOCK * (data[0] - 1) + 3
    if len(data) < BLOCK or len(data) <= at:
        raise source.error(f"expected a header and parameters, found {len(data)} bytes; is the file cut short?")
    processor = data[at]
    if processor not in (INTEL, DEC, MIPS):
        raise source.error(f"expected the processor 84, 85 or 86 in byte {at + 1}, found {processor}")
    header = struct.unpack(f"{_order(processor)}10H", data[:20])
    # Where the header does not say where the frames begin, the parameters have as many blocks as they can say.
    start = BLOCK * (header[8] - 1)
    stop = start if at < start <= length else at + 256 * BLOCK
    data += file.read(max(stop - len(data), 0))
    parameters = Parameters(source, data[:stop], processor)
    frame_rate = _frame_rate(source, parameters, float(parameters.floats(data[20:24])[0]))
    factor, is_float = _factor(source, parameters, float(parameters.floats(data[12:16])[0]))
    frames = _find_frames(source, parameters, header, (BLOCK * data[0], length), frame_rate, is_float)
    file.seek(frames.start)
    rows = np.frombuffer(file.read(frames.n_frames * frames.n_bytes), np.uint8).reshape(frames.n_frames, -1)
    data = rows[:, : 4 * frames.n_points * (4 if frames.is_float else 2)].tobytes()  # without analog samples
    if frames.is_float:
        points = parameters.floats(data).reshape(frames.n_frames, frames.n_points, 4)
    else:
        points = np.frombuffer(data, f"{parameters.order}i2").reshape(frames.n_frames, frames.n_points, 4)
    positions = points[:, :, :3] * (1.0 if frames.is_float else abs(factor))
    return Recording(parameters, frame_rate, _lose(source, positions, points[:, :, 3] < 0))


def _lose(source: Source, positions: np.ndarray, lost: np.ndarray) -> np.ndarray:
    """Return the positions with NaN where a residual is negative, unless all are, at positions that differ."""
    if lost.all() and (positions != positions[0, 0]).any():
        source.warn(
            "all residuals are negative, which says that no marker is ever seen; as the positions differ, this program "
            "seems to write them so where it knows none, and all markers are read as seen"
        )
        return positions
    positions[lost] = np.nan
    return positions


def _frame_rate(source: Source, parameters: Parameters, by_header: float) -> float:
    rate = parameters.number("POINT:RATE", 0.0) or by_header
    if not (rate > 0 and np.isfinite(rate) and np.isfinite(1 / rate)):
        raise source.error(f"POINT:RATE: expected a positive number, found {rate:g}")
    if np.isfinite(by_header) and by_header > 0 and not abs(rate - by_header) <= SAME_RATE * rate:
        source.warn(f"POINT:RATE is {rate:g} Hz, which is taken, and the header says {by_header:g} Hz")
    return rate


def _factor(source: Source, parameters: Parameters, by_header: float) -> tuple[float, list[bool]]:
    """Return the unit of integers, and whether numbers are floats, by the parameters and by the header."""
    factor = parameters.number("POINT:SCALE", by_header)
    if factor == 0 or not np.isfinite(factor):
        raise source.error(f"POINT:SCALE: expected a number that is not zero, found {factor:g}")
    if not np.isfinite(by_header) or by_header == 0:
        return factor, [factor < 0]
    if factor > 0 and not abs(factor - abs(by_header)) <= SAME_SCALE * factor:
        source.warn(f"POINT:SCALE is {factor:g}, which is taken, and the header says {by_header:g}")
    return factor, [factor < 0, by_header < 0]


def _find_frames(
    source: Source,
    parameters: Parameters,
    header: tuple[int, ...],
    bounds: tuple[int, int],
    frame_rate: float,
    is_float: list[bool],
) -> Frames:
    """Return where the frames are: as header and parameters say, or what of both the length of the file fits.

    Parameters
    ----------
    source, parameters, header, frame_rate : Source, Parameters, tuple of int, float
        The file and what is known of it.
    bounds : tuple of int
        Bytes before the first that may be one of a frame, and those of the file.
    is_float : list of bool
        Whether numbers are floats, by the parameters and by the header.
    """
    stated = _list_layouts(source, parameters, header, bounds, frame_rate, is_float)
    length = bounds[1]
    agrees = len(stated) == 1 and parameters.number("POINT:USED", 0.0) > 0
    if agrees:
        _check_length(source, stated[0], length)
        return stated[0]
    differ = _difference(stated)
    fitting = [one for one in stated if 0 <= one.rest(length) < BLOCK]
    if not fitting and len({one[:-1] for one in stated}) == 1:  # only the number of frames differs
        fitting = [one for one in stated if one.rest(length) >= 0]
    if not fitting:
        raise source.error(
            f"it states {stated[0].n_frames} frames of {stated[0].n_points} points, but {differ}, and the length of "
            f"the file, {length} bytes, fits neither: is it cut short, or damaged?"
        )
    if len({one[:-1] for one in fitting}) > 1:
        raise source.error(
            f"{differ}, and the length of the file fits more than one: which are the points is not certain"
        )
    found = min(fitting)  # the fewest frames, as zeros may follow the last one
    source.warn(f"{differ}: {found.n_frames} frames of {found.n_points} points fit the length of the file")
    return found


def _list_layouts(
    source: Source,
    parameters: Parameters,
    header: tuple[int, ...],
    bounds: tuple[int, int],
    frame_rate: float,
    is_float: list[bool],
) -> list[Frames]:
    """Return all that header and parameters may mean, first what the parameters say; one where they agree."""
    used = parameters.number("POINT:USED", math.nan)
    if used == 0 or (math.isnan(used) and header[1] == 0):
        raise source.error("it holds no points: is it a file of analog channels, such as forces, alone?")
    n_frames = _n_frames(parameters, header)
    if used < 0 or not n_frames:
        count = n_frames[0] if n_frames else 0
        shown = header[1] if math.isnan(used) else used
        raise source.error(f"it states {count} frames of {shown:g} points: expected at least one")
    n_points = [n for n in (0 if math.isnan(used) else int(used), header[1]) if n > 0]
    blocks = header[8], int(parameters.number("POINT:DATA_START", 0.0)) % 65536
    starts = [start for start in (BLOCK * (block - 1) for block in blocks) if bounds[0] <= start <= bounds[1]]
    if not starts:
        raise source.error(
            f"the frames begin at block {header[8]} by the header, which cannot be: is the file cut short, or damaged?"
        )
    n_analog = _n_analog(parameters, header, frame_rate)
    every = [
        Frames(start, points, analog, floats, frames)
        for start, points, analog, floats, frames in product(starts, n_points, n_analog, is_float, n_frames)
    ]
    return list(dict.fromkeys(every))


def _difference(stated: list[Frames]) -> str:
    """Return in words what header and parameters state otherwise."""
    names = "bytes before the frames", "points", "analog samples a frame", "numbers are floats", "frames"
    parts = []
    for i, name in enumerate(names):
        values = list(dict.fromkeys(one[i] for one in stated))
        if len(values) > 1:
            parts.append(f"{name}: {' or '.join(map(str, values))}")
    if not parts:
        return "only the header says how many points there are"
    return f"its header and its parameters differ ({'; '.join(parts)})"


def _n_frames(parameters: Parameters, header: tuple[int, ...]) -> list[int]:
    """Return the number of frames by the parameters and by the header, those of both that say it."""
    by_parameters = int(parameters.number("POINT:FRAMES", 0.0))
    by_parameters += 65536 if -32768 <= by_parameters < 0 else 0
    if by_parameters == MANY_FRAMES:
        by_parameters = int(parameters.number("POINT:LONG_FRAMES", by_parameters))
    by_header = header[4] - header[3] + 1
    if header[4] == MANY_FRAMES and by_parameters >= MANY_FRAMES:
        by_header = 0
    return [n for n in (by_parameters, by_header) if n > 0]


def _n_analog(parameters: Parameters, header: tuple[int, ...], frame_rate: float) -> list[int]:
    """Return the number of analog samples of a frame by the header, by the channels, and by the rates."""
    n_channels = int(parameters.number("ANALOG:USED", -1.0))
    if n_channels < 0:
        return [header[2]]
    found = [n_channels * header[9], header[2]]
    ratio = parameters.number("ANALOG:RATE", 0.0) / frame_rate
    if 0 < ratio < MANY_FRAMES and not abs(ratio - header[9]) < 1:  # rates are rounded
        found.append(n_channels * round(ratio))
    return found


def _check_length(source: Source, frames: Frames, length: int) -> None:
    """Refuse a file that is too short for its frames, or holds more than can be stated."""
    left = frames.rest(length)
    if left < 0:
        there = (length - frames.start) // frames.n_bytes
        raise source.error(
            f"it states {frames.n_frames} frames of {frames.n_points} points, and holds {there}; is it cut short?"
        )
    if frames.n_frames == MANY_FRAMES and left >= BLOCK + frames.n_bytes:
        raise source.error(f"it holds more than the {MANY_FRAMES} frames that it states, and no POINT:LONG_FRAMES")
