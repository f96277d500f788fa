"""Readers of motion-capture files; writers of BVH, .npz and CSV.

Acclaim ASF/AMC, Biovision BVH and AMASS are motions; TRC, C3D and keypoints, as JSON, CSV or arrays, are positions
without a skeleton. Robots are in `skpose.robots`.
Angles are in radians, lengths in metres. A file that does not follow its format raises `MocapFormatError` with the line
and the column, or with the key.
"""

from skpose.io._amass import load_amass
from skpose.io._amc import load_amc
from skpose.io._asf import AsfFile, load_asf
from skpose.io._bvh import load_bvh
from skpose.io._c3d import C3DQuantity, load_c3d, load_c3d_quantities
from skpose.io._error import MocapFormatError
from skpose.io._keypoints import load_keypoints
from skpose.io._load import asf_path, file_format, load_motion
from skpose.io._save import save_bvh
from skpose.io._save_csv import save_csv
from skpose.io._save_npz import save_npz
from skpose.io._trc import load_trc

__all__ = [
    "AsfFile",
    "C3DQuantity",
    "MocapFormatError",
    "asf_path",
    "file_format",
    "load_amass",
    "load_amc",
    "load_asf",
    "load_bvh",
    "load_c3d",
    "load_c3d_quantities",
    "load_keypoints",
    "load_motion",
    "load_trc",
    "save_bvh",
    "save_csv",
    "save_npz",
]
