"""A writer of tiles into a zarr array, in a folder that workers can open too, or in any other store."""

import math
import os
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from skpose._files import sync
from skpose.metrics._tiles import MIRROR_EDGE, Tile


class ZarrTarget:
    """A zarr array; it is opened anew, in its folder if there is one, so that a change of the folder is noticed."""

    def __init__(self, array: Any):
        self.path = _folder_of(array)
        self._store = array.store_path if self.path is None else None
        self._format, self._kind = array.metadata.zarr_format, _kind_of(array)
        self.chunk = math.lcm(*_chunks_of(array))

    def obstacle(self, here: bool) -> str | None:
        can_write = self.path is not None and os.access(self.path, os.W_OK)
        return None if can_write else f"{self.path} is missing there, or may not be written"

    def check(self, array: Any) -> None:
        if change := self.change():
            raise ValueError(
                f'out is a zarr array that is not in its store any more: {change}. Open it again with mode="r+"; where '
                "the current folder has changed since, by its absolute path"
            )

    def change(self) -> str | None:
        """Return why what is in the store is not the array that the target was made of; None if it is."""
        where = self.path or self._store
        try:
            found = _kind_of(self._array())
        except Exception as error:  # each store has its own for what it does not have
            return f"{where} cannot be opened as an array ({type(error).__name__}: {error})"
        names = [name for name in {**self._kind, **found} if self._kind.get(name) != found.get(name)]
        return f"{where} is an array with another {' and another '.join(names)}" if names else None

    @contextmanager
    def open_writer(self) -> Iterator["ZarrWriter"]:
        yield ZarrWriter(self._array(), self)

    def _array(self) -> Any:
        import zarr

        if self.path is not None and not self.path.is_dir():
            raise FileNotFoundError(f"there is no folder {self.path}")  # zarr 3.0 would make one
        return zarr.open_array(self.path or self._store, mode="r+", zarr_format=self._format)


class ZarrWriter:
    """Writes into a zarr array."""

    def __init__(self, array: Any, target: ZarrTarget):
        self._array, self._target, self._path = array, target, target.path
        self._written: set[Path] = set()  # files that are not on the disk for sure

    def write(self, tile: Tile, mirrored: Tile | None, distances: np.ndarray) -> list[int]:
        distances = distances.astype(self._array.dtype, copy=False)
        self._put(tile, distances)
        if mirrored is not None:
            self._put(mirrored, np.ascontiguousarray(distances.T))
        return [self._checksum(tile), 0 if mirrored is None else self._checksum(mirrored)]

    def checksums(self, tile: Tile, mirrored: Tile | None) -> list[int] | None:
        try:
            return [self._checksum(tile), 0 if mirrored is None else self._checksum(mirrored)]
        except Exception:  # every codec has errors of its own for bytes that it did not write
            return None

    def sync(self) -> None:
        written, self._written = self._written, set()  # another thread may write meanwhile
        folders = {folder for path in written for folder in path.parents if folder.is_relative_to(self._path or "")}
        for path in (*written, *folders):
            with suppress(FileNotFoundError):  # zarr removes a chunk of zeros
                sync(path)

    def change(self) -> str | None:
        return self._target.change()

    def _put(self, tile: Tile, distances: np.ndarray) -> None:
        self._array[tile.slices] = distances
        if self._path is not None:
            height, width = _chunks_of(self._array)
            for i in range(tile.top // height, -(-tile.bottom // height)):
                for j in range(tile.left // width, -(-tile.right // width)):
                    self._written.add(self._path / self._array.metadata.encode_chunk_key((i, j)))

    def _checksum(self, tile: Tile) -> int:
        """Return the checksum of what can be read, as a codec may round."""
        part, known = self._array[tile.slices], 0
        for start in range(0, len(part), MIRROR_EDGE):
            known = zlib.crc32(np.ascontiguousarray(part[start : start + MIRROR_EDGE]), known)
        return known


def is_zarr(array: Any) -> bool:
    """Return whether this is an array of zarr, without importing zarr."""
    return type(array).__module__.split(".")[0] == "zarr"


def _folder_of(array: Any) -> Path | None:
    """Return the folder of an array in a store that is a folder of this computer."""
    root = getattr(array.store_path.store, "root", None)
    return Path(os.path.realpath(root), array.store_path.path) if isinstance(root, Path) else None


def _kind_of(array: Any) -> dict[str, str]:
    """Return all that zarr needs to know to find and decode the numbers: shape, dtype, chunks, codecs."""
    return {name: repr(value) for name, value in array.metadata.to_dict().items() if name != "attributes"}


def _chunks_of(array: Any) -> tuple[int, int]:
    """Return the shape of what zarr writes at once."""
    return getattr(array, "shards", None) or array.chunks
