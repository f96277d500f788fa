"""How fast is the search for the nearest poses of other people? Against scikit-learn and another checkout, in one run.

    python benchmarks/far_queries.py [--cmu FOLDER] [--hdm05 FOLDER] [--against common.CHECKOUT] [--quick]

Queries of one person among all poses of the others, "spatial", k = 10: recorded frames alone, and some 100,000 poses
with interpolations between frames. Each checkout searches in a process of its own;
all take turns, and a line holds medians. By ``==``, answers of all checkouts must be equal, and those of some queries
equal to brute force by `pose_distances`. scikit-learn's brute force gets the joint positions ready made.
"""

import pickle
import sys
import tempfile
import time
from pathlib import Path

import common
import numpy as np
from sklearn.neighbors import NearestNeighbors
from threadpoolctl import threadpool_limits

from skpose import PoseKNeighborsTransformer, forward_kinematics, pose_distances

K = 10
N_POSES, N_QUERIES, N_BRUTE, REPEATS = 100_000, 1000, 50, 5
QUICK = 600, 40, 5, 1
RECORDED = 60  # Hz, of the CMU poses that are no interpolations; more are nearly the same poses again


def cases(options, n_poses, n_queries):
    """Yield name, skeleton, poses of an index and queries: recorded frames alone, then frames between them too."""
    for name, dataset in common.datasets(options).items():
        recorded = max(motion.frame_rate for motion in dataset)
        dense = recorded * max(1, int(np.ceil(n_poses / sum(len(motion) for motion in dataset))))
        if name == "CMU":
            recorded = RECORDED
        for rate in (recorded, dense):
            for rotations, motions in (("Euler angles", dataset), ("ball joints", dataset.to_rotvec())):
                poses, sequence = motions.poses(frame_rate=rate)
                first = dataset.subjects[sequence] == dataset.subjects[0]
                rng = np.random.default_rng(0)
                queries = rng.choice(poses[first], min(n_queries, first.sum()), replace=False)
                index = poses[~first]
                if options.quick:
                    index = rng.choice(index, min(n_poses, len(index)), replace=False)
                kind = f"{name}, {rotations}, {'recorded' if rate == recorded else 'dense'}"
                yield kind, motions.skeleton, index, queries
                yield f"{kind}, shuffled", motions.skeleton, rng.permutation(index), queries


class Checkout:
    """A process that searches with the skpose of a checkout."""

    def __init__(self, path, data):
        self.process = common.start_checkout(path, __file__, data)
        self.answer = self.next()

    def next(self):
        """Return what the process sends next."""
        return pickle.load(self.process.stdout)

    def search(self, n_jobs):
        """Search once; return seconds of the clock and of the processor."""
        self.process.stdin.write(f"{n_jobs}\n".encode())
        self.process.stdin.flush()
        return self.next()

    def stop(self):
        self.process.stdin.close()
        self.process.wait()


def seconds(function):
    """Return seconds of the clock and of the processor."""
    clock, processor = time.perf_counter(), time.process_time()
    function()
    return time.perf_counter() - clock, time.process_time() - processor


def serve(data):
    """Search once for the answer, then once for each line on standard input, with so many jobs."""
    with open(data, "rb") as file:
        skeleton, poses, queries = pickle.load(file)
    knn = PoseKNeighborsTransformer(skeleton).fit(poses)
    distances, indices, evaluations = knn.kneighbors(queries, K, return_evaluations=True)
    send((distances, indices, evaluations.lengths / len(queries)))
    for line in sys.stdin:
        knn.set_params(n_jobs=int(line))
        send(seconds(lambda: knn.kneighbors(queries, K)))


def send(answer):
    pickle.dump(answer, sys.stdout.buffer)
    sys.stdout.buffer.flush()


def check(skeleton, poses, queries, distances, indices):
    """Compare with a stable sort of the whole matrix."""
    D = pose_distances(queries, poses, skeleton=skeleton, n_jobs=-1)
    order = np.argsort(D, axis=1, kind="stable")[:, :K]
    np.testing.assert_array_equal(indices[: len(queries)], order)
    np.testing.assert_array_equal(distances[: len(queries)], np.take_along_axis(D, order, axis=1))


def compare(name, skeleton, poses, queries, options, n_brute, repeats):
    """Print a line for one index and its queries."""
    with tempfile.NamedTemporaryFile() as file:
        pickle.dump((skeleton, poses, queries), file)
        file.flush()
        checkouts = [Checkout(path, file.name) for path in (common.CHECKOUT, options.against) if path]
    here = checkouts[0].answer
    check(skeleton, poses, queries[:n_brute], *here[:2])
    for there in checkouts[1:]:
        for ours, theirs in zip(here[:2], there.answer[:2], strict=True):
            np.testing.assert_array_equal(ours, theirs)
    F, G = (forward_kinematics(some, skeleton).reshape(len(some), -1) for some in (poses, queries))
    euclidean = NearestNeighbors(algorithm="brute", n_neighbors=K).fit(F)
    runs = []
    for _ in range(repeats):
        with threadpool_limits(1):
            one = seconds(lambda: euclidean.kneighbors(G))[1]
        runs.append([one, seconds(lambda: euclidean.kneighbors(G))[0]])
        time.sleep(common.PAUSE)
        for checkout in checkouts:
            runs[-1] += [checkout.search(1)[1], checkout.search(-1)[0]]
    one, all_, *ours = np.median(runs, axis=0)
    for checkout in checkouts:
        checkout.stop()
    line = f"{name:<42}{len(poses):>8,}  scikit-learn {one:.3f} {all_:.3f}"
    for which, checkout, mine, mine_all in zip(("here", "there"), checkouts, ours[::2], ours[1::2], strict=False):
        line += f"  {which} {mine:.3f} ({mine / one:.2f} ×) {mine_all:.3f} ({mine_all / all_:.2f} ×)"
        line += f" {checkout.answer[2]:.1f} lengths"
    print(line, flush=True)


def main():
    if sys.argv[1:2] == ["--search"]:
        serve(sys.argv[2])
        return
    arguments = common.parser_of_both(__doc__)
    arguments.add_argument("--against", type=Path, help="another checkout of skpose")
    options = arguments.parse_args()
    common.print_machine()
    n_poses, n_queries, n_brute, repeats = QUICK if options.quick else (N_POSES, N_QUERIES, N_BRUTE, REPEATS)
    print(f"{n_queries} queries, k = {K}: poses; seconds of the processor on one thread, of the clock on all cores")
    for case in cases(options, n_poses, n_queries):
        compare(*case, options, n_brute, repeats)


if __name__ == "__main__":
    main()
