"""Arrays of .npz files, zip archives of numpy's arrays, and of .npy files, with nothing ever unpickled.

An entry is checked by its header before its data are read: kind of numbers, shape, and that the data are as long as
these require. So memory is at most what a header of an expected shape states. Entries that nobody asks for are not
opened.
"""

import errno
import gzip
import math
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import IO, NamedTuple

import numpy as np

from skpose.io._error import MocapFormatError
from skpose.io._source import Source

try:
    from lzma import LZMAError
except ImportError:  # this Python cannot decompress it
    OF_LZMA: tuple[type[Exception], ...] = ()
else:
    OF_LZMA = (LZMAError,)

MAGIC = re.compile(rb"\x93NUMPY[\x01\x02]\x00")
LONGEST_HEADER = 1000  # characters; numpy writes 118 for plain numbers
HEADER = re.compile(
    rb"\{'descr': '([<>|=]?[A-Za-z]\d*)', 'fortran_order': (False|True), 'shape': \(([\dL, ]*)\),? ?\}\s*"
)
DAMAGE: tuple[type[Exception], ...] = (
    zipfile.BadZipFile,
    gzip.BadGzipFile,
    zlib.error,
    *OF_LZMA,
    struct.error,
    EOFError,
    ValueError,
    OverflowError,
    KeyError,
)
# A position before the start, which a damaged table of contents states; bzip2's error on its data has no number.
DAMAGE_OF_SYSTEM = errno.EINVAL, None
UNSUPPORTED = RuntimeError, NotImplementedError  # a password, another compression


class Header(NamedTuple):
    """The kind, the order and the shape of an array."""

    dtype: np.dtype
    fortran_order: bool
    shape: tuple[int, ...]

    @property
    def n_bytes(self) -> int:
        return math.prod(self.shape) * self.dtype.itemsize

    def array(self, data: bytes) -> np.ndarray:
        """Return bytes as the array."""
        return np.ndarray(self.shape, self.dtype, data, order="F" if self.fortran_order else "C")


class Archive:
    """The arrays of an .npz file by their keys.

    Parameters
    ----------
    source : Source
        The open file.
    pickled : str, default=""
        What to do where an entry is a pickled object.
    """

    def __init__(self, source: Source, pickled: str = ""):
        if source.binary != "zip":
            raise source.error("expected an .npz file, a zip archive of numpy's arrays; this is none, or is damaged")
        self.source, self._pickled = source, f". {pickled}" if pickled else ""
        with self._damage("the archive"):
            self._zip = zipfile.ZipFile(source.seekable())
            self.keys = {name.removesuffix(".npy") for name in self._zip.namelist() if name.endswith(".npy")}

    def shape(self, key: str) -> tuple[int, ...]:
        """Return the shape of an array of numbers, from its header alone."""
        with self._opened(key) as member:
            return self._header(key, member).shape

    def numbers(self, key: str, *shapes: Sequence[int | None], finite: bool = True) -> np.ndarray:
        """Return an array of finite numbers as float64, if its shape is one of these; None is any length."""
        with self._opened(key) as member:
            header = self._header(key, member)
            check_numbers(self.source, key, header, *shapes)
            array = as_float64(self._data(key, member, header))
        if finite and not np.isfinite(array).all():
            index = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
            raise self.source.error(f"{key}: expected finite numbers, found {array[index]} at index {_shown(index)}")
        return array

    def texts(self, key: str) -> list[str]:
        """Return an array of texts of one dimension, of characters or of bytes."""
        with self._opened(key) as member:
            header = self._header(key, member)
            if header.dtype.kind not in "SU" or len(header.shape) != 1:
                raise self.source.error(
                    f"{key}: expected texts, shape (n,), found dtype {header.dtype} and shape {_shown(header.shape)}"
                )
            values = self._data(key, member, header).tolist()
        return [value.decode("utf-8", errors="replace") if isinstance(value, bytes) else value for value in values]

    def text(self, key: str) -> str:
        """Return an array of one text, of characters or of bytes."""
        with self._opened(key) as member:
            header = self._header(key, member)
            if header.dtype.kind not in "SU" or math.prod(header.shape) != 1:
                raise self.source.error(
                    f"{key}: expected one text, found dtype {header.dtype} and shape {_shown(header.shape)}"
                )
            value = self._data(key, member, header).item()
        return value.decode("utf-8", errors="replace") if isinstance(value, bytes) else value

    @contextmanager
    def _opened(self, key: str) -> Iterator[IO[bytes]]:
        """Open the entry of a key for reading."""
        if key not in self.keys:
            raise self.source.error(f"it has no {key}; its keys are {', '.join(sorted(self.keys)) or 'none'}")
        with self._damage(key), self._zip.open(f"{key}.npy") as member:
            yield member

    def _header(self, key: str, member: IO[bytes]) -> Header:
        """Read the header of an entry and check it against the entry's length."""
        header = read_header(self.source, key, member.read, self._pickled)
        length = self._zip.getinfo(f"{key}.npy").file_size - member.tell()
        if length != header.n_bytes:
            raise wrong_length(self.source, key, header, str(length))
        return header

    def _data(self, key: str, member: IO[bytes], header: Header) -> np.ndarray:
        """Read the array after its header."""
        data = member.read(header.n_bytes)  # to the end of the entry, where its checksum is compared
        if len(data) != header.n_bytes:
            raise wrong_length(self.source, key, header, str(len(data)))
        return header.array(data)

    @contextmanager
    def _damage(self, key: str) -> Iterator[None]:
        """Turn the errors of a damaged archive into one that names the file and the entry."""
        try:
            yield
        except MocapFormatError:
            raise
        except DAMAGE as error:
            raise self.source.error(f"{key}: damaged or cut short: {error}") from None
        except UNSUPPORTED as error:
            raise self.source.error(
                f"{key}: cannot be decompressed: {error}; numpy.savez writes it so that it can"
            ) from None
        except OSError as error:
            if error.errno not in DAMAGE_OF_SYSTEM:
                raise
            raise self.source.error(f"{key}: damaged or cut short: {error}") from None


def read_array(source: Source, *shapes: Sequence[int | None]) -> np.ndarray:
    """Return the numbers of an open .npy file as float64, if its shape is one of these; None is any length."""
    if source.binary != "npy":
        raise source.error("expected an .npy file, an array in numpy's format; this is none, or is damaged")
    header = read_header(source, "the array", source.read, "")
    check_numbers(source, "the array", header, *shapes)
    data = source.read(header.n_bytes + 1)
    if len(data) != header.n_bytes:
        found = str(len(data)) if len(data) < header.n_bytes else "more"
        raise wrong_length(source, "the array", header, found)
    return as_float64(header.array(data))


def as_float64(array: np.ndarray) -> np.ndarray:
    """Return numbers as float64, without a warning on those that are no valid or no finite ones."""
    with np.errstate(over="ignore", invalid="ignore"):
        return array.astype(np.float64)


def read_header(source: Source, key: str, read: Callable[[int], bytes], pickled: str) -> Header:
    """Read the header of an array, of plain numbers or texts; `pickled` is what to do where it is a pickled object."""
    start = read(8)
    if not MAGIC.fullmatch(start):
        raise source.error(f"{key}: expected an array in numpy's format, version 1 or 2, found {start[:8]!r}")
    length = int.from_bytes(read(2 * start[6]), "little")
    text = read(min(length, LONGEST_HEADER))
    match = HEADER.fullmatch(text)
    if not match:
        raise source.error(f"{key}: expected the header of an array of numbers, found {text[:60]!r}")
    descr, order, lengths = (group.decode() for group in match.groups())
    if "O" in descr:
        raise source.error(
            f"{key}: expected numbers, found a pickled object, which could run any program and is never read{pickled}"
        )
    try:
        dtype = np.dtype(descr)
    except TypeError:
        raise source.error(f"{key}: expected numbers, found an array of the unknown dtype {descr!r}") from None
    return Header(dtype, order == "True", tuple(int(n) for n in re.findall(r"\d+", lengths)))


def check_numbers(source: Source, key: str, header: Header, *shapes: Sequence[int | None]) -> None:
    """Raise the error on an array that holds no numbers, or has none of the shapes."""
    if header.dtype.kind not in "fiu":
        raise source.error(f"{key}: expected numbers, found an array of dtype {header.dtype}")
    if not any(_fits(header.shape, shape) for shape in shapes):
        expected = " or ".join(_shown(shape) for shape in shapes)
        raise source.error(f"{key}: expected shape {expected}, found {_shown(header.shape)}")


def wrong_length(source: Source, key: str, header: Header, found: str) -> MocapFormatError:
    """Return the error on an array whose data are shorter or longer than its header states."""
    return source.error(
        f"{key}: its header states {header.n_bytes} bytes of data, shape {_shown(header.shape)} of {header.dtype}, and "
        f"there are {found}; is the file cut short?"
    )


def _fits(shape: tuple[int, ...], expected: Sequence[int | None]) -> bool:
    return len(shape) == len(expected) and all(
        wanted is None or n == wanted for n, wanted in zip(shape, expected, strict=True)
    )


def _shown(shape: Sequence[int | None]) -> str:
    lengths = ["n" if n is None else str(n) for n in shape]
    return f"({', '.join(lengths)}{',' if len(lengths) == 1 else ''})"
