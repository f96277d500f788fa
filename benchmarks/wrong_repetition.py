"""Repetitions.to_pandas: how unusual is the most unusual row where nothing is wrong, and where one repetition is?

    python benchmarks/wrong_repetition.py [--quick]

Generated squats at 50 Hz, 100 recordings of each number of repetitions, once as they are and once with one of them
wrong: a knee is in by 15° from 40 to 60 % of the cycle, the left and the right one in turn. "natural" variation is 12 %
in duration, 4 % in depth, 0.9° in the posture of each repetition and 0.6° of sway in each angle; "large" is twice that.

Columns: the median and the 95th percentile of the largest number of the column "unusual" where nothing is wrong; the
shares of these recordings in which it is above 4, and above 6. Then, of those with a wrong repetition, the share in
which the row with the largest number has that repetition, a joint of that leg, and a time from 40 to 60 % of its cycle,
give or take 5 %; and the share in which that number is above 4. Recordings in which `segment_repetitions` finds another
number of repetitions are counted in the last column, and left out.
"""

import sys
from pathlib import Path

import common
import numpy as np

from skpose.motions import segment_repetitions

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "motions"))
from squats import squats

LEG = "thigh", "shank", "foot", "toes"


def most_unusual(motion, n):
    """Return the row with the largest number, None where other repetitions are found."""
    found = segment_repetitions(motion, n_surrogates=19, random_state=0)
    if len(found) != n:
        return None
    table = found.to_pandas()
    return table.loc[table["unusual"].idxmax()]


def row_of(n, spread, seeds):
    """Measure recordings of n repetitions."""
    null, named, sizes, missed = [], [], [], 0
    for seed in range(seeds):
        side, wrong = ("left", "right")[seed % 2], seed % n
        right = most_unusual(squats(seed, n=n, spread=spread)[0], n)
        motion, cycles = squats(seed, wrong, side, n=n, spread=spread)
        row = most_unusual(motion, n)
        if row is None or right is None:
            missed += 1
            continue
        null.append(right.unusual)
        first, last = cycles[wrong]
        is_there = 0.35 < (row["time [s]"] - first) / (last - first) < 0.65
        is_leg = row.joint in {f"{side}_{name}" for name in LEG}
        named.append(row.repetition == wrong and is_leg and is_there)
        sizes.append(row.unusual)
    null, sizes = np.array(null), np.array(sizes)
    return (
        f"{np.median(null):9.2f} {np.quantile(null, 0.95):9.2f} {np.mean(null > 4):9.1%} {np.mean(null > 6):9.1%}"
        f" {np.mean(named):9.1%} {np.mean(sizes > 4):9.1%} {missed:9}"
    )


def main():
    options = common.parser(__doc__, folder=False).parse_args()
    common.print_machine()
    columns = "median", "95 %", "> 4", "> 6", "named", "> 4", "missed"
    print(f"{'n':>4} {'variation':>10} " + " ".join(f"{name:>9}" for name in columns))
    for n in (10,) if options.quick else (4, 5, 10):
        for name, spread in (("natural", 1.0), ("large", 2.0)):
            print(f"{n:>4} {name:>10} {row_of(n, spread, 4 if options.quick else 100)}", flush=True)


if __name__ == "__main__":
    main()
