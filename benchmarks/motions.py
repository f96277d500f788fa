"""Distances between whole motions: million cells a second against aeon, dtaidistance and tslearn.

    pip install "skpose[peers]"
    python benchmarks/motions.py --hdm05 FOLDER_OF_HDM05_FILES [--quick]

A cell is a pair of frames of two motions; all motions against all, one triangle, one thread, the programs in turns.
What others get is made before: the positions of the joints, in the form that each takes without a copy; aeon gets both
orders of the axes. Ours get joint angles: forward kinematics and the conversions are a part of their time. The others
sum squared distances, and dtaidistance also plain ones; their answers are checked in the same run, against ours or
against the recursion on squared distances. Tools that are not installed are left out.
"""

import importlib
from typing import NamedTuple

import common
import numpy as np

from skpose import forward_kinematics, motion_distances, pose_distances
from skpose._compiled.warping.paths import Paths, accumulate
from skpose.datasets import load_hdm05, make_gait

RATE = 12  # Hz
SEED, N_CHECKED = 0, 30  # pairs of motions whose distances are computed again
WHOLE = Paths(1.0, False)  # no window


class Size(NamedTuple):
    n_motions: int  # in the race of long motions
    repeats: int


FULL, QUICK = Size(16, 3), Size(4, 1)


def installed(name):
    """Return a module, or None where it is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        print(f"{name} is not installed: it is left out")
        return None


def on_one_skeleton(dataset):
    """The angles of each motion, and the mean skeleton."""
    X, sequence = dataset.poses()
    return np.split(X, np.searchsorted(sequence, np.arange(1, len(dataset)))), dataset.skeleton


def others(positions):
    """Functions that return all distances of aeon, dtaidistance and tslearn, by name."""
    found = {}
    if aeon := installed("aeon.distances"):
        rows = [np.ascontiguousarray(p.T) for p in positions]  # (n_channels, n_frames)
        columns = [p.T for p in positions]  # the same, the numbers of a frame side by side
        found["aeon"] = lambda: aeon.dtw_pairwise_distance(rows, n_jobs=1)
        found["aeon, frames contiguous"] = lambda: aeon.dtw_pairwise_distance(columns, n_jobs=1)
    if dtaidistance := installed("dtaidistance.dtw_ndim"):
        for name, inner in (("dtaidistance", "squared euclidean"), ("dtaidistance, not squared", "euclidean")):
            found[name] = lambda inner=inner: dtaidistance.distance_matrix_fast(
                positions, parallel=False, inner_dist=inner
            )
    if tslearn := installed("tslearn.metrics"):
        padded = importlib.import_module("tslearn.utils").to_time_series_dataset(positions)
        found["tslearn"] = lambda: tslearn.cdist_dtw(padded)
    return found


def check(name, distances, motions, skeleton, ours):
    """Compare some distances with sums of squares, or with ours, of the metric "position"."""
    rng = np.random.default_rng(SEED)
    for i, j in rng.choice(len(motions), (N_CHECKED, 2)):
        i, j = min(i, j), max(i, j)
        if i == j:
            continue
        costs = pose_distances(motions[i], motions[j], skeleton=skeleton, metric="position")
        if not name.endswith("not squared"):
            costs **= 2
        accumulate(costs, WHOLE)
        expected = costs[-1, -1]
        if name == "dtaidistance, not squared":
            frames = len(motions[i]) + len(motions[j])
            np.testing.assert_allclose(ours[i, j] * frames, expected, rtol=1e-10)
        elif not name.startswith("aeon"):
            expected = np.sqrt(expected)
        np.testing.assert_allclose(distances[i, j], expected, rtol=1e-9)


def race(title, dataset, repeats):
    """Print million cells a second of all, and what "spatial" costs against its pairs alone."""
    motions, skeleton = on_one_skeleton(dataset)
    positions = [forward_kinematics(X, skeleton).reshape(len(X), -1) for X in motions]
    lengths, frames = np.array([len(X) for X in motions]), np.concatenate(motions)
    n_cells = (lengths.sum() ** 2 - np.square(lengths).sum()) // 2
    print(
        f"\n{title}: {len(motions)} motions of {lengths.min()} to {lengths.max()} frames, {n_cells / 1e6:.2f} M cells, "
        f"{positions[0].shape[1]} coordinates, one thread"
    )
    contestants = {}
    for metric in ("position", "spatial"):
        for dtype in (np.float64, np.float32):
            given = [X.astype(dtype) for X in motions]
            contestants[f"skpose, {metric}, {np.dtype(dtype)}"] = lambda given=given, metric=metric: motion_distances(
                given, skeleton=skeleton, metric=metric, n_jobs=1
            )
    ours = contestants["skpose, position, float64"]()
    peers = others(positions)
    for name, function in peers.items():
        check(name, function(), motions, skeleton, ours)
    out = np.zeros((len(frames), len(frames)))
    pairs = {"pose_distances, spatial, float64": lambda: pose_distances(frames, skeleton=skeleton, n_jobs=1, out=out)}
    seconds = common.medians(contestants | peers | pairs, repeats)
    n_pairs = len(frames) * (len(frames) - 1) // 2  # with those within a motion
    cells = dict.fromkeys(seconds, n_cells) | dict.fromkeys(pairs, n_pairs)
    rates = {name: cells[name] / seconds[name] / 1e6 for name in seconds}
    fastest = max((rates[name] for name in peers if name.startswith("aeon")), default=None)
    print(f"{'':<34}{'s':>10}{'M cells/s':>12}" + (f"{'x aeon':>10}" if fastest else ""))
    for name, rate in rates.items():
        against = f"{rate / fastest:>10.2f}" if fastest else ""
        print(f"{name:<34}{seconds[name]:>10.4f}{rate:>12.2f}{against}")
    ratio = rates[next(iter(pairs))] / rates["skpose, spatial, float64"]
    print(f"spatial: a cell takes {ratio:.2f} x the time of a pair of pose_distances")


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--hdm05", help="HDM05 files, see load_hdm05; default: generated gait")
    options = arguments.parse_args()
    common.print_machine()
    size, n = (QUICK, 2) if options.quick else (FULL, 10)
    dataset = (
        load_hdm05(options.hdm05, rotations="file")
        if options.hdm05
        else make_gait(n, n, rotations="file", random_state=SEED)
    )
    slow = common.resampled(dataset, RATE)
    race(f"{RATE} Hz", slow[: size.n_motions] if options.quick else slow, size.repeats)
    chosen = np.sort(np.random.default_rng(SEED).choice(len(dataset), size.n_motions, replace=False))
    race(f"{dataset[0].frame_rate:g} Hz", dataset[chosen], size.repeats)


if __name__ == "__main__":
    main()
