"""How long does the first call take, which compiles, how long the first one of later processes, and all others?

    python benchmarks/first_calls.py [--against CHECKOUT] [--quick]

Each call is measured in two processes: one that starts with an empty cache of numba's, and makes the call twice, and
one that finds the cache filled. With --against another checkout of skpose takes turns, and must give the same results.
Seconds of the processor: compiling takes one thread, and other programs do not count.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import common

PREPARE = """
import json, time
import numpy as np
import skpose
from sklearn.neighbors import KNeighborsClassifier
from skpose.datasets import make_gait
motion = make_gait(n_subjects=1, n_sequences=1, duration=1.0, frame_rate=24, rotations="file", random_state=0)[0]
X, skeleton = np.asarray(motion.angles), motion.skeleton
def timed(call):
    start = time.process_time()
    value = call()
    return time.process_time() - start, float(value)
"""
CALLS = {
    "pose_distances": "skpose.pose_distances(X, skeleton=skeleton)[0, 9]",
    "pose_metric": "skpose.pose_metric(skeleton)(X[0], X[9])",
    "KNeighborsClassifier, pose_metric": (
        "KNeighborsClassifier(1, metric=skpose.pose_metric(skeleton), algorithm='brute')"
        ".fit(X, np.arange(len(X)) % 2).predict(X[:3]).sum()"
    ),
    "PoseKNeighborsTransformer": "skpose.PoseKNeighborsTransformer(skeleton=skeleton).fit_transform(X).sum()",
    "geodesic": "skpose.geodesic(X[0], X[9], skeleton).length",
    'pose_distances, "geodesic"': 'skpose.pose_distances(X[:10], skeleton=skeleton, metric="geodesic")[0, 9]',
    "frechet_mean": "skpose.geodesics.frechet_mean(X[:9], skeleton).variance",
    'frechet_mean, "geodesic"': 'skpose.geodesics.frechet_mean(X[:9], skeleton, metric="geodesic").variance',
    "log_map": "np.abs(skpose.geodesics.log_map(X[0], X[9:10], skeleton)).sum()",
    "inverse_kinematics": (
        "np.abs(skpose.inverse_kinematics(skpose.forward_kinematics(X[:2], skeleton), skeleton).poses).sum()"
    ),
    "mean_motion": "np.abs(skpose.motions.mean_motion([X[:12], X[12:]], skeleton=skeleton).poses).sum()",
}
QUICK = "pose_distances"
AGREE = 1e-6  # relative difference of the results of two checkouts


def run(call, cache, checkout):
    """Make a call twice in a new process: seconds and value of each."""
    program = f"{PREPARE}print(json.dumps([timed(lambda: {call}) for _ in range(2)]))"
    environment = os.environ | {"NUMBA_CACHE_DIR": cache, "PYTHONPATH": str(checkout)}
    output = subprocess.run(
        [sys.executable, "-c", program], cwd=cache, env=environment, stdout=subprocess.PIPE, check=True
    )
    return json.loads(output.stdout.splitlines()[-1])


def measure(call, checkout):
    """Return the seconds of the first call, of the first one with a filled cache, of a second one; and the value."""
    with tempfile.TemporaryDirectory() as cache:
        (first, second), (cached, _) = run(call, cache, checkout), run(call, cache, checkout)
    assert first[1] == second[1] == cached[1], f"{call}: one call, several results"
    return first[0], cached[0], second[0], first[1]


def main():
    arguments = common.parser(__doc__, folder=False)
    arguments.add_argument("--against", type=Path, help="another checkout of skpose")
    options = arguments.parse_args()
    common.print_machine()
    checkouts = [Path(__file__).resolve().parent.parent] + ([options.against] if options.against else [])
    header = f"{'seconds of the processor':<34} {'first':>7} {'cached':>7} {'second':>8}"
    print(header + "   first and cached there" * len(checkouts[1:]))
    for name, call in CALLS.items():
        if options.quick and name != QUICK:
            continue
        (first, cached, second, value), *others = [measure(call, checkout) for checkout in checkouts]
        line = f"{name:<34} {first:7.1f} {cached:7.2f} {second:8.4f}"
        for there in others:
            assert abs(value - there[-1]) <= AGREE * abs(value), f"{name}: {value} here and {there[-1]} there"
            line += f"   {there[0]:5.1f} {there[1]:5.2f}: {there[0] / first:.1f} × less"
        print(line, flush=True)


if __name__ == "__main__":
    main()
