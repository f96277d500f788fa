"""Readers of the Carnegie Mellon University motion-capture database, from a folder or from its server."""

import csv
import hashlib
import re
from collections.abc import Iterable
from pathlib import Path
from urllib.error import URLError

from sklearn.datasets import fetch_file, get_data_home

from skpose._files import new_file
from skpose._parallel.progress import progress
from skpose.datasets._cmu_digests import DIGESTS
from skpose.datasets._index import COLUMNS, INDEX, PathLike, check_folder, read_index, read_motions
from skpose.datasets._motions import MotionDataset
from skpose.io._shared import asf_path

SERVER = "http://mocap.cs.cmu.edu"


def load_cmu(folder: PathLike, *, frame_rate: float | None = None, verbose: int = 0) -> MotionDataset:
    """Read the motions of a folder of CMU's ASF and AMC files.

    Parameters
    ----------
    folder : str or path-like
        Folder with an ``index.csv`` of the columns subject, trial, action, frames_per_second and file (relative to
        the folder), or with CMU's own layout, ``subjects/SS/SS_TT.amc`` and ``subjects/SS/SS.asf``.
    frame_rate : float, default=None
        Frames per second, Hz, where no index states it. None is 120 Hz, as of most of CMU's files, with a warning.
    verbose : int, default=0
        Whether to show how many files have been read.

    Returns
    -------
    MotionDataset
        The motions; subjects and trials are strings such as "02", actions are empty if there is no index. All motions
        of an ASF file share one skeleton.

    Raises
    ------
    FileNotFoundError
        If the folder holds no such files, or lacks one that the index names.
    MocapFormatError
        If a file or the index does not follow its format.

    Examples
    --------
    >>> from skpose.datasets import load_cmu
    >>> load_cmu("cmu")  # doctest: +SKIP
    MotionDataset(47 motions of 5 subjects: 1 bend over, scoop up, rise, lift arm, 1 jump, balance, 1 punch/strike, ...
    """
    folder = Path(folder)
    check_folder(folder)
    index = folder / INDEX if (folder / INDEX).is_file() else None
    rows = read_index(index) if index else _scan(folder, frame_rate)
    rows = [row | {"frames_per_second": row["frames_per_second"] or frame_rate} for row in rows]
    return read_motions(folder, rows, index, asf_path, verbose)


def _scan(folder: Path, frame_rate: float | None) -> list[dict]:
    """Return rows as those of an index for a folder with CMU's own layout."""
    paths = sorted((folder / "subjects").glob("*/*_*.amc"))
    if not paths:
        raise FileNotFoundError(f"{folder} holds neither an index.csv nor files named subjects/SS/SS_TT.amc")
    rows = []
    for path in paths:
        subject, trial = path.stem.rsplit("_", 1)
        file = path.relative_to(folder)
        values = (subject, trial, "", frame_rate, file)
        rows.append(dict(zip(COLUMNS, values, strict=True)))
    return rows


def fetch_cmu(
    subjects: Iterable[int | str],
    data_home: PathLike | None = None,
    *,
    frame_rate: float | None = None,
    verbose: int = 0,
) -> MotionDataset:
    """Download subjects of the CMU motion-capture database, unless they are there already, and read them.

    Parameters
    ----------
    subjects : iterable of int or str
        Numbers of the subjects, such as ``[2, 35]``.
    data_home : str or path-like, default=None
        Folder in which the files are stored, under "cmu_mocap"; None is scikit-learn's data home.
    frame_rate : float, default=None
        Frames per second, Hz. The database does not state it in a readable form; some subjects are at 60 Hz. None is
        120 Hz, with a warning, and blank in the index.
    verbose : int, default=0
        Whether to show how many files have been downloaded and read.

    Returns
    -------
    MotionDataset
        All trials of the subjects, with CMU's own descriptions as actions.

    Raises
    ------
    OSError
        If the server cannot be reached or has no such subject, or if one of the files that skpose's figures were
        measured on has another SHA-256 digest; what was downloaded is then removed.

    Notes
    -----
    An ``index.csv`` in the folder lists all subjects that have been downloaded, so that `load_cmu` reads them.

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
    trials = {name: _fetch_index(name, home / "subjects" / name) for name in names}
    with progress(SERVER, sum(map(len, trials.values())), verbose) as advance:
        for name in names:
            folder = home / "subjects" / name
            _fetch(f"{SERVER}/subjects/{name}/{name}.asf", folder, f"{name}.asf")
            for trial, action in trials[name].items():
                path = _fetch(f"{SERVER}/subjects/{name}/{name}_{trial}.amc", folder, f"{name}_{trial}.amc")
                file = path.relative_to(home).as_posix()
                rows.append(dict(zip(COLUMNS, (name, trial, action, frame_rate, file), strict=True)))
                advance()
    _add_to_index(home / INDEX, rows)
    return read_motions(home, rows, home / INDEX, asf_path, verbose)


def _add_to_index(path: Path, rows: list[dict]) -> None:
    """Write the rows to the index, after those of other files that are in it."""
    new = {row["file"] for row in rows}
    others = [row for row in read_index(path) if row["file"] not in new] if path.exists() else []
    with new_file(path, replace=True) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        writer.writerows([*others, *rows])


def _fetch_index(subject: str, folder: Path) -> dict[str, str]:
    """Return the action of each trial of a subject, from the server's listing: tab-separated, the description last."""
    query = f"subjectnumber={int(subject)}&motion=%25%25%25&maincat=%25&subcat=%25&subtext=yes"
    path = _fetch(f"{SERVER}/search.php?{query}", folder, "index.txt")
    trials = {}
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        name, *fields = (field.strip() for field in line.split("\t"))
        match = re.fullmatch(r"(\d+)_(\d+)", name)
        if match and int(match[1]) == int(subject) and f"{name}.amc" in fields:
            action = fields[-1]
            trials[match[2]] = "" if re.fullmatch(rf"{name}\.\w+", action) else action
    if not trials:
        path.unlink()  # so that the next call asks the server again
        raise OSError(f"the CMU server lists no motions of subject {subject}")
    return trials


def _fetch(url: str, folder: Path, name: str) -> Path:
    """Return the path of a downloaded file, downloaded now unless it exists; refuse one with another digest."""
    folder.mkdir(parents=True, exist_ok=True)
    existed = (folder / name).exists()
    try:
        path = Path(fetch_file(url, folder=folder, local_filename=name))
    except (URLError, TimeoutError, ConnectionError) as error:
        raise OSError(
            f"could not download {url} ({error}). Is there a network? Without one, put the files under {folder} by "
            "hand and use load_cmu"
        ) from error
    expected = DIGESTS.get(name)
    if expected is not None and digest(path) != expected:
        if not existed:
            path.unlink()
        remedy = f"Delete {path} to download it again" if existed else "Nothing was kept; try again"
        raise OSError(
            f"the SHA-256 digest of {name} differs from that of the file that skpose's figures were measured on: it "
            f"may be cut short or newer. {remedy}, or use load_cmu, which reads any version"
        )
    return path


def digest(path: Path) -> str:
    """Return the SHA-256 of a text file without line ends and trailing blanks, which differ from copy to copy."""
    lines = (line.rstrip() for line in path.read_bytes().splitlines())
    return hashlib.sha256(b"\n".join(lines).strip()).hexdigest()
