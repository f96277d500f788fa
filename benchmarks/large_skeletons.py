"""How long do geodesics take on skeletons with hands, feet and face, and what does it cost to find them more closely?

    python benchmarks/large_skeletons.py [FOLDER OF CMU FILES] [--quick]

Chains of three joints with three Euler angles each, 3 cm long, stand at the tips of the skeleton: 11 make some 155 dofs
of 56, and 27 some 299. Every second chain keeps still; the others curl by up to 0.8 rad a joint. The angles of
the other joints are real, so that the same pairs are measured on each skeleton. Of each pair the geodesic is found with
the default tol, and with a millionth of it; the latter's length is the reference. Random pairs, one thread.
"""

import time
import warnings
from typing import NamedTuple

import common
import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose import Bone, Skeleton, geodesic

CHAINS = 0, 11, 27
LENGTH, CURL, SPREAD = 0.03, 0.8, 0.08  # m; rad; rad
LOOSE, TIGHT = 1e-6, 1e-12  # the default; the reference
REPEATS = 5


class Race(NamedTuple):
    """Geodesics of all pairs by one tol."""

    seconds: np.ndarray
    lengths: np.ndarray
    n_iter: np.ndarray
    refined: np.ndarray
    converged: np.ndarray


def with_chains(skeleton, X, n_chains):
    """Return the skeleton with chains at its tips, and the poses with their angles."""
    rng = np.random.default_rng(0)
    tips = [name for i, name in enumerate(skeleton.joint_names) if i not in skeleton.parents]
    bones, angles = list(skeleton.bones), dict(zip(skeleton.dof_names, X.T, strict=True))
    for chain in range(n_chains):
        parent, direction = tips[chain % len(tips)], rng.normal(size=3)
        for joint in range(3):
            bone = Bone(f"chain{chain}_{joint}", parent, LENGTH * direction / np.linalg.norm(direction), "XYZ")
            amount = (CURL, SPREAD, SPREAD) if chain % 2 else (0.0, 0.0, 0.0)
            angles |= zip(bone.dof_names, [a * rng.uniform(size=len(X)) for a in amount], strict=True)
            bones.append(bone)
            parent = bone.name
    larger = Skeleton(bones)
    return larger, np.stack([angles[name] for name in larger.dof_names], axis=1)


def race(skeleton, X, pairs, tol):
    """Find all geodesics."""
    rows = []
    for i, j in pairs:
        start = time.process_time()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # their number is printed
            found = geodesic(X[i], X[j], skeleton, tol=tol)
        rows.append((time.process_time() - start, found.length, found.n_iter, len(found.path) > 11, found.converged))
    return Race(*map(np.array, zip(*rows, strict=True)))


def main():
    options = common.start(__doc__)
    n_pairs, repeats = (3, 1) if options.quick else (12, REPEATS)
    dataset = common.motions(options.folder)
    X, _ = dataset.poses(frame_rate=12)
    pairs = np.random.default_rng(0).choice(len(X), (n_pairs, 2))
    cases = [with_chains(dataset.skeleton, X, n) for n in (CHAINS[:2] if options.quick else CHAINS)]
    for skeleton, Y in cases:
        race(skeleton, Y, pairs[:1], LOOSE)  # compiles, and brings the skeleton into the cache
    loose = [[race(*case, pairs, LOOSE) for case in cases] for _ in range(repeats)]
    print(f"{n_pairs} random pairs of poses, times in ms\n")
    print(
        f"{'dofs':>4}{'tol':>8}{'median':>9}{'largest':>9}{'iterations':>12}{'refined':>9}{'unconverged':>13}", end=""
    )
    print("   length over the reference - 1: median, largest, least")
    medians = []
    for i, (skeleton, Y) in enumerate(cases):
        seconds = np.median([turn[i].seconds for turn in loose], axis=0)
        found = {LOOSE: loose[0][i]._replace(seconds=seconds), TIGHT: race(skeleton, Y, pairs, TIGHT)}
        medians.append(np.median(seconds))
        for tol, one in found.items():
            over = one.lengths / found[TIGHT].lengths - 1.0
            assert np.median(np.abs(over)) < 1e-4, "the lengths differ"
            print(
                f"{skeleton.n_dofs:>4}{tol:>8.0e}{1e3 * np.median(one.seconds):>9.1f}{1e3 * one.seconds.max():>9.0f}"
                f"{np.median(one.n_iter):>12.0f}{one.refined.sum():>9}{(~one.converged).sum():>13}"
                f"{np.median(over):>12.0e}{over.max():>9.0e}{over.min():>9.0e}"
            )
    for (skeleton, _), median in zip(cases[1:], medians[1:], strict=True):
        print(f"{skeleton.n_dofs} dofs take {median / medians[0]:.1f} times as long as {cases[0][0].n_dofs}")


if __name__ == "__main__":
    main()
