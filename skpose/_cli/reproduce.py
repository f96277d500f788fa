"""`skpose reproduce`: section 3 of the paper."""

import argparse
from contextlib import ExitStack
from pathlib import Path

import skpose
from skpose._cli import options
from skpose._cli.compare import FOLDER, add_folder

FIGURES = "figure_3.png", "figure_4.png"


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "reproduce",
        "repeat section 3 of the paper",
        "Print every number of section 3 next to the paper's, and write figures 3 and 4. The "
        f"motions must include walks and runs: actions whose first word is walk or run. {FOLDER}",
        "[FOLDER] --out DIR",
    )
    add_folder(parser)
    parser.add_argument(
        "--out",
        dest="directory",
        type=Path,
        required=True,
        metavar="DIR",
        help="folder for the figures (required)",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of all random draws; default: 0")
    options.add_jobs(parser)
    options.add_reading(parser, skip=False)


def run(args: argparse.Namespace) -> None:
    from skpose._cli.files import read_labelled
    from skpose._cli.studies import reproduce as study
    from skpose._utils.files import check_new, new_file

    for name in FIGURES if args.directory.exists() else ():
        check_new(args.directory / name)
    if args.folder is None:
        dataset = skpose.datasets.make_gait(rotations="file", random_state=args.seed)
    else:
        dataset = read_labelled(args, "file")
    args.directory.mkdir(exist_ok=True)
    findings = study.reproduce(dataset, args.seed, n_jobs=args.jobs)
    print(study.table(findings))
    with ExitStack() as files:  # both files or none
        study.draw(findings, *(files.enter_context(new_file(args.directory / name)) for name in FIGURES))
    print(f"\n{args.directory}: {', '.join(FIGURES)}")
