"""Motions of either format, told apart by what is in the file."""

import os
from pathlib import Path
from typing import Literal

from skpose.io._amc import read_amc
from skpose.io._asf import read_asf
from skpose.io._bvh import read_bvh
from skpose.io._source import WHOLE, PathLike, Readable, Source
from skpose.skeleton import Motion

ASF_KEYWORDS = {":version", ":name", ":units", ":documentation", ":root", ":bonedata", ":hierarchy", ":skin"}


def load_motion(
    path: Readable,
    *,
    asf: Readable | None = None,
    frame_rate: float = 120.0,
    scale: float | None = None,
    on_nan: Literal["raise", "drop"] = "raise",
    trust: Literal["header", "rows"] = "header",
    stretch: Literal["raise", "mean"] = "raise",
    missing: Literal["raise", "rest"] = "raise",
) -> Motion:
    """Read a motion from a BVH file or an AMC file, whichever it is.

    What the file is called does not matter; its first words say what it is.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    asf : str, path-like or file, default=None
        The skeleton of an AMC file. None looks beside it: walk.asf for walk.amc, and as CMU has it, 02.asf for
        02_01.amc.
    frame_rate : float, default=120.0
        Frames per second of an AMC file, which does not say; a BVH file does.
    scale : float, default=None
        Metres per unit of length. None is 1 for BVH, and what the skeleton's file says for AMC.
    on_nan : {"raise", "drop"}, default="raise"
        What to do with frames in which a number is NaN or infinite.
    trust, stretch : str
        How to take a BVH file, see `load_bvh`.
    missing : str
        How to take an AMC file, see `load_amc`.

    Returns
    -------
    Motion

    Raises
    ------
    MocapFormatError
        If the file is neither, or not whole; with its name, the line and the column.
    OSError
        If it cannot be read, or the skeleton of an AMC file is not found.

    Examples
    --------
    >>> from skpose.io import load_motion
    >>> load_motion("dance.bvh.gz", scale=0.01)  # doctest: +SKIP
    Motion(1200 frames at 60 Hz, 20.0 s, Skeleton(n_joints=52, n_dofs=114))
    >>> load_motion("cmu/subjects/02/02_01.amc")  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, Skeleton(n_joints=30, n_dofs=56))
    """
    with Source(path, "a BVH or AMC file") as source:
        kind = kind_of(source)
        if kind == "BVH":
            scale = 1.0 if scale is None else scale
            return read_bvh(source, scale=scale, on_nan=on_nan, trust=trust, stretch=stretch)
        if kind == "ASF":
            raise source.error("this is a skeleton (ASF), which has no motion: load_asf reads it, load_motion its AMC")
        if asf is None:
            if not isinstance(path, str | os.PathLike):
                raise ValueError("an AMC file needs its skeleton: pass asf=, the ASF file")
            asf = skeleton_of(path)
            if not asf.is_file():
                raise FileNotFoundError(f"{source.name} needs its skeleton and there is no {asf}: pass asf=, the file")
        with Source(asf, "an ASF file") as skeleton:
            asf = read_asf(skeleton, scale)
        return read_amc(source, asf, frame_rate=frame_rate, on_nan=on_nan, missing=missing)


def kind_of(source: Source) -> Literal["BVH", "ASF", "AMC"]:
    """What a file is, by its first words that are not a comment."""
    for line in source.head.splitlines():
        word, *_ = line.partition("#")[0].lower().split() or [""]
        if word == "hierarchy":
            return "BVH"
        if word.startswith(":"):
            return "ASF" if word in ASF_KEYWORDS else "AMC"
        if WHOLE.fullmatch(word):
            return "AMC"
        if word:
            raise source.error(f"expected HIERARCHY (BVH) or a keyword such as :DEGREES (AMC), found {word[:40]!r}")
    return "AMC"  # nothing but comments so far, which BVH does not have


def skeleton_of(amc: PathLike) -> Path:
    """Where the skeleton of a motion is: walk.asf beside walk.amc, or where CMU has it, 02.asf beside 02_01.amc."""
    amc = Path(amc)
    stem = amc.name.removesuffix(".gz").removesuffix(amc.suffix).rsplit(".", 1)[0]
    own = amc.with_name(f"{stem}.asf")
    return own if own.is_file() else amc.with_name(f"{stem.rsplit('_', 1)[0]}.asf")
