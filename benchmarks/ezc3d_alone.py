"""Outcomes of ezc3d alone, and of load_c3d, on damaged C3D files: why every count is checked before ezc3d reads a file.

    pip install "skpose[bench]"
    python benchmarks/ezc3d_alone.py [--quick]

Each file is read in a process of its own, with 10 s and 4 GB: the same 1,500 files by both, of which a quarter are cut
short and the others have one to three places with other bytes (tests/damaged.py). POSIX only.
"""

import collections
import os
import resource
import signal
import sys
import tempfile
from pathlib import Path

import common
import ezc3d
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
import damaged

FULL, QUICK = 1500, 20  # files
MOST_SECONDS, MOST_BYTES = 10, 4_000_000_000
READ, REFUSED, MEMORY, OTHER = range(4)


def outcome(read):
    """Return what becomes of a process that reads a file."""
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.alarm(MOST_SECONDS)
        try:
            os._exit(READ if read() != "refused" else REFUSED)
        except Exception as error:
            os._exit(MEMORY if isinstance(error, MemoryError) or "alloc" in str(error) else OTHER)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return "too slow" if os.WTERMSIG(status) == signal.SIGALRM else "crashed"
    return {READ: "read", REFUSED: "refused", MEMORY: "out of memory", OTHER: "refused"}[os.WEXITSTATUS(status)]


def main():
    options = common.parser(__doc__, folder=False).parse_args()
    common.print_machine()
    print(f"ezc3d {ezc3d.__version__}")
    rng, counts = np.random.default_rng(0), collections.Counter()
    whole = [data.rstrip(b"\0") for data in damaged.FILES["C3D"]]  # without the zeros behind the last frame
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "damaged.c3d")
        for _ in range(QUICK if options.quick else FULL):
            data = damaged.damaged("C3D", rng)
            cut = any(one.startswith(data) and len(data) < len(one) for one in whole)
            path.write_bytes(data)
            kind = "cut short" if cut else "changed"
            counts["ezc3d", kind, outcome(lambda: bool(ezc3d.c3d(str(path)).data))] += 1
            counts["load_c3d", kind, outcome(lambda data=data: damaged.outcome("C3D", data))] += 1
    for (reader, kind, found), count in sorted(counts.items()):
        print(f"{reader:<10}{kind:<11}{found:<14}{count:>6,}")


if __name__ == "__main__":
    main()
