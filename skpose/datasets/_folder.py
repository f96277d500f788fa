"""Motions of files with their labels, by the names of the files or by a table."""

import csv
import glob
import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, Literal

from skpose._utils.progress import progress
from skpose._utils.validation import check_choice
from skpose._utils.warnings import warn
from skpose.datasets._motions import LABELS, MotionDataset, Rotations
from skpose.io import load_motion
from skpose.io._source import Source

PathLike = str | os.PathLike
Row = dict[str, Any]
INDEX = "index.csv"
COLUMNS = ("subject", "trial", "action", "frames_per_second", "file")
RATE = COLUMNS[3]
MOTIONS = (".bvh", ".amc")  # suffixes of the files of a folder
NO_MOTIONS = ("shape.npz", "stagei.npz")  # of AMASS, next to the motions
PATTERN = "{subject}_{action}_{trial}"
# Names of AMC files in databases, which a pattern cannot state.
HDM05 = re.compile(
    rf"HDM_(?P<subject>[a-z]+)_(?P<trial>(?P<action>.+?)_?\d*)_(?P<{RATE}>\d+)\.amc(\.gz)?", re.IGNORECASE
)
CMU = re.compile(r"(?P<subject>\d+)_(?P<trial>\d+)\.amc(\.gz)?", re.IGNORECASE)


def load_motions(
    files: PathLike | Iterable[PathLike],
    *,
    pattern: str | None = None,
    table: PathLike | None = None,
    scale: float | Literal["auto"] = "auto",
    on_error: Literal["warn", "raise"] = "warn",
    rotations: Rotations = "rotvec",
    verbose: int = 0,
    **options: Any,
) -> MotionDataset:
    """Read the motions of a folder, with labels by the names of the files or by a table.

    Parameters
    ----------
    files : str, path-like or iterable of such
        A folder, whose BVH and AMC files are read, or else its .npz files, also in folders below; a pattern such as
        ``"bvh/*.bvh"``; or the files.
    pattern : str, default=None
        The end of the path of a file, without suffix, with the places of labels: "{action}/{subject}-{trial}" has
        actions as folders. An action may contain underscores. None is "{subject}_{action}_{trial}", the names of AMC
        files as in CMU and HDM05, or an index.csv next to a file or one folder above.
    table : str or path-like, default=None
        A CSV file with a column `file`, relative to its folder, and any of subject, action, trial and
        frames_per_second, Hz, in place of the pattern. Only its files are read. By default index.csv in the folder.
    scale : float or "auto", default="auto"
        Metres per unit of length of BVH files. "auto" chooses for each file: metres if its skeleton is then between 0.3
        and 5 m, else the unit with which it is nearest to 1.7 m.
    on_error : {"warn", "raise"}, default="warn"
        Leave out files that cannot be read, with a warning, or raise the error.
    rotations : {"rotvec", "file"}, default="rotvec"
        Whether joints of two or three Euler angles become ball joints or keep the angles of the files, see
        `MotionDataset`.
    verbose : int, default=0
        Whether to show progress.
    **options
        Options of `skpose.io.load_motion`, such as `frame_rate`, `up` and `model`.

    Returns
    -------
    MotionDataset
        The motions, sorted by the paths of the files, or in the order of the table. Labels are empty where a name does
        not have the pattern, and left out if none has it.

    Raises
    ------
    FileNotFoundError
        If there are no such files.
    MocapFormatError
        If the table does not follow its format.
    ValueError
        If no file can be read, or people differ threefold in size.

    Warns
    -----
    UserWarning
        If files are left out, or names do not have the pattern.

    See Also
    --------
    skpose.io.load_motion : Read one file.
    load_cmu, load_hdm05 : Read these databases.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from skpose.datasets import load_motions, make_gait
    >>> from skpose.io import save_bvh
    >>> with TemporaryDirectory() as folder:
    ...     for name, motion in zip(["ben_walk_1", "ben_run_1"], make_gait(1, 1, random_state=0)):
    ...         save_bvh(Path(folder, f"{name}.bvh"), motion)
    ...     dataset = load_motions(folder)
    >>> dataset
    MotionDataset(2 motions of 1 subjects: 1 run, 1 walk)
    """
    check_choice("on_error", on_error, ("warn", "raise"))
    given = [files] if isinstance(files, str | os.PathLike) else list(files)
    if table is None and pattern is None and len(given) == 1 and is_index(Path(given[0], INDEX)):
        table = Path(given[0], INDEX)
    if table is None:
        rows = rows_of(find_files(given), pattern)
        unnamed = [row["file"] for row in rows if not row.keys() & {"subject", "action", "trial"}]
        if 0 < len(unnamed) < len(rows):
            example = re.sub(r"\{(\w+)\}", lambda match: match[1].upper(), pattern or PATTERN) + unnamed[0].suffix
            complaint = f"expected names such as {example}, got {len(unnamed)} others, such as {unnamed[0].name}"
            if on_error == "raise":
                raise ValueError(complaint)
            warn(complaint)
    else:
        rows = read_index(Path(table))
    return read_rows(rows, on_error, rotations, verbose, {"scale": scale} | options)


def read_rows(
    rows: Sequence[Row], on_error: str, rotations: Rotations, verbose: int, options: dict[str, Any]
) -> MotionDataset:
    """Read the file of each row; options win over the frame rates of rows."""
    motions, kept, failed = [], [], list[Exception]()
    with progress(f"reading {len(rows)} motions", len(rows), verbose) as advance:
        for row in rows:
            try:
                motions.append(load_motion(row["file"], **({"frame_rate": row.get(RATE)} | options)))
                kept.append(row)
            except (OSError, ValueError) as error:
                if on_error == "raise" or len(failed) + 1 == len(rows):
                    raise
                failed.append(error)
            advance()
    if failed:
        warn(f"{len(failed)} of {len(rows)} files are left out, such as {failed[0]}")
    return MotionDataset(motions, **labels_of(kept), rotations=rotations)


def labels_of(rows: Sequence[Row]) -> dict[str, list[str]]:
    """The subjects, actions and trials of rows, "" where unknown; kinds of labels that no row has are left out."""
    kinds = {name: name.removesuffix("s") for name in LABELS}
    return {name: [row.get(key, "") for row in rows] for name, key in kinds.items() if any(key in row for row in rows)}


def find_files(paths: Iterable[PathLike], suffixes: Sequence[str] = MOTIONS) -> list[Path]:
    """Replace folders by the files in them, and below, that have one of the suffixes, sorted; or else by .npz files.

    Patterns such as "*.bvh" are replaced by the files that have them.
    """
    files, ends = [], (*suffixes, *(f"{suffix}.gz" for suffix in suffixes))
    for path in map(Path, paths):
        if not path.is_dir():
            found = (
                [path]
                if path.exists() or not glob.has_magic(str(path))
                else sorted(map(Path, glob.glob(str(path), recursive=True)))
            )
        else:
            inside = [one for one in sorted(path.rglob("[!.]*")) if one.is_file()]
            found = [one for one in inside if one.name.lower().endswith(ends)] or [
                one for one in inside if one.suffix.lower() == ".npz" and not one.name.endswith(NO_MOTIONS)
            ]
        if not found:
            raise FileNotFoundError(f"no files in {path}: expected {', '.join(suffixes)} or .npz")
        files += found
    return files


def rows_of(files: Iterable[Path], pattern: str | None = None) -> list[Row]:
    """What the name of each file states about it; without a pattern, an index near it, whose path is "index"."""
    indexes: dict[Path, dict[str, Row]] = {}
    return [{"file": path} | ((not pattern and _indexed(path, indexes)) or _named(path, pattern)) for path in files]


def _indexed(path: Path, indexes: dict[Path, dict[str, Row]]) -> Row:
    """The row of a file in an index in its folder, or in the one above it; of both the nearer.

    In CMU's layout, subjects/SS/SS_TT.amc, the index is next to "subjects".
    """
    absolute = Path(os.path.abspath(path))
    for folder in absolute.parents[: 3 if absolute.parent.parent.name == "subjects" else 2]:
        index = folder / INDEX
        if folder not in indexes:
            rows = read_index(index) if is_index(index) else []
            indexes[folder] = {os.path.abspath(row["file"]): row for row in rows}
        if row := indexes[folder].get(str(absolute)):
            return row | {"file": path, "index": index}
    return {}


def _named(path: Path, pattern: str | None) -> Row:
    """The labels in the name of a file."""
    match = None if pattern else HDM05.fullmatch(path.name) or CMU.fullmatch(path.name)
    if match is None:
        parts = re.split(r"\{(\w+)\}", pattern or PATTERN)
        fields = [f"(?P<{name}>{'[^/]+' if name == 'action' else '[^_/]+'})" for name in parts[1::2]]
        texts = [re.escape(text) for text in parts[::2]]
        expression = "".join(text + field for text, field in zip(texts, [*fields, ""], strict=True))
        stem = re.sub(r"(\.\w+?)(\.gz)?$", "", path.as_posix(), flags=re.IGNORECASE)
        match = re.fullmatch(rf"(?:.*/)?{expression}", stem)
    row: Row = {} if match is None else dict(match.groupdict())
    return row | ({RATE: float(row[RATE])} if RATE in row else {})


def read_index(path: Path) -> list[Row]:
    """The rows of an index with frame rates as numbers, None if blank, and files as paths."""
    source, rows = Source(path, "an index of motions"), list[Row]()
    with source.format_errors():
        reader = csv.DictReader(source.data.decode().splitlines(keepends=True))
    for row in reader:
        if not row.get("file") or None in row.values():
            raise source.error("expected a column 'file', and a value in each column", reader.line_num)
        rate = (row.get(RATE) or "").strip()
        value = source.number(rate, RATE, reader.line_num) if rate else None
        if value is not None and value <= 0.0:
            raise source.error(f"{RATE}: expected a positive number, found {rate!r}", reader.line_num)
        rows.append(row | {RATE: value, "file": path.parent / row["file"]})
    if not rows:
        raise source.error("the index lists no motions")
    return rows


def is_index(path: Path) -> bool:
    """Whether a file is an index of motions by its head; other programs write files of that name, too."""
    try:
        with path.open("rb") as file:
            head = file.readline(10_000).decode("utf-8-sig", errors="replace")
    except OSError:  # no such file, or in a folder that may not be read
        return False
    columns = set(next(csv.reader([head]), []))
    return "file" in columns and bool(columns & {*COLUMNS} - {"file"})
