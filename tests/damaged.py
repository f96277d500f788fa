"""Files of keypoints with something wrong in them, and what their readers do with them; for tests and the benchmark."""

import csv
import io
import json
import struct
import warnings

import c3d_files
import numpy as np

from skpose.io import MocapFormatError, load_c3d, load_keypoints, load_trc
from skpose.keypoints import Keypoints

NAMES = ["hip", "knee", "ankle"]


def trc_file(n_frames=20):
    """Return a TRC file of three markers, the knee lost in some frames."""
    head = "PathFileType\t4\t(X/Y/Z)\twalk.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\n"
    head += f"100.00\t100.00\t{n_frames}\t3\tmm\t100.00\nFrame#\tTime\t" + "".join(f"{name}\t\t\t" for name in NAMES)
    head += "\n\t\t" + "\t".join(f"{axis}{i}" for i in (1, 2, 3) for axis in "XYZ") + "\t\n\n"
    rows = []
    for k, row in enumerate(positions(n_frames)):
        cells = ["" if np.isnan(number) else f"{number:.5f}" for number in row.ravel()]
        rows.append("\t".join([str(k + 1), f"{k / 100:.5f}", *cells]))
    return (head + "\n".join(rows) + "\n").encode()


def positions(n_frames=20):
    """Return positions, mm, of three markers, the knee lost in some frames."""
    found = np.random.default_rng(5).uniform(-800, 800, (n_frames, 3, 3))
    found[3:6, 1] = np.nan
    return found


def c3d_kinds():
    """Return C3D files that ezc3d reads too: floats and integers, Intel and DEC, with and without analog data."""
    analog = np.random.default_rng(6).normal(size=(20, 4, 2))
    return [
        c3d_files.c3d_file(positions(), NAMES, processor=processor, step=step, analog=samples, axis_up="+Z")
        for processor in (c3d_files.INTEL, c3d_files.DEC)
        for step in (None, 0.05)
        for samples in (None, analog)
    ]


def _saved(save, *arguments, **arrays):
    file = io.BytesIO()
    save(file, *arguments, **arrays)
    return file.getvalue()


def json_documents(n_frames=20):
    """Return keypoints as OpenPose, MediaPipe and COCO's style write them, mm, by name where a style has names."""
    array = np.nan_to_num(positions(n_frames))
    rows = np.concatenate([array, np.ones((n_frames, 3, 1))], axis=2)
    points = [[dict(zip("xyz", point, strict=True), visibility=0.9) for point in frame] for frame in array.tolist()]
    coco = {
        "images": [{"id": i} for i in range(n_frames)],
        "annotations": [{"image_id": i, "keypoints": row.ravel().tolist()} for i, row in enumerate(rows)],
        "categories": [{"keypoints": NAMES}],
    }
    return [
        [{"people": [{"pose_keypoints_3d": row.ravel().tolist()}]} for row in rows],
        {"fps": 25, "frames": [{"frame": i, "pose_world_landmarks": one} for i, one in enumerate(points)]},
        [dict(zip(NAMES, frame, strict=True)) for frame in points],
        coco,
    ]


def csv_file(n_frames=20):
    """Return a CSV file of three points and how sure each is."""
    file = io.StringIO()
    axes = "x", "y", "z", "score"
    writer = csv.writer(file)
    writer.writerow(["frame", *(f"{name}_{axis}" for name in NAMES for axis in axes)])
    for i, frame in enumerate(positions(n_frames)):
        writer.writerow([i, *("" if np.isnan(x) else f"{x:.3f}" for point in frame for x in (*point, 0.5))])
    return file.getvalue().encode()


FILES = {
    "TRC": [trc_file()],
    "C3D": c3d_kinds(),
    "NPY": [_saved(np.save, positions()), _saved(np.save, np.asfortranarray(positions(), np.float32))],
    "NPZ": [
        _saved(np.savez, keypoints=positions(), scores=np.ones((20, 3)), fps=25, names=NAMES),
        _saved(np.savez_compressed, positions=positions(), frame_rate=[25.0]),
    ],
    "JSON": [json.dumps(document).encode() for document in json_documents()],
    "CSV": [csv_file()],
}
BYTES = [0, 1, 2, 4, 9, 10, 32, 44, 45, 46, 48, 57, 80, 84, 85, 86, 95, 127, 128, 254, 255]
WORDS = [b"", b"NaN", b"1e999", b"-inf", b"1_0", b"1,5", b"9" * 40, b"1000000000", b"-1", b"x\ty", b"\t", b"\n", b"\r"]


def damaged(kind, rng):
    """Return a file of a kind, one of FILES, with some damage."""
    data = bytearray(FILES[kind][rng.integers(len(FILES[kind]))])
    if rng.random() < 0.25:
        return bytes(data[: rng.integers(len(data))])
    for _ in range(rng.integers(1, 4)):
        # The beginning states what follows.
        at = int(rng.integers(min(len(data), 1400) if rng.random() < 0.8 else len(data)))
        how = rng.integers(6)
        if how == 0 and kind == "C3D":
            data[at : at + 2] = struct.pack("<h", rng.choice([-32768, -2, -1, 0, 3, 255, 256, 32767]))
        elif how <= 1 and kind == "TRC":
            lines = data.split(b"\n")
            line = lines[rng.integers(min(8, len(lines)))].split(b"\t")
            line[rng.integers(len(line))] = WORDS[rng.integers(len(WORDS))]
            lines[rng.integers(min(8, len(lines)))] = b"\t".join(line)
            data = bytearray(b"\n".join(lines))
        elif how <= 1 and kind in ("JSON", "CSV"):
            words = data.split(b",")
            words[rng.integers(min(60, len(words)))] = WORDS[rng.integers(len(WORDS))]
            data = bytearray(b",".join(words))
        elif how == 2:
            del data[at : at + int(rng.integers(1, 600))]
        elif how == 3:
            data[at:at] = data[at : at + int(rng.integers(1, 600))]
        else:
            data[at : at + 1] = bytes([rng.choice(BYTES) if rng.random() < 0.7 else rng.integers(256)])
        if not data:
            break
    return bytes(data)


def outcome(kind, data):
    """Return "read" or "refused" for a file; any exception but MocapFormatError is raised."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="the open file: ", category=UserWarning)
        try:
            if kind == "TRC":
                found = load_trc(io.BytesIO(data))
            elif kind == "C3D":
                found = load_c3d(io.BytesIO(data))
            else:
                found = load_keypoints(io.BytesIO(data), names=NAMES, frame_rate=25, scale=0.001)
        except MocapFormatError as error:
            if not error.message or not str(error).startswith("the open file"):
                raise AssertionError(f"an error without message or file name: {error!r}") from error
            return "refused"
    if not isinstance(found, Keypoints):
        raise AssertionError(f"no keypoints: {found!r}")
    return "read"
