"""Writers of tiles: into any array of this process, or into a file by position, which workers can do too.

A *target* names a file or a zarr array; it can be sent to a worker. Opened, it is a *writer*. `_zarr_writer` has the
other kind.
"""

import mmap
import os
import threading
import zlib
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from skpose._parallel.file_systems import writes_whole_pages
from skpose.metrics._tiles import MIRROR_EDGE, Tile

PAGES_NOT_NEEDED = getattr(mmap, "MADV_DONTNEED", None)  # not on Windows
pwrite, pread = getattr(os, "pwrite", None), getattr(os, "pread", None)  # not on Windows either
fdatasync = getattr(os, "fdatasync", os.fsync)  # without the file's times; Linux has it
BINARY = getattr(os, "O_BINARY", 0)  # without it Windows changes the ends of lines


class Writer(Protocol):
    """An open target."""

    def write(self, tile: Tile, mirrored: Tile | None, distances: np.ndarray) -> list[int]:
        """Write a tile, and its transpose if it has a mirror image; return the checksums of both, 0 for none."""

    def checksums(self, tile: Tile, mirrored: Tile | None) -> list[int] | None:
        """Return the checksums of what is there now; None if it cannot be read."""

    def sync(self) -> None:
        """Wait until all that was written is on the disk."""

    def change(self) -> str | None:
        """Return why what others find at the path is not what is written here; None if it is."""


class Target(Protocol):
    """A matrix that outlives this process."""

    @property
    def path(self) -> Path | None:
        """The file or folder that other processes can open too, if there is one."""

    @property
    def chunk(self) -> int:
        """The edge of the smallest square of which no part can be written alone."""

    def obstacle(self, here: bool) -> str | None:
        """Return why this process cannot write there, None if it can; `here` is the computer of the client."""

    def check(self, array: Any) -> None:
        """Raise an error unless what is written there is what is in the array."""

    def open_writer(self) -> AbstractContextManager[Writer]:
        """Open it for writing."""


class ArrayWriter:
    """Writes into an array of this process: in memory, a part of a mapped file, or any with items."""

    def __init__(self, array: Any, mapping: mmap.mmap | None):
        self.array, self.mapping = array, mapping
        self.plain = np.asarray(array) if isinstance(array, np.ndarray) else None

    def view(self, tile: Tile, dtype: np.dtype) -> np.ndarray | None:
        """Return the tile of the array itself, if distances of this dtype can be computed into it."""
        return self.plain[tile.slices] if self.plain is not None and self.plain.dtype == dtype else None

    def write(self, tile: Tile, mirrored: Tile | None, distances: np.ndarray) -> None:
        """Write the distances of a tile, unless they are its view, and transposed those of its mirror image."""
        if self.plain is None:
            distances = distances.astype(self.array.dtype, copy=False)
            self.array[tile.slices] = distances
            if mirrored is not None:
                self.array[mirrored.slices] = np.ascontiguousarray(distances.T)
            return
        if not np.may_share_memory(distances, self.plain):
            self.plain[tile.slices] = distances
        if mirrored is not None:
            _transpose(distances, self.plain[mirrored.slices])
        self.release()

    def release(self) -> None:
        """Give back the memory of the parts of a file that were written; the file keeps them."""
        if self.mapping is not None and PAGES_NOT_NEEDED is not None:
            self.mapping.madvise(PAGES_NOT_NEEDED)


class FileTarget(NamedTuple):
    """A matrix in a file from some byte on; row by row, or column by column as Fortran has it."""

    path: Path
    start: int
    shape: tuple[int, int]
    dtype: np.dtype
    by_columns: bool
    chunk: int = 1

    @classmethod
    def of(cls, array: np.memmap) -> "FileTarget":
        path, shape = Path(os.path.realpath(str(array.filename))), (array.shape[0], array.shape[1])
        return cls(path, array.offset, shape, array.dtype, not array.flags.c_contiguous)

    @property
    def n_bytes(self) -> int:
        return self.start + self.shape[0] * self.shape[1] * self.dtype.itemsize

    def obstacle(self, here: bool) -> str | None:
        if not os.access(self.path, os.W_OK):
            return f"{self.path} is missing there, or may not be written"
        if self.path.stat().st_size < self.n_bytes:
            return f"{self.path} is shorter there"
        if not here and (kind := writes_whole_pages(self.path)):
            return f"{self.path} is on {kind}, where two computers cannot write one file, but a zarr array in a folder"
        return None

    def check(self, array: np.memmap) -> None:
        """Change a byte in the array and look for it in the file."""
        seen = []
        if self.obstacle(here=True) is None:
            last = np.asarray(array.T if self.by_columns else array).reshape(-1).view(np.uint8)[-1:]
            with open(self.path, "rb", buffering=0) as file:
                for _ in range(2):  # the second time is as before
                    last ^= 0xFF
                    seen.append(_read(file.fileno(), 1, self.n_bytes - 1) == last.tobytes())
        if not seen or not all(seen):
            raise ValueError(
                f"out is a memory map of a file that is not {self.path} any more, as it was moved, deleted or "
                'replaced: open the file again with mode="r+"'
            )

    @contextmanager
    def open_writer(self) -> Iterator["FileWriter"]:
        descriptor = os.open(self.path, os.O_WRONLY | BINARY)
        try:
            yield FileWriter(self, descriptor)
        finally:
            os.close(descriptor)


class FileWriter:
    """Writes at positions of an open file: half the processor time of page faults, and a full disk is an error."""

    def __init__(self, target: FileTarget, descriptor: int):
        self._target, self._descriptor = target, descriptor
        self._n_columns = target.shape[0 if target.by_columns else 1]
        self._moving = threading.Lock()

    def write(self, tile: Tile, mirrored: Tile | None, distances: np.ndarray) -> list[int]:
        distances = np.ascontiguousarray(distances, self._target.dtype)
        written = [self._put(tile, distances, self._target.by_columns), 0]
        if mirrored is not None:
            written[1] = self._put(mirrored, distances, not self._target.by_columns)
        return written

    def checksums(self, tile: Tile, mirrored: Tile | None) -> list[int] | None:
        try:
            with open(self._target.path, "rb", buffering=0) as file:
                found = [self._checksum(file.fileno(), tile), 0]
                if mirrored is not None:
                    found[1] = self._checksum(file.fileno(), mirrored)
                return found
        except OSError:  # such as a part of the disk that cannot be read
            return None

    def sync(self) -> None:
        fdatasync(self._descriptor)

    def change(self) -> str | None:
        path = self._target.path
        try:
            found = path.stat()
        except OSError as error:
            return f"{path} cannot be found any more ({error.strerror})"
        if not os.path.samestat(found, os.fstat(self._descriptor)):
            return f"{path} is another file now"
        return None if found.st_size >= self._target.n_bytes else f"{path} is shorter now"

    def _put(self, tile: Tile, distances: np.ndarray, transposed: bool) -> int:
        """Write the distances, transposed or not, where the file has this tile; return the checksum."""
        if self._target.by_columns:
            tile = tile.mirrored
        if not transposed:
            self._put_rows(distances, tile.top, tile.left)
            return zlib.crc32(distances)
        known = 0
        for start in range(0, distances.shape[1], MIRROR_EDGE):
            part = distances[:, start : start + MIRROR_EDGE]
            rows = np.empty(part.shape[::-1], part.dtype)
            _transpose(part, rows)
            self._put_rows(rows, tile.top + start, tile.left)
            known = zlib.crc32(rows, known)
        return known

    def _put_rows(self, rows: np.ndarray, top: int, left: int) -> None:
        """Write rows of a tile that begin at this row and column of the file."""
        if rows.shape[1] == self._n_columns:
            rows = rows.reshape(1, -1)  # which are one piece of the file
        for row, numbers in enumerate(rows, top):
            offset, rest = self._offset(row, left), memoryview(numbers).cast("B")
            while rest:
                n_written = self._put_bytes(rest, offset)
                offset, rest = offset + n_written, rest[n_written:]

    def _put_bytes(self, content: memoryview, offset: int) -> int:
        """Write some of the bytes, and return how many: a call of the operating system need not write all."""
        try:
            if pwrite is not None:
                return pwrite(self._descriptor, content, offset)
            with self._moving:
                os.lseek(self._descriptor, offset, os.SEEK_SET)
                return os.write(self._descriptor, content)
        except OSError as error:
            raise OSError(error.errno, f"{self._target.path} cannot be written: {error.strerror}") from None

    def _offset(self, row: int, column: int) -> int:
        return self._target.start + (row * self._n_columns + column) * self._target.dtype.itemsize

    def _checksum(self, descriptor: int, tile: Tile) -> int:
        if self._target.by_columns:
            tile = tile.mirrored
        length, known = (tile.right - tile.left) * self._target.dtype.itemsize, 0
        for row in range(tile.top, tile.bottom):
            known = zlib.crc32(_read(descriptor, length, self._offset(row, tile.left)), known)
        return known


def _read(descriptor: int, length: int, offset: int) -> bytes:
    if pread is not None:
        return pread(descriptor, length, offset)
    os.lseek(descriptor, offset, os.SEEK_SET)
    return os.read(descriptor, length)


def _transpose(distances: np.ndarray, target: np.ndarray) -> None:
    """Copy the transpose, a square at a time for the cache's sake.

    Squares are copied to where their rows are no power of two apart: numbers that are share few places of the cache,
    and to transpose them takes twice as long.
    """
    edge = min(MIRROR_EDGE, max(target.shape))
    square = np.empty((edge, edge + 16), target.dtype)
    for top in range(0, len(target), edge):
        for left in range(0, target.shape[1], edge):
            part = distances[left : left + edge, top : top + edge]
            copied = square[: part.shape[0], : part.shape[1]]
            copied[...] = part
            target[top : top + edge, left : left + edge] = copied.T
