"""SpatialMDS against scikit-learn's ClassicalMDS, MedoidShift against its MeanShift: time, memory, answers.

    python benchmarks/estimators.py [FOLDER OF CMU FILES] [--quick]

Contestants take turns on the same data; the table holds medians, and memory is the peak of what numpy allocates in a
separate run. Without a folder the poses are generated gait.
"""

import tracemalloc
from typing import NamedTuple

import common
import numpy as np
from sklearn.cluster import MeanShift
from sklearn.manifold import ClassicalMDS
from sklearn.metrics import adjusted_rand_score

from skpose import MedoidShift, SpatialMDS, pose_distances

RNG = np.random.default_rng(0)


class Size(NamedTuple):
    n_scaled: int  # poses
    n_clustered: int
    repeats: int


FULL = Size(n_scaled=3000, n_clustered=5000, repeats=3)
QUICK = Size(n_scaled=200, n_clustered=300, repeats=1)


def measured(contestants, repeats):
    """Median seconds, peak MB and fitted estimator of each function, all of them taking turns."""
    memory, fitted = {}, {}
    for name, fit in contestants.items():
        tracemalloc.start()
        fitted[name] = fit()
        memory[name] = tracemalloc.get_traced_memory()[1] / 1e6
        tracemalloc.stop()
    seconds = common.medians(contestants, repeats)
    return {name: (seconds[name], memory[name], fitted[name]) for name in contestants}


def report(results, first, second):
    """Print time and memory of each, and the ratio of two times."""
    for name, (seconds, memory, _) in results.items():
        print(f"  {name:<14}{seconds:>9.2f} s{memory:>9.0f} MB")
    print(f"  ratio of times {results[second][0] / results[first][0]:.1f}")


def main():
    options = common.start(__doc__)
    size = QUICK if options.quick else FULL
    dataset = common.motions(options.folder)
    X, _ = dataset.poses()
    X = X[RNG.choice(len(X), size.n_clustered, replace=False)]
    D = pose_distances(X[: size.n_scaled], skeleton=dataset.skeleton, n_jobs=-1)
    print(f"{dataset}\nTwo components of {len(D)} x {len(D)} spatial distances")
    results = measured(
        {
            "SpatialMDS": lambda: SpatialMDS(n_components=2, metric="precomputed").fit(D),
            "ClassicalMDS": lambda: ClassicalMDS(2, metric="precomputed").fit(D),
        },
        size.repeats,
    )
    ours, theirs = (results[name][2].eigenvalues_ for name in ("SpatialMDS", "ClassicalMDS"))
    np.testing.assert_allclose(ours, theirs, rtol=1e-8)
    report(results, "SpatialMDS", "ClassicalMDS")
    print(f"  eigenvalues differ by {np.abs(ours / theirs - 1).max():.0e}")

    bandwidth = MedoidShift(metric="angle").fit(X[:1000]).bandwidth_ / 3
    print(f"\nClusters of {len(X)} joint-angle vectors, bandwidth {bandwidth:.3f} rad, all cores")
    results = measured(
        {
            "MedoidShift": lambda: MedoidShift(bandwidth=bandwidth, metric="angle", n_jobs=-1).fit(X),
            "MeanShift": lambda: MeanShift(bandwidth=bandwidth, n_jobs=-1).fit(X),
        },
        size.repeats,
    )
    report(results, "MedoidShift", "MeanShift")
    ours, theirs = (results[name][2].labels_ for name in ("MedoidShift", "MeanShift"))
    agreement = adjusted_rand_score(ours, theirs)
    print(f"  {len(set(ours))} and {len(set(theirs))} clusters, adjusted Rand index {agreement:.2f}")


if __name__ == "__main__":
    main()
