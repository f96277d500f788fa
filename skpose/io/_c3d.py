"""C3D files, positions of markers as most motion-capture systems write them, and quantities that models compute."""

import math
import re
import struct
from typing import Any, NamedTuple

import numpy as np

from skpose.io._conventions import Up, Zeros, check_options, choose_rate, keypoints_of_markers, number_names, read_unit
from skpose.io._source import MocapFormatError, Readable, Source, open_source
from skpose.keypoints import Keypoints
from skpose.keypoints._checks import UPS

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

    def _decode(self, name: str, what: str) -> tuple[int, tuple[int, ...], bytes] | None:
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
        is_whole = kind in SIZES and len(shape) == n_dims and len(data) == n_bytes
        if not is_whole or (kind == -1) != (what == "texts"):
            raise self._source.error(f"{name}: expected {what}, found {len(data)} bytes of kind {kind}, shape {shape}")
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
        kind, _, data = self._decode(name, "numbers") or (4, (), b"")
        return self.floats(data) if kind == 4 else np.frombuffer(data, f"{self.order}i{kind}").astype(float)

    def texts(self, name: str) -> list[str]:
        """All texts of a parameter and its continuations, NAME2 and so on, without the blanks around them."""
        texts, i = list[str](), 1
        while found := self._decode(name if i == 1 else f"{name}{i}", "texts"):
            _, shape, data = found
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


# --- c3d --------------------------------------------------------------------------------------------------------------


# The parameters of the group POINT that list labels of points that are not positions. POINT:TYPE_GROUPS names more of
# them, each with the singular of its name, by which its unit is found.
KINDS = "ANGLES", "SYMBOLIC_ANGLES", "FORCES", "MOMENTS", "POWERS", "REACTIONS", "SCALARS"
# Parts of the names of groups that list positions.
OF_MARKERS = "MARKER", "TRAJECTOR", "POINT", "LABEL", "DESCRIPTION"
# Words at the end of labels that are not positions by their names alone, before a number, a side or an axis. Points of
# the body and of things are: the inferior angle of the scapula, a marker of a triangle.
BY_NAME = {
    "angle": "ANGLES", "force": "FORCES", "grf": "FORCES", "moment": "MOMENTS", "torque": "MOMENTS", "power": "POWERS",
}  # fmt: skip
QUANTITY = re.compile(rf"({'|'.join(BY_NAME)})s?(?:[\s_.-]*\d+|[\s_.-]+(?:left|right|[lrxyz]))*\Z")
ANATOMICAL = re.compile(r"(?:tri|rect|quadr|(?:inf|sup|scap|acrom|stern|mandib|jaw|cost|rib)[a-z]*[\s_.-]*)angle")

Groups = dict[str, list[tuple[str, str]]]  # by a label without its prefix, the kind ("" for positions) and the prefix


class C3DQuantity(NamedTuple):
    """A quantity that a model has computed from markers in each frame, such as the angles of a joint, or an event."""

    kind: str  # "angles", "forces", "moments", "powers", "reactions", "scalars", "events" or another group of the file
    unit: str  # such as "deg", "N" or "Nmm"; empty if the file names none
    values: np.ndarray  # (n_frames, 3), as in the file, NaN where there are none; of events (n_events,), times, s


def load_c3d(
    path: Readable,
    *,
    up: Up | None = None,
    scale: float | None = None,
    frame_rate: float | None = None,
    zeros: Zeros | None = None,
) -> Keypoints:
    """Read positions of markers from a C3D file.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis that points up. By default the file's POINT:Y_SCREEN, or z, with a warning; or, with a warning, another
        axis if the points that stand still while others move are in one plane below these, as feet on a floor. If an
        axis points down, the world is turned by half a turn: about x for y and z, about y for x.
    scale : float, default=None
        Metres per unit of length. By default that of POINT:UNITS.
    frame_rate : float, default=None
        Frames per second, Hz. By default POINT:RATE; a number replaces it, with a warning if the two differ by more
        than 1 %.
    zeros : {"seen", "missing"}, default=None
        Whether a position of exactly (0, 0, 0) is a position or a lost marker. By default a position, with a warning.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a marker is lost.

    Raises
    ------
    MocapFormatError
        If the file is damaged, cut short, or holds no positions; with its name and the parameter.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If points are left out or numbered, positions are (0, 0, 0), all residuals are negative, the up axis is unknown
        or unlikely, header and parameters differ, or the markers are not of the size of a person.

    See Also
    --------
    load_c3d_quantities : Read angles, forces, moments, powers and scalars of a model.
    load_trc : Read a TRC file.
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    The labels that POINT:ANGLES, FORCES, MOMENTS, POWERS, REACTIONS, SCALARS and other groups of POINT:TYPE_GROUPS list
    are not positions, in any case of the letters, with or without the prefix of a subject (``Anna:LKneeAngles``). Nor
    are labels that no group lists and that end in Angle, Force, GRF, Moment, Torque or Power.

    A marker is lost where its residual is negative. Numbers may be floats or scaled integers, of Intel, DEC or MIPS.
    Analog channels, force plates and rotations are not read.

    References
    ----------
    .. [1] Motion Lab Systems, "The C3D file format user guide", https://www.c3d.org/HTML/default.htm.

    Examples
    --------
    >>> from skpose.io import load_c3d
    >>> load_c3d("walk.c3d")  # doctest: +SKIP
    Keypoints(580 frames at 100 Hz, 5.8 s, 51 points, 0.8 % not seen)
    """
    check_options(up=up, zeros=zeros, scale=scale, frame_rate=frame_rate)
    source = open_source(path, "a C3D file", binary=True)
    with source.format_errors():
        parameters, rate, all_positions, names, kinds = _read(source, frame_rate)
        chosen = [i for i in names if i not in kinds]
        if kinds:
            message = f"{len(kinds)} of {len(names)} points are not positions of markers, such as {names[min(kinds)]!r}"
            if not chosen:
                raise source.error(f"{message}: load_c3d_quantities reads them")
            source.warn(f"{message} and are left out; load_c3d_quantities reads them by their names")
        labels = [names[i] for i in chosen]
        units = parameters.texts("POINT:UNITS") if scale is None else _texts_if_any(parameters, "POINT:UNITS")
        scale = read_unit(source, "POINT:UNITS", units[0] if units else "", scale)
        usual = _up(source, parameters) if up is None else (up, "")
        return keypoints_of_markers(source, all_positions[:, chosen], labels, rate, scale, zeros, up, usual)


def load_c3d_quantities(path: Readable) -> dict[str, C3DQuantity]:
    """Read angles, forces, moments, powers and scalars, which models such as Plug-in Gait write, and events.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.

    Returns
    -------
    dict of str to C3DQuantity
        By label, in the order of the file: `kind`, such as "angles" or "moments", `unit`, such as "deg", and `values`,
        (n_frames, 3), of the points that are not positions, see the notes of `load_c3d`. Events, such as "Left Foot
        Strike", follow with the kind "events" and times (n_events,) since the first frame, s; `gait_events` takes them.

    Raises
    ------
    MocapFormatError
        If the file is damaged or cut short; with its name and the parameter.
    OSError
        If it cannot be read.

    See Also
    --------
    load_c3d : Read the positions of the markers.

    Notes
    -----
    Axes, signs and order of angles are those of the model that computed them; the file does not state them.

    Examples
    --------
    >>> from skpose.io import load_c3d_quantities
    >>> quantities = load_c3d_quantities("walk.c3d")  # doctest: +SKIP
    >>> quantities["LKneeAngles"].unit, quantities["LKneeAngles"].values.shape  # doctest: +SKIP
    ('deg', (580, 3))
    """
    source = open_source(path, "a C3D file", binary=True)
    with source.format_errors():
        parameters, rate, positions, names, kinds = _read(source, None)
        found = dict[str, C3DQuantity]()
        for i, kind in kinds.items():
            units = parameters.texts(f"POINT:{kind.removesuffix('S')}_UNITS")
            found[names[i]] = C3DQuantity(kind.lower(), next(iter(units), ""), positions[:, i])
        first = int.from_bytes(source.data[6:8], "big" if parameters.processor == MIPS else "little")
        times = parameters.numbers("EVENT:TIMES").reshape(-1, 2) @ [60.0, 1.0] - (first - 1) / rate  # min and s
        contexts, labels = (_texts_if_any(parameters, name) for name in ("EVENT:CONTEXTS", "EVENT:LABELS"))
        contexts, n = contexts or [""] * len(labels), len(times)
        if min(len(contexts), len(labels)) < n:
            raise source.error(f"expected a context and a label for each of {n} events, found {len(labels)}")
        words = zip(contexts[:n], labels[:n], times, strict=True)
        events = [(f"{context} {label}".strip(), time) for context, label, time in words]
        for name in dict.fromkeys(name for name, _ in events):
            found[name] = C3DQuantity("events", "s", np.array([time for other, time in events if other == name]))
        return found


def _read(
    source: Source, frame_rate: float | None
) -> tuple[Parameters, float, np.ndarray, dict[int, str], dict[int, str]]:
    """A recording, and by the indices of its points the names, where they have one, and the kinds of quantities."""
    if source.kind != "C3D":
        raise source.error("expected a C3D file, whose second byte is 80")
    parameters, rate, positions = read_recording(source, frame_rate)
    n_points = positions.shape[1]
    labels = parameters.texts("POINT:LABELS")[:n_points]
    named = [i for i, label in enumerate(labels) if label]
    if not named:
        source.warn(f"none of its {n_points} points has a name (POINT:LABELS): they are called by their numbers")
        return parameters, rate, positions, {i: str(i + 1) for i in range(n_points)}, {}
    if without := n_points - len(named):
        source.warn(f"{without} of {n_points} points have no label and are left out")
    names = number_names(source, [labels[i] for i in named])
    groups = _list_groups(parameters)
    kinds = {i: kind for i in named if (kind := _kind_of(labels[i], groups))}
    return parameters, rate, positions, dict(zip(named, names, strict=True)), kinds


def _list_groups(parameters: Parameters) -> Groups:
    more = [group.upper() for group in _texts_if_any(parameters, "POINT:TYPE_GROUPS")]
    found: Groups = {}
    for group in dict.fromkeys([*KINDS, "MODELED_MARKERS", "VIRTUAL_MARKERS", *more]):
        kind, name = "" if any(part in group for part in OF_MARKERS) else group, f"POINT:{group}"
        for label in parameters.texts(name) if group in KINDS else _texts_if_any(parameters, name):
            if label:
                prefix, rest = _split(label)
                found.setdefault(rest, []).append((kind, prefix))
    return found


def _texts_if_any(parameters: Parameters, name: str) -> list[str]:
    """The texts of a parameter that points do not need: none if it is damaged."""
    try:
        return parameters.texts(name)
    except MocapFormatError:
        return []


def _split(label: str) -> tuple[str, str]:
    """The prefix of a label, as that of a subject before a colon, and the rest, in lower case."""
    prefix, _, name = label.lower().rpartition(":")
    return prefix.strip(), name.strip()


def _kind_of(label: str, groups: Groups) -> str:
    """The kind of quantity of a label, empty for a marker.

    Labels are the same in any case of the letters, and where one of them has no prefix: of two subjects both have one.
    """
    prefix, name = _split(label)
    for kind, other in groups.get(name, []):
        if not prefix or other in (prefix, ""):
            return kind
    match = QUANTITY.search(name)
    return "" if match is None or ANATOMICAL.search(name) else BY_NAME[match[1]]


def _up(source: Source, parameters: Parameters) -> tuple[Up, str]:
    """The direction that points up by the file, and why it is taken."""
    axis = next(iter(parameters.texts("POINT:Y_SCREEN")), "")
    if not axis:
        source.warn("it does not say which axis points up (POINT:Y_SCREEN): z is taken; pass up= otherwise")
        return "z", "as is usual"
    up: Any = axis.lower().lstrip("+")
    if up not in UPS:
        raise source.error(f"POINT:Y_SCREEN: expected +X, +Y, +Z, -X, -Y or -Z, found {axis[:40]!r}: pass up=")
    return up, "by POINT:Y_SCREEN"
