"""Motions of any format, which is recognised by the file's content."""

import os
import re
from pathlib import Path
from typing import Literal

from skpose.io._amass import read_amass
from skpose.io._amc import read_amc
from skpose.io._arguments import PathLike, Readable
from skpose.io._asf import AsfFile, content_of
from skpose.io._bvh import read_bvh
from skpose.io._error import MocapFormatError
from skpose.io._keypoints import POSITIONS
from skpose.io._keypoints_csv import ANGLES, is_angles, is_table
from skpose.io._npz import Archive
from skpose.io._other import is_numbers, route_of
from skpose.io._save_npz import VERSION, read_npz
from skpose.io._source import Source
from skpose.io._up import Up
from skpose.io._words import WHOLE
from skpose.skeleton import Motion

Format = Literal["BVH", "AMC", "ASF", "AMASS", "NPZ", "TRC", "C3D"]
KINDS = "a BVH, AMC, ASF, AMASS, TRC or C3D file"
# The last line of the head of a table of OpenSim, and one before it.
OPENSIM = re.compile(r"^[ \t]*endheader[ \t\r]*$", re.MULTILINE | re.IGNORECASE)
OPENSIM_KEY = re.compile(r"^[ \t]*(nrows|ncolumns|indegrees|datarows|datacolumns)\b", re.MULTILINE | re.IGNORECASE)
AMASS = "an AMASS file", "is the pelvis"
NUMERIC = re.compile(r"[+-]?[.\d]|nan|[+-]?inf", re.ASCII | re.IGNORECASE)  # how a number begins, also a damaged one
AMC_KEYWORD = re.compile(r":[a-z][\w-]*", re.ASCII)  # such as :degrees and :fully-specified
FORMATS = (
    "expected HIERARCHY (BVH), a keyword such as :DEGREES or the number of a frame (AMC), PathFileType (TRC), an .npz "
    "file (AMASS) or a C3D file"
)
ASF_KEYWORDS = {":version", ":name", ":units", ":documentation", ":root", ":bonedata", ":hierarchy", ":skin"}


def load_motion(
    path: Readable,
    *,
    asf: Readable | AsfFile | None = None,
    frame_rate: float | None = None,
    scale: float | None = None,
    on_nan: Literal["raise", "drop"] = "raise",
    trust: Literal["header", "rows"] = "header",
    stretch: Literal["raise", "mean"] = "raise",
    missing: Literal["raise", "rest"] = "raise",
    model: PathLike | None = None,
    hands: bool = True,
    root: str | None = None,
    root_offset: Literal["replace", "add"] = "replace",
    up: Up | None = None,
) -> Motion:
    """Read a motion from a BVH, AMC or AMASS file, or from one that `save_npz` wrote.

    The format is recognised by the content of the file, not by its name.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    asf : str, path-like, file or AsfFile, default=None
        The skeleton of an AMC file. None is the file at `asf_path`: walk.asf for walk.amc, or, as in the CMU database,
        02.asf for 02_01.amc, or HDM_bd.asf for HDM_bd_walk_001_120.amc.
    frame_rate : float, default=None
        Frames per second, Hz. None is what a BVH or AMASS file states, and 120 Hz for an AMC file, which does not state
        it, with a warning, see `load_amc`. A number comes before what a file states, with a warning where they differ;
        it changes the times and not the poses, see `Motion.resample`.
    scale : float, default=None
        Metres per unit of length. None is 1 for BVH, and the unit of the ASF file for AMC. AMASS files and those of
        `save_npz` are in metres.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite: refuse the file, or leave
        these frames out. The others keep their times.
    trust, stretch : str
        How to read a BVH file, see `load_bvh`.
    missing : str
        How to read an AMC file, see `load_amc`.
    model : str or path-like, default=None
        The file of the body model of an AMASS file, see `load_amass`.
    hands : bool, default=True
        How to read an AMASS file, see `load_amass`.
    root : str, default=None
        Name of the joint of a BVH file that is the root of the skeleton, see `load_bvh`. The root of an AMC file is
        that of its skeleton.
    root_offset : str, default="replace"
        How to read a BVH file, see `load_bvh`.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The direction of the file's world that points up, see `load_bvh`. None is y for BVH and AMC files and z for
        AMASS files, with a warning where poses stand along another axis, and what a file of `save_npz` states.

    Returns
    -------
    Motion
        Motion with angles in rad and lengths in m.

    Raises
    ------
    MocapFormatError
        If the file is none of these, or not whole; with its name, and the line and the column or the key.
    OSError
        If it cannot be read, or the skeleton of an AMC file is not found.
    ValueError
        If an AMC file has no `asf` and is not a path, or a `root` is chosen for a file that is not BVH.

    See Also
    --------
    file_format : Return the format of a file.
    save_bvh, save_npz : Write a motion.
    load_trc, load_c3d, load_keypoints : Read positions of markers and keypoints.

    Examples
    --------
    >>> from skpose.io import load_motion
    >>> load_motion("dance.bvh.gz", scale=0.01)  # doctest: +SKIP
    Motion(1200 frames at 60 Hz, 20.0 s, y up, Skeleton(n_joints=52, n_dofs=114))
    >>> load_motion("cmu/subjects/02/02_01.amc", frame_rate=120)  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, y up, Skeleton(n_joints=30, n_dofs=56))
    """
    with Source(path, "a BVH, AMC or AMASS file", binary=True) as source:
        if source.binary == "zip":
            archive = Archive(source)
            kind, of_root = ("a file of save_npz", "is stated") if VERSION in archive.keys else AMASS
            if root is not None:
                raise ValueError(f"root={root!r} is for BVH files; {source.name} is {kind}, whose root {of_root}")
            if scale not in (None, 1.0):
                raise ValueError(f"{source.name} is {kind}, in metres: scale must be None, got {scale!r}")
            if VERSION in archive.keys:
                return read_npz(source, archive, frame_rate=frame_rate, on_nan=on_nan, up=up)
            return read_amass(source, archive, frame_rate=frame_rate, model=model, hands=hands, on_nan=on_nan, up=up)
        found = _format_of(source)
        if found == "BVH":
            scale = 1.0 if scale is None else scale
            return read_bvh(
                source,
                frame_rate=frame_rate,
                scale=scale,
                on_nan=on_nan,
                trust=trust,
                stretch=stretch,
                root=root,
                root_offset=root_offset,
                up=up,
            )
        if found in ("TRC", "C3D"):
            raise source.error(
                f"this is a {found} file, positions of markers without a skeleton: load_{found.lower()} reads it, "
                "fit_skeleton and inverse_kinematics find the motion"
            )
        if found == "ASF":
            raise source.error("this is a skeleton (ASF), which has no motion: load_asf reads it, load_motion its AMC")
        if root is not None:
            raise ValueError(
                f"root={root!r} is for BVH files; {source.name} is an AMC file, whose root its ASF file states"
            )
        if asf is None:
            if not isinstance(path, str | os.PathLike):
                raise ValueError("an AMC file needs its skeleton: pass asf=, the ASF file")
            asf = asf_path(path)
            if not os.path.lexists(asf):
                raise FileNotFoundError(f"{source.name} needs its skeleton and there is no {asf}: pass asf=, the file")
        content = content_of(asf, scale)
        return read_amc(source, content, frame_rate=frame_rate, on_nan=on_nan, missing=missing, up=up)


def file_format(path: Readable) -> Format:
    """Return the format of a motion-capture file, recognised by its first words or bytes.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one, whose beginning is then read; compressed by gzip or not.

    Returns
    -------
    {"BVH", "AMC", "ASF", "AMASS", "NPZ", "TRC", "C3D"}
        The format; an .npz file is "NPZ" if `save_npz` wrote it, and "AMASS" otherwise. The rest of the file is not
        checked.

    Raises
    ------
    MocapFormatError
        If the file is none of these.
    OSError
        If it cannot be read.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from skpose.io import file_format
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "dance.txt")
    ...     _ = path.write_text("HIERARCHY\\nROOT Hips\\n")
    ...     file_format(path)
    'BVH'
    """
    with Source(path, KINDS, binary=True) as source:
        return _format_of(source)


def has_keypoints(path: Readable) -> bool:
    """Return whether a file is one of those that `load_keypoints` reads, by its beginning, or by the keys of a zip."""
    with Source(path, KINDS, binary=True) as source:
        if source.binary == "zip":
            return bool(_keys_of(source) & set(POSITIONS))
        if source.binary is not None or is_numbers(source.head) or is_angles(source.head):
            return source.binary == "npy"
        return source.head.lstrip()[:1] in ("{", "[") or is_table(source.head)


def _keys_of(source: Source) -> set[str]:
    """Return the keys of an open archive, none where it is damaged, which its reader reports."""
    try:
        return Archive(source).keys
    except MocapFormatError:
        return set()


def _format_of(source: Source) -> Format:
    """Return the format of an open file, by its first word that is not in a comment, or as a zip archive."""
    if source.binary == "zip":
        return "NPZ" if VERSION in _keys_of(source) else "AMASS"
    if source.binary == "C3D":
        return "C3D"
    if source.binary == "npy":
        raise source.error("this is an array (.npy), not a motion: load_keypoints reads one of keypoints")
    if OPENSIM.search(source.head) and OPENSIM_KEY.search(source.head):
        raise source.error(
            "this is a table of OpenSim (.mot or .sto), whose columns have a meaning only in a model (.osim), which "
            "is not read: load_trc reads the markers of the same trial, fit_skeleton and inverse_kinematics find the "
            "motion"
        )
    if is_angles(source.head):
        raise source.error(f"this is {ANGLES}")
    if route := route_of(source.head):
        raise source.error(f"{route}; fit_skeleton and inverse_kinematics find the motion")
    for i, line in enumerate(lines := source.head.splitlines()):
        words = line.partition("#")[0].split()
        word = words[0].lower() if words else ""
        if word.partition(",")[0] == "pathfiletype":  # some are separated by commas
            return "TRC"
        if word == "hierarchy":
            return "BVH"
        if word in ASF_KEYWORDS:
            return "ASF"
        if AMC_KEYWORD.fullmatch(word) or (WHOLE.fullmatch(word) and _is_frame(lines[i:])):
            return "AMC"
        if word:
            raise source.error(f"this is not a motion file: {FORMATS}, found {' '.join(words)[:40]!r}")
    if "#" in source.head:
        return "AMC"  # only comments so far, which BVH does not have
    for chunk in source.chunks():  # so that a gzip file that unpacks to nothing but blanks is called one
        if chunk.text.strip():
            break
    raise source.error(f"this is not a motion file: {FORMATS}, found {len(source.head):,} blanks at its beginning")


def _is_frame(lines: list[str]) -> bool:
    """Return whether lines begin as a frame of an AMC file: its number alone, and a bone with numbers, if any line is.

    Texts may begin with a number, too. A line that may be cut is not looked at.
    """
    number, *more = [words for line in lines if (words := line.partition("#")[0].split())][:3]
    if len(number) > 1:
        return False
    bone = more[0] if len(more) > 1 else []
    return len(bone) < 2 or NUMERIC.match(bone[1]) is not None


def asf_path(amc: PathLike) -> Path:
    """Return the path at which the ASF file of an AMC file is expected.

    Parameters
    ----------
    amc : str or path-like
        The AMC file.

    Returns
    -------
    Path
        The path walk.asf in the folder of walk.amc if there is such a file; otherwise the name up to the last
        underscore, as in the CMU database: 02.asf in the folder of 02_01.amc; or up to the one before it, and so on, as
        in HDM05: HDM_bd.asf for HDM_bd_walk_001_120.amc. For a link also by the name and the folder of the file that it
        is a link to. Where there is none of them, 02.asf, which does not exist.

    Examples
    --------
    >>> from skpose.io import asf_path
    >>> asf_path("cmu/subjects/02/02_01.amc").as_posix()
    'cmu/subjects/02/02.asf'
    """
    amc = Path(amc)
    candidates = _asf_paths(amc)
    linked = _asf_paths(Path(os.path.realpath(amc))) if amc.is_symlink() else []
    found = next((path for path in candidates + linked if os.path.lexists(path) and not path.is_dir()), None)
    return found or candidates[min(1, len(candidates) - 1)]


def _asf_paths(amc: Path) -> list[Path]:
    name = amc.name[:-3] if amc.name.lower().endswith(".gz") else amc.name
    parts = Path(name).stem.split("_")
    return [amc.with_name(f"{'_'.join(parts[:n])}.asf") for n in range(len(parts), 0, -1)]
