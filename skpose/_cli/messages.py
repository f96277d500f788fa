"""Messages on files: those of one kind as one, with the count of the files."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

MOST_NAMES = 5  # of files in one line
# Not those of a remedy, such as scale=0.01, which is for some files only.
NUMBER = re.compile(r"(?<![\w=.])-?\d[\d.,]*(?:e[+-]?\d+)?")


class Note(NamedTuple):
    """A warning on a file."""

    name: str  # of the file
    text: str
    category: type[Warning] = UserWarning


@dataclass
class Skipped:
    """The files that --skip-errors left out, each with the reason."""

    messages: list[str] = field(default_factory=list)
    n_files: int = 0  # of the command, all of them


def group(notes: Iterable[Note], files: Sequence[str]) -> list[tuple[str, type[Warning]]]:
    """Return one text for the notes that differ in the file and in numbers only; `files` are all of the command."""
    kinds: dict[tuple[str, type[Warning]], dict[str, str]] = {}
    for note in notes:
        text = note.text if len(files) == 1 else note.text.removeprefix(f"{Path(note.name).name}: ")
        kinds.setdefault((NUMBER.sub("#", text), note.category), {}).setdefault(note.name, text)
    found = []
    for (_, category), texts in kinds.items():
        (name, text), *others = texts.items()
        if others:
            of_first = ", of the first" if len({*texts.values()}) > 1 else ""
            text = f"in {count_files(list(texts), files)}{of_first}: {text}"
        elif len(files) > 1:
            text = f"{name}: {text}"
        found.append((text, category))
    return found


def count_files(names: Sequence[str], files: Sequence[str]) -> str:
    """Return how many of the files these are, with some of their names, without the folders if that is clear."""
    if len(names) == 1:
        return names[0]
    if len(names) == len(files):
        return f"all {len(files)} files"
    if len({*map(_base_name, files)}) == len({*files}):
        names = [*map(_base_name, names)]
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return f"{len(names)} of {len(files)} files ({', '.join(names[:MOST_NAMES])}{more})"


def _base_name(name: str) -> str:
    return Path(name).name
