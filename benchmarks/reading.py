"""How fast is a BVH file read, in how much memory, and what does another reader take? In one run.

    python benchmarks/reading.py [FOLDER OF CMU FILES]

The file has 50 MB, six digits after the point as most have, and a regular body, which pybvh reads too; a second one has
numbers of all lengths, as "%g" writes them. Readers take turns, the tables hold medians of five; positions of joints
are compared. Memory is what a process of its own holds at most beyond what it held before.
"""

import gzip
import io
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pybvh
from scipy.spatial.transform import Rotation
from timing import medians

from skpose import forward_kinematics
from skpose.datasets import make_gait
from skpose.io import load_amc, load_bvh, save_bvh

SIZE = 50e6  # bytes
READERS = {"skpose": load_bvh, "pybvh": lambda path: pybvh.read_bvh_file(path, world_up="+y")}


def write(path, form):
    """A file of so many bytes; the numbers of a motion of ours with noise, so that no two lines are the same."""
    motion = make_gait(n_subjects=1, n_sequences=1, random_state=0).motions[0]
    save_bvh(path, motion)
    head, _, rows = path.read_text().partition("Frames: ")
    table = np.loadtxt(io.StringIO(rows.split("\n", 2)[2]))
    noise = np.random.default_rng(0)
    per_frame = len(" ".join(form % x for x in table[0] + noise.normal(scale=0.1, size=len(table[0])))) + 1
    n_frames = int(SIZE / per_frame)
    table = table[np.arange(n_frames) % len(table)]
    table += noise.normal(scale=0.1, size=table.shape)
    with path.open("w") as file:
        file.write(f"{head}Frames: {n_frames}\nFrame Time: 0.008333\n")
        np.savetxt(file, table, fmt=form)
    return table.shape


def in_space(motion, frames):
    """Joint positions of some frames with the root's movement."""
    turn = Rotation.from_euler(motion.root_axes, motion.root_angles[frames])
    F = forward_kinematics(motion.angles[frames], motion.skeleton)
    return np.stack([turn.apply(F[:, i]) for i in range(F.shape[1])], axis=1) + motion.root_positions[frames, None]


def check(path):
    """The readers agree on where every joint is."""
    frames = [0, 1, 1000, -1]
    ours = in_space(load_bvh(path), frames)
    theirs = READERS["pybvh"](path).node_positions(centered="world")[frames, 1:]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9)


def memory(name, path):
    """Megabytes at most beyond what the process held before it read the file."""
    status = Path("/proc/self/status")

    def megabytes(what):
        return int(re.search(rf"{what}:\s+(\d+) kB", status.read_text())[1]) / 1e3

    READERS[name](Path(__file__).parents[1] / "tests" / "data" / "regular.bvh")  # what is imported on the way
    Path("/proc/self/clear_refs").write_text("5")  # VmHWM begins again
    before = megabytes("VmRSS")
    result = READERS[name](path)  # held, as what it is read for
    print(megabytes("VmHWM") - before)
    return result


def compare(form):
    """One file, and the table of what it took whom."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "big.bvh"
        shape = write(path, form)
        size, array = path.stat().st_size / 1e6, np.prod(shape) * 8 / 1e6
        print(f"Numbers as {form}: {size:.1f} MB, {shape[0]:,} frames of {shape[1]}, as an array {array:.1f} MB\n")
        check(path)
        compressed = path.with_suffix(".bvh.gz")
        compressed.write_bytes(gzip.compress(path.read_bytes(), 1))
        contestants = {name: lambda read=read: read(path) for name, read in READERS.items()}
        contestants["skpose, .gz"] = lambda: load_bvh(compressed)
        contestants["numpy.loadtxt, the numbers alone"] = lambda: np.loadtxt(path, skiprows=first_row(path))
        seconds = medians(contestants)
        print("| | s | MB/s | times as fast as pybvh | memory, MB | memory, arrays |")
        print("|---|---|---|---|---|---|")
        for name, taken in seconds.items():
            more = "- | -"
            if name in READERS:
                command = [sys.executable, __file__, "--memory", name, str(path)]
                held = float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
                more = f"{held:.0f} | {held / array:.2f}"
            print(f"| {name} | {taken:.2f} | {size / taken:.1f} | {seconds['pybvh'] / taken:.2f} | {more} |")
        print(flush=True)


def main():
    if sys.argv[1:2] == ["--memory"]:
        memory(*sys.argv[2:])
        return
    for form in ("%.6f", "%g"):
        compare(form)
    if len(sys.argv) > 1:
        amc = max(Path(sys.argv[1]).rglob("*.amc"), key=lambda path: path.stat().st_size)
        asf = amc.with_name(f"{amc.stem.rsplit('_', 1)[0]}.asf")
        taken = medians({"amc": lambda: load_amc(amc, asf)})["amc"]
        print(f"AMC, {amc.name}: {taken:.2f} s, {amc.stat().st_size / 1e6 / taken:.1f} MB/s")


def first_row(path):
    with path.open() as file:
        return next(i for i, line in enumerate(file) if line.startswith("Frame Time")) + 1


if __name__ == "__main__":
    main()
