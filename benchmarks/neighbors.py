"""How exact and how fast is the search of nearest neighbours? Against brute force and scikit-learn, in one run.

    python benchmarks/neighbors.py [FOLDER OF CMU FILES] [--quick]

Equality first: indices and distances, by ``==``, against a stable sort of `pose_distances`. Then contestants take
turns, a table holds medians. scikit-learn's brute force gets the joint positions ready made, and all cores.
"""

import time
from typing import NamedTuple

import common
import numpy as np
from sklearn.neighbors import NearestNeighbors

from skpose import (
    PoseKNeighborsTransformer,
    forward_kinematics,
    pose_distances,
)
from skpose.neighbors import PoseRadiusNeighborsTransformer, _search
from skpose.neighbors._graph import Request, find

KS = (1, 5, 15, 50)
QUANTILES = (0.001, 0.01, 0.1)  # of all distances, as radii
METRICS = ("angle", "position", "rotation", "spatial")
RNG = np.random.default_rng(0)


class Size(NamedTuple):
    frame_rate: float  # of the queries whose searches among all frames are compared with brute force
    n_random: int  # poses
    n_index: int
    n_queries: int
    n_brute: int  # queries for brute force, whose time is scaled
    geodesic: tuple  # queries, poses
    repeats: int


FULL = Size(12, 2000, 100_000, 1000, 50, (200, 10_000), 5)
QUICK = Size(2, 60, 600, 20, 5, (2, 50), 1)


def positions(X, skeleton):
    """Joint positions, a row for each pose."""
    return forward_kinematics(X, skeleton).reshape(len(X), -1)


def n_measured(knn, queries, k):
    """How many distances a search measures for each query; with "geodesic", how many geodesics it solves."""
    return find(Request(knn._index, queries, np.full(len(queries), -1), k=k), -1, 0).n_measured / len(queries)


# --- equality --------------------------------------------------------------------------------------------------------


def check(X, queries, skeleton, metric, ks):
    """Compare every k and every radius with brute force; return how many lengths a query measured, for every k."""
    D = pose_distances(queries, X, skeleton=skeleton, metric=metric, n_jobs=-1)
    order = np.argsort(D, axis=1, kind="stable")
    knn = PoseKNeighborsTransformer(skeleton, metric=metric, n_jobs=-1).fit(X)
    measured = []
    for k in ks:
        distances, indices = knn.kneighbors(queries, k)
        np.testing.assert_array_equal(indices, order[:, :k])
        np.testing.assert_array_equal(distances, np.take_along_axis(D, order[:, :k], axis=1))
        measured.append(n_measured(knn, queries, k))
    near = PoseRadiusNeighborsTransformer(skeleton, metric=metric, n_jobs=-1).fit(X)
    for radius in [0.0, *np.quantile(D, QUANTILES)]:
        for row, distances, indices in zip(D, *near.radius_neighbors(queries, radius), strict=True):
            inside = np.flatnonzero(row <= radius)
            inside = inside[np.argsort(row[inside], kind="stable")]
            np.testing.assert_array_equal(indices, inside)
            np.testing.assert_array_equal(distances, row[inside])
    return measured


def equality(dataset, size):
    """Compare searches with brute force: among frames, among random poses, and under "geodesic"."""
    skeleton = dataset.skeleton
    subjects = sorted(set(dataset.subjects))
    poses, some = (
        {name: dataset[dataset.subjects == name].poses(frame_rate=rate, skeleton=skeleton)[0] for name in subjects}
        for rate in (None, size.frame_rate)
    )
    print(f"equal to brute force, {len(subjects)}² pairs of subjects, queries at {size.frame_rate} Hz among all frames")
    print("distances measured per query for k = " + ", ".join(map(str, KS)))
    for metric in METRICS:
        within, across = [], []
        for a in subjects:
            for b in subjects:
                ks = [k for k in KS if k <= len(poses[b])]
                (within if a == b else across).append(check(poses[b], some[a], skeleton, metric, ks))
        for name, rows in (("same subject", within), ("another subject", across)):
            if rows:
                print(f"  {metric:<9}{name:<16}" + "".join(f"{x:>10.1f}" for x in np.mean(rows, axis=0)))

    n = size.n_random
    X = RNG.uniform(-np.pi, np.pi, size=(n, skeleton.n_dofs))
    doubled = np.concatenate([X[: n // 2], X[: n // 2]])
    for metric in METRICS:
        check(X, X[: n // 20] + 0.01, skeleton, metric, KS)
        check(doubled, doubled[:: n // 50], skeleton, metric, (*KS, n))
        check(X[:1], X[:10], skeleton, metric, (1,))
    print("also random poses, duplicates, one pose, k = n")
    for a in subjects:
        for b in subjects:
            few, queries = RNG.choice(poses[b], 60, replace=False), RNG.choice(poses[a], 2, replace=False)
            check(few, queries, skeleton, "geodesic", (1, 5, 15))
    print("also geodesic, 2 queries among 60 poses for each pair of subjects")


# --- speed -----------------------------------------------------------------------------------------------------------


def dense(dataset, n, n_queries):
    """Frames, and interpolations between them until there are n poses and the queries."""
    n_frames, rate = sum(len(motion) for motion in dataset), max(motion.frame_rate for motion in dataset)
    poses, sequence = dataset.poses(frame_rate=rate * int(np.ceil((n + n_queries) / n_frames)))
    return poses, dataset.subjects[sequence]


def brute_force(queries, X, skeleton, k):
    """Return the k least distances of each query, in order."""
    D = pose_distances(queries, X, skeleton=skeleton, n_jobs=-1)
    nearest = np.argpartition(D, k - 1, axis=1)[:, :k]
    return np.sort(np.take_along_axis(D, nearest, axis=1), axis=1)


def spatial(name, X, queries, skeleton, size, k=10):
    """Print times of a search under "spatial", of scikit-learn's among joint positions, and of brute force."""
    start = time.perf_counter()
    knn = PoseKNeighborsTransformer(skeleton, n_jobs=-1).fit(X)
    seconds_to_fit = time.perf_counter() - start
    whole = PoseKNeighborsTransformer(skeleton, n_jobs=-1, algorithm="brute").fit(X)
    F, G = positions(X, skeleton), positions(queries, skeleton)
    euclidean = NearestNeighbors(algorithm="brute", n_neighbors=k).fit(F)
    few = queries[: size.n_brute]
    distances, _ = knn.kneighbors(queries, k)
    np.testing.assert_array_equal(distances[: size.n_brute], brute_force(few, X, skeleton, k))
    assert (euclidean.kneighbors(G)[0] <= distances + 1e-6).all()
    seconds = common.medians(
        {
            "skpose": lambda: knn.kneighbors(queries, k),
            "sklearn": lambda: euclidean.kneighbors(G),
            "brute": lambda: whole.kneighbors(few, k),
            "matrix": lambda: brute_force(few, X, skeleton, k),
        },
        size.repeats,
    )
    factor = len(queries) / len(few)
    print(
        f"{name}: {len(queries)} queries, {len(X)} poses; fit {seconds_to_fit:.2f} s\n"
        f"  skpose {seconds['skpose']:.3f} s, {n_measured(knn, queries, k):.1f} lengths per query\n"
        f"  scikit-learn's brute force on joint positions {seconds['sklearn']:.3f} s: "
        f"ratio {seconds['skpose'] / seconds['sklearn']:.2f}\n"
        f"  algorithm='brute' {factor * seconds['brute']:.1f} s: "
        f"ratio {factor * seconds['brute'] / seconds['skpose']:.0f} (of {len(few)} queries, scaled)\n"
        f"  pose_distances and argpartition {factor * seconds['matrix']:.1f} s: "
        f"ratio {factor * seconds['matrix'] / seconds['skpose']:.0f} (likewise)"
    )


def geodesic(poses, skeleton, size, k=5):
    """Print time and cost of a search under "geodesic"."""
    n_queries, n = size.geodesic
    chosen = RNG.permutation(len(poses))[: n + n_queries]
    knn = PoseKNeighborsTransformer(skeleton, metric="geodesic", n_jobs=-1).fit(poses[chosen[n_queries:]])
    knn.kneighbors(poses[chosen[:1]], k)  # compiles
    start = time.perf_counter()
    knn.kneighbors(poses[chosen[:n_queries]], k)
    seconds = time.perf_counter() - start
    print(
        f"\ngeodesic, k = {k}, {n_queries} queries, {n} poses: {seconds:.1f} s, "
        f"{n_measured(knn, poses[chosen[:n_queries]], k):.2f} geodesics per query"
    )


def main():
    options = common.start(__doc__)
    size = QUICK if options.quick else FULL
    dataset = common.motions(options.folder, 5, 5)
    if options.quick:
        first = [np.flatnonzero(dataset.subjects == name)[0] for name in sorted(set(dataset.subjects))[:2]]
        dataset = dataset[np.isin(np.arange(len(dataset)), first)]
    skeleton = dataset.skeleton
    print(f"{dataset}\n{skeleton}\n")
    least, _search.LEAST_WORK_TO_FILTER = _search.LEAST_WORK_TO_FILTER, 0  # so that small indices are filtered too
    equality(dataset, size)
    _search.LEAST_WORK_TO_FILTER = least

    n_index, n_queries = size.n_index, size.n_queries
    poses, subjects = dense(dataset, n_index, n_queries)
    chosen = RNG.permutation(len(poses))
    print("\nspatial, k = 10")
    spatial(
        "of the same motions",
        poses[np.sort(chosen[n_queries : n_queries + n_index])],
        poses[chosen[:n_queries]],
        skeleton,
        size,
    )
    first = subjects == subjects[0]
    spatial(
        f"subject {subjects[0]} among the others",
        poses[~first],
        RNG.choice(poses[first], n_queries, replace=False),
        skeleton,
        size,
    )
    geodesic(poses, skeleton, size)


if __name__ == "__main__":
    main()
