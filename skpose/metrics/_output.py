"""Writing a matrix of distances tile by tile: into memory, a file, or an array such as zarr's.

Nothing here knows what is computed. A destination gets a tiling, a fingerprint of what the matrix is of, and the
numbers of each tile; from the checksums of the tiles that a checkpoint lists it finds out which are complete.
"""

import mmap
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from skpose._parallel.checkpoint import IDENTITY, AttributeCheckpoint, FileCheckpoint
from skpose.metrics._convergence import Unconverged
from skpose.metrics._mirror import write_transposed
from skpose.metrics._tiles import Tile, Tiling

PAGES_NOT_NEEDED = getattr(mmap, "MADV_DONTNEED", None)  # not on Windows
ROWS_AT_ONCE = 512  # of a tile that is read for its checksum
NOTE_LENGTH = 8  # of a tile: its four indices, two checksums, the two fields of Unconverged


class Destination:
    """An array of the user's, or a new one.

    Parameters
    ----------
    array : ndarray, zarr.Array or the like, or None
        None makes an ndarray.
    shape, dtype
        The shape and dtype that it must have.
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
        self._checkpoint = _checkpoint_of(self.array, self._mapping)

    @property
    def resumable(self) -> bool:
        """True for an array that outlives this process, and its checkpoint with it."""
        return self._checkpoint is not None

    def view(self, tile: Tile, dtype: np.dtype) -> np.ndarray | None:
        """Return the tile of the array itself, if distances of this dtype can be computed into it."""
        return self._plain[tile.slices] if self._plain is not None and self._plain.dtype == dtype else None

    def write(self, tile: Tile, mirrored: Tile | None, distances: np.ndarray, n_threads: int) -> None:
        """Write the distances of a tile, unless they are its view, and transposed those of its mirror image."""
        if self._plain is None:
            distances = distances.astype(self.array.dtype, copy=False)
            self.array[tile.slices] = distances
        elif not np.may_share_memory(distances, self._plain):
            self._plain[tile.slices] = distances
        if mirrored is not None:
            self._write_transposed(mirrored, distances, n_threads)
        self._release()

    def _release(self) -> None:
        """Give back the memory of the parts of a file that were written or read; the file keeps them."""
        if self._mapping is not None and PAGES_NOT_NEEDED is not None:
            self._mapping.madvise(PAGES_NOT_NEEDED)

    def _write_transposed(self, tile: Tile, distances: np.ndarray, n_threads: int) -> None:
        if self._plain is None:
            self.array[tile.slices] = np.ascontiguousarray(distances.T)
        else:
            write_transposed(distances, self._plain[tile.slices], n_threads)

    @contextmanager
    def resumed(
        self, tiling: Tiling, fingerprint: dict[str, Any] | None
    ) -> Iterator[tuple[list[Tile], list[Unconverged], Callable[[Tile, Unconverged], None]]]:
        """Yield the tiles that are left to do, the unconverged of the others, and how to note that one is complete.

        Parameters
        ----------
        tiling : Tiling
            The tiles, unless earlier notes have others.
        fingerprint : dict
            Equal for equal matrices only: what one depends on by names, for messages; needed if this is `resumable`.

        Raises
        ------
        ValueError
            If the array holds the beginning of another matrix.
        """
        checkpoint = self._checkpoint
        if checkpoint is None:
            yield tiling.tiles(), [], lambda tile, unconverged: None
            return
        head: dict[str, Any] = {IDENTITY: fingerprint, "shape": list(tiling.shape), "edge": tiling.edge}
        notes = []
        if (found := checkpoint.read()) is not None:
            if differences := _differences(found[0], head):
                raise ValueError(
                    f"out holds the beginning of other distances, with another {' and another '.join(differences)}: "
                    "finish those with the call that started them, in the same version or checkout of skpose, or "
                    f"delete {checkpoint} to write over them"
                )
            head = found[0]
            tiling = tiling._replace(edge=head["edge"])
            notes = [note for note in found[1] if self._is_intact(note, tiling)]
        checkpoint.start(head, notes)
        complete = {Tile(*note[:4]) for note in notes}

        def add_note(tile: Tile, unconverged: Unconverged) -> None:
            checkpoint.add([*tile, *self._checksums(tile, tiling), *unconverged])

        try:
            left = [tile for tile in tiling.tiles() if tile not in complete]
            yield left, [Unconverged(*note[6:]) for note in notes], add_note
        except BaseException:
            checkpoint.save()
            raise
        if isinstance(self.array, np.memmap):
            self.array.flush()
        checkpoint.remove()

    def _is_intact(self, note: list, tiling: Tiling) -> bool:
        """Return whether a tile that was noted has the bytes that it had then."""
        return len(note) == NOTE_LENGTH and self._checksums(Tile(*note[:4]), tiling) == note[4:6]

    def _checksums(self, tile: Tile, tiling: Tiling) -> list[int]:
        """Return the checksums of a tile and of its mirror image, 0 if it has none."""
        mirrored = tiling.mirror_of(tile)
        return [self._checksum(tile), 0 if mirrored is None else self._checksum(mirrored)]

    def _checksum(self, tile: Tile) -> int:
        part, known = self.array[tile.slices], 0
        for start in range(0, len(part), ROWS_AT_ONCE):
            known = zlib.crc32(np.ascontiguousarray(part[start : start + ROWS_AT_ONCE]), known)
            self._release()  # to read makes more resident than is read
        return known


def _differences(found: dict[str, Any], expected: dict[str, Any]) -> list[str]:
    """Return the names of what differs between the heads of two checkpoints, but for the edge of the tiles."""
    before, now = ({"shape": head.get("shape"), **_named(head.get(IDENTITY))} for head in (found, expected))
    if before.keys() != now.keys():
        return ["version or checkout of skpose, whose notes have another form"]
    return [name for name in now if before[name] != now[name]]


def _named(fingerprint: Any) -> dict[str, Any]:
    return fingerprint if isinstance(fingerprint, dict) else {}


def _mapping_of(array: Any) -> mmap.mmap | None:
    """Return the file's mapping that an array lies in, if what is written there goes to the file."""
    while isinstance(array, np.ndarray):
        if isinstance(array, np.memmap) and array.mode == "c":
            return None
        array = array.base
    return array if isinstance(array, mmap.mmap) else None


def _checkpoint_of(array: Any, mapping: mmap.mmap | None) -> FileCheckpoint | AttributeCheckpoint | None:
    """Return the checkpoint of an array that is the whole of a file, or that has attributes; None for others."""
    if isinstance(array, np.memmap):
        base: Any = array.base  # a mapping too, which numpy's types leave out
        whole = base is mapping and mapping is not None and array.filename is not None
        return FileCheckpoint(Path(str(array.filename))) if whole else None
    return AttributeCheckpoint(array.attrs) if type(array).__module__.split(".")[0] == "zarr" else None
