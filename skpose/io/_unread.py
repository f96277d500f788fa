"""Formats that are known and not read, and what to do with them: one entry for each, which all readers use."""

import re
from typing import NamedTuple

NUMBERS = rb"(?:[-+\d.e,;\s]|nan|inf)+\Z"  # a table of these alone


class Unread(NamedTuple):
    """A format that no reader reads.

    Attributes
    ----------
    name : str
        The format, with the suffixes of its files, as after "this is".
    signature : pattern of bytes
        How its files begin.
    advice : str
        The way out; empty if there is none.
    """

    name: str
    signature: re.Pattern[bytes]
    advice: str = ""


def _starts(name: str, signature: bytes, advice: str = "") -> Unread:
    return Unread(name, re.compile(signature, re.DOTALL | re.IGNORECASE), advice)


TO_BVH = "Blender imports it and exports BVH"
# The first that matches is the format.
UNREAD = (
    _starts("an empty file", rb"\s*\Z"),
    _starts("a pointer of Git LFS", rb"version https://git-lfs", "run git lfs pull"),
    _starts("UTF-16 text", rb"\xff\xfe|\xfe\xff", "save it as UTF-8"),
    _starts(
        "a pickle", rb"\x80[\x02-\x05]", "it could run any program and is never read; save its arrays by numpy.savez"
    ),
    _starts("a file of PyTorch (.pt, .pth)", rb"PK\x03\x04.*/data\.pkl", "save its tensors as arrays by numpy.savez"),
    _starts("an Excel table (.xlsx)", rb"PK\x03\x04.*\[Content_Types\]\.xml", "save it as CSV"),
    _starts("glTF (.glb, .vrm, .vrma)", rb"glTF", TO_BVH),
    _starts("FBX", rb"Kaydara FBX|; FBX", TO_BVH),
    _starts("USD", rb"PXR-USDC|#usda", TO_BVH),
    _starts("COLLADA (.dae)", rb"\s*<.{0,2000}<COLLADA", TO_BVH),
    _starts(
        "HDF5 (.h5, .slp), as of DeepLabCut and SLEAP",
        rb"\x89HDF\r\n",
        "the package movement reads it, and Keypoints takes positions in three dimensions",
    ),
    _starts(
        "a file of pose-format (.pose)",
        rb"\xcd\xcc(?:\xcc=|L>)",
        "Pose.read of pose-format has its points in body.data, as an array for Keypoints",
    ),
    _starts(
        "DeepLabCut's table of two dimensions",
        rb"scorer,[^\n]*\n(?:individuals,[^\n]*\n)?bodyparts,[^\n]*\ncoords,x,y,(?!z)",
        "Anipose triangulates several cameras, and its CSV is read",
    ),
    _starts(
        "DeepMimic's motion",
        rb'\s*\{.*(?-i:"Frames")\s*:\s*\[\s*\[\s*[-\d]',
        "it holds rotations of its own characters",
    ),
    _starts(
        "a JSON file of SPL Open Data",
        rb'\s*\{.*"tracking"\s*:\s*\[',
        "save a list of its frames {name: [x, y, z]}, which are in feet, scale=0.3048",
    ),
    _starts(
        "a table of joint angles of save_csv, without a skeleton",
        rb"frame,time,frame_rate,up,root_axes,",
        "pandas.read_csv reads it",
    ),
    _starts(
        "a table of OpenSim (.mot, .sto)",
        rb"(?:.*\n)?[ \t]*(?:nrows|ncolumns|indegrees|datarows|datacolumns)\b.*\n[ \t]*endheader\b",
        "load_trc reads the markers of the same trial",
    ),
    _starts(
        "a table of numbers without names",
        rb"(?=\s*[^\s,;]+[\s,;]+[^\s,;])" + NUMBERS,
        "numpy.loadtxt reads it for motion_from_qpos, if they are a robot's, or for Keypoints",
    ),
    _starts("a robot", rb"\s*(?:<.*)?<(?:mujoco|robot)[\s>]", "load_robot reads it"),
    _starts("a web page or XML", rb"(?!.{0,2000}<mvnx[\s>])\s*<"),
)
