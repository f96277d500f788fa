"""Arrays of .npz and .npy files, checked for kind and shape. Nothing is unpickled."""

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from skpose.io._source import LARGEST, MocapFormatError, Source

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
