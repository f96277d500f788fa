"""Arrays of .npz files, zip archives of numpy's arrays, and of .npy files, with nothing ever unpickled.

An entry is checked by its header before its data are read: kind of numbers, shape, and that the data are as long as
these require. numpy.load first allocates what a header states, which in a file of 300 bytes may be 80 GB. Entries that
nobody asks for are not opened.
"""

import errno
import io
import math
import re
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import IO, NamedTuple

import numpy as np

from skpose.io._error import MocapFormatError
from skpose.io._opening import TIMES, is_too_much
from skpose.io._source import Source

MAGIC = re.compile(rb"\x93NUMPY[\x01\x02]\x00")
LONGEST_HEADER = 1000  # characters; numpy writes 118 for plain numbers
HEADER = re.compile(
    rb"\{'descr': '([<>|=]?[A-Zb-z]\d*)', 'fortran_order': (False|True), 'shape': \(([\dL, ]*)\),? ?\}\s*"
)
LARGEST_ANGLE = 1e15  # rad; of a larger one no digit says where in the turn it is
NUMBERS, TEXTS = ("numbers", "fiu"), ("texts", "SU")  # the kinds of dtypes
# A position before the start, which a damaged table of contents states; bzip2's error on its data has no number.
DAMAGE_OF_SYSTEM = errno.EINVAL, None

LAST_CHARACTER, SURROGATES = 0x10FFFF, (0xD800, 0xDFFF)  # of Unicode; what else numpy holds, Python has no text for

Shape = Sequence[int | None]  # that is expected; None is any length


class Header(NamedTuple):
    """The kind, the order and the shape of an array."""

    dtype: np.dtype
    fortran_order: bool
    shape: tuple[int, ...]


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
        with _damage(source, "the archive"):
            file = source.seekable()
            self._n_bytes = file.seek(0, io.SEEK_END)
            self._zip = zipfile.ZipFile(file)
            self.keys = {name.removesuffix(".npy") for name in self._zip.namelist() if name.endswith(".npy")}

    def shape(self, key: str) -> tuple[int, ...]:
        """Return the shape of an array, from its header alone."""
        with self._open(key) as (member, length):
            return _read_header(self.source, key, member, length, self._pickled).shape

    def numbers(self, key: str, *shapes: Shape, finite: bool = True, remedy: str = "") -> np.ndarray:
        """Return an array of numbers as float64, if its shape is one of these, and all are finite or need not be."""
        array = as_float64(self._read(key, NUMBERS, shapes))
        if finite and not np.isfinite(array).all():
            index = tuple(np.argwhere(~np.isfinite(array))[0].tolist())
            raise self.source.error(
                f"{key}: expected finite numbers, found {array[index]} at index {_format_shape(index)}{remedy}"
            )
        return array

    def angles(self, key: str, *shapes: Shape, finite: bool = True, remedy: str = "") -> np.ndarray:
        """Return angles or rotation vectors, rad; numbers that are none are an error."""
        found = self.numbers(key, *shapes, finite=finite, remedy=remedy)
        if (is_large := np.isfinite(found) & (np.abs(found) > LARGEST_ANGLE)).any():
            raise self.source.error(f"{key}: expected angles in rad, found {found[is_large][0]:g}, which is no angle")
        return found

    def texts(self, key: str, *shapes: Shape) -> list[str]:
        """Return all texts of an array, of characters or of bytes, if its shape is one of these."""
        array = self._read(key, TEXTS, shapes)
        if array.dtype.kind == "U":
            codes = np.frombuffer(array.tobytes(), np.dtype("u4").newbyteorder(array.dtype.byteorder))
            if ((codes > LAST_CHARACTER) | ((codes >= SURROGATES[0]) & (codes <= SURROGATES[1]))).any():
                raise self.source.error(f"{key}: damaged: it holds numbers that are no characters")
        values = array.ravel().tolist()
        return [value.decode("utf-8", errors="replace") if isinstance(value, bytes) else value for value in values]

    def _read(self, key: str, kind: tuple[str, str], shapes: Sequence[Shape]) -> np.ndarray:
        with self._open(key) as (member, length):
            return _read(self.source, key, member, length, kind, shapes, self._pickled)

    @contextmanager
    def _open(self, key: str) -> Iterator[tuple[IO[bytes], int]]:
        """Open the entry of a key for reading, and say how long it is."""
        if key not in self.keys:
            raise self.source.error(f"it has no {key}; its keys are {', '.join(sorted(self.keys)) or 'none'}")
        entry = self._zip.getinfo(f"{key}.npy")
        packed = min(entry.compress_size, self._n_bytes)
        if entry.compress_type != zipfile.ZIP_STORED and is_too_much(entry.file_size, packed):
            raise self.source.error(
                f"{key}: its compression holds {entry.file_size // 10**6} MB, over {TIMES} times its size, which no "
                "recording does; if it is one nevertheless, save it with numpy.savez, without compression"
            )
        with _damage(self.source, key), self._zip.open(entry) as member:
            yield member, entry.file_size


def read_array(source: Source, *shapes: Shape) -> np.ndarray:
    """Return the numbers of an open .npy file as float64, if its shape is one of these."""
    if source.binary != "npy":
        raise source.error("expected an .npy file, an array in numpy's format; this is none, or is damaged")
    file = source.seekable()
    length = file.seek(0, io.SEEK_END)
    file.seek(0)
    return as_float64(_read(source, "the array", file, length, NUMBERS, shapes))


def as_float64(array: np.ndarray) -> np.ndarray:
    """Return numbers as float64, without a warning on those that are no valid or no finite ones."""
    with np.errstate(over="ignore", invalid="ignore"):
        return array.astype(np.float64)


@contextmanager
def _damage(source: Source, key: str) -> Iterator[None]:
    """Turn the errors of zipfile and of all that decompress, of a dozen types, into one that names file and entry."""
    try:
        yield
    except Exception as error:
        of_system = isinstance(error, OSError) and error.errno not in DAMAGE_OF_SYSTEM
        if of_system or isinstance(error, MocapFormatError | MemoryError):
            raise
        raise source.error(f"{key}: damaged or cut short, or compressed in a way that is not read: {error}") from None


def _read(
    source: Source,
    key: str,
    file: IO[bytes],
    length: int,
    kind: tuple[str, str],
    shapes: Sequence[Shape],
    pickled: str = "",
) -> np.ndarray:
    """Read an array that has so many bytes with its header, if it is of a kind and has one of the shapes."""
    header = _read_header(source, key, file, length, pickled)
    if header.dtype.kind not in kind[1]:
        raise source.error(f"{key}: expected {kind[0]}, found an array of dtype {header.dtype}")
    if not any(_fits(header.shape, shape) for shape in shapes):
        expected = " or ".join(_format_shape(shape) for shape in shapes)
        raise source.error(f"{key}: expected shape {expected}, found {_format_shape(header.shape)}")
    # To the end of an entry, where its checksum is compared. Without the length all is decompressed that there is.
    data = file.read(math.prod(header.shape) * header.dtype.itemsize)
    return np.ndarray(header.shape, header.dtype, data, order="F" if header.fortran_order else "C")


def _read_header(source: Source, key: str, file: IO[bytes], length: int, pickled: str) -> Header:
    """Read the header of an array, and check that its data have the length that it states."""
    start = file.read(8)
    if not MAGIC.fullmatch(start):
        raise source.error(f"{key}: expected an array in numpy's format, version 1 or 2, found {start[:8]!r}")
    text = file.read(min(int.from_bytes(file.read(2 * start[6]), "little"), LONGEST_HEADER))
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
    shape = tuple(int(n) for n in re.findall(r"\d+", lengths))
    stated, found = math.prod(shape) * dtype.itemsize, length - file.tell()
    if stated != found:
        raise source.error(
            f"{key}: its header states {stated} bytes of data, shape {_format_shape(shape)} of {dtype}, and there are "
            f"{found}; is the file cut short?"
        )
    return Header(dtype, order == "True", shape)


def _fits(shape: tuple[int, ...], expected: Shape) -> bool:
    return len(shape) == len(expected) and all(
        wanted is None or n == wanted for n, wanted in zip(shape, expected, strict=True)
    )


def _format_shape(shape: Shape) -> str:
    lengths = ["n" if n is None else str(n) for n in shape]
    return f"({', '.join(lengths)}{',' if len(lengths) == 1 else ''})"
