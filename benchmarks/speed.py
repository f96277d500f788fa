"""How fast are forward kinematics and every metric? Ratios to a plain scalar numba kernel, in one run.

    python benchmarks/speed.py [FOLDER OF CMU FILES]

Contestants take turns, a table holds medians, and every answer is checked against the scalar kernel's first. All use
all cores but scikit-learn's `pairwise_distances`, which calls a compiled function of two poses under the GIL.
"""

import os
import statistics
import sys
import time

import numpy as np
import scalar
from sklearn.metrics import pairwise_distances

from skpose import forward_kinematics, pose_distances, pose_metric
from skpose.compare import COMPARED
from skpose.datasets import load_cmu, make_gait

REPEATS = 5
N_POSES = 2000  # X and Y; the slow contestants get fewer rows of X
N_SLOW_ROWS = {"scalar": 100, "sklearn": 20}
RNG = np.random.default_rng(0)


def medians(contestants):
    """Median seconds of each function, all of them taking turns."""
    for function in contestants.values():
        function()
    seconds = {name: [] for name in contestants}
    for _ in range(REPEATS):
        for name, function in contestants.items():
            start = time.perf_counter()
            function()
            seconds[name].append(time.perf_counter() - start)
    return {name: statistics.median(values) for name, values in seconds.items()}


def main():
    dataset = load_cmu(sys.argv[1]) if len(sys.argv) > 1 else make_gait(10, 10, random_state=0)
    skeleton = dataset.skeleton
    poses, _ = dataset.poses()
    poses = poses[RNG.choice(len(poses), 2 * N_POSES, replace=False)]
    X, Y = np.ascontiguousarray(poses[:N_POSES]), np.ascontiguousarray(poses[N_POSES:])
    tree = scalar.tree_of(skeleton)
    print(f"{dataset}\n{skeleton}, {os.cpu_count()} cores, {N_POSES} x {N_POSES} poses, n_steps = 10\n")

    many = np.tile(X, (10, 1))
    np.testing.assert_allclose(forward_kinematics(X, skeleton), scalar.forward_kinematics(X, tree), atol=1e-12)
    seconds = medians(
        {
            "skpose": lambda: forward_kinematics(many, skeleton),
            "scalar": lambda: scalar.forward_kinematics(many, tree),
        }
    )
    rate = {name: len(many) / value for name, value in seconds.items()}
    print(
        f"forward kinematics: {rate['skpose']:,.0f} poses/s on one core, scalar kernel {rate['scalar']:,.0f} on all\n"
    )

    header = ("metric", "pairs/s", "x scalar", "float32", "Y=None", "sklearn", "scalar, pairs/s")
    print(("{:<10}" + "{:>14}" + "{:>10}" * 4 + "{:>18}").format(*header))
    for metric in COMPARED:
        naive, f = getattr(scalar, metric), pose_metric(metric, skeleton, wrap=False)
        single = X.astype(np.float32), Y.astype(np.float32)

        def distances(A, B=None, metric=metric):
            return pose_distances(A, B, skeleton=skeleton, metric=metric, wrap=False, n_jobs=-1)

        rows = {name: X[:n] for name, n in N_SLOW_ROWS.items()}
        expected = naive(rows["scalar"], Y, tree)
        # arccos of a trace loses half the digits of small angles; that is the scalar kernel's doing.
        tolerance = {"rtol": 1e-6, "atol": 1e-6} if metric == "rotation" else {"rtol": 1e-10, "atol": 1e-12}
        np.testing.assert_allclose(distances(rows["scalar"], Y), expected, **tolerance)
        np.testing.assert_allclose(distances(*single)[: len(expected)], expected, rtol=1e-4, atol=1e-5)
        np.testing.assert_allclose(pairwise_distances(rows["sklearn"], Y, metric=f), expected[:20], **tolerance)
        seconds = medians(
            {
                "skpose": lambda: distances(X, Y),
                "float32": lambda single=single: distances(*single),
                "Y=None": lambda: distances(X),
                "scalar": lambda naive=naive, rows=rows: naive(rows["scalar"], Y, tree),
                "sklearn": lambda f=f, rows=rows: pairwise_distances(rows["sklearn"], Y, metric=f),
            }
        )
        rate = {name: N_SLOW_ROWS.get(name, N_POSES) * N_POSES / value for name, value in seconds.items()}
        ratios = [rate[name] / rate["scalar"] for name in ("skpose", "float32", "Y=None", "sklearn")]
        print(
            f"{metric:<10}{rate['skpose']:>14,.0f}"
            + "".join(f"{r:>10.2f}" for r in ratios)
            + f"{rate['scalar']:>18,.0f}"
        )


if __name__ == "__main__":
    main()
