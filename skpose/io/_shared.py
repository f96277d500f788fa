"""Names of `skpose.io` that the other packages of skpose use, in addition to the public ones."""

from skpose.io._load import has_keypoints
from skpose.io._npz import Archive, read_array
from skpose.io._opening import open_file
from skpose.io._source import Source

__all__ = ["Archive", "Source", "has_keypoints", "open_file", "read_array"]
