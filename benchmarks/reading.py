"""How fast is a BVH file read, in how much memory, and what does another reader take? In one run.

    pip install "skpose[bench]"
    python benchmarks/reading.py [FOLDER OF CMU FILES] [--quick]

The file has 50 MB, six digits after the point as most have, and a regular skeleton, which pybvh reads too; a second one
has numbers of all lengths, as "%g" writes them. Readers take turns, the tables hold medians of five; joint positions
are compared. Memory is what a process of its own holds at most beyond what it held before. Linux only.
"""

import argparse
import gzip
import io
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import common
import numpy as np
import pybvh
from scipy.spatial.transform import Rotation

from skpose import forward_kinematics
from skpose.io import load_amc, load_bvh, save_bvh


class Size(NamedTuple):
    n_bytes: float
    repeats: int


FULL, QUICK = Size(50e6, common.REPEATS), Size(1e6, 1)
READERS = {"skpose": load_bvh, "pybvh": lambda path: pybvh.read_bvh_file(path, world_up="+y")}


def write(path, form, n_bytes):
    """Write a file of so many bytes: the numbers of a generated motion with noise, so that all lines differ."""
    motion = common.motions(None, 1, 1).motions[0]
    save_bvh(path, motion)
    head, _, rows = path.read_text().partition("Frames: ")
    table = np.loadtxt(io.StringIO(rows.split("\n", 2)[2]))
    noise = np.random.default_rng(0)
    per_frame = len(" ".join(form % x for x in table[0] + noise.normal(scale=0.1, size=len(table[0])))) + 1
    n_frames = int(n_bytes / per_frame)
    table = table[np.arange(n_frames) % len(table)]
    table += noise.normal(scale=0.1, size=table.shape)
    with path.open("w") as file:
        file.write(f"{head}Frames: {n_frames}\nFrame Time: 0.008333\n")
        np.savetxt(file, table, fmt=form)
    return table.shape


def in_space(motion, frames):
    """Joint positions of some frames with the root's movement."""
    rotation = Rotation.from_euler(motion.root_axes, motion.root_angles[frames])
    F = forward_kinematics(motion.angles[frames], motion.skeleton)
    return np.stack([rotation.apply(F[:, i]) for i in range(F.shape[1])], axis=1) + motion.root_positions[frames, None]


def check(path):
    """Compare the joint positions of both readers."""
    frames = [0, 1, 1000, -1]
    ours = in_space(load_bvh(path), frames)
    theirs = READERS["pybvh"](path).node_positions(centered="world")[frames, 1:]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9)


def print_memory(name, path):
    """Print the megabytes at most beyond what the process held before it read the file; return what it read."""
    READERS[name](Path(__file__).parents[1] / "tests" / "data" / "regular.bvh")  # imports what a reader needs
    common.forget_peak_memory()
    before = common.memory("VmRSS")
    result = READERS[name](path)  # kept, so that it counts
    print(common.memory("VmHWM") - before)
    return result


def compare(form, size):
    """Print the table of one file: time and memory of every reader."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "big.bvh"
        shape = write(path, form, size.n_bytes)
        megabytes, array = path.stat().st_size / 1e6, np.prod(shape) * 8 / 1e6
        print(f"Numbers as {form}: {megabytes:.1f} MB, {shape[0]:,} frames of {shape[1]}, as an array {array:.1f} MB\n")
        check(path)
        compressed = path.with_suffix(".bvh.gz")
        compressed.write_bytes(gzip.compress(path.read_bytes(), 1))
        contestants = {name: lambda read=read: read(path) for name, read in READERS.items()}
        contestants["skpose, .gz"] = lambda: load_bvh(compressed)
        contestants["numpy.loadtxt, the numbers alone"] = lambda: np.loadtxt(path, skiprows=first_row(path))
        seconds = common.medians(contestants, size.repeats)
        print("| | s | MB/s | times as fast as pybvh | memory, MB | memory, arrays |")
        print("|---|---|---|---|---|---|")
        for name, taken in seconds.items():
            more = "- | -"
            if name in READERS:
                command = [sys.executable, __file__, "--memory", name, str(path)]
                held = float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
                more = f"{held:.0f} | {held / array:.2f}"
            print(f"| {name} | {taken:.2f} | {megabytes / taken:.1f} | {seconds['pybvh'] / taken:.2f} | {more} |")
        print(flush=True)


def first_row(path):
    """Return the number of lines before the numbers."""
    with path.open() as file:
        return next(i for i, line in enumerate(file) if line.startswith("Frame Time")) + 1


def amc(folder, size):
    """Print the speed of the largest AMC file of a folder."""
    path = max(Path(folder).rglob("*.amc"), key=lambda path: path.stat().st_size)
    asf = path.with_name(f"{path.stem.rsplit('_', 1)[0]}.asf")
    taken = common.medians({"amc": lambda: load_amc(path, asf)}, size.repeats)["amc"]
    print(f"AMC, {path.name}: {taken:.2f} s, {path.stat().st_size / 1e6 / taken:.1f} MB/s")


def main():
    parser = common.parser(__doc__)
    parser.add_argument("--memory", nargs=2, help=argparse.SUPPRESS)  # reader and file of a process of its own
    options = parser.parse_args()
    if options.memory:
        print_memory(*options.memory)
        return
    common.print_machine()
    size = QUICK if options.quick else FULL
    for form in ("%.6f", "%g"):
        compare(form, size)
    if options.folder:
        amc(options.folder, size)


if __name__ == "__main__":
    main()
