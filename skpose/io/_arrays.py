"""Arrays of .npz and .npy files, checked for kind and shape. Nothing is unpickled."""

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from skpose.io._error import MocapFormatError
from skpose.io._source import Source

Shape = Sequence[int | None]  # that is expected; None is any length


class Archive:
    """The arrays of an .npz file by their keys, each read when it is requested; or arrays of a file by other keys."""

    def __init__(self, source: Source, arrays: Mapping[str, Any] | None = None):
        self.source = source
        if arrays is not None:
            self._arrays, self.keys = arrays, set(arrays)
            return
        if source.kind != "zip":
            raise source.error("expected an .npz file, found none")
        with _damage(source, "the archive"):
            self._arrays = file = np.load(io.BytesIO(source.data), allow_pickle=False)
        self.keys = {name for name in file.files if f"{name}.npy" in file.zip.namelist()}

    def list_keys(self) -> str:
        return ", ".join(sorted(self.keys)[:12]) + (" and others" if len(self.keys) > 12 else "") or "none"

    def numbers(self, key: str, *shapes: Shape, finite: bool = True) -> np.ndarray:
        """An array of numbers as float64, if its shape is one of these, and all are finite or need not be."""
        array = check_numbers(self.source, key, self._read(key), *shapes)
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


def read_array(source: Source, *shapes: Shape) -> np.ndarray:
    """The numbers of an .npy file as float64, if its shape is one of these."""
    if source.kind != "npy":
        raise source.error("expected an .npy file, found none")
    with _damage(source, "the array"):
        array = np.load(io.BytesIO(source.data), allow_pickle=False)
    return check_numbers(source, "the array", array, *shapes)


def check_numbers(source: Source, key: str, array: np.ndarray, *shapes: Shape) -> np.ndarray:
    """An array as float64 if it has numbers and one of the shapes."""
    _check(source, key, array, "fiu", shapes)
    with np.errstate(over="ignore", invalid="ignore"):
        return array.astype(np.float64)


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
