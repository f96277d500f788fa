"""Readers of recorded databases: CMU, from a folder or from its server, and HDM05."""

import hashlib
import re
from collections.abc import Iterable
from pathlib import Path

from sklearn.datasets import fetch_file, get_data_home

from skpose._utils.files import write_csv
from skpose._utils.progress import progress
from skpose.datasets._folder import COLUMNS, HDM05, INDEX, RATE, PathLike, Row, is_index, read_index, read_rows, rows_of
from skpose.datasets._motions import MotionDataset, Rotations

SERVER = "http://mocap.cs.cmu.edu"
LISTING = "index.txt"  # of the trials of a subject
DIGESTS = "sha256.txt"  # of the files as they were downloaded: the server states none


def load_cmu(
    folder: PathLike, *, frame_rate: float | None = None, rotations: Rotations = "rotvec", verbose: int = 0
) -> MotionDataset:
    """Read the motions of a folder of CMU's ASF and AMC files.

    Parameters
    ----------
    folder : str or path-like
        Folder with an ``index.csv`` of the columns subject, trial, action, frames_per_second and file (relative to
        the folder), or with CMU's own layout, ``subjects/SS/SS_TT.amc`` and ``subjects/SS/SS.asf``.
    frame_rate : float, default=None
        Frames per second, Hz, if no index states it. None is 120 Hz, the rate of most CMU files, with a warning.
    rotations : {"rotvec", "file"}, default="rotvec"
        Whether joints of two or three Euler angles become ball joints or keep the angles of the files, see
        `MotionDataset`.
    verbose : int, default=0
        Whether to show progress.

    Returns
    -------
    MotionDataset
        The motions; subjects and trials are strings such as "02", actions are empty without an index. All motions
        of an ASF file share one skeleton.

    Raises
    ------
    FileNotFoundError
        If the folder has no such files, or lacks a file of the index.
    MocapFormatError
        If a file or the index does not follow its format.

    Examples
    --------
    >>> from skpose.datasets import load_cmu
    >>> load_cmu("cmu")  # doctest: +SKIP
    MotionDataset(47 motions of 5 subjects: 1 bend over, scoop up, rise, lift arm, 1 jump, balance, 1 punch/strike, ...
    """
    rows = _rows_in(folder, Path(folder).glob("subjects/*/*_*.amc"), "subjects/SS/SS_TT.amc")
    return _read(rows, frame_rate, rotations, verbose)


def _rows_in(folder: PathLike, files: Iterable[Path], example: str) -> list[Row]:
    """The rows of the index of a folder, or else of files by their names."""
    index = Path(folder, INDEX)
    rows = read_index(index) if is_index(index) else rows_of(sorted(files))
    if not rows:
        found = "neither" if Path(folder).is_dir() else "no folder"
        raise FileNotFoundError(f"expected {folder} with an index.csv or files {example}, found {found}")
    return rows


def _read(rows: list[Row], frame_rate: float | None, rotations: Rotations, verbose: int) -> MotionDataset:
    rows = [{"action": ""} | row | {RATE: row.get(RATE) or frame_rate} for row in rows]
    return read_rows(rows, "raise", rotations, verbose, {})


def fetch_cmu(
    subjects: Iterable[int | str],
    data_home: PathLike | None = None,
    *,
    frame_rate: float | None = None,
    rotations: Rotations = "rotvec",
    verbose: int = 0,
) -> MotionDataset:
    """Download subjects of the CMU motion-capture database if needed, and read them.

    Parameters
    ----------
    subjects : iterable of int or str
        Numbers of the subjects, such as ``[2, 35]``.
    data_home : str or path-like, default=None
        Folder in which the files are stored, under "cmu_mocap"; None is scikit-learn's data home.
    frame_rate : float, default=None
        Frames per second, Hz. The database does not state it in a readable form; some subjects have 60 Hz. None is
        120 Hz, with a warning, and blank in the index.
    rotations : {"rotvec", "file"}, default="rotvec"
        Whether joints of two or three Euler angles become ball joints or keep the angles of the files, see
        `MotionDataset`.
    verbose : int, default=0
        Whether to show progress.

    Returns
    -------
    MotionDataset
        All trials of the subjects, with CMU's own descriptions as actions.

    Raises
    ------
    OSError
        If the server cannot be reached or has no such subject.

    Notes
    -----
    An ``index.csv`` in the folder lists all downloaded subjects, so `load_cmu` can read them. ``sha256.txt`` has the
    digests of the files as they were downloaded; a file that has changed since is downloaded again, with a warning.

    The data is free for every use, including products that are sold, but must not be resold itself. It was obtained
    from mocap.cs.cmu.edu; the database was created with funding from NSF EIA-0196217.

    Examples
    --------
    >>> from skpose.datasets import fetch_cmu
    >>> fetch_cmu([2])  # doctest: +SKIP
    MotionDataset(10 motions of 1 subjects: ...
    """
    home = Path(get_data_home(data_home)) / "cmu_mocap"
    names = list(dict.fromkeys(f"{int(subject):02}" for subject in subjects))
    if not names:
        raise ValueError("subjects must name at least one subject, got none")
    rows = []
    trials = {name: _fetch_index(name, home, home / "subjects" / name) for name in names}
    with progress(SERVER, sum(map(len, trials.values())), verbose) as advance:
        for name in names:
            folder = home / "subjects" / name
            _fetch(f"{SERVER}/subjects/{name}/{name}.asf", home, folder, f"{name}.asf")
            for trial, action in trials[name].items():
                path = _fetch(f"{SERVER}/subjects/{name}/{name}_{trial}.amc", home, folder, f"{name}_{trial}.amc")
                rows.append(dict(zip(COLUMNS, (name, trial, action, frame_rate, path), strict=True)))
                advance()
    _add_to_index(home / INDEX, rows)
    return _read(rows, frame_rate, rotations, verbose)


def _add_to_index(path: Path, rows: list[Row]) -> None:
    known = read_index(path) if path.exists() else []
    merged = {row["file"]: row for row in (*known, *rows)}
    labels = ([row.get(name) for name in COLUMNS[:-1]] for row in merged.values())
    files = (file.relative_to(path.parent).as_posix() for file in merged)
    write_csv(path, [COLUMNS, *([*row, file] for row, file in zip(labels, files, strict=True))], replace=True)


def _fetch_index(subject: str, home: Path, folder: Path) -> dict[str, str]:
    """The action of each trial of a subject, from the server's tab-separated listing, the description last."""
    query = f"subjectnumber={int(subject)}&motion=%25%25%25&maincat=%25&subcat=%25&subtext=yes"
    path = _fetch(f"{SERVER}/search.php?{query}", home, folder, LISTING)
    trials = {}
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        name, *fields = (field.strip() for field in line.split("\t"))
        match = re.fullmatch(r"(\d+)_(\d+)", name)
        if match and int(match[1]) == int(subject) and f"{name}.amc" in fields:
            action = fields[-1]
            trials[match[2]] = "" if re.fullmatch(rf"{name}\.\w+", action) else action
    if not trials:
        path.unlink()  # the next call asks the server again
        raise OSError(f"the CMU server lists no motions of subject {subject}")
    return trials


def _fetch(url: str, home: Path, folder: Path, name: str) -> Path:
    """Download a file unless it exists with the digest that it had when it was downloaded."""
    folder.mkdir(parents=True, exist_ok=True)
    digests, key = home / DIGESTS, (folder / name).relative_to(home).as_posix()
    known = dict(line.split(" ", 1)[::-1] for line in digests.read_text().splitlines()) if digests.exists() else {}
    try:
        path = Path(fetch_file(url, folder=folder, local_filename=name, sha256=known.get(key)))
    except OSError as error:
        raise OSError(f"could not download {url} ({error}); put the files into {folder} and use load_cmu") from error
    if key not in known and name != LISTING:  # the server may add motions
        with digests.open("a") as file:
            file.write(f"{hashlib.sha256(path.read_bytes()).hexdigest()} {key}\n")
    return path


# --- HDM05 ------------------------------------------------------------------------------------------------------------


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
    files = (path for path in Path(folder).rglob("*.amc*") if HDM05.fullmatch(path.name))
    return read_rows(_rows_in(folder, files, "HDM_bd_squat1Reps_001_120.amc"), "raise", rotations, verbose, {})
