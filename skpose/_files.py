"""New files: written whole or not at all, and never over one that exists; and files that are on the disk for sure."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PathLike = str | os.PathLike


def check_new(path: PathLike) -> None:
    """Raise an error unless a file can be created here; for before the work whose result it is to hold.

    Raises
    ------
    OSError
        If there is a file or a folder of this name, or if the folder for it is missing or cannot be written to.
    """
    path = Path(path)
    if os.path.lexists(path):  # a link that leads nowhere is a file too
        raise FileExistsError(f"{path} already exists: delete it or choose another file")
    folder = path.parent
    if not folder.exists():
        raise FileNotFoundError(f"{path} cannot be written: there is no folder {folder}; create it first")
    if not folder.is_dir():
        raise NotADirectoryError(f"{path} cannot be written: {folder} is a file, not a folder; choose another folder")
    probe = _temporary_name(path)  # permissions do not say all: a whole disk may be read-only
    try:
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        raise type(error)(f"{path} cannot be written: {error.strerror}; choose another folder") from None


@contextmanager
def new_file(path: PathLike, *, replace: bool = False) -> Iterator[Path]:
    """Yield a temporary path in the same folder: what is written there becomes the file, unless there is an error.

    `replace` is for files that are this library's own, such as notes.
    """
    path = Path(path)
    if not replace:
        check_new(path)
    temporary = _temporary_name(path)
    try:
        yield temporary
        if replace:
            temporary.replace(path)
        else:
            _rename_to_new(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def sync(path: PathLike) -> None:
    """Wait until a file, or the list of the files of a folder, is on the disk."""
    is_folder = os.path.isdir(path)
    if is_folder and os.name != "posix":  # Windows opens no folders
        return
    descriptor = os.open(path, os.O_RDONLY if is_folder else os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def created_meanwhile_error(path: PathLike) -> FileExistsError:
    """Return the error that a file exists, which did not when it was checked."""
    return FileExistsError(f"{path} has been created by something else in the meantime: choose another file")


def _rename_to_new(temporary: Path, path: Path) -> None:
    """Rename a file, unless there is one of the new name. A link and its check are one step, a replacement is not."""
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise created_meanwhile_error(path) from None
    except OSError:  # not every file system has links
        if os.path.lexists(path):
            raise created_meanwhile_error(path) from None
        temporary.replace(path)
    else:
        temporary.unlink()


def _temporary_name(path: Path) -> Path:
    """Return a new name next to the path, hidden, with the same suffix: some writers add one where it is missing."""
    return path.with_name(f".{os.urandom(4).hex()}.{path.name}")
