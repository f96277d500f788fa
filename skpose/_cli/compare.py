"""`skpose compare`: accuracy of action recognition under each metric."""

import argparse
import textwrap
from pathlib import Path

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser(
        "compare",
        help="compare the accuracy of action recognition under all metrics",
        description="Print the 1-NN accuracy of single poses and of whole motions for each metric. Actions of only "
        "one person are left out; joints of 2 or 3 angles become ball joints.",
        parents=[options.computing(None), options.reading(skip=False)],
    )
    add_folder(parser)
    parser.add_argument(
        "--paper", action="store_true", help="the paper's protocol: walks and runs, with the angles of the files"
    )
    parser.set_defaults(func=run)


def add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        help="AMC files with an index.csv, see skpose.datasets.load_cmu, files of HDM05, or BVH files named "
        "SUBJECT_ACTION_TRIAL.bvh; default: generated motions",
    )


def run(args: argparse.Namespace) -> None:
    import numpy as np

    from skpose._cli.inputs import read_labelled
    from skpose._cli.studies.compare import COLUMNS, FRAME_RATE, PAPER, compare, prepare

    if args.folder is not None:
        dataset, source = read_labelled(args), str(args.folder)
    else:
        make = skpose.datasets.make_gait if args.paper else skpose.datasets.make_actions
        dataset, source = make(random_state=0), f"generated, skpose.datasets.{make.__name__}(random_state=0)"
    n_all, dataset = len(dataset), prepare(dataset, paper=args.paper)
    n_actions, n_people = len(set(dataset.actions)), len(set(dataset.subjects))
    print(f"{'Walking or running' if args.paper else 'Which action is it'}? {source}")
    joints = "angles as they are" if args.paper else "ball joints"
    print(
        f"{len(dataset)} motions of {n_actions} actions by {n_people} people, {sum(map(len, dataset)):,} poses "
        f"at {FRAME_RATE:g} Hz, {joints}"
    )
    if len(dataset) < n_all:
        print(f"{n_all - len(dataset)} motions of other actions are left out")
    print(f"\n{'':<10}{'1-NN accuracy':^40}{'variance in':>13}")
    print(f"{'':<10}{'among other people':>20}{'among other motions':>20}{'first MDS':>13}")
    print(f"{'metric':<10}{'frames':>11}{'motions':>9}{'frames':>11}{'motions':>9}{'component':>13}{'time':>10}")
    for result in compare(dataset, n_jobs=args.jobs):
        shares = ["-" if np.isnan(value) else f"{value:.1%}" for value in result[1:-1]]
        cells = "".join(f"{cell:>{width}}" for cell, width in zip(shares, (11, 9, 11, 9, 13), strict=True))
        print(f"{result.metric:<10}{cells}{result.seconds:>8.2f} s", flush=True)
    print("\n" + textwrap.fill(COLUMNS, 100))
    if args.paper:
        print(textwrap.fill(PAPER, 100))
