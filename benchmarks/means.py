"""Means of many poses: time and iterations, next to scipy on the same objective and geomstats on a toy of equal size.

    python benchmarks/means.py [--cmu FOLDER] [--hdm05 FOLDER] [--quick]

For poses of walks and of actions (generated walks where there is no folder): the extrinsic mean, the same by scipy from
the same start, the intrinsic mean, and the median under "position". Then 28 rotations a pose, as many numbers as a
pose of a person has: the mean under "rotation" of a skeleton of 28 ball joints at the root is the Karcher mean of
SO(3)²⁸, which geomstats computes too (`pip install geomstats`; it is left out where it is not installed or does not
work with the numpy there). Every answer is checked.
"""

import importlib
import time
import warnings

import common
import numpy as np
from scipy.optimize import least_squares, minimize

from skpose import Bone, Skeleton, forward_kinematics, pose_distances
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.geodesics import frechet_mean, geometric_median
from skpose.kinematics import position_jacobian

N_ROTATIONS = 28
FRAME_RATE = 12
SAME = 1e-2  # distance of two poses that are one minimum, m


def timed(function):
    """Return a result and the seconds that it takes; the caller has compiled before."""
    start = time.perf_counter()
    result = function()
    return result, time.perf_counter() - start


def some(X, n):
    """Return n of the poses, at random."""
    return X[np.random.default_rng(0).permutation(len(X))[:n]]


def poses_of(options, n):
    """Yield a name, poses and their skeleton."""
    if options.cmu:
        cmu = load_cmu(options.cmu, rotations="file")
        X, motion_of = cmu.poses(FRAME_RATE)
        yield "CMU walks", some(X[cmu.actions[motion_of] == "walk"], n), cmu.skeleton
    if options.hdm05:
        hdm05 = load_hdm05(options.hdm05, rotations="file")
        yield "HDM05", some(hdm05.poses(FRAME_RATE)[0], n), hdm05.skeleton
    if not (options.cmu or options.hdm05):
        gait = make_gait(10, 10, rotations="file", random_state=0)
        yield "generated walks", some(gait.poses(FRAME_RATE)[0], n), gait.skeleton


def line(name, seconds, n_iter, value):
    """Print one row."""
    print(f"  {name:44s} {1e3 * seconds:10.1f} ms {n_iter:5d} iterations   {value:.6f}")


def by_scipy(X, skeleton, method, start=None):
    """Return the extrinsic mean by scipy, with the Jacobian of the positions, and iterations; None is our start."""
    scale = np.repeat(np.sqrt(skeleton.weights), 3)
    F = forward_kinematics(X, skeleton).reshape(len(X), -1) * scale
    target = F.mean(axis=0)
    if start is None:
        start = X[((F - target) ** 2).sum(axis=1).argmin()]

    def gap(pose):
        return scale * forward_kinematics(pose[None], skeleton).ravel() - target

    def slopes(pose):
        return scale[:, None] * position_jacobian(pose[None], skeleton)[0]

    if method == "lm":
        found = least_squares(gap, start, slopes, method="lm", xtol=1e-12, ftol=1e-12, gtol=1e-10)
        return found.x, found.nfev
    found = minimize(
        lambda pose: (gap(pose) @ gap(pose), 2.0 * slopes(pose).T @ gap(pose)),
        start, jac=True, method=method, options={"maxiter": 5000},
    )  # fmt: skip
    return found.x, found.nit


def variance(X, skeleton, metric, pose):
    """Return the mean of the squared distances, by `pose_distances`."""
    return float((pose_distances(pose[None], X, skeleton=skeleton, metric=metric, n_jobs=-1) ** 2).mean())


def compare_means(name, X, skeleton):
    """Print the means of one set of poses."""
    print(f"{name}: {len(X)} poses of {X.shape[1]} dofs")
    for metric in ("position", "geodesic"):
        frechet_mean(X[:9], skeleton, metric=metric, n_jobs=-1)
    geometric_median(X[:9], skeleton)
    mean, seconds = timed(lambda: frechet_mean(X, skeleton))
    line('frechet_mean, "position"', seconds, mean.n_iter, mean.variance)
    for method in ("lm", "BFGS"):
        (pose, n_iter), seconds = timed(lambda method=method: by_scipy(X, skeleton, method))
        found = variance(X, skeleton, "position", pose)
        line(f'scipy, "{method}", on the same sum', seconds, n_iter, found)
        # It may come to another minimum, as of HDM05 to a lower one; from ours it comes to no other.
        is_same = pose_distances(pose[None], mean.pose[None], skeleton=skeleton, metric="position")[0, 0] < SAME
        assert mean.variance < found * (1 + (1e-4 if is_same else 1e-3))
        polished = variance(X, skeleton, "position", by_scipy(X, skeleton, method, mean.pose)[0])
        assert mean.variance < polished * (1 + 1e-9)
    median, seconds = timed(lambda: geometric_median(X, skeleton))
    line('geometric_median, "position" (mean distance)', seconds, median.n_iter, median.deviation)
    assert median.deviation**2 <= mean.variance
    intrinsic, seconds = timed(lambda: frechet_mean(X, skeleton, metric="geodesic", n_jobs=-1))
    line('frechet_mean, "geodesic"', seconds, intrinsic.n_iter, intrinsic.variance)
    again = variance(X, skeleton, "geodesic", intrinsic.pose)
    at_extrinsic = variance(X, skeleton, "geodesic", mean.pose)
    assert abs(again / intrinsic.variance - 1.0) < 5e-3, (again, intrinsic.variance)
    assert again <= at_extrinsic * (1 + 1e-9)
    assert mean.converged
    assert intrinsic.converged


def rotations_of(n_poses):
    """Return a skeleton of ball joints at the root, and poses of it about a common one."""
    skeleton = Skeleton([Bone(f"b{i}", None, (1.0, 0.0, 0.0), "rotvec") for i in range(N_ROTATIONS)])
    rng = np.random.default_rng(0)
    return skeleton, rng.normal(scale=0.3, size=3 * N_ROTATIONS) + rng.normal(
        scale=0.3, size=(n_poses, 3 * N_ROTATIONS)
    )


def by_geomstats(X):
    """Return the mean of SO(3)²⁸ by geomstats, as rotation vectors, and its iterations; None where it is missing."""
    try:
        special = importlib.import_module("geomstats.geometry.special_orthogonal").SpecialOrthogonal
        n_fold = importlib.import_module("geomstats.geometry.nfold_manifold").NFoldManifold
        learning = importlib.import_module("geomstats.learning.frechet_mean")
    except ImportError as error:
        print(f"  geomstats is left out: {error}")
        return None
    space = n_fold(special(3, point_type="vector"), N_ROTATIONS)
    points = X.reshape(len(X), N_ROTATIONS, 3)
    calls = []
    original = space.metric.log
    space.metric.log = lambda *a, **k: (calls.append(1), original(*a, **k))[1]
    estimator = learning.FrechetMean(space).set(epsilon=1e-8, max_iter=200)
    result, seconds = timed(lambda: estimator.fit(points).estimate_)
    return np.asarray(result).ravel(), len(calls), seconds


def compare_rotations(n_poses):
    """Print the means of rotations."""
    skeleton, X = rotations_of(n_poses)
    print(f"{N_ROTATIONS} rotations: {n_poses} points of {X.shape[1]} dimensions")
    frechet_mean(X[:9], skeleton, metric="rotation", n_jobs=-1)
    mean, seconds = timed(lambda: frechet_mean(X, skeleton, metric="rotation", n_jobs=-1, tol=1e-4))
    line('frechet_mean, "rotation"', seconds, mean.n_iter, mean.variance)
    assert mean.converged
    other = by_geomstats(X)
    if other is not None:
        pose, n_iter, seconds = other
        line("geomstats FrechetMean", seconds, n_iter, variance(X, skeleton, "rotation", pose))
        assert pose_distances(pose[None], mean.pose[None], skeleton=skeleton, metric="rotation")[0, 0] < 1e-2


def main():
    warnings.simplefilter("ignore", UserWarning)  # scipy's optimisers try poses of many turns
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    n_poses = 30 if options.quick else 1000
    for name, X, skeleton in poses_of(options, n_poses):
        compare_means(name, X, skeleton)
    compare_rotations(n_poses)


if __name__ == "__main__":
    main()
