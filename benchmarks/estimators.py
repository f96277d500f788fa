"""SpatialMDS against scikit-learn's ClassicalMDS, MedoidShift against its MeanShift: time, memory, answers.

    python benchmarks/estimators.py [FOLDER OF CMU FILES]

Contestants take turns on the same data; the table holds medians, and memory is the peak of what numpy allocates in a
separate run. Without a folder the poses are generated gait.
"""

import statistics
import sys
import time
import tracemalloc

import numpy as np
from sklearn.cluster import MeanShift
from sklearn.manifold import ClassicalMDS
from sklearn.metrics import adjusted_rand_score

from skpose import MedoidShift, SpatialMDS, pose_distances
from skpose.datasets import load_cmu, make_gait

REPEATS = 3
N_SCALED = 3000
N_CLUSTERED = 5000
RNG = np.random.default_rng(0)


def measured(contestants):
    """Median seconds, peak MB and fitted estimator of each function, all of them taking turns."""
    seconds, memory, fitted = {name: [] for name in contestants}, {}, {}
    for name, fit in contestants.items():
        tracemalloc.start()
        fitted[name] = fit()
        memory[name] = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
    for _ in range(REPEATS):
        for name, fit in contestants.items():
            start = time.perf_counter()
            fit()
            seconds[name].append(time.perf_counter() - start)
    return {name: (statistics.median(seconds[name]), memory[name], fitted[name]) for name in contestants}


def report(results, first, second):
    for name, (seconds, memory, _) in results.items():
        print(f"  {name:<14}{seconds:>9.2f} s{memory:>9.0f} MB")
    print(f"  ratio of times {results[second][0] / results[first][0]:.1f}")


def main():
    dataset = load_cmu(sys.argv[1]) if len(sys.argv) > 1 else make_gait(10, 10, random_state=0)
    X, _ = dataset.poses()
    X = X[RNG.choice(len(X), N_CLUSTERED, replace=False)]
    D = pose_distances(X[:N_SCALED], skeleton=dataset.skeleton, n_jobs=-1)
    print(f"{dataset}\nTwo components of {N_SCALED} x {N_SCALED} spatial distances")
    results = measured(
        {
            "SpatialMDS": lambda: SpatialMDS(2, metric="precomputed").fit(D),
            "ClassicalMDS": lambda: ClassicalMDS(2, metric="precomputed").fit(D),
        }
    )
    ours, theirs = (results[name][2].eigenvalues_ for name in ("SpatialMDS", "ClassicalMDS"))
    np.testing.assert_allclose(ours, theirs, rtol=1e-8)
    report(results, "SpatialMDS", "ClassicalMDS")
    print(f"  eigenvalues differ by {np.abs(ours / theirs - 1).max():.0e}")

    bandwidth = MedoidShift().fit(X[:1000]).bandwidth_ / 3
    print(f"\nClusters of {N_CLUSTERED} joint-angle vectors, bandwidth {bandwidth:.3f} rad, all cores")
    results = measured(
        {
            "MedoidShift": lambda: MedoidShift(bandwidth, n_jobs=-1).fit(X),
            "MeanShift": lambda: MeanShift(bandwidth=bandwidth, n_jobs=-1).fit(X),
        }
    )
    report(results, "MedoidShift", "MeanShift")
    ours, theirs = (results[name][2].labels_ for name in ("MedoidShift", "MeanShift"))
    agreement = adjusted_rand_score(ours, theirs)
    print(f"  {len(set(ours))} and {len(set(theirs))} clusters, adjusted Rand index {agreement:.2f}")


if __name__ == "__main__":
    main()
