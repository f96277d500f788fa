"""Writing a matrix of distances tile by tile: into memory, a file, or an array such as zarr's.

Nothing here knows what is computed. A destination gets a tiling, a fingerprint of what the matrix is of, and the
numbers of each tile, or only the checksums of those that a worker has written.
"""

import mmap
import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

import numpy as np

from skpose._parallel.checkpoint import AttributeCheckpoint, FileCheckpoint
from skpose._parallel.lock import hold_lock
from skpose.metrics._run import PlainRun, ResumedRun
from skpose.metrics._tiles import Tile, Tiling
from skpose.metrics._writers import ArrayWriter, FileTarget
from skpose.metrics._zarr_writer import ZarrTarget, is_zarr


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
        self.array: Any = np.empty(shape, dtype) if array is None else array
        _check(self.array, shape, dtype)
        mapping = _mapping_of(self.array)
        self._plain = ArrayWriter(self.array, mapping)
        self._target = _target_of(self.array, mapping)

    @property
    def resumable(self) -> bool:
        """True for an array that outlives this process, and its checkpoint with it."""
        return self._target is not None

    @property
    def chunk(self) -> int:
        """The edge of the smallest square of which no part can be written alone."""
        return 1 if self._target is None else self._target.chunk

    def view(self, tile: Tile, dtype: np.dtype) -> np.ndarray | None:
        """Return the tile of the array itself, if distances of this dtype can be computed into it."""
        return None if self.resumable else self._plain.view(tile, dtype)

    @contextmanager
    def start_run(self, tiling: Tiling, fingerprint: dict[str, Any] | None) -> Iterator[PlainRun | ResumedRun]:
        """Yield what is left to do, where an earlier call may have done a part of it.

        Parameters
        ----------
        tiling : Tiling
            The tiles, unless earlier notes have others.
        fingerprint : dict
            Equal for equal matrices only: what one depends on by names, for messages; needed if this is `resumable`.

        Raises
        ------
        ValueError
            If the array holds the beginning of another matrix, or its file is no longer where it was.
        RuntimeError
            If another process or thread writes it, or something else changed it meanwhile.
        """
        target = self._target
        if target is None:
            yield PlainRun(tiling, self._plain)
            return
        path = target.path
        with nullcontext() if path is None else hold_lock(path) as token:
            target.check(self.array)
            checkpoint = AttributeCheckpoint(self.array.attrs) if path is None else FileCheckpoint(path)
            with target.open_writer() as writer:
                run = ResumedRun(tiling, fingerprint, target=target, writer=writer, token=token, checkpoint=checkpoint)
                try:
                    yield run
                finally:
                    run.save()
                    checkpoint.save()
                run.check()
            checkpoint.remove()


def _check(array: Any, shape: tuple[int, int], dtype: np.dtype) -> None:
    """Raise an error unless this is an array of this shape and dtype that can be written."""
    expected = f"out must be a writeable {dtype} array of shape {shape}"
    if isinstance(array, str | os.PathLike):
        raise TypeError(
            f"{expected}, got the path {os.fspath(array)!r}: make the file with numpy.lib.format.open_memmap(path, "
            f'mode="w+", dtype={str(dtype)!r}, shape={shape}), or open it with mode="r+", and give that'
        )
    if hasattr(array, "iloc"):  # of pandas and the like, whose items are columns
        raise TypeError(f"{expected}, got a {type(array).__name__}: call without out, and make one of the result")
    found = tuple(getattr(array, "shape", ())), getattr(array, "dtype", None)
    flags = getattr(array, "flags", None)
    read_only = getattr(array, "read_only", False) or (flags is not None and not flags.writeable)
    state = ", read-only" if read_only else ""
    if flags is not None and not flags.aligned:
        state += f", not aligned: begin at a byte that is a multiple of {dtype.alignment}"
    if found != (shape, dtype) or state:
        file = is_zarr(array) or isinstance(array, np.memmap)
        remedy = ': open it with mode="r+"' if read_only and file else ""
        got = type(array).__name__ if found[1] is None else f"{found[1]} {found[0]}{state}"
        raise ValueError(f"{expected}, got {got}{remedy}")


def _mapping_of(array: Any) -> mmap.mmap | None:
    """Return the file's mapping that an array lies in, if what is written there goes to the file."""
    while isinstance(array, np.ndarray):
        if isinstance(array, np.memmap) and array.mode == "c":
            return None
        array = array.base
    return array if isinstance(array, mmap.mmap) else None


def _target_of(array: Any, mapping: mmap.mmap | None) -> FileTarget | ZarrTarget | None:
    """Return the target for an array that is the whole of a file, or zarr's; None for others."""
    if isinstance(array, np.memmap):
        base: Any = array.base  # a mapping too, which numpy's types leave out
        return FileTarget.of(array) if base is mapping and mapping is not None and array.filename is not None else None
    return ZarrTarget(array) if is_zarr(array) else None
