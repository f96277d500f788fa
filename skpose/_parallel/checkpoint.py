"""Checkpoints of a matrix that is written piece by piece: notes on the pieces that are complete, as lists of JSON.

Each note holds checksums of the bytes of its piece. A note counts only if the bytes still have these checksums. So
nothing that was half written, lost by the disk or created anew is ever taken for complete, in any order of the writes.
"""

import json
import time
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import Any

from skpose._files import new_file

ATTRIBUTE = "skpose.unfinished"
IDENTITY = "fingerprint"  # key of every head
SECONDS = 5.0  # between two writes of the attributes, which are written as a whole


class FileCheckpoint:
    """Notes in a file next to the matrix: a head, then a line of JSON for each piece."""

    def __init__(self, array_path: Path):
        self.path = Path(f"{array_path}.progress")

    def __str__(self) -> str:
        return f"the file {self.path}"

    def read(self) -> tuple[dict[str, Any], list[list]] | None:
        """Return the head and all notes that are not cut short; None if there are none."""
        try:
            head, *notes = self.path.read_text(encoding="utf-8", errors="replace").split("\n")
        except FileNotFoundError:
            return None
        head = _parsed(head)
        if not isinstance(head, dict) or IDENTITY not in head:
            raise ValueError(f"{self.path} is where skpose keeps its notes, but it holds something else; move it away")
        return head, [note for note in map(_parsed, notes) if isinstance(note, list)]

    def start(self, head: Mapping[str, Any], notes: list[list]) -> None:
        """Replace all earlier notes, or keep all of them if that fails."""
        with new_file(self.path, replace=True) as new:
            new.write_text("".join(json.dumps(line) + "\n" for line in [head, *notes]), encoding="utf-8")

    def add(self, note: list) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(note) + "\n")

    def save(self) -> None:
        """Do nothing: every note is in the file already."""

    def remove(self) -> None:
        """Remove the notes, as the matrix is complete."""
        self.path.unlink(missing_ok=True)  # of two processes that wrote the same, the other may have been faster


def _parsed(line: str) -> Any:
    try:
        return json.loads(line)
    except ValueError:
        return None


class AttributeCheckpoint:
    """Notes in the attributes of the array, as zarr has them."""

    def __init__(self, attributes: MutableMapping):
        self.attributes = attributes
        self._content: dict[str, Any] = {}
        self._saved = 0.0

    def __str__(self) -> str:
        return f"the attribute {ATTRIBUTE!r}"

    def read(self) -> tuple[dict[str, Any], list[list]] | None:
        """Return the head and the notes; None if there are none."""
        content = self.attributes.get(ATTRIBUTE)
        return None if content is None else (content["head"], content["notes"])

    def start(self, head: Mapping[str, Any], notes: list[list]) -> None:
        """Replace all earlier notes."""
        self._content = {"head": head, "notes": [*notes]}
        self.save()

    def add(self, note: list) -> None:
        self._content["notes"].append(note)
        if time.monotonic() - self._saved > SECONDS:
            self.save()

    def save(self) -> None:
        """Write all notes to the attributes."""
        self.attributes[ATTRIBUTE] = self._content
        self._saved = time.monotonic()

    def remove(self) -> None:
        """Remove the notes, as the matrix is complete."""
        del self.attributes[ATTRIBUTE]
