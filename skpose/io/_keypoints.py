"""Reader of keypoints that a program has stored as arrays of numpy, as JSON or as CSV."""

import os
import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from skpose._validation.motions import check_frame_rate
from skpose._validation.options import check_positive
from skpose._validation.positions import refuse_infinite
from skpose.io._arguments import Readable
from skpose.io._error import MocapFormatError
from skpose.io._frame_times import complaint_of_times
from skpose.io._keypoints_csv import is_table, read_csv
from skpose.io._keypoints_json import json_files, read_folder, read_json
from skpose.io._npz import Archive, read_array
from skpose.io._other import NUMBERS, is_numbers
from skpose.io._points import Zeros, check_options, turn_up, watch_points
from skpose.io._save_npz import VERSION
from skpose.io._source import Source
from skpose.io._stored import Stored, as_confidences
from skpose.io._up import Up
from skpose.keypoints import Keypoints, Layout, layouts
from skpose.keypoints._shared import (
    REMEDY,
    find_names,
    name_points,
    refuse_pictures,
    remedy_without,
)

POSITIONS = "positions", "keypoints"
CONFIDENCES = "confidences", "scores"
RATES = "frame_rate", "fps"
NAMES = "names"
UP = "up"
SHAPES = (None, None, 3), (None, None, 4)
KIND = "keypoints as JSON, CSV with a header, .npz or .npy"


def load_keypoints(
    path: Readable,
    layout: Any = None,
    *,
    names: Iterable[str] | None = None,
    frame_rate: float | None = None,
    scale: float = 1.0,
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
        axis that points up unless the file states it, and points that are means of others. Where the file names its
        points they are found by their names, in any order and spelling, and others are left out.
    names : iterable of str, default=None
        Name of each point in the file. None is the file's own, or those of the layout.
    frame_rate : float, default=None
        Frames per second. None is the file's own, `frame_rate` or `fps`, which CSV files state where `save_csv` wrote
        them.
    scale : float, default=1.0
        Metres per unit of length.
    up : {"x", "y", "z", "-x", "-y", "-z"}, default=None
        The direction that points up. None is the file's own `up`, as `save_npz` and `save_csv` write it, else that of
        the layout, and "y" without one, with a warning where heads and feet speak against it. Where an axis points down
        the world is turned by half a turn: about x if y or z points down, about y if x does.
    zeros : {"seen", "missing"}, default=None
        What a position of exactly (0, 0, 0) is: a position, or a lost point, as some programs write it. None is
        "seen", with a warning where there are any. A point that is there in every frame is the origin of the others,
        and seen.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a point is not seen: where a number is NaN or not there, or the confidence is 0.

    Raises
    ------
    MocapFormatError
        If the file is not what it should be, such as cut short, or in two dimensions; with its name, and the line or
        the key.
    OSError
        If it cannot be read.
    ValueError
        If names or the frame rate are neither given nor in the file.

    Warns
    -----
    UserWarning
        If the points are less than 0.3 or more than 5 m apart: they may be in another unit than metres. Not for a
        layout without left and right, such as that of a hand.
    UserWarning
        If x and y of nearly all points are from 0 to 1, or no number is negative and all third numbers are up to 100:
        they may be those of a picture, the third ones scores.
    UserWarning
        If positions are (0, 0, 0). If people stand along another axis than the one that is taken as up. If times next
        to the points contradict the frame rate, or leave out frames. If points are left out, as they are rotations or
        velocities by their names.

    See Also
    --------
    load_trc, load_c3d : Read files of markers.
    save_npz, save_csv : Write keypoints.
    skpose.keypoints.Keypoints : Keypoints from an array in memory.

    Notes
    -----
    An .npy file is one array of shape (n_frames, n_points, 3), or (n_frames, n_points, 4), whose fourth number is the
    confidence, from 0 to 1. An .npz file has these keys; others are not opened:

    ============================ =============================================================
    ``positions``, ``keypoints`` the array, as above
    ``confidences``, ``scores``  (n_frames, n_points), from 0 to 1, not with a fourth number
    ``frame_rate``, ``fps``      one number, Hz
    ``names``                    (n_points,) texts
    ``up``                       a text, x, y or z
    ============================ =============================================================

    Nothing is unpickled: arrays of objects are refused.

    Confidences that are COCO's 0, 1 or 2 become 0 and 1, and scores that overshoot 1 become 1; others above 1, such as
    percent, are refused.

    A CSV file has a header and a row for each frame, with columns such as ``nose_x``, ``nose_y``, ``nose_z`` and, for
    all points or none, ``nose_visibility``, ``_confidence``, ``_score`` or ``_likelihood``. A column ``frame`` says
    which frame a row is; columns ``frame_rate`` and ``up`` that are the same in all rows say what they say.
    Quaternions, with ``nose_w``, are refused.

    A JSON file is a frame, a list of frames, an object of frames by their numbers, or an object with a list of them as
    ``frames``, and ``fps``. A frame has
    one person's points as ``pose_world_landmarks`` (MediaPipe, also ``worldLandmarks``), ``pose_keypoints_3d`` of its
    ``people`` (OpenPose), ``keypoints_3d``, or ``keypoints`` (COCO, MMPose): lists of x, y, z and how sure, or objects
    with these, by name or in the order of a layout; with a layout, a list of numbers may be a frame. ``frame``,
    ``frame_id`` or ``image_id`` says which frame it is, as a number or a name with one such as 000012.jpg; COCO's
    images are in the order of these, of the numbers in their names, or of their ids. Frames that are left out between
    others are not seen. Landmarks and keypoints of pictures are refused.

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
    check_positive("scale", scale)
    if frame_rate is not None:
        check_frame_rate(frame_rate)
    check_options(up, zeros)
    layout = None if layout is None else _layout(layout)
    names = None if names is None else list(names)
    folder = path if isinstance(path, str | os.PathLike) and Path(path).is_dir() else None
    files = json_files(folder) if folder is not None else []
    if folder is not None and not files:
        raise MocapFormatError(folder, None, "expected a JSON file for each frame in the folder, found none")
    with Source(files[0] if files else path, KIND, binary=True) as source:
        n_points = len(names) if names is not None else len(layout.names) if layout is not None else None
        if folder is not None:
            source.name = os.fspath(folder)
            stored = read_folder(source, files, n_points)
        else:
            stored = _read(source, n_points)
        frame_rate = _rate(source, stored, frame_rate)
        up = stored.up if up is None else up
        names = stored.names if names is None else names
        if layout is None and names is None:
            raise ValueError(f"{source.name} does not name its points: pass layout=, or names=, one for each point")
        with source.format_errors():
            refuse_infinite(stored.positions, "positions")
            refuse_pictures(stored.positions, names or (), "positions")
            positions, confidences = stored.positions * scale, stored.confidences
            if layout is not None and names is not None:
                order = _order(source, names, positions.shape[1], layout)
                positions = positions[:, order]
                confidences = None if confidences is None else confidences[:, order]
            if layout is None:
                positions = watch_points(source, positions, confidences, names or (), zeros, up, ("y", "as is usual"))
                positions, axis = turn_up(positions, up or "y")
                found = Keypoints(positions, names or (), frame_rate, confidences, axis)
            else:
                usual = layout.up, f"as the layout {layout.name!r} says"
                positions = watch_points(source, positions, confidences, layout.names, zeros, up, usual)
                stated = layout if up is None else replace(layout, up=up)
                found = name_points(stated, positions, frame_rate, confidences)
        if layout is None or layout.pairs:
            source.warn_of_extent(found.positions, scale)
        return found


def read_stored(path: Readable) -> Stored:
    """Return what a file of keypoints states, whether or not it names its points and has a frame rate.

    Keypoints of pictures are refused.
    """
    with Source(path, KIND, binary=True) as source:
        stored = _read(source, None)
        with source.format_errors():
            refuse_infinite(stored.positions, "positions")
            refuse_pictures(stored.positions, stored.names or (), "positions")
        return stored


def _rate(source: Source, stored: Stored, frame_rate: float | None) -> float:
    """Return the frame rate that is given, or else that of the file; warn if the times of frames contradict it."""
    rate = stored.frame_rate if frame_rate is None else frame_rate
    if rate is None:
        of_times = "" if stored.times is None else stored.times.rate()
        likely = "" if stored.times is None or np.isnan(of_times) else f"; {stored.times.key!r} has {of_times:.4g} Hz"
        raise ValueError(f"{source.name} does not state its frame rate: pass frame_rate=, in Hz{likely}")
    if stored.times is not None and (complaint := complaint_of_times(stored.times, rate)):
        source.warn(complaint)
    return rate


def _read(source: Source, n_points: int | None) -> Stored:
    """Return what an open file holds, whose content says which of the formats it is."""
    if source.binary == "npy":
        return _with_fourth(source, Stored(_read_or_explain(source, lambda: read_array(source, *SHAPES)), None, None))
    if source.binary == "zip":
        return _with_fourth(source, _from_archive(source))
    start = source.head.lstrip()[:1]
    if start and start in "[{":
        return read_json(source, n_points)
    if source.binary is None and is_table(source.head):
        return read_csv(source)
    raise source.error(_not_keypoints(source))


def _not_keypoints(source: Source) -> str:
    """Return the message on a file that holds no keypoints, with the function that reads it."""
    expected = f"expected {KIND}"
    if source.binary == "C3D":
        return f"{expected}, found C3D: load_c3d reads it"
    if is_numbers(source.head):
        return f"{expected}, found {NUMBERS}"
    lines = (line.split() for line in source.head.splitlines())
    word = next((words[0] for words in lines if words and not words[0].startswith("#")), "")
    for beginning, reader in (("pathfiletype", "load_trc"), ("hierarchy", "load_bvh"), (":", "load_motion")):
        if word.lower().startswith(beginning):
            return f"{expected}, found {word[:40]!r}: {reader} reads it"
    return f"{expected}, found {word[:40]!r}, which begins none of them"


def _with_fourth(source: Source, stored: Stored) -> Stored:
    """Return positions of three coordinates, the fourth as confidences."""
    if stored.positions.shape[2] == 3:
        return stored
    if stored.confidences is not None:
        raise source.error("confidences are given twice: as a key, and as the fourth number of each position")
    confidences = as_confidences(source, np.nan_to_num(stored.positions[:, :, 3], posinf=np.inf))
    return stored._replace(positions=stored.positions[:, :, :3], confidences=confidences)


def _from_archive(source: Source) -> Stored:
    """Return what an .npz file holds."""
    file = Archive(source)
    key = _one_of(file, POSITIONS)
    if key is None and VERSION in file.keys:
        raise source.error("this is a motion that save_npz wrote: load_motion reads it")
    if key is None:
        raise source.error(f"it has no {' or '.join(POSITIONS)}; its keys are {', '.join(sorted(file.keys)) or 'none'}")
    array = _read_or_explain(source, lambda: file.numbers(key, *SHAPES, finite=False))
    confidences = rate = names = None
    if found := _one_of(file, CONFIDENCES):
        scores = file.numbers(found, array.shape[:2], finite=False)
        confidences = as_confidences(source, np.nan_to_num(scores, posinf=np.inf))
    if found := _one_of(file, RATES):
        rate = float(file.numbers(found, (), (1,)).item())
        if not (rate > 0 and np.isfinite(1.0 / rate)):
            raise source.error(f"{found}: expected a positive number, found {rate:g}")
    if NAMES in file.keys:
        names = file.texts(NAMES, (None,))
    up = file.texts(UP, ())[0] if UP in file.keys else None
    if up is not None and up not in ("x", "y", "z"):
        raise source.error(f"{UP}: expected x, y or z, found {up[:40]!r}")
    return Stored(array, confidences, names, rate, up)


def _order(source: Source, names: list[str], n_points: int, layout: Layout) -> list[int]:
    """Return the columns of the points of a layout, by the names of the file's points."""
    if len(names) != n_points:
        raise source.error(f"there are {len(names)} names, and {n_points} points")
    found = find_names(layout.names, names)
    missing = [name for name in layout.names if name not in found]
    if missing:
        raise source.error(
            f"it has no point {missing[0]!r}, as the layout {layout.name!r} has; its points are "
            f"{', '.join(names[:50])}. Pass the layout that they are of, none, or {remedy_without(layout, missing)}"
        )
    return [names.index(found[name]) for name in layout.names]


def _one_of(file: Archive, keys: tuple[str, str]) -> str | None:
    found = [key for key in keys if key in file.keys]
    if len(found) > 1:
        raise file.source.error(f"it has both {found[0]} and {found[1]}: keep one of them")
    return found[0] if found else None


def _read_or_explain(source: Source, read: Callable[[], np.ndarray]) -> np.ndarray:
    """Return what `read` does; its error on an array of two coordinates says why three are needed."""
    try:
        return read()
    except MocapFormatError as error:
        if re.search(r"found \(\d+, \d+, 2\)$", error.message):
            raise source.error(f"{error.message}: these are keypoints in two dimensions. {REMEDY}") from None
        raise


def _layout(layout: Any) -> Layout:
    """Return a layout, which may be named."""
    if not isinstance(layout, str):
        if not isinstance(layout, Layout):
            raise TypeError(f"layout must be a Layout or the name of one, got {type(layout).__name__}")
        return layout
    if layout not in layouts:
        raise ValueError(f"layout must be one of {', '.join(sorted(layouts))}, got {layout!r}")
    return layouts[layout]
