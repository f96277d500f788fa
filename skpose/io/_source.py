"""What the readers share: a file line by line, its words and numbers, and the error that says where it is wrong."""

import gzip
import inspect
import io
import os
import re
import warnings
import zlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import IO

import numpy as np

PathLike = str | os.PathLike
Readable = PathLike | IO

BLOCK = 1 << 18  # bytes of lines that are read at once: enough for numpy's parser, and they stay in the cache
WORD = re.compile(r"\S+")  # as str.split has them
REAL = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
NUMBER = re.compile(rf"{REAL}|[+-]?(?:nan|inf(?:inity)?)", re.ASCII | re.IGNORECASE)
WHOLE = re.compile(r"\d{1,18}", re.ASCII)  # what fits 64 bits; Python's own int() gives up at 4,300 digits
GLUED = re.compile(rf"{REAL}(?:[+-](?:\d|\.)[\d.eE+-]*)+", re.ASCII)
DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", re.ASCII)


class MocapFormatError(ValueError):
    """A motion-capture file that does not say what its format asks for.

    Attributes
    ----------
    filename : str
        The file.
    line : int or None
        Where in it, counted from 1; None where no one line is at fault.
    column : int or None
        Where in the line, counted from 1; None where it is the line as a whole.
    message : str
        What was expected, what was found, and what to do, without the place.
    """

    def __init__(self, filename: PathLike, line: int | None, message: str, column: int | None = None):
        self.filename, self.line, self.message, self.column = str(filename), line, message, column
        where = Path(self.filename).name
        where += f", line {line}" if line is not None else ""
        where += f", column {column}" if column is not None else ""
        super().__init__(f"{where}: {message}")

    def __reduce__(self):
        return MocapFormatError, (self.filename, self.line, self.message, self.column)


class Token(str):
    """A word of a file that knows where it stands."""

    line: int
    column: int

    def __new__(cls, word: str, line: int, column: int):
        token = super().__new__(cls, word)
        token.line, token.column = line, column
        return token


class Source:
    """A text file that is read once from its start to its end, and the errors that name it.

    Parameters
    ----------
    file : str, path-like or file
        Where it is, or the open file, of text or of bytes, from where it stands; compressed by gzip or not.
    kind : str
        What it should be, such as "a BVH file".
    """

    def __init__(self, file: Readable, kind: str):
        self.line = 0  # number of the line read last
        self._lines: Iterator[bytes] = iter(())
        with ExitStack() as closing:
            if isinstance(file, str | os.PathLike):
                self.name = os.fspath(file)
                stream = closing.enter_context(Path(file).open("rb"))
            elif hasattr(file, "read"):
                self.name = str(getattr(file, "name", "the open file"))
                stream = _as_bytes(file)
            else:
                raise TypeError(f"expected a path or an open file to read, got {type(file).__name__}")
            self._stream = stream
            with self._gzip_errors():
                if stream.peek(2)[:2] == b"\x1f\x8b":
                    self._stream = stream = closing.enter_context(gzip.GzipFile(fileobj=stream))
                head = stream.peek(BLOCK)
            self.head = head.removeprefix(b"\xef\xbb\xbf").decode("utf-8", errors="replace")
            self._refuse_other_kinds(head, kind)
            if b"\r" in head and b"\n" not in head:  # lines end as on an old Macintosh
                self._stream = io.BytesIO(stream.read().replace(b"\r", b"\n"))
            self._closing = closing.pop_all()

    def _refuse_other_kinds(self, head: bytes, kind: str) -> None:
        found = None
        if not head.strip() and len(head) < 4096:  # more blanks than that are the start of something
            found = "the file is empty"
        elif head.startswith(b"version https://git-lfs"):
            found = "this is a pointer of Git LFS; get the file itself with git lfs pull. It is"
        elif head.startswith((b"\xff\xfe", b"\xfe\xff")):
            found = "this is UTF-16 text; save it as UTF-8. It is"
        elif b"\0" in head:
            found = "this is a binary file"
        elif head.lstrip().startswith(b"<"):
            found = "this is a web page or XML"
        if found:
            comma = "" if found.endswith("It is") else ","
            raise self.error(f"{found}{comma} not {kind}")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._closing.close()

    @contextmanager
    def _gzip_errors(self) -> Iterator[None]:
        try:
            yield
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise self.error(f"its gzip compression is damaged or cut short: {error}") from None

    def readline(self) -> str | None:
        """The next line, with its end; None after the last."""
        line = next(self._lines, None)
        if line is None:
            self._lines = iter(self._block())
            line = next(self._lines, None)
            if line is None:
                return None
        self.line += 1
        # Names in these files may be in any encoding; numbers and keywords are ASCII.
        return line.decode("utf-8", errors="replace")

    def _block(self) -> list[bytes]:
        with self._gzip_errors():
            lines = self._stream.readlines(BLOCK)
        if lines and self.line == 0:
            lines[0] = lines[0].removeprefix(b"\xef\xbb\xbf")
        return lines

    def blocks(self) -> Iterator[tuple[int, list[bytes]]]:
        """All further lines, many at a time, with the number of the first."""
        lines = list(self._lines) or self._block()
        while lines:
            yield self.line + 1, lines
            self.line += len(lines)
            lines = self._block()

    def statements(self) -> Iterator[list[Token]]:
        """The words of each further line that has any; round brackets taken out."""
        while (text := self.readline()) is not None:
            if tokens := self.words(text.replace("(", " ").replace(")", " "), self.line):
                yield tokens

    @staticmethod
    def words(text: str, line: int) -> list[Token]:
        """The words of a line, without a comment."""
        return [Token(m[0], line, m.start() + 1) for m in WORD.finditer(text.partition("#")[0])]

    def error(self, message: str, at: Token | int | None = None) -> MocapFormatError:
        """The error that names this file, and a word or a line of it."""
        if isinstance(at, Token):
            return MocapFormatError(self.name, at.line, message, at.column)
        return MocapFormatError(self.name, at, message)

    def number(self, token: Token, what: str, *, finite: bool = True) -> float:
        """What a word says in numbers, never NaN."""
        value = float(token) if NUMBER.fullmatch(token) else np.nan
        if np.isnan(value) or (finite and np.isinf(value)):
            raise self.error(f"{what}: {complaint(token)}", token)
        return value

    def positive(self, token: Token, what: str) -> float:
        """A number above zero, and not so small that its inverse is infinite."""
        value = self.number(token, what)
        if value <= 0 or not np.isfinite(1.0 / value):
            raise self.error(f"{what}: expected a positive number, found {str(token)!r}", token)
        return value

    def warn(self, message: str) -> None:
        """A warning that names this file, and the caller's line that wanted it read."""
        level, frame = 2, inspect.currentframe().f_back
        while frame is not None and frame.f_globals.get("__name__", "").startswith("skpose."):
            level, frame = level + 1, frame.f_back
        warnings.warn(f"{Path(self.name).name}: {message}", UserWarning, stacklevel=level)

    @contextmanager
    def blamed(self) -> Iterator[None]:
        """What Skeleton and Motion refuse, and numbers past 1e308, are faults of the file."""
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                yield
        except MocapFormatError:
            raise
        except ValueError as error:
            raise self.error(str(error)) from None


def complaint(token: str) -> str:
    """Why a word is not a number that we take, and what may be the matter."""
    shown = repr(str(token[:40]))
    if NUMBER.fullmatch(token):
        return f"expected a finite number, found {shown}"
    if DECIMAL_COMMA.fullmatch(token):
        return f"expected a number, found {shown}, which has a decimal comma: write it with a point"
    if GLUED.fullmatch(token):
        return f"expected a number, found {shown}: numbers without a blank between them"
    return f"expected a number, found {shown}"


def check_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f"{name} must be {' or '.join(map(repr, choices))}, got {value!r}")


def check_positive(name: str, value: float) -> None:
    if not (np.isreal(value) and np.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be a positive number, got {value!r}")


class _Bytes(io.RawIOBase):
    """Anything with a read method, for io.BufferedReader; it leaves the file open."""

    def __init__(self, file: IO[bytes]):
        self._file = file

    def readable(self) -> bool:
        return True

    def readinto(self, buffer) -> int:
        data = self._file.read(len(buffer))
        buffer[: len(data)] = data
        return len(data)


def _as_bytes(file: IO) -> io.BufferedReader:
    if isinstance(file.read(0), str):
        file = io.BytesIO(file.read().encode("utf-8", errors="replace"))
    return io.BufferedReader(_Bytes(file), BLOCK)
