"""How fast are forward kinematics and every metric? Ratios to a plain scalar numba kernel, in one run.

    python benchmarks/speed.py [FOLDER OF CMU FILES] [--quick]

Contestants take turns, a table holds medians, and every answer is checked against the scalar kernel's first. All use
all cores but scikit-learn's `pairwise_distances`, which calls a compiled function of two poses under the GIL.
"""

from typing import NamedTuple

import common
import numpy as np
import scalar
from numba import njit
from sklearn.metrics import pairwise_distances

from skpose import forward_kinematics, pose_distances, pose_metric
from skpose._compiled.simd.lanes import lanes, rows
from skpose.kinematics._tree import tree_of
from skpose.metrics import Spatial

METRICS = ("angle", "position", "rotation", "spatial")
RNG = np.random.default_rng(0)


class Size(NamedTuple):
    n_poses: int  # of X and of Y
    n_rows: dict  # of X, for the slow contestants
    n_multiply_adds: int
    repeats: int


FULL = Size(2000, {"scalar": 100, "sklearn": 20}, 1_000_000, common.REPEATS)
QUICK = Size(100, {"scalar": 10, "sklearn": 2}, 10_000, 1)


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
    """Additions and multiplications that a pair costs under "spatial", counted in `skpose._compiled`."""
    n_dofs = tree.end_dof - tree.first_dof
    n_inner = tree.first_frame[-1]
    rotations = n_dofs[:n_inner].sum() + (n_dofs[1:n_inner] == 0).sum()  # of two rows each
    tips = n_dofs[n_inner:]
    n_placed = (tree.joint_frame[1:] > 0).sum()
    step = 8 * n_dofs.sum() + 2 * 6 * rotations + (2 + 6 * (tips - 1)).sum() + n_placed * (9 + 3 * 5 + 3 * 4)
    ends = 3 * n_dofs.sum() + 6 * n_dofs.sum() + 9 * (len(tree.offset) - 1)
    return (n_steps - 1) * step + ends


def share_of_peak(X, Y, skeleton, size):
    """Operations per second of the spatial kernel on one core, and of nothing but multiply-adds."""
    X, width, n = X[:500], lanes(X.dtype), size.n_multiply_adds
    array, factor = np.ones((7, width), X.dtype), X.dtype.type(1e-9)
    seconds = common.medians(
        {
            "kernel": lambda: pose_distances(X, Y, skeleton=skeleton, metric=Spatial(wrap=False)),
            "peak": lambda: multiply_add(array, factor, n),
        },
        size.repeats,
    )
    done = operations(tree_of(skeleton), 10) * len(X) * len(Y) / seconds["kernel"]
    return done, 2 * 7 * width * n / seconds["peak"]


def kinematics(X, skeleton, tree, size):
    """Poses per second of the forward kinematics."""
    many = np.tile(X, (10, 1))
    np.testing.assert_allclose(forward_kinematics(X, skeleton), scalar.forward_kinematics(X, tree), atol=1e-12)
    seconds = common.medians(
        {
            "skpose, one core": lambda: forward_kinematics(many, skeleton),
            "skpose, all cores": lambda: forward_kinematics(many, skeleton, n_jobs=-1),
            "scalar kernel, all cores": lambda: scalar.forward_kinematics(many, tree),
        },
        size.repeats,
    )
    print("forward kinematics, poses/s")
    for name, value in seconds.items():
        print(f"  {name:<26}{len(many) / value:>14,.0f}")


def position(X, Y, skeleton, size):
    """Time of "position" from angles on, and of scikit-learn from joint positions on."""
    F, G = (forward_kinematics(P, skeleton).reshape(len(P), -1) for P in (X, Y))
    seconds = common.medians(
        {
            "position": lambda: pose_distances(X, Y, skeleton=skeleton, metric="position", n_jobs=-1),
            "sklearn": lambda: pairwise_distances(F, G),
        },
        size.repeats,
    )
    print(
        f"position: {1e3 * seconds['position']:.0f} ms from angles on; scikit-learn's pairwise_distances of the joint "
        f"positions {1e3 * seconds['sklearn']:.0f} ms, ratio {seconds['position'] / seconds['sklearn']:.2f}\n"
    )


def rates(metric, X, Y, skeleton, tree, size):
    """Pairs per second of every contestant, after a comparison of their answers."""
    literal = Spatial(wrap=False) if metric == "spatial" else metric  # as the scalar kernel
    naive, f = getattr(scalar, metric), pose_metric(skeleton, metric=literal)
    single = X.astype(np.float32), Y.astype(np.float32)

    def distances(A, B=None):
        return pose_distances(A, B, skeleton=skeleton, metric=literal, n_jobs=-1)

    few = {name: X[:n] for name, n in size.n_rows.items()}
    expected = naive(few["scalar"], Y, tree)
    # The scalar kernel's arccos of a trace loses half the digits of small angles.
    tolerance = {"rtol": 1e-6, "atol": 1e-6} if metric == "rotation" else {"rtol": 1e-10, "atol": 1e-12}
    np.testing.assert_allclose(distances(few["scalar"], Y), expected, **tolerance)
    np.testing.assert_allclose(distances(*single)[: len(expected)], expected, rtol=1e-4, atol=1e-5)
    by_sklearn = pairwise_distances(few["sklearn"], Y, metric=f)
    np.testing.assert_allclose(by_sklearn, expected[: len(by_sklearn)], **tolerance)
    seconds = common.medians(
        {
            "skpose": lambda: distances(X, Y),
            "float32": lambda: distances(*single),
            "Y=None": lambda: distances(X),
            "scalar": lambda: naive(few["scalar"], Y, tree),
            "sklearn": lambda: pairwise_distances(few["sklearn"], Y, metric=f),
        },
        size.repeats,
    )
    return {name: size.n_rows.get(name, len(X)) * len(Y) / value for name, value in seconds.items()}


def main():
    options = common.start(__doc__)
    size = QUICK if options.quick else FULL
    dataset = common.motions(options.folder)
    skeleton, (poses, _) = dataset.skeleton, dataset.poses()
    poses = poses[RNG.choice(len(poses), 2 * size.n_poses, replace=False)]
    X, Y = np.ascontiguousarray(poses[: size.n_poses]), np.ascontiguousarray(poses[size.n_poses :])
    tree = scalar.tree_of(skeleton)
    print(f"{dataset}\n{skeleton}, {len(X)} x {len(Y)} poses, n_steps = 10\n")
    kinematics(X, skeleton, tree, size)
    for kind in (np.float64, np.float32):
        done, peak = share_of_peak(X.astype(kind), Y.astype(kind), skeleton, size)
        print(f"spatial, one core, {np.dtype(kind)}: {done / 1e9:.1f} of {peak / 1e9:.1f} GFlop/s, {done / peak:.0%}")
    position(X, Y, skeleton, size)

    header = ("metric", "pairs/s", "x scalar", "float32", "Y=None", "sklearn", "scalar, pairs/s")
    print(("{:<10}" + "{:>14}" + "{:>10}" * 4 + "{:>18}").format(*header))
    for metric in METRICS:
        rate = rates(metric, X, Y, skeleton, tree, size)
        ratios = [rate[name] / rate["scalar"] for name in ("skpose", "float32", "Y=None", "sklearn")]
        print(
            f"{metric:<10}{rate['skpose']:>14,.0f}"
            + "".join(f"{r:>10.2f}" for r in ratios)
            + f"{rate['scalar']:>18,.0f}"
        )


if __name__ == "__main__":
    main()
