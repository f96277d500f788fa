"""Reader of C3D files, positions of markers as most motion-capture systems write them, through ezc3d.

B. Michaud, M. Begon, "ezc3d: an easy C3D file I/O cross-platform solution for C++, Python and MATLAB", Journal of Open
Source Software 6 (2021), 2911, doi:10.21105/joss.02911.
"""

import io
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import numpy as np

from skpose._validation.options import check_choice, check_positive
from skpose.io._arguments import Readable
from skpose.io._c3d_head import BLOCK, Head, read_head
from skpose.io._lengths import complaint_of_unit, metres_of
from skpose.io._source import Source
from skpose.keypoints import Keypoints

UP: dict[str, Literal["x", "y", "z"]] = {"+X": "x", "+Y": "y", "+Z": "z", "X": "x", "Y": "y", "Z": "z"}


def load_c3d(path: Readable, *, up: Literal["x", "y", "z"] | None = None, scale: float | None = None) -> Keypoints:
    """Read positions of markers from a C3D file, through ezc3d: ``pip install 'skpose[c3d]'``.

    Parameters
    ----------
    path : str, path-like or file
        The file, or an open one; compressed by gzip or not.
    up : {"x", "y", "z"}, default=None
        The axis that points up. None is the file's POINT:Y_SCREEN; where it has none, z, with a warning.
    scale : float, default=None
        Metres per unit of length. None is the unit that the file names, POINT:UNITS.

    Returns
    -------
    Keypoints
        Positions in m, NaN where a marker is lost.

    Raises
    ------
    ImportError
        If ezc3d is not installed.
    MocapFormatError
        If the file does not follow its format, is cut short, or holds no points; with its name and the parameter.
    OSError
        If it cannot be read.

    Warns
    -----
    UserWarning
        If the file does not say which axis points up. If it holds points without a label, which are left out. If the
        markers are less than 0.3 or more than 5 m apart: the file may name the wrong unit.

    See Also
    --------
    load_trc : Read a TRC file.
    skpose.inverse_kinematics : The poses of a skeleton at these positions.

    Notes
    -----
    A marker is lost where its residual is negative. Numbers may be floats or scaled integers, of Intel or of DEC.
    Analog channels, events and force plates are left out. Every count that the file states is compared with its length
    before ezc3d reads it, from a temporary copy of the part that it needs. Files of more than 65,535 frames, and files
    of MIPS machines, are refused, as ezc3d does not read them.

    References
    ----------
    .. [1] Motion Lab Systems, "The C3D file format user guide", https://www.c3d.org/HTML/default.htm.
    .. [2] B. Michaud, M. Begon, "ezc3d: an easy C3D file I/O cross-platform solution for C++, Python and MATLAB",
       Journal of Open Source Software 6, 2021, :doi:`10.21105/joss.02911`.

    Examples
    --------
    >>> from skpose.io import load_c3d
    >>> load_c3d("walk.c3d")  # doctest: +SKIP
    Keypoints(580 frames at 100 Hz, 5.8 s, 51 points, 0.8 % not seen)
    """
    if up is not None:
        check_choice("up", up, ("x", "y", "z"))
    if scale is not None:
        check_positive("scale", scale)
    reader = _ezc3d()
    with Source(path, "a C3D file", binary=True) as source:
        if source.binary != "C3D":
            raise source.error("expected a C3D file, whose second byte is 80; this is none, or is damaged")
        data = source.seekable()
        length = data.seek(0, io.SEEK_END)
        data.seek(0)
        start = data.read(BLOCK)
        # Parameters have at most 255 blocks.
        start += data.read(BLOCK * (start[0] + 255))
        if len(start) < BLOCK:
            raise source.error(f"expected a header of {BLOCK} bytes, found {len(start)}; is the file cut short?")
        with source.format_errors():
            head = read_head(source, start, length)
        metres = _scale(source, head, scale)
        up = _up(source, head) if up is None else up
        data.seek(0)
        positions = _points(reader, source, head, data.read(head.n_bytes)) * metres
        named = [i for i, name in enumerate(head.labels) if name]
        _check_names(source, head)
        with source.format_errors():
            found = Keypoints(positions[:, named], [head.labels[i] for i in named], head.frame_rate, up=up)
        source.warn_of_extent(found.positions, metres)
        return found


def _ezc3d() -> Any:
    try:
        import ezc3d
    except ImportError:
        raise ImportError("C3D files are read by ezc3d, which is not installed: pip install 'skpose[c3d]'") from None
    return ezc3d


def _points(ezc3d: Any, source: Source, head: Head, data: bytes) -> np.ndarray:
    """Return the positions of all points, (n_frames, n_points, 3), in the file's unit, NaN for lost markers."""
    with TemporaryDirectory() as folder:  # ezc3d reads paths alone; what has been checked is what it reads
        copy = Path(folder, "points.c3d")
        copy.write_bytes(data)
        try:
            found = ezc3d.c3d(str(copy))["data"]
        except (RuntimeError, ValueError, IndexError, TypeError, OSError) as error:
            raise source.error(f"ezc3d cannot read it: {error}") from None
    points, residuals = found["points"][:3], found["meta_points"]["residuals"][0]
    if points.shape != (3, head.n_points, head.n_frames):
        raise source.error(
            f"it states {head.n_frames} frames of {head.n_points} points, and ezc3d finds {points.shape[2]} of "
            f"{points.shape[1]}"
        )
    positions = np.where(residuals < 0, np.nan, points).transpose(2, 1, 0)
    return np.ascontiguousarray(positions, dtype=np.float64)


def _scale(source: Source, head: Head, scale: float | None) -> float:
    if scale is None and (scale := metres_of(head.unit)) is None:
        raise source.error(complaint_of_unit("POINT:UNITS", head.unit))
    return scale


def _up(source: Source, head: Head) -> Literal["x", "y", "z"]:
    if not head.axis_up:
        source.warn(
            "it does not say which axis points up (POINT:Y_SCREEN): z is taken, as is usual; pass up= otherwise"
        )
        return "z"
    if (up := UP.get(head.axis_up.upper())) is None:
        raise source.error(f"POINT:Y_SCREEN: expected +X, +Y or +Z, found {head.axis_up[:40]!r}; up= chooses the axis")
    return up


def _check_names(source: Source, head: Head) -> None:
    """Refuse names that are given twice; warn of points without one."""
    names = [name for name in head.labels if name]
    if not names:
        raise source.error("none of its points has a name (POINT:LABELS)")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise source.error(
            f"POINT:LABELS: several points are named {', '.join(map(repr, twice[:9]))}: rename them, as points are "
            "matched by name"
        )
    if without := head.n_points - len(names):
        source.warn(f"{without} of {head.n_points} points have no label and are left out")
