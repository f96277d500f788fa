"""The index of the motions in a folder, index.csv, and their reading."""

import csv
import math
import os
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

from skpose._utils.progress import progress
from skpose.datasets._motions import MotionDataset, Rotations
from skpose.io import AsfFile, MocapFormatError, load_amc

PathLike = str | os.PathLike
INDEX = "index.csv"
COLUMNS = ("subject", "trial", "action", "frames_per_second", "file")


def load_folder(
    folder: PathLike,
    scan: Callable[[Path], list[dict]],
    asf_of: Callable[[Path], Path],
    verbose: int,
    rotations: Rotations,
    frame_rate: float | None = None,
) -> MotionDataset:
    """Read the AMC files of the index of a folder, or the files that `scan` lists; `frame_rate` fills blanks."""
    folder = Path(folder)
    if not folder.is_dir():
        raise FileNotFoundError(f"there is no folder {folder}")
    index = folder / INDEX
    rows = read_index(index) if index.is_file() else scan(folder)
    rows = [row | {"frames_per_second": row["frames_per_second"] or frame_rate} for row in rows]
    return read_motions(folder, rows, asf_of, verbose, rotations)


def read_motions(
    folder: Path, rows: list[dict], asf_of: Callable[[Path], Path], verbose: int, rotations: Rotations
) -> MotionDataset:
    """Read the AMC files of rows, and each ASF file once."""
    skeletons: dict[Path, AsfFile] = {}
    motions = []
    with progress(f"reading {len(rows)} motions", len(rows), verbose) as advance:
        for row in rows:
            path = folder / row["file"]
            asf = asf_of(path)
            if asf not in skeletons:
                skeletons[asf] = AsfFile(asf)
            motions.append(load_amc(path, skeletons[asf], frame_rate=row["frames_per_second"]))
            advance()
    labels = ([row[key] for row in rows] for key in ("subject", "trial", "action"))
    return MotionDataset(motions, *labels, rotations=rotations)


def read_index(path: Path) -> list[dict]:
    """The rows of an index with frame rates as numbers, None if blank."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise MocapFormatError(path, None, f"expected UTF-8: {error}") from None
    reader, rows = csv.DictReader(text.splitlines(keepends=True)), []
    if missing := [name for name in COLUMNS if name not in (reader.fieldnames or [])]:
        raise MocapFormatError(path, 1, f"expected the columns {', '.join(COLUMNS)}; missing: {', '.join(missing)}")
    for row in reader:
        if any(row[name] is None for name in COLUMNS) or not row["file"]:
            raise MocapFormatError(path, reader.line_num, f"expected a value for each of {', '.join(COLUMNS)}")
        try:
            rate = float(row["frames_per_second"]) if row["frames_per_second"].strip() else None
        except ValueError:
            rate = math.nan
        if rate is not None and not 0.0 < rate < math.inf:
            problem = f"frames_per_second: expected a positive number, found {row['frames_per_second']!r}"
            raise MocapFormatError(path, reader.line_num, problem)
        rows.append(row | {"frames_per_second": rate})
    if not rows:
        raise MocapFormatError(path, None, "the index lists no motions")
    return rows


def rows_of(files: Iterable[Path]) -> dict[Path, dict]:
    """The rows of files that an index in their folder, or in the one above it, lists; of both the nearer.

    In CMU's layout, subjects/SS/SS_TT.amc, the index is next to "subjects". Indexes in use are named on stderr.
    """
    indexes: dict[Path, dict[str, dict]] = {}
    found, used = {}, dict[Path, None]()
    for path in files:
        absolute = Path(os.path.abspath(path))
        for folder in absolute.parents[: 3 if absolute.parent.parent.name == "subjects" else 2]:
            if folder not in indexes:
                rows = read_index(folder / INDEX) if is_index(folder / INDEX) else []
                indexes[folder] = {os.path.abspath(folder / row["file"]): row for row in rows}
            if str(absolute) in indexes[folder]:
                found[path] = indexes[folder][str(absolute)]
                used[folder / INDEX] = None
                break
    for index in used:
        print(f"skpose: labels and frame rates of {index}", file=sys.stderr)
    return found


def is_index(path: Path) -> bool:
    """Whether a file is an index of motions by its head; other programs write files of that name, too."""
    try:
        with path.open("rb") as file:
            head = file.readline(10_000).decode("utf-8-sig", errors="replace")
    except OSError:  # no such file, or in a folder that may not be read
        return False
    return {"file", "frames_per_second"} <= set(next(csv.reader([head]), []))
