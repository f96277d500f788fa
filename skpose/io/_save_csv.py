"""Motions and keypoints as tables in CSV files."""

import csv
from collections.abc import Iterable

import numpy as np

from skpose._utils.files import check_new, new_file
from skpose.io._keypoints_csv import ANGLES_HEAD, FORMULA, POINTS_HEAD, find_points
from skpose.io._source import PathLike
from skpose.keypoints import Keypoints
from skpose.skeleton import Motion

SURE = "confidence"


def save_csv(path: PathLike, content: Motion | Keypoints) -> None:
    """Write the angles of a motion, or the positions of keypoints, as a table in a CSV file.

    Parameters
    ----------
    path : str or path-like
        The file, which must not exist yet. It is written whole or not at all.
    content : Motion or Keypoints
        What to write.

    Raises
    ------
    TypeError
        If it is neither a motion nor keypoints.
    ValueError
        For names of points that would be others where the file is read; for keypoints without frames.
    OSError
        If the file exists, or cannot be written.

    See Also
    --------
    load_keypoints : Read the table of keypoints again.
    save_npz : Write a motion with its skeleton, which `load_motion` reads.

    Notes
    -----
    A row is a frame, commas separate cells, and numbers have as many digits as they need to be read as they are. The
    first columns are

    ================================== ===================================================================
    ``frame``, ``time``                number of the frame; its time, s
    ``frame_rate``, ``up``             Hz; the axis of the world that points up. The same in all rows
    ``root_axes``                      of a motion: the axes of the root's angles, see `Motion`; likewise
    ================================== ===================================================================

    Of a motion then follow ``root_x``, ``root_y``, ``root_z``, the positions of the root, m, its angles, rad, such as
    ``root_rz``, and the angles of the joints, rad, by ``skeleton.dof_names``. The "root" of these columns is
    ``"root_"``, or has more underscores, where columns of the joints have these names. The skeleton is not in the
    table: the last example puts the angles onto it again.

    Names that a spreadsheet would take for formulas, which begin with ``=``, ``+``, ``-`` or ``@``, follow a single
    quote; `load_keypoints` removes it.

    Of keypoints follow ``hip_x``, ``hip_y``, ``hip_z`` of each point, m, without a number where it is not seen, and
    ``hip_confidence`` where any confidence is between 0 and 1.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> import pandas
    >>> from skpose import Motion
    >>> from skpose.datasets import make_gait
    >>> from skpose.io import save_csv
    >>> walk = make_gait(1, 1, random_state=0)[0]
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "walk.csv")
    ...     save_csv(path, walk)
    ...     table = pandas.read_csv(path)
    >>> list(table.columns[:9])
    ['frame', 'time', 'frame_rate', 'up', 'root_axes', 'root_x', 'root_y', 'root_z', 'root_rx']
    >>> angles = table[list(walk.skeleton.dof_names)]
    >>> Motion(walk.skeleton, angles, table["frame_rate"][0], table[["root_x", "root_y", "root_z"]], up=table["up"][0])
    Motion(180 frames at 60 Hz, 3.0 s, y up, Skeleton(n_joints=22, n_dofs=48))
    """
    if isinstance(content, Motion):
        header, same, numbers, columns = _of_motion(content)
    elif isinstance(content, Keypoints):
        header, same, numbers, columns = _of_keypoints(content)
    else:
        raise TypeError(f"content must be a skpose.Motion or skpose.Keypoints, got {type(content).__name__}")
    check_new(path)
    with new_file(path) as new, new.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(f"'{cell}" if FORMULA.match(cell) else cell for cell in header)
        for number, time, row in zip(numbers.tolist(), (numbers / content.frame_rate).tolist(), columns, strict=True):
            writer.writerow([number, time, *same, *("" if x != x else x for x in row)])


Table = tuple[list[str], list, np.ndarray, Iterable[list[float]]]


def _of_motion(motion: Motion) -> Table:
    """The header, the cells that are the same in all rows, the numbers of the frames, and the other cells."""
    names, root = motion.skeleton.dof_names, "root"

    def root_columns() -> list[str]:
        return [f"{root}_{axis}" for axis in "xyz"] + [f"{root}_r{axis}" for axis in motion.root_axes.lower()]

    while set(root_columns()) & set(names):
        root += "_"
    header = [*ANGLES_HEAD, *root_columns(), *names]
    same = [float(motion.frame_rate), motion.up, motion.root_axes]
    array = np.concatenate([motion.root_positions, motion.root_angles, motion.angles], axis=1)
    return header, same, motion.frame_numbers, (row.tolist() for row in array)


def _of_keypoints(points: Keypoints) -> Table:
    """The same of keypoints."""
    axes: tuple[str, ...] = ("x", "y", "z")
    array = points.positions
    if not len(array):
        raise ValueError("a CSV file needs at least one frame, got none: write an .npz file")
    if not np.isin(points.confidences, [0.0, 1.0]).all():
        axes += (SURE,)
        array = np.concatenate([array, points.confidences[:, :, None]], axis=2)
    header = [*POINTS_HEAD, *(f"{name}_{axis}" for name in points.names for axis in axes)]
    found = list(find_points([cell.strip() for cell in header]))
    if found != list(points.names):
        name = next((name for name in points.names if name not in found), points.names[0])
        raise ValueError(
            f"point {name[:100]!r} would have another name in a CSV file: rename it, or write an .npz file"
        )
    same = [float(points.frame_rate), points.up]
    return header, same, np.arange(len(points)), (row.ravel().tolist() for row in array)
