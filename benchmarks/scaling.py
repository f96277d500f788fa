"""How do time and memory grow with the number of poses, and is a matrix the same after its process was killed?

    pip install "skpose[bench]"
    python benchmarks/scaling.py [FOLDER OF CMU FILES] [--largest N] [--scratch FOLDER] [--quick]

"spatial" distances in float32, written to a file in the scratch folder, 10 GB for the largest N of 50,000; every size
in a process of its own. Entries are checked against distances computed alone, and the matrix of a run that was killed
(SIGKILL) at half its tiles and started again, byte by byte, against that of a run in one go. Then the graph of ten
neighbours, joblib's backends, and from these figures what a million poses would take. Linux only.
"""

import argparse
import ctypes
import filecmp
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import common
import joblib
import numpy as np

from skpose import PoseKNeighborsTransformer, pose_distances


class Size(NamedTuple):
    n_poses: tuple  # of each matrix
    n_backends: int  # poses for joblib's backends
    n_written: int  # poses of the matrix for the speed of writing
    repeats: int


FULL = Size((1000, 2000, 5000, 10_000, 20_000, 50_000), 5000, 20_000, common.REPEATS)
QUICK = Size((300, 4200), 300, 1000, 1)
TILE = 4096  # rows and columns of a tile of a matrix that is written to a file
MILLION, N_CORES = 1_000_000, 64
ATTEMPTS = 5  # to kill a run half-way
RNG = np.random.default_rng(0)


def poses_of(folder, n):
    """Return n poses, of frames and of those interpolated between them, in random order."""
    dataset = common.motions(folder)
    rate = dataset.motions[0].frame_rate
    while len(X := dataset.poses(rate)[0]) < n:
        rate *= 2
    return RNG.permutation(X)[:n].astype(np.float32), dataset.skeleton


def child(options):
    """Compute one matrix or graph in this process; print time and memory as a line of JSON."""
    X, skeleton = poses_of(options.folder, options.largest)
    X = X[: options.child].copy()
    pose_distances(X[:50], skeleton=skeleton)  # compiles
    PoseKNeighborsTransformer(skeleton, n_neighbors=10).fit(X[:500]).kneighbors()
    ctypes.CDLL(None).malloc_trim(0)  # so that memory that is free does not count as resident
    common.forget_peak_memory()
    before, start = common.memory("VmRSS"), time.perf_counter()
    if options.name == "graph":
        search = PoseKNeighborsTransformer(skeleton, n_neighbors=10, n_jobs=-1).fit(X)
        *_, evaluations = search.kneighbors(return_evaluations=True)
        taken = {"lengths": evaluations.lengths / len(X)}
    else:
        path = Path(options.scratch, options.name)
        mode, kind = ("r+", {}) if path.exists() else ("w+", {"dtype": X.dtype, "shape": (len(X), len(X))})
        out = np.lib.format.open_memmap(path, mode=mode, **kind)
        pose_distances(X, skeleton=skeleton, out=out, n_jobs=-1)
        taken = {}
    taken |= {"seconds": time.perf_counter() - start, "MB": common.memory("VmHWM") - before}
    if options.name != "graph":
        for i, j in np.sort(RNG.integers(len(X), size=(200, 2))):
            alone = pose_distances(X[i : i + 1], X[j : j + 1], skeleton=skeleton)[0, 0]
            np.testing.assert_array_equal([out[i, j], out[j, i]], alone)
    print(json.dumps(taken))


def begin(options, n, name):
    """Start the process of one size."""
    folder = [options.folder] if options.folder else []
    arguments = ["--largest", str(options.largest), "--scratch", options.scratch, "--child", str(n), "--name", name]
    return subprocess.Popen([sys.executable, __file__, *folder, *arguments], stdout=subprocess.PIPE, text=True)


def run(options, n, name):
    """Return what the process of one size prints."""
    process = begin(options, n, name)
    out, _ = process.communicate()
    if process.returncode != 0:
        sys.exit(f"{n} poses: exit status {process.returncode}")
    return json.loads(out.splitlines()[-1])


def tiles_in(notes):
    """Return how many tiles the notes of a matrix hold; none without notes, as before the first tile and at the end."""
    try:
        return max(notes.read_text().count("\n") - 1, 0)
    except FileNotFoundError:
        return 0


def kill_half_way(options, n, n_tiles):
    """Start a matrix and kill its process when half of the tiles are done; return their number."""
    notes = Path(options.scratch, "killed.npy.progress")
    for _ in range(ATTEMPTS):
        process = begin(options, n, "killed.npy")
        while process.poll() is None and tiles_in(notes) < n_tiles // 2:
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        if n_done := tiles_in(notes):
            return n_done
        Path(options.scratch, "killed.npy").unlink(missing_ok=True)  # it was complete before it was killed
    sys.exit(f"{n} poses: {ATTEMPTS} runs ended before they could be killed")


def backends(X, skeleton, repeats):
    """Return seconds in threads, in processes, and on a dask cluster of this machine."""
    from dask.distributed import Client, LocalCluster

    n_jobs = os.cpu_count()
    expected = pose_distances(X, skeleton=skeleton, n_jobs=n_jobs)

    def on(**options):
        with joblib.parallel_config(**options):
            np.testing.assert_array_equal(pose_distances(X, skeleton=skeleton), expected)

    with LocalCluster(n_workers=n_jobs, threads_per_worker=1, dashboard_address=":0") as cluster, Client(cluster):
        return common.medians(
            {
                "threads": lambda: on(backend="threading", n_jobs=n_jobs),
                "loky": lambda: on(backend="loky", n_jobs=n_jobs),
                "dask": lambda: on(backend="dask"),
            },
            repeats,
        )


def writing(X, skeleton, scratch):
    """Return the MB/s that this process can write, with distances that take almost no time to compute."""
    out = np.lib.format.open_memmap(Path(scratch, "W.npy"), mode="w+", dtype=X.dtype, shape=(len(X), len(X)))
    start = time.perf_counter()
    pose_distances(X, out=out, metric="angle", n_jobs=-1)
    return out.nbytes / 1e6 / (time.perf_counter() - start)


def predict(row, graph, n, seconds, n_jobs, written):
    """Print how long a million poses would take on a cluster, as a calculation."""
    n_pairs, share = MILLION * (MILLION - 1) / 2, seconds["threads"] / seconds["dask"]
    rate = n * (n - 1) / 2 / row["seconds"] / n_jobs
    print(f"\nA million poses on {N_CORES} such cores, calculated:")
    print(
        f"  to compute: {n_pairs:.3g} pairs / ({rate / 1e6:.2f} million pairs/s a core x {N_CORES} cores x {share:.2f}"
    )
    print(f"  for dask compared with threads) = {n_pairs / (rate * N_CORES * share) / 3600:.1f} h")
    print(f"  to write, in one process: 4 TB / {written:.0f} MB/s = {4e6 / written / 3600:.1f} h")
    least, most = (graph["seconds"] * n_jobs / N_CORES / 60 * (MILLION / n) ** power for power in (1, 2))
    print(f"  graph of ten neighbours: {graph['seconds']:.1f} s x {n_jobs} cores for {n:,}; {least:.1f} min if it")
    print(f"  grows with the poses, as the lengths measured do, {most:.1f} min if with their square, as filters do")


def main():
    parser = common.parser(__doc__)
    parser.add_argument("--largest", type=int, help=f"most poses; default: {FULL.n_poses[-1]:,}")
    parser.add_argument("--scratch", help="folder for the matrices; default: a temporary one")
    parser.add_argument("--child", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--name", default="D.npy", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        child(options)
        return
    common.print_machine()
    size = QUICK if options.quick else FULL
    options.largest = options.largest or size.n_poses[-1]
    n_jobs = os.cpu_count()
    made = options.scratch is None
    options.scratch = tempfile.mkdtemp() if made else options.scratch
    try:
        _, skeleton = poses_of(options.folder, options.largest)
        print(f'{skeleton}, "spatial", float32, {n_jobs} cores; memory is what is resident beyond the poses\n')
        print(f"{'poses':>8}{'matrix':>10}{'time':>10}{'pairs/s':>10}{'memory':>10}{'graph, k = 10':>16}{'memory':>10}")
        for n in [n for n in size.n_poses if n <= options.largest]:
            Path(options.scratch, "D.npy").unlink(missing_ok=True)
            row, graph = run(options, n, "D.npy"), run(options, n, "graph")
            rate = n * (n - 1) / 2 / row["seconds"] / 1e6
            print(
                f"{n:>8,}{4 * n * n / 1e6:>7,.0f} MB{row['seconds']:>8.2f} s{rate:>8.2f} M{row['MB']:>7.0f} MB"
                f"{graph['seconds']:>14.2f} s{graph['MB']:>7.0f} MB   {graph['lengths']:.1f} lengths per pose",
                flush=True,
            )
        n_edges = -(-n // TILE)
        n_tiles = n_edges * (n_edges + 1) // 2
        n_done = kill_half_way(options, n, n_tiles)
        again = run(options, n, "killed.npy")
        same = filecmp.cmp(Path(options.scratch, "D.npy"), Path(options.scratch, "killed.npy"), shallow=False)
        print(f"\nkilled after {n_done} of {n_tiles} tiles and started again: ", end="")
        print(
            f"{again['seconds']:.0f} s more, {again['MB']:.0f} MB; the same bytes: {'yes' if same else 'NO'}",
            flush=True,
        )
        X, skeleton = poses_of(options.folder, size.n_backends)
        seconds = backends(X, skeleton, size.repeats)
        print(f"\n{len(X):,} poses on joblib's backends, {n_jobs} workers, in memory: ", end="")
        print(", ".join(f"{name} {taken:.1f} s" for name, taken in seconds.items()))
        X, _ = poses_of(options.folder, size.n_written)
        predict(row, graph, n, seconds, n_jobs, writing(X, skeleton, options.scratch))
        if not same:
            sys.exit(1)
    finally:
        if made:
            shutil.rmtree(options.scratch)


if __name__ == "__main__":
    main()
