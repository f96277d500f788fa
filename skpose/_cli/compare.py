"""`skpose compare`: accuracy of action recognition under each metric."""

import argparse
import textwrap
from pathlib import Path

import skpose
from skpose._cli import options

FOLDER = (
    "The folder has AMC files with an index.csv, see skpose.datasets.load_cmu, files of HDM05, or BVH files named "
    "SUBJECT_ACTION_TRIAL.bvh."
)


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "compare",
        "compare the accuracy of action recognition under all metrics",
        "Print for each metric: 1-NN accuracy of frames and of whole motions (DTW); the median share of variance in "
        "the first MDS component; time without compilation. Actions of only one person are left out; joints of 2 or 3 "
        "angles become ball joints; the orientation of the root is ignored. "
        f"{FOLDER}",
        "[FOLDER]",
    )
    add_folder(parser)
    parser.add_argument("--paper", action="store_true", help="the paper's protocol: walks and runs")
    options.add_jobs(parser)
    options.add_reading(parser, skip=False)


def add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder", nargs="?", type=Path, metavar="FOLDER", help="labelled motions; default: generated ones"
    )


def run(args: argparse.Namespace) -> None:
    import numpy as np

    from skpose._cli.files import read_labelled
    from skpose._cli.studies.compare import FRAME_RATE, PAPER, compare, prepare
    from skpose.datasets._motions import Rotations

    rotations: Rotations = "file" if args.paper else "rotvec"
    if args.folder is not None:
        dataset, source = read_labelled(args, rotations), str(args.folder)
    else:
        make = skpose.datasets.make_gait if args.paper else skpose.datasets.make_actions
        dataset, source = (
            make(rotations=rotations, random_state=0),
            f"generated, skpose.datasets.{make.__name__}(random_state=0)",
        )
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
    print(f"\n{'':<10}{'1-NN accuracy,':<26}{'1-NN accuracy,':<26}variance in")
    print(f"{'':<10}{'leave-one-person-out':<26}{'leave-one-motion-out':<26}first MDS")
    print(f"{'metric':<10}{'frames':<9}{'motions (DTW)':<17}{'frames':<9}{'motions (DTW)':<17}{'component':<14}time")
    for result in compare(dataset, n_jobs=args.jobs):
        shares = ["-" if np.isnan(value) else f"{value:.1%}" for value in result[1:-1]]
        cells = "".join(f"{cell:<{width}}" for cell, width in zip(shares, (9, 17, 9, 17, 14), strict=True))
        print(f"{result.metric:<10}{cells}{result.seconds:.2f} s", flush=True)
    if args.paper:
        print("\n" + textwrap.fill(PAPER, 100))
