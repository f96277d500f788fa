"""Names of `skpose.io` that the other packages of skpose use, in addition to the public ones."""

from skpose.io._amc import asf_path
from skpose.io._formats import FORMATS, Format, format_of
from skpose.io._keypoints import read_stored
from skpose.io._opening import open_file
from skpose.io._source import Source
from skpose.io._stored import Stored

__all__ = [
    "FORMATS",
    "Format",
    "Source",
    "Stored",
    "asf_path",
    "format_of",
    "is_robot",
    "open_file",
    "read_stored",
]
