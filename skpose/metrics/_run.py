"""A matrix in progress: the tiles that are left, the notes on the others, and the worker's part of the writing.

A tile is noted when its bytes are on the disk, with their checksums. A note of an earlier call counts if the bytes
still have these.
"""

import functools
import socket
import time
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from skpose._parallel.backends import from_workers
from skpose._parallel.checkpoint import IDENTITY, AttributeCheckpoint, FileCheckpoint
from skpose._parallel.file_systems import computer
from skpose._parallel.lock import Token
from skpose._parallel.threads import in_threads, one_behind
from skpose._warnings import warn
from skpose.metrics._convergence import Unconverged
from skpose.metrics._tiles import Tile, Tiling
from skpose.metrics._writers import ArrayWriter, Target, Writer

NOTE_LENGTH = 8  # of a tile: its four indices, two checksums, the two fields of Unconverged
LARGEST_EDGE = 2**31  # of tiles in notes, which may be longer than the matrix
SAMPLE = 32  # tiles that are read again at the end, at most; and no more than one of eight, but the first and the last
SECONDS = 1.0  # between two times that tiles are noted, at least

Checkpoint = FileCheckpoint | AttributeCheckpoint
Note = tuple


class Computed(NamedTuple):
    """A tile that has been computed: its distances, or the checksums of those that a worker has written."""

    unconverged: Unconverged
    distances: np.ndarray | None
    checksums: list[int] | None = None
    obstacle: str | None = None  # why a worker did not write it


class WorkerOutput(NamedTuple):
    """The destination as it is sent to workers."""

    target: Target
    token: Token
    tiling: Tiling
    client: str  # the computer of this process

    def obstacle(self) -> str | None:
        """Return why this worker does not see, or cannot write, the destination that the token is of; else None."""
        obstacle = self.token.obstacle() or self.target.obstacle(here=self.client == computer())
        return obstacle and f"{socket.gethostname()}: {obstacle}"

    def write(self, tile: Tile, distances: np.ndarray, unconverged: Unconverged) -> Computed:
        """Write a tile, or return it to be written if this worker does not see the destination."""
        if obstacle := self.obstacle():
            return Computed(unconverged, distances, obstacle=obstacle)
        with self.target.open_writer() as writer:
            checksums = writer.write(tile, self.tiling.mirror_of(tile), distances)
            writer.sync()
        return Computed(unconverged, None, checksums)

    def is_intact(self, note: Note) -> bool | None:
        """Return whether a noted tile has the bytes that it had then; None if this worker does not see it."""
        if self.obstacle():
            return None
        with self.target.open_writer() as writer:
            return _is_intact(writer, self.tiling, note)


class PlainRun:
    """All tiles of an array of this process, without notes."""

    output = None  # workers cannot write into the memory of this process

    def __init__(self, tiling: Tiling, writer: ArrayWriter):
        self.tiling, self._writer = tiling, writer
        self.tiles = tiling.tiles()
        self.unconverged: list[Unconverged] = []

    def resume(self, n_jobs: int | None, n_threads: int, remote: bool) -> None:
        """Leave no tile out."""

    def complete(self, results: Iterable[tuple[Tile, Computed]]) -> Generator[None, None, None]:
        """Write each tile; yields once for each."""
        for tile, computed in results:
            if computed.distances is not None:
                self._writer.write(tile, self.tiling.mirror_of(tile), computed.distances)
            self.unconverged.append(computed.unconverged)
            yield


class ResumedRun:
    """The tiles of a file or an array of zarr's that are left, with notes on those that are complete.

    Parameters
    ----------
    tiling : Tiling
        The tiles, unless earlier notes have others.
    fingerprint : dict
        Identifies the matrix.
    target, writer : Target, Writer
        The destination, and what writes the tiles that no worker does.
    token : Token or None
        Its lock, where other processes can open it.
    checkpoint : FileCheckpoint or AttributeCheckpoint
        Keeps the notes.

    Raises
    ------
    ValueError
        If there are notes on another matrix.
    """

    def __init__(
        self,
        tiling: Tiling,
        fingerprint: dict[str, Any] | None,
        *,
        target: Target,
        writer: Writer,
        token: Token | None,
        checkpoint: Checkpoint,
    ):
        self._head: dict[str, Any] = {IDENTITY: fingerprint, "shape": list(tiling.shape), "edge": tiling.edge}
        self._noted: list[Note] = []
        if (found := checkpoint.read()) is not None:
            if differences := _differences(found[0], self._head):
                raise ValueError(
                    f"out holds the beginning of other distances, with another {' and another '.join(differences)}: "
                    "finish those with the call that started them, in the same version or checkout of skpose, or "
                    f"delete {checkpoint} to write over them"
                )
            self._head = found[0]
            edge: Any = self._head.get("edge")
            if not _is_integer(edge) or not 0 < edge <= LARGEST_EDGE:
                raise checkpoint.not_notes()
            tiling = tiling._replace(edge=edge)
            self._noted = _select_valid(found[1], tiling)
        self.tiling, self._writer, self._checkpoint = tiling, writer, checkpoint
        self.output = None if token is None else WorkerOutput(target, token, tiling, computer())
        self._token = token
        self.tiles: list[Tile] = []
        self.unconverged: list[Unconverged] = []
        self._notes: list[list] = []  # on all tiles that are complete, saved or not
        self._pending: list[list] = []  # notes that are not saved
        self._on_disk = True  # all that this process wrote of these
        self._saved = time.monotonic()
        self._saver = ThreadPoolExecutor(1)
        self._saving: Future[None] | None = None

    def resume(self, n_jobs: int | None, n_threads: int, remote: bool) -> None:
        """Leave out the noted tiles that still have the bytes that they had then; workers read, if they compute."""
        self.output = self._for_workers() if remote else None
        results: Iterable[tuple[Note, bool | None]]
        if self.output is not None and self._noted:
            results = from_workers(WorkerOutput.is_intact, self.output, self._noted, n_jobs)
        else:
            results = in_threads((functools.partial(self._check_note, note) for note in self._noted), n_threads)
        results = (self._check_note(note) if intact is None else (note, intact) for note, intact in results)
        notes = [list(note) for note, intact in results if intact]
        self._checkpoint.start(self._head, notes)
        complete = {Tile(*note[:4]) for note in notes}
        self.tiles = [tile for tile in self.tiling.tiles() if tile not in complete]
        self.unconverged = [Unconverged(*note[6:]) for note in notes]
        self._notes = [*notes]

    def _check_note(self, note: Note) -> tuple[Note, bool]:
        return note, _is_intact(self._writer, self.tiling, note)

    def _for_workers(self) -> WorkerOutput | None:
        """Return the destination as it is sent to workers; None, and a warning, if two of them would share a chunk."""
        output, edge = self.output, self.tiling.edge
        if output is None or self.tiling.is_in_chunks(output.target.chunk):
            return output
        warn(
            f"workers cannot write into out: its chunks do not fit into tiles of {edge:,} × {edge:,}, and two writers "
            "of one chunk lose data. This process writes all tiles, at the speed of one: create the array with chunks "
            f"of ({edge}, {edge}), or of a divisor of that"
        )
        return None

    def complete(self, results: Iterable[tuple[Tile, Computed]]) -> Generator[None, None, None]:
        """Write and note each tile, while the next one is computed; yields once for each."""
        yield from one_behind(self._finish, _warn_if_not_written(results))

    def save(self) -> None:
        """Wait until the disk has all tiles that are complete, and note them; for the end."""
        with self._saver:
            if self._saving is not None:
                self._saving.result()
        if self._pending:
            self._save(self._pending, self._on_disk)

    def check(self) -> None:
        """Raise an error if something else changed the destination meanwhile; for the end.

        The file at the path must be the one that was written, and a sample of its tiles have their bytes. A file that
        was emptied has lost the first tiles, so that they are in the sample.

        Raises
        ------
        RuntimeError
            If so. The notes are kept.
        """
        n_tiles = len(self._notes)
        n_read = min(n_tiles, max(2, min(SAMPLE, n_tiles // 8)))
        sample = [tuple(self._notes[i]) for i in np.linspace(0, n_tiles - 1, n_read).astype(int)]
        change = self._find_new_holder() or self._writer.change()
        if change is None and not all(_is_intact(self._writer, self.tiling, note) for note in sample):
            change = "a complete tile does not have the numbers any more that were written"
        if change is not None:
            raise self._change_error(change)

    def _find_new_holder(self) -> str | None:
        return None if self._token is None else self._token.find_new_holder()

    def _change_error(self, change: str) -> RuntimeError:
        return RuntimeError(
            f"out was changed by something else while it was being written: {change}. The notes on complete tiles are "
            f"kept in {self._checkpoint}. Find what wrote there, such as a second start of a script that creates out "
            'again; then open out with mode="r+" and make the same call, which computes what is missing'
        )

    def _finish(self, result: tuple[Tile, Computed]) -> None:
        tile, computed = result
        checksums = computed.checksums
        if computed.distances is not None:
            self._on_disk = False
            checksums = self._writer.write(tile, self.tiling.mirror_of(tile), computed.distances)
        self.unconverged.append(computed.unconverged)
        note = [*tile, *(checksums or ()), *computed.unconverged]
        self._notes.append(note)
        self._pending.append(note)
        if time.monotonic() - self._saved > SECONDS and (self._saving is None or self._saving.done()):
            if self._saving is not None:
                self._saving.result()  # raises its error
            # In a thread of its own: the next tile is written while the disk is at work on the last ones.
            self._saving = self._saver.submit(self._save, self._pending, self._on_disk)
            self._pending, self._on_disk = [], True

    def _save(self, notes: list[list], on_disk: bool) -> None:
        if not on_disk:
            self._writer.sync()
        if taken := self._find_new_holder():  # the notes are another call's too
            raise self._change_error(taken)
        try:
            self._checkpoint.add(notes)
        except FileNotFoundError:  # removed meanwhile
            with suppress(FileNotFoundError):  # with its folder: the next write or the last check says what happened
                self._checkpoint.start(self._head, [*self._notes])
        self._saved = time.monotonic()


def _select_valid(notes: list[list], tiling: Tiling) -> list[Note]:
    """Return the notes on tiles of this tiling, the last one on each: a file may hold anything."""
    return list({note[:4]: note for note in map(tuple, notes) if _is_valid(note, tiling)}.values())


def _is_valid(note: Note, tiling: Tiling) -> bool:
    if len(note) != NOTE_LENGTH or not all(map(_is_integer, note[:7])) or type(note[7]) not in (int, float):
        return False
    tile = Tile(*note[:4])
    return note[6] >= 0 and tiling.has(tile)


def _is_integer(number: Any) -> bool:
    return type(number) is int  # True is another type


def _is_intact(writer: Writer, tiling: Tiling, note: Note) -> bool:
    tile = Tile(*note[:4])
    return writer.checksums(tile, tiling.mirror_of(tile)) == [*note[4:6]]


def _warn_if_not_written(results: Iterable[tuple[Tile, Computed]]) -> Iterator[tuple[Tile, Computed]]:
    """Warn, once, if a worker could not write."""
    warned = False
    for tile, computed in results:
        if computed.obstacle is not None and not warned:
            warned = True
            warn(
                f"a worker cannot write into out, on {computed.obstacle}. Such tiles are sent to this process, which "
                "writes them, at the speed of one: let workers see the same folder, under the same path"
            )
        yield tile, computed


def _differences(found: dict[str, Any], expected: dict[str, Any]) -> list[str]:
    """Return the names of what differs between the heads of two checkpoints, but for the edge of the tiles."""
    before, now = ({"shape": head.get("shape"), **_as_dict(head.get(IDENTITY))} for head in (found, expected))
    if before.keys() != now.keys():
        return ["version or checkout of skpose, whose notes have another form"]
    return [name for name in now if before[name] != now[name]]


def _as_dict(fingerprint: Any) -> dict[str, Any]:
    return fingerprint if isinstance(fingerprint, dict) else {}
