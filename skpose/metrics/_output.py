"""Where a matrix of distances is written, block by block: in memory, in a file, or in an array such as zarr's."""

import hashlib
import json
import mmap
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from typing import Any

import numpy as np

from skpose._parallel.journal import AttributeJournal, FileJournal
from skpose.kinematics._tree import tree_of
from skpose.metrics._convergence import Unconverged
from skpose.metrics._matrix import MIRROR_BLOCK, Block, DistanceMatrix

PAGES_NOT_NEEDED = getattr(mmap, "MADV_DONTNEED", None)  # not on Windows
NOTED = 8  # of a block: its place, two checksums, two numbers of unconverged


class Destination:
    """An array of the user's, or a new one.

    Parameters
    ----------
    array : ndarray, zarr.Array or the like, or None
        None makes an ndarray.
    shape, dtype
        What it must have.
    """

    def __init__(self, array: Any, shape: tuple[int, int], dtype: np.dtype):
        self.array = np.empty(shape, dtype) if array is None else array
        flags = getattr(self.array, "flags", None)
        usable = flags is None or (flags.writeable and flags.aligned)
        found = tuple(getattr(self.array, "shape", ())), getattr(self.array, "dtype", None)
        if found != (shape, dtype) or not usable or getattr(self.array, "read_only", False):
            state = "" if flags is None or flags.writeable else ", read-only"
            raise ValueError(
                f"out must be a writeable {dtype} array of shape {shape}, got "
                f"{type(array).__name__ if found[1] is None else f'{found[1]} {found[0]}{state}'}"
            )
        self._plain = np.asarray(self.array) if isinstance(self.array, np.ndarray) else None
        self._mapping = _mapping_of(self.array)
        self._journal = _journal_of(self.array, self._mapping)

    def part(self, block: Block, dtype: np.dtype) -> np.ndarray | None:
        """The block itself, if distances of this dtype can be written into it at once."""
        return self._plain[block.place] if self._plain is not None and self._plain.dtype == dtype else None

    def write(self, block: Block, distances: np.ndarray, symmetric: bool) -> None:
        """Write a block, unless it is there already, and what mirrors it."""
        if self._plain is None:
            distances = distances.astype(self.array.dtype, copy=False)
            self.array[block.place] = distances
        elif not np.may_share_memory(distances, self._plain):
            self._plain[block.place] = distances
        if symmetric and block.top != block.left:
            self._write_transposed(block.mirrored, distances)
        self._release()

    def _release(self) -> None:
        """Keep what was written or read of a file from staying resident; it goes to the file all the same."""
        if self._mapping is not None and PAGES_NOT_NEEDED is not None:
            self._mapping.madvise(PAGES_NOT_NEEDED)

    def _write_transposed(self, block: Block, distances: np.ndarray) -> None:
        if self._plain is None:
            self.array[block.place] = np.ascontiguousarray(distances.T)
            return
        target = self._plain[block.place]
        for start in range(0, len(target), MIRROR_BLOCK):  # for the cache's sake
            for first in range(0, target.shape[1], MIRROR_BLOCK):
                here = slice(start, start + MIRROR_BLOCK), slice(first, first + MIRROR_BLOCK)
                target[here] = distances[here[1], here[0]].T

    def checksum(self, block: Block) -> int:
        part, known = self.array[block.place], 0
        for start in range(0, len(part), MIRROR_BLOCK):
            known = zlib.crc32(np.ascontiguousarray(part[start : start + MIRROR_BLOCK]), known)
            self._release()  # to read makes more resident than is read
        return known

    @contextmanager
    def resumed(
        self, matrix: DistanceMatrix, edge: int
    ) -> Iterator[tuple[list[Block], list[Unconverged], Callable[[Block, Unconverged], None]]]:
        """The blocks that are left to do, the unconverged about those that are done, and how to note one more.

        Raises
        ------
        ValueError
            If the array holds the beginning of another matrix.
        """
        blocks = matrix.blocks(edge)
        if self._journal is None:
            yield blocks, [], lambda block, unconverged: None
            return
        head = {"of": _fingerprint(matrix), "shape": list(matrix.shape), "metric": matrix.metric, "edge": edge}
        notes = []
        if (found := self._journal.read()) is not None:
            if {**found[0], "edge": edge} != head:
                raise ValueError(
                    f"out holds the beginning of other distances ({found[0].get('metric')}, "
                    f"{found[0].get('shape')}; other poses, a body, parameters or a version of skpose than these): "
                    f"finish those with the call that began them, or delete {self._journal} to write over them"
                )
            head = found[0]
            blocks = matrix.blocks(head["edge"])
            notes = [note for note in found[1] if self._holds(note, matrix.symmetric)]
        self._journal.begin(head, notes)
        done = {Block(*note[:4]) for note in notes}

        def note(block: Block, unconverged: Unconverged) -> None:
            self._journal.add(
                [*block, self.checksum(block), self._mirror_checksum(block, matrix.symmetric), *unconverged]
            )

        try:
            yield [block for block in blocks if block not in done], [Unconverged(*note[6:]) for note in notes], note
        except BaseException:
            self._journal.pause()
            raise
        if isinstance(self.array, np.memmap):
            self.array.flush()
        self._journal.end()

    def _holds(self, note: list, symmetric: bool) -> bool:
        """Whether a block that was noted is what it was."""
        if len(note) != NOTED:
            return False
        block = Block(*note[:4])
        return [self.checksum(block), self._mirror_checksum(block, symmetric)] == note[4:6]

    def _mirror_checksum(self, block: Block, symmetric: bool) -> int:
        return self.checksum(block.mirrored) if symmetric and block.top != block.left else 0


def _mapping_of(array: Any) -> mmap.mmap | None:
    """The file's mapping that an array lies in, if what is written there goes to the file."""
    while isinstance(array, np.ndarray):
        if isinstance(array, np.memmap) and array.mode == "c":
            return None
        array = array.base
    return array if isinstance(array, mmap.mmap) else None


def _journal_of(array: Any, mapping: mmap.mmap | None) -> FileJournal | AttributeJournal | None:
    """Where to take notes: beside the file that an array is the whole of, or with the array; else nowhere."""
    if isinstance(array, np.memmap):
        whole = array.base is mapping and mapping is not None and array.filename is not None
        return FileJournal(array.filename) if whole else None
    return AttributeJournal(array.attrs) if type(array).__module__.split(".")[0] == "zarr" else None


def _fingerprint(matrix: DistanceMatrix) -> str:
    """What a matrix is of, to the last bit."""
    known = hashlib.sha256()
    steps = [float(step) for step in matrix.steps]
    known.update(json.dumps([version("skpose"), matrix.metric, steps, matrix.dtype.str, matrix.symmetric]).encode())
    for array in (matrix.X, *(() if matrix.symmetric else (matrix.Y,)), *tree_of(matrix.skeleton)):
        known.update(json.dumps([array.dtype.str, array.shape]).encode())
        known.update(np.ascontiguousarray(array))
    return known.hexdigest()
