"""Files of every format, and damage to them, for tests."""

import csv
import io
import json
import tempfile
from pathlib import Path

import c3d_files
import numpy as np

from skpose.io import load_motion, save_npz

DATA = Path(__file__).parent / "data"
NAMES = ["hip", "knee", "ankle"]


def positions(n_frames=20):
    """Return positions, mm, of three markers, the knee lost in some frames."""
    found = np.random.default_rng(5).uniform(-800, 800, (n_frames, 3, 3))
    found[3:6, 1] = np.nan
    return found


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


def c3d_kinds():
    """Return C3D files that ezc3d reads too: floats and integers, Intel and DEC, with analog data."""
    analog = np.random.default_rng(6).normal(size=(20, 4, 2))
    return [
        c3d_files.c3d_file(positions(), NAMES, processor=processor, step=step, analog=analog, axis_up="+Z")
        for processor in (c3d_files.INTEL, c3d_files.DEC)
        for step in (None, 0.05)
    ]


def saved(save, *arguments, **arrays):
    file = io.BytesIO()
    save(file, *arguments, **arrays)
    return file.getvalue()


def json_documents(n_frames=20):
    """Return keypoints as MediaPipe and COCO's style write them, mm."""
    array = np.nan_to_num(positions(n_frames))
    points = [[dict(zip("xyz", point, strict=True), visibility=0.9) for point in frame] for frame in array.tolist()]
    rows = np.concatenate([array, np.ones((n_frames, 3, 1))], axis=2)
    coco = {
        "images": [{"id": i} for i in range(n_frames)],
        "annotations": [{"image_id": i, "keypoints": row.ravel().tolist()} for i, row in enumerate(rows)],
        "categories": [{"keypoints": NAMES}],
    }
    return [{"fps": 25, "frames": [{"frame": i, "pose_world_landmarks": one} for i, one in enumerate(points)]}, coco]


def csv_file(n_frames=20):
    """Return a CSV file of three points and how sure each is, with the number and the time of each frame."""
    file = io.StringIO()
    writer = csv.writer(file)
    writer.writerow(["frame", "time", *(f"{name}_{axis}" for name in NAMES for axis in ("x", "y", "z", "score"))])
    for i, frame in enumerate(positions(n_frames)):
        writer.writerow([i, i / 25, *("" if np.isnan(x) else f"{x:.3f}" for point in frame for x in (*point, 0.5))])
    return file.getvalue().encode()


def amass_archive(n_frames=3):
    """Return a motion of SMPL-H, in the keys of AMASS."""
    rng = np.random.default_rng(8)
    poses, trans = rng.normal(size=(n_frames, 156)), rng.normal(size=(n_frames, 3))
    return saved(np.savez, poses=poses, trans=trans, betas=rng.normal(size=16), gender="neutral", mocap_framerate=120.0)


def motion_archive():
    """Return a motion that `save_npz` wrote."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "motion.npz"
        save_npz(path, load_motion(DATA / "biped.bvh", scale=0.01))
        return path.read_bytes()


def mvnx_file(n_frames=20):
    """Return an MVNX file of three segments, with a pose of the calibration before the frames."""
    segments = "".join(f'<segment id="{i + 1}" label="{name}"><points/></segment>' for i, name in enumerate(NAMES))
    frames = f'<frame type="tpose"><position>{"0 " * 9}</position></frame>'
    for i, frame in enumerate(np.nan_to_num(positions(n_frames)) / 1000):
        numbers = " ".join(f"{x:.6f}" for x in frame.ravel())
        frames += f'<frame time="{10 * i}" type="normal"><orientation>1 0 0 0</orientation>'
        frames += f"<position>{numbers}</position></frame>\n"
    head = '<?xml version="1.0" encoding="UTF-8"?>\n<mvnx xmlns="http://www.xsens.com/mvn/mvnx" version="4">\n'
    subject = (
        f'<subject label="Anna" frameRate="100"><segments>{segments}</segments>\n<frames>{frames}</frames></subject>'
    )
    return f"{head}{subject}</mvnx>".encode()


def motive_file(n_frames=20):
    """Return Motive's CSV of a bone with a rotation and two markers, mm."""
    head = "Format Version,1.23,Take Name,Walk,Capture Frame Rate,200.0,Export Frame Rate,100.000000,Rotation Type,"
    lines = [f"{head}Quaternion,Length Units,Millimeters,Coordinate Space,Global", ""]
    lines += [",Type," + ",".join(7 * ["Bone"] + 6 * ["Marker"])]
    lines += [",Name," + ",".join(f'"{name}"' for name in 7 * NAMES[:1] + 3 * NAMES[1:2] + 3 * NAMES[2:])]
    lines += [",ID," + ",".join(13 * ["7"]), ",," + ",".join(4 * ["Rotation"] + 9 * ["Position"])]
    lines += ["Frame,Time (Seconds),X,Y,Z,W," + ",".join(3 * "XYZ")]
    for i, frame in enumerate(positions(n_frames)):
        cells = ["" if np.isnan(x) else f"{x:.6f}" for x in frame.ravel()]
        lines.append(",".join([str(i), f"{i / 100:.6f}", "0", "0", "0", "1", *cells]))
    return "\r\n".join(lines).encode()


def qualisys_file(n_frames=20, *, columns=True):
    """Return QTM's TSV of three markers, mm, with columns of the frame and the time or not."""
    lines = [f"NO_OF_FRAMES\t{n_frames}", "NO_OF_CAMERAS\t8", "NO_OF_MARKERS\t3", "FREQUENCY\t100", "DESCRIPTION\t--"]
    lines += ["DATA_INCLUDED\t3D", "\t".join(["MARKER_NAMES", *NAMES])]
    if columns:
        lines += ["\t".join(["Frame", "Time", *(f"{name} {axis}" for name in NAMES for axis in "XYZ")])]
    for i, frame in enumerate(positions(n_frames)):
        cells = ["" if np.isnan(x) else f"{x:.3f}" for x in frame.ravel()]
        lines.append("\t".join([str(i + 1), f"{i / 100:.5f}"] * columns + cells))
    return "\n".join(lines).encode()


FILES = {
    "BVH": [(DATA / "biped.bvh").read_bytes()],
    "ASF": [(DATA / "arm.asf").read_bytes()],
    "AMC": [(DATA / "arm.amc").read_bytes()],
    "TRC": [trc_file()],
    "C3D": c3d_kinds(),
    "NPY": [saved(np.save, positions())],
    "NPZ": [saved(np.savez, keypoints=positions(), scores=np.ones((20, 3)), fps=25, names=NAMES)],
    "JSON": [json.dumps(document).encode() for document in json_documents()],
    "CSV": [csv_file()],
    "AMASS": [amass_archive()],
    "motion": [motion_archive()],
    "MVNX": [mvnx_file()],
    "Motive CSV": [motive_file()],
    "Qualisys TSV": [qualisys_file(), qualisys_file(columns=False)],
}


def damaged(kind, rng):
    """Return a file of a kind, one of FILES, that is cut short, or with some bytes or words moved or changed."""
    data = bytearray(FILES[kind][rng.integers(len(FILES[kind]))])
    if rng.random() < 0.3:
        return bytes(data[: rng.integers(len(data))])
    for _ in range(rng.integers(1, 4)):
        at, length = int(rng.integers(min(len(data), 1500))), int(rng.integers(1, 60))  # the beginning states the rest
        how = rng.integers(4)
        if how == 0:
            del data[at : at + length]
        elif how == 1:
            data[at:at] = data[at : at + length]
        elif how == 2:
            data[at : at + 1] = rng.choice([b"nan", b"1e999", b"-", b"9" * 40, b"\n", b"{", b"0"])
        else:
            data[at : at + 1] = bytes([rng.integers(256)])
    return bytes(data)
