"""The header and the parameters of a C3D file, checked before ezc3d reads it.

ezc3d trusts what a file states: of damaged files it crashes on one of seventy, reads others without end or takes all
memory, and most of those that are cut short it takes for whole ones (benchmarks/ezc3d_alone.py). So every count that it
relies on is compared with the file's length here, record by record. C3D user guide, https://www.c3d.org/HTML/default.htm.
"""

import math
import struct
from typing import NamedTuple, NoReturn

import numpy as np

from skpose.io._source import Source

BLOCK = 512  # bytes
INTEL, DEC, MIPS = 84, 85, 86  # the processors whose numbers are in the file
SIZES = {-1: 1, 1: 1, 2: 2, 4: 4}  # bytes of one value: characters, bytes, integers, floats
MANY_FRAMES = 65535  # the largest count of POINT:FRAMES, which stands for larger ones as well
MOST_EMPTY = 1_000_000  # samples of no channels in all frames: ezc3d makes an object of each


class Parameter(NamedTuple):
    """A parameter of the file: characters (-1), bytes (1), integers (2) or floats (4), the first dimension fastest."""

    kind: int
    shape: tuple[int, ...]
    data: bytes


class Head(NamedTuple):
    """Numbers, units and names that a C3D file states about its points, in a file that is long enough for it."""

    n_frames: int
    n_points: int
    n_bytes: int  # of the file, to the end of the last frame
    frame_rate: float
    labels: list[str]
    unit: str
    axis_up: str


class Parameters:
    """The parameters of a C3D file, `GROUP:NAME` by name."""

    def __init__(self, source: Source, data: bytes):
        self._source = source
        self._start = BLOCK * (data[0] - 1)
        if len(data) < self._start + 4:
            self._refuse("the file ends before its parameters; is it cut short?")
        n_blocks, self.processor = data[self._start + 2 : self._start + 4]
        self._end = self._start + BLOCK * n_blocks
        if self.processor == MIPS:
            self._refuse("its numbers are in the format of MIPS, which ezc3d does not read: convert it to Intel's")
        if self.processor not in (INTEL, DEC):
            self._refuse(f"expected the processor 84, 85 or 86 in byte {self._start + 4}, found {self.processor}")
        if len(data) < self._end:
            self._refuse(f"its {n_blocks} blocks of parameters end at byte {self._end}, the file at {len(data)}")
        groups, parameters = dict[int, str](), dict[tuple[int, str], Parameter]()
        at: int | None = self._start + 4
        while at is not None:
            at = self._record(data, at, groups, parameters)
        if len(set(groups.values())) < len(groups):
            self._refuse("two groups of parameters have one name")
        self._by_name: dict[str, Parameter] = {
            f"{groups.get(group, '')}:{name}": value for (group, name), value in parameters.items()
        }
        self.groups: set[str] = set(groups.values())

    def _refuse(self, message: str) -> NoReturn:
        raise self._source.error(message)

    def _record(
        self, data: bytes, at: int, groups: dict[int, str], parameters: dict[tuple[int, str], Parameter]
    ) -> int | None:
        """Read the group or the parameter at a byte of the file; return where the next one is, None after the last."""
        if at >= self._end:
            self._refuse("its parameters have no end")
        length = abs(int.from_bytes(data[at : at + 1], signed=True))
        if length == 0:
            return None
        group = int.from_bytes(data[at + 1 : at + 2], signed=True)
        name = data[at + 2 : at + 2 + length].split(b"\0")[0].decode("utf-8", errors="replace")
        here = at + 2 + length
        where = f"the parameter record at byte {at}, {name[:40]!r},"
        if here + 5 > self._end:
            self._refuse(f"{where} goes beyond the parameters")
        offset = int.from_bytes(data[here : here + 2], "little")
        end = here + offset
        if group == 0 or end > self._end or (offset and offset < 3):
            self._refuse(f"{where} is damaged")
        here += 2
        if group < 0:
            groups[-group] = name
        else:
            kind, n_dims = struct.unpack("2b", data[here : here + 2])
            shape = tuple(data[here + 2 : here + 2 + max(n_dims, 0)])
            if kind not in SIZES or not 0 <= n_dims <= 7 or (n_dims == 0 and kind == -1):
                self._refuse(f"{where} has values of the kind {kind} in {n_dims} dimensions, which ezc3d does not read")
            here += 2 + n_dims
            size = math.prod(shape) * SIZES[kind]
            if here + size + 1 > self._end or math.prod(max(n, 1) for n in shape) > self._end:
                self._refuse(f"{where} has values of shape {shape}, which go beyond the parameters")
            parameters[group, name] = Parameter(kind, shape, data[here : here + size])
            here += size
        described = int.from_bytes(data[here : here + 1], signed=True)
        if described < 0 or here + 1 + described > self._end:
            self._refuse(f"{where} has a description of {described % 256} characters; ezc3d reads at most 127")
        here += 1 + described
        if offset == 0:
            return None
        if end != here:
            self._refuse(f"{where} states that the next one is at byte {end}, but it ends at {here}")
        return end

    def __contains__(self, name: str) -> bool:
        return name in self._by_name

    def numbers(self, name: str, default: float | None = None) -> np.ndarray:
        """Return all numbers of a parameter, signed integers, at least one; `default` where there is none."""
        parameter = self._by_name.get(name)
        if parameter is None:
            if default is None:
                self._refuse(f"it has no parameter {name}")
            return np.array([default])
        if parameter.kind == -1 or not parameter.data:
            self._refuse(f"{name}: expected a number, found {'text' if parameter.data else 'nothing'}")
        return self._values(parameter)

    def _values(self, parameter: Parameter) -> np.ndarray:
        if parameter.kind == 4:
            return floats(parameter.data, self.processor)
        return np.frombuffer(parameter.data, f"<i{parameter.kind}")

    def count(self, name: str) -> int:
        """Return how many values a parameter and its continuations, NAME2, NAME3 and so on, have."""
        return sum(math.prod(parameter.shape) for parameter in self._continued(name))

    def texts(self, name: str) -> list[str]:
        """Return all texts of a parameter and its continuations, without the blanks around them."""
        found = list[str]()
        for parameter in self._continued(name):
            if parameter.kind != -1:
                self._refuse(f"{name}: expected text, found numbers")
            width = parameter.shape[0]
            pieces = (parameter.data[i : i + width] for i in range(0, len(parameter.data), max(width, 1)))
            found += [piece.split(b"\0")[0].decode("utf-8", errors="replace").strip() for piece in pieces]
        return found

    def _continued(self, name: str) -> list[Parameter]:
        found, i = list[Parameter](), 1
        while parameter := self._by_name.get(name if i == 1 else f"{name}{i}"):
            found.append(parameter)
            i += 1
        return found


def floats(data: bytes, processor: int) -> np.ndarray:
    """Return floats of 32 bits of Intel or of DEC, whose words are in the other order and four times as large."""
    if processor == INTEL:
        return np.frombuffer(data, "<f4").astype(np.float64)
    words = np.frombuffer(data, "<u2").reshape(-1, 2)[:, ::-1]
    return np.ascontiguousarray(words).view("<f4").ravel().astype(np.float64) / 4.0


def read_head(source: Source, data: bytes, length: int) -> Head:
    """Return what the file states about its points.

    Parameters
    ----------
    source : Source
        The open file, for messages.
    data : bytes
        The file up to the end of its parameters, or more.
    length : int
        Bytes of the whole file.
    """
    parameters = Parameters(source, data)
    n_points, n_frames, rate = _counts(source, parameters, data)
    factor = _single(source, parameters, "POINT:SCALE", -1.0)
    if factor == 0 or "POINT:SCALE2" in parameters:
        raise source.error(f"POINT:SCALE: expected one number, not zero, found {factor:g}")
    n_samples = _samples(source, parameters, data, n_frames, rate)
    _check_rotations(source, parameters, n_frames, rate)
    start = int.from_bytes(data[16:18], "little")
    stated = int(_single(source, parameters, "POINT:DATA_START", start))
    if start < 2 or stated not in (start, start - 65536):
        raise source.error(f"the frames begin at block {start} by the header, and at {stated} by POINT:DATA_START")
    frame = (4 if factor < 0 else 2) * (4 * n_points + n_samples)
    n_bytes = BLOCK * (start - 1) + n_frames * frame
    if n_bytes > length:
        there = max(length - BLOCK * (start - 1), 0) // frame
        raise source.error(f"it states {n_frames} frames of {n_points} points, and holds {there}; is it cut short?")
    if n_frames == MANY_FRAMES and length - n_bytes >= BLOCK + frame:
        raise source.error(f"it holds more frames than the {MANY_FRAMES} that it states, which ezc3d does not read")
    units, axes = parameters.texts("POINT:UNITS"), parameters.texts("POINT:Y_SCREEN")
    labels = parameters.texts("POINT:LABELS")[:n_points]
    return Head(n_frames, n_points, n_bytes, rate, labels, "".join(units[:1]), "".join(axes[:1]))


def _single(source: Source, parameters: Parameters, name: str, default: float | None = None) -> float:
    values = parameters.numbers(name, default)
    if len(values) != 1 or not np.isfinite(values[0]):
        raise source.error(
            f"{name}: expected one finite number, found {', '.join(f'{value:g}' for value in values[:9])}"
        )
    return float(values[0])


def _counts(source: Source, parameters: Parameters, data: bytes) -> tuple[int, int, float]:
    """Return the numbers of points and of frames, and the frames per second."""
    n_points = int(_single(source, parameters, "POINT:USED"))
    if n_points == 0:
        raise source.error("it holds no points: is it a file of analog channels, such as forces, alone?")
    first, last = struct.unpack("<2H", data[6:10])
    n_frames = int(_single(source, parameters, "POINT:FRAMES", 0.0))
    n_frames = n_frames + 65536 if -32768 <= n_frames < 0 else n_frames
    n_frames = last - first + 1 if n_frames == 0 else n_frames
    if n_frames >= MANY_FRAMES:
        long = parameters.numbers("POINT:LONG_FRAMES", n_frames)
        if long[0] != n_frames or n_frames > MANY_FRAMES:
            raise source.error(f"it holds more than {MANY_FRAMES} frames, which ezc3d does not read")
    if n_points < 0 or n_frames < 1:
        raise source.error(f"it states {n_frames} frames of {n_points} points: expected at least one")
    rate = _single(source, parameters, "POINT:RATE", 0.0) or floats(data[20:24], parameters.processor)[0]
    if not (rate > 0 and np.isfinite(rate) and np.isfinite(1 / rate)):
        raise source.error(f"POINT:RATE: expected a positive number, found {rate:g}")
    return n_points, n_frames, float(rate)


def _samples(source: Source, parameters: Parameters, data: bytes, n_frames: int, rate: float) -> int:
    """Return the number of analog samples between the points of two frames."""
    n_channels = int(_single(source, parameters, "ANALOG:USED", 0.0))
    per_frame = int.from_bytes(data[18:20], "little")
    if rate >= 1:  # ezc3d goes by the rates then
        ratio = _single(source, parameters, "ANALOG:RATE", 0.0) / rate
        if n_channels and int(ratio) != per_frame:
            raise source.error(
                f"it has {per_frame} analog samples a frame by the header, and {ratio:g} by ANALOG:RATE: which are the "
                "points is not certain"
            )
        per_frame = int(ratio) if 0 <= ratio <= MOST_EMPTY else -1
    parameters.numbers("ANALOG:GEN_SCALE", 1.0)
    known = n_channels == 0 or min(parameters.count("ANALOG:SCALE"), parameters.count("ANALOG:OFFSET")) >= n_channels
    if n_channels < 0 or per_frame < 0 or not known:
        raise source.error(f"its {n_channels} analog channels need as many numbers in ANALOG:SCALE and ANALOG:OFFSET")
    if n_channels == 0 and per_frame * n_frames > MOST_EMPTY:
        raise source.error(f"ANALOG:RATE states {per_frame} analog samples a frame, but there are no analog channels")
    return n_channels * per_frame


def _check_rotations(source: Source, parameters: Parameters, n_frames: int, rate: float) -> None:
    """Refuse rotations, which some programs write behind the points and ezc3d reads without a check."""
    if "ROTATION" not in parameters.groups:
        return
    if _single(source, parameters, "ROTATION:USED", 0.0) != 0:
        raise source.error("it holds rotations of segments (ROTATION), not points alone, which is not supported")
    ratio = _single(source, parameters, "ROTATION:RATIO", 0.0)
    ratio = max(ratio, _single(source, parameters, "ROTATION:RATE", 0.0) / rate)
    parameters.numbers("ROTATION:DATA_START", 0.0)
    if not 0 <= ratio * n_frames <= MOST_EMPTY:
        raise source.error(f"ROTATION: expected no rotations, found {ratio:g} a frame")
