"""Reader of the motion-capture database HDM05, from a folder."""

import re
from pathlib import Path

from skpose.datasets._index import COLUMNS, PathLike, load_folder
from skpose.datasets._motions import MotionDataset, Rotations

NAME = re.compile(r"HDM_(?P<subject>[a-z]+)_(?P<trial>(?P<action>.+?)_?\d*)_(?P<rate>\d+)\.amc(\.gz)?", re.IGNORECASE)


def load_hdm05(folder: PathLike, *, rotations: Rotations = "rotvec", verbose: int = 0) -> MotionDataset:
    """Read motions of the database HDM05 in the ASF/AMC format from a folder.

    Labels come from the names of the files: HDM_bd_squat1Reps_001_120.amc is the first recording of the person "bd" and
    the action "squat1Reps", at 120 Hz, on the skeleton HDM_bd.asf of the same folder.

    Parameters
    ----------
    folder : str or path-like
        Folder with such files, in it or in folders below, or with an ``index.csv`` of the columns subject, trial,
        action, frames_per_second and file (relative to the folder).
    rotations : {"rotvec", "file"}, default="rotvec"
        Whether joints of two or three Euler angles become ball joints or keep the angles of the files, see
        `MotionDataset`.
    verbose : int, default=0
        Whether to show progress.

    Returns
    -------
    MotionDataset
        The motions, sorted by the paths of the files, or in the order of the index. All motions of an ASF file share
        one skeleton.

    Raises
    ------
    FileNotFoundError
        If the folder has no such files, or lacks a file of the index or an ASF file.
    MocapFormatError
        If a file or the index does not follow its format.

    References
    ----------
    M. Müller, T. Röder, M. Clausen, B. Eberhardt, B. Krüger, A. Weber, "Documentation Mocap Database HDM05", technical
    report CG-2007-2, Universität Bonn, 2007.

    Examples
    --------
    >>> from skpose.datasets import load_hdm05
    >>> load_hdm05("hdm05")  # doctest: +SKIP
    MotionDataset(188 motions of 3 subjects: 18 deposit on floor, 18 elbow to knee, 16 grab high, ...
    """
    return load_folder(folder, _scan, _asf_path, verbose, rotations)


def _scan(folder: Path) -> list[dict]:
    """Rows as of an index for files named as in HDM05."""
    rows = []
    for path in sorted(folder.rglob("*.amc*")):
        match = NAME.fullmatch(path.name)
        if match:
            values = (match["subject"], match["trial"], match["action"], float(match["rate"]), path.relative_to(folder))
            rows.append(dict(zip(COLUMNS, values, strict=True)))
    if not rows:
        raise FileNotFoundError(f"{folder} has neither index.csv nor files such as HDM_bd_squat1Reps_001_120.amc")
    return rows


def _asf_path(amc: Path) -> Path:
    """The path of the person's skeleton: HDM_bd.asf for HDM_bd_squat1Reps_001_120.amc."""
    return amc.with_name("_".join(amc.name.split("_")[:2]) + ".asf")
