"""New files, which are written completely or not at all, and never replace an existing file."""

import csv
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

PathLike = str | os.PathLike


def check_new(path: PathLike) -> None:
    """Refuse a path where no new file can be created, before the work whose result it is to hold.

    Raises
    ------
    OSError
        If the path exists, or its folder does not exist or cannot be written to.
    """
    path = Path(path)
    if os.path.lexists(path):  # also a broken link
        raise FileExistsError(f"{path} already exists: delete it or choose another file")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"{path} cannot be written: the folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK):
        raise PermissionError(f"{path} cannot be written: the folder {path.parent} is read-only")


@contextmanager
def new_file(path: PathLike, *, replace: bool = False) -> Iterator[Path]:
    """Yield a temporary path in the same folder, which is renamed to `path` unless there is an error."""
    path = Path(path)
    if not replace:
        check_new(path)
    temporary = path.with_name(f".{os.urandom(4).hex()}.{path.name}")  # with its suffix, which some writers add
    try:
        yield temporary
        if not replace:
            check_new(path)  # again: it may have been created in the meantime
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def write_csv(path: PathLike, rows: Iterable[Iterable[Any]], *, replace: bool = False) -> None:
    with new_file(path, replace=replace) as new, new.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)
