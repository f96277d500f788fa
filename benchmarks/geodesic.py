"""How fast and how good are geodesics? Against scipy's minimisers on the same energy, in one run; and eq. 8.

    python benchmarks/geodesic.py [FOLDER OF CMU FILES] [--quick]

scipy gets the energy and its closed-form gradient from skpose's compiled kinematics, on one thread. Each contestant
starts at the straight line in angle space; times are medians over repeats of the mean over 20 pairs.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: one thread for everybody

import warnings
from functools import partial
from typing import NamedTuple

import common
import numpy as np
from numba import njit
from scipy.optimize import minimize
from sklearn.exceptions import ConvergenceWarning

from skpose import geodesic, pose_distances
from skpose._compiled.path.energy import evaluate, path_of, samples_for
from skpose._compiled.path.normal_equations import equations_for, gradient_of
from skpose.kinematics._tree import tree_of
from skpose.metrics import Geodesic

N_STEPS = 10


class Size(NamedTuple):
    n_raced: int  # pairs
    n_ratios: int
    copies: int  # of each pose of a walk, for the speed on two threads
    repeats: int


FULL = Size(20, 100, 4, 3)
QUICK = Size(2, 5, 1, 1)


@njit
def path_and_workspace(tree, poses):
    """A path of these poses, with room for its samples and for its gradient."""
    path = path_of(tree, poses, 1)
    return path, samples_for(tree, path), equations_for(tree, path)


@njit(nogil=True)
def energy_and_gradient(tree, path, samples, equations):
    """Eq. 6, and half its derivative in all poses among the equations."""
    gradient_of(tree, path, samples, equations)
    return 2.0 * evaluate(tree, path, samples)


class Energy:
    """Eq. 6 from start to end as scipy sees it: of a flat array of the inner poses."""

    def __init__(self, start, end, skeleton):
        self.tree = tree_of(skeleton)
        gap = (end - start + np.pi) % (2 * np.pi) - np.pi
        line = start + np.linspace(0, 1, N_STEPS + 1)[:, None] * gap
        poses = np.ascontiguousarray(line[:, self.tree.column] * self.tree.sign)
        self.path, self.samples, self.equations = path_and_workspace(self.tree, poses)
        self.start = self.path.poses[1:-1].ravel().copy()

    def __call__(self, x):
        self.path.poses[1:-1] = x.reshape(N_STEPS - 1, -1)
        value = energy_and_gradient(self.tree, self.path, self.samples, self.equations)
        return value, 2.0 * self.equations.gradient[1:-1].ravel()

    def hessian_product(self, x, direction):
        step = 1e-6 / max(np.linalg.norm(direction), 1e-300)
        return (self(x + step * direction)[1] - self(x - step * direction)[1]) / (2 * step)


def by_scipy(method, **options):
    """A contestant: energy of the path that scipy finds, and norm of the gradient there."""

    def solve(start, end, skeleton):
        energy = Energy(start, end, skeleton)
        product = energy.hessian_product if method == "trust-krylov" else None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a minimiser stops early is in the table
            found = minimize(energy, energy.start, jac=True, hessp=product, method=method, options=options)
        return energy(found.x)[0], np.linalg.norm(energy(found.x)[1])

    return solve


def by_skpose(start, end, skeleton, **options):
    path = geodesic(start, end, skeleton, metric=Geodesic(N_STEPS), **options)
    return path.energy, path.gradient_norm


CONTESTANTS = {
    "skpose": by_skpose,
    "skpose, tol = 0": partial(by_skpose, tol=0.0),
    "scipy L-BFGS-B, defaults": by_scipy("L-BFGS-B"),
    "scipy L-BFGS-B, gtol = 1e-5": by_scipy("L-BFGS-B", gtol=1e-5, ftol=0, maxiter=20_000, maxfun=50_000),
    "scipy trust-krylov, defaults": by_scipy("trust-krylov"),
}


def pairs_of_one_walk(dataset, sequence, chosen, n, rng):
    """Random pairs of poses, both of one random sequence out of the chosen ones."""
    sequences = rng.choice(np.flatnonzero(chosen), n)
    return np.array([rng.choice(np.flatnonzero(sequence == i), 2, replace=False) for i in sequences])


def race(X, pairs, skeleton, repeats):
    """Print the time of every contestant, the largest gradient that it leaves, and its energies over skpose's."""
    print(f"{len(pairs)} pairs of walking poses, one thread, ten steps\n")
    print(
        f"{'':<30}{'ms':>8}{'x skpose':>10}{'gradient, largest':>19}{'energy over that of tol = 0, largest, least':>43}"
    )
    results = {}

    def run(name):
        results[name] = np.array([CONTESTANTS[name](X[i], X[j], skeleton) for i, j in pairs])

    seconds = common.medians({name: partial(run, name) for name in CONTESTANTS}, repeats)
    for name, found in results.items():
        above = found[:, 0] / results["skpose, tol = 0"][:, 0] - 1
        assert above.min() > -1e-9, f"{name} finds a path of less energy"
        print(
            f"{name:<30}{1e3 * seconds[name] / len(pairs):>8.2f}{seconds[name] / seconds['skpose']:>10.1f}"
            f"{found[:, 1].max():>19.1e}{above.max():>22.1e}{above.min():>21.1e}"
        )


def ratios(X, pairs, skeleton, title):
    """Print lengths of geodesics over those of straight lines."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ConvergenceWarning)
        paths = [geodesic(X[i], X[j], skeleton, metric=Geodesic(N_STEPS)) for i, j in pairs]
    chord, line = (
        np.array([pose_distances(X[[i]], X[[j]], skeleton=skeleton, metric=m)[0, 0] for i, j in pairs])
        for m in ("position", "spatial")
    )
    length, curve = np.array([path.length for path in paths]), np.array([path.curve_length for path in paths])
    r = length / line
    assert (chord <= length * (1 + 1e-9)).all()
    assert (length <= line * (1 + 1e-9)).all()
    print(
        f"{title}: lowest {r.min():.4f}, median {np.median(r):.4f}, highest {r.max():.4f}; {np.sum(r < 0.94)} below "
        f"0.94, {np.sum((r < 0.94) & (curve / line < 0.94))} of them also as curves on the fine grid\n"
        f"    gradient {max(path.gradient_norm for path in paths):.1e} at most, curve over chords - 1 "
        f"{np.max(curve / length - 1):.2%} at most, {sum(len(path.path) > N_STEPS + 1 for path in paths)} refined, "
        f"{len(caught)} not converged; lowest chord over line {np.min(chord / line):.4f}"
    )


def scaling(X, skeleton, repeats):
    """Print the time of a pair on one thread and on two."""
    results = {}

    def run(n_jobs):
        results[n_jobs] = pose_distances(X, skeleton=skeleton, metric="geodesic", n_jobs=n_jobs)

    seconds = common.medians({n: partial(run, n) for n in (1, 2)}, repeats)
    np.testing.assert_array_equal(results[1], results[2])
    n_pairs = len(X) * (len(X) - 1) // 2
    each = f"{1e3 * seconds[1] / n_pairs:.2f} ms a pair on one thread, {1e3 * seconds[2] / n_pairs:.2f} on two"
    ratio = f"{seconds[1] / seconds[2]:.2f} times as fast"
    print(f"\ngeodesics among {len(X)} poses of one walk, {n_pairs} pairs: {each}, {ratio}")


def main():
    options = common.start(__doc__)
    size = QUICK if options.quick else FULL
    dataset = common.motions(options.folder)
    skeleton, rng = dataset.skeleton, np.random.default_rng(0)
    X, sequence = dataset.poses(frame_rate=12)
    print(f"{dataset}\n{skeleton}, poses at 12 Hz\n")
    walks = dataset.actions == "walk"
    others = walks & (dataset.subjects != "02")  # some poses of 02's walks are too far apart for ten chords
    race(X, pairs_of_one_walk(dataset, sequence, others, size.n_raced, rng), skeleton, size.repeats)
    n = size.n_ratios
    print(f"\nlength of the geodesic over that of the line, eq. 8 (the paper's lowest of 100: 0.94), {n} pairs")
    ratios(X, pairs_of_one_walk(dataset, sequence, others, n, rng), skeleton, "walks without subject 02's")
    ratios(X, pairs_of_one_walk(dataset, sequence, walks, n, rng), skeleton, "all walks")
    ratios(X, rng.choice(np.flatnonzero(walks[sequence]), (n, 2)), skeleton, "across all walks")
    ratios(X, rng.choice(len(X), (n, 2)), skeleton, "across all motions")
    one = np.flatnonzero(sequence == np.flatnonzero(walks)[-1])
    copies = np.repeat(X[one], size.copies, axis=0)
    scaling(copies + 1e-3 * rng.normal(size=copies.shape), skeleton, size.repeats)


if __name__ == "__main__":
    main()
