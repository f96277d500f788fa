"""Distances between motions that earlier calls have computed, in files of a folder.

Estimators of all folds of a cross-validation, of all processes and of later runs read and add to one folder. A distance
is found by the content of both motions and by all that it depends on besides: what is found is what would be computed,
to the last bit. As the distance from a to b and the one from b to a may differ in the last bit, each is one of its own.

A file, a *block*, holds the distances from some motions to others. It is written whole or not at all, and not changed.
Who computes holds a lock meanwhile, so that processes that begin together do not all compute the same.
"""

import hashlib
import json
import os
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from joblib import Memory, effective_n_jobs

from skpose._files import new_file, sync
from skpose._parallel.lock import hold_lock
from skpose.metrics._shared import Unconverged, digest, mirror
from skpose.motions._inputs import Sequences
from skpose.motions._matrix import MotionMatrix

FOLDER = "skpose_distances"  # in that of the user
WORK_PER_BLOCK = 5e10  # for each thread, some 10 s: lost if it is interrupted


class Block(NamedTuple):
    """Distances from the motions of the rows to those of the columns, and the geodesics that did not converge."""

    rows: np.ndarray  # (n,) digests of motions
    columns: np.ndarray  # (m,)
    distances: np.ndarray  # (n, m) NaN where they were not computed
    unconverged: np.ndarray  # (3,) their number, the largest gap, and the number of all geodesics

    @classmethod
    def load(cls, path: Path) -> "Block":
        try:
            with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
                return cls(*(file[name] for name in cls._fields))
        except (ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(
                f"{path}, which should hold distances that were computed before, is damaged ({error}): delete it, and "
                "they are computed again"
            ) from None

    def save(self, folder: Path) -> Path:
        """Write the block to a file whose name says which distances it has; return its path."""
        path = folder / f"{digest(self.rows, self.columns, np.isnan(self.distances))}.npz"
        with new_file(path, replace=True) as new:
            np.savez(new, **self._asdict())
            sync(new)
        return path


class KnownDistances:
    """The distances of a matrix as far as they are known, and the blocks that they are from."""

    def __init__(self, matrix: MotionMatrix, folder: Path):
        self.matrix = matrix
        self.folder = folder / hashlib.sha256(json.dumps(matrix.kind(), sort_keys=True).encode()).hexdigest()
        self.rows = _digests(matrix.X)
        self.columns = self.rows if matrix.Y is None else _digests(matrix.Y)
        self.distances = np.full(matrix.shape, np.nan, matrix.result_dtype)
        self.unconverged: list[np.ndarray] = []
        self._read: set[Path] = set()

    def missing(self) -> np.ndarray:
        """Return which distances are not known; where the matrix is symmetric, in the triangle that is computed."""
        missing = np.isnan(self.distances)
        return np.triu(missing, 1) if self.matrix.symmetric else missing

    def read(self) -> None:
        """Take what is missing from the files that have not been read yet."""
        for path in set(self.folder.glob("[!.]*.npz")) - self._read:
            self._read.add(path)
            self._take(Block.load(path))

    def compute(self, n_jobs: int | None, verbose: int) -> None:
        """Compute what is missing, and write it into files."""
        most = int(WORK_PER_BLOCK * effective_n_jobs(n_jobs) / self.matrix.work_per_pair)
        new, counts, n_new = np.full_like(self.distances, np.nan), [], 0
        for rows, columns in split(self.missing(), self.matrix.symmetric, most):
            part = self.matrix.part(rows, columns)
            distances, unconverged = part.write(None, n_jobs, verbose)
            if columns is None:
                distances[np.tri(len(rows), dtype=bool)] = np.nan
            new[np.ix_(rows, rows if columns is None else columns)] = distances
            counts.append([*Unconverged.join(unconverged), part.n_cells])
            n_new += part.n_pairs
            if n_new >= most:
                self._add(new, counts)
                new[...], counts, n_new = np.nan, [], 0
        if n_new:
            self._add(new, counts)

    def _add(self, new: np.ndarray, counts: list[list[float]]) -> None:
        """Write a file of new distances, without the motions that have none."""
        rows, columns = (np.flatnonzero(~np.isnan(new).all(axis=axis)) for axis in (1, 0))
        count, gap, n = np.transpose(counts)
        unconverged = np.array([count.sum(), gap.max(), n.sum()])
        block = Block(self.rows[rows], self.columns[columns], new[np.ix_(rows, columns)], unconverged)
        self._read.add(block.save(self.folder))
        self._take(block)

    def _take(self, block: Block) -> None:
        i, k = _find(self.rows, block.rows)
        j, m = _find(self.columns, block.columns)
        known, found = self.distances[np.ix_(i, j)], block.distances[np.ix_(k, m)]
        is_new = np.isnan(known) & ~np.isnan(found)
        if is_new.any():
            self.distances[np.ix_(i, j)] = np.where(is_new, found, known)
            self.unconverged.append(block.unconverged)


def remember_distances(
    matrix: MotionMatrix, folder: Path, n_jobs: int | None, verbose: int
) -> tuple[np.ndarray, list[Unconverged], int]:
    """Return what `MotionMatrix.write` does, of which only what is not in the folder is computed.

    The geodesics that did not converge, and the number of all of them, are those of the blocks that are used.
    """
    rows, row_of = _distinct(matrix.X)
    columns, column_of = (rows, row_of) if matrix.Y is None else _distinct(matrix.Y)
    repeated = len(rows) < len(row_of) or len(columns) < len(column_of)
    known = KnownDistances(matrix.part(rows, columns) if repeated else matrix, folder)
    known.read()
    if known.missing().any():
        known.folder.mkdir(parents=True, exist_ok=True)
        with hold_lock(known.folder, wait=True):
            known.read()
            known.compute(n_jobs, verbose)
    distances = known.distances[np.ix_(row_of, column_of)] if repeated else known.distances
    if matrix.symmetric:
        mirror(distances, effective_n_jobs(n_jobs))
    unconverged = [Unconverged(int(count), float(gap)) for count, gap, _ in known.unconverged]
    return distances, unconverged, int(sum(n for _, _, n in known.unconverged))


def folder_of(memory: Any) -> Path | None:
    """Return the folder of distances of a path or a `joblib.Memory`; None if there is none. A file is refused."""
    location = memory.location if isinstance(memory, Memory) else memory
    if location is None:
        return None
    folder = Path(os.fspath(location)) / FOLDER
    there = next((place for place in (folder, *folder.parents) if place.exists()), None)
    if there is not None and not there.is_dir():
        raise NotADirectoryError(
            f"memory must be a folder for distances, which is made where there is none, got {str(location)!r}: "
            f"{there} is a file"
        )
    return folder


def split(missing: np.ndarray, triangle: bool, most: int) -> Iterator[tuple[np.ndarray, np.ndarray | None]]:
    """Yield rows and columns that make up the missing pairs, about so many at once.

    None for the columns is the triangle of the rows, in which each is paired with the ones after it.
    """
    if triangle:
        rows = np.flatnonzero(missing.any(axis=0) | missing.any(axis=1))
        if 2 * np.count_nonzero(missing) == len(rows) * (len(rows) - 1):
            edge = max(1, most // max(1, len(rows)))
            for first in range(0, len(rows), edge):
                some, others = rows[first : first + edge], rows[first + edge :]
                if len(some) > 1:
                    yield some, None
                if len(others):
                    yield some, others
            return
    patterns, of_row = np.unique(missing, axis=0, return_inverse=True)
    for k, pattern in enumerate(patterns):
        if pattern.any():
            rows, columns = np.flatnonzero(of_row.ravel() == k), np.flatnonzero(pattern)
            edge = max(1, most // len(columns))
            for first in range(0, len(rows), edge):
                yield rows[first : first + edge], columns


def _digests(motions: Sequences) -> np.ndarray:
    return np.array([digest(motions.motion(i)) for i in range(motions.n_motions)], dtype="S64")


def _distinct(motions: Sequences) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of motions that differ in content, and for each motion which of them it is."""
    _, first, kind = np.unique(_digests(motions), return_index=True, return_inverse=True)
    order = np.argsort(first)
    return first[order], np.argsort(order)[kind]


def _find(requested: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the requested motions that are among the known ones, and their indices there."""
    index = {motion: k for k, motion in enumerate(known.tolist())}
    found = [(i, index[motion]) for i, motion in enumerate(requested.tolist()) if motion in index]
    i, k = np.array(found, dtype=int).reshape(-1, 2).T
    return i, k
