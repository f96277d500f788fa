"""How does an exact search grow up to a million poses?

    python benchmarks/million.py [--hdm05 FOLDER] [--quick]

"spatial", k = 10, one thread, ball joints: frames at 120 Hz, filled up with frames that have noise of 0.03 rad, and
1,000 queries of another person. Answers of some queries are compared with brute force, by ``==``. Each line holds the
median CPU time in ms a query, and the peak memory beyond the poses (Linux).
"""

import argparse
import time

import common
import numpy as np

from skpose import PoseKNeighborsTransformer, pose_distances
from skpose.datasets import load_hdm05, make_gait

K = 10
SIZES, N_QUERIES, N_BRUTE, REPEATS = (30_000, 100_000, 300_000, 1_000_000), 1000, 20, 3
QUICK = (300, 1000), 20, 5, 1
NOISE = 0.03  # rad


def poses_of(dataset, n, n_queries):
    """n poses of all people but the first, and queries of that one."""
    poses, sequence = dataset.poses(frame_rate=max(motion.frame_rate for motion in dataset))
    first, rng = dataset.subjects[sequence] == dataset.subjects[0], np.random.default_rng(0)
    queries, poses = rng.choice(poses[first], n_queries, replace=False), poses[~first]
    if n <= len(poses):
        return poses[np.sort(rng.choice(len(poses), n, replace=False))], queries
    more = rng.integers(0, len(poses), n - len(poses))
    noise = NOISE * rng.normal(size=(len(more), poses.shape[1]))
    return np.concatenate([poses, poses[more] + noise]), queries


def measure(skeleton, poses, queries, n_brute, repeats):
    """Print a line for one size, and give ms a query."""
    PoseKNeighborsTransformer(skeleton, n_jobs=1).fit(poses[:20_000]).kneighbors(queries, K)  # compiles
    common.forget_peak_memory()
    before = common.memory("VmRSS")
    knn = PoseKNeighborsTransformer(skeleton, n_jobs=1).fit(poses)
    distances, indices = knn.kneighbors(queries, K)
    held = common.memory("VmHWM") - before
    D = pose_distances(queries[:n_brute], poses, skeleton=skeleton, n_jobs=-1)
    order = np.argsort(D, axis=1, kind="stable")[:, :K]
    np.testing.assert_array_equal(indices[:n_brute], order)
    np.testing.assert_array_equal(distances[:n_brute], np.take_along_axis(D, order, axis=1))
    search = {"search": lambda: knn.kneighbors(queries, K)}
    milliseconds = 1000 * common.medians(search, repeats, time.process_time)["search"] / len(queries)
    print(f"{len(poses):>9,} poses {milliseconds:.3f} ms a query, {held:,.0f} MB", flush=True)
    return milliseconds


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--hdm05", help="HDM05 files, see load_hdm05; default: generated gait")
    arguments.add_argument("--quick", action="store_true", help="check the answers in seconds; times mean nothing")
    options = arguments.parse_args()
    common.print_machine()
    sizes, n_queries, n_brute, repeats = QUICK if options.quick else (SIZES, N_QUERIES, N_BRUTE, REPEATS)
    dataset = load_hdm05(options.hdm05) if options.hdm05 else make_gait(5, 2, random_state=0)
    skeleton = dataset.skeleton
    times = [measure(skeleton, *poses_of(dataset, n, n_queries), n_brute, repeats) for n in sizes]
    exponent = np.polyfit(np.log(sizes), np.log(times), 1)[0]
    print(f"time grows with n to the power of {exponent:.2f}")


if __name__ == "__main__":
    main()
