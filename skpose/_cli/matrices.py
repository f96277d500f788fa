"""Matrices of distances with the names of their rows, and graphs of neighbours: as .npz and as CSV files."""

import csv
import re
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_matrix, save_npz

from skpose._cli.targets import is_unfinished
from skpose.datasets import MotionDataset
from skpose.io import MocapFormatError
from skpose.io._shared import Archive, Source, read_array

KEY = "distances"
KIND = "a file of distances: CSV with names of rows and columns, .npz or .npy"
CORNER = re.compile(r"(\S.*), (\S+)")  # the metric and the unit
NEAR_ZERO = 1e-6  # of the largest distance: what a diagonal that is zero may have, as of rounded numbers


class Names(NamedTuple):
    """The names of the rows of a matrix."""

    rows: list[str]  # each once
    files: list[str]
    times: np.ndarray | None  # (n_rows,) of poses in their files, s


class Matrix(NamedTuple):
    """A matrix of distances that has been read."""

    distances: np.ndarray
    names: list[str]
    metric: str  # empty where the file does not state it
    unit: str


def name_motions(dataset: MotionDataset) -> Names:
    """Return the names of rows that are motions: their files, numbered where one is given twice."""
    files = dataset.subjects.tolist()
    return Names(_number(files), files, None)


def name_poses(dataset: MotionDataset) -> Names:
    """Return the names of rows that are poses: the file, and the time in it."""
    rows, files, times = [], [], []
    for file, motion in zip(name_motions(dataset).rows, dataset, strict=True):
        digits = max(3, int(np.ceil(np.log10(motion.frame_rate))) + 1)
        rows += [f"{file} {time:.{digits}f} s" for time in motion.times.tolist()]
        files += [file] * len(motion)
        times += motion.times.tolist()
    return Names(rows, files, np.array(times))


def _number(names: Sequence[str]) -> list[str]:
    """Return names, each once: those that are given again have a number behind them."""
    found: list[str] = []
    for name in names:
        numbered = (name if i == 1 else f"{name} ({i})" for i in count(1))
        found.append(next(one for one in numbered if one not in found))
    return found


def write_matrix(new: Path, D: np.ndarray, names: Names, metric: str, unit: str) -> None:
    """Write a matrix with its names, and what it was measured by, to a new file whose suffix is the format."""
    if new.suffix.lower() == ".npz":
        arrays: dict[str, Any] = {KEY: D, "names": np.array(names.rows), "files": np.array(names.files)}
        if names.times is not None:
            arrays["times"] = names.times
        with new.open("wb") as file:  # to a path numpy adds .npz, also where it ends in .NPZ
            np.savez(file, **arrays, metric=np.array(metric), unit=np.array(unit))
    else:
        rows = ([name, *row.astype(str).tolist()] for name, row in zip(names.rows, D, strict=True))
        _write_table(new, [f"{metric}, {unit}", *names.rows], rows)


def write_graph(new: Path, graph: csr_matrix, names: Sequence[str]) -> None:
    """Write a graph of neighbours with the names of its rows to a new file whose suffix is the format."""
    if new.suffix.lower() == ".npz":
        with new.open("w+b") as file:
            save_npz(file, graph)
            with zipfile.ZipFile(file, "a") as archive, archive.open("names.npy", "w") as member:
                np.lib.format.write_array(member, np.array(names), allow_pickle=False)
    else:
        _write_table(new, ["row", "neighbor", "rank", "distance"], _neighbors_of(graph, names))


def _neighbors_of(graph: csr_matrix, names: Sequence[str]) -> Iterator[list]:
    """Yield the cells of each neighbour, the nearest of each row first."""
    for i, name in enumerate(names):
        here = slice(graph.indptr[i], graph.indptr[i + 1])
        distances, columns = graph.data[here], graph.indices[here]
        for rank, k in enumerate(np.argsort(distances, kind="stable"), start=1):
            yield [name, names[columns[k]], rank, str(distances[k])]


def _write_table(new: Path, header: Sequence, rows: Iterable[Sequence]) -> None:
    with new.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def find_matrix(paths: Sequence[Path]) -> Path | None:
    """Return the path of the file of distances, None if these are files of motions; refuse both together."""
    found = [path for path in paths if path.is_file() and _is_matrix(path)]
    if found and len(paths) > 1:
        raise ValueError(f"{found[0]} holds distances, and needs no other file: pass it alone")
    return found[0] if found else None


def _is_matrix(path: Path) -> bool:
    """Return whether a file holds a matrix of distances, by its beginning, or by the keys of a zip."""
    try:
        with Source(path, KIND, binary=True) as source:
            if source.binary == "zip":
                return KEY in Archive(source).keys
            lines = [_cells(line) for line in source.head.splitlines()[:2]]
            is_table = len(lines) == 2 and len(lines[0]) > 1 and lines[0][1:2] == lines[1][:1]
            return source.binary == "npy" or (source.binary is None and is_table)
    except MocapFormatError:  # which the reader of motions reports
        return False


def read_matrix(path: Path) -> Matrix:
    """Read a matrix of distances, as `write_matrix` wrote it, as pandas writes a table with its names, or as .npy."""
    if is_unfinished(path):
        raise ValueError(f"{path} is unfinished: run the command that started it again, which continues it")
    with Source(path, KIND, binary=True) as source:
        if source.binary == "npy":
            D = read_array(source, (None, None))
            matrix = Matrix(D, [str(i) for i in range(len(D))], "", "")
        elif source.binary == "zip":
            file = Archive(source)
            n = file.shape(KEY)[:1]
            matrix = Matrix(file.numbers(KEY, (*n, *n)), file.texts("names", n), *_read_metric(file))
        else:
            matrix = _read_table(source)
        _check_distances(source, matrix)
        return matrix


def _read_metric(file: Archive) -> tuple[str, str]:
    metric, unit = (file.texts(key, ())[0] if key in file.keys else "" for key in ("metric", "unit"))
    return metric, unit


def _read_table(source: Source) -> Matrix:
    corner, *names = _cells(source.readline() or "")
    D = np.empty((len(names), len(names)))
    row = 0
    while (line := source.readline()) is not None:
        if not line.strip():
            continue
        name, *cells = _cells(line)
        if row == len(names) or name != names[row] or len(cells) != len(names):
            expected = f"{names[row]!r} and {len(names)} numbers" if row < len(names) else "the end of the table"
            raise source.error(f"expected {expected}, found {name!r} and {len(cells)} cells", source.line)
        try:
            D[row] = [float(cell) for cell in cells]
        except ValueError as error:
            raise source.error(f"expected distances: {error}", source.line) from None
        row += 1
    if row < len(names):
        raise source.error(f"expected a row for each of the {len(names)} columns, found {row}")
    match = CORNER.fullmatch(corner)
    return Matrix(D, names, match[1] if match else "", match[2] if match else "")


def _check_distances(source: Source, matrix: Matrix) -> None:
    """Refuse what cannot be distances."""
    D = matrix.distances
    if D.shape[0] != D.shape[1]:
        raise source.error(f"expected as many rows as columns, found {D.shape[0]:,} × {D.shape[1]:,}")
    if not np.isfinite(D).all() or (D < 0.0).any():
        i, j = np.argwhere(~(np.isfinite(D) & (D >= 0.0)))[0]
        raise source.error(
            f"expected distances, finite and zero or more, found {D[i, j]} of {matrix.names[i]!r} and "
            f"{matrix.names[j]!r}"
        )
    if D.size and np.abs(D.diagonal()).max() > NEAR_ZERO * D.max():
        i = int(np.abs(D.diagonal()).argmax())
        raise source.error(
            f"expected distances, which are zero of each row to itself, found {D[i, i]} of {matrix.names[i]!r}; are "
            "these similarities?"
        )


def _cells(line: str) -> list[str]:
    try:
        return next(csv.reader([line.rstrip("\r\n")]), [])
    except csv.Error:  # a cell of more than 131,072 characters
        return line.split(",")
