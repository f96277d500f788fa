"""How fast is a matrix of distances written: by page faults, by position, and by workers?

    pip install "skpose[bench,zarr]"
    python benchmarks/writing.py [--poses N] [--scratch FOLDER] [--quick]

Distances between numbers, which take almost no time to compute, in float32 into a file or a zarr array in the scratch
folder, 1 GB for the N of 16,384. Times end when all bytes are on the disk. Every contestant's matrix is compared with
the first one's, and that with numpy's. The processor time is that of this process, not of its workers. From these
figures, what a million poses would take.
"""

import argparse
import os
import shutil
import statistics
import tempfile
import time
import zlib
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path

import common
import joblib
import numpy as np
import zarr

import skpose.metrics._tiled
import skpose.metrics._writers
from skpose import pose_distances
from skpose._files import sync
from skpose.metrics._run import ResumedRun
from skpose.metrics._tiles import MIRROR_EDGE
from skpose.metrics._writers import ArrayWriter, FileTarget

N_WORKERS = 2
CHUNK = 2048  # of zarr's; also the edge of the tiles that workers compute
BAND = 1024  # rows that are compared at once
MILLION, N_CORES, HOURS = 1_000_000, 64, 1.4  # the last as `scaling.py` calculates it


class PageFaults:
    """Writes through a mapping, as `FileWriter` does by position: what it is compared with."""

    def __init__(self, target):
        array = np.memmap(target.path, target.dtype, "r+", target.start, target.shape)
        self.array, self.writer = array, ArrayWriter(array, array.base)

    def write(self, tile, mirrored, distances):
        self.writer.write(tile, mirrored, distances)
        return self.checksums(tile, mirrored)

    def checksums(self, tile, mirrored):
        return [self.checksum(tile), 0 if mirrored is None else self.checksum(mirrored)]

    def checksum(self, tile):
        known = 0
        for top in range(tile.top, tile.bottom, MIRROR_EDGE):
            rows = self.array[top : min(top + MIRROR_EDGE, tile.bottom), tile.left : tile.right]
            known = zlib.crc32(np.ascontiguousarray(rows), known)
            self.writer.release()
        return known

    def sync(self):
        """Leave that to the end."""

    def change(self):
        """Look for none."""


@contextmanager
def page_faults(n_jobs=None):
    """Write through a mapping, in this process; workers only compute."""
    with ExitStack() as stack:
        stack.enter_context(replaced(FileTarget, "open_writer", lambda target: nullcontext(PageFaults(target))))
        stack.enter_context(replaced(ResumedRun, "_for_workers", lambda run: None))
        if n_jobs:
            stack.enter_context(workers())
        yield


@contextmanager
def replaced(where, name, value):
    before = getattr(where, name)
    setattr(where, name, value)
    try:
        yield
    finally:
        setattr(where, name, before)


def workers():
    return joblib.parallel_config(backend="loky", n_jobs=N_WORKERS)


def one_wait():
    """Wait for the disk at the end alone, which is what the waits in between are compared with."""
    return replaced(skpose.metrics._writers, "fdatasync", lambda _: None)


def new_file(folder, n):
    return np.lib.format.open_memmap(folder / "D.npy", mode="w+", dtype=np.float32, shape=(n, n))


def new_zarr(folder, n):
    return zarr.create_array(folder / "D.zarr", shape=(n, n), dtype=np.float32, chunks=(CHUNK, CHUNK))


CONTESTANTS = {  # name: a new destination, and the context
    "in memory, nothing is written": (lambda _, n: np.empty((n, n), np.float32), nullcontext),
    "page faults": (new_file, page_faults),
    "by position": (new_file, nullcontext),
    "by position, one wait for the disk": (new_file, one_wait),
    "workers compute, page faults": (new_file, lambda: page_faults(N_WORKERS)),
    "workers write": (new_file, workers),
    "zarr, this process": (new_zarr, nullcontext),
    "zarr, workers write": (new_zarr, workers),
}


def written(X, folder, name):
    """Write the matrix; return it, seconds, and seconds of this process's processor time."""
    create, context = CONTESTANTS[name]
    out = create(folder, len(X))
    start, used = time.perf_counter(), time.process_time()
    with context():
        pose_distances(X, metric="angle", out=out, n_jobs=N_WORKERS)
    if create is new_file:
        out.flush()
        sync(folder / "D.npy")
    return out, time.perf_counter() - start, time.process_time() - used


def race(X, folder, repeats):
    """Return for each contestant the medians of MB/s and of processor time, s/GB; matrices are compared."""
    megabytes, taken = 4 * len(X) ** 2 / 1e6, {name: [] for name in CONTESTANTS}
    order = np.random.default_rng(0)
    for repeat in range(1 + repeats):  # the first one starts the workers and compiles
        for name in order.permutation(list(CONTESTANTS)):  # who is next finds the memory that another left
            os.sync()
            out, seconds, used = written(X, folder, name)
            taken[name].append((megabytes / seconds, 1000 * used / megabytes))
            if repeat == 0:
                check(out, X)
            del out
            for path in folder.iterdir():
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    return {name: [statistics.median(column) for column in zip(*rows[1:], strict=True)] for name, rows in taken.items()}


def check(out, X):
    """Compare a matrix with numpy's, row by row."""
    for top in range(0, len(X), BAND):
        np.testing.assert_array_equal(out[top : top + BAND], np.abs(X[top : top + BAND] - X.T))


def predict(rates):
    """Print how long the writing of a million poses would take: an extrapolation."""
    gigabytes = 4 * MILLION**2 / 1e9
    print(f"\nA million poses, {gigabytes:,.0f} GB in float32, extrapolated from these figures:")
    for name in ("page faults", "by position"):
        print(f"  one process, {name}: {1000 * gigabytes / rates[name][0] / 3600:.1f} h")
    used = {name: gigabytes * rates[name][1] / 3600 for name in ("workers compute, page faults", "workers write")}
    print(
        "  this process's processor time, where workers compute: "
        f"{used['workers compute, page faults']:.1f} h; where they write too: {used['workers write']:.2f} h"
    )
    each, needed = rates["workers write"][0] / N_WORKERS, 1000 * gigabytes / HOURS / 3600
    hours = 1000 * gigabytes / each / N_CORES / 3600
    print(
        f"  {N_CORES} workers writing, each at 1/{N_WORKERS} of this rate: {hours:.2f} h beyond {HOURS} h to compute,"
    )
    print(f"  if the file system that they share takes {needed:.0f} MB/s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=16_384)
    parser.add_argument("--scratch", help="folder for the matrices; default: a temporary one")
    parser.add_argument("--repeats", type=int, default=common.REPEATS)
    parser.add_argument("--quick", action="store_true", help="check the answers in seconds; times mean nothing")
    options = parser.parse_args()
    common.print_machine()
    n, repeats = (4200, 1) if options.quick else (options.poses, options.repeats)
    skpose.metrics._tiled.WORTH_SENDING = 0  # work that takes as little time as this stays in one process otherwise
    X = np.random.default_rng(0).normal(size=(n, 1)).astype(np.float32)
    folder = Path(tempfile.mkdtemp(dir=options.scratch))
    try:
        rates = race(X, folder, repeats)
    finally:
        shutil.rmtree(folder)
    print(f"\n{n:,} × {n:,} float32, {4 * n * n / 1e9:.2f} GB, {N_WORKERS} workers or threads; medians of {repeats}\n")
    print(f"{'':<36}{'MB/s':>8}{'processor s/GB, this process':>32}")
    for name, (rate, used) in rates.items():
        print(f"{name:<36}{rate:>8.0f}{used:>32.2f}")
    predict(rates)


if __name__ == "__main__":
    main()
