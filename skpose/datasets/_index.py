"""The list of the motions in a folder, index.csv, and their reading."""

import csv
import io
import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path

from skpose._parallel.progress import progress
from skpose._validation.names import near_names
from skpose.datasets._motions import MotionDataset
from skpose.io import AsfFile, MocapFormatError, load_amc

PathLike = str | os.PathLike
INDEX = "index.csv"
COLUMNS = ("subject", "trial", "action", "frames_per_second", "file")


def read_motions(
    folder: Path, rows: list[dict], origin: Path | None, asf_of: Callable[[Path], Path], verbose: int
) -> MotionDataset:
    """Read the AMC files that rows refer to, and each ASF file once; `origin` is the index that the rows are from."""
    skeletons: dict[Path, AsfFile] = {}
    motions = []
    with progress(f"reading {len(rows)} motions", len(rows), verbose) as advance:
        for row in rows:
            path = folder / row["file"]
            asf = asf_of(path)
            for needed in (asf, path):
                if not needed.is_file():
                    raise FileNotFoundError(f"{needed} is missing, but {origin or path} refers to it")
            if asf not in skeletons:
                skeletons[asf] = AsfFile(asf)
            motions.append(load_amc(path, skeletons[asf], frame_rate=row["frames_per_second"]))
            advance()
    return MotionDataset(motions, *([row[key] for row in rows] for key in ("subject", "trial", "action")))


def check_folder(folder: Path) -> None:
    """Refuse a folder of motions that is not there, with what is near to its name."""
    if folder.is_dir():
        return
    if folder.exists():
        raise NotADirectoryError(f"{folder} is a file, expected a folder of motions: pass the folder that it is in")
    above = folder.absolute().parent
    if not above.is_dir():
        raise FileNotFoundError(f"there is no folder {folder}, as there is no folder {folder.parent}")
    near = near_names([path.name for path in above.iterdir() if path.is_dir()], folder.name, "")
    raise FileNotFoundError(f"there is no folder {folder}{f': {near}' if near else ', nor one with a similar name'}")


def read_index(path: Path) -> list[dict]:
    """Return the rows of an index with the frame rates as numbers, None where they are blank."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        problem = f"expected text in UTF-8, found the byte {error.object[error.start]:#x}: save the index as UTF-8"
        raise MocapFormatError(path, line, problem) from None
    with io.StringIO(text, newline="") as file:
        reader = csv.DictReader(file)
        missing = [name for name in COLUMNS if name not in (reader.fieldnames or [])]
        if missing:
            raise MocapFormatError(path, 1, f"expected the columns {', '.join(COLUMNS)}; missing: {', '.join(missing)}")
        rows = []
        for row in reader:
            if any(row[name] is None for name in COLUMNS) or not row["file"]:
                raise MocapFormatError(path, reader.line_num, f"expected a value for each of {', '.join(COLUMNS)}")
            rate = _number(row["frames_per_second"]) if row["frames_per_second"].strip() else None
            if rate is not None and not 0.0 < rate < math.inf:
                problem = f"frames_per_second: expected a positive number, found {row['frames_per_second']!r}"
                raise MocapFormatError(path, reader.line_num, problem)
            rows.append(row | {"frames_per_second": rate})
    if not rows:
        raise MocapFormatError(path, None, "the index names no motions")
    return rows


def rows_of(files: Iterable[Path]) -> dict[Path, dict]:
    """Return, of the files that an index in their folder or in one above it names, its row, with the `index` itself."""
    indexes: dict[Path, dict[Path, dict]] = {}
    found = {}
    for path in files:
        # A link may be in the folder of an index, or be one to a file that is.
        for absolute in dict.fromkeys((Path(os.path.abspath(path)), Path(os.path.realpath(path)))):
            for folder in absolute.parents:
                if folder not in indexes:
                    indexes[folder] = _rows_in(folder) if is_index(folder / INDEX) else {}
                if path not in found and absolute in indexes[folder]:
                    found[path] = indexes[folder][absolute]
    return found


def _rows_in(folder: Path) -> dict[Path, dict]:
    """Return the rows of a folder's index by the absolute paths of their files."""
    index = folder / INDEX
    return {Path(os.path.abspath(folder / row["file"])): row | {"index": index} for row in read_index(index)}


def is_index(path: Path) -> bool:
    """Return whether a file is an index of motions, by its head; other programs write files of that name, too."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            head = file.readline(10_000).decode("utf-8-sig", errors="replace")
    except OSError:  # of a folder above, which may not be ours
        return False
    return {"file", "frames_per_second"} <= set(next(csv.reader([head]), []))


def _number(text: str) -> float:
    """Return a text as a number, NaN if it is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
