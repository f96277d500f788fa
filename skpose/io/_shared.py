"""Names of `skpose.io` that the other packages of skpose use, in addition to the public ones."""

from skpose.io._keypoints import read_stored
from skpose.io._load import has_keypoints
from skpose.io._npz import Archive, read_array
from skpose.io._opening import open_file
from skpose.io._robot_kind import is_robot
from skpose.io._source import Source
from skpose.io._stored import Stored

__all__ = ["Archive", "Source", "Stored", "has_keypoints", "is_robot", "open_file", "read_array", "read_stored"]
