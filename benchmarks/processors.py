"""How fast is code for other processors than this one, and are results the same? Distances and geodesics, in turns.

    python benchmarks/processors.py [FOLDER OF CMU FILES] [--quick]

numba compiles for the processor that it runs on. `NUMBA_CPU_NAME` and `NUMBA_CPU_FEATURES` name another one, as for
images of containers. Each runs in a process of its own; one thread, seconds of the processor.
"""

import json
import os
import signal
import subprocess
import sys
import time
from statistics import median

import common
import numpy as np

from skpose import geodesic, pose_distances

# x86-64-v3 has AVX2 and FMA, as nearly all processors of PCs and clouds since 2015; generic has SSE2 alone.
PROCESSORS = {"this": {}} | {
    name: {"NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""} for name in ("x86-64-v4", "x86-64-v3", "generic")
}
METRICS = "angle", "position", "rotation", "spatial"
N_POSES, N_GEODESICS, REPEATS = 700, 20, 5
QUICK = 20, 2, 1
SAME = 1e-9  # relative difference of results


def measure(options):
    """Print seconds and a sum of the results of each call, as JSON."""
    n_poses, n_geodesics, repeats = QUICK if options.quick else (N_POSES, N_GEODESICS, REPEATS)
    dataset = common.motions(options.folder, 3, 3)
    rng, (poses, _) = np.random.default_rng(0), dataset.poses(frame_rate=12.0)
    X, skeleton = rng.choice(poses, n_poses, replace=False), dataset.skeleton
    calls = {
        metric: lambda metric=metric: pose_distances(X, skeleton=skeleton, metric=metric).sum() for metric in METRICS
    }
    pairs = list(zip(X[:n_geodesics], X[n_geodesics:], strict=False))
    calls["geodesic"] = lambda: sum(geodesic(*pair, skeleton).length for pair in pairs)
    values = {name: float(call()) for name, call in calls.items()}
    seconds = common.medians(calls, repeats, time.process_time)
    print(json.dumps({name: (seconds[name], values[name]) for name in calls}))


def run(options, environment):
    arguments = [options.folder] * bool(options.folder) + ["--quick"] * options.quick
    output = subprocess.run(
        [sys.executable, __file__, "--measure", *arguments],
        env=os.environ | environment,
        capture_output=True,
        text=True,
    )
    if output.returncode == -signal.SIGILL:
        return None
    assert output.returncode == 0, output.stderr
    return json.loads(output.stdout.splitlines()[-1])


def main():
    arguments = common.parser(__doc__)
    arguments.add_argument("--measure", action="store_true", help="measure in this process")
    options = arguments.parse_args()
    if options.measure:
        measure(options)
        return
    common.print_machine()
    names = ("this", "generic") if options.quick else tuple(PROCESSORS)
    found = {name: [] for name in names}
    for _ in range(1 if options.quick else 3):
        for name in names:
            found[name].append(run(options, PROCESSORS[name]))
    calls = list(found["this"][0])
    print(f"{'ms':<12}" + "".join(f"{call:>10}" for call in calls) + "   largest relative difference of a sum")
    for name, runs in found.items():
        if None in runs:
            print(f"{name:<12} is not for this machine")
            continue
        ms = [1e3 * median(one[call][0] for one in runs) for call in calls]
        apart = max(abs(one[call][1] / found["this"][0][call][1] - 1) for one in runs for call in calls)
        assert apart <= SAME, f"{name}: {apart}"
        print(f"{name:<12}" + "".join(f"{value:10.2f}" for value in ms) + f"   {apart:.1e}")


if __name__ == "__main__":
    main()
