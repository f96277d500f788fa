"""Reading the files of a command, with their subjects, actions, trials and frame rates."""

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from inspect import signature
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from skpose._utils.warnings import warn
from skpose.datasets import MotionDataset, load_motions
from skpose.datasets._folder import INDEX, MOTIONS, RATE, Row, find_files, rows_of
from skpose.datasets._motions import Rotations
from skpose.io import load_motion
from skpose.io._formats import FORMATS, format_of
from skpose.keypoints import Keypoints
from skpose.robots import load_robot
from skpose.robots._load import is_robot
from skpose.skeleton import Motion, Skeleton

Content = Motion | Skeleton | Keypoints
STDIN = "-"
MOVING = (*MOTIONS, ".trc", ".c3d")
READING = [name for name in dict.fromkeys(option for one in FORMATS for option in one.options) if name != "frame_rate"]


def reading_options(args: argparse.Namespace) -> dict[str, Any]:
    """The keyword arguments of loaders for which there was an option."""
    options = {name: getattr(args, name, None) for name in READING} | {"frame_rate": args.file_frame_rate}
    return {name: value for name, value in options.items() if value is not None}


def load(file: Path | BytesIO, options: dict[str, Any]) -> Content:
    """Load a file of any format."""
    if is_robot(_rewind(file)):
        return _call(load_robot, file, options)
    found = format_of(_rewind(file))
    return load_poses(file, options) if found.content == "motion" else _call(found.load, file, options)


def load_poses(file: Path | BytesIO, options: dict[str, Any]) -> Motion:
    """Load a motion with a skeleton; the scale of other files of the command is not for files in metres."""
    known = {name for one in FORMATS if one.content == "motion" for name in one.options}
    if "scale" in options and "scale" not in format_of(_rewind(file)).options:
        known.remove("scale")
    return load_motion(_rewind(file), **{name: value for name, value in options.items() if name in known})


def load_moving(file: Path | BytesIO, options: dict[str, Any]) -> Motion | Keypoints:
    """Load a motion or keypoints."""
    content = load(file, options)
    if isinstance(content, Skeleton):
        raise ValueError(f"{getattr(file, 'name', file)} is a skeleton without a motion")
    return content


def _call(loader: Callable[..., Any], file: Path | BytesIO, options: dict[str, Any]) -> Any:
    """Call a loader with those options that it has."""
    known = signature(loader).parameters
    return loader(_rewind(file), **{name: value for name, value in options.items() if name in known})


def _rewind(file: Path | BytesIO) -> Path | BytesIO:
    if isinstance(file, BytesIO):
        file.seek(0)
    return file


def read(
    args: argparse.Namespace,
    paths: Iterable[Path],
    loader: Callable[[Path | BytesIO, dict[str, Any]], Any] = load,
    suffixes: Sequence[str] = MOVING,
    *,
    required: int = 0,
) -> list[tuple[str, Any]]:
    """The name and the content of each file; --skip-errors never leaves out the first `required` files."""
    rows, options, contents = describe(find_files(paths, suffixes)), reading_options(args), []
    given = options.get("frame_rate")
    if given is not None and any(row.get(RATE) not in (None, given) for row in rows):
        warn(f"--file-frame-rate {given:g} replaces other rates that file names or an index state")
    for i, row in enumerate(rows):
        path = row["file"]
        name = "standard input" if str(path) == STDIN else str(path)
        try:
            contents.append((name, loader(_open(path, name), {"frame_rate": row.get(RATE)} | options)))
        except (OSError, ValueError) as error:
            if i < required or not getattr(args, "skip_errors", False):
                raise
            print(f"skpose: left out: {error}", file=sys.stderr)
            args.status = 3  # the exit status
    if not contents:
        raise ValueError("no file could be read")
    return contents


def _open(path: Path, name: str) -> Path | BytesIO:
    """The path, or the content of standard input or of a pipe, which can be read only once."""
    if str(path) != STDIN and not path.is_fifo():
        return path
    content = BytesIO(sys.stdin.buffer.read() if str(path) == STDIN else path.read_bytes())
    content.name = name
    return content


def read_dataset(
    args: argparse.Namespace, paths: Iterable[Path], *, required: int = 0
) -> tuple[list[str], MotionDataset]:
    """The names of files, and their motions, prepared as the options ask for, on one skeleton."""
    contents = read(args, paths, load_poses, MOTIONS, required=required)
    names = [name for name, _ in contents]
    dataset = MotionDataset([motion for _, motion in contents], rotations=args.rotations)
    if args.retarget != "numbers":
        dataset = dataset.retarget(dataset.motions[0].skeleton, method=args.retarget)
        for name, report in zip(names, dataset.retargeting, strict=True):
            print(f"skpose: {name}: by {report}", file=sys.stderr)
    if args.with_root is not None:
        dataset = dataset.with_root(args.with_root)
    dataset = dataset.retarget(dataset.skeleton, method="numbers")
    if args.frame_rate is not None:
        dataset = MotionDataset([motion.resample(args.frame_rate) for motion in dataset], rotations="file")
    return names, dataset


def read_labelled(args: argparse.Namespace, rotations: Rotations) -> MotionDataset:
    """The motions of a folder with their subjects, actions and trials, by an index.csv or by their names."""
    dataset = load_motions(args.folder, on_error="raise", rotations=rotations, **reading_options(args))
    if not all(all(getattr(dataset, name, [""])) for name in ("subjects", "actions")):
        raise ValueError(f"files must be named SUBJECT_ACTION_TRIAL.bvh, or be in an {INDEX}")
    return dataset


def describe(files: Sequence[Path]) -> list[Row]:
    """What file names or an index state about files; indexes are named on stderr."""
    rows = rows_of(files)
    for index in dict.fromkeys(row["index"] for row in rows if "index" in row):
        print(f"skpose: labels and frame rates of {index}", file=sys.stderr)
    return rows


def resample(content: Any, frame_rate: float | None) -> Any:
    """A motion at another rate; keypoints are not interpolated: every n-th frame."""
    if frame_rate is None:
        return content
    if isinstance(content, Motion):
        return content.resample(frame_rate)
    step = content.frame_rate / frame_rate
    if step < 0.999 or abs(step - round(step)) > 1e-3 * step:
        raise ValueError(f"--frame-rate must divide the {content.frame_rate:g} Hz of keypoints, got {frame_rate:g}")
    return content[:: round(step)]


def rows_between(content: Motion | Keypoints, begins: float | None, ends: float | None) -> slice:
    """The rows of the frames from one time up to, and without, another, s."""
    begins, ends = begins or 0.0, np.inf if ends is None else ends
    first, last = np.searchsorted(content.times, [begins, ends]).tolist()
    if first >= last:
        raise ValueError(f"no frame from {begins:g} to {ends:g} s among {len(content)} at {content.frame_rate:g} Hz")
    return slice(first, last)


def shorten(names: Sequence[str]) -> list[str]:
    """The names of files without their folders, unless two are equal then."""
    short = [Path(name).name for name in names]
    return short if len(set(short)) == len(short) else list(names)
