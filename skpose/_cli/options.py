"""Options that several commands share, and the types of their values."""

import argparse
import re
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from skpose._cli.colours import RED, paint, paint_help
from skpose._cli.targets import CONTENTS, ENDINGS, file_named
from skpose._validation.names import near_names

# The groups of options of every command, in this order: what differs between commands comes first.
GROUPS = "input", "metric", "result", "output", "preparing", "computation", "reading"
WIDEST = 100  # of help, columns
METRICS = "angle", "position", "rotation", "spatial", "geodesic"  # the registry's, without numba and scikit-learn
# What is compiled, those first that take long.
SUBJECTS = "geodesics", "means", "motions", "inverse-kinematics", "neighbors", "distances"


class CommandParser(argparse.ArgumentParser):
    """A parser whose options are in the same groups, in the same order, for every command, and whose errors say what is
    near to a word that it does not know. Its usage has what must be given; help lists the options.
    """

    def __init__(self, **options: Any):
        super().__init__(**{"formatter_class": HelpFormatter} | options)
        self.color = False  # argparse's own, since Python 3.14
        self._own_groups = {title: self.add_argument_group(title) for title in GROUPS}

    def group(self, title: str) -> Any:
        """Return the group of a title."""
        return self._own_groups[title]

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse options that a command does not have here, where those that it has are known."""
        options, unknown = super().parse_known_args(args, namespace)
        if wrong := [text.partition("=")[0] for text in unknown if text.startswith("--") and text != "--"]:
            names = [name for action in self._actions for name in action.option_strings if name.startswith("--")]
            near = near_names([name[2:] for name in names], wrong[0][2:], f"{self.prog} --help lists all")
            self.error(f"there is no option {wrong[0]}: " + re.sub(r"'([\w-]+)'", r"--\1", near))
        return options, unknown

    def format_usage(self) -> str:
        """Return the usage in one line."""
        self.usage = self._short_usage()
        return super().format_usage()

    def format_help(self) -> str:
        """Return the help, without colours."""
        self.usage = self._short_usage()
        return super().format_help()

    def _short_usage(self) -> str:
        """Return the usage with arguments and options that are required, the other options as one word."""
        words, alternatives = [], {one: group for group in self._mutually_exclusive_groups for one in _actions(group)}
        for action in self._actions:
            group = alternatives.get(action)
            if not action.option_strings:
                name = str(action.metavar)
                words.append({"+": f"{name} ...", "?": f"[{name}]", "A...": f"{name} ..."}.get(str(action.nargs), name))
            elif action.required or (group is not None and group.required and action is _actions(group)[0]):
                either = [action] if group is None else _actions(group)
                text = " | ".join(f"{one.option_strings[-1]} {one.metavar}" for one in either)
                words.append(f"({text})" if either[1:] else text)
        return " ".join(["%(prog)s", *words, "[options]"])

    def _print_message(self, message: str, file: Any = None) -> None:
        if message and file is not None:
            file.write(paint_help(message, file))

    def error(self, message: str) -> NoReturn:
        """Print the usage, and the message with what is near to a wrong choice."""
        if choice := re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)$", message):
            choices = re.split(", ", choice[2].replace("'", ""))  # with quotation marks before Python 3.12
            message += near_names(choices, choice[1], "").replace("did", ": did", 1)
        self.print_usage(sys.stderr)
        print(f"{self.prog}: {paint('error:', RED, sys.stderr)} {message}", file=sys.stderr)
        self.exit(2)


class HelpFormatter(argparse.HelpFormatter):
    """Help in lines of 100 columns at most, with names of options on the left of what they do."""

    def __init__(self, prog: str):
        columns = min(shutil.get_terminal_size().columns, WIDEST)
        super().__init__(prog, max_help_position=26, width=columns - 2)


class ListFormatter(HelpFormatter, argparse.RawDescriptionHelpFormatter):
    """Help with a description in lines of its own."""


def _actions(group: Any) -> list[argparse.Action]:
    return group._group_actions


def add_folder(parser: CommandParser) -> None:
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        metavar="FOLDER",
        help="AMC files with an index.csv, see skpose.datasets.load_cmu, or BVH files whose names are their labels, "
        "SUBJECT_ACTION_TRIAL.bvh, such as anna_walk_1.bvh, ben_run_fast_2.bvh; walks and runs are actions that begin "
        "with the word walk or run; "
        "default: generated motions",
    )
    add_scale(parser, "metres per unit of length of BVH files; default: 1")


def add_poses(parser: CommandParser, out: str, suffixes: Sequence[str], result: str) -> None:
    """Add the options of a computation on poses that writes a file: input, output, metric, backend."""
    add_files(parser)
    add_out(parser, out, suffixes, result)
    add_metric(parser)
    add_preparing(parser)
    group = parser.group("computation")
    group.add_argument(
        "--backend",
        choices=["threads", "loky", "dask", "ray"],
        default="threads",
        metavar="NAME",
        help="threads (default), loky (processes), or dask or ray: a cluster, for which they must be installed",
    )
    group.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="address of the cluster, such as tcp://10.0.0.1:8786; default: start one on this machine",
    )
    add_jobs(parser)


def add_out(parser: CommandParser, out: str, suffixes: Sequence[str], result: str, *, named: bool = True) -> None:
    """Add the option of the file that is written; `named` says that there is one without the option too."""
    if ending := ENDINGS.get(parser.prog.split()[-1], "") if named else "":
        result += f"; default: the name of FILE with {ending}, here, with a number where there is one already"
    parser.group("output").add_argument("--out", type=file_named(*suffixes), metavar=out, help=result)


def add_open(parser: CommandParser, what: str) -> None:
    parser.group("output").add_argument("--open", action="store_true", help=f"show {what} in the browser")


def add_new_motion(parser: CommandParser, result: str, *, named: bool = True) -> None:
    """Add the options of a command that writes a motion."""
    formats = (
        f"{result}: .bvh for other programs; .npz, which loses nothing, for all commands, skpose.io.load_motion and "
        "numpy; .csv, a table of the angles in rad, for pandas and spreadsheets"
    )
    add_out(parser, "FILE", CONTENTS, formats, named=named)
    add_open(parser, "what is written")
    parser.group("output").add_argument(
        "--out-scale",
        type=positive(float),
        default=1.0,
        metavar="M",
        help="metres per unit of length in a BVH file that is written: 1 writes metres, 0.01 centimetres; default: 1",
    )


def add_files(
    parser: CommandParser,
    order: str = ", in the order of the rows",
    *,
    skip: bool = True,
    formats: str = "BVH, AMC or AMASS files, or .npz files of skpose",
    of_folders: str = "BVH and AMC",
) -> None:
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help=f"{formats}{order}; for a folder its {of_folders} files, sorted; - is standard input",
    )
    if skip:
        add_skip_errors(parser)


def add_skip_errors(parser: CommandParser) -> None:
    parser.group("reading").add_argument(
        "--skip-errors",
        action="store_true",
        help="leave out files that cannot be read, and go on with the others; they are listed at the end, and the exit "
        "status is 3; default: the first of them is an error",
    )


def add_metric(parser: CommandParser, choices: Sequence[str] = METRICS, default: str = "spatial") -> None:
    parser.group("metric").add_argument(
        "--metric", choices=choices, default=default, metavar="NAME", help=one_of(choices, default)
    )


def one_of(choices: Sequence[str], default: str | None = None) -> str:
    """Return choices in words, the default with a note."""
    *first, last = (f"{name} (default)" if name == default else name for name in choices)
    return f"{', '.join(first)} or {last}" if first else last


def add_dtype(parser: CommandParser) -> None:
    parser.group("output").add_argument(
        "--dtype",
        choices=["float32", "float64"],
        default="float64",
        metavar="TYPE",
        help="precision: float32 or float64 (default)",
    )


def add_preparing(parser: CommandParser, frame_rate: float | None = None, *, resample: bool = True) -> None:
    """Add the options of what is read, and of what is done with it before the computation."""
    if resample:
        add_frame_rate(parser, frame_rate)
    add_rotations(parser)
    add_reading(parser)
    group = parser.group("preparing")
    group.add_argument(
        "--retarget",
        dest="method",
        choices=["numbers", "orientations", "positions", "auto", "unchecked"],
        default="numbers",
        metavar="BY",
        help="bring files of different rigs or rest poses onto the skeleton of the first by orientations (directions "
        "of the bones in the world), positions (of the joints), auto (the first method that can) or unchecked (the "
        "numbers as they are); default: numbers, on the mean skeleton, with different rest poses refused",
    )
    group.add_argument(
        "--with-root",
        choices=["tilt", "whole"],
        metavar="PART",
        help="make the orientation of the root a part of the poses: its tilt, without the heading, or the whole; "
        "default: neither",
    )


def add_rotations(parser: CommandParser) -> None:
    parser.group("preparing").add_argument(
        "--rotations",
        choices=["rotvec"],
        metavar="AS",
        help="rotvec: turn joints of two or three Euler angles into ball joints, which rotate by the shortest path; "
        "default: the files' angles",
    )


def add_frame_rate(parser: CommandParser, default: float | None = None) -> None:
    without = "every frame" if default is None else f"{default:g}"
    parser.group("preparing").add_argument(
        "--frame-rate",
        type=positive(float),
        default=default,
        metavar="HZ",
        help=f"resample to this many poses a second; default: {without}",
    )


def add_reading(parser: CommandParser) -> None:
    """Add the options of the readers of files."""
    group = parser.group("reading")
    group.add_argument(
        "--asf",
        type=Path,
        metavar="FILE",
        help="skeleton of the AMC files; default: in the same folder, walk.asf for walk.amc, or 02.asf for 02_01.amc",
    )
    group.add_argument(
        "--amc-frame-rate",
        type=positive(float),
        metavar="HZ",
        help="frame rate of AMC files, which do not state it; default: that of an index.csv in the folder of a file or "
        "in one above it, see skpose.datasets.load_cmu, or of a name as in HDM05, otherwise 120, with a warning",
    )
    group.add_argument(
        "--file-frame-rate",
        type=positive(float),
        metavar="HZ",
        help="frame rate of the files, in the place of what they state, with a warning where that differs; it changes "
        "the times and not the poses",
    )
    add_scale(parser, "metres per unit of length; default: 1 for BVH, the unit in the skeleton's file for AMC")
    group.add_argument(
        "--up",
        choices=["x", "y", "z", "-x", "-y", "-z"],
        metavar="AXIS",
        help="the axis of the files' world that points up: x, y, z, -x, -y or -z, as --up z or --up=-y; default: y for "
        "BVH and AMC files, z for AMASS files, and what .npz files of skpose state",
    )
    group.add_argument(
        "--model",
        metavar="FILE",
        help="body model (.npz) of AMASS files, see skpose.io.load_amass; {gender} in it is replaced by the motion's; "
        "default: a person of mean proportions",
    )
    group.add_argument(
        "--no-hands",
        dest="hands",
        action="store_false",
        help="leave out the joints beyond the wrists of AMASS files, with which SMPL and SMPL-H differ",
    )
    for name, choices, metavar, meaning in (
        ("on-nan", ["raise", "drop"], "DO", "frames with NaN or infinite numbers: {} (refuse the file), or {} them"),
        ("trust", ["header", "rows"], "WHAT", "number of frames of a BVH or TRC file: of its {}, or as it has {}"),
        ("stretch", ["raise", "mean"], "DO", "bones of a BVH file that change their lengths: {} (refuse it), or {}"),
        ("root-offset", ["replace", "add"], "DO", "position channels of a BVH file's ROOT {} its OFFSET, or {} to it"),
        (
            "missing",
            ["raise", "rest"],
            "DO",
            "bones that a frame of an AMC file lacks: {} (refuse it), or {}: zero",
        ),
    ):
        default = choices[0]
        meaning = f"{meaning.format(*choices)}; default: {default}"
        group.add_argument(f"--{name}", choices=choices, default=default, metavar=metavar, help=meaning)
    group.add_argument(
        "--root",
        metavar="NAME",
        help="joint of a BVH file that is the root, or link of a robot; default: the first, or its moving child if it "
        "stands still; of a robot the link that moves freely",
    )


def add_reading_points(parser: CommandParser) -> None:
    """Add the options of the readers of markers and keypoints."""
    group = parser.group("reading")
    group.add_argument(
        "--layout",
        metavar="NAME",
        help="layout of keypoints, one of skpose.keypoints.layouts, such as mediapipe33; default: the file's own names",
    )
    group.add_argument(
        "--names",
        type=lambda text: [name.strip() for name in text.split(",")],
        metavar="A,B,…",
        help="name of each point of a file of keypoints that names none",
    )
    group.add_argument(
        "--zeros",
        choices=["seen", "missing"],
        metavar="AS",
        help="positions of (0, 0, 0) in TRC and C3D files: seen, as they are, or missing, lost markers; default: seen, "
        "with a warning",
    )


def add_scale(parser: CommandParser, meaning: str) -> None:
    parser.group("reading").add_argument(
        "--scale",
        type=_scale,
        metavar="M",
        help=f"{meaning}; auto: for each file the unit in which it has the size of a person, which is printed",
    )


def _scale(text: str) -> float | str:
    return text if text == "auto" else positive(float)(text)


_scale.__name__ = "positive number or auto"  # in argparse's error message


def add_jobs(parser: CommandParser) -> None:
    parser.group("computation").add_argument(
        "--jobs", type=jobs, default=-1, metavar="N", help="threads or processes; -1, the default, is all processors"
    )


def jobs(text: str) -> int:
    number = int(text)
    if number == 0:
        raise ValueError
    return number


jobs.__name__ = "number of jobs"  # in argparse's error message


def share(text: str) -> float:
    value = float(text)
    if not 0 <= value <= 1:
        raise ValueError
    return value


share.__name__ = "share from 0 to 1"


def seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a time in seconds, zero or more, got {text!r}")
    return value


def positive(kind: type) -> Callable[[str], float]:
    def value_of(text: str) -> float:
        number = kind(text)
        if not 0 < number < float("inf"):
            raise ValueError
        return number

    value_of.__name__ = "positive integer" if kind is int else "positive number"  # in argparse's error message
    return value_of
