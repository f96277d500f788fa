"""A C3D file: its parameters, and which of its bytes are the frames.

A file has a header of one block, blocks of parameters, and frames: the points of each, then its analog samples. Header
and parameters both state how many there are and where. If they differ, the one that fits the length of the file is
taken, with a warning; if both or neither fit, the file is refused. Only what is requested of the parameters is decoded:
what points do not need cannot refuse a file. C3D user guide, https://www.c3d.org/HTML/default.htm.
"""

import math
import struct
from typing import NamedTuple

import numpy as np

from skpose.io._conventions import choose_rate
from skpose.io._source import Source

BLOCK = 512  # bytes
INTEL, DEC, MIPS = 84, 85, 86  # processors; MIPS has the high byte first
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
        self._source, self.processor, self.order = source, processor, ">" if processor == MIPS else "<"
        groups, records = dict[int, str](), list[tuple[int, str, bytes]]()
        at = BLOCK * (data[0] - 1) + 4
        while at < len(data) and (length := abs(int.from_bytes(data[at : at + 1], signed=True))):
            here = at + 2 + length
            name = data[at + 2 : here].split(b"\0")[0].decode("utf-8", errors="replace")
            group = int.from_bytes(data[at + 1 : at + 2], signed=True)
            offset = int.from_bytes(data[here : here + 2], "big" if processor == MIPS else "little")
            if here + 2 > len(data) or group == 0 or offset == 1:
                raise source.error(f"the parameter record at byte {at}, {name[:40]!r}, is damaged or cut short")
            at = here + offset if offset else len(data)  # it is 0 in the last record, or too large
            if group < 0:
                groups[-group] = name
            else:
                records.append((group, name, data[here + 2 : at]))
        self._records: dict[str, list[bytes]] = {}
        for group, name, record in records:
            self._records.setdefault(f"{groups.get(group, '')}:{name}".upper(), []).append(record)

    def _decode(self, name: str) -> tuple[int, tuple[int, ...], bytes] | None:
        """Kind, shape (the first dimension is the fastest) and bytes of a parameter; None if there is none."""
        records = self._records.get(name)
        if records is None:
            return None
        record = records[0]
        if any(other != record for other in records):
            raise self._source.error(f"expected one parameter {name}, found two that differ")
        kind, n_dims = struct.unpack("2b", record[:2].ljust(2, b"\0"))
        shape = tuple(record[2 : 2 + max(n_dims, 0)])
        n_bytes = math.prod(shape) * SIZES.get(kind, 0)
        data = record[2 + len(shape) :][:n_bytes]
        if kind not in SIZES or len(shape) != n_dims or len(data) != n_bytes:
            raise self._source.error(f"{name}: expected values of kind {kind} and shape {shape}, found fewer")
        return kind, shape, data

    def number(self, name: str, default: float) -> float:
        """The one finite number of a parameter; `default` where there is none."""
        if name not in self._records:
            return default
        values = self.numbers(name)
        if len(values) != 1 or not np.isfinite(values[0]):
            raise self._source.error(f"{name}: expected one finite number, found {values[:5].tolist()}")
        return float(values[0])

    def numbers(self, name: str) -> np.ndarray:
        """All numbers of a parameter, integers as signed ones; none where there is none."""
        kind, _, data = self._decode(name) or (4, (), b"")
        if kind == -1:
            raise self._source.error(f"{name}: expected numbers, found {data[:20]!r}")
        return self.floats(data) if kind == 4 else np.frombuffer(data, f"{self.order}i{kind}").astype(float)

    def texts(self, name: str) -> list[str]:
        """All texts of a parameter and its continuations, NAME2 and so on, without the blanks around them."""
        texts, i = list[str](), 1
        while found := self._decode(name if i == 1 else f"{name}{i}"):
            kind, shape, data = found
            if kind != -1:
                raise self._source.error(f"{name}: expected text, found numbers")
            width = max(shape[0], 1) if shape else 1
            pieces = (data[at : at + width] for at in range(0, len(data), width))
            texts += [piece.split(b"\0")[0].decode("utf-8", errors="replace").strip() for piece in pieces]
            i += 1
        return texts

    def floats(self, data: bytes) -> np.ndarray:
        """Floats of 32 bits; DEC has the words in the other order, and numbers four times as large."""
        if self.processor != DEC:
            return np.frombuffer(data, f"{self.order}f4").astype(np.float64)
        words = np.frombuffer(data, "<u4").astype(np.uint32)
        return (words >> 16 | words << 16).view(np.float32).astype(np.float64) / 4


def read_recording(source: Source, frame_rate: float | None) -> tuple[Parameters, float, np.ndarray]:
    """Parameters, frame rate, Hz, and positions (n_frames, n_points, 3) in the file's unit, NaN for lost markers."""
    data = source.data
    at = BLOCK * (data[0] - 1) + 3
    if len(data) < BLOCK or len(data) <= at:
        raise source.error(f"expected a header and parameters, found {len(data)} bytes; is the file cut short?")
    if data[at] not in (INTEL, DEC, MIPS):
        raise source.error(f"expected the processor 84, 85 or 86 in byte {at + 1}, found {data[at]}")
    header = struct.unpack(f"{'>' if data[at] == MIPS else '<'}10H", data[:20])
    # Where the header does not say where the frames begin, the parameters have as many blocks as they can say.
    start = BLOCK * (header[8] - 1)
    parameters = Parameters(source, data[: start if at < start <= len(data) else at + 256 * BLOCK], data[at])
    header_scale, header_rate = (float(parameters.floats(data[i : i + 4])[0]) for i in (12, 20))
    stated = parameters.number("POINT:RATE", 0.0) or header_rate
    rate = choose_rate(source, frame_rate, stated, "POINT:RATE")
    if not (rate > 0 and np.isfinite(rate) and np.isfinite(1 / rate)):
        raise source.error(f"POINT:RATE: expected a positive number, found {rate:g}: pass frame_rate=")
    scale = parameters.number("POINT:SCALE", header_scale)
    if scale == 0 or not np.isfinite(scale):
        raise source.error(f"POINT:SCALE: expected a number other than zero, found {scale:g}")
    has_scale = np.isfinite(header_scale) and header_scale != 0
    is_float = scale < 0, header_scale < 0 if has_scale else scale < 0
    frames = _find_frames(source, parameters, header, stated if stated > 0 else rate, is_float, BLOCK * data[0])
    if frame_rate is None and 0 < header_rate < np.inf and abs(header_rate - rate) > SAME_RATE * rate:
        source.warn(f"POINT:RATE is {rate:g} Hz, which is taken, but the header states {header_rate:g} Hz")
    if not frames.is_float and has_scale and abs(abs(header_scale) - abs(scale)) > SAME_SCALE * abs(scale):
        source.warn(f"POINT:SCALE is {scale:g}, which is taken, but the header states {header_scale:g}")
    rows = np.frombuffer(data, np.uint8, frames.n_frames * frames.n_bytes, frames.start).reshape(frames.n_frames, -1)
    points_data = rows[:, : 4 * frames.n_points * (4 if frames.is_float else 2)].tobytes()  # without analog samples
    numbers = parameters.floats(points_data) if frames.is_float else np.frombuffer(points_data, f"{parameters.order}i2")
    points = numbers.reshape(frames.n_frames, frames.n_points, 4)
    positions, lost = points[:, :, :3] * (1.0 if frames.is_float else abs(scale)), points[:, :, 3] < 0
    if lost.all() and (positions != positions[0, 0]).any():
        source.warn("all residuals are negative, but the positions differ: all markers are read as seen")
    else:
        positions[lost] = np.nan
    return parameters, rate, positions


def _find_frames(
    source: Source,
    parameters: Parameters,
    header: tuple[int, ...],
    rate: float,
    is_float: tuple[bool, bool],
    first: int,
) -> Frames:
    """Where the frames are, as parameters and header say; what only one of the two says is taken from it.

    Parameters
    ----------
    source, parameters, header, rate : Source, Parameters, tuple of int, float
        The file, its parameters, the words of its header, and Hz.
    is_float : tuple of bool
        Whether numbers are floats, by the parameters and by the header.
    first : int
        Bytes before the first that may be one of a frame.
    """
    used, length = parameters.number("POINT:USED", header[1]), len(source.data)
    if used <= 0:
        raise source.error("it holds no points: is it a file of analog channels, such as forces, alone?")
    n_frames = int(parameters.number("POINT:FRAMES", 0.0))
    n_frames += 65536 if -32768 <= n_frames < 0 else 0  # an integer without a sign; floats may be larger
    if n_frames == MANY_FRAMES:
        n_frames = int(parameters.number("POINT:LONG_FRAMES", n_frames))
    by_header = header[4] - header[3] + 1
    if header[4] == MANY_FRAMES and n_frames >= MANY_FRAMES:
        by_header = n_frames
    counts = [n_frames if n_frames > 0 else by_header, by_header if by_header > 0 else n_frames]
    blocks = int(parameters.number("POINT:DATA_START", 0.0)) % 65536, header[8]
    starts = [start for block in blocks if first <= (start := BLOCK * (block - 1)) <= length]
    if min(counts) <= 0 or not starts:
        raise source.error(f"it states {min(counts)} frames at block {header[8]}; is the file cut short, or damaged?")
    n_channels, ratio = int(parameters.number("ANALOG:USED", -1.0)), header[9]
    rates = parameters.number("ANALOG:RATE", 0.0) / rate
    if 0 < rates < MANY_FRAMES and not abs(rates - ratio) < 1:  # rates are rounded
        ratio = round(rates)
    n_analog = header[2] if n_channels < 0 else n_channels * ratio
    stated = [
        Frames(starts[0], int(used), n_analog, is_float[0], counts[0]),
        Frames(starts[-1], header[1] or int(used), header[2], is_float[1], counts[1]),
    ]
    return _choose(source, list(dict.fromkeys(stated)), length)


def _choose(source: Source, stated: list[Frames], length: int) -> Frames:
    """The frames as they are stated, or what of both fits the length of the file."""
    left = {one: length - one.start - one.n_frames * one.n_bytes for one in stated}
    fitting = [one for one in stated if 0 <= left[one] < BLOCK]
    if not fitting and len({one[:-1] for one in stated}) == 1:  # only the numbers of frames may differ
        fitting = [one for one in stated if left[one] >= 0]
    differ = ", ".join(f"{one.n_frames} frames of {one.n_points} points" for one in stated)
    if not fitting:
        raise source.error(f"it states {differ}, and holds {length} bytes, which are too few; is it cut short?")
    if len({one[:-1] for one in fitting}) > 1:
        raise source.error(f"header and parameters state {differ}, and both fit the length of the file")
    found = min(fitting)  # the fewest frames, as zeros may follow the last one
    if found.n_frames == MANY_FRAMES and left[found] >= BLOCK + found.n_bytes:
        raise source.error(f"it holds more than the {MANY_FRAMES} frames that it states, and no POINT:LONG_FRAMES")
    if len(stated) > 1:
        source.warn(
            f"header and parameters differ: {found.n_frames} frames of {found.n_points} points fit the length of the "
            "file"
        )
    return found
