"""The files of a command: reading them, with their subjects, actions, trials and frame rates, and writing results."""

import argparse
import sys
from collections.abc import Callable, Collection, Iterable, Sequence
from inspect import signature
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from skpose._utils.warnings import warn
from skpose.datasets import MotionDataset, load_motions
from skpose.datasets._folder import INDEX, MOTIONS, RATE, Row, find_files, labels_of, rows_of
from skpose.datasets._motions import Rotations
from skpose.io import load_motion, save_bvh, save_csv, save_npz, save_smpl
from skpose.io._formats import EXPECTED, FORMATS, format_of
from skpose.io._source import Source, open_source
from skpose.keypoints import Keypoints
from skpose.robots import load_robot
from skpose.robots._load import is_robot
from skpose.skeleton import Motion, Skeleton
from skpose.view import Page

Content = Motion | Skeleton | Keypoints
STDIN = "-"
MOVING = (*MOTIONS, ".trc", ".c3d")
READING = [name for name in dict.fromkeys(option for one in FORMATS for option in one.options) if name != "frame_rate"]


def reading_options(args: argparse.Namespace) -> dict[str, Any]:
    """The keyword arguments of loaders for which there was an option."""
    options = {name: getattr(args, name, None) for name in READING} | {"frame_rate": args.file_frame_rate}
    return {name: value for name, value in options.items() if value is not None}


def load(file: Path | BytesIO, options: dict[str, Any]) -> Content:
    """Load a file of any format, with those options that its loader has."""
    is_a_robot = is_robot(file)
    if isinstance(file, BytesIO):
        file.seek(0)
    if is_a_robot:
        return load_robot(file, **_some(options, signature(load_robot).parameters))
    source = Source(file, EXPECTED, binary=True)
    found = format_of(source)
    return (
        load_poses(source, options)
        if found.content == "motion"
        else found.load(source, **_some(options, found.options))
    )


def load_poses(file: Path | BytesIO | Source, options: dict[str, Any]) -> Motion:
    """Load a motion with a skeleton; the scale of other files of the command is not for files in metres."""
    source: Any = open_source(file, EXPECTED, binary=True)
    known = {name for one in FORMATS if one.content == "motion" for name in one.options}
    return load_motion(source, **_some(options, known - ({"scale"} - {*format_of(source).options})))


def load_moving(file: Path | BytesIO, options: dict[str, Any]) -> Motion | Keypoints:
    """Load a motion or keypoints."""
    content = load(file, options)
    if isinstance(content, Skeleton):
        raise ValueError(f"{getattr(file, 'name', file)} is a skeleton without a motion")
    return content


def _some(options: dict[str, Any], names: Collection[str]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if name in names}


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
    labels = labels_of(rows_of([Path(name) for name in names]))
    dataset = MotionDataset([motion for _, motion in contents], **labels, rotations=args.rotations)
    if args.retarget != "numbers":
        dataset = dataset.retarget(dataset.motions[0].skeleton, method=args.retarget)
        for name, report in zip(names, dataset.retargeting, strict=True):
            print(f"skpose: {name}: by {report}", file=sys.stderr)
    if args.with_root is not None:
        dataset = dataset.with_root(args.with_root)
    dataset = dataset.retarget(dataset.skeleton, method="numbers")
    if args.frame_rate is not None:
        motions = [motion.resample(args.frame_rate) for motion in dataset]
        dataset = MotionDataset(motions, **labels, rotations="file")
    return names, dataset


def read_labelled(args: argparse.Namespace, rotations: Rotations) -> MotionDataset:
    """The motions of a folder with their subjects, actions and trials, by an index.csv or by their names."""
    dataset = load_motions(args.folder, on_error="raise", rotations=rotations, **reading_options(args))
    if not is_labelled(dataset):
        raise ValueError(f"files must be named SUBJECT_ACTION_TRIAL.bvh, or be in an {INDEX}")
    return dataset


def is_labelled(dataset: MotionDataset) -> bool:
    """Whether the subject and the action of every motion are known."""
    return all(all(getattr(dataset, name, [""])) for name in ("subjects", "actions"))


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


def save_motion(content: Motion | Keypoints, out: Path, scale: float, smpl: bool) -> None:
    """Write a motion or keypoints in the format of the suffix; `scale` is metres per unit of a BVH file."""
    suffix = out.suffix.lower()
    on_smpl = suffix == ".npy" or (smpl and suffix == ".npz")
    if suffix != ".bvh" and not on_smpl:
        (save_npz if suffix == ".npz" else save_csv)(out, content)
    elif isinstance(content, Keypoints):
        raise ValueError("keypoints have no skeleton, as BVH and SMPL files need: choose .npz or .csv")
    elif on_smpl:
        save_smpl(out, content, content="joints" if suffix == ".npy" else "poses")
    else:
        save_bvh(out, content, scale=scale)
        if content.fitted:
            print("BVH files do not state that poses were fitted to positions; .npz files do")
        if scale != 1.0:
            print(f"BVH files do not state their unit: read this one with --scale {scale:g}")
    print(f"{out}: {'22 joints at 20 Hz' if suffix == '.npy' else repr(content)}")


def save_page(page: Page, out: Path | None, show: bool) -> None:
    """Write a page, and show it in the browser, from a temporary file if there is no `out`."""
    if out is not None:
        page.save(out)
        print(f"{out}: {page.note}, {page.n_bytes / 1e6:.2g} MB")
    if show:
        print(f"{page.open()}: open this file if no browser shows it")
