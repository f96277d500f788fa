"""The bytes of a file, its words with their positions, and the errors and warnings that name it."""

import gzip
import io
import os
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Literal, Self

import numpy as np

from skpose._utils.warnings import warn
from skpose.io._arguments import Readable
from skpose.io._error import MocapFormatError
from skpose.io._unread import UNREAD

REAL = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
NUMBER = re.compile(rf"{REAL}|[+-]?(?:nan|inf(?:inity)?)", re.ASCII | re.IGNORECASE)
WHOLE = re.compile(r"\d{1,18}", re.ASCII)  # fits 64 bits
WORD, UNBRACKETED = re.compile(rb"\S+"), re.compile(rb"[^\s()]+")
LINE = re.compile(rb"([^\n#]*)(?:#[^\n]*)?\n?")  # and its comment

GZIP, BOM = b"\x1f\x8b", b"\xef\xbb\xbf"
LARGEST = 1 << 31  # bytes that a gzip file may unpack to: 3 MB of it can hold 3 GB of blanks
HEAD = 1 << 18  # bytes that show what a file is
Kind = Literal["text", "zip", "npy", "C3D", "binary"]
# How binary files begin. A C3D file has the block of its parameters, then 80, and zeros, which text does not have.
BINARY: dict[Kind, re.Pattern[bytes]] = {
    "zip": re.compile(rb"PK(\x03\x04|\x05\x06)"),
    "npy": re.compile(rb"\x93NUMPY"),
    "C3D": re.compile(rb"(?!%PDF|\x89PNG)[^\0]P(?=.{0,509}\0)", re.DOTALL),
    "binary": re.compile(rb"[^\0]{,262144}\0"),
}


class Token(str):
    """A word of a file and its place, in bytes from the beginning."""

    at: int

    def __new__(cls, match: re.Match[bytes], group: int = 0) -> Self:
        token = super().__new__(cls, match[group].decode(errors="replace"))
        token.at = match.start(group)
        return token


class Source:
    """A file that has been read, decompressed where gzip has compressed it.

    Parameters
    ----------
    file : str, path-like or file
        The path, or the open file, of text or of bytes; or a folder with a JSON file for each frame.
    expected : str
        What the file should be, such as "a BVH file".
    binary : bool, default=False
        Whether it may also be a zip archive, an array of numpy or a C3D file.
    """

    def __init__(self, file: Readable, expected: str, *, binary: bool = False):
        if isinstance(file, str | os.PathLike):
            self.name, path = os.fspath(file), Path(file)
            parts = sorted(path.glob("*.json"), key=last_number) if path.is_dir() else []
            if path.is_dir() and not parts:
                raise IsADirectoryError(f"{file} is a folder: load each of its files, or use load_motions")
            data = b"[" + b",".join(part.read_bytes() for part in parts) + b"]" if parts else path.read_bytes()
        elif hasattr(file, "read"):
            self.name, data = str(getattr(file, "name", "the open file")), file.read()
        else:
            raise TypeError(f"expected a path or an open file to read, got {type(file).__name__}")
        data = data.encode("utf-8", errors="replace") if isinstance(data, str) else data
        data = (self._unpack(data) if data.startswith(GZIP) else data).removeprefix(BOM)
        self.kind: Kind = next((kind for kind, start in BINARY.items() if start.match(data)), "text")
        if found := next((one for one in UNREAD if one.signature.match(data[:HEAD])), None):
            raise self.error(": ".join(filter(None, (f"this is {found.name}", found.advice))))
        is_text = self.kind == "text"
        if is_text and b"\r" in data[:HEAD] and b"\n" not in data[:HEAD]:  # the line ends of an old Macintosh
            data = data.replace(b"\r", b"\n")
        self.data, self.head = data, data[:HEAD].decode(errors="replace") if is_text else ""
        if self.kind == "binary" or not (binary or is_text):
            raise self.error(f"expected {expected}, found {self.describe()}")

    def _unpack(self, data: bytes) -> bytes:
        try:
            with gzip.open(io.BytesIO(data)) as file:
                parts = iter(lambda: file.read(1 << 24), b"")
                unpacked = b"".join(islice(parts, 1 + (LARGEST >> 24)))
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise self.error(f"its gzip compression is damaged or cut short: {error}") from None
        if len(unpacked) > LARGEST:
            raise self.error(f"gzip: expected at most {LARGEST >> 20} MB, found more: decompress it first")
        return unpacked

    @property
    def lines(self) -> list[str]:
        """The lines without their ends. Names may be in any encoding; numbers and keywords are ASCII."""
        return self.data.decode(errors="replace").split("\n")

    def statements(self) -> Iterator[list[Token]]:
        """Yield the words of each line that has any, without comments and round brackets."""
        for line in LINE.finditer(self.data):
            if tokens := [Token(match) for match in UNBRACKETED.finditer(self.data, *line.span(1))]:
                yield tokens

    @property
    def first_word(self) -> str:
        """The first word, in lower case, that is not in a comment."""
        lines = (line.partition("#")[0].split() for line in self.head.splitlines())
        return next((words[0].lower() for words in lines if words), "")

    def describe(self) -> str:
        """Describe the file in an error message, with the function that reads it."""
        return {
            "C3D": "a C3D file, positions of markers: load_c3d reads it",
            "npy": "an array (.npy): load_keypoints reads keypoints",
            "zip": "a zip archive",
            "binary": "a binary file",
            "text": f"{self.first_word[:40]!r}; load_bvh, load_amc, load_trc and load_keypoints read text",
        }[self.kind]

    def error(self, message: str, at: Token | int | None = None) -> MocapFormatError:
        """The error that names this file, and a word or the number of a line."""
        if not isinstance(at, Token):
            return MocapFormatError(self.name, at, message)
        start = self.data.rfind(b"\n", 0, at.at) + 1
        line = self.data.count(b"\n", 0, at.at) + 1
        return MocapFormatError(self.name, line, message, len(self.data[start : at.at].decode(errors="replace")) + 1)

    def number(self, token: str, what: str, at: int | None = None, *, finite: bool = True, nan: bool = False) -> float:
        """A word as a number, finite or not, NaN or not; `at` is its line if it is not a Token."""
        is_number = NUMBER.fullmatch(token) is not None
        value = float(token) if is_number else np.nan
        if not is_number or (finite and not np.isfinite(value)) or (np.isnan(value) and not nan):
            raise self.error(f"{what}: {complaint(token)}", token if isinstance(token, Token) else at)
        return value

    def warn(self, message: str | None) -> None:
        """Emit a warning, if there is a message, that names this file, at the caller's line outside this library."""
        if message:
            warn(f"{Path(self.name).name}: {message}")

    @contextmanager
    def format_errors(self) -> Iterator[None]:
        """Turn every ValueError, as of Skeleton and Motion, into one that names this file."""
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                yield
        except MocapFormatError:
            raise
        except ValueError as error:
            raise self.error(str(error)) from None


def open_source(file: Readable | Source, expected: str, *, binary: bool = False) -> Source:
    """Read a file unless it has been read, as by a function that recognised its format."""
    return file if isinstance(file, Source) else Source(file, expected, binary=binary)


def last_number(path: Path) -> int:
    """The last number of the name of a file, by which programs count frames; -1 if there is none."""
    return int((re.findall(r"\d{1,15}", path.stem) or ["-1"])[-1])


def complaint(token: str) -> str:
    """Say that a word is not accepted as a number."""
    return f"expected a finite number such as -0.5, found {str(token[:40])!r}"
