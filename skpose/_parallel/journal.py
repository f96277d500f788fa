"""Notes on an unfinished matrix that lies on disk: which of its blocks are done, with the checksums of their bytes.

A block counts as done if its bytes are what was noted. So nothing that was half written, or lost by the disk or by
making the file anew, is ever taken for done, whatever reached the disk first.
"""

import json
import time
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from typing import Any

ATTRIBUTE = "skpose.unfinished"
SECONDS = 5.0  # between notes in attributes, which are written as a whole


class FileJournal:
    """Notes in a file beside the matrix, a line of JSON for each block."""

    def __init__(self, array_path: Path):
        self.path = Path(f"{array_path}.progress")

    def __str__(self) -> str:
        return f"the file {self.path}"

    def read(self) -> tuple[dict[str, Any], list[list]] | None:
        """The head and the notes, but for what was cut short; None if there are none."""
        try:
            head, *notes = self.path.read_text(encoding="utf-8", errors="replace").split("\n")
        except FileNotFoundError:
            return None
        head = _parsed(head)
        if not isinstance(head, dict) or "of" not in head:
            raise ValueError(f"{self.path} is where skpose keeps its notes, but it holds something else; move it away")
        return head, [note for note in map(_parsed, notes) if isinstance(note, list)]

    def begin(self, head: Mapping[str, Any], notes: list[list]) -> None:
        """Forget what was noted before, or keep all of it if that fails."""
        new = self.path.with_name(f"{self.path.name}.new")
        new.write_text("".join(json.dumps(line) + "\n" for line in [head, *notes]), encoding="utf-8")
        new.replace(self.path)

    def add(self, note: list) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(note) + "\n")

    def pause(self) -> None:
        """Nothing more comes for now."""

    def end(self) -> None:
        """The matrix is finished."""
        self.path.unlink(missing_ok=True)  # of two that wrote the same, the other may have ended first


def _parsed(line: str) -> Any:
    try:
        return json.loads(line)
    except ValueError:
        return None


class AttributeJournal:
    """Notes in the attributes of the array, as zarr has them."""

    def __init__(self, attributes: MutableMapping):
        self.attributes = attributes
        self._content: dict[str, Any] = {}
        self._written = 0.0

    def __str__(self) -> str:
        return f"the attribute {ATTRIBUTE!r}"

    def read(self) -> tuple[dict[str, Any], list[list]] | None:
        content = self.attributes.get(ATTRIBUTE)
        return None if content is None else (content["head"], content["notes"])

    def begin(self, head: Mapping[str, Any], notes: list[list]) -> None:
        self._content = {"head": head, "notes": [*notes]}
        self.pause()

    def add(self, note: list) -> None:
        self._content["notes"].append(note)
        if time.monotonic() - self._written > SECONDS:
            self.pause()

    def pause(self) -> None:
        self.attributes[ATTRIBUTE] = self._content
        self._written = time.monotonic()

    def end(self) -> None:
        del self.attributes[ATTRIBUTE]
