"""Readers of motion-capture files; writers of BVH, SMPL, .npz and CSV.

BVH, Acclaim ASF/AMC and SMPL files hold motions; TRC, C3D and keypoint files (JSON, CSV, arrays) hold positions
without a skeleton. Robots are in `skpose.robots`. Angles are in radians, lengths in metres. A file that does not follow
its format raises `MocapFormatError`.
"""

from skpose.io._acclaim import AsfFile as AsfFile, load_amc, load_asf
from skpose.io._amass import load_amass
from skpose.io._bvh import load_bvh, save_bvh
from skpose.io._c3d import C3DQuantity as C3DQuantity, load_c3d, load_c3d_quantities
from skpose.io._formats import load_motion
from skpose.io._keypoints import load_keypoints
from skpose.io._save_npz import save_npz
from skpose.io._save_smpl import save_smpl
from skpose.io._source import MocapFormatError
from skpose.io._tables import load_trc, save_csv

__all__ = [
    "MocapFormatError",
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
    "save_smpl",
]
