"""`skpose distances`: the matrix of distances between all poses."""

import argparse
from itertools import chain
from pathlib import Path
from typing import Any

import skpose
from skpose._cli import options


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = options.add_command(
        subparsers,
        run,
        "distances",
        "write the distances between all poses of files",
        "Write the matrix of distances between all poses. Poses of several skeletons are compared on their "
        "mean skeleton. .npy is an array for numpy.load(..., mmap_mode='r'), written tile by tile; .npz and .csv also "
        "have the names of the rows.",
        "FILE... --out FILE",
    )
    options.add_files(parser, "motions, in the order of the rows")
    options.add_out(parser, ".npy", ".npz", ".csv")
    options.add_metric(parser)
    parser.add_argument("--dtype", choices=["float32", "float64"], default="float64", help="default: float64")
    options.add_jobs(parser)
    options.add_preparing(parser)
    options.add_reading(parser)


def run(args: argparse.Namespace) -> None:
    import shutil

    import numpy as np

    from skpose._cli.files import read_dataset
    from skpose._utils.files import new_file

    names, dataset = read_dataset(args, args.files)
    ends = np.cumsum([len(motion) for motion in dataset])
    for name, first, end in zip(names, [0, *ends], ends, strict=False):
        print(f"{first:>8} to {end - 1:<8} {name}")
    X = np.concatenate([motion.angles for motion in dataset]).astype(args.dtype)
    shape = len(X), len(X)
    needed, free = X.itemsize * len(X) ** 2, shutil.disk_usage(args.out.absolute().parent).free
    if needed > free:
        raise ValueError(f"{args.out} needs {needed / 1e9:.1f} GB, and {free / 1e9:.1f} GB are free")
    with new_file(args.out) as new:
        is_array = args.out.suffix.lower() == ".npy"
        D = np.lib.format.open_memmap(new, "w+", X.dtype, shape) if is_array else np.empty(shape, X.dtype)
        skpose.pose_distances(X, skeleton=dataset.skeleton, metric=args.metric, n_jobs=args.jobs, out=D, verbose=1)
        if not is_array:
            _write_with_names(new, D, names, dataset, args.metric)
        del D
    print(f"{args.out}: {len(X):,} × {len(X):,} distances, {X.dtype}")


def _write_with_names(new: Path, D: Any, names: list[str], dataset: Any, metric: str) -> None:
    """Write a matrix with the file and the time of each row, the metric and its unit, as .npz or .csv."""
    import numpy as np

    from skpose._utils.files import write_csv

    rows = [f"{name} {time:.4f} s" for name, motion in zip(names, dataset, strict=True) for time in motion.times]
    unit = "rad" if metric == "angle" else "m"
    if new.suffix.lower() == ".csv":
        table = ([name, *row.astype(str)] for name, row in zip(rows, D, strict=True))
        write_csv(new, chain([[f"{metric}, {unit}", *rows]], table))
    else:
        files = np.repeat(names, [len(motion) for motion in dataset])
        times = np.concatenate([motion.times for motion in dataset])
        with new.open("wb") as file:
            np.savez(file, distances=D, names=rows, files=files, times=times, metric=metric, unit=unit)
