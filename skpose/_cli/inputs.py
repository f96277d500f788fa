"""Motions from the files, folders and pipes that a command is given. Errors name the files."""

import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import numpy as np

from skpose._cli.labels import labels_in_names
from skpose._cli.reader import Reader, name_of
from skpose.datasets import MotionDataset, load_cmu, load_hdm05, walks_and_runs
from skpose.datasets._shared import INDEX, NAME, ONE_REST, ONE_RIG, check_folder, read_index
from skpose.keypoints import Keypoints
from skpose.kinematics._shared import Method
from skpose.motions._shared import rates_differ
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import check_comparable, mismatch

MOVING = ".bvh", ".amc", ".trc", ".c3d"  # files of a folder that `skpose view` shows


def motion_files(paths: Iterable[Path], suffixes: tuple[str, ...] = (".bvh", ".amc")) -> list[Path]:
    """Return the files, in the place of each folder all that have one of the suffixes, in it or below, sorted."""
    files = []
    for path in paths:
        if not path.is_dir():
            files.append(path)
            continue
        found = _files_in(path, suffixes)
        if not found:
            raise FileNotFoundError(f"the folder {path} holds no files named *{', *'.join(suffixes)}")
        files += found
    return files


def _files_in(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    found = (path for path in folder.rglob("[!.]*") if path.name.lower().removesuffix(".gz").endswith(suffixes))
    return sorted(path for path in found if not path.is_dir())


def one_file(path: Path, argument: str) -> Path:
    """Return the path of an argument that is one file; refuse a folder."""
    if path.is_dir():
        raise IsADirectoryError(f"{argument} must be one file, and {path} is a folder: choose a file in it")
    return path


def join_poses(dataset: MotionDataset) -> np.ndarray:
    """Return all poses of motions that have the names of their files. Print which rows belong to which file."""
    ends = np.cumsum([len(motion) for motion in dataset])
    for name, first_row, end in zip(dataset.subjects, [0, *ends], ends, strict=False):
        print(f"{first_row:>8} to {end - 1:<8} {name}")
    return np.concatenate([motion.angles for motion in dataset])


def read_motions(
    paths: Sequence[Path],
    frame_rate: float | None,
    *,
    reader: Reader,
    required: int = 0,
    rotations: Literal["rotvec"] | None = None,
    method: Method = "numbers",
    with_root: Literal["tilt", "whole"] | None = None,
    one_frame_rate: bool = False,
    frames: bool = False,
) -> MotionDataset:
    """Read all files; return their motions on the mean skeleton. Their labels are the names of the files.

    Motions with another `method` than "numbers" are on the skeleton of the first file. With `one_frame_rate`
    refuse motions of different frame rates, and without frames; with `frames` the latter alone. Of the first files, the
    `required` are not left out.
    """
    read = list(reader.read(motion_files(paths), frames=frames or one_frame_rate, required=required))
    names, motions = [name_of(path) for path, _ in read], [motion for _, motion in read]
    dataset = MotionDataset(motions, names, names, names)
    with files_in_messages(names):
        if rotations == "rotvec":
            dataset = dataset.to_rotvec()
        if method != "numbers":
            first = dataset.motions[0].skeleton
            for i, motion in enumerate(dataset if method == "unchecked" else ()):
                if difference := mismatch(first, motion.skeleton):
                    raise ValueError(f"motions[{i}] does not fit the skeleton of motions[0]: {difference}. {ONE_RIG}")
            dataset = dataset.retarget(first, method=method)
            for report in dict.fromkeys(dataset.retargeting):
                of = [name for name, other in zip(names, dataset.retargeting, strict=True) if other == report]
                whose = of[0] if len(of) == 1 else f"{len(of)} of {len(names)} files"
                print(f"skpose: {whose}: by {report}", file=sys.stderr)
        if with_root is not None:
            dataset = dataset.with_root(with_root)
        dataset = dataset.retarget(dataset.skeleton, method="numbers")
    if frame_rate is not None:
        dataset = MotionDataset([motion.resample(frame_rate) for motion in dataset], names, names, names)
    if one_frame_rate:
        check_one_frame_rate(dataset)
    return dataset


def read_separately(paths: Sequence[Path], frame_rate: float | None, reader: Reader) -> tuple[list[str], list[Motion]]:
    """Read all files; return their names, and motions, each on its own skeleton. Refuse those without frames."""
    read = list(reader.read(motion_files(paths), frames=True))
    names, motions = [name_of(path) for path, _ in read], [motion for _, motion in read]
    return names, motions if frame_rate is None else [motion.resample(frame_rate) for motion in motions]


def read_moving(
    paths: Sequence[Path], frame_rate: float | None, reader: Reader, load: Callable[..., Any]
) -> tuple[list[str], list[Motion | Keypoints]]:
    """Read all files; return their names, and motions, each on its own skeleton, or keypoints. Refuse those without
    frames, and skeletons without a motion.
    """
    read = list(reader.read(motion_files(paths, MOVING), partial(_load_moving, load), frames=True))
    names, shown = [name_of(path) for path, _ in read], [one for _, one in read]
    if frame_rate is not None:
        shown = [_at_rate(one, frame_rate, name) for name, one in zip(names, shown, strict=True)]
    return names, shown


def _load_moving(load: Callable[..., Any], file: Path | BytesIO, **options: Any) -> Motion | Keypoints:
    content = load(file, **options)
    if isinstance(content, Skeleton):
        raise ValueError(
            "this is a skeleton (ASF or a robot), which has no motion: choose a motion, such as its AMC file"
        )
    return content


def _at_rate(content: Motion | Keypoints, frame_rate: float, name: str) -> Motion | Keypoints:
    """Return a motion resampled; of keypoints every other frame, every third and so on, as none is made up."""
    if isinstance(content, Motion):
        return content.resample(frame_rate)
    step = round(content.frame_rate / frame_rate)
    if step < 1 or rates_differ(content.frame_rate / step, frame_rate):
        rates = ", ".join(f"{content.frame_rate / k:.4g}" for k in range(1, 6))
        raise ValueError(
            f"{name} has points at {content.frame_rate:g} Hz, of which whole frames are left out: use --frame-rate "
            f"{rates} and so on, got {frame_rate:g}"
        )
    return content[::step]


def check_one_frame_rate(dataset: MotionDataset) -> None:
    """Refuse motions that are not comparable in time."""
    first, frame_rate = dataset.subjects[0], dataset.motions[0].frame_rate
    for name, motion in zip(dataset.subjects, dataset, strict=True):
        if rates_differ(motion.frame_rate, frame_rate):
            raise ValueError(
                f"{first} has {frame_rate:g} frames a second and {name} {motion.frame_rate:g}, which changes the "
                "distances: resample all with --frame-rate, such as --frame-rate "
                f"{min(frame_rate, motion.frame_rate):g}"
            )


@contextmanager
def files_in_messages(names: Sequence[str], collection: str = "motions") -> Iterator[None]:
    """Name files in the errors about a collection, which name motions by their index."""
    try:
        yield
    except ValueError as error:
        message = re.sub(rf"(?<![\w.]){collection}\[(\d+)\]", lambda found: names[int(found[1])], str(error))
        raise ValueError(message) from None


def read_labelled(
    folder: Path,
    scale: float | Literal["auto"] | None,
    choose: Callable[[MotionDataset], MotionDataset] = walks_and_runs,
) -> MotionDataset:
    """Return the motions of a folder, with labels. Those that `choose` returns are comparable.

    The labels are those of an index.csv, see `load_cmu`, of files that are named as in HDM05, or of BVH files that are
    named SUBJECT_ACTION_TRIAL.bvh.
    """
    check_folder(folder)
    index, paths = folder / INDEX, []
    if not index.is_file() and not (paths := [path for path in _files_in(folder, (".amc",)) if NAME.match(path.name)]):
        paths = _files_in(folder, (".bvh",))
        labels = labels_in_names(folder, paths, gait=choose is walks_and_runs)
        motions = [motion for _, motion in Reader({"scale": scale}).read(paths)]
        dataset = MotionDataset(motions, labels["subject"], labels["trial"], labels["action"])
    else:
        if scale is not None:
            holds = f"an {INDEX}" if index.is_file() else f"{paths[0].name}"
            raise ValueError(f"--scale is for folders of BVH files; {folder} has {holds}, which is of AMC files")
        paths = [folder / row["file"] for row in read_index(index)] if index.is_file() else paths
        dataset = (load_hdm05 if all(NAME.fullmatch(path.name) for path in paths) else load_cmu)(folder)
    file_of = {id(motion): str(path) for motion, path in zip(dataset, paths, strict=True)}
    skeletons: dict[Skeleton, str] = {}
    for motion in choose(dataset):
        skeletons.setdefault(motion.skeleton, file_of[id(motion)])
    check_comparable(list(skeletons), list(skeletons.values()), ONE_REST, ONE_RIG)
    return dataset
