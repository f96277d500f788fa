"""Options that several commands share, and the types of their values."""

import argparse
from collections.abc import Callable
from pathlib import Path

METRICS = "angle", "position", "rotation", "spatial", "geodesic"  # the registry's, without importing numba
METRICS_HELP = f"{', '.join(METRICS[:-1])} or {METRICS[-1]}; default: spatial"
MOTION_SUFFIXES = ".bvh", ".npz", ".csv", ".npy"


def add_command(
    subparsers: argparse._SubParsersAction,
    run: Callable[[argparse.Namespace], None],
    name: str,
    summary: str,
    description: str,
    arguments: str,
) -> argparse.ArgumentParser:
    """A command whose help has a short usage and options in one line each."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        name,
        help=summary,
        description=description,
        usage=f"%(prog)s {arguments} [options]",
        formatter_class=lambda prog: argparse.HelpFormatter(prog, max_help_position=32),
    )
    parser.set_defaults(func=run)
    return parser


def add_reading(parser: argparse.ArgumentParser, *, skip: bool = True) -> None:
    """Add options of the readers of files, the arguments of `load_motion`."""
    group = parser.add_argument_group(
        "reading files", "arguments of skpose.io.load_motion, for all files of the command"
    )
    add = group.add_argument
    if skip:
        add("--skip-errors", action="store_true", help="skip unreadable files, and exit with status 3")
    add("--scale", type=_scale, metavar="M", help="metres per unit; 0.01 for centimetres; auto: by size; not of AMASS")
    add("--up", choices=["x", "y", "z", "-x", "-y", "-z"], metavar="AXIS", help="up axis, such as --up=-y")
    add(
        "--file-frame-rate",
        dest="file_frame_rate",
        type=positive,
        metavar="HZ",
        help="frame rate, instead of the one in the file",
    )
    add("--asf", type=Path, metavar="FILE", help="skeleton of AMC files")
    add("--root", metavar="NAME", help="root joint (BVH) or root link (robots)")
    add("--on-nan", choices=["raise", "drop"], help="raise an error for NaN, or drop the frames")
    add("--trust", choices=["header", "rows"], help="frame count: the header's, or the rows there")
    add("--stretch", choices=["raise", "mean"], help="bone length changes: error, or mean (BVH)")
    add("--root-offset", choices=["replace", "add"], help="root positions replace OFFSET, or add (BVH)")
    add("--missing", choices=["raise", "rest"], help="missing bones: error, or zero (AMC)")
    add("--model", type=Path, metavar="FILE", help="body model .npz (AMASS)")
    add("--no-hands", dest="hands", action="store_const", const=False, help="omit the finger joints (AMASS)")
    add("--layout", metavar="NAME", help="layout of keypoints, such as mediapipe33")
    add(
        "--names",
        type=lambda text: [name.strip() for name in text.split(",")],
        metavar="A,B,…",
        help="names of keypoints",
    )
    add("--zeros", choices=["seen", "missing"], help="points at exactly 0 are seen or missing")


def add_preparing(parser: argparse.ArgumentParser, frame_rate: float | None = None) -> None:
    """Add options that prepare motions for comparison."""
    group = parser.add_argument_group("preparing motions")
    add_frame_rate(group, frame_rate, "every frame" if frame_rate is None else f"{frame_rate:g}")
    group.add_argument(
        "--rotations",
        choices=["rotvec", "file"],
        default="rotvec",
        help="ball joints (default), or Euler angles of files",
    )
    group.add_argument(
        "--retarget",
        choices=["numbers", "orientations", "positions", "auto", "unchecked"],
        default="numbers",
        metavar="METHOD",
        help="numbers (default), orientations, positions, auto",
    )
    group.add_argument("--with-root", choices=["tilt", "whole"], help="also compare tilt, or tilt and heading")


def add_metric(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--metric", choices=METRICS, default="spatial", metavar="NAME", help=METRICS_HELP)


def add_jobs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--jobs", type=int, default=-1, metavar="N", help="threads; default: all processors")


def add_out(parser: argparse.ArgumentParser, *suffixes: str, required: bool = True) -> None:
    """Add the option of the new file."""
    parser.add_argument(
        "--out",
        type=file_named(*suffixes),
        required=required,
        metavar="FILE",
        help=f"new file: {', '.join(suffixes)}" + " (required)" * required,
    )
    if suffixes == MOTION_SUFFIXES:
        parser.add_argument(
            "--out-scale", type=positive, metavar="M", help="unit of the BVH file; 0.01: centimetres; default: metres"
        )
        parser.add_argument("--smpl", action="store_true", help=".npz as AMASS, on SMPL; .npy has HumanML3D's joints")


def add_files(parser: argparse.ArgumentParser, what: str) -> None:
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help=f"{what}, or folders of them; -: standard input"
    )


def add_frame_rate(group: argparse._ActionsContainer, default: float | None = None, text: str = "every frame") -> None:
    group.add_argument(
        "--frame-rate", type=positive, default=default, metavar="HZ", help=f"resample to this rate; default: {text}"
    )


def add_part(group: argparse._ActionsContainer, what: str) -> None:
    """Add --from and --to, in seconds."""
    for name, word in (("from", "begins"), ("to", "ends")):
        group.add_argument(f"--{name}", dest=word, type=float, metavar="S", help=f"time at which {what} {word}, s")


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


def _scale(text: str) -> float | str:
    return text if text == "auto" else positive(text)


def positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a positive number, got {text!r}")
    return value
