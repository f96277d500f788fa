"""Files as streams of bytes: pipes that nobody writes to end, and what gzip unpacks has a limit.

A gzip file of 3 MB may hold 3 GB of blanks. Text of recordings is compressed 2 to 8 times, that of a person who does
not move at all some 200 times, blanks 1,030 times, the most that the format can. So a file may unpack to a hundred
times its size, and each to 64 MB.
"""

import gzip
import io
import os
import stat
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

from skpose.io._arguments import PathLike

LEAST, TIMES = 1 << 26, 100  # what may be unpacked: bytes, and times the packed size
PART = 1 << 13  # bytes of a packed file that are read at once, as what may be unpacked depends on what was read
PATIENCE = 5.0  # s, for a program to open a named pipe for writing


def open_file(path: PathLike) -> IO[bytes]:
    """Open a file for reading. A named pipe is waited for only some seconds, if no program writes to it."""
    if not stat.S_ISFIFO(os.stat(path).st_mode):
        return Path(path).open("rb")
    raw = io.FileIO(os.open(path, os.O_RDONLY | os.O_NONBLOCK))
    until = time.monotonic() + PATIENCE
    while (first := raw.read(1)) == b"":  # None where a program has it open and has written nothing yet
        if time.monotonic() > until:
            raw.close()
            raise TimeoutError(
                f"{os.fspath(path)} is a named pipe that no program writes to: start the program that does, or pass a "
                "file"
            )
        time.sleep(0.01)
    os.set_blocking(raw.fileno(), True)
    return io.BufferedReader(_Pipe(raw, first or b""))


def is_too_much(unpacked: int, packed: int) -> bool:
    """Return whether so many bytes are more than a file of that packed size may hold."""
    return unpacked > max(LEAST, TIMES * packed)


class _Pipe(io.RawIOBase):
    """A pipe of which a byte has been read. Reads are full ones, as the beginning says what a file is."""

    def __init__(self, raw: io.FileIO, first: bytes):
        self._raw, self._first = raw, first

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        n = len(self._first)
        buffer[:n], self._first = self._first, b""
        while n < len(buffer) and (more := self._raw.readinto(memoryview(buffer)[n:])):
            n += more
        return n

    def close(self) -> None:
        self._raw.close()
        super().close()


class Unpacked(io.RawIOBase):
    """The content of a stream that gzip has compressed; `error` makes the exception where it is too much.

    Parameters
    ----------
    packed : file
        The compressed stream.
    error : callable
        Makes an exception of a message.
    """

    def __init__(self, packed: IO[bytes], error: Callable[[str], Exception]):
        self._packed, self._error = _Counted(packed), error
        self._file = gzip.GzipFile(fileobj=self._packed, mode="rb")
        self._n_bytes = 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        n = self._file.readinto(buffer)
        self._n_bytes += n
        if is_too_much(self._n_bytes, self._packed.n_bytes):
            raise self._error(
                f"its gzip compression holds more than {self._n_bytes // 10**6} MB, over {TIMES} times its size, which "
                "no recording does; if it is one nevertheless, decompress it first, with gunzip"
            )
        return n


class _Counted(io.RawIOBase):
    """A stream that counts the bytes that are read."""

    def __init__(self, file: IO[bytes]):
        self._file, self.n_bytes = file, 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        data = self._file.read(min(len(buffer), PART))
        buffer[: len(data)] = data
        self.n_bytes += len(data)
        return len(data)
