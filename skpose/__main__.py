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
    from skpose.compare import FRAME_RATE, PAPER, compare, walks_and_runs
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
    print("Share of poses whose nearest neighbour is of the right class:\n")
    print(f"{'metric':<10}{'leave one':>12}{'leave one':>14}{'paper, leave':>16}{'time':>10}")
    print(f"{'':<10}{'subject out':>12}{'sequence out':>14}{'sequence out*':>16}{'':>10}")
    for row in compare(dataset, n_jobs=n_jobs):
        paper = f"{PAPER[row.metric]:.0%}" if row.metric in PAPER else "-"
        print(
            f"{row.metric:<10}{row.leave_subject_out:>12.1%}{row.leave_sequence_out:>14.1%}{paper:>16}"
            f"{row.seconds:>8.2f} s",
            flush=True,
        )
    print(
        "\n* Hauberg & Pedersen 2012, sec. 3.3: ten walks and ten runs, 1,096 poses, other sequences of the CMU data."
    )
    print("Times are for the matrix of distances and both validations; compilation comes before, once per machine.")


if __name__ == "__main__":
    sys.exit(main())
