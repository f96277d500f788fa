"""How fast and how good are geodesics? Against scipy's minimisers on the same energy, in one run; and eq. 8.

    python benchmarks/geodesic.py [FOLDER OF CMU FILES]

scipy gets the energy and its closed-form gradient from the same compiled kinematics as ours, on one thread. Each
contestant starts at the straight line in angle space; times are medians over repeats of the mean over 20 pairs.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: one thread for everybody

import statistics
import sys
import time
import warnings

import numpy as np
from numba import njit
from scipy.optimize import minimize
from sklearn.exceptions import ConvergenceWarning

from skpose import geodesic, pose_distances
from skpose._compiled import path_energy
from skpose._compiled.forward import workspace_rows
from skpose.datasets import load_cmu, make_gait
from skpose.kinematics._tree import tree_of

REPEATS = 3
N_STEPS = 10


@njit(nogil=True)
def energy_and_gradient(tree, path, scratch, moments, gradient):
    """Eq. 6 and its derivative in all poses."""
    half = path_energy.evaluate(tree, path, scratch)
    gradient[:] = 0.0
    for i in range(1, len(path.P) - 1):
        path_energy.sum_moments(tree, path.P[i - 1], path.P[i], path.P[i + 1], moments)
        path_energy.add_gradient(tree, path.screws[i], moments, 0.0, gradient[i : i + 2])
    return 2.0 * half


class Energy:
    """Eq. 6 from start to end as scipy sees it: of a flat array of the inner poses."""

    def __init__(self, start, end, skeleton):
        self.tree = tree_of(skeleton)
        gap = (end - start + np.pi) % (2 * np.pi) - np.pi
        line = start + np.linspace(0, 1, N_STEPS + 1)[:, None] * gap
        self.path = path_energy.path_of(self.tree, line[:, self.tree.column] * self.tree.sign, 1)
        self.scratch, self.moments = np.empty(workspace_rows(self.tree)), np.empty((len(self.tree.frame_parent), 12))
        self.gradient = np.empty(line.shape)
        self.start = self.path.poses[1:-1].ravel().copy()

    def __call__(self, x):
        self.path.poses[1:-1] = x.reshape(N_STEPS - 1, -1)
        value = energy_and_gradient(self.tree, self.path, self.scratch, self.moments, self.gradient)
        return value, 2.0 * self.gradient[1:-1].ravel()

    def hessian_product(self, x, direction):
        step = 1e-6 / max(np.linalg.norm(direction), 1e-300)
        return (self(x + step * direction)[1] - self(x - step * direction)[1]) / (2 * step)


def by_scipy(method, **options):
    def solve(start, end, skeleton):
        energy = Energy(start, end, skeleton)
        product = energy.hessian_product if method == "trust-krylov" else None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that a minimiser stops early is in the table
            found = minimize(energy, energy.start, jac=True, hessp=product, method=method, options=options)
        return energy(found.x)[0], np.linalg.norm(energy(found.x)[1])

    return solve


def ours(start, end, skeleton):
    way = geodesic(start, end, skeleton, n_steps=N_STEPS)
    return way.energy, way.gradient_norm


CONTESTANTS = {
    "skpose": ours,
    "scipy L-BFGS-B, defaults": by_scipy("L-BFGS-B"),
    "scipy L-BFGS-B, gtol = 1e-5": by_scipy("L-BFGS-B", gtol=1e-5, ftol=0, maxiter=20_000, maxfun=50_000),
    "scipy trust-krylov, defaults": by_scipy("trust-krylov"),
}


def pairs_of_one_walk(dataset, sequence, chosen, n, rng):
    """Random pairs of poses, both of one random sequence out of the chosen ones."""
    sequences = rng.choice(np.flatnonzero(chosen), n)
    return np.array([rng.choice(np.flatnonzero(sequence == i), 2, replace=False) for i in sequences])


def race(X, pairs, skeleton):
    print(f"{len(pairs)} pairs of walking poses, one thread, ten steps\n")
    print(f"{'':<30}{'ms':>8}{'x ours':>8}{'gradient, largest':>19}{'energy over ours - 1, largest and least':>42}")
    results, seconds = {}, {name: [] for name in CONTESTANTS}
    for solve in CONTESTANTS.values():
        solve(X[pairs[0, 0]], X[pairs[0, 1]], skeleton)
    for _ in range(REPEATS):
        for name, solve in CONTESTANTS.items():
            begin = time.perf_counter()
            results[name] = np.array([solve(X[i], X[j], skeleton) for i, j in pairs])
            seconds[name].append((time.perf_counter() - begin) / len(pairs))
    median = {name: statistics.median(values) for name, values in seconds.items()}
    for name, found in results.items():
        above = found[:, 0] / results["skpose"][:, 0] - 1
        print(
            f"{name:<30}{1e3 * median[name]:>8.2f}{median[name] / median['skpose']:>8.1f}{found[:, 1].max():>19.1e}"
            f"{above.max():>21.1e}{above.min():>21.1e}"
        )


def ratios(X, pairs, skeleton, title):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ConvergenceWarning)
        ways = [geodesic(X[i], X[j], skeleton, n_steps=N_STEPS) for i, j in pairs]
    chord, line = (
        np.array([pose_distances(X[[i]], X[[j]], skeleton=skeleton, metric=m)[0, 0] for i, j in pairs])
        for m in ("position", "spatial")
    )
    length, along = np.array([way.length for way in ways]), np.array([way.curve_length for way in ways])
    r = length / line
    print(
        f"{title}: lowest {r.min():.4f}, median {np.median(r):.4f}, highest {r.max():.4f}; {np.sum(r < 0.94)} below "
        f"0.94, of which {np.sum((r < 0.94) & (along / line < 0.94))} also as curves on the fine grid\n"
        f"    gradient {max(way.gradient_norm for way in ways):.1e} at most, curve over chords - 1 "
        f"{np.max(along / length - 1):.2%} at most, {sum(len(way.path) > N_STEPS + 1 for way in ways)} refined, "
        f"{len(caught)} not converged; lowest chord over line {np.min(chord / line):.4f}"
    )


def scaling(X, skeleton):
    seconds = {}
    for n_jobs in (1, 2, 1, 2, 1, 2):
        begin = time.perf_counter()
        pose_distances(X, skeleton=skeleton, metric="geodesic", n_jobs=n_jobs)
        seconds.setdefault(n_jobs, []).append(time.perf_counter() - begin)
    one, two = (statistics.median(seconds[n]) for n in (1, 2))
    n_pairs = len(X) * (len(X) - 1) // 2
    each = f"{1e3 * one / n_pairs:.2f} ms a pair on one thread, {1e3 * two / n_pairs:.2f} on two"
    print(f"\ngeodesics among {len(X)} poses of one walk, {n_pairs} pairs: {each}, {one / two:.2f} times as fast")


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else None
    dataset = load_cmu(folder) if folder else make_gait(random_state=0)
    skeleton, rng = dataset.skeleton, np.random.default_rng(0)
    X, sequence = dataset.poses(frame_rate=12)
    print(f"{dataset}\n{skeleton}, poses at 12 Hz\n")
    walks = dataset.actions == "walk"
    quiet = walks & (dataset.subjects != "02")  # whose poses of one walk are too far apart for ten chords, at times
    race(X, pairs_of_one_walk(dataset, sequence, quiet, 20, rng), skeleton)
    print("\nlength of the geodesic over that of the line, eq. 8 (the paper's lowest of 100: 0.94), 100 pairs")
    ratios(X, pairs_of_one_walk(dataset, sequence, quiet, 100, rng), skeleton, "walks without subject 02's")
    ratios(X, pairs_of_one_walk(dataset, sequence, walks, 100, rng), skeleton, "all walks")
    ratios(X, rng.choice(np.flatnonzero(walks[sequence]), (100, 2)), skeleton, "across all walks")
    ratios(X, rng.choice(len(X), (100, 2)), skeleton, "across all motions")
    one = np.flatnonzero(sequence == np.flatnonzero(walks)[-1])
    scaling(np.repeat(X[one], 4, axis=0) + 1e-3 * rng.normal(size=(4 * len(one), X.shape[1])), skeleton)


if __name__ == "__main__":
    main()
