"""Options that several commands share, as parent parsers, and the types of their values."""

import argparse
from collections.abc import Callable
from pathlib import Path

METRICS = "angle", "position", "rotation", "spatial", "geodesic"  # the registry's, without importing numba
MOTION_SUFFIXES = ".bvh", ".npz", ".csv"


def reading(*, skip: bool = True) -> argparse.ArgumentParser:
    """Options of the readers of files."""
    parser = argparse.ArgumentParser(add_help=False)
    group = parser.add_argument_group(
        "reading files",
        "Arguments of skpose.io.load_motion (--file-frame-rate is frame_rate=); options of other formats are ignored",
    )
    add = group.add_argument
    if skip:
        add("--skip-errors", action="store_true", help="skip files that cannot be read, and exit with status 3")
    add(
        "--scale",
        type=positive,
        metavar="M",
        help="metres per unit of length, such as 0.01 for centimetres; default: the unit in the file, or metres",
    )
    add("--up", choices=["x", "y", "z", "-x", "-y", "-z"], metavar="AXIS", help="up axis of the files, such as --up=-y")
    add(
        "--file-frame-rate",
        dest="file_frame_rate",
        type=positive,
        metavar="HZ",
        help="frame rate of the files; default: as in the files; for AMC files from index.csv or their names, or 120",
    )
    add("--asf", type=Path, metavar="FILE", help="skeleton of AMC files; default: found by name")
    add("--root", metavar="NAME", help="root joint of a BVH file, or root link of a robot")
    add("--on-nan", choices=["raise", "drop"], help="raise an error for frames with NaN, or drop them")
    add("--trust", choices=["header", "rows"], help="which number of frames to trust in BVH and TRC files")
    add("--stretch", choices=["raise", "mean"], help="BVH bones of changing length: raise an error, or use the mean")
    add(
        "--root-offset",
        choices=["replace", "add"],
        help="whether BVH root positions replace the root's OFFSET or add to it",
    )
    add("--missing", choices=["raise", "rest"], help="raise an error for bones missing in AMC frames, or use zero")
    add("--model", type=Path, metavar="FILE", help="body model (.npz) of AMASS files; default: mean proportions")
    add("--no-hands", dest="hands", action="store_const", const=False, help="omit the finger joints of AMASS files")
    add("--layout", metavar="NAME", help="layout of keypoints, such as mediapipe33")
    add(
        "--names",
        type=lambda text: [name.strip() for name in text.split(",")],
        metavar="A,B,…",
        help="names of keypoints, separated by commas",
    )
    add(
        "--zeros", choices=["seen", "missing"], help="how to read positions of exactly 0 in TRC, C3D and keypoint files"
    )
    return parser


def preparing(frame_rate: float | None = None) -> argparse.ArgumentParser:
    """Options that prepare motions for comparison."""
    parser = argparse.ArgumentParser(add_help=False)
    group = parser.add_argument_group("preparing motions")
    default = "every frame" if frame_rate is None else f"{frame_rate:g}"
    add_frame_rate(group, frame_rate, default)
    add_rotations(group)
    group.add_argument(
        "--retarget",
        choices=["numbers", "orientations", "positions", "auto", "unchecked"],
        default="numbers",
        help="how to retarget motions of other rigs to the skeleton of the first file, see skpose.retarget; default: "
        "numbers, on the mean skeleton, for equal rest poses only",
    )
    group.add_argument(
        "--with-root", choices=["tilt", "whole"], help="include the tilt, or the whole orientation, of the root"
    )
    return parser


def computing(default_metric: str | None = "spatial") -> argparse.ArgumentParser:
    """Options of a computation: the metric, unless None, and the number of threads."""
    parser = argparse.ArgumentParser(add_help=False)
    group = parser.add_argument_group("computation")
    if default_metric is not None:
        group.add_argument("--metric", choices=METRICS, default=default_metric, help=f"default: {default_metric}")
    group.add_argument("--jobs", type=int, default=-1, metavar="N", help="threads; default: -1, all processors")
    return parser


def writing(*suffixes: str, required: bool = True) -> argparse.ArgumentParser:
    """The option of the new file."""
    parser = argparse.ArgumentParser(add_help=False)
    group = parser.add_argument_group("output")
    group.add_argument(
        "--out",
        type=file_named(*suffixes),
        required=required,
        metavar="FILE",
        help=f"the new file: {', '.join(suffixes)}; existing files are not overwritten",
    )
    if suffixes == MOTION_SUFFIXES:
        group.add_argument(
            "--out-scale", type=positive, default=1.0, metavar="M", help="metres per unit of a BVH file; default: 1"
        )
    return parser


def add_files(parser: argparse.ArgumentParser, what: str) -> None:
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help=f"{what}; a folder: all such files in it; -: standard input"
    )


def add_frame_rate(group: argparse._ActionsContainer, default: float | None = None, text: str = "every frame") -> None:
    group.add_argument(
        "--frame-rate", type=positive, default=default, metavar="HZ", help=f"resample to this rate; default: {text}"
    )


def add_rotations(group: argparse._ActionsContainer) -> None:
    group.add_argument("--rotations", choices=["rotvec"], help="turn joints of 2 or 3 Euler angles into ball joints")


def add_part(group: argparse._ActionsContainer, what: str) -> None:
    """Add --from and --to, in seconds."""
    for name, word in (("from", "begins"), ("to", "ends")):
        group.add_argument(
            f"--{name}", dest=word, type=float, metavar="S", help=f"time at which {what} {word}, in seconds"
        )


def file_named(*suffixes: str) -> Callable[[str], Path]:
    """The type of an option: a path whose suffix is one of these."""

    def path(text: str) -> Path:
        if Path(text).suffix.lower() not in suffixes:
            raise argparse.ArgumentTypeError(f"expected a name that ends in {' or '.join(suffixes)}, got {text!r}")
        return Path(text)

    return path


def one_file(text: str) -> Path:
    if Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"expected a file, got the folder {text!r}")
    return Path(text)


def positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a positive number, got {text!r}")
    return value
