"""The files that the commands write, checked before anything is read or computed."""

import argparse
import os
from collections.abc import Callable, Sequence
from itertools import count
from pathlib import Path

from skpose._files import check_new
from skpose._parallel.checkpoint import FileCheckpoint

MATRICES = "distances", "motions"  # commands that write a matrix, as .npy tile by tile, and continue it
NAMED = ".npz", ".csv"  # the suffixes of matrices with names
CONTENTS = ".bvh", ".npz", ".csv"  # of motions; keypoints have the last two
# Of files without --out, what follows the name of the input.
ENDINGS = {
    "view": ".html",
    "explore": "_explore.html",
    "distances": "_distances.npy",
    "motions": "_motions.npy",
    "neighbors": "_neighbors.npz",
    "mean": "_mean.npz",
    "between": "_between.npz",
    "convert": ".npz",
    "angles": "_angles.csv",
    "reproduce": "_report",
}
REPORT = ("report.md", "table.txt", "figure_3.png", "figure_4.png")  # of `skpose reproduce`


def file_named(*suffixes: str) -> Callable[[str], Path]:
    """Return the type of an option: the path of a file whose name has the suffix of one of its formats."""
    *first, last = suffixes
    expected = f"{', '.join(first)} or {last}, the formats" if first else f"{last}, which is the format"

    def path(text: str) -> Path:
        if Path(text).suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"{text!r} does not end in {expected} of the file")
        return Path(text)

    return path


def prepare(options: argparse.Namespace) -> None:
    """Choose a name for what a command writes if none is given, and refuse those that cannot be written."""
    pictures = [path for path in (getattr(options, "png", None), getattr(options, "gif", None)) if path is not None]
    if options.out is None and (not pictures or options.open):
        options.out = default_name(options.command, _inputs(options))
    for path in [options.out] * (options.out is not None) + pictures:
        check(options.command, path)


def _inputs(options: argparse.Namespace) -> list[Path]:
    """Return the files or the folder that a command is given."""
    given = vars(options)
    one = given.get("file", given.get("folder"))
    return given.get("files", [] if one is None else [one])


def default_name(command: str, inputs: Sequence[Path]) -> Path:
    """Return the name of a new file, here, by what it is of: the first that is free, or an unfinished matrix."""
    ending = ENDINGS[command]
    of = f"{_stem(inputs[0])}_and_{len(inputs) - 1}_more" if inputs[1:] else _stem(inputs[0]) if inputs else ""
    name, dot, suffix = ending.partition(".")
    stem = of + name if of else name.removeprefix("_")
    paths = (Path(f"{stem}{f'_{number}' if number > 1 else ''}{dot}{suffix}") for number in count(1))
    return next(
        path for path in paths if not os.path.lexists(path) or (continues(command, path) and is_unfinished(path))
    )


def _stem(path: Path) -> str:
    """Return the name of a file without its endings, or of a folder."""
    if str(path) == "-":
        return "stdin"
    path = path.resolve() if path.name in ("", "..") else path
    name = path.name.removesuffix(".gz") if not path.is_dir() else path.name
    return (Path(name).stem if not path.is_dir() else name) or "skpose"


def is_unfinished(out: Path) -> bool:
    """Return whether a file holds a matrix of distances that can be continued."""
    return out.exists() and FileCheckpoint(out).path.exists()


def continues(command: str, out: Path | None) -> bool:
    """Return whether the command continues its file after an interruption."""
    return command in MATRICES and out is not None and out.suffix.lower() == ".npy"


def check(command: str, out: Path) -> None:
    """Raise an error unless the command can write its results."""
    if continues(command, out) and out.parent.is_dir():
        FileCheckpoint(out).read()  # refuses another program's file
        if is_unfinished(out):
            with out.open("r+b"):  # which may not be permitted
                return
    if command != "reproduce":
        check_new(out)
    elif out.is_dir():
        for name in REPORT:
            check_new(out / name)
    elif os.path.lexists(out):
        raise NotADirectoryError(f"{out} is a file: choose a folder, a new or an existing one")
    else:
        check_new(out)
