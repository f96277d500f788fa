"""The command line: ``skpose compare``."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import skpose


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return the exit status."""
    parser = argparse.ArgumentParser(prog="skpose", description=skpose.__doc__.splitlines()[0])
    parser.add_argument("--version", action="version", version=f"skpose {skpose.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    compare = commands.add_parser(
        "compare",
        help="compare the metrics at telling walking from running",
        description="Compare the metrics at telling walking from running, by the nearest neighbour among the poses of "
        "other people and of other sequences.",
    )
    compare.add_argument(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        help="CMU files with an index.csv, see skpose.datasets.load_cmu; without it, generated motions",
    )
    compare.add_argument(
        "--jobs", type=int, default=-1, metavar="N", help="threads; -1, the default, is all processors"
    )
    options = parser.parse_args(arguments)
    try:
        _compare(options.folder, options.jobs)
    except (OSError, ValueError) as error:
        print(f"skpose: {error}", file=sys.stderr)
        return 1
    return 0


def _compare(folder: Path | None, n_jobs: int) -> None:
    from skpose.compare import FRAME_RATE, PAPER_ACCURACY, PAPER_FIRST_COMPONENT, compare, walks_and_runs
    from skpose.datasets import load_cmu, make_gait

    if folder is None:
        dataset, source = make_gait(random_state=0), "generated gait, skpose.datasets.make_gait(random_state=0)"
    else:
        dataset, source = load_cmu(folder), str(folder)
    dataset = walks_and_runs(dataset)
    n_poses = len(dataset.poses(FRAME_RATE)[0])
    print(f"Walking or running? {source}")
    counts = ", ".join(f"{(dataset.actions == name).sum()} {name}s" for name in ("walk", "run"))
    print(f"{counts}, {len(set(dataset.subjects))} subjects, {n_poses} poses at {FRAME_RATE:g} Hz")
    print(f"\n{'':<10}{'nearest neighbour right':^36}{'variance in first':^22}")
    print(f"{'':<10}{'leave one':>11}{'leave one':>11}{'paper,':>12}{'MDS component,':>17}")
    print(f"{'metric':<10}{'subject out':>12}{'seq. out':>10}{'seq. out':>12}{'median':>11}{'paper':>8}{'time':>10}")
    for row in compare(dataset, n_jobs=n_jobs):
        paper, component = (
            f"{values[row.metric]:.0%}" if row.metric in values else "-"
            for values in (PAPER_ACCURACY, PAPER_FIRST_COMPONENT)
        )
        print(
            f"{row.metric:<10}{row.leave_subject_out:>12.1%}{row.leave_sequence_out:>10.1%}{paper:>12}"
            f"{row.first_component:>11.1%}{component:>8}{row.seconds:>8.2f} s",
            flush=True,
        )
    print("\nPaper: Hauberg & Pedersen 2012, other sequences of the CMU data. Sec. 3.3: ten walks and ten runs, 1,096")
    print(
        "poses; fig. 4 (c): modes over 673 sequences. Times are for distances, validations and scaling, not compiling."
    )


if __name__ == "__main__":
    sys.exit(main())
