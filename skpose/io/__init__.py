"""Readers of motion-capture files, Acclaim ASF/AMC and Biovision BVH, and a writer of BVH.

Angles come in radians, lengths in metres. What a file gets wrong is said in a `MocapFormatError`, with the line and the
column.
"""

from skpose.io._amc import load_amc
from skpose.io._asf import load_asf
from skpose.io._bvh import load_bvh
from skpose.io._load import load_motion
from skpose.io._save import save_bvh
from skpose.io._source import MocapFormatError

__all__ = ["MocapFormatError", "load_amc", "load_asf", "load_bvh", "load_motion", "save_bvh"]
