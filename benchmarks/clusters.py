"""Clusters of poses against labels: k-means under every metric, medoid shift, and scikit-learn's k-means of angles.

    python benchmarks/clusters.py [--cmu FOLDER OF CMU FILES] [--hdm05 FOLDER OF HDM05 FILES] [--quick]

Protocols, poses on the mean skeleton, as many clusters as labels:

- CMU: the walks and runs of `skpose compare`, at 12 Hz; two labels. Twenty pairs of one walk and one run, as in
  `examples/maps_and_clusters/clustering.py` (sec. 3.4 of the paper), with the median and the range over the pairs; and
  all together.
- HDM05: frames of all sequences at 4 Hz, labelled with the action of their sequence; eleven labels. Frames of a rest
  pose are in most actions, so that no clusters of single frames can agree with the labels altogether.

"angle" takes the Euler angles of the files, the other metrics ball joints. K-means runs from ten seeds ("rotation":
three), one start each: the median and the range. It leaves "spatial" out, whose means take minutes. Medoid shift has no
seed; its bandwidth is the one that gives the number of clusters. The silhouette is that of the clusters under the
metric itself, and under "position", the same for all rows. Without folders the poses are generated gait.
"""

import time
import warnings
from typing import NamedTuple

import common
import numpy as np
from sklearn.cluster import KMeans
from sklearn.exceptions import ConvergenceWarning
from sklearn.metrics import adjusted_rand_score, silhouette_score

from skpose import MedoidShift, forward_kinematics, pose_distances
from skpose.cluster import PoseKMeans
from skpose.datasets import load_cmu, load_hdm05, make_gait, walks_and_runs

METRICS = "angle", "position", "rotation", "spatial"
SLOW = {"rotation": 3}  # seeds at most, where a mean takes a second; under "spatial" it takes minutes


class Size(NamedTuple):
    n_seeds: int
    n_pairs: int
    rate_of_walks: float  # Hz
    rate_of_actions: float  # Hz


FULL, QUICK = Size(10, 20, 12, 4), Size(2, 2, 4, 2)


class Poses(NamedTuple):
    """The poses of a protocol for one metric."""

    X: np.ndarray
    skeleton: object
    distances: np.ndarray


def protocol(dataset, rate):
    """Poses with distances for each metric, the label of each pose, and its sequence."""
    as_read, sequence = dataset.poses(rate)
    balls, _ = dataset.poses(rate, rotations="rotvec")
    found = {}
    for metric in METRICS:
        X, skeleton = (as_read, dataset.skeleton) if metric == "angle" else (balls, dataset.to_rotvec().skeleton)
        found[metric] = Poses(X, skeleton, pose_distances(X, skeleton=skeleton, metric=metric, n_jobs=-1))
    return found, dataset.actions[sequence], sequence


def check(k_means, poses, metric):
    """Check what k-means promises: centres that are poses, the nearest centre, an inertia of these."""
    squares = pose_distances(poses.X, k_means.cluster_centers_, skeleton=poses.skeleton, metric=metric) ** 2
    assert (squares.argmin(axis=1) == k_means.labels_).all()
    assert np.isclose(squares.min(axis=1).sum(), k_means.inertia_)
    positions = forward_kinematics(k_means.cluster_centers_, poses.skeleton)
    positions = np.concatenate([positions, np.zeros((len(positions), 1, 3))], axis=1)  # the last is the root
    lengths = np.linalg.norm(positions[:, :-1] - positions[:, poses.skeleton.parents], axis=2)
    assert np.abs(lengths - np.linalg.norm(poses.skeleton.offsets, axis=1)).max() < 1e-9


class Run(NamedTuple):
    """The clusters of some of the poses."""

    rows: np.ndarray  # indices of the poses
    labels: np.ndarray
    seconds: float


def timed(estimator, X, rows):
    """Fit, with the clock."""
    start = time.perf_counter()
    labels = estimator.fit(X).labels_
    return Run(rows, labels, time.perf_counter() - start)


def silhouette(distances, run):
    """The silhouette of a run; of a single cluster, which has none, zero."""
    if len(set(run.labels)) < 2:
        return 0.0
    return silhouette_score(distances[np.ix_(run.rows, run.rows)], run.labels, metric="precomputed")


def print_row(name, runs, truth, own, position):
    """Print a row of the table."""
    columns = [
        [adjusted_rand_score(truth[run.rows], run.labels) for run in runs],
        [silhouette(own, run) for run in runs],
        [silhouette(position, run) for run in runs],
    ]
    cells = [f"{np.median(c):.2f} ({min(c):.2f} to {max(c):.2f})" if len(c) > 1 else f"{c[0]:.2f}" for c in columns]
    seconds = np.median([run.seconds for run in runs])
    print(f"{name:<30}" + "".join(f"{cell:>24}" for cell in cells) + f"{seconds:>9.2f}")


def table(title, found, truth, parts, n_seeds):
    """Print the clusters of each part of the poses, k-means from some seeds."""
    n_clusters, position = len(set(truth)), found["position"].distances
    print(f"\n{title}, {n_clusters} labels")
    titles = "adjusted Rand index", "silhouette, own metric", 'silhouette, "position"'
    print(" " * 30 + "".join(f"{name:>24}" for name in titles) + f"{'s':>9}")
    starts = [(rows, seed) for rows in parts for seed in range(n_seeds)]
    angle = found["angle"]
    runs = [timed(KMeans(n_clusters, n_init=1, random_state=seed), angle.X[rows], rows) for rows, seed in starts]
    print_row("KMeans of angles, scikit-learn", runs, truth, angle.distances, position)
    for metric, poses in found.items():
        if metric == "spatial":
            continue
        runs = []
        for rows, seed in starts:
            if seed >= SLOW.get(metric, n_seeds):
                continue
            k_means = PoseKMeans(poses.skeleton, n_clusters=n_clusters, metric=metric, random_state=seed, n_jobs=-1)
            runs.append(timed(k_means, poses.X[rows], rows))
            check(k_means, poses._replace(X=poses.X[rows]), metric)
        print_row(f"PoseKMeans, {metric}", runs, truth, poses.distances, position)
    for metric, poses in found.items():
        runs = []
        for rows in parts:
            shift = MedoidShift(n_clusters=n_clusters, metric="precomputed")
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConvergenceWarning)  # where no bandwidth gives the number of clusters
                runs.append(timed(shift, poses.distances[np.ix_(rows, rows)], rows))
        print_row(f"MedoidShift, {metric}", runs, truth, poses.distances, position)


def pairs_of(dataset, sequence, n_pairs):
    """The poses of one walk and one run, at random, for each of some pairs."""
    rng = np.random.default_rng(0)
    walks, runs = (np.flatnonzero(dataset.actions == action) for action in ("walk", "run"))
    chosen = [(rng.choice(walks), rng.choice(runs)) for _ in range(n_pairs)]
    return [np.flatnonzero(np.isin(sequence, pair)) for pair in chosen]


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    size = QUICK if options.quick else FULL
    gait = make_gait(*((2, 1) if options.quick else (10, 10)), random_state=0)
    walks = walks_and_runs(load_cmu(options.cmu) if options.cmu else gait)
    found, truth, sequence = protocol(walks, size.rate_of_walks)
    title = "Walking and running" + ", CMU" * bool(options.cmu)
    pairs = pairs_of(walks, sequence, size.n_pairs)
    table(f"{title}: {len(pairs)} pairs of a walk and a run at {size.rate_of_walks} Hz", found, truth, pairs, 1)
    everything = [np.arange(len(truth))]
    about = f"{len(truth)} poses of {len(walks)} sequences at {size.rate_of_walks} Hz"
    table(f"{title}: {about}", found, truth, everything, size.n_seeds)
    if options.hdm05:
        actions = load_hdm05(options.hdm05)
        found, truth, _ = protocol(actions, size.rate_of_actions)
        about = f"{len(truth)} poses of {len(actions)} sequences at {size.rate_of_actions} Hz"
        table(f"Actions, HDM05: {about}", found, truth, [np.arange(len(truth))], size.n_seeds)


if __name__ == "__main__":
    main()
