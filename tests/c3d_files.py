"""A small writer of C3D files, of any processor and number format.

It follows the C3D user guide, https://www.c3d.org/HTML/default.htm, and shares no code with the library.
"""

import math
import struct

import numpy as np

INTEL, DEC, MIPS = 84, 85, 86


def to_floats(values, processor):
    """Return numbers as the bytes of 32-bit floats of a processor."""
    values = np.asarray(values, np.float32)
    if processor == MIPS:
        return values.astype(">f4").tobytes()
    if processor == INTEL:
        return values.astype("<f4").tobytes()
    return (values * np.float32(4)).astype("<f4").view("<u2").reshape(-1, 2)[:, ::-1].tobytes()


def to_words(values, processor):
    return np.asarray(values).astype(">i2" if processor == MIPS else "<i2").tobytes()


def parameter(group, name, values, processor=INTEL, shape=None):
    """Return the record of a parameter: text, a list of texts, integers, or floats."""
    if isinstance(values, str):
        values = [values]
    if isinstance(values, list) and all(isinstance(value, str) for value in values):
        width = max(map(len, values), default=0)
        kind, shape, data = -1, (width, len(values)), "".join(value.ljust(width) for value in values).encode()
    else:
        values = np.asarray(values)
        shape = values.shape if shape is None else shape
        if values.dtype.kind == "f":
            kind, data = 4, to_floats(values.ravel(), processor)
        else:
            kind, data = 2, to_words(values.ravel(), processor)
    content = struct.pack("bB", kind, len(shape)) + bytes(shape) + data + b"\0"
    offset = struct.pack(">H" if processor == MIPS else "<H", len(content) + 2)
    return struct.pack("2b", len(name), group) + name.encode() + offset + content


def c3d_file(
    positions,
    labels,
    *,
    units="mm",
    rate=100.0,
    processor=INTEL,
    step=None,
    analog=None,
    axis_up=None,
    more=(),
    **changed,
):
    """Return a C3D file; positions (n, points, 3) are floats, or with `step` integers times it, NaN where lost.

    `analog` has shape (n, samples a frame, channels). `more` are further records; `changed` are parameters of the group
    POINT with other values, or None to leave them out.
    """
    n_frames, n_points, _ = positions.shape
    analog = np.zeros((n_frames, 0, 0)) if analog is None else analog
    point = {
        "USED": n_points,
        "FRAMES": n_frames if n_frames < 32768 else n_frames - 65536,
        "SCALE": -0.1 if step is None else step,
        "RATE": float(rate),
        "LABELS": labels,
        "UNITS": units,
        "DATA_START": 0,
        "Y_SCREEN": axis_up,
    }
    point |= changed
    records = [struct.pack("2b", 5, -1) + b"POINT", struct.pack("2b", 6, -2) + b"ANALOG"]
    records = [record + struct.pack(">H" if processor == MIPS else "<H", 3) + b"\0" for record in records]
    samples, channels = analog.shape[1:]
    start = 2
    for _ in range(2):  # once to learn where the frames start
        point["DATA_START"] = changed.get("DATA_START", start)
        made = [parameter(1, name, value, processor) for name, value in point.items() if value is not None]
        made += [
            parameter(2, "USED", channels, processor), parameter(2, "RATE", float(rate) * samples, processor),
            parameter(2, "SCALE", np.ones(channels), processor),
            parameter(2, "OFFSET", np.zeros(channels, int), processor),
            parameter(2, "GEN_SCALE", 1.0, processor),
        ]  # fmt: skip
        body = b"".join([*records, *made, *more]) + b"\0\0"
        n_blocks = math.ceil((len(body) + 4) / 512)
        start = 2 + n_blocks
    order = ">" if processor == MIPS else "<"
    head = b"\x02P" + struct.pack(order + "5H", n_points, samples * channels, 1, min(n_frames, 65535), 10)
    head += to_floats([-0.1 if step is None else step], processor) + struct.pack(order + "2H", start, samples)
    head += to_floats([rate], processor)
    section = bytes([1, 80, n_blocks, processor]) + body
    data = head.ljust(512, b"\0") + section.ljust(512 * n_blocks, b"\0") + frames(positions, analog, processor, step)
    return data + bytes(-len(data) % 512)


def frames(positions, analog, processor, step):
    lost = np.isnan(positions).any(axis=2)
    points = np.zeros((*lost.shape, 4))
    points[..., :3] = np.where(lost[..., None], 0.0, positions)
    points[..., 3] = np.where(lost, -1.0, 0.0)
    if step is not None:
        points[..., :3] = np.rint(points[..., :3] / step)
    numbers = np.concatenate([points.reshape(len(points), -1), analog.reshape(len(points), -1)], axis=1)
    return (to_floats if step is None else to_words)(numbers.ravel(), processor)


def with_header(data, processor=INTEL, **words):
    """Return a file with other words in its header: n_points, analog, first, last, start, samples, scale or rate."""
    data = bytearray(data)
    at = {"n_points": 2, "analog": 4, "first": 6, "last": 8, "scale": 12, "start": 16, "samples": 18, "rate": 20}
    for name, value in words.items():
        made = to_floats([value], processor) if name in ("scale", "rate") else to_words([value], processor)
        data[at[name] : at[name] + len(made)] = made
    return bytes(data)
