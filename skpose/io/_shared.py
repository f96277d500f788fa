"""Names of `skpose.io` that the other packages of skpose use, in addition to the public ones."""

from skpose.io._load import has_keypoints
from skpose.io._opening import open_file

__all__ = ["has_keypoints", "open_file"]
