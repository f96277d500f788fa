"""Logarithms and exponentials: does exp(log) come back, is the logarithm as long as the distance, is it the gradient?

    python benchmarks/tangent.py [--cmu FOLDER OF CMU FILES --hdm05 FOLDER OF HDM05 FILES] [--quick]

200 random pairs of poses at 12 Hz (seed 0) of CMU's walks and of HDM05, each with Euler angles and with ball joints.

- "exp(log)": distance from exp(log(pose)) to the pose, by positions, in mm and relative to the geodesic distance;
- "length": length of the logarithm against ``pose_distances(metric="geodesic")``, relative;
- "gradient": the slope of ½ distance², by central differences along a random direction of the base's dofs, against
  −⟨log, J direction⟩; relative to the length of the logarithm times that of J direction.

Quantiles over the pairs, and ms for each pose in one thread. Without folders it runs on generated gait.
"""

import time
import warnings

import common
import numpy as np
from sklearn.exceptions import ConvergenceWarning

from skpose import pose_distances, position_jacobian
from skpose.datasets import load_cmu, load_hdm05, make_gait
from skpose.geodesics import exp_map, log_map

N_PAIRS, QUICK_PAIRS = 200, 5
GRADIENTS = 50  # pairs whose gradient is checked: two more geodesics each, and poses near to each other
RATE = 12  # Hz
STEP = 1e-3  # of central differences, m of the joints
SHARES = (0.5, 0.9, 0.95, 0.99, 1.0)


def quantiles(label, values):
    cells = "".join(f"{value:>10.1e}" for value in np.quantile(values, SHARES))
    print(f"  {label:34}{cells}")
    return values


def length(velocities, skeleton):
    return np.sqrt(np.square(velocities).sum(axis=-1) @ skeleton.weights)


def distance(base, pose, skeleton, metric):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # those of the logarithms are counted
        return pose_distances(base[None], pose[None], skeleton=skeleton, metric=metric)[0, 0]


def check(label, skeleton, X, n_pairs):
    """Print the quantiles of all errors; return those of exp(log), relative."""
    rng = np.random.default_rng(0)
    pairs = rng.choice(len(X), (n_pairs, 2))
    logarithms, found, unconverged, seconds = [], [], 0, np.zeros(2)
    for a, b in pairs:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", ConvergenceWarning)
            start = time.perf_counter()
            logarithm = log_map(X[a], X[[b]], skeleton)
            middle = time.perf_counter()
            found.append(exp_map(X[a], logarithm, skeleton)[0])
            seconds += middle - start, time.perf_counter() - middle
        unconverged += bool(caught)
        logarithms.append(logarithm[0])
    log_ms, exp_ms = 1e3 * seconds / n_pairs
    print(f"\n{label}: {n_pairs} pairs, {unconverged} with a warning; log {log_ms:.1f} ms, exp {exp_ms:.1f} ms")
    print(f"  {'quantile':34}" + "".join(f"{share:>10}" for share in SHARES))
    lengths = length(np.array(logarithms), skeleton)
    distances = np.array([distance(X[a], X[b], skeleton, "geodesic") for a, b in pairs])
    missed = np.array([distance(pose, X[b], skeleton, "position") for pose, (_, b) in zip(found, pairs, strict=True)])
    apart = distances > 0.0
    relative = quantiles("exp(log), relative", missed[apart] / distances[apart])
    quantiles("exp(log), mm", 1e3 * missed)
    quantiles("length, relative", np.abs(lengths[apart] / distances[apart] - 1.0))
    errors = []
    for i in np.flatnonzero(apart)[: min(GRADIENTS, n_pairs)]:
        a, b = pairs[i]
        direction = rng.normal(size=X.shape[1])
        moving = (position_jacobian(X[[a]], skeleton)[0] @ direction).reshape(-1, 3)
        direction /= length(moving, skeleton)
        moving /= length(moving, skeleton)
        near = [0.5 * distance(X[a] + h * direction, X[b], skeleton, "geodesic") ** 2 for h in (STEP, -STEP)]
        expected = -(logarithms[i] * moving * skeleton.weights[:, None]).sum()
        errors.append(((near[0] - near[1]) / (2.0 * STEP) - expected) / lengths[i])
    quantiles("gradient, relative", np.abs(errors))
    return relative


def main():
    options = common.parser_of_both(__doc__).parse_args()
    common.print_machine()
    sets = {}
    if options.cmu and not options.quick:
        dataset = load_cmu(options.cmu)
        sets["CMU walks"] = dataset[dataset.actions == "walk"]
    if options.hdm05 and not options.quick:
        sets["HDM05"] = load_hdm05(options.hdm05)
    n_pairs = N_PAIRS if sets else QUICK_PAIRS
    for label, dataset in (sets or {"generated gait": make_gait(2, 1, random_state=0)}).items():
        for kind, one in (("Euler angles", dataset), ("ball joints", dataset.to_rotvec())):
            X, _ = one.poses(frame_rate=RATE)
            relative = check(f"{label}, {kind}", one.skeleton, X, n_pairs)
            assert np.median(relative) < (1e-3 if sets else 1e-5), "exp(log) does not come back"


if __name__ == "__main__":
    main()
