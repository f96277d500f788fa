"""Do readers survive any content of a file? 20,000 damaged files of each format of motions and of keypoints.

    pip install "skpose[bench]"
    python benchmarks/fuzz.py [HOW MANY] [--quick]

The mutations are those of tests/mutations.py, drawn by hypothesis from a fixed seed, and of tests/damaged.py. A case
fails if a reader raises anything but MocapFormatError, warns of anything that is not about the file, takes more than
ten seconds of the processor, or asks for more than 2 GB beyond what the process has: the operating system refuses it
then, and that is an error. POSIX only.
"""

import collections
import resource
import signal
import sys
import time
from pathlib import Path

import common
import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import damaged
import mutations

FULL, QUICK = 20_000, 100  # files of each format
MOST_SECONDS, MOST_BYTES = 10, 2_000_000_000


def give_up(*_):
    raise TimeoutError(f"a reader took more than {MOST_SECONDS} s of the processor")


def every_other_kind(n_cases, outcomes):
    """Count the outcomes of so many keypoints and archives of each kind; return the slowest: seconds, kind, bytes."""
    slowest = (0.0, "", 0)
    for kind in damaged.FILES:
        rng = np.random.default_rng(0)
        for _ in range(n_cases):
            data = damaged.damaged(kind, rng)
            signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
            start = time.process_time()
            outcomes[kind, damaged.outcome(kind, data)] += 1
            slowest = max(slowest, (time.process_time() - start, kind, len(data)))
            signal.setitimer(signal.ITIMER_PROF, 0)
    return slowest


def main():
    parser = common.parser(__doc__, folder=False)
    parser.add_argument("n_cases", nargs="?", type=int, help=f"number of files of each format; default: {FULL:,}")
    options = parser.parse_args()
    common.print_machine()
    n_cases = options.n_cases or (QUICK if options.quick else FULL)
    outcomes, slowest = collections.Counter(), (0.0, "", 0)
    usual = {"on_nan": "raise", "trust": "header", "stretch": "raise", "missing": "raise", "root": None}
    mutations.outcome("BVH", mutations.BVH, usual)  # imports what a reader imports when it is called
    damaged.outcome("C3D", damaged.FILES["C3D"][0])
    limit = int(common.memory("VmSize") * 1e6) + MOST_BYTES
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    signal.signal(signal.SIGPROF, give_up)

    def every_case_of(kind):
        @seed(0)
        @settings(
            max_examples=n_cases,
            deadline=None,
            database=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @given(mutations.files([kind]), mutations.options)
        def every_case(file, options):
            nonlocal slowest
            data = file[1]
            signal.setitimer(signal.ITIMER_PROF, MOST_SECONDS)
            start = time.process_time()
            outcomes[kind, mutations.outcome(kind, data, options)] += 1
            taken = time.process_time() - start
            signal.setitimer(signal.ITIMER_PROF, 0)
            slowest = max(slowest, (taken, kind, len(data)))

        every_case()

    start = time.perf_counter()
    for kind in mutations.VALID:
        every_case_of(kind)
    slowest = max(slowest, every_other_kind(n_cases, outcomes))
    print(f"{sum(outcomes.values()):,} files in {time.perf_counter() - start:.0f} s, none with another outcome\n")
    for (kind, outcome), count in sorted(outcomes.items()):
        print(f"{kind}  {outcome:<8}{count:>8,}")
    print(f"\nslowest: {slowest[0]:.2f} s, {slowest[1]} of {slowest[2]:,} bytes")
    print(
        f"memory at most: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f} MB, the interpreter's included"
    )


if __name__ == "__main__":
    main()
