"""A text file as lines, words and numbers, and the errors that name a position in it."""

import gzip
import io
import os
import re
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO, Any, Literal, NamedTuple, Self

import numpy as np

from skpose._validation.units import complaint_of_extent, complaint_of_size
from skpose._warnings import warn
from skpose.io._arguments import Readable
from skpose.io._error import MocapFormatError
from skpose.io._opening import Unpacked, open_file
from skpose.io._robot_kind import robot_kind
from skpose.io._words import NUMBER, Token, complaint
from skpose.skeleton import Skeleton
from skpose.skeleton._shared import size_of

ZIP = (b"PK\x03\x04", b"PK\x05\x06")  # the first bytes of an archive, and of one without members
NPY = b"\x93NUMPY"
C3D = re.compile(rb"(?!%PDF|\x89PNG)[^\0]P", re.DOTALL)  # the block of the parameters, and 80
C3D_HEADER = 512  # bytes, some of which are zero in every C3D file, and in no text
NEWLINE = ord("\n")
HEAD = 1 << 18  # bytes, at most, that say what a file is
CHUNK = 1 << 18  # bytes of lines that are read at once: enough for numpy's parser, and they fit the cache
WORD = re.compile(r"\S+")  # as str.split separates them


class Chunk(NamedTuple):
    """Consecutive lines of a file, and the position of the first."""

    line: int  # from 1
    column: int  # characters of the first line that are left out
    text: bytes

    @property
    def lines(self) -> list[bytes]:
        """The lines with their ends; made at each call."""
        return _lines_of(self.text)

    def words(self) -> Iterator[Token]:
        """Yield the words with their positions; slow, for error messages only."""
        for i, text in enumerate(self.lines):
            start = 0
            for word in text.split():
                start = text.index(word, start)
                column = start + 1 + (self.column if i == 0 else 0)
                yield Token(word.decode("utf-8", errors="replace"), self.line + i, column)
                start += len(word)


class Source:
    """A text file that is read once from start to end, and the errors that name it.

    Parameters
    ----------
    file : str, path-like or file
        The path, or the open file, of text or of bytes, read from its current position; compressed by gzip or not.
    kind : str
        What the file should be, such as "a BVH file".
    binary : bool, default=False
        Whether it may also be a binary file of a kind that some reader knows.

    Attributes
    ----------
    head : str
        The beginning, as text.
    binary : {"zip", "npy", "C3D"} or None
        The kind of a binary file, which `seekable` returns.
    """

    def __init__(self, file: Readable, kind: str, *, binary: bool = False):
        self.line = 0  # number of the last line read
        self._lines: Iterator[bytes] = iter(())
        with ExitStack() as closing:
            if isinstance(file, str | os.PathLike):
                self.name = os.fspath(file)
                stream: Any = closing.enter_context(open_file(file))
            elif hasattr(file, "read"):
                self.name = str(getattr(file, "name", "the open file"))
                stream = _as_bytes(file)
            else:
                raise TypeError(f"expected a path or an open file to read, got {type(file).__name__}")
            with self._gzip_errors():
                self._packed = stream.peek(2)[:2] == b"\x1f\x8b"
                if self._packed:
                    stream = io.BufferedReader(Unpacked(stream, self.error), HEAD)
                head = stream.peek(HEAD)
                self.head = head.removeprefix(b"\xef\xbb\xbf").decode("utf-8", errors="replace")
                self.binary = _binary_kind(head) if binary else None
                if not self.binary and (problem := _other_kind(head)):
                    raise self.error(f"{problem} not {kind}")
                if not self.binary and b"\r" in head and b"\n" not in head:  # lines end as on an old Macintosh
                    stream = io.BytesIO(stream.read().replace(b"\r", b"\n"))
            self._stream = stream
            self._closing = closing.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._closing.close()

    @contextmanager
    def _gzip_errors(self) -> Iterator[None]:
        try:
            yield
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise self.error(f"its gzip compression is damaged or cut short: {error}") from None

    def seekable(self) -> IO[bytes]:
        """Return the whole file, of which nothing has been read, as one in which any position can be read."""
        if self._packed:
            if self.binary == "zip":
                raise self.error("a zip archive compressed by gzip once more: decompress it first, with gunzip")
            with self._gzip_errors():
                return io.BytesIO(self._stream.read())
        return self._stream if self._stream.seekable() else io.BytesIO(self._stream.read())

    def readline(self) -> str | None:
        """Return the next line, with its end; None after the last."""
        line = next(self._lines, None)
        if line is None:
            self._lines = iter(_lines_of(self._read_text()))
            line = next(self._lines, None)
            if line is None:
                return None
        self.line += 1
        # Names in these files may be in any encoding; numbers and keywords are ASCII.
        return line.decode("utf-8", errors="replace")

    def _read_text(self) -> bytes:
        """Return some whole lines, nothing after the last."""
        with self._gzip_errors():
            text = self._stream.read(CHUNK)
            if not text.endswith(b"\n"):
                text += self._stream.readline()
        return text.removeprefix(b"\xef\xbb\xbf") if self.line == 0 else text

    def chunks(self) -> Iterator[Chunk]:
        """Yield all further lines, many at a time."""
        text = b"".join(self._lines) or self._read_text()
        while text:
            yield Chunk(self.line + 1, 0, text)
            self.line += n_lines(text) + (not text.endswith(b"\n"))
            text = self._read_text()

    def statements(self) -> Iterator[list[Token]]:
        """Yield the words of each further line that has any, without round brackets."""
        while (text := self.readline()) is not None:
            if tokens := self.words(text.replace("(", " ").replace(")", " "), self.line):
                yield tokens

    @staticmethod
    def words(text: str, line: int) -> list[Token]:
        """Return the words of a line, without its comment."""
        return [Token(m[0], line, m.start() + 1) for m in WORD.finditer(text.partition("#")[0])]

    def error(self, message: str, at: Token | int | None = None) -> MocapFormatError:
        """Return the error that names this file, and a word or a line of it."""
        if isinstance(at, Token):
            return MocapFormatError(self.name, at.line, message, at.column)
        return MocapFormatError(self.name, at, message)

    def number(self, token: Token, what: str, *, finite: bool = True) -> float:
        """Return a word as a number, never NaN."""
        value = float(token) if NUMBER.fullmatch(token) else np.nan
        if np.isnan(value) or (finite and np.isinf(value)):
            raise self.error(f"{what}: {complaint(token)}", token)
        return value

    def positive(self, token: Token, what: str) -> float:
        """Return a word as a number above zero whose inverse is finite."""
        value = self.number(token, what)
        if value <= 0 or not np.isfinite(1.0 / value):
            raise self.error(f"{what}: expected a positive number, found {str(token)!r}", token)
        return value

    def warn(self, message: str) -> None:
        """Emit a warning that names this file, at the line of the caller outside this library."""
        warn(f"{Path(self.name).name}: {message}")

    def warn_of_size(self, skeleton: Skeleton, scale: float) -> None:
        """Warn if the file's skeleton, at so many metres a unit, has not the size of a person."""
        if message := complaint_of_size(size_of(skeleton), scale):
            self.warn(message)

    def warn_of_extent(self, positions: np.ndarray, scale: float) -> None:
        """Warn if the file's points, at so many metres a unit, are not as far apart as those of a person."""
        if message := complaint_of_extent(positions, scale):
            self.warn(message)

    @contextmanager
    def format_errors(self) -> Iterator[None]:
        """Turn every ValueError, as of Skeleton, Motion and numbers past 1e308, into one that names this file."""
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                yield
        except MocapFormatError:
            raise
        except ValueError as error:
            raise self.error(str(error)) from None


def n_lines(text: bytes) -> int:
    """Return the number of line ends; six times as fast as bytes.count where lines are short."""
    return int(np.count_nonzero(np.frombuffer(text, np.uint8) == NEWLINE))


def _lines_of(text: bytes) -> list[bytes]:
    """Return the lines with their ends, which bytes.splitlines would see at carriage returns, too."""
    return io.BytesIO(text).readlines()


def _binary_kind(head: bytes) -> Literal["zip", "npy", "C3D"] | None:
    if head.startswith(ZIP):
        return "zip"
    if head.startswith(NPY):
        return "npy"
    return "C3D" if _is_c3d(head) else None


def _is_c3d(head: bytes) -> bool:
    return C3D.match(head) is not None and b"\0" in head[:C3D_HEADER]


def _other_kind(head: bytes) -> str | None:
    """Return the start of the message on a file that holds no text, or text of another kind; None if neither."""
    if not head.strip() and len(head) < 4096:  # more blanks than that are the start of something
        return "the file is empty,"
    if head.startswith(b"version https://git-lfs"):
        return "this is a pointer of Git LFS; get the file itself with git lfs pull. It is"
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "this is UTF-16 text; save it as UTF-8. It is"
    if head.startswith(ZIP):
        return "this is a zip archive,"
    if _is_c3d(head):
        return "this is a C3D file, which load_c3d reads,"
    if re.match(rb"\x80[\x02-\x05]", head):
        return "this is a pickle, which could run any program and is never read,"
    if b"\0" in head:
        return "this is a binary file,"
    if head.lstrip().startswith(b"<"):
        kind = robot_kind(head.decode("utf-8", errors="replace"))
        return f"this is a robot ({kind}), which load_robot reads," if kind else "this is a web page or XML,"
    return None


class _Bytes(io.RawIOBase):
    """Any object with a read method, for io.BufferedReader, which then leaves it open."""

    def __init__(self, file: IO[bytes]):
        self._file = file

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        data = self._file.read(len(buffer))
        buffer[: len(data)] = data
        return len(data)


def _as_bytes(file: IO) -> io.BufferedReader:
    if isinstance(file.read(0), str):
        file = io.BytesIO(file.read().encode("utf-8", errors="replace"))
    return io.BufferedReader(_Bytes(file), HEAD)
