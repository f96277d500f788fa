"""Motions from the files, folders and pipes that a command is given. Errors name the files."""

import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, Literal

import numpy as np

from skpose._cli.labels import labels_of_walks_and_runs
from skpose.datasets import MotionDataset, load_cmu, walks_and_runs
from skpose.datasets._shared import INDEX, ONE_REST, ONE_RIG, read_index
from skpose.io import AsfFile, load_motion
from skpose.kinematics._shared import Method
from skpose.motions._shared import rates_differ
from skpose.skeleton import Motion, Skeleton
from skpose.skeleton._shared import check_comparable, mismatch

STDIN = "-"


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
    return sorted(path for path in folder.rglob("[!.]*") if path.name.lower().removesuffix(".gz").endswith(suffixes))


def name_of(path: Path) -> str:
    """Return the name of a file for messages."""
    return "standard input" if str(path) == STDIN else str(path)


def read_if_pipe(path: Path) -> Path | BytesIO:
    """Return the path of a file, or what a pipe, which can be read only once, holds; "-" is standard input."""
    if str(path) != STDIN and (path.is_file() or not path.exists()):  # the reader reports that there is none
        return path
    content = BytesIO(sys.stdin.buffer.read() if str(path) == STDIN else path.read_bytes())
    content.name = name_of(path)
    return content


def reading_options(reading: dict[str, Any]) -> dict[str, Any]:
    """Return the options of the readers, with the content of the skeleton's file if that is a pipe."""
    if reading["asf"] is None or isinstance(asf := read_if_pipe(reading["asf"]), Path):
        return reading
    return reading | {"asf": AsfFile(asf, scale=reading["scale"])}


def query_file(path: Path) -> Path:
    """Return the path of the one motion that is to be found; refuse a folder."""
    if path.is_dir():
        raise IsADirectoryError(f"QUERY must be one file, and {path} is a folder: choose a file in it")
    return path


def read_poses(paths: Sequence[Path], frame_rate: float | None, **preparing: Any) -> tuple[np.ndarray, Skeleton]:
    """Read all files, see `read_motions`; return all poses and the skeleton. Print which rows belong to which file."""
    dataset = read_motions(paths, frame_rate, **preparing)
    ends = np.cumsum([len(motion) for motion in dataset])
    for name, first_row, end in zip(dataset.subjects, [0, *ends], ends, strict=False):
        print(f"{first_row:>8} to {end - 1:<8} {name}")
    return np.concatenate([motion.angles for motion in dataset]), dataset.motions[0].skeleton


def read_motions(
    paths: Sequence[Path],
    frame_rate: float | None,
    *,
    reading: dict[str, Any],
    rotations: Literal["rotvec"] | None = None,
    method: Method = "numbers",
    with_root: Literal["tilt", "whole"] | None = None,
    one_frame_rate: bool = False,
    amc_frame_rates: Mapping[Path, float] | None = None,
) -> MotionDataset:
    """Read all files; return their motions on the mean skeleton. Their labels are the names of the files.

    Motions with another `method` than "numbers" are on the skeleton of the first file. With `one_frame_rate`
    refuse motions of different frame rates, and without frames. `amc_frame_rates` are those of some AMC files.
    """
    files = motion_files(paths)
    reading = reading_options(reading)
    names = [name_of(path) for path in files]
    known = amc_frame_rates or {}
    stated = [{"frame_rate": known[path]} if path in known else {} for path in files]
    motions = [load_motion(read_if_pipe(path), **(reading | one)) for path, one in zip(files, stated, strict=True)]
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
            for name, report in zip(names, dataset.retargeting, strict=True):
                print(f"{name}: by {report}")
        if with_root is not None:
            dataset = dataset.with_root(with_root)
        dataset = dataset.retarget(dataset.skeleton, method="numbers")
    if frame_rate is not None:
        dataset = MotionDataset([motion.resample(frame_rate) for motion in dataset], names, names, names)
    if one_frame_rate:
        check_one_frame_rate(dataset)
    return dataset


def read_separately(
    paths: Sequence[Path], frame_rate: float | None, reading: dict[str, Any]
) -> tuple[list[str], list[Motion]]:
    """Read all files; return their names, and their motions, each on its own skeleton. Refuse those without frames."""
    files, reading = motion_files(paths), reading_options(reading)
    names = [name_of(path) for path in files]
    motions = [load_motion(read_if_pipe(path), **reading) for path in files]
    for name, motion in zip(names, motions, strict=True):
        _check_has_frames(name, motion)
    return names, motions if frame_rate is None else [motion.resample(frame_rate) for motion in motions]


def _check_has_frames(name: str, motion: Motion) -> None:
    if not len(motion):
        raise ValueError(f"{name} has no frames: leave it out")


def check_one_frame_rate(dataset: MotionDataset) -> None:
    """Refuse motions that are not comparable in time."""
    first, frame_rate = dataset.subjects[0], dataset.motions[0].frame_rate
    for name, motion in zip(dataset.subjects, dataset, strict=True):
        _check_has_frames(name, motion)
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


def read_gait(folder: Path, scale: float | None) -> MotionDataset:
    """Return the motions of a folder, with labels, and with walks and runs that are comparable.

    The labels are those of an index.csv, see `load_cmu`, or of BVH files that are named SUBJECT_ACTION_TRIAL.bvh.
    """
    if (folder / INDEX).is_file():
        if scale is not None:
            raise ValueError(f"--scale is for folders of BVH files; {folder} has an {INDEX}, which is of AMC files")
        files = [str(folder / row["file"]) for row in read_index(folder / INDEX)]
        dataset = load_cmu(folder)
    else:
        paths = _files_in(folder, (".bvh",))
        labels = labels_of_walks_and_runs(folder, paths)
        files = [str(path) for path in paths]
        motions = [load_motion(path, scale=scale) for path in paths]
        dataset = MotionDataset(motions, labels["subject"], labels["trial"], labels["action"])
    file_of = {id(motion): file for motion, file in zip(dataset, files, strict=True)}
    skeletons: dict[Skeleton, str] = {}
    for motion in walks_and_runs(dataset):
        skeletons.setdefault(motion.skeleton, file_of[id(motion)])
    check_comparable(list(skeletons), list(skeletons.values()), ONE_REST, ONE_RIG)
    return dataset
