"""The Carnegie Mellon University motion-capture database, from a folder or from its server."""

import csv
import hashlib
import re
import warnings
from collections.abc import Iterable
from pathlib import Path
from urllib.error import URLError

from sklearn.datasets import fetch_file, get_data_home

from skpose._parallel.progress import progress
from skpose.datasets._cmu_digests import DIGESTS
from skpose.datasets._motions import MotionDataset
from skpose.io._amc import read_amc
from skpose.io._asf import read_asf
from skpose.io._load import skeleton_of
from skpose.io._source import MocapFormatError, PathLike, Source, check_positive

SERVER = "http://mocap.cs.cmu.edu"
COLUMNS = ("subject", "trial", "action", "frames_per_second", "file")


def load_cmu(folder: PathLike, *, frame_rate: float = 120.0, verbose: int = 0) -> MotionDataset:
    """Read the motions of a folder of CMU's ASF and AMC files.

    Parameters
    ----------
    folder : str or path-like
        Either with an ``index.csv`` of the columns subject, trial, action, frames_per_second and file (relative to
        the folder), or just laid out as CMU does, ``subjects/SS/SS_TT.amc`` beside ``subjects/SS/SS.asf``.
    frame_rate : float, default=120.0
        Frames per second, Hz, where there is no index; most of CMU's files are at 120 Hz.
    verbose : int, default=0
        Whether to show how many files are read.

    Returns
    -------
    MotionDataset
        Subjects and trials as strings such as "02"; actions empty where there is no index.

    Raises
    ------
    FileNotFoundError
        If the folder holds no such files, or not one that the index names.
    MocapFormatError
        If a file or the index is not what it should be.

    Examples
    --------
    >>> from skpose.datasets import load_cmu
    >>> load_cmu("cmu")  # doctest: +SKIP
    MotionDataset(47 motions of 5 subjects: 1 bend over, scoop up, rise, lift arm, 1 jump, balance, 1 punch/strike, ...
    """
    folder = Path(folder)
    index = folder / "index.csv"
    rows = _read_index(index) if index.is_file() else _scan(folder, frame_rate)
    skeletons = {}
    motions = []
    with progress(f"{len(rows)} motions", len(rows), verbose) as advance:
        for row in rows:
            path = folder / row["file"]
            asf = skeleton_of(path)
            for needed in (asf, path):
                if not needed.is_file():
                    asker = index if index.is_file() else path
                    raise FileNotFoundError(f"{needed} is missing, but {asker} asks for it")
            if asf not in skeletons:
                with Source(asf, "an ASF file") as source:
                    skeletons[asf] = read_asf(source)
            with Source(path, "an AMC file") as source:
                motions.append(read_amc(source, skeletons[asf], frame_rate=row["frames_per_second"]))
            advance()
    return MotionDataset(motions, *([row[key] for row in rows] for key in ("subject", "trial", "action")))


def _read_index(path: Path) -> list[dict]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        reader = csv.DictReader(file)
        missing = [name for name in COLUMNS if name not in (reader.fieldnames or [])]
        if missing:
            raise MocapFormatError(path, 1, f"expected the columns {', '.join(COLUMNS)}; missing: {', '.join(missing)}")
        rows = []
        for row in reader:
            if any(row[name] is None for name in COLUMNS) or not row["file"]:
                raise MocapFormatError(path, reader.line_num, f"expected a value for each of {', '.join(COLUMNS)}")
            try:
                rate = float(row["frames_per_second"])
                check_positive("frames_per_second", rate)
            except ValueError:
                problem = f"frames_per_second: expected a positive number, found {row['frames_per_second']!r}"
                raise MocapFormatError(path, reader.line_num, problem) from None
            row["frames_per_second"] = rate
            rows.append(row)
    if not rows:
        raise MocapFormatError(path, None, "the index names no motions")
    return rows


def _scan(folder: Path, frame_rate: float) -> list[dict]:
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
    frame_rate: float = 120.0,
    verbose: int = 0,
) -> MotionDataset:
    """Download subjects of the CMU motion-capture database, unless they are there already, and read them.

    Parameters
    ----------
    subjects : iterable of int or str
        Numbers of the subjects, such as ``[2, 35]``.
    data_home : str or path-like, default=None
        Where to keep the files, in a folder "cmu_mocap"; None is scikit-learn's data home.
    frame_rate : float, default=120.0
        Frames per second, Hz. The database does not say it in a form that can be read; some subjects are at 60 Hz.
    verbose : int, default=0
        Whether to show how far it is.

    Returns
    -------
    MotionDataset
        All trials of the subjects, the actions in CMU's own words.

    Raises
    ------
    OSError
        If the server cannot be reached or has no such subject.

    Warns
    -----
    UserWarning
        If a file is not the one that skpose's own figures were measured on, where that is known.

    Notes
    -----
    The data is free for every use, also in products that are sold, but must not be resold itself. It was obtained
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
    # The index of what was asked for, for load_cmu.
    with (home / "index.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
    return load_cmu(home, verbose=verbose)


def _fetch_index(subject: str, folder: Path) -> dict[str, str]:
    """Trials of a subject and what they show, from the server's listing: tab-separated, the description last."""
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
    folder.mkdir(parents=True, exist_ok=True)
    try:
        path = Path(fetch_file(url, folder=folder, local_filename=name))
    except (URLError, TimeoutError, ConnectionError) as error:
        raise OSError(
            f"could not download {url} ({error}). Is there a network? Without one, put the files under {folder} by "
            "hand and use load_cmu"
        ) from error
    expected = DIGESTS.get(name)
    if expected is not None and digest(path) != expected:
        warnings.warn(
            f"{path} is not the {name} that skpose's figures were measured on; it may be cut short or newer. "
            "Delete it to download it again",
            stacklevel=3,
        )
    return path


def digest(path: Path) -> str:
    """SHA-256 of a text file whose line ends and trailing blanks may differ from copy to copy."""
    lines = (line.rstrip() for line in path.read_bytes().splitlines())
    return hashlib.sha256(b"\n".join(lines).strip()).hexdigest()
