"""Acclaim motion files (AMC): the angles of an ASF skeleton, frame by frame and bone by bone."""

from collections.abc import Iterator

import numpy as np

from skpose.io._asf import Asf, read_asf
from skpose.io._text import MocapFormatError, PathLike, finite_numbers, read_lines
from skpose.motion import Motion


def load_amc(path: PathLike, asf: PathLike, *, frame_rate: float = 120.0, scale: float | None = None) -> Motion:
    """Read a motion from an Acclaim AMC file and the ASF file of its skeleton.

    Parameters
    ----------
    path : str or path-like
        The AMC file.
    asf : str or path-like
        The ASF file that it belongs to; it says which angles the numbers are.
    frame_rate : float, default=120.0
        Frames per second; the format does not store it. 120 Hz is CMU's usual rate.
    scale : float, default=None
        Metres per unit of length, as in `load_asf`.

    Returns
    -------
    Motion
        Angles placed by name, in rad.

    Raises
    ------
    MocapFormatError
        If a file is not what it should be, is cut short, or the two do not belong together; with its name and the
        line.
    OSError
        If one cannot be read.

    Examples
    --------
    >>> from skpose.io import load_amc
    >>> load_amc("02_01.amc", "02.asf")  # doctest: +SKIP
    Motion(343 frames at 120 Hz, 2.9 s, Skeleton(n_joints=30, n_dofs=56))
    """
    return read_amc(path, read_asf(asf, scale), frame_rate)


def _statements(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    for line, text in enumerate(lines, start=1):
        tokens = text.split("#")[0].split()
        if tokens:
            yield line, tokens


def read_amc(path: PathLike, asf: Asf, frame_rate: float) -> Motion:
    """`load_amc` with the ASF file read already."""
    lines = read_lines(path, "an AMC file")
    channels = {"root": asf.root_channels} | asf.dofs
    first = dict(zip(channels, np.cumsum([0] + [len(names) for names in channels.values()]), strict=False))
    width = sum(map(len, channels.values()))
    radians = asf.radians
    frame: str | None = None  # its number, as the file has it
    row: list[str] = []
    row_lines: list[int] = []
    missing: set[str] = set()
    rows = []

    def finish(line: int) -> None:
        """Keep the frame before this line, if there is one."""
        if frame is None:
            return
        if missing:
            names = ", ".join(name for name in channels if name in missing)
            raise MocapFormatError(path, line, f"frame {frame} ends without {names}; is the file cut short?")
        rows.append(finite_numbers(row, row_lines, path, f"frame {frame}"))

    for line, (name, *values) in _statements(lines):
        if name.startswith(":"):
            keyword = name[1:].lower()
            if keyword in ("degrees", "radians"):
                radians = keyword == "radians"
                if radians != asf.radians:
                    raise MocapFormatError(path, line, f"angles in {keyword}, but {asf.path.name} has the other unit")
        elif not values and name.isdecimal():
            finish(line)
            if frame is not None and int(name) != int(frame) + 1:
                raise MocapFormatError(path, line, f"expected frame {int(frame) + 1}, found frame {name}")
            frame, missing = name, set(channels)
            row, row_lines = [""] * width, [0] * width
        elif frame is None:
            raise MocapFormatError(path, line, f"expected a frame number, found {name!r}; not an AMC file?")
        else:
            if name not in missing:
                problem = (
                    f"{name!r} stands twice in frame {frame}"
                    if name in channels
                    else f"{asf.path.name} has no bone {name!r} with degrees of freedom; is it the right skeleton?"
                )
                raise MocapFormatError(path, line, problem)
            if len(values) != len(channels[name]):
                raise MocapFormatError(
                    path,
                    line,
                    f"{name!r} has {len(values)} numbers, but {asf.path.name} gives it {len(channels[name])} "
                    f"({' '.join(channels[name])}); is the line cut short, or the skeleton another?",
                )
            start = first[name]
            row[start : start + len(values)] = values
            row_lines[start : start + len(values)] = [line] * len(values)
            missing.discard(name)
    finish(len(lines))
    if not rows:
        raise MocapFormatError(path, len(lines), "the file ends without a frame; not AMC, or cut short")
    return _motion(np.array(rows), channels, asf, frame_rate)


def _motion(numbers: np.ndarray, channels: dict[str, list[str]], asf: Asf, frame_rate: float) -> Motion:
    """Every column of the file put where its name says, in rad and m."""
    names = [f"{bone}_{channel}" for bone, its in channels.items() for channel in its]
    column = {name: i for i, name in enumerate(names)}
    angles = numbers[:, [column[name] for name in asf.skeleton.dof_names]]
    root_angles = numbers[:, [column[f"root_r{axis}"] for axis in asf.root_axes]]
    if not asf.radians:
        angles, root_angles = np.radians(angles), np.radians(root_angles)
    positions = np.zeros((len(numbers), 3))
    for i, axis in enumerate("xyz"):
        if f"root_t{axis}" in column:
            positions[:, i] = numbers[:, column[f"root_t{axis}"]] * asf.scale
    return Motion(asf.skeleton, angles, frame_rate, positions, root_angles, asf.root_axes)
