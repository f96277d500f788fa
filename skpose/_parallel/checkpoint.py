"""Checkpoints of a matrix that is written piece by piece: notes on the pieces that are complete, as lists of JSON.

Each note holds checksums of the bytes of its piece. A note counts only if the bytes still have these checksums. So
nothing that was half written, lost by the disk or created anew is ever taken for complete, in any order of the writes.
Notes in a file are on the disk when they have been added; who adds one has seen to the bytes of its piece before.
"""

import json
import os
import time
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import Any

from skpose._files import new_file, sync

ATTRIBUTE = "skpose.unfinished"
IDENTITY = "fingerprint"  # key of every head
SECONDS = 5.0  # between two writes of the attributes, which are written as a whole


def companion(array_path: Path, name: str) -> Path:
    """Return the path of a file that belongs to the file or, as zarr has it, the folder of a matrix."""
    path = Path(os.path.realpath(array_path))  # one for all links to it
    return path / f"skpose.{name}" if path.is_dir() else Path(f"{path}.{name}")


class FileCheckpoint:
    """Notes in a file next to the matrix, or in its folder: a head, then a line of JSON for each piece."""

    def __init__(self, array_path: Path):
        self.path = companion(array_path, "progress")

    def __str__(self) -> str:
        return f"the file {self.path}"

    def read(self) -> tuple[dict[str, Any], list[list]] | None:
        """Return the head and all notes that are not cut short; None if there are none."""
        try:
            head, *notes = self.path.read_text(encoding="utf-8", errors="replace").split("\n")
        except FileNotFoundError:
            return None
        head = _parse(head)
        if not isinstance(head, dict) or IDENTITY not in head:
            raise self.not_notes()
        return head, [note for note in map(_parse, notes) if isinstance(note, list)]

    def not_notes(self) -> ValueError:
        """Return the error for a file that is no notes."""
        return ValueError(f"{self.path} is where skpose keeps its notes, but it holds something else; move it away")

    def start(self, head: Mapping[str, Any], notes: list[list]) -> None:
        """Replace all earlier notes, or keep all of them if that fails."""
        with new_file(self.path, replace=True) as new:
            new.write_text(_lines([head, *notes]), encoding="utf-8")
            sync(new)
        sync(self.path.parent)

    def add(self, notes: list[list]) -> None:
        """Add notes to a file that has been started; raise a FileNotFoundError if it was removed since."""
        with self.path.open("r+", encoding="utf-8") as file:
            file.seek(0, os.SEEK_END)
            file.write(_lines(notes))
            file.flush()
            os.fsync(file.fileno())

    def save(self) -> None:
        """Do nothing: every note is in the file already."""

    def remove(self) -> None:
        """Remove the notes, as the matrix is complete."""
        self.path.unlink(missing_ok=True)


def _lines(contents: list) -> str:
    return "".join(json.dumps(content) + "\n" for content in contents)


def _parse(line: str) -> Any:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):  # the latter of brackets in brackets
        return None


class AttributeCheckpoint:
    """Notes in the attributes of the array, as zarr has them; for stores that are no folder of this computer."""

    def __init__(self, attributes: MutableMapping):
        self.attributes = attributes
        self._content: dict[str, Any] = {}
        self._saved = 0.0

    def __str__(self) -> str:
        return f"the attribute {ATTRIBUTE!r}"

    def read(self) -> tuple[dict[str, Any], list[list]] | None:
        """Return the head and the notes; None if there are none."""
        content = self.attributes.get(ATTRIBUTE)
        if content is None:
            return None
        head, notes = (content.get(key) if isinstance(content, dict) else None for key in ("head", "notes"))
        if not isinstance(head, dict) or IDENTITY not in head or not isinstance(notes, list):
            raise self.not_notes()
        return head, [note for note in notes if isinstance(note, list)]

    def not_notes(self) -> ValueError:
        """Return the error for an attribute that is no notes."""
        return ValueError(f"{self} of out is where skpose keeps its notes, but it holds something else; delete it")

    def start(self, head: Mapping[str, Any], notes: list[list]) -> None:
        """Replace all earlier notes."""
        self._content = {"head": head, "notes": [*notes]}
        self.save()

    def add(self, notes: list[list]) -> None:
        self._content["notes"] += notes
        if time.monotonic() - self._saved > SECONDS:
            self.save()

    def save(self) -> None:
        """Write all notes to the attributes, once there is a start."""
        if self._content:
            self.attributes[ATTRIBUTE] = self._content
            self._saved = time.monotonic()

    def remove(self) -> None:
        """Remove the notes, as the matrix is complete."""
        del self.attributes[ATTRIBUTE]
