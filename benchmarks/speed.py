"""How fast are forward kinematics and every metric? Ratios to a plain scalar numba kernel, in one run.

    python benchmarks/speed.py [FOLDER OF CMU FILES]

Contestants take turns, a table holds medians, and every answer is checked against the scalar kernel's first. All use
all cores but scikit-learn's `pairwise_distances`, which calls a compiled function of two poses under the GIL.
"""

import os
import sys

import numpy as np
import scalar
from numba import njit
from sklearn.metrics import pairwise_distances
from timing import medians

from skpose import forward_kinematics, pose_distances, pose_metric
from skpose._cli.compare import COMPARED
from skpose._compiled.lanes import lanes, rows
from skpose.datasets import load_cmu, make_gait
from skpose.kinematics._tree import tree_of

N_POSES = 2000  # X and Y; the slow contestants get fewer rows of X
N_SLOW_ROWS = {"scalar": 100, "sklearn": 20}
RNG = np.random.default_rng(0)


@njit(nogil=True, fastmath={"contract"})
def multiply_add(array, factor, n):
    """Seven chains of multiply-adds on lanes: enough to hide its latency, few enough to stay in registers."""
    r = rows(array, 0)
    a, b, c, d, e, f, g = r[0], r[1], r[2], r[3], r[4], r[5], r[6]
    for _ in range(n):
        a, b, c, d = a * factor + a, b * factor + b, c * factor + c, d * factor + d
        e, f, g = e * factor + e, f * factor + f, g * factor + g
    r[0] = a + b + c + d + e + f + g


def operations(tree, n_steps):
    """Additions and multiplications that a pair costs under "spatial", counted in `skpose._compiled.kernels`."""
    n_dofs = tree.end_dof - tree.first_dof
    n_inner = tree.first_frame[-1]
    turns = n_dofs[:n_inner].sum() + (n_dofs[1:n_inner] == 0).sum()  # of two rows each
    tips = n_dofs[n_inner:]
    n_placed = (tree.joint_frame[1:] > 0).sum()
    step = 8 * n_dofs.sum() + 2 * 6 * turns + (2 + 6 * (tips - 1)).sum() + n_placed * (9 + 3 * 5 + 3 * 4)
    ends = 3 * n_dofs.sum() + 6 * n_dofs.sum() + 9 * (len(tree.offset) - 1)
    return (n_steps - 1) * step + ends


def share_of_peak(X, Y, skeleton):
    """Operations per second of the spatial kernel on one core, and of nothing but multiply-adds."""
    width, n = lanes(X.dtype), 1_000_000
    array, factor = np.ones((7, width), X.dtype), X.dtype.type(1e-9)
    seconds = medians(
        {
            "kernel": lambda: pose_distances(X[:500], Y, skeleton=skeleton, wrap=False),
            "peak": lambda: multiply_add(array, factor, n),
        }
    )
    done = operations(tree_of(skeleton), 10) * 500 * len(Y) / seconds["kernel"]
    return done, 2 * 7 * width * n / seconds["peak"]


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
            "skpose, one core": lambda: forward_kinematics(many, skeleton),
            "scalar kernel, all cores": lambda: scalar.forward_kinematics(many, tree),
        }
    )
    print("forward kinematics, poses/s")
    for name, value in seconds.items():
        print(f"  {name:<26}{len(many) / value:>14,.0f}")
    for kind in (np.float64, np.float32):
        done, peak = share_of_peak(X.astype(kind), Y.astype(kind), skeleton)
        print(f"spatial, one core, {np.dtype(kind)}: {done / 1e9:.1f} of {peak / 1e9:.1f} GFlop/s, {done / peak:.0%}")
    F, G = (forward_kinematics(P, skeleton).reshape(len(P), -1) for P in (X, Y))
    seconds = medians(
        {
            "position": lambda: pose_distances(X, Y, skeleton=skeleton, metric="position", n_jobs=-1),
            "sklearn": lambda: pairwise_distances(F, G),
        }
    )
    print(
        f"position: {1e3 * seconds['position']:.0f} ms from angles on; scikit-learn's pairwise_distances of the joint "
        f"positions {1e3 * seconds['sklearn']:.0f} ms, ratio {seconds['position'] / seconds['sklearn']:.2f}\n"
    )

    header = ("metric", "pairs/s", "x scalar", "float32", "Y=None", "sklearn", "scalar, pairs/s")
    print(("{:<10}" + "{:>14}" + "{:>10}" * 4 + "{:>18}").format(*header))
    for metric in COMPARED:
        naive, f = getattr(scalar, metric), pose_metric(skeleton, metric=metric, wrap=False)
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
