"""The files that the commands write, checked before anything is read or computed."""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from skpose._files import check_new
from skpose._parallel.checkpoint import FileCheckpoint

MATRICES = "distances", "motions"  # commands that write a matrix, as .npy tile by tile, and continue it
NAMED = ".npz", ".csv"  # the suffixes of matrices with names
CONTENTS = ".bvh", ".npz", ".csv"  # of motions; keypoints have the last two
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


def find_contradiction_of_view(options: argparse.Namespace) -> str:
    """Return in words which options of ``skpose view`` exclude each other, empty if none do."""
    if (options.out, options.png, options.gif) == (None, None, None):
        return "pass --out VIEW.html for a page, --png OUT.png for a picture or --gif OUT.gif for a moving one"
    if options.out is None and (options.align or options.overlay):
        return "--align and --overlay are for a page, and pictures show motions side by side: pass --out VIEW.html"
    if options.png is None and options.at is not None:
        return "--at is the time of --png: pass both"
    if options.gif is None and (options.begins, options.ends, options.fps) != (None, None, None):
        return "--from, --to and --fps are for --gif: pass it too"
    if options.fps is not None and options.fps > 50:
        return f"--fps must be at most 50, as viewers show shorter pictures of a GIF longer, got {options.fps:g}"
    return ""
