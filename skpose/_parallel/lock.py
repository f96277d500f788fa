"""A lock on a destination, so that two processes, or two threads of one, do not write it at the same time.

The lock is the operating system's, on a file next to the destination: it ends with the process that holds it, however
that ends. The file also says who holds it, and a token: a worker that reads the same token sees the same destination.
"""

import contextlib
import errno
import json
import os
import socket
import sys
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from skpose._compat.joblib import active_backend, while_waiting
from skpose._parallel.checkpoint import companion

HELD = (errno.EAGAIN, errno.EACCES, errno.EDEADLK)  # by another one
NO_LINK = getattr(os, "O_NOFOLLOW", 0)  # a file that a link leads to would be emptied
SECONDS = 0.05  # between two attempts to get a lock that is held
BEYOND = 2**30  # a byte after the text of the file: on Windows nobody can read a byte that is locked

if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        os.lseek(descriptor, BEYOND, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        # Of the open file, not of the process, so that threads exclude each other too, and so that it does not end
        # when something else in this process closes the same file.
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


class Token(NamedTuple):
    """The sign by which a process recognises the destination that another one has locked."""

    path: Path
    value: str

    def obstacle(self) -> str | None:
        """Return why this process does not see the locked destination, None if it does."""
        try:
            found = _content(self.path)
        except OSError as error:
            return f"{self.path} cannot be read there ({error.strerror})"
        return None if found.get("token") == self.value else f"{self.path} is another file there"

    def find_new_holder(self) -> str | None:
        """Return which other process has a lock of this name, after the file of this one was removed; else None."""
        try:
            found = _content(self.path)
        except OSError:
            return None
        if found.get("token") in (None, self.value):
            return None
        return f"{self.path} was removed, and is the lock of {_holder(found)} now"


@contextmanager
def hold_lock(array_path: Path, *, wait: bool = False) -> Iterator[Token]:
    """Hold the lock of a file or a folder, in a file next to it that is removed at the end; yields its token.

    Raises
    ------
    RuntimeError
        If another process or thread holds it. With `wait` it is waited for.
    OSError
        If the file cannot be made, written or locked.
    """
    path = companion(array_path, "lock")
    descriptor = _wait_for(path, array_path) if wait else _open_locked(path, array_path)
    _held.add(descriptor)
    try:
        token = Token(path, uuid.uuid4().hex)
        content = {"process": os.getpid(), "host": socket.gethostname(), "token": token.value}
        try:
            _write(descriptor, json.dumps(content).encode())
        except OSError as error:
            raise _lock_error(error, path, array_path) from None
        yield token
    finally:
        if descriptor in _held:  # not in a process that was forked here
            _held.remove(descriptor)
            _remove(path, descriptor)


def _write(descriptor: int, content: bytes) -> None:
    os.ftruncate(descriptor, 0)
    os.lseek(descriptor, 0, os.SEEK_SET)
    os.write(descriptor, content)
    os.fsync(descriptor)  # so that other hosts see it too


def _remove(path: Path, descriptor: int) -> None:
    """Remove the file, unless it is another one now, and end its lock."""
    if os.name == "posix":  # in this order, so that nobody locks a file that is about to be removed
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                path.unlink()
        os.close(descriptor)
        return
    os.close(descriptor)  # elsewhere an open file cannot be removed
    with contextlib.suppress(OSError):
        path.unlink()


def _open_locked(path: Path, array_path: Path) -> int:
    """Return a descriptor of the lock file, with the lock."""
    while True:
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | NO_LINK, 0o666)
        except OSError as error:
            raise _lock_error(error, path, array_path) from None
        try:
            _lock(descriptor)
        except OSError as error:
            os.close(descriptor)
            if error.errno in HELD:
                raise RuntimeError(_in_use(path, array_path)) from None
            raise OSError(
                error.errno,
                f"{path} cannot be locked ({error.strerror}), so that another process might write the same matrix: "
                "mount the file system with locks, or choose another one",
            ) from None
        with contextlib.suppress(FileNotFoundError):
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        os.close(descriptor)  # its holder removed it after it was opened here


def _wait_for(path: Path, array_path: Path) -> int:
    """Return a descriptor of the lock file, with the lock, once nobody else has it."""
    with contextlib.suppress(RuntimeError):
        return _open_locked(path, array_path)
    with while_waiting(active_backend()):
        while True:
            time.sleep(SECONDS)
            with contextlib.suppress(RuntimeError):
                return _open_locked(path, array_path)


def _lock_error(error: OSError, path: Path, array_path: Path) -> OSError:
    """Return the error of a lock file that cannot be opened or written, with what to do about it."""
    number, reason = error.errno, error.strerror
    if number == errno.ENAMETOOLONG:
        remedy = f"give {array_path.name} a shorter name"
    elif path.is_symlink():
        reason, remedy = "it is a symbolic link, which skpose does not follow", "remove the link"
    elif path.is_dir():
        reason, remedy = "it is a folder", "move it away"
    elif number in (errno.ENOSPC, errno.EDQUOT):
        remedy = "free some space there"
    elif number == errno.ENOENT:
        remedy = f"create the folder {path.parent} again, and {array_path.name} in it"
    elif path.exists() and not os.access(path, os.W_OK):
        remedy = "it may be left over from another user's call: have it removed, once that call has ended"
    else:
        remedy = f"get permission to write in the folder {path.parent}, or choose another one for {array_path.name}"
    return OSError(
        number,
        f"{path} cannot be made ({reason}). It is the lock that keeps two processes from writing {array_path.name} at "
        f"the same time: {remedy}",
    )


def _in_use(path: Path, array_path: Path) -> str:
    try:
        found = _content(path)
    except OSError:
        found = {}
    return (
        f"{array_path} is being written by {_holder(found)}, which holds the lock {path}: wait until it has ended, or "
        "end it; the same call then computes what is missing"
    )


def _holder(found: dict) -> str:
    """Return who holds a lock, in words, by the content of its file."""
    if "process" not in found or "host" not in found:
        return "a process that began just now"
    if (found["process"], found["host"]) == (os.getpid(), socket.gethostname()):
        return f"another thread of this process ({os.getpid()})"
    return f"process {found['process']} on {found['host']}"


def _content(path: Path) -> dict:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


_held: set[int] = set()


def _close_in_child() -> None:
    """Close the locks in a process that was forked: it may live longer than the one that holds them."""
    for descriptor in _held:
        os.close(descriptor)
    _held.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_close_in_child)
