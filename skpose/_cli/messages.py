"""Messages on files: those of one kind as one, with the count of the files."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from skpose._validation.names import near_names

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


def describe(error: BaseException) -> str:
    """Return the message of an error in words, also where the operating system has a number for it."""
    if isinstance(error, MemoryError):
        return str(error) or "not enough memory"
    if not isinstance(error, OSError) or error.errno is None or error.filename is None:
        return str(error) or type(error).__name__
    name = str(error.filename)
    if not isinstance(error, FileNotFoundError):
        return f"{name}: {(error.strerror or type(error).__name__).lower()}"
    if Path(name).is_symlink():
        return f"{name} is a link to a file that does not exist"
    folder = Path(name).parent
    if not folder.is_dir():
        return f"there is no file {name}, as there is no folder {folder}"
    near = near_names([path.name for path in folder.iterdir()], Path(name).name, "")
    return f"there is no file {name}{f': {near}' if near else ', nor one with a similar name'}"


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
