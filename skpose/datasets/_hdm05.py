"""Reader of the motion-capture database HDM05, from a folder."""

from pathlib import Path

from skpose.datasets._folder import HDM05, INDEX, PathLike, is_index, read_index, read_rows, rows_of
from skpose.datasets._motions import MotionDataset, Rotations


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
    folder = Path(folder)
    is_indexed = is_index(folder / INDEX)
    files = [path for path in sorted(folder.rglob("*.amc*")) if HDM05.fullmatch(path.name)]
    if not (is_indexed or files):
        raise FileNotFoundError(f"{folder} has neither index.csv nor files such as HDM_bd_squat1Reps_001_120.amc")
    rows = read_index(folder / INDEX) if is_indexed else rows_of(files)
    return read_rows(rows, "raise", rotations, verbose, {})
