"""The bytes of a file, its words with their positions, its numbers and arrays, and errors and warnings that name it."""

import gzip
import io
import os
import re
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import IO, Any, Literal, NamedTuple, Self

import numpy as np

from skpose._utils.warnings import warn

# --- formats that are not read ----------------------------------------------------------------------------------------


NUMBERS = rb"(?:[-+\d.e,;\s]|nan|inf)+\Z"  # a table of these alone


class Unread(NamedTuple):
    """A format that no reader reads.

    Attributes
    ----------
    name : str
        The format, with the suffixes of its files, as after "this is".
    signature : bytes
        An expression for how its files begin, without regard to case, with line ends as any character.
    advice : str
        The way out; empty if there is none.
    """

    name: str
    signature: bytes
    advice: str = ""


ROBOT = Unread("a robot", rb"(?:\xef\xbb\xbf)?\s*(?:<.*)?<(?:mujoco|robot)[\s>]", "load_robot reads it")
TO_BVH = "Blender imports it and exports BVH"
# The first that matches is the format.
UNREAD = (
    Unread("an empty file", rb"\s*\Z"),
    Unread("a pointer of Git LFS", rb"version https://git-lfs", "run git lfs pull"),
    Unread("UTF-16 text", rb"\xff\xfe|\xfe\xff", "save it as UTF-8"),
    Unread(
        "a pickle", rb"\x80[\x02-\x05]", "it could run any program and is never read; save its arrays by numpy.savez"
    ),
    Unread("a file of PyTorch (.pt, .pth)", rb"PK\x03\x04.*/data\.pkl", "save its tensors as arrays by numpy.savez"),
    Unread("an Excel table (.xlsx)", rb"PK\x03\x04.*\[Content_Types\]\.xml", "save it as CSV"),
    Unread("glTF (.glb, .vrm, .vrma)", rb"glTF", TO_BVH),
    Unread("FBX", rb"Kaydara FBX|; FBX", TO_BVH),
    Unread("USD", rb"PXR-USDC|#usda", TO_BVH),
    Unread("COLLADA (.dae)", rb"\s*<.{0,2000}<COLLADA", TO_BVH),
    Unread(
        "HDF5 (.h5, .slp), as of DeepLabCut and SLEAP",
        rb"\x89HDF\r\n",
        "the package movement reads it, and Keypoints takes positions in three dimensions",
    ),
    Unread(
        "a file of pose-format (.pose)",
        rb"\xcd\xcc(?:\xcc=|L>)",
        "Pose.read of pose-format has its points in body.data, as an array for Keypoints",
    ),
    Unread(
        "DeepLabCut's table of two dimensions",
        rb"scorer,[^\n]*\n(?:individuals,[^\n]*\n)?bodyparts,[^\n]*\ncoords,x,y,(?!z)",
        "Anipose triangulates several cameras, and its CSV is read",
    ),
    Unread(
        "DeepMimic's motion",
        rb'\s*\{.*(?-i:"Frames")\s*:\s*\[\s*\[\s*[-\d]',
        "it holds rotations of its own characters",
    ),
    Unread(
        "a JSON file of SPL Open Data",
        rb'\s*\{.*"tracking"\s*:\s*\[',
        "save a list of its frames {name: [x, y, z]}, which are in feet, scale=0.3048",
    ),
    Unread(
        "a table of joint angles of save_csv, without a skeleton",
        rb"frame,time,frame_rate,up,root_axes,",
        "pandas.read_csv reads it",
    ),
    Unread(
        "a table of OpenSim (.mot, .sto)",
        rb"(?:.*\n)?[ \t]*(?:nrows|ncolumns|indegrees|datarows|datacolumns)\b.*\n[ \t]*endheader\b",
        "load_trc reads the markers of the same trial",
    ),
    Unread(
        "a table of numbers without names",
        rb"(?=\s*[^\s,;]+[\s,;]+[^\s,;])" + NUMBERS,
        "numpy.loadtxt reads it for motion_from_qpos, if they are a robot's, or for Keypoints",
    ),
    ROBOT,
    Unread("a web page or XML", rb"(?!.{0,2000}<mvnx[\s>])\s*<"),
)


PathLike = str | os.PathLike
Readable = PathLike | IO


# --- error ------------------------------------------------------------------------------------------------------------
# The error of all readers.


class MocapFormatError(ValueError):
    """A motion-capture file that does not follow its format.

    Attributes
    ----------
    filename : str
        The file.
    line : int or None
        Number of the line, from 1; None if the fault is not in one line.
    column : int or None
        Number of the character in the line, from 1; None if the fault is the whole line.
    message : str
        What was expected, what was found, and what to do, without the position.

    Examples
    --------
    >>> import io
    >>> from skpose.io import MocapFormatError, load_bvh
    >>> try:
    ...     load_bvh(io.StringIO("HIERARCHY hello"))
    ... except MocapFormatError as error:
    ...     print(error.line, error.column, error.message)
    1 11 expected ROOT, found 'hello'
    """

    def __init__(self, filename: PathLike, line: int | None, message: str, column: int | None = None):
        self.filename, self.line, self.message, self.column = str(filename), line, message, column
        parts = {"line": line, "column": column}.items()
        position = ", ".join([Path(self.filename).name, *(f"{name} {n}" for name, n in parts if n is not None)])
        super().__init__(f"{position}: {message}")

    def __reduce__(self) -> tuple:
        return MocapFormatError, (self.filename, self.line, self.message, self.column)


# --- source -----------------------------------------------------------------------------------------------------------


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
        self.parts = list[Source]()  # the files of a folder, in the order of the last number of their names
        if isinstance(file, str | os.PathLike):
            self.name, path = os.fspath(file), Path(file)
            if path.is_dir():
                files = sorted(one for one in path.iterdir() if one.suffix.lower() == ".json")
                self.parts = [Source(part, "a JSON file") for part in sorted(files, key=last_number)]
                if not self.parts:
                    raise IsADirectoryError(f"{file} is a folder without JSON files: load each of its files")
            data = b"[" + b",".join(one.data for one in self.parts) + b"]" if self.parts else path.read_bytes()
        elif hasattr(file, "read"):
            self.name, data = str(getattr(file, "name", "the open file")), file.read()
        else:
            raise TypeError(f"expected a path or an open file to read, got {type(file).__name__}")
        data = data.encode("utf-8", errors="replace") if isinstance(data, str) else data
        data = (self._unpack(data) if data.startswith(GZIP) else data).removeprefix(BOM)
        self.kind: Kind = next((kind for kind, start in BINARY.items() if start.match(data)), "text")
        if found := next(
            (one for one in UNREAD if re.match(one.signature, data[:HEAD], re.DOTALL | re.IGNORECASE)), None
        ):
            raise self.error(": ".join(filter(None, (f"this is {found.name}", found.advice))))
        is_text = self.kind == "text"
        if is_text and b"\r" in data[:HEAD] and b"\n" not in data[:HEAD]:  # the line ends of an old Macintosh
            data = data.replace(b"\r", b"\n")
        self.data: bytes = data
        self.head = data[:HEAD].decode(errors="replace") if is_text else ""
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


def last_number(path: PathLike) -> int:
    """The last number of the name of a file, by which programs count frames; -1 if there is none."""
    return int((re.findall(r"\d{1,15}", Path(path).stem) or ["-1"])[-1])


def complaint(token: str) -> str:
    """Say that a word is not accepted as a number."""
    return f"expected a finite number such as -0.5, found {str(token[:40])!r}"


# --- numbers ----------------------------------------------------------------------------------------------------------
# The numbers of a file's frames, read by numpy's parsers: each the nearest double, as by Python's float.


CHUNK = 1 << 18  # bytes that are read at once: enough for numpy's parser, and they fit the cache
# Kind of each character: a blank, a digit, a point, a sign, or (?) something else.
KINDS = b"?" * 9 + b" " * 5 + b"?" * 18 + b" " + b"?" * 10 + b"-?-.?" + b"0" * 10 + b"?" * 198  # by its code
OTHER = b"\x1c\x1d\x1e\x1f"  # blanks to numpy, but not in these files; nor is "_", Python's separator of digits


def read_numbers(source: Source, start: int, *, finite: bool) -> np.ndarray:
    """Read all numbers from a byte of the file on as float64 of shape (n,); line ends have no meaning.

    An error names the first word that is not a number, or not a finite one if all must be.
    """
    data, parts = source.data, list[np.ndarray]()
    while start < len(data):
        stop = data.find(b"\n", start + CHUNK) + 1 or len(data)
        numbers = parse(data[start:stop])
        words = WORD.finditer(data, start, stop)
        if numbers is None:
            token = next(token for token in map(Token, words) if not NUMBER.fullmatch(token))
            raise source.error(f"a frame: {complaint(token)}", token)
        if finite and not np.isfinite(numbers).all():
            token = Token(next(islice(words, int(np.argmin(np.isfinite(numbers))), None)))
            raise source.error(f"a frame: {complaint(token)}; on_nan='drop' leaves such frames out", token)
        parts.append(numbers)
        start = stop
    return np.concatenate(parts) if parts else np.empty(0)


def drop_not_finite(rows: np.ndarray, frames: np.ndarray, source: Source) -> tuple[np.ndarray, np.ndarray]:
    """Leave out the rows that hold a NaN or infinite number, and their frames; a warning counts them."""
    finite = np.isfinite(rows).all(axis=1)
    if finite.all():
        return rows, frames
    source.warn(
        f"{np.count_nonzero(~finite)} of {len(rows)} frames have a number that is NaN or infinite and are left out; "
        "the others keep their times"
    )
    return rows[finite], frames[finite]


def parse(text: bytes) -> np.ndarray | None:
    """The numbers; None if any word is not a number."""
    text = text.strip()
    if not text:
        return np.empty(0)
    # The rest is likely to be written in the same format as the first 1,000 characters.
    if parse_fixed(text[:1000].rpartition(b" ")[0] or text) is not None and (numbers := parse_fixed(text)) is not None:
        return numbers
    if b"_" in text or len(text) != len(text.translate(None, OTHER)):
        return None
    # The first is faster, but requires equally many numbers on each line.
    for read in (
        lambda: np.loadtxt(io.BytesIO(text).readlines(), comments=None, encoding="ascii", ndmin=1).ravel(),
        lambda: np.array(text.split(), dtype=np.float64),
    ):
        with suppress(ValueError):
            return read()
    return None


def parse_fixed(text: bytes) -> np.ndarray | None:
    """Numbers with equally many digits after the point, as most programs write them; None for any others.

    Without their points they are integers, which numpy reads three times as fast. A double holds integers below 2^53
    and powers of ten up to 10^22 exactly, so that one division gives the double that the digits stand for (W. D.
    Clinger, How to read floating point numbers accurately, 1990, DOI 10.1145/93542.93557). numpy's parser of integers
    accepts some words that are not integers, so every word is checked first.
    """
    n_digits = len(text.split(None, 1)[0].rpartition(b".")[2])
    kinds = (b" " + text + b" " * (n_digits + 1)).translate(KINDS)
    if not 1 <= n_digits <= 22 or b"?" in kinds:
        return None
    codes = np.frombuffer(kinds, np.uint8)
    blank, points = codes == ord(" "), np.flatnonzero(codes == ord("."))
    ends, n_words = points + n_digits + 1, np.count_nonzero(blank[:-1] > blank[1:])
    # A word ends n_digits characters after each point, before the next point. So no word has two points; as there are
    # as many words as points, each word has exactly one.
    if len(points) != n_words or not (blank[ends] & ~blank[ends - 1]).all() or (points[1:] <= ends[:-1]).any():
        return None
    if ((codes[1:] == ord("-")) & ~blank[:-1]).any():  # a sign that does not begin a word
        return None
    whole = np.fromstring(text.replace(b".", b""), np.int64, sep=" ")
    if whole.min() <= -(2**53) or whole.max() >= 2**53:
        return None
    numbers, zeros = whole / 10.0**n_digits, np.flatnonzero(whole == 0)
    starts = np.flatnonzero(blank[:-1] > blank[1:])[zeros]
    numbers[zeros[np.frombuffer(text, np.uint8)[starts] == ord("-")]] = -0.0  # integers have no such zero
    return numbers


# --- arrays -----------------------------------------------------------------------------------------------------------
# Arrays of .npz and .npy files, checked for kind and shape. Nothing is unpickled.


ARRAY = "the array"
Shape = Sequence[int | None]  # that is expected; None is any length


class Archive:
    """The arrays of an .npz file by their keys, each read when it is requested; or arrays of a file by other keys.

    The array of an .npy file has the key "the array".
    """

    def __init__(self, source: Source, arrays: Mapping[str, Any] | None = None):
        if arrays is None and source.kind not in ("zip", "npy"):
            raise source.error("expected an .npz file, found none")
        self.source, names = source, None
        if arrays is None:
            with _damage(source, "the archive" if source.kind == "zip" else ARRAY):
                loaded: Any = np.load(io.BytesIO(source.data), allow_pickle=False)
            arrays = {ARRAY: loaded} if source.kind == "npy" else loaded
            names = loaded.zip.namelist() if source.kind == "zip" else None
            if names and sum(member.file_size for member in loaded.zip.infolist()) > LARGEST:
                raise source.error(f"the archive unpacks to more than {LARGEST >> 30} GB")
        self._arrays = arrays
        self.keys = {key for key in arrays if names is None or f"{key}.npy" in names}  # an archive may have other files

    def list_keys(self) -> str:
        return ", ".join(sorted(self.keys)[:12]) + (" and others" if len(self.keys) > 12 else "") or "none"

    def numbers(self, key: str, *shapes: Shape, finite: bool = True) -> np.ndarray:
        """An array of numbers as float64, if its shape is one of these, and all are finite or need not be."""
        array = self._read(key)
        _check(self.source, key, array, "fiu", shapes)
        with np.errstate(over="ignore", invalid="ignore"):
            array = array.astype(np.float64)
        if finite and not np.isfinite(array).all():
            raise self.source.error(f"{key}: expected finite numbers, found {array[~np.isfinite(array)][0]}")
        return array

    def texts(self, key: str, *shapes: Shape) -> list[str]:
        """All texts of an array, of characters or of bytes, if its shape is one of these."""
        array = self._read(key)
        _check(self.source, key, array, "SU", shapes)
        with _damage(self.source, key):
            values = array.ravel().tolist()
            return [value.decode() if isinstance(value, bytes) else value for value in values]

    def _read(self, key: str) -> np.ndarray:
        if key not in self.keys:
            raise self.source.error(f"expected the key {key!r}, found {self.list_keys()}")
        with _damage(self.source, key):
            return np.asarray(self._arrays[key])


def _check(source: Source, key: str, array: Any, kinds: str, shapes: Sequence[Shape]) -> None:
    if array.dtype.kind not in kinds:
        what = "numbers" if "f" in kinds else "texts"
        raise source.error(f"{key}: expected {what}, found an array of dtype {array.dtype}")
    possible = [shape for shape in shapes if len(shape) == array.ndim]
    if not any(all(n in (None, m) for n, m in zip(shape, array.shape, strict=True)) for shape in possible):
        expected = " or ".join(str(tuple(n or "n" for n in shape)).replace("'", "") for shape in shapes)
        raise source.error(f"{key}: expected shape {expected}, found {array.shape}")


@contextmanager
def _damage(source: Source, key: str) -> Iterator[None]:
    """Turn all errors of numpy, zipfile and decompression, of a dozen types, into one that names file and entry."""
    try:
        yield
    except MocapFormatError:
        raise
    except Exception as error:
        reason = "a pickled object, which is never read" if "allow_pickle" in str(error) else f"damage: {error}"
        raise source.error(f"{key}: expected an array, found {reason}") from None
