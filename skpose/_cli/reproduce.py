"""`skpose reproduce`: section 3 of the paper."""

import argparse
from contextlib import ExitStack
from pathlib import Path

import skpose
from skpose._cli import options
from skpose._cli.compare import add_folder

REPORT = "report.md", "table.txt", "figure_3.png", "figure_4.png"


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "reproduce",
        help="repeat section 3 of the paper",
        description="Print every number of section 3 next to the paper's, and write the table and figures 3 and 4. The "
        "motions must include walks and runs: actions whose first word is walk or run.",
        parents=[options.computing(None), options.reading(skip=False)],
    )
    add_folder(parser)
    parser.add_argument(
        "--out", dest="directory", type=Path, required=True, metavar="DIR", help=f"folder for {', '.join(REPORT)}"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of all random draws; default: 0")
    parser.set_defaults(func=run)


def run(args: argparse.Namespace) -> None:
    from skpose._cli.inputs import read_labelled
    from skpose._cli.studies import reproduce_report as report  # fails early without matplotlib
    from skpose._cli.studies.reproduce import reproduce
    from skpose._utils.files import check_new, new_file

    for name in REPORT if args.directory.exists() else ():
        check_new(args.directory / name)
    if args.folder is None:
        dataset = skpose.datasets.make_gait(random_state=args.seed)
        source = f"generated gait, make_gait(random_state={args.seed})"
    else:
        dataset = read_labelled(args)
        source = f"{len(dataset)} motions of {len(set(dataset.subjects))} people in the folder {args.folder.name}"
    args.directory.mkdir(exist_ok=True)
    findings = reproduce(dataset, args.seed, n_jobs=args.jobs)
    print(report.text(findings))
    with ExitStack() as files:  # all files or none
        document, table, *figures = (files.enter_context(new_file(args.directory / name)) for name in REPORT)
        document.write_text(report.markdown(findings, source, args.seed), encoding="utf-8")
        table.write_text(report.text(findings) + "\n", encoding="utf-8")
        report.draw(findings, *figures)
    print(f"\n{args.directory}: {', '.join(REPORT)}")
