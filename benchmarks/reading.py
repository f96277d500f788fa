"""How fast are files read, in how much memory, and what does another reader take?

    pip install "skpose[bench]"
    python benchmarks/reading.py [--cmu FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Large files have 50 MB: a regular skeleton, which pybvh reads too, with numbers as programs write them: six digits after
the point, "%g", 17 digits; and frames of CMU's longest AMC file again and again. Real files are the longest recordings
of CMU and HDM05, as AMC; CMU's also as BVH, by `save_bvh` and with "%g". Readers take turns, the tables hold medians of
five; angles are compared with pybvh's to the last bit, those of AMC files with Python's float of each word.

Memory is what a process of its own holds at most beyond what it held before (VmHWM). Linux only.
"""

import argparse
import gzip
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path
from typing import NamedTuple

import common
import numpy as np
import pybvh

from skpose.io import AsfFile, load_amc, load_bvh, save_bvh
from skpose.io._acclaim import asf_path


class Size(NamedTuple):
    n_bytes: float  # of a large file
    n_files: int  # real ones of each collection
    repeats: int


FULL, QUICK = Size(50e6, 3, common.REPEATS), Size(1e6, 1, 1)
FORMS = "%.6f", "%g", "%.17g"


def pybvh_motion(path):
    return pybvh.read_bvh_file(path, world_up="+y")


def write(path, form, n_bytes):
    """Write a BVH file of so many bytes: the numbers of a generated motion with noise, so that all lines differ."""
    path.unlink(missing_ok=True)
    save_bvh(path, common.motions(None, 1, 1).motions[0])
    table, noise = table_of(path), np.random.default_rng(0)
    per_frame = len(" ".join(form % x for x in table[0] + noise.normal(scale=0.1, size=len(table[0])))) + 1
    table = table[np.arange(int(n_bytes / per_frame)) % len(table)]
    write_rows(path, table + noise.normal(scale=0.1, size=table.shape), form)


def table_of(path):
    """Return the numbers of a BVH file."""
    return np.loadtxt(path, skiprows=first_row(path))


def write_rows(path, table, form):
    """Replace the frames of a BVH file."""
    head = path.read_text().partition("Frames: ")[0]
    with path.open("w") as file:
        file.write(f"{head}Frames: {len(table)}\nFrame Time: 0.008333\n")
        np.savetxt(file, table, fmt=form)


def first_row(path):
    """Return the number of lines before the numbers."""
    with path.open() as file:
        return next(i for i, line in enumerate(file) if line.startswith("Frame Time")) + 1


def write_amc(path, source, n_bytes):
    """Write an AMC file of so many bytes: the frames of another, numbered anew."""
    head, *lines = source.read_bytes().partition(b"\n1\n")[::2]
    frames, frame = [], []
    for line in [*lines[0].splitlines(), b"0"]:
        if line.strip().isdigit():
            frames, frame = [*frames, b"\n".join(frame)], []
        else:
            frame.append(line)
    n = int(n_bytes * len(frames) / source.stat().st_size) + 1
    rows = [b"%d\n%s\n" % (k + 1, frames[k % len(frames)]) for k in range(n)]
    path.write_bytes(b"\n".join([head, b"".join(rows)]))


def check_bvh(path):
    """Compare the angles of both readers, to the last bit."""
    ours, theirs = load_bvh(path), pybvh_motion(path)
    np.testing.assert_array_equal(ours.angles, theirs.joint_angles[:, 1:].reshape(len(ours), -1))
    np.testing.assert_array_equal(ours.root_positions, theirs.root_pos)


def check_amc(path, asf):
    """Compare the angles with those of every word, read by float; each bone has its axes in the order x, y, z."""
    motion = load_amc(path, asf, frame_rate=120)
    numbers: dict[str, list[list[float]]] = {}
    for line in path.read_text(encoding="latin-1").splitlines():
        name, *words = line.split()
        if words and name[0] not in "#:":
            numbers.setdefault(name, []).append([float(word) for word in words])
    bones = [bone for bone in motion.skeleton.bones if bone.dofs]
    angles = np.radians(np.concatenate([np.array(numbers[bone.name]) for bone in bones], axis=1))
    np.testing.assert_array_equal(motion.angles, angles)


def in_a_new_process(*arguments):
    """Return what this program prints with these arguments."""
    command = [sys.executable, __file__, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def reader(name, asf):
    """Return a function that reads a path."""
    if asf:
        content = AsfFile(asf)
        return lambda path: load_amc(path, content, frame_rate=120)
    return {"skpose": load_bvh, "pybvh": pybvh_motion}[name]


def print_memory(name, path, small, asf=None):
    """Print the megabytes at most beyond what the process held before it read the file, and those of the arrays."""
    read = reader(name, asf)
    read(Path(small))  # what is imported once
    common.forget_peak_memory()
    before = common.memory("VmRSS")
    motion = read(Path(path))  # kept, so that it counts
    held = common.memory("VmHWM") - before
    arrays = ("angles", "root_positions", "root_angles") if name == "skpose" else ("joint_angles", "root_pos")
    print(held / (sum(getattr(motion, array).nbytes for array in arrays) / 1e6))


def compare(title, path, contestants, size, memory=()):
    """Print the rows of one file: time of every reader, and memory of some, by names and arguments."""
    megabytes = path.stat().st_size / 1e6
    seconds = common.medians(contestants, size.repeats, time.process_time)
    for name, taken in seconds.items():
        ratio = f"{seconds['pybvh'] / taken:.2f}" if "pybvh" in seconds else ""
        held = f"{float(in_a_new_process('--memory', name, path, *memory[name])):.2f}" if name in memory else ""
        print(f"| {title} | {megabytes:.1f} | {name} | {taken:.4f} | {megabytes / taken:.1f} | {ratio} | {held} |")
    sys.stdout.flush()


def bvh_readers(path):
    return {"skpose": lambda: load_bvh(path), "pybvh": lambda: pybvh_motion(path)}


def large_bvh(folder, form, size):
    """Print the rows of one large BVH file."""
    path, small = folder / "large.bvh", folder / "small.bvh"
    write(path, form, size.n_bytes)
    write(small, form, size.n_bytes / 50)
    check_bvh(path)
    compressed = path.with_suffix(".bvh.gz")
    compressed.write_bytes(gzip.compress(path.read_bytes(), 1))
    contestants = bvh_readers(path) | {"skpose, .gz": lambda: load_bvh(compressed)}
    contestants["numpy.loadtxt, the numbers alone"] = lambda: table_of(path)
    compare(f"generated BVH, {form}", path, contestants, size, {"skpose": [small], "pybvh": [small]})


def real_bvh(folder, files, size):
    """Print the rows of CMU recordings as BVH."""
    for file in files:
        path = folder / f"{file.stem}.bvh"
        save_bvh(path, load_amc(file, asf_path(file), frame_rate=120))
        for form in FORMS[:2]:
            if form != FORMS[0]:
                write_rows(path, table_of(path), form)
            check_bvh(path)
            compare(f"{path.name}, {form}", path, bvh_readers(path), size)


def amc(folder, files, size):
    """Print the rows of AMC files, and of a large one."""
    for file in files:
        asf = AsfFile(asf_path(file))
        check_amc(file, asf)
        compare(file.name, file, {"skpose": lambda file=file, asf=asf: load_amc(file, asf, frame_rate=120)}, size)
    large, file = folder / "large.amc", files[0]
    write_amc(large, file, size.n_bytes)
    asf = asf_path(file)
    check_amc(large, AsfFile(asf))
    contestants = {"skpose": lambda: load_amc(large, AsfFile(asf), frame_rate=120)}
    compare(f"frames of {file.name}", large, contestants, size, {"skpose": [file, asf]})


def largest(folder, n):
    return sorted(Path(folder).rglob("*.amc"), key=lambda path: path.stat().st_size)[-n:][::-1] if folder else []


def main():
    parser = common.parser_of_both(__doc__)
    parser.add_argument("--memory", nargs="+", help=argparse.SUPPRESS)  # reader and files of a process of its own
    options = parser.parse_args()
    warnings.filterwarnings("ignore", message=".* from end to end in the rest pose", category=UserWarning)
    if options.memory:
        print_memory(*options.memory)
        return
    common.print_machine()
    size = QUICK if options.quick else FULL
    cmu, hdm05 = largest(options.cmu, size.n_files), largest(options.hdm05, size.n_files)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        print("\n| file | MB | reader | CPU s | MB/s | times as fast as pybvh | memory, arrays |")
        print("|---|---|---|---|---|---|---|")
        for form in FORMS:
            large_bvh(folder, form, size)
        real_bvh(folder, cmu, size)
        if cmu or hdm05:
            amc(folder, cmu + hdm05, size)


if __name__ == "__main__":
    main()
