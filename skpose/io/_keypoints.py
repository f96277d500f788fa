"""Keypoints that a program has stored as arrays of numpy, as JSON or as a table."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from skpose._utils.units import complaint_of_extent
from skpose._utils.validation import refuse_infinite
from skpose.io._amass import is_smpl
from skpose.io._conventions import Stored, Up, Zeros, as_confidences, check_options, choose_rate, choose_scale
from skpose.io._keypoints_json import is_json, read_json
from skpose.io._save_smpl import N_NUMBERS, NAMES, RATE, joints_of
from skpose.io._source import ARRAY, Archive, Readable, Source, open_source
from skpose.io._tables import is_csv, read_csv, read_motive, read_mvnx, read_qualisys
from skpose.keypoints import Keypoints
from skpose.keypoints._checks import REMEDY, complaints_of, refuse_pictures, settle_up, turn_up
from skpose.keypoints._layouts import check_layout

POSITIONS, CONFIDENCES, RATES = ("positions", "keypoints"), ("confidences", "scores"), ("frame_rate", "fps")
SHAPES = (None, None, 3), (None, None, 4), (None, None, 2), (None, N_NUMBERS)
EXPECTED = "keypoints as JSON, CSV with a header, MVNX, Qualisys TSV, .npz or .npy"
# Formats of text: names, suffixes, functions that recognise and read them. The first that does is the format.
TEXTS = (
    ("MVNX", (".mvnx",), lambda source: "<mvnx" in source.head[:2000].lower(), read_mvnx),
    ("Motive CSV", (".csv",), lambda source: source.head.startswith("Format Version,"), read_motive),
    ("Qualisys TSV", (".tsv",), lambda source: source.first_word == "no_of_frames", read_qualisys),
    ("CSV", (".csv", ".tsv"), is_csv, read_csv),
)


def load_keypoints(
    path: Readable,
    layout: Any = None,
    *,
    names: Iterable[str] | None = None,
    frame_rate: float | None = None,
    scale: float | None = None,
    up: Up | None = None,
    zeros: Zeros | None = None,
) -> Keypoints:
    """Read keypoints in three dimensions from a file of JSON, CSV or numpy, or from a folder of JSON files.

    The format is recognised by the content of the file, not by its name.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one, compressed by gzip or not; or a folder with a JSON file for each frame, as OpenPose
        writes it.
    layout : Layout or str, default=None
        The layout of the keypoints, or the name of one of `skpose.keypoints.layouts`: the names of the points, the
        axis that points up unless the file states it, and points that are means of others. If the file names its
        points, they are found by their names, in any order and spelling, and others are left out.
    names : iterable of str, default=None
        Name of each point in the file. By default the file's own, or the layout's.
    frame_rate : float, default=None
        Frames per second, Hz. By default the file's own, `frame_rate` or `fps`.
    scale : float, default=None
        Metres per unit of length. By default the unit in the header of a CSV file, as of ``hip_x (mm)``, or 1.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The axis that points up. By default the file's own `up`, as `save_npz` and `save_csv` write it, or that of the
        layout, or y, with a warning if people stand along another axis; or the axis of the floor, with a warning, as
        in `load_c3d`. If an axis points down, the world is turned by half a turn: about x for y and z, about y for x.
    zeros : {"seen", "missing"}, default=None
        Whether a position of exactly (0, 0, 0) is a position or a lost point. By default a position, with a warning. A
        point that is at zero in every frame is the origin of the others, and seen.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a point is not seen: its numbers are NaN or missing, or its confidence is 0.

    Raises
    ------
    MocapFormatError
        If the file is damaged, or in two dimensions; with its name, and the line or the key.
    OSError
        If it cannot be read.
    ValueError
        If names or the frame rate are neither given nor in the file.

    Warns
    -----
    UserWarning
        If the points are not of the size of a person, may be in units of a picture, or are (0, 0, 0); if people stand
        along another axis, times have gaps or contradict the frame rate, or points are left out as rotations,
        velocities or forces, by their names or units.

    See Also
    --------
    load_trc, load_c3d : Read files of markers.
    save_npz, save_csv : Write keypoints.
    skpose.keypoints.Keypoints : Keypoints from an array in memory.

    Notes
    -----
    An .npy file is one array of shape (n_frames, n_points, 3), or (n_frames, n_points, 4), whose fourth number is the
    confidence, from 0 to 1; or the vectors of HumanML3D, (n_frames, 263), not standardised, at 20 Hz. An .npz file has
    these keys:

    ============================ =============================================================
    ``positions``, ``keypoints`` the array, as above
    ``confidences``, ``scores``  (n_frames, n_points), from 0 to 1
    ``frame_rate``, ``fps``      one number, Hz
    ``names``                    (n_points,) texts
    ``up``                       a text, x, y or z
    ============================ =============================================================

    Nothing is unpickled.

    A CSV file has a header and a row for each frame, with columns such as ``nose_x``, ``nose_y``, ``nose_z`` and, for
    all points or none, ``nose_visibility``, ``_confidence``, ``_score`` or ``_likelihood``. A column ``frame`` has the
    number of the frame.

    A JSON file has the form of OpenPose with ``--3d``, MediaPipe (``pose_world_landmarks``), COCO or MMPose, or is a
    list of frames, an object of frames by their numbers, or an object with ``frames`` and ``fps``. One person is read.
    Frames that are left out by their numbers are not seen.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import numpy as np
    >>> from skpose.io import load_keypoints
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "arm.npz")
    ...     np.savez(path, keypoints=np.random.default_rng(0).random((50, 3, 3)), fps=25)
    ...     load_keypoints(path, names=["shoulder", "elbow", "wrist"])
    Keypoints(50 frames at 25 Hz, 2.0 s, 3 points)
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "hand.csv")
    ...     _ = path.write_text("frame,wrist_x,wrist_y,wrist_z\\n0,0.1,1.2,0.4\\n1,0.1,1.3,0.4\\n")
    ...     load_keypoints(path, frame_rate=30)
    Keypoints(2 frames at 30 Hz, 0.1 s, 1 points)
    """
    check_options(scale=scale, frame_rate=frame_rate, up=up, zeros=zeros)
    layout = None if layout is None else check_layout(layout)
    of_layout = None if layout is None else list(layout.names)
    given = None if names is None else list(names)
    source = open_source(path, EXPECTED, binary=True)
    stored = _read(source, len(given or of_layout or ()) or None)
    if scale is not None and stored.scale is not None:
        choose_scale(source, scale, stored.scale, "the header")
    scale = scale or stored.scale or 1.0
    rate = stored.frame_rate if frame_rate is None else frame_rate
    if stored.frame_rate is not None and stored.times is None:  # times are compared with the rate later
        rate = choose_rate(source, frame_rate, stored.frame_rate, "the file")
    if rate is None:
        by_times = stored.times.rate() if stored.times else np.nan
        hint = f"; by {stored.times.key!r} it is {by_times:.4g} Hz" if stored.times and by_times > 0.0 else ""
        raise ValueError(f"{source.name} does not state its frame rate: pass frame_rate=, in Hz{hint}")
    found_names = given or stored.names or of_layout
    with source.format_errors():
        refuse_infinite(stored.positions, "positions")
        refuse_pictures(stored.positions, found_names or (), "positions")
    if found_names is None:
        raise ValueError(f"{source.name} does not name its points: pass layout= or names=")
    usual: Any = up or stored.up or ("y" if layout is None else layout.up)
    why = "as is usual" if layout is None else f"as the layout {layout.name!r} says"
    why = "" if up else stored.why if stored.up else why
    with source.format_errors():
        check_options(up=usual)
        found = Keypoints(stored.positions * scale, found_names, rate, stored.confidences)
        for complaint in complaints_of(found.positions, found.names, usual, "", "", zeros):
            source.warn(complaint)
        if why:
            usual, complaint = settle_up(found.positions, found.names, usual, why)
            source.warn(complaint)
        if stored.times is not None:
            source.warn(stored.times.complaint(found.frame_rate))
        positions, axis = turn_up(found.positions, usual)
        found = replace(found, positions=positions, up=axis)
        if layout is not None:
            found = layout.keypoints(found)
    if layout is None or layout.pairs:
        source.warn(complaint_of_extent(found.positions, scale, found.up))
    return found


def is_array(source: Source) -> bool:
    """Whether a file is an array of numpy, or an archive with one of positions."""
    is_positions = source.kind == "zip" and bool(Archive(source).keys & {*POSITIONS})
    return is_positions or (source.kind == "npy" and not is_smpl(source))


def _read(source: Source, n_points: int | None) -> Stored:
    """What a file holds, whose content says which of the formats it is."""
    if source.kind != "zip" and is_smpl(source):
        raise source.error("expected positions, found parameters of SMPL: load_motion reads them")
    if source.kind == "npy":
        return _from_array(source, Archive(source).numbers(ARRAY, *SHAPES, finite=False))
    if source.kind == "zip":
        return _from_archive(source)
    if is_json(source):
        return read_json(source, n_points)
    for _, _, recognizes, read in TEXTS:
        if source.kind == "text" and recognizes(source):
            return read(source)
    raise source.error(f"expected {EXPECTED}, found {source.describe()}")


def _from_array(source: Source, array: np.ndarray) -> Stored:
    """Positions of three coordinates, and the fourth as confidences; or the vectors of HumanML3D."""
    if array.ndim == 2:
        if np.abs(array[:, -4:] - 0.5).max(initial=0.0) > 1.0:
            source.warn("contacts of feet are far from 0 and 1: are the vectors standardised, less a mean?")
        return Stored(joints_of(array), None, list(NAMES), RATE)
    if array.shape[2] == 2:
        raise source.error(f"these are keypoints in two dimensions. {REMEDY}")
    confidences = as_confidences(source, array[:, :, 3]) if array.shape[2] == 4 else None
    return Stored(array[:, :, :3], confidences, None)


def _from_archive(source: Source) -> Stored:
    file = Archive(source)
    if (key := _one_of(file, POSITIONS)) is None:
        raise source.error(
            f"expected the key {' or '.join(POSITIONS)}, found {file.list_keys()}: load_motion reads rotations"
        )
    stored = _from_array(source, file.numbers(key, *SHAPES, finite=False))
    if found := _one_of(file, CONFIDENCES):
        if stored.confidences is not None:
            raise source.error(f"expected confidences once, found {found} and a fourth number of each point")
        scores = file.numbers(found, stored.positions.shape[:2], finite=False)
        stored = stored._replace(confidences=as_confidences(source, scores))
    rate = _one_of(file, RATES)
    return stored._replace(
        frame_rate=float(file.numbers(rate, (), (1,)).item()) if rate else stored.frame_rate,
        names=file.texts("names", (None,)) if "names" in file.keys else stored.names,
        up=file.texts("up", ())[0] if "up" in file.keys else None,
    )


def _one_of(file: Archive, keys: tuple[str, str]) -> str | None:
    found = [key for key in keys if key in file.keys]
    if len(found) > 1:
        raise file.source.error(f"expected one of the keys {found[0]} and {found[1]}, found both")
    return found[0] if found else None
