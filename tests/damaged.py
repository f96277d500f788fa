"""Keypoints and archives with something wrong in them, and what readers do with them: for tests and the benchmark."""

import csv
import io
import json
import struct
import tempfile
import warnings
import zipfile
from pathlib import Path

import c3d_files
import mutations
import numpy as np

from skpose import Motion
from skpose.io import (
    MocapFormatError,
    load_amass,
    load_c3d,
    load_c3d_quantities,
    load_keypoints,
    load_motion,
    load_trc,
    save_npz,
)
from skpose.keypoints import Keypoints

NAMES = ["hip", "knee", "ankle"]


def trc_file(n_frames=20, *, points=None, names=NAMES):
    """Return a TRC file of markers in mm at 100 Hz; by default of three, the knee lost in some frames."""
    points = positions(n_frames) if points is None else points
    n_frames, n_markers, _ = points.shape
    head = "PathFileType\t4\t(X/Y/Z)\twalk.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\n"
    head += f"100.00\t100.00\t{n_frames}\t{n_markers}\tmm\t100.00\n"
    head += "Frame#\tTime\t" + "".join(f"{name}\t\t\t" for name in names)
    head += "\n\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(n_markers) for axis in "XYZ") + "\t\n\n"
    rows = []
    for k, row in enumerate(points):
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


def _trc_forms():
    """Return TRC files in the forms of several programs."""
    text = trc_file()
    lines = text.split(b"\n")
    seen = trc_file(points=np.nan_to_num(positions()))
    no_axes = b"\n".join(lines[:4] + lines[6:])
    more_names = b"\n".join([*lines[:3], lines[3] + b"toe\t\t\theel", *lines[4:]])
    return [text, seen.replace(b"\t", b" "), text.replace(b"\t", b","), no_axes, more_names + b"\t\t\t1\n\t\n"]


def _other_c3d_kinds():
    """Return C3D files of MIPS, of ten points, of points that are no positions, and one that contradicts itself."""
    ten = np.random.default_rng(7).uniform(-800, 800, (20, 10, 3))
    return [
        c3d_files.c3d_file(positions(), NAMES, processor=c3d_files.MIPS, step=0.05),
        c3d_files.c3d_file(ten, ["hip"] * 10, axis_up="-Z", ANGLE_UNITS="deg"),
        c3d_files.c3d_file(positions(), NAMES, ANGLES=["knee"], SCALARS=["toe"]),
        c3d_files.c3d_file(positions(), NAMES, USED=4, FRAMES=40),
    ]


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
        [{"image_id": f"{2 * i:06}.jpg", "keypoints": row.ravel().tolist()} for i, row in enumerate(array)],
        {str(i): {"time": i / 25, "keypoints_3d": frame} for i, frame in enumerate(array.tolist())},
        {"timestamps": [40 * i for i in range(n_frames)], "frames": rows.reshape(n_frames, -1).tolist()},
        coco | {"images": [{"id": i, "file_name": f"walk_{n_frames - i}.png"} for i in range(n_frames)]},
    ]


def csv_file(n_frames=20, key="frame", form="{}"):
    """Return a CSV file of three points and how sure each is, with the number and the time of each frame."""
    file = io.StringIO()
    axes = "x", "y", "z", "score"
    writer = csv.writer(file)
    writer.writerow([key, "time", *(f"{name}_{axis}" for name in NAMES for axis in axes)])
    for i, frame in enumerate(positions(n_frames)):
        writer.writerow(
            [form.format(i), i / 25, *("" if np.isnan(x) else f"{x:.3f}" for point in frame for x in (*point, 0.5))]
        )
    return file.getvalue().encode()


def amass_archives(n_frames=3):
    """Return motions of SMPL-H and SMPL-X, in the keys of AMASS."""
    rng = np.random.default_rng(8)
    poses = rng.normal(size=(n_frames, 165))
    common = {"trans": rng.normal(size=(n_frames, 3)), "betas": rng.normal(size=16), "gender": "neutral"}
    edges = {"root_orient": (0, 3), "pose_body": (3, 66), "pose_jaw": (66, 69), "pose_eye": (69, 75)}
    parts = {name: poses[:, first:last] for name, (first, last) in edges.items()} | {"pose_hand": poses[:, 75:]}
    x = {"poses": poses, "mocap_frame_rate": 59.94, "surface_model_type": "smplx", **parts}
    return [
        _saved(np.savez, poses=poses[:, :156], mocap_framerate=120.0, **common),
        _saved(np.savez_compressed, **x, **common),
    ]


def motion_archive():
    """Return a motion that `save_npz` wrote."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "motion.npz"
        save_npz(path, load_motion(io.BytesIO(mutations.BVH), scale=0.01))
        return path.read_bytes()


FILES = {
    "TRC": _trc_forms(),
    "C3D": c3d_kinds() + _other_c3d_kinds(),
    "NPY": [_saved(np.save, positions()), _saved(np.save, np.asfortranarray(positions(), np.float32))],
    "NPZ": [
        _saved(np.savez, keypoints=positions(), scores=np.ones((20, 3)), fps=25, names=NAMES),
        _saved(np.savez_compressed, positions=positions(), frame_rate=[25.0]),
    ],
    "JSON": [json.dumps(document).encode() for document in json_documents()],
    "CSV": [csv_file(), csv_file(key="image_id", form="walk_{:04}.png")],
    "AMASS": amass_archives(),
    "motion": [motion_archive()],
}
BYTES = [0, 1, 2, 4, 9, 10, 32, 44, 45, 46, 48, 57, 80, 84, 85, 86, 95, 127, 128, 254, 255]
OTHER_ARRAYS = [
    np.array(array)
    for array in (
        np.nan,
        np.inf,
        -1.0,
        0,
        1e300,
        10**18,
        "",
        "x",
        b"x",
        [],
        [[]],
        [1.0],
        [[np.nan] * 3],
        ["x"],
        True,
        1j,
    )
]
WORDS = [b"", b"NaN", b"1e999", b"-inf", b"1_0", b"1,5", b"9" * 40, b"1000000000", b"-1", b"x\ty", b"\t", b"\n", b"\r"]


ARRAYS = [(load_keypoints, {"names": NAMES, "frame_rate": 25, "scale": 0.001})]
READERS = {
    "TRC": [(load_trc, {}), (load_trc, {"trust": "rows", "zeros": "missing", "scale": 1, "frame_rate": 9, "up": "-y"})],
    "C3D": [(load_c3d, {}), (load_c3d, {"zeros": "missing", "scale": 1, "up": "-x"}), (load_c3d_quantities, {})],
    "NPY": ARRAYS,
    "NPZ": ARRAYS,
    "JSON": ARRAYS,
    "CSV": ARRAYS,
    "AMASS": [(load_amass, {}), (load_motion, {"hands": False, "on_nan": "drop"})],
    "motion": [(load_motion, {})],
}
KINDS = {load_c3d_quantities: dict, load_amass: Motion, load_motion: Motion}
ARCHIVES = "NPZ", "AMASS", "motion"


def damaged(kind, rng):
    """Return a file of a kind, one of FILES, with some damage."""
    data = bytearray(FILES[kind][rng.integers(len(FILES[kind]))])
    if kind in ARCHIVES and rng.random() < 0.7:
        return _damaged_entry(data, rng)
    if rng.random() < 0.25:
        return bytes(data[: rng.integers(len(data))])
    for _ in range(rng.integers(1, 4)):
        # The beginning states what follows.
        at = int(rng.integers(min(len(data), 1400) if rng.random() < 0.8 else len(data)))
        how = rng.integers(6)
        if how == 0 and kind == "C3D":
            data[at : at + 2] = struct.pack("<h", rng.choice([-32768, -2, -1, 0, 3, 255, 256, 32767]))
        elif how <= 3 and kind == "TRC" and rng.random() < 0.8:
            data = _damaged_line(data, rng)
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


def _damaged_entry(data, rng):
    """Return an archive, whole as an archive, with damage in an array, without one, or with one of another kind."""
    with zipfile.ZipFile(io.BytesIO(data)) as whole:
        entries = {name: whole.read(name) for name in whole.namelist()}
    name, other, how = *rng.choice(list(entries), 2), rng.integers(6)
    entry = bytearray(entries[name])
    if how == 0:
        del entries[name]
    elif how == 1:
        entries[name] = entries[other]
    elif how == 2:
        entries[name] = _saved(np.save, OTHER_ARRAYS[rng.integers(len(OTHER_ARRAYS))])
    elif how == 3:
        entries[name] = bytes(entry[: rng.integers(len(entry))])
    else:
        for _ in range(rng.integers(1, 4)):  # the header, or a number
            entry[rng.integers(len(entry) if how == 4 else min(len(entry), 128))] = rng.choice(BYTES)
        entries[name] = bytes(entry)
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, entry in entries.items():
            archive.writestr(name, entry)
    return file.getvalue()


def _damaged_line(data, rng):
    """Return a text with another word, separator or numbers in a line, or with the line in another place."""
    lines = data.split(b"\n")
    i = int(rng.integers(min(8, len(lines)) if rng.random() < 0.7 else len(lines)))
    cells, how = lines[i].split(b"\t"), rng.integers(6)
    if how <= 1:
        cells[rng.integers(len(cells))] = WORDS[rng.integers(len(WORDS))]
    elif how == 2:
        cells += [b""] * int(rng.integers(1, 4))
    elif how == 3:
        cells = lines[i].replace(b"\t", [b" ", b"  ", b"\t\t", b","][rng.integers(4)]).split(b"\t")
    elif how == 4:
        cells = lines[i].translate(bytes.maketrans(b"1234567890", b"0246813579")).split(b"\t")
    lines[i] = bytearray(b"\t".join(cells))
    if how == 5:
        lines.insert(int(rng.integers(len(lines))), lines[i] if rng.random() < 0.5 else bytearray(b"\t\t"))
    return bytearray(b"\n".join(lines))


def outcome(kind, data):
    """Return what its first reader makes of a file, "read" or "refused"; exceptions but MocapFormatError are raised."""
    outcomes = []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="the open file: ", category=UserWarning)
        warnings.filterwarnings("ignore", message="bones have the lengths of a person", category=UserWarning)
        for read, options in READERS[kind]:
            try:
                found = read(io.BytesIO(data), **options)
            except MocapFormatError as error:
                if not error.message or not str(error).startswith("the open file"):
                    raise AssertionError(f"an error without message or file name: {error!r}") from error
                outcomes.append("refused")
            else:
                if not isinstance(found, KINDS.get(read, Keypoints)):
                    raise AssertionError(f"not what it reads: {found!r}")
                outcomes.append("read")
    return outcomes[0]
