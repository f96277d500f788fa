"""Reader of keypoints that a program has stored as arrays of numpy, in .npz or .npy files."""

import re
from collections.abc import Callable, Iterable
from typing import Any, Literal

import numpy as np

from skpose._validation.motions import check_frame_rate, check_up
from skpose._validation.options import check_positive
from skpose.io._arguments import Readable
from skpose.io._error import MocapFormatError
from skpose.io._npz import Archive, read_array
from skpose.io._source import Source
from skpose.keypoints import Keypoints, Layout, layouts

POSITIONS = "positions", "keypoints"
CONFIDENCES = "confidences", "scores"
RATES = "frame_rate", "fps"
NAMES = "names"
SHAPES = (None, None, 3), (None, None, 4)


def load_keypoints(
    path: Readable,
    layout: Any = None,
    *,
    names: Iterable[str] | None = None,
    frame_rate: float | None = None,
    scale: float = 1.0,
    up: Literal["x", "y", "z"] | None = None,
) -> Keypoints:
    """Read keypoints in three dimensions from an .npz or .npy file of numpy.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one.
    layout : Layout or str, default=None
        The layout of the keypoints, or the name of one of `skpose.keypoints.layouts`: the names of the columns, the
        axis that points up, and points that are midpoints of others.
    names : iterable of str, default=None
        Name of each point, without a layout. None is the file's own, `names` of an .npz file.
    frame_rate : float, default=None
        Frames per second. None is the file's own, `frame_rate` or `fps` of an .npz file.
    scale : float, default=1.0
        Metres per unit of length.
    up : {"x", "y", "z"}, default=None
        The axis that points up, without a layout, which states its own. None is "y".

    Returns
    -------
    Keypoints
        Positions in m, NaN where a point is not seen: where a number is NaN, or the confidence is 0.

    Raises
    ------
    MocapFormatError
        If the file is not what it should be, such as cut short, or in two dimensions; with its name and the key.
    OSError
        If it cannot be read.
    ValueError
        If names or the frame rate are neither given nor in the file, or a layout and `names` or `up` are both given.

    Warns
    -----
    UserWarning
        If the points are less than 0.3 or more than 5 m apart: they may be in another unit than metres.

    See Also
    --------
    load_trc, load_c3d : Read files of markers.
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
    ============================ =============================================================

    Nothing is unpickled: arrays of objects are refused.

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
    """
    check_positive("scale", scale)
    if frame_rate is not None:
        check_frame_rate(frame_rate)
    if layout is not None and (names is not None or up is not None):
        raise ValueError(f"a layout states names and up: pass layout= or {'names' if up is None else 'up'}=, not both")
    if up is not None:
        check_up(up)
    layout = None if layout is None else _layout(layout)
    with Source(path, "an .npz or .npy file", binary=True) as source:
        if source.binary == "npy":
            array, confidences = _read_or_explain(source, lambda: read_array(source, *SHAPES)), None
        else:
            array, confidences, stated_rate, stated_names = _from_archive(source)
            frame_rate = stated_rate if frame_rate is None else frame_rate
            names = stated_names if names is None else names
            if layout is not None and stated_names is not None:
                order = _order(source, stated_names, layout)
                array, confidences = array[:, order], None if confidences is None else confidences[:, order]
        if frame_rate is None:
            raise ValueError(f"{source.name} does not state its frame rate: pass frame_rate=, in Hz")
        if layout is None and names is None:
            raise ValueError(f"{source.name} does not name its points: pass layout=, or names=, one for each point")
        if array.shape[2] == 4:
            if confidences is not None:
                raise source.error("confidences are given twice: as a key, and as the fourth number of each position")
            array, confidences = array[:, :, :3], np.nan_to_num(array[:, :, 3])
        with source.format_errors():
            if layout is not None:
                found = layout.keypoints(array * scale, frame_rate, confidences)
            else:
                found = Keypoints(array * scale, names or (), frame_rate, confidences, up or "y")
        source.warn_of_extent(found.positions, scale)
        return found


def _from_archive(source: Source) -> tuple[np.ndarray, np.ndarray | None, float | None, list[str] | None]:
    """Return positions, confidences, frame rate and names of an .npz file; None for what it does not have."""
    file = Archive(source)
    key = _one_of(file, POSITIONS)
    if key is None:
        raise source.error(f"it has no {' or '.join(POSITIONS)}; its keys are {', '.join(sorted(file.keys)) or 'none'}")
    array = _read_or_explain(source, lambda: file.numbers(key, *SHAPES, finite=False))
    confidences = rate = names = None
    if found := _one_of(file, CONFIDENCES):
        confidences = np.nan_to_num(file.numbers(found, array.shape[:2], finite=False))
    if found := _one_of(file, RATES):
        rate = float(file.numbers(found, (), (1,)).item())
        if not (rate > 0 and np.isfinite(1.0 / rate)):
            raise source.error(f"{found}: expected a positive number, found {rate:g}")
    if NAMES in file.keys:
        names = file.texts(NAMES, (None,))
    return array, confidences, rate, names


def _order(source: Source, names: list[str], layout: Layout) -> list[int]:
    """Return the columns of a file in the order of a layout, by the names that the file states."""
    if sorted(names) != sorted(layout.names):
        other = next((name for name in names if name not in layout.names), None)
        found = (
            f"the point {other!r}, which it does not have" if other else f"{len(names)} of {len(layout.names)} points"
        )
        raise source.error(
            f"{NAMES}: expected those of the layout {layout.name!r}, found {found}; pass the layout that the file has, "
            "or none"
        )
    return [names.index(name) for name in layout.names]


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
            raise source.error(
                f"{error.message}: these are keypoints in two dimensions. Lengths of bones are not known from a "
                "picture: lift them to 3-D first, by a pose estimator that gives 3-D keypoints or by several cameras"
            ) from None
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
