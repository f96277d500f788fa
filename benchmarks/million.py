"""How does an exact search grow up to a million poses? Against faiss, where it is installed, in one run.

    python benchmarks/million.py [--hdm05 FOLDER] [--against common.CHECKOUT] [--quick]

"spatial", k = 10, one thread, ball joints: frames at 120 Hz, filled up with frames that have noise of 0.03 rad, and
1,000 queries of another person. Answers of some queries are compared with brute force, by ``==``. Contestants take
turns; a line holds medians of seconds of the processor, in ms a query, and the memory at most, beyond the poses. faiss
searches joint positions, which it gets ready made, for 500 candidates (flat) or 200 (HNSW), which are measured.
"""

import argparse
import pickle
import sys
import tempfile
import time
from pathlib import Path

import common
import numpy as np
from threadpoolctl import threadpool_limits

from skpose import PoseKNeighborsTransformer, forward_kinematics, pose_distances
from skpose.datasets import load_hdm05, make_gait

K = 10
SIZES, N_QUERIES, N_BRUTE, REPEATS = (30_000, 100_000, 300_000, 1_000_000), 1000, 20, 3
QUICK = (300, 1000), 20, 5, 1
NOISE = 0.03  # rad
CANDIDATES = {"flat": 500, "HNSW": 200}


def poses_of(dataset, n, n_queries):
    """Return n poses of all people but the first, and queries of that one."""
    poses, sequence = dataset.to_rotvec().poses(frame_rate=max(motion.frame_rate for motion in dataset))
    first, rng = dataset.subjects[sequence] == dataset.subjects[0], np.random.default_rng(0)
    queries, poses = rng.choice(poses[first], n_queries, replace=False), poses[~first]
    if n <= len(poses):
        return poses[np.sort(rng.choice(len(poses), n, replace=False))], queries
    more = rng.integers(0, len(poses), n - len(poses))
    noise = NOISE * rng.normal(size=(len(more), poses.shape[1]))
    return np.concatenate([poses, poses[more] + noise]), queries


def serve(data):
    """Search once, send the answer and the memory that it took; then once for each line on standard input."""
    with open(data, "rb") as file:
        skeleton, poses, queries = pickle.load(file)
    PoseKNeighborsTransformer(skeleton, n_jobs=1).fit(poses[:20_000]).kneighbors(queries, K)  # compiles
    common.forget_peak_memory()
    before = common.memory("VmRSS")
    knn = PoseKNeighborsTransformer(skeleton, n_jobs=1).fit(poses)
    send((*knn.kneighbors(queries, K), common.memory("VmHWM") - before))
    for _ in sys.stdin:
        send(seconds(lambda: knn.kneighbors(queries, K)))


def send(answer):
    pickle.dump(answer, sys.stdout.buffer)
    sys.stdout.buffer.flush()


def seconds(function):
    start = time.process_time()
    function()
    return time.process_time() - start


class Checkout:
    """A process that searches with the skpose of a checkout."""

    def __init__(self, path, data):
        self.process = common.start_checkout(path, __file__, data)
        self.distances, self.indices, self.memory = pickle.load(self.process.stdout)

    def search(self):
        self.process.stdin.write(b"\n")
        self.process.stdin.flush()
        return pickle.load(self.process.stdout)

    def stop(self):
        self.process.stdin.close()
        self.process.wait()


def peers(skeleton, poses, queries):
    """Return searches of faiss among joint positions, by name: each gives candidates."""
    try:
        import faiss
    except ImportError:
        return {}
    F, G = (forward_kinematics(some, skeleton).reshape(len(some), -1).astype(np.float32) for some in (poses, queries))
    indexes = {"flat": faiss.IndexFlatL2(F.shape[1]), "HNSW": faiss.IndexHNSWFlat(F.shape[1], 32)}
    for index in indexes.values():
        index.add(F)
    indexes["HNSW"].hnsw.efSearch = CANDIDATES["HNSW"]
    sizes = {name: min(n, len(poses)) for name, n in CANDIDATES.items()}
    return {name: lambda index=index, n=sizes[name]: index.search(G, n)[1] for name, index in indexes.items()}


def compare(skeleton, poses, queries, against, n_brute, repeats):
    """Print a line for one size; return ms a query of this checkout."""
    with tempfile.NamedTemporaryFile() as file:
        pickle.dump((skeleton, poses, queries), file)
        file.flush()
        checkouts = {
            name: Checkout(path, file.name) for name, path in (("here", common.CHECKOUT), ("there", against)) if path
        }
    here = checkouts["here"]
    D = pose_distances(queries[:n_brute], poses, skeleton=skeleton, n_jobs=-1)
    order = np.argsort(D, axis=1, kind="stable")[:, :K]
    np.testing.assert_array_equal(here.indices[:n_brute], order)
    np.testing.assert_array_equal(here.distances[:n_brute], np.take_along_axis(D, order, axis=1))
    for there in checkouts.values():
        np.testing.assert_array_equal(there.indices, here.indices)
        np.testing.assert_array_equal(there.distances, here.distances)
    knn = PoseKNeighborsTransformer(skeleton, n_jobs=1).fit(poses)
    contestants, recall = {name: checkout.search for name, checkout in checkouts.items()}, {}
    for name, candidates in peers(skeleton, poses, queries).items():

        def measured(candidates=candidates):
            return knn.approximate_kneighbors(candidates(), queries, K, n_checked=0)

        recall[name] = (measured().distances <= here.distances[:, -1:]).mean()
        contestants[name] = lambda measured=measured: seconds(measured)
    runs = {name: [] for name in contestants}
    with threadpool_limits(1):
        for _ in range(repeats):
            for name, contestant in contestants.items():
                runs[name].append(1000 * contestant() / len(queries))
    line = f"{len(poses):>9,} poses"
    for name, values in runs.items():
        line += f"  {name} {np.median(values):.3f}"
        line += f" ({checkouts[name].memory:,.0f} MB)" if name in checkouts else f" (recall {recall[name]:.4f})"
    print(line, flush=True)
    for checkout in checkouts.values():
        checkout.stop()
    return {name: np.median(values) for name, values in runs.items()}


def main():
    if sys.argv[1:2] == ["--search"]:
        serve(sys.argv[2])
        return
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--hdm05", help="HDM05 files, see load_hdm05; default: generated gait")
    arguments.add_argument("--against", type=Path, help="another checkout of skpose")
    arguments.add_argument("--quick", action="store_true", help="check the answers in seconds; times mean nothing")
    options = arguments.parse_args()
    common.print_machine()
    sizes, n_queries, n_brute, repeats = QUICK if options.quick else (SIZES, N_QUERIES, N_BRUTE, REPEATS)
    dataset = load_hdm05(options.hdm05) if options.hdm05 else make_gait(5, 2, random_state=0)
    skeleton = dataset.to_rotvec().skeleton
    print(f"{n_queries} queries, k = {K}, one thread: ms a query")
    times = []
    for n in sizes:
        times.append(compare(skeleton, *poses_of(dataset, n, n_queries), options.against, n_brute, repeats))
    if "flat" not in times[0]:
        print("faiss is not installed: no peers")
    for name in times[0]:
        values = np.log([row[name] for row in times])
        line = f"{name}: time grows with n to the power of {np.polyfit(np.log(sizes), values, 1)[0]:.2f}"
        if len(sizes) > 2:
            line += f", {np.polyfit(np.log(sizes[1:]), values[1:], 1)[0]:.2f} from the second size on"
        print(line)


if __name__ == "__main__":
    main()
