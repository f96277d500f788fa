"""How much less do geodesic distances from the frames of a motion take, each path from that of the frame before?

    python benchmarks/geodesic_distances.py [--cmu FOLDER] [--hdm05 FOLDER] [--quick]

Random motions of a second, each against random poses of all motions, Euler angles and ball joints. One thread, seconds
of the processor; `geodesic_distances` and a search for each geodesic take turns. Both find local minima: how much their
lengths differ is printed.

Then sets of poses in the place of motions: poses of all people, put in order along a short tour, from each pose to the
nearest one that is left, and, as the control, in no order.
"""

import time
import warnings

import common
import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose import pose_distances
from skpose.geodesics import geodesic_distances

FRAME_RATES = 30, 120  # Hz
N_MOTIONS, N_POSES, SECONDS = 10, 10, 1.0
QUICK = 2, 3
N_SET, N_IN_A_ROW, N_COLUMNS = 1000, 50, 20  # poses of a set; those that are computed, of a row and of all
QUICK_SET = 40, 6, 3
SAME = 1e-4  # relative difference of two lengths of one geodesic
OPTIONS = {geodesic_distances: {}, pose_distances: {"metric": "geodesic"}}
LONGER = 1e-3  # by how much followed geodesics may be longer in the mean, relative


def cases(options, n_motions, n_poses):
    """Yield names, and a skeleton with motions at all frame rates and the poses that each is compared with."""
    for name, dataset in common.datasets(options).items():
        for rotations, motions in (("Euler angles", dataset), ("ball joints", dataset.to_rotvec())):
            rng, long = np.random.default_rng(0), [m for m in motions if len(m.angles) > SECONDS * m.frame_rate]
            chosen = [long[i] for i in rng.choice(len(long), n_motions)]
            starts = [int(rng.integers(len(m.angles) - round(SECONDS * m.frame_rate))) for m in chosen]
            poses, _ = motions.poses(frame_rate=12)
            others = [poses[rng.choice(len(poses), n_poses)] for _ in chosen]
            for rate in (rate for rate in FRAME_RATES if rate <= chosen[0].frame_rate):
                windows = [
                    m.angles[start : start + round(SECONDS * m.frame_rate) : max(1, round(m.frame_rate / rate))]
                    for m, start in zip(chosen, starts, strict=True)
                ]
                yield f"{name}, {rotations}, {rate} Hz", motions.skeleton, list(zip(windows, others, strict=True))


def tour(X, skeleton):
    """Return indices of poses, each followed by the nearest one that is left under "position"."""
    distances = pose_distances(X, skeleton=skeleton, metric="position", n_jobs=1)
    order, left = [0], np.ones(len(X), dtype=bool)
    for _ in range(len(X) - 1):
        left[order[-1]] = False
        order.append(int(np.where(left, distances[order[-1]], np.inf).argmin()))
    return np.array(order)


def sets(options, n_poses, n_in_a_row, n_columns):
    """Yield names, skeletons, and poses of a set in order and in none, with the poses that they are compared with."""
    for name, dataset in common.datasets(options).items():
        for rotations, motions in (("Euler angles", dataset), ("ball joints", dataset.to_rotvec())):
            rng = np.random.default_rng(0)
            X, _ = motions.poses(frame_rate=12)
            X = X[rng.choice(len(X), min(n_poses, len(X)), replace=False)]
            others = X[rng.choice(len(X), n_columns, replace=False)]
            begin = (len(X) - n_in_a_row) // 3
            for order, rows in (("a tour", tour(X, motions.skeleton)), ("no order", np.arange(len(X)))):
                yield f"{name}, {rotations}, {order}", motions.skeleton, X[rows[begin : begin + n_in_a_row]], others


def timed(function, *arguments, **options):
    began = time.process_time()
    found = function(*arguments, **options)
    return time.process_time() - began, found.ravel()


def race(name, skeleton, pairs):
    """Print what both take for pairs of arrays of poses; return how much longer the followed geodesics are."""
    for function, own in OPTIONS.items():  # compile
        function(*(part[:2] for part in pairs[0]), skeleton=skeleton, **own)
    runs = [[timed(f, *pair, skeleton=skeleton, **own) for f, own in OPTIONS.items()] for pair in pairs]
    seconds = np.array([[each[0] for each in run] for run in runs]).sum(axis=0)
    followed, searched = (np.concatenate([run[i][1] for run in runs]) for i in range(2))
    followed_ms, searched_ms = 1e3 * seconds / len(followed)
    gap = followed[searched > 0] / searched[searched > 0] - 1.0
    print(
        f"{name:<32} {searched_ms:8.2f} {followed_ms:9.2f} {searched_ms / followed_ms:7.1f}   "
        f"mean {gap.mean():.0e}, least {gap.min():.0e}, largest {gap.max():.0e}; of {len(gap)} "
        f"{(gap > SAME).sum()} longer and {(gap < -SAME).sum()} shorter by more than {SAME:g}",
        flush=True,
    )
    return gap


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    warnings.simplefilter("ignore", ConvergenceWarning)
    size = QUICK if options.quick else (N_MOTIONS, N_POSES)
    print(f"{'ms for each distance':<32} searched  followed   times   length followed over searched, minus 1")
    for name, skeleton, pairs in cases(options, *size):
        gap = race(name, skeleton, pairs)
        assert gap.mean() <= LONGER, f"followed geodesics are longer by {gap.mean():.1%}"
    for name, skeleton, *pair in sets(options, *(QUICK_SET if options.quick else (N_SET, N_IN_A_ROW, N_COLUMNS))):
        race(name, skeleton, [pair])


if __name__ == "__main__":
    main()
