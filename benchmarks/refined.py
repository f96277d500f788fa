"""How long do geodesics take, also those whose paths have to be refined? Here and in another checkout, in turns.

    python benchmarks/refined.py [--cmu FOLDER] [--hdm05 FOLDER] [--against CHECKOUT] [--quick]

Random pairs of poses of all motions, Euler angles and ball joints, one thread, processor time. Each checkout has a
process of its own; times are medians for each pair. Lengths of both are compared.
"""

import os
import pickle
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import common
import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose import geodesic

N_PAIRS, REPEATS = 100, 3
QUICK = 4, 1
SAME = 1e-4  # relative difference of two lengths of one geodesic
FEWEST_SAME = 0.5  # share of the pairs
CHECKOUT = Path(__file__).resolve().parent.parent


def cases(options, n_pairs):
    """Yield name, skeleton and pairs of poses (2, n_pairs, n_dofs)."""
    for name, dataset in common.datasets(options).items():
        for rotations, motions in (("Euler angles", dataset), ("ball joints", dataset.to_rotvec())):
            poses, _ = motions.poses(frame_rate=12)
            rows = np.random.default_rng(0).choice(len(poses), (2, n_pairs))
            yield f"{name}, {rotations}", motions.skeleton, poses[rows]


def measure(data):
    """Find all geodesics; send seconds of the processor, lengths, and whether each is refined and has converged."""
    with open(data, "rb") as file:
        skeleton, (starts, ends) = pickle.load(file)
    warnings.simplefilter("ignore", ConvergenceWarning)  # their number is printed
    geodesic(starts[0], ends[0], skeleton)  # compiles
    rows = []
    for start, end in zip(starts, ends, strict=True):
        began = time.process_time()
        found = geodesic(start, end, skeleton)
        rows.append((time.process_time() - began, found.length, len(found.path) > 11, found.converged, found.n_iter))
    pickle.dump(np.array(rows).T, sys.stdout.buffer)


def run(checkout, data):
    """Measure with the skpose of a checkout."""
    environment = os.environ | {"PYTHONPATH": str(checkout)}
    if checkout != CHECKOUT:
        environment["NUMBA_CACHE_DIR"] = str(Path(tempfile.gettempdir()) / "refined_cache")
    command = [sys.executable, __file__, "--measure", data]
    return pickle.loads(subprocess.run(command, env=environment, stdout=subprocess.PIPE, check=True).stdout)


def compare(name, skeleton, pairs, checkouts, repeats):
    """Print a line for each checkout, and one for the difference of lengths."""
    with tempfile.NamedTemporaryFile() as file:
        pickle.dump((skeleton, pairs), file)
        file.flush()
        runs = [[run(checkout, file.name) for checkout in checkouts] for _ in range(repeats)]
    found = [runs[0][i] for i in range(len(checkouts))]
    for i, (checkout, (_, _, refined, converged, n_iter)) in enumerate(zip(checkouts, found, strict=True)):
        ms, refined = 1e3 * np.median([one[i][0] for one in runs], axis=0), refined > 0
        line = f"{name:<24}{'here' if checkout == CHECKOUT else 'there':<7}"
        for kind, chosen in (("plain", ~refined), ("refined", refined)):
            if chosen.any():
                line += (
                    f"{chosen.sum():>4} {kind}: median {np.median(ms[chosen]):6.2f}, mean {ms[chosen].mean():6.2f}, "
                )
                line += f"largest {ms[chosen].max():6.1f} ms, {n_iter[chosen].mean():5.1f} iterations;"
        print(f"{line} {(converged == 0).sum()} unconverged", flush=True)
    for _, lengths, *_ in found[1:]:
        gap = found[0][1] / lengths - 1.0
        assert (np.abs(gap) < SAME).mean() >= FEWEST_SAME, "the lengths differ"
        print(
            f"{'':<24}length here over there - 1: median of sizes {np.median(np.abs(gap)):.0e}, least {gap.min():.0e}, "
            f"largest {gap.max():.0e}, mean {gap.mean():.0e}; {(np.abs(gap) > SAME).sum()} differ by more than {SAME:g}"
        )


def main():
    if sys.argv[1:2] == ["--measure"]:
        measure(sys.argv[2])
        return
    arguments = common.parser_of_both(__doc__)
    arguments.add_argument("--against", type=Path, help="another checkout of skpose")
    options = arguments.parse_args()
    common.print_machine()
    n_pairs, repeats = QUICK if options.quick else (N_PAIRS, REPEATS)
    checkouts = [CHECKOUT] + ([options.against.resolve()] if options.against else [])
    for case in cases(options, n_pairs):
        compare(*case, checkouts, repeats)


if __name__ == "__main__":
    main()
