"""Opening of files for reading."""

from pathlib import Path
from typing import IO

from skpose.io._arguments import PathLike


def open_file(path: PathLike) -> IO[bytes]:
    return Path(path).open("rb")
